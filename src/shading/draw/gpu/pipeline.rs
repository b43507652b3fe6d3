//! The WGSL and what a card makes of it.

use std::collections::HashMap;

use super::{
    device::{GpuError, guarded},
    pack,
};
use crate::{
    light::{Depth, Transfer},
    shading::{
        frame::Frame,
        lighting::{Facets, Specular},
        shaders::{Correction, Shade, Shader},
    },
};

/// The whole of the WGSL.
pub const WGSL: &str = concat!(
    include_str!("wgsl/bindings.wgsl"),
    include_str!("../../shaders/curve.wgsl"),
    include_str!("../../shaders/strips.wgsl"),
    include_str!("../../shaders/fixed.wgsl"),
    include_str!("../../shaders/gradient.wgsl"),
    include_str!("../../shaders/exact.wgsl"),
    include_str!("../../shaders/cut.wgsl"),
    include_str!("../../shaders/patch.wgsl"),
    include_str!("../../shaders/vertex.wgsl"),
    include_str!("../../shaders/reweight.wgsl"),
    include_str!("wgsl/lighting.wgsl"),
    include_str!("wgsl/light.wgsl"),
    include_str!("wgsl/transfer.wgsl"),
    include_str!("wgsl/main.wgsl"),
);

/// How depth is kept.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What the WGSL is made for: its overrides.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Variant {
    shader: u32,
    depth: u32,
    vertex: u32,
    reweight: u32,
    transfer: u32,
    specular: u32,
    rows: u32,
}

impl Variant {
    fn new(frame: &Frame, shade: &Shade, transfer: &Transfer) -> Variant {
        let correction = |correction| position(Correction::ALL, correction);
        Variant {
            shader: position(Shader::ALL, shade.shader),
            depth: match shade.depth {
                Depth::Finite(n) => u32::from(n.clamp(1, Depth::MAX_FINITE)),
                Depth::Infinite => 0,
            },
            vertex: correction(shade.vertex),
            reweight: correction(shade.reweight),
            transfer: match transfer {
                Transfer::Linear => 0,
                Transfer::Srgb => 1,
                Transfer::Gamma(_) => 2,
                // The card has no arithmetic of its own for gain and offset.
                Transfer::Gog(_) | Transfer::Table(_) => 3,
            },
            specular: match frame.lighting.material.specular_model {
                Specular::Phong => 0,
                Specular::Blinn => 1,
                Specular::CookTorrance(facets) => match facets.facets {
                    Facets::Gaussian { .. } => 2,
                    Facets::Beckmann => 3,
                },
            },
            rows: pack::rows(shade.shader),
        }
    }

    /// The shader alone, for what does not depend on the rest.
    const fn any() -> Variant {
        Variant { shader: 0, depth: 1, vertex: 0, reweight: 0, transfer: 0, specular: 0, rows: 0 }
    }

    fn constants(self) -> [(&'static str, f64); 7] {
        [
            ("SHADER", self.shader),
            ("DEPTH", self.depth),
            ("VERTEX", self.vertex),
            ("REWEIGHT", self.reweight),
            ("TRANSFER", self.transfer),
            ("SPECULAR", self.specular),
            ("ROWS", self.rows),
        ]
        .map(|(name, value)| (name, f64::from(value)))
    }
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
    /// Fills the window.
    pub background: wgpu::RenderPipeline,
    format: wgpu::TextureFormat,
    made: HashMap<Variant, wgpu::RenderPipeline>,
}

impl std::fmt::Debug for Variant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_map().entries(self.constants()).finish()
    }
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
            let entries = ("place_background", "shade_background");
            let background = pipeline(device, &module, &layout, format, entries, Variant::any());
            Pipelines { module, layout, bindings, background, format, made: HashMap::new() }
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
        let variant = Variant::new(frame, shade, transfer);
        if let Some(made) = self.made.get(&variant) {
            return Ok(made.clone());
        }
        let entries = ("place_corner", "shade_pixel");
        let made = guarded(device, || pipeline(device, &self.module, &self.layout, self.format, entries, variant))?;
        self.made.insert(variant, made.clone());
        Ok(made)
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

/// A pipeline between two entry points. The background's writes no depth.
fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    format: wgpu::TextureFormat,
    (vertex, fragment): (&str, &str),
    variant: Variant,
) -> wgpu::RenderPipeline {
    let constants = variant.constants();
    let compilation_options =
        || wgpu::PipelineCompilationOptions { constants: &constants, zero_initialize_workgroup_memory: false };
    let (write, compare) = match vertex {
        "place_background" => (false, wgpu::CompareFunction::Always),
        _ => (true, wgpu::CompareFunction::Less),
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex),
            compilation_options: compilation_options(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(write),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment),
            compilation_options: compilation_options(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
