//! Images from a graphics card without a window.

use machband::{
    light::{CodeImage, Samples, Transfer},
    shading::{
        Frame, Shade,
        gpu::{Gpu, GpuError},
    },
};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A device of the best card of `backends`, or nothing where there is none and none is required.
pub fn device(
    backends: wgpu::Backends,
    limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits,
) -> Option<(String, wgpu::Device, wgpu::Queue)> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends;
    let options = wgpu::RequestAdapterOptions::default();
    let adapter = match pollster::block_on(wgpu::Instance::new(descriptor).request_adapter(&options)) {
        Ok(adapter) => adapter,
        Err(fault) => {
            assert!(std::env::var_os("MACHBAND_REQUIRE_GPU").is_none(), "{fault}, and one is required");
            println!("SKIPPED: {fault}");
            return None;
        }
    };
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits(&adapter), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some((adapter.get_info().name, device, queue))
}

/// A card with what it needs to make images.
pub struct Offscreen {
    pub name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    gpu: Gpu,
}

impl Offscreen {
    pub fn new(backends: wgpu::Backends, limits: impl FnOnce(&wgpu::Adapter) -> wgpu::Limits) -> Option<Offscreen> {
        let (name, device, queue) = device(backends, limits)?;
        let gpu = Gpu::new(&device, FORMAT).unwrap();
        Some(Offscreen { name, device, queue, gpu })
    }

    /// `frame` shaded by `shade` as 8-bit codes for a display of `transfer`.
    pub fn image(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> Result<CodeImage, GpuError> {
        let (width, height) = (frame.width, frame.height);
        if width == 0 || height == 0 {
            return Ok(CodeImage { width, height, samples: Samples::Eight(Vec::new()) });
        }
        let uploaded = self.gpu.upload(frame, shade, transfer)?;
        let target = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let codes = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.gpu.render(&mut encoder, &view, &uploaded);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let destination = wgpu::TexelCopyBufferInfo { buffer: &codes, layout };
        encoder.copy_texture_to_buffer(target.as_image_copy(), destination, target.size());
        self.queue.submit([encoder.finish()]);
        codes.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let bytes = codes.slice(..).get_mapped_range().unwrap();
        let pixels = bytes.chunks_exact(row as usize).flat_map(|row| row[..4 * width as usize].chunks_exact(4));
        let rgb = pixels.flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]).collect();
        Ok(CodeImage { width, height, samples: Samples::Eight(rgb) })
    }
}
