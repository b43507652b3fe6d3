//! Code that both shader examples share: draws two triangles off screen, with one byte per pixel.

use std::borrow::Cow;

use glam::{DMat3, DVec2, DVec3};
use machband::shading::{Across, Fan, Frame, FrameTriangle, FrameVertex, Lighting, View};
use wgpu::util::DeviceExt as _;

/// Side of the image, in pixels.
pub const SIZE: u32 = 256;

/// A kite of two triangles, ABC and DCB, that share the edge BC: positions in pixels from the top left and light
/// values.
pub const CORNERS: [([f32; 2], f32); 4] =
    [([40.0, 30.0], 0.35), ([30.0, 170.0], 0.75), ([220.0, 60.0], 0.8), ([200.0, 230.0], 0.3)];
/// The corners of each triangle, counterclockwise as seen by the viewer.
pub const TRIANGLES: [[usize; 3]; 2] = [[0, 1, 2], [3, 2, 1]];

/// The code around a shader: `constants` contains `N` numbers per triangle, and `light_of(weights, base)` computes the
/// light from them.
const AROUND: &str = "
@group(0) @binding(0) var<storage, read> constants: array<f32>;
struct Vertex { @builtin(position) place: vec4f, @location(0) @interpolate(linear) weights: vec3f,
                @location(1) @interpolate(flat) triangle: u32 };
@vertex fn vertex(@location(0) place: vec2f, @builtin(vertex_index) index: u32) -> Vertex {
    var corner = array(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));
    return Vertex(vec4f(place.x / 128.0 - 1.0, 1.0 - place.y / 128.0, 0.0, 1.0), corner[index % 3u], index / 3u);
}
@fragment fn fragment(in: Vertex) -> @location(0) vec4f { return vec4f(light_of(in.weights, in.triangle * N)); }
";

/// The kite as a library mesh.
pub fn frame() -> Frame {
    let vertex = |(place, light): ([f32; 2], f32)| FrameVertex {
        screen: DVec2::from(place.map(f64::from)),
        depth: 0.5,
        eye: DVec3::ZERO,
        normal: DVec3::Z,
        light: DVec3::splat(f64::from(light)),
        ambient: DVec3::ZERO,
    };
    // The two triangles share their first edge.
    let triangle = |t: usize| FrameTriangle {
        vertices: TRIANGLES[t].map(|v| v as u32),
        fans: TRIANGLES[t].map(|v| v as u32),
        of_mesh: t as u32,
        is_back: false,
        normal: DVec3::Z,
        across: [
            Across::Triangle { triangle: 1 - t as u32, apex: TRIANGLES[1 - t][0] as u32 },
            Across::Nothing,
            Across::Nothing,
        ],
    };
    Frame {
        width: SIZE,
        height: SIZE,
        background: DVec3::ZERO,
        vertices: CORNERS.map(vertex).to_vec(),
        triangles: vec![triangle(0), triangle(1)],
        lighting: Lighting::standard(),
        view: View::square(SIZE),
        encoding: None,
        creases: Vec::new(),
        sphere: (DVec3::ZERO, 1.0),
        smooth: None,
        paint: None,
        fans: (0..CORNERS.len() as u32).map(|vertex| Fan { vertex, curvature: DMat3::ZERO }).collect(),
    }
}

/// Draws the kite with `shader`, which uses `count` of the `constants` per triangle. `depth` is the continuity depth n
/// of the strips. Returns one byte per pixel in linear light, row by row from the top, and 0 outside the kite; `None`
/// if there is no graphics adapter.
pub fn draw(shader: &str, depth: u8, constants: &[f32], count: usize) -> Option<Vec<u8>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).ok()?;
    let limits = wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits());
    let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).ok()?;
    let source = format!("const N: u32 = {count}u;\n{shader}\n{AROUND}");
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(Cow::Owned(source)),
    });
    let depths = [("DEPTH", f64::from(depth))];
    let format = wgpu::TextureFormat::R8Unorm;
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 8,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x2],
            })],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: if depth > 0 { &depths } else { &[] },
                ..Default::default()
            },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let places: Vec<[f32; 2]> = TRIANGLES.iter().flatten().map(|corner| CORNERS[*corner].0).collect();
    let places = buffer(bytemuck::cast_slice(&places), wgpu::BufferUsages::VERTEX);
    let storage = buffer(bytemuck::cast_slice(constants), wgpu::BufferUsages::STORAGE);
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: storage.as_entire_binding() }],
    });
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let bytes = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(SIZE * SIZE),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let view = texture.create_view(&Default::default());
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, places.slice(..));
        pass.draw(0..6, 0..1);
    }
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE), rows_per_image: None };
    let size = texture.size();
    encoder.copy_texture_to_buffer(texture.as_image_copy(), wgpu::TexelCopyBufferInfo { buffer: &bytes, layout }, size);
    queue.submit([encoder.finish()]);
    bytes.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
    Some(bytes.slice(..).get_mapped_range().ok()?.to_vec())
}

/// Returns the barycentric weights of the pixel at column `x` and row `y` in triangle `triangle`, if the pixel is
/// inside.
pub fn weights(triangle: usize, x: u32, y: u32) -> Option<[f64; 3]> {
    let p = [f64::from(x) + 0.5, f64::from(y) + 0.5];
    let [a, b, c] = TRIANGLES[triangle].map(|corner| CORNERS[corner].0.map(f64::from));
    let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let whole = area(a, b, c);
    let w = [area(p, b, c) / whole, area(p, c, a) / whole, area(p, a, b) / whole];
    w.iter().all(|w| *w > 1e-3).then_some(w)
}

/// Compares an image with the library's and prints the largest difference.
pub fn compare(name: &str, drawn: Option<Vec<u8>>, light: impl Fn(usize, [f64; 3]) -> f64) {
    let Some(drawn) = drawn else {
        println!("{name}: SKIPPED, because there is no graphics adapter; the shader needs only the constants above");
        return;
    };
    let mut largest = 0.0_f64;
    for (y, x) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (y, x))) {
        for triangle in 0..TRIANGLES.len() {
            if let Some(w) = weights(triangle, x, y) {
                let code = f64::from(drawn[(y * SIZE + x) as usize]);
                largest = largest.max((light(triangle, w) * 255.0 - code).abs());
            }
        }
    }
    println!("{name}: the image is within {largest:.2} codes of the f64 reference");
    assert!(largest < 1.0, "the shader and the reference differ");
}
