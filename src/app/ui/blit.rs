//! Draws images on the screen pixel for pixel, with a shader that does nothing else.
//!
//! egui's own shader filters, tints and dithers everything that it draws. With software rendering, it takes ten times
//! as long to draw the same codes.

use std::sync::{Arc, OnceLock};

use eframe::{
    CreationContext,
    egui::{self, Id, Rect, Shape, TextureId, mutex::RwLock},
    egui_wgpu::{Callback, CallbackResources, CallbackTrait, RenderState, Renderer, ScreenDescriptor},
    wgpu,
};

/// Each corner consists of its clip coordinates x, y and its texel coordinates u, v.
const SHADER: &str = "
struct Corner { @builtin(position) at: vec4<f32>, @location(0) texel: vec2<f32> };
@group(0) @binding(0) var codes: texture_2d<f32>;
@vertex fn place(@location(0) corner: vec4<f32>) -> Corner {
    return Corner(vec4<f32>(corner.xy, 0.0, 1.0), corner.zw);
}
@fragment fn copy(corner: Corner) -> @location(0) vec4<f32> {
    return textureLoad(codes, vec2<i32>(floor(corner.texel)), 0);
}
";
/// Size of the corners in bytes: four corners of four numbers of four bytes.
const CORNERS: u64 = 4 * 4 * 4;

/// egui's textures and the objects needed to upload one.
#[derive(Clone)]
struct Textures {
    renderer: Arc<RwLock<Renderer>>,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// The pipeline with the shader, stored among egui's resources.
struct Pipeline(wgpu::RenderPipeline);

/// Creates the shader. If there are no graphics, or if the screen's format would change codes, egui draws instead.
pub fn install(cc: &CreationContext<'_>) {
    let Some(state) = cc.wgpu_render_state.as_ref().filter(|state| !state.target_format.is_srgb()) else { return };
    let pipeline = pipeline(state);
    state.renderer.write().callback_resources.insert(Pipeline(pipeline));
    let RenderState { renderer, device, queue, .. } = state.clone();
    cc.egui_ctx.data_mut(|data| data.insert_temp(Id::NULL, Textures { renderer, device, queue }));
}

fn pipeline(state: &RenderState) -> wgpu::RenderPipeline {
    let device = &state.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("blit"),
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let textures = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("blit"),
        entries: &texture_entries(),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("blit"),
        bind_group_layouts: &[Some(&textures)],
        ..Default::default()
    });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("blit"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("place"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: CORNERS / 4,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x4],
            })],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("copy"),
            compilation_options: Default::default(),
            targets: &[Some(state.target_format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Returns the layout of egui's texture bind group: a texture, a sampler and flags.
fn texture_entries() -> [wgpu::BindGroupLayoutEntry; 3] {
    let entry =
        |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::FRAGMENT, ty, count: None };
    let texture = wgpu::BindingType::Texture {
        multisampled: false,
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
    };
    let flags = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: std::num::NonZeroU64::new(16),
    };
    [entry(0, texture), entry(1, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)), entry(2, flags)]
}

/// A part of a picture, in physical pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Upper left corner on the screen.
    pub at: [f32; 2],
    /// Upper left corner in the picture.
    pub from: [f32; 2],
    /// Number of columns and rows.
    pub size: [f32; 2],
}

/// Uploads a new image immediately: egui would upload it only when the frame is drawn, and the first frame that shows
/// an image is the one that counts. Returns `false` if there are no graphics.
pub fn upload(ctx: &egui::Context, texture: TextureId, delta: &egui::epaint::ImageDelta) -> bool {
    let found: Option<Textures> = ctx.data(|data| data.get_temp(Id::NULL));
    let Some(Textures { renderer, device, queue }) = found else { return false };
    renderer.write().update_texture(&device, &queue, texture, delta);
    true
}

/// Draws a part of an image pixel for pixel. Returns `false` if egui must draw it, because the image is not uploaded
/// yet, because there are no graphics, or because the page is dimmed.
pub fn draw(ui: &egui::Ui, texture: TextureId, part: Piece) -> bool {
    if ui.opacity() < 1.0 {
        return false;
    }
    let Some(Textures { renderer, .. }) = ui.ctx().data(|data| data.get_temp(Id::NULL)) else { return false };
    let Some(codes) = renderer.read().texture(&texture).map(|texture| texture.bind_group.clone()) else {
        return false;
    };
    let blit = Blit { codes, part, corners: OnceLock::new() };
    let scale = ui.ctx().pixels_per_point();
    let [left, top] = part.at.map(|pixels| pixels / scale);
    let [width, height] = part.size.map(|pixels| pixels / scale);
    let rect = Rect::from_min_size(egui::pos2(left, top), egui::vec2(width, height));
    ui.painter().add(Shape::Callback(Callback::new_paint_callback(rect, blit)));
    true
}

/// The drawing of one picture in one frame.
struct Blit {
    codes: wgpu::BindGroup,
    part: Piece,
    corners: OnceLock<wgpu::Buffer>,
}

impl CallbackTrait for Blit {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        screen: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        _: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        let buffer = self.corners.get_or_init(|| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("blit"),
                size: CORNERS,
                usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        });
        queue.write_buffer(buffer, 0, bytemuck::cast_slice(&self.part.corners(screen.size_in_pixels)));
        Vec::new()
    }

    fn paint(
        &self,
        info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let (Some(Pipeline(pipeline)), Some(corners)) = (resources.get::<Pipeline>(), self.corners.get()) else {
            return;
        };
        // The viewport is the whole window, so that an image that extends beyond its edge is not squeezed.
        let [width, height] = info.screen_size_px.map(|side| side as f32);
        pass.set_viewport(0.0, 0.0, width, height, 0.0, 1.0);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &self.codes, &[]);
        pass.set_vertex_buffer(0, corners.slice(..));
        pass.draw(0..4, 0..1);
    }
}

impl Piece {
    /// Returns the corners of a triangle strip in a window of this size.
    fn corners(self, window: [u32; 2]) -> [[f32; 4]; 4] {
        let [width, height] = window.map(|side| side as f32);
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(right, down)| {
            let [x, y] = [self.at[0] + right * self.size[0], self.at[1] + down * self.size[1]];
            let [u, v] = [self.from[0] + right * self.size[0], self.from[1] + down * self.size[1]];
            [2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, u, v]
        })
    }
}
