//! Frames drawn into textures.

use wgpu::util::DeviceExt as _;

use super::{
    pack,
    pipeline::{DEPTH_FORMAT, GpuError, Pipelines, check, guarded},
};
use crate::{
    light::Transfer,
    shading::{Frame, Shade},
};

/// Draws frames with a device that it may share, into textures of one format.
#[derive(Debug)]
pub struct Gpu {
    device: wgpu::Device,
    pipelines: Pipelines,
    depth: Option<wgpu::TextureView>,
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
    /// When the device gives shaders no storage buffers (see [`limits`](super::limits)), or the driver refuses them.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Result<Gpu, GpuError> {
        check(device)?;
        Ok(Gpu { device: device.clone(), pipelines: Pipelines::new(device, format)?, depth: None })
    }

    /// Takes `frame` to the card, to be shaded by `shade` and encoded by `transfer`.
    ///
    /// # Errors
    /// When frame or mesh are larger than the device takes, or the driver refuses.
    pub fn upload(&mut self, frame: &Frame, shade: &Shade, transfer: &Transfer) -> Result<GpuFrame, GpuError> {
        let limits = self.device.limits();
        let (side, most) = (frame.width.max(frame.height), limits.max_texture_dimension_2d);
        if side > most {
            return Err(GpuError::TooLarge { what: "a side", size: side.into(), most: most.into() });
        }
        let lamps = frame.lighting.lamps.len();
        if lamps > pack::MOST_LAMPS {
            return Err(GpuError::TooLarge {
                what: "a number of lamps",
                size: lamps as u64,
                most: pack::MOST_LAMPS as u64,
            });
        }
        let pipeline = self.pipelines.get(&self.device, frame, shade, transfer)?;
        let storage = wgpu::BufferUsages::STORAGE;
        let buffers = [
            self.buffer("globals", &[pack::globals(frame, shade, transfer)], wgpu::BufferUsages::UNIFORM)?,
            self.buffer("vertices", &pack::vertices(frame), storage)?,
            self.buffer("triangles", &pack::triangles(frame), storage)?,
            self.buffer("constants", &pack::constants(frame, shade), storage)?,
            self.buffer("table", &pack::table(transfer), storage)?,
        ];
        let mut binding = 0;
        let entries = buffers.each_ref().map(|buffer| {
            binding += 1;
            wgpu::BindGroupEntry { binding: binding - 1, resource: buffer.as_entire_binding() }
        });
        let bindings = guarded(&self.device, || {
            self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("shading"),
                layout: &self.pipelines.bindings,
                entries: &entries,
            })
        })?;
        let background = pack::background(frame, transfer);
        Ok(GpuFrame {
            pipeline,
            bindings,
            corners: 3 * frame.triangles.len() as u32,
            width: frame.width,
            height: frame.height,
            background: wgpu::Color { r: background.x, g: background.y, b: background.z, a: 1.0 },
        })
    }

    /// Draws `frame` into `view`, its top left at the texture's.
    pub fn render(&mut self, encoder: &mut wgpu::CommandEncoder, view: &wgpu::TextureView, frame: &GpuFrame) {
        let load = wgpu::LoadOp::Clear(frame.background);
        let depth = self.depth_for(view.texture().size());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shading"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
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
        pass.set_bind_group(0, &frame.bindings, &[]);
        if frame.corners > 0 {
            pass.set_viewport(0.0, 0.0, frame.width as f32, frame.height as f32, 0.0, 1.0);
            pass.set_pipeline(&frame.pipeline);
            pass.draw(0..frame.corners, 0..1);
        }
    }

    /// A buffer that holds `items`, and room for one if there is none: a binding of nothing is not allowed.
    fn buffer<T: bytemuck::Pod>(
        &self,
        label: &str,
        items: &[T],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, GpuError> {
        let nothing = [T::zeroed()];
        let contents = bytemuck::cast_slice(if items.is_empty() { &nothing } else { items });
        let limits = self.device.limits();
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if contents.len() as u64 > most {
            return Err(GpuError::TooLarge { what: "a buffer", size: contents.len() as u64, most });
        }
        let descriptor = wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage };
        guarded(&self.device, || self.device.create_buffer_init(&descriptor))
    }

    /// A depth buffer as large as the target.
    fn depth_for(&mut self, size: wgpu::Extent3d) -> wgpu::TextureView {
        match &self.depth {
            Some(depth) if depth.texture().size() == size => depth.clone(),
            _ => {
                let texture = self.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some("depth"),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: DEPTH_FORMAT,
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                    view_formats: &[],
                });
                let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
                self.depth = Some(view.clone());
                view
            }
        }
    }
}
