//! Pictures drawn by the graphics card, on the window's own device.

use std::{sync::Arc, time::Instant};

use eframe::{
    egui::{TextureId, mutex::RwLock},
    egui_wgpu::{RenderState, Renderer},
    wgpu,
};

use crate::{
    light::{CodeImage, Samples},
    shading::gpu::{Gpu, GpuError},
    stimulus::Shot,
};

/// How pictures are stored: as codes.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The window's graphics card.
pub struct WindowGpu {
    state: RenderState,
    gpu: Gpu,
    info: wgpu::AdapterInfo,
}

/// A picture in the card's memory, registered with egui until it is dropped.
pub struct GpuPicture {
    texture: wgpu::Texture,
    id: TextureId,
    renderer: Arc<RwLock<Renderer>>,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl WindowGpu {
    /// The card that draws the window.
    ///
    /// # Errors
    /// When its device cannot draw the shaders.
    pub fn new(state: &RenderState) -> Result<WindowGpu, GpuError> {
        Ok(WindowGpu { state: state.clone(), gpu: Gpu::new(&state.device, FORMAT)?, info: state.adapter.get_info() })
    }

    /// The card's name and its interface.
    pub fn name(&self) -> String {
        format!("{}, {:?}", self.info.name, self.info.backend)
    }

    /// Whether a program acts as the card: no faster than the rasterizer here.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Draws a shot, and gives the milliseconds until it was done.
    ///
    /// # Errors
    /// When the frame is too large for the card, or the driver fails.
    pub fn draw(&mut self, shot: &Shot<'_>) -> Result<(GpuPicture, f64), GpuError> {
        let begun = Instant::now();
        let frame = &*shot.frame;
        let uploaded = self.gpu.upload(frame, &shot.shade, &shot.transfers.channels()[0])?;
        let RenderState { device, queue, .. } = &self.state;
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shading"),
            size: wgpu::Extent3d { width: frame.width, height: frame.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.gpu.render(&mut encoder, &view, &uploaded);
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|fault| GpuError::Driver(fault.to_string()))?;
        let ms = begun.elapsed().as_secs_f64() * 1e3;
        let renderer = self.state.renderer.clone();
        let id = renderer.write().register_native_texture(device, &view, wgpu::FilterMode::Nearest);
        Ok((GpuPicture { texture, id, renderer, device: device.clone(), queue: queue.clone() }, ms))
    }
}

impl GpuPicture {
    /// The name that egui knows it by.
    pub fn id(&self) -> TextureId {
        self.id
    }

    /// Its codes, read back; `None` where the driver fails.
    pub fn codes(&self) -> Option<CodeImage> {
        let (width, height) = (self.texture.width(), self.texture.height());
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("shading"),
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(self.texture.as_image_copy(), destination, self.texture.size());
        self.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
        self.device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
        let bytes = buffer.slice(..).get_mapped_range().ok()?;
        let codes = bytes
            .chunks_exact(row as usize)
            .flat_map(|row| row[..4 * width as usize].chunks_exact(4).flat_map(|rgba| [rgba[0], rgba[1], rgba[2]]));
        Some(CodeImage { width, height, samples: Samples::Eight(codes.collect()) })
    }
}

impl Drop for GpuPicture {
    fn drop(&mut self) {
        self.renderer.write().free_texture(&self.id);
    }
}
