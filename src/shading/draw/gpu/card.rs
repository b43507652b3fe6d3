//! Draws frames into textures and reads them back.

use std::collections::HashMap;

use wgpu::util::DeviceExt as _;

use super::{
    pack,
    pipeline::{DEPTH_FORMAT, Overrides, layout, overrides, pipeline, wgsl},
};
use crate::{
    light::{CodeImage, Samples, Transfer},
    shading::{Frame, Shade},
};

/// Images are stored as codes.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The number of storage buffers that a stage reads.
const STORAGE_BUFFERS: u32 = 4;

/// Why the graphics device cannot draw.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The device has too few storage buffers for the shaders.
    #[error("the graphics device gives a shader {0} storage buffers; expected at least {STORAGE_BUFFERS}")]
    NoStorage(u32),
    /// Something is larger than the device accepts.
    #[error("{what} of {size} is too large for the graphics device; expected at most {most}")]
    TooLarge {
        /// What is too large: `a side` (in pixels), `a buffer` (in bytes), or `a number of lamps`.
        what: &'static str,
        /// Its size.
        size: u64,
        /// The largest size that the device accepts.
        most: u64,
    },
    /// The driver refused or failed.
    #[error("the graphics driver failed: {0}")]
    Driver(String),
}

/// Draws frames with a device that other code may share.
///
/// Request the device with all [limits](wgpu::Adapter::limits) of its adapter: default limits may leave out storage
/// buffers, as eframe's defaults do on OpenGL.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    /// The pipelines, each made when it is first needed.
    pipelines: HashMap<Overrides, wgpu::RenderPipeline>,
}

impl Gpu {
    /// Prepares drawing with `device`.
    ///
    /// # Errors
    /// Returns an error if the device gives shaders too few storage buffers or the driver rejects the shaders.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Gpu, GpuError> {
        let storage = device.limits().max_storage_buffers_per_shader_stage;
        if storage < STORAGE_BUFFERS {
            return Err(GpuError::NoStorage(storage));
        }
        guarded(device, || {
            let source = wgpu::ShaderSource::Wgsl(wgsl().into());
            let module = wgpu::ShaderModuleDescriptor { label: Some("shading"), source };
            Gpu {
                device: device.clone(),
                queue: queue.clone(),
                module: device.create_shader_module(module),
                layout: layout(device),
                pipelines: HashMap::new(),
            }
        })
    }

    /// Draws `frame`, shaded by `shade` and encoded by `transfer`, into a texture of 8-bit RGBA codes, and waits until
    /// drawing is complete.
    ///
    /// # Errors
    /// Returns an error if the frame, the mesh or the number of lamps is too large for the device, or if the driver
    /// fails.
    pub fn draw(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> Result<wgpu::Texture, GpuError> {
        let limits = self.device.limits();
        let contents = pack::buffers(frame, shade, transfer);
        let longest = contents.iter().map(Vec::len).max().unwrap_or(0) as u64;
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        for (what, size, most) in [
            ("a side", frame.width.max(frame.height).into(), limits.max_texture_dimension_2d.into()),
            ("a number of lamps", frame.lighting.lamps.len() as u64, pack::MAX_LAMPS as u64),
            ("a buffer", longest, most),
        ] {
            if size > most {
                return Err(GpuError::TooLarge { what, size, most });
            }
        }
        let Gpu { device, queue, module, layout, pipelines } = self;
        let overrides = overrides(frame, shade, transfer, pack::rows(shade.shader));
        let pipeline = match pipelines.get(&overrides) {
            Some(made) => made.clone(),
            None => {
                let made = guarded(device, || pipeline(device, module, layout, FORMAT, &overrides))?;
                pipelines.insert(overrides, made.clone());
                made
            }
        };
        let texture = guarded(device, || {
            let target = wgpu::TextureUsages::RENDER_ATTACHMENT;
            let used = target | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
            let [texture, depth] = [(FORMAT, used), (DEPTH_FORMAT, target)].map(|(format, usage)| {
                device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("shading"),
                    size: wgpu::Extent3d { width: frame.width, height: frame.height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage,
                    view_formats: &[],
                })
            });
            let bindings = bindings(device, layout, &contents);
            let [r, g, b] = pack::background(frame, transfer);
            let load = wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 });
            let [view, depth] = [&texture, &depth].map(|texture| texture.create_view(&Default::default()));
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shading"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_bind_group(0, &bindings, &[]);
            if !frame.triangles.is_empty() {
                pass.set_pipeline(&pipeline);
                pass.draw(0..3 * frame.triangles.len() as u32, 0..1);
            }
            drop(pass);
            queue.submit([encoder.finish()]);
            texture
        })?;
        wait(device)?;
        Ok(texture)
    }
}

/// Reads back the codes of a texture that [`Gpu::draw`] made.
///
/// # Errors
/// Returns an error if the driver fails.
pub fn codes(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Result<CodeImage, GpuError> {
    let (width, height) = (texture.width(), texture.height());
    let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("shading"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), destination, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    wait(device)?;
    let bytes = buffer.slice(..).get_mapped_range().map_err(|error| GpuError::Driver(error.to_string()))?;
    let rows = bytes.chunks_exact(row as usize).map(|row| &row[..4 * width as usize]);
    let codes = rows.flat_map(|row| row.as_chunks().0).flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
    Ok(CodeImage { width, height, samples: Samples::Eight(codes) })
}

/// Waits until the device has completed all submitted work.
fn wait(device: &wgpu::Device) -> Result<(), GpuError> {
    let done = device.poll(wgpu::PollType::wait_indefinitely());
    done.map(|_| ()).map_err(|error| GpuError::Driver(error.to_string()))
}

/// Makes the buffers that the WGSL reads, with these contents; the globals come first.
fn bindings(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, contents: &[Vec<u8>]) -> wgpu::BindGroup {
    let usages = [wgpu::BufferUsages::UNIFORM].into_iter().chain(std::iter::repeat(wgpu::BufferUsages::STORAGE));
    let buffers = contents.iter().zip(usages).map(|(contents, usage)| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("shading"), contents, usage })
    });
    let buffers: Vec<wgpu::Buffer> = buffers.collect();
    let entry = |(binding, buffer)| wgpu::BindGroupEntry { binding, resource: wgpu::Buffer::as_entire_binding(buffer) };
    let entries: Vec<_> = (0..).zip(&buffers).map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("shading"), layout, entries: &entries })
}

/// Runs `make`; returns an error instead of panicking if the device rejects something.
fn guarded<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    let filters = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    let made = make();
    let errors = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
    match errors.last() {
        Some(error) => Err(GpuError::Driver(error.to_string())),
        None => Ok(made),
    }
}
