//! Frames drawn into textures.

use std::collections::HashMap;

use wgpu::util::DeviceExt as _;

use super::{
    pack,
    pipeline::{DEPTH_FORMAT, Overrides, WGSL, layout, overrides, pipeline},
};
use crate::{
    light::Transfer,
    shading::{Frame, Shade},
};

/// Storage buffers that a stage reads.
const STORAGE_BUFFERS: u32 = 4;

/// Why a card does not draw.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The device has too few storage buffers for the shaders.
    #[error("the graphics device gives a shader {0} storage buffers; expected at least {STORAGE_BUFFERS}")]
    NoStorage(u32),
    /// More than the card accepts.
    #[error("{what} of {size} is too large for the graphics device; expected at most {most}")]
    TooLarge {
        /// What is too large: `a side`, in pixels, `a buffer`, in bytes, or `a number of lamps`.
        what: &'static str,
        /// How large it is.
        size: u64,
        /// How large it may be.
        most: u64,
    },
    /// The driver refused or failed.
    #[error("the graphics driver failed: {0}")]
    Driver(String),
}

/// Draws frames with a device that it may share, into textures of one format.
///
/// The device should have all [limits](wgpu::Adapter::limits) of its adapter: defaults may leave out storage buffers, as
/// eframe's do on OpenGL.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    format: wgpu::TextureFormat,
    module: wgpu::ShaderModule,
    layout: wgpu::BindGroupLayout,
    /// Made when they are first needed.
    pipelines: HashMap<Overrides, wgpu::RenderPipeline>,
}

/// A frame on the card, ready to be drawn by the [`Gpu`] that made it.
#[derive(Clone, Debug)]
pub struct GpuFrame {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
    corners: u32,
    width: u32,
    height: u32,
    background: wgpu::Color,
}

impl Gpu {
    /// What draws into textures of `format` with `device`. The colors it writes are encoded: the format must be one
    /// that keeps them as they are, such as Rgba8Unorm, not one ending in Srgb.
    ///
    /// # Errors
    /// When the device gives shaders no storage buffers, or the driver refuses them.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Result<Gpu, GpuError> {
        let storage = device.limits().max_storage_buffers_per_shader_stage;
        if storage < STORAGE_BUFFERS {
            return Err(GpuError::NoStorage(storage));
        }
        guarded(device, || {
            let source = wgpu::ShaderSource::Wgsl(WGSL.into());
            let module = wgpu::ShaderModuleDescriptor { label: Some("shading"), source };
            Gpu {
                device: device.clone(),
                format,
                module: device.create_shader_module(module),
                layout: layout(device),
                pipelines: HashMap::new(),
            }
        })
    }

    /// Takes `frame` to the card, to be shaded by `shade` and encoded by `transfer`.
    ///
    /// # Errors
    /// When frame or mesh are larger than the device takes, or the driver refuses.
    pub fn upload(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> Result<GpuFrame, GpuError> {
        let limits = self.device.limits();
        let contents = pack::buffers(frame, shade, transfer);
        let longest = contents.iter().map(Vec::len).max().unwrap_or(0) as u64;
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        for (what, size, most) in [
            ("a side", frame.width.max(frame.height).into(), limits.max_texture_dimension_2d.into()),
            ("a number of lamps", frame.lighting.lamps.len() as u64, pack::MOST_LAMPS as u64),
            ("a buffer", longest, most),
        ] {
            if size > most {
                return Err(GpuError::TooLarge { what, size, most });
            }
        }
        let Gpu { device, format, module, layout, pipelines } = self;
        let overrides = overrides(frame, shade, transfer, pack::rows(shade.shader));
        let pipeline = match pipelines.get(&overrides) {
            Some(made) => made.clone(),
            None => {
                let made = guarded(device, || pipeline(device, module, layout, *format, &overrides))?;
                pipelines.insert(overrides, made.clone());
                made
            }
        };
        let bindings = guarded(device, || {
            let usages =
                [wgpu::BufferUsages::UNIFORM].into_iter().chain(std::iter::repeat(wgpu::BufferUsages::STORAGE));
            let buffers = contents.iter().zip(usages).map(|(contents, usage)| {
                device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some("shading"), contents, usage })
            });
            let buffers: Vec<wgpu::Buffer> = buffers.collect();
            let entry =
                |(binding, buffer)| wgpu::BindGroupEntry { binding, resource: wgpu::Buffer::as_entire_binding(buffer) };
            let entries: Vec<_> = (0..).zip(&buffers).map(entry).collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("shading"), layout, entries: &entries })
        })?;
        let [r, g, b] = pack::background(frame, transfer);
        Ok(GpuFrame {
            pipeline,
            bindings,
            corners: 3 * frame.triangles.len() as u32,
            width: frame.width,
            height: frame.height,
            background: wgpu::Color { r, g, b, a: 1.0 },
        })
    }

    /// Draws `frame` into `view`, its top left at the texture's.
    pub fn render(&self, encoder: &mut wgpu::CommandEncoder, view: &wgpu::TextureView, frame: &GpuFrame) {
        let load = wgpu::LoadOp::Clear(frame.background);
        let depth = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("depth"),
            size: view.texture().size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH_FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shading"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth.create_view(&wgpu::TextureViewDescriptor::default()),
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &frame.bindings, &[]);
        if frame.corners > 0 {
            pass.set_viewport(0.0, 0.0, frame.width as f32, frame.height as f32, 0.0, 1.0);
            pass.set_pipeline(&frame.pipeline);
            pass.draw(0..frame.corners, 0..1);
        }
    }
}

/// The result of `make`; an error, not a panic, if the device refuses it.
fn guarded<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    let filters = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
    let scopes = filters.map(|filter| device.push_error_scope(filter));
    let made = make();
    let faults = scopes.into_iter().rev().filter_map(|scope| pollster::block_on(scope.pop()));
    match faults.last() {
        Some(fault) => Err(GpuError::Driver(fault.to_string())),
        None => Ok(made),
    }
}
