//! Images from a card without a window.

use super::{
    card::Gpu,
    device::{GpuError, guarded, limits},
};
use crate::{
    light::{CodeImage, Samples, Transfer},
    shading::{Frame, Shade},
};

/// How the image is kept.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A card with nothing but what it needs to make images.
#[derive(Debug)]
pub struct Offscreen {
    info: wgpu::AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    gpu: Gpu,
}

impl Offscreen {
    /// The best card there is, of one of `backends`, or of any.
    ///
    /// # Errors
    /// When there is none, or none that draws.
    pub fn new(backends: Option<wgpu::Backends>) -> Result<Offscreen, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        descriptor.backends = backends.unwrap_or(descriptor.backends);
        let adapter =
            pollster::block_on(wgpu::Instance::new(descriptor).request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..Default::default()
            }))
            .map_err(|fault| GpuError::NoAdapter(fault.to_string()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("offscreen"),
            required_limits: limits(&adapter),
            ..Default::default()
        }))
        .map_err(|fault| GpuError::Driver(fault.to_string()))?;
        let gpu = Gpu::new(&device, FORMAT)?;
        Ok(Offscreen { info: adapter.get_info(), device, queue, gpu })
    }

    /// The card's name and the way to it, for people: "llvmpipe (Vulkan)".
    #[must_use]
    pub fn adapter_name(&self) -> String {
        format!("{} ({:?})", self.info.name, self.info.backend)
    }

    /// Whether a program acts as the card: its frame times say nothing about cards.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// `frame` shaded by `shade` as 8-bit codes for a display of `transfer`.
    ///
    /// # Errors
    /// When frame or mesh are larger than the card takes, or the driver fails.
    pub fn image(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> Result<CodeImage, GpuError> {
        let (width, height) = (frame.width, frame.height);
        if width == 0 || height == 0 {
            return Ok(CodeImage { width, height, samples: Samples::Eight(Vec::new()) });
        }
        let uploaded = self.gpu.upload(frame, shade, transfer)?;
        let (codes, row) = guarded(&self.device.clone(), || {
            let target = self.target(width, height);
            let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
            let codes = self.readable(u64::from(row) * u64::from(height));
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.gpu.render(
                &mut encoder,
                &target.create_view(&wgpu::TextureViewDescriptor::default()),
                &uploaded,
                None,
            );
            let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
            let destination = wgpu::TexelCopyBufferInfo { buffer: &codes, layout };
            encoder.copy_texture_to_buffer(target.as_image_copy(), destination, target.size());
            self.queue.submit([encoder.finish()]);
            (codes, row as usize)
        })?;
        let bytes = self.read(&codes)?;
        let rgb = bytes
            .chunks_exact(row)
            .flat_map(|row| row[..4 * width as usize].chunks_exact(4).flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]))
            .collect();
        Ok(CodeImage { width, height, samples: Samples::Eight(rgb) })
    }

    fn target(&self, width: u32, height: u32) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("offscreen"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    fn readable(&self, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        })
    }

    fn read(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // Nobody waits any more only if waiting failed.
            let _ = sender.send(result);
        });
        self.wait()?;
        receiver.recv().map_err(failed)?.map_err(failed)?;
        Ok(buffer.slice(..).get_mapped_range().map_err(failed)?.to_vec())
    }

    fn wait(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(failed)
    }
}

fn failed(fault: impl std::fmt::Display) -> GpuError {
    GpuError::Driver(fault.to_string())
}
