//! Images from a card without a window.

use std::time::{Duration, Instant};

use super::{
    device::{GpuError, guarded, limits},
    twin::{Gpu, GpuFrame},
};
use crate::{
    light::{CodeImage, Samples, Transfer},
    shading::{Frame, Shade},
};

/// How the image is kept.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Most frames that are timed at once.
const MOST_FRAMES: u32 = 2048;

/// A card with nothing but what it needs to make images.
#[derive(Debug)]
pub struct Offscreen {
    info: wgpu::AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    gpu: Gpu,
}

/// How long frames took, each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Timing {
    /// From handing a frame to the driver until it was done, by the computer's clock.
    pub wall: Vec<Duration>,
    /// On the card, by its own clock, if it has one.
    pub card: Option<Vec<Duration>>,
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
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
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

    /// Times `frames` drawings (1…2048) of `frame`, which is on the card already: after one that is not timed.
    ///
    /// # Errors
    /// As [`Offscreen::image`].
    pub fn time(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer, frames: u32) -> Result<Timing, GpuError> {
        let frames = frames.clamp(1, MOST_FRAMES);
        let uploaded = self.gpu.upload(frame, shade, transfer)?;
        let target = guarded(&self.device, || self.target(frame.width.max(1), frame.height.max(1)))?;
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        self.draw_and_wait(&view, &uploaded, None)?;
        let clock = self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            self.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: None,
                ty: wgpu::QueryType::Timestamp,
                count: 2 * frames,
            })
        });
        let mut wall = Vec::with_capacity(frames as usize);
        for i in 0..frames {
            let started = Instant::now();
            self.draw_and_wait(&view, &uploaded, clock.as_ref().map(|clock| (clock, 2 * i)))?;
            wall.push(started.elapsed());
        }
        let card = clock.map(|clock| self.read_clock(&clock, frames)).transpose()?;
        Ok(Timing { wall, card })
    }

    fn draw_and_wait(
        &mut self,
        view: &wgpu::TextureView,
        frame: &GpuFrame,
        clock: Option<(&wgpu::QuerySet, u32)>,
    ) -> Result<(), GpuError> {
        guarded(&self.device.clone(), || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let writes = clock.map(|(query_set, first)| wgpu::RenderPassTimestampWrites {
                query_set,
                beginning_of_pass_write_index: Some(first),
                end_of_pass_write_index: Some(first + 1),
            });
            self.gpu.render_timed(&mut encoder, view, frame, None, writes);
            self.queue.submit([encoder.finish()]);
        })?;
        self.wait()
    }

    fn read_clock(&self, clock: &wgpu::QuerySet, frames: u32) -> Result<Vec<Duration>, GpuError> {
        let size = u64::from(2 * frames) * u64::from(wgpu::QUERY_SIZE);
        let ticks = guarded(&self.device.clone(), || {
            let resolved = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            let ticks = self.readable(size);
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.resolve_query_set(clock, 0..2 * frames, &resolved, 0);
            encoder.copy_buffer_to_buffer(&resolved, 0, &ticks, 0, size);
            self.queue.submit([encoder.finish()]);
            ticks
        })?;
        let nanoseconds = f64::from(self.queue.get_timestamp_period());
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&self.read(&ticks)?);
        let pairs = ticks.chunks_exact(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64 * nanoseconds);
        Ok(pairs.map(|ns| Duration::from_nanos(ns as u64)).collect())
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
