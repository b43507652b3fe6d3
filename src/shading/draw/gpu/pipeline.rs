//! The WGSL and its compiled pipelines.

use crate::{
    light::{Depth, Transfer},
    shading::{
        frame::Frame,
        lighting::{Facets, Microfacets, Specular},
        shaders::{Correction, Shade, Shader},
    },
};

/// The WGSL except the shader numbers.
const SOURCE: &str = concat!(
    include_str!("bindings.wgsl"),
    include_str!("../../shaders/strips.wgsl"),
    include_str!("../../shaders/fixed.wgsl"),
    include_str!("../../shaders/gradient.wgsl"),
    include_str!("../../../../shaders/wgsl/patch.wgsl"),
    include_str!("../../shaders/corrections.wgsl"),
    include_str!("../../shaders/painted.wgsl"),
    include_str!("lighting.wgsl"),
    include_str!("main.wgsl"),
);

/// Returns the complete WGSL, with the number of each shader as a constant: `GRADIENT_REPAIRED` for
/// "gradient-repaired".
pub fn wgsl() -> String {
    let constant = |shader: &Shader| {
        let name = shader.name().replace('-', "_").to_uppercase();
        format!("const {name} = {}u;\n", position(Shader::ALL, *shader))
    };
    Shader::ALL.iter().map(constant).collect::<String>() + SOURCE
}

/// The format of the depth buffer.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// The names and values of the WGSL overrides.
pub type Overrides = [(&'static str, u32); 8];

/// Returns the overrides, for `rows` rows of constants per triangle.
pub fn overrides(frame: &Frame, shade: &Shade, transfer: &Transfer, rows: u32) -> Overrides {
    let depth = match shade.depth {
        Depth::Finite(n) => u32::from(n.clamp(1, Depth::MAX_FINITE)),
        Depth::Infinite => 0,
    };
    let transfer = match transfer {
        Transfer::Linear => 0,
        Transfer::Srgb => 1,
        Transfer::Gamma(_) => 2,
        // The WGSL has no separate arithmetic for gain and offset.
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
        ("ROWS", rows),
        ("PAINTED", frame.paint.is_some().into()),
    ]
}

/// Returns the index of `value` in `all`, by which the WGSL identifies it.
fn position<T: PartialEq>(all: &[T], value: T) -> u32 {
    all.iter().position(|other| *other == value).unwrap_or(0) as u32
}

/// Makes the layout of the buffers: binding 0 holds the globals, the others hold lists.
pub fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entries = [0, 1, 2, 3, 4].map(|binding| {
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
    });
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("shading"), entries: &entries })
}

/// Makes the pipeline of `module`, which is compiled from [`wgsl`], for these overrides.
pub fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::BindGroupLayout,
    format: wgpu::TextureFormat,
    overrides: &Overrides,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("shading"),
        bind_group_layouts: &[Some(layout)],
        ..Default::default()
    });
    let constants = overrides.map(|(name, value)| (name, f64::from(value)));
    let options = wgpu::PipelineCompilationOptions { constants: &constants, zero_initialize_workgroup_memory: false };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("shading"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
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
            module,
            entry_point: Some("shade_pixel"),
            compilation_options: options.clone(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
