//! What a graphics card must have, the WGSL, and what a card makes of it.

use std::collections::HashMap;

use super::pack;
use crate::{
    light::{Depth, Transfer},
    shading::{
        frame::Frame,
        lighting::{Facets, Microfacets, Specular},
        shaders::{Correction, Shade, Shader},
    },
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

/// What to ask of a device on which [`Gpu`](super::Gpu) is to draw: all that `adapter` has. Defaults may leave out
/// storage buffers, as eframe's do on OpenGL.
#[must_use]
pub fn limits(adapter: &wgpu::Adapter) -> wgpu::Limits {
    adapter.limits()
}

/// Whether `device` has what the shaders read.
pub(super) fn check(device: &wgpu::Device) -> Result<(), GpuError> {
    let buffers = device.limits().max_storage_buffers_per_shader_stage;
    if buffers < STORAGE_BUFFERS { Err(GpuError::NoStorage(buffers)) } else { Ok(()) }
}

/// The result of `make`; an error, not a panic, if the device refuses it.
pub(super) fn guarded<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    let filters = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
    let mut scopes = filters.map(|filter| Some(device.push_error_scope(filter)));
    let made = make();
    let mut fault = None;
    for scope in scopes.iter_mut().rev().filter_map(Option::take) {
        fault = pollster::block_on(scope.pop()).or(fault);
    }
    match fault {
        Some(fault) => Err(GpuError::Driver(fault.to_string())),
        None => Ok(made),
    }
}

/// The whole of the WGSL.
pub const WGSL: &str = concat!(
    include_str!("bindings.wgsl"),
    include_str!("../../shaders/strips.wgsl"),
    include_str!("../../shaders/fixed.wgsl"),
    include_str!("../../shaders/gradient.wgsl"),
    include_str!("../../shaders/exact.wgsl"),
    include_str!("../../shaders/cut.wgsl"),
    include_str!("../../shaders/patch.wgsl"),
    include_str!("../../shaders/corrections.wgsl"),
    include_str!("lighting.wgsl"),
    include_str!("main.wgsl"),
);

/// How depth is kept.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The WGSL's overrides: what it is made for.
type Overrides = [(&'static str, u32); 7];

fn overrides(frame: &Frame, shade: &Shade, transfer: &Transfer) -> Overrides {
    let depth = match shade.depth {
        Depth::Finite(n) => u32::from(n.clamp(1, Depth::MAX_FINITE)),
        Depth::Infinite => 0,
    };
    let transfer = match transfer {
        Transfer::Linear => 0,
        Transfer::Srgb => 1,
        Transfer::Gamma(_) => 2,
        // The card has no arithmetic of its own for gain and offset.
        Transfer::Gog(_) | Transfer::Table(_) => 3,
    };
    let specular = match frame.lighting.material.specular_model {
        Specular::Phong => 0,
        Specular::Blinn => 1,
        Specular::CookTorrance(Microfacets { facets: Facets::Gaussian { .. }, .. }) => 2,
        Specular::CookTorrance(Microfacets { facets: Facets::Beckmann, .. }) => 3,
    };
    [
        ("SHADER", position(Shader::ALL, shade.shader)),
        ("DEPTH", depth),
        ("VERTEX", position(Correction::ALL, shade.vertex)),
        ("REWEIGHT", position(Correction::ALL, shade.reweight)),
        ("TRANSFER", transfer),
        ("SPECULAR", specular),
        ("ROWS", pack::rows(shade.shader)),
    ]
}

/// The place of `value` in its enum, as the WGSL numbers them.
fn position<T: PartialEq>(all: &[T], value: T) -> u32 {
    all.iter().position(|other| *other == value).unwrap_or(0) as u32
}

/// Pipelines, made when they are first wanted.
#[derive(Debug)]
pub struct Pipelines {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    /// Of the buffers.
    pub bindings: wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
    made: HashMap<Overrides, wgpu::RenderPipeline>,
}

impl Pipelines {
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Result<Pipelines, GpuError> {
        guarded(device, || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("shading"),
                source: wgpu::ShaderSource::Wgsl(WGSL.into()),
            });
            let bindings = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("shading"),
                entries: &[0, 1, 2, 3, 4].map(entry),
            });
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("shading"),
                bind_group_layouts: &[Some(&bindings)],
                ..Default::default()
            });
            Pipelines { module, layout, bindings, format, made: HashMap::new() }
        })
    }

    /// The pipeline for `shade` and `transfer`.
    pub fn get(
        &mut self,
        device: &wgpu::Device,
        frame: &Frame,
        shade: &Shade,
        transfer: &Transfer,
    ) -> Result<wgpu::RenderPipeline, GpuError> {
        let overrides = overrides(frame, shade, transfer);
        if let Some(made) = self.made.get(&overrides) {
            return Ok(made.clone());
        }
        let made = guarded(device, || self.pipeline(device, &overrides))?;
        self.made.insert(overrides, made.clone());
        Ok(made)
    }

    fn pipeline(&self, device: &wgpu::Device, overrides: &Overrides) -> wgpu::RenderPipeline {
        let constants = overrides.map(|(name, value)| (name, f64::from(value)));
        let options =
            wgpu::PipelineCompilationOptions { constants: &constants, zero_initialize_workgroup_memory: false };
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("shading"),
            layout: Some(&self.layout),
            vertex: wgpu::VertexState {
                module: &self.module,
                entry_point: Some("place_corner"),
                compilation_options: options.clone(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("shade_pixel"),
                compilation_options: options.clone(),
                targets: &[Some(self.format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Binding 0 is the globals, the others are lists.
fn entry(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = match binding {
        0 => wgpu::BufferBindingType::Uniform,
        _ => wgpu::BufferBindingType::Storage { read_only: true },
    };
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}
