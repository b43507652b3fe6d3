//! The files in `shaders/` that programmers copy: they are valid, and they give the library's results.

#[path = "../../shaders/ordinates.rs"]
mod ordinates;

use bytemuck::cast_slice;
use glam::{DMat3, DVec3};
use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{
        Field, Frame, Gradients, Lighting, Mesh, Patches, Reference, Shade, Shader, Surface, View, coverage,
        shapes::{self, Shape},
    },
};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use wgpu::util::DeviceExt as _;

use self::ordinates::{Camera, Tensor, V};
use crate::common::skip;

const PATCH: &str = include_str!("../../shaders/wgsl/patch.wgsl");
const C1_PHONG: &str =
    concat!(include_str!("../../shaders/wgsl/patch.wgsl"), "\n", include_str!("../../shaders/wgsl/c1_phong.wgsl"));
const ORDINATES: &str = include_str!("../../shaders/wgsl/ordinates.wgsl");

#[test]
fn naga_converts_every_wgsl_file() {
    for source in [PATCH, C1_PHONG, ORDINATES] {
        let module = naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{error}"));
        let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).unwrap();
        naga::back::spv::write_vec(&module, &info, &Default::default(), None).unwrap();
        naga::back::msl::write_string(&module, &info, &Default::default(), &Default::default()).unwrap();
        let (mut hlsl, options, pipeline) = (String::new(), Default::default(), Default::default());
        let mut writer = naga::back::hlsl::Writer::new(&mut hlsl, &options, &pipeline);
        writer.write(&module, &info, None).unwrap();
        for entry in &module.entry_points {
            let pipeline = naga::back::glsl::PipelineOptions {
                shader_stage: entry.stage,
                entry_point: entry.name.clone(),
                multiview: None,
            };
            let options =
                naga::back::glsl::Options { version: naga::back::glsl::Version::Desktop(450), ..Default::default() };
            let mut glsl = String::new();
            let policies = naga::proc::BoundsCheckPolicies::default();
            naga::back::glsl::Writer::new(&mut glsl, &module, &info, &options, &pipeline, policies)
                .and_then(|mut writer| writer.write().map(drop))
                .unwrap();
            assert!(glsl.contains("void main()"));
        }
    }
}

/// The library's view of a mesh as the kit's camera. With an eye, view space begins at the eye.
fn camera(frame: &Frame) -> Camera {
    let View { rotation, distance, fill, width, height, .. } = frame.view;
    let (center, radius) = frame.sphere;
    let DMat3 { x_axis, y_axis, z_axis } = rotation * (1.0 / radius);
    let back = if distance.is_finite() { DVec3::Z * distance } else { DVec3::ZERO };
    let moved = rotation * (-center / radius) - back;
    let mut model_view = [0.0; 16];
    for (column, values) in [x_axis, y_axis, z_axis, moved].into_iter().enumerate() {
        model_view[4 * column..4 * column + 3].copy_from_slice(&values.to_array());
    }
    model_view[15] = 1.0;
    let mut projection = [0.0; 16];
    if distance.is_finite() {
        let (near, far) = (distance - 1.0, distance + 1.0);
        projection[0] = fill * (distance * distance - 1.0).sqrt();
        (projection[10], projection[14], projection[11]) = (-far / (far - near), -far * near / (far - near), -1.0);
    } else {
        (projection[0], projection[10], projection[14], projection[15]) = (fill, -0.5, 0.5, 1.0);
    }
    projection[5] = projection[0];
    Camera { model_view, projection, size: [f64::from(width), f64::from(height)] }
}

/// A mesh as flat arrays, its frame, and what the kit computes for it.
struct Subject {
    name: String,
    frame: Frame,
    positions: Vec<V>,
    normals: Vec<V>,
    triangles: Vec<[u32; 3]>,
    curvature: Vec<Tensor>,
    camera: Camera,
}

impl Subject {
    fn new(name: &str, mesh: &Mesh, distance: f64) -> Subject {
        let view = View { distance, ..View::square(SIDE) }.rotated([25.0, -35.0, 0.0]);
        let frame = Frame::new(&Surface::new(mesh.clone()), &view, &Lighting::standard(), DVec3::ZERO);
        let positions: Vec<V> = mesh.vertices.iter().map(|v| v.position.to_array()).collect();
        let normals: Vec<V> = mesh.vertices.iter().map(|v| v.normal.to_array()).collect();
        let curvature = ordinates::curvature(&positions, &normals, &mesh.triangles);
        let camera = camera(&frame);
        let name = format!("{name} from {distance}");
        Subject { name, frame, positions, normals, triangles: mesh.triangles.clone(), curvature, camera }
    }

    fn ordinates(&self) -> Vec<[[f32; 4]; 12]> {
        ordinates::ordinates(&self.positions, &self.normals, &self.triangles, &self.curvature, &self.camera)
    }
}

const SIDE: u32 = 256;

fn subjects() -> Vec<Subject> {
    let shapes = [(Shape::Blob, 320), (Shape::Torus, 400), (Shape::UvSphere, 300), (Shape::JitteredTorus, 300)];
    let of = |(shape, vertices): (Shape, usize)| {
        let mesh = shapes::mesh(shape, vertices).unwrap();
        [f64::INFINITY, 3.0].map(|distance| Subject::new(&shape.to_string(), &mesh, distance))
    };
    shapes.into_iter().flat_map(of).collect()
}

#[test]
fn plain_rust_gives_the_librarys_ordinates() {
    for subject in subjects() {
        let of = |field| Patches::new(&subject.frame, field, Gradients::Curvature).control_points;
        let (normals, places) = (of(Field::Normal), of(Field::Position));
        let own = subject.ordinates();
        let drawn: Vec<_> = own.iter().filter(|own| own[0] != [0.0; 4]).collect();
        assert_eq!(drawn.len(), normals.len(), "{}", subject.name);
        let away = if subject.frame.view.distance.is_finite() { subject.frame.view.distance } else { 0.0 };
        let mut worst = [0f64; 2];
        for (t, own) in drawn.iter().enumerate() {
            // Near a silhouette, slopes are steep, and the library's places on the screen are multiples of 1/256 pixel.
            let vertices = subject.frame.corners(t);
            let is_steep = vertices.iter().any(|v| v.normal.dot(subject.frame.view.to_viewer(v.eye)) < 0.3);
            for (at, from) in [0, 1, 2, 3, 5, 7, 4, 6, 8, 12, 13, 14].into_iter().enumerate() {
                let (theirs, z) = (normals[t][from], places[t][from].z - away);
                for (own, theirs) in own[at].iter().zip([theirs.x, theirs.y, theirs.z, z]) {
                    let worst = &mut worst[usize::from(is_steep)];
                    *worst = worst.max((f64::from(*own) - theirs).abs());
                }
            }
        }
        assert!(worst[0] < 4e-3 && worst[1] < 0.05, "{}: {worst:?}", subject.name);
    }
}

fn floats(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| *x as f32).collect()
}

/// Computes the ordinates with the two compute passes, draws with the shaders, and returns both: the ordinates, and the
/// linear light of every pixel as codes.
fn on_card(subject: &Subject, device: &wgpu::Device, queue: &wgpu::Queue) -> (Vec<[[f32; 4]; 12]>, Vec<u8>) {
    let storage = |contents: &[u8]| {
        let usage = wgpu::BufferUsages::STORAGE;
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let uniform = |contents: &[f32]| {
        let (contents, usage) = (cast_slice(contents), wgpu::BufferUsages::UNIFORM);
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let Camera { model_view, projection, size } = &subject.camera;
    let matrices = [floats(model_view), floats(projection)].concat();
    let camera = uniform(&[&matrices[..], &floats(size)[..], &[0.0; 2]].concat());
    let vertices: Vec<f32> = (0..subject.positions.len())
        .flat_map(|v| {
            let rows = [subject.positions[v], subject.normals[v]].into_iter().chain(subject.curvature[v]);
            rows.flat_map(|row| [row[0] as f32, row[1] as f32, row[2] as f32, 0.0])
        })
        .collect();
    let (starts, pairs) = ordinates::rings(subject.positions.len(), &subject.triangles);
    let inputs = [
        camera,
        storage(cast_slice(&vertices)),
        storage(cast_slice(&subject.triangles)),
        storage(cast_slice(&starts)),
        storage(cast_slice(&pairs)),
        storage(&vec![0; subject.positions.len() * 32]),
    ];
    let bytes = subject.triangles.len() as u64 * 192;
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let cubics =
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false });
    let module = |source: &'static str| {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        })
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    let compute = module(ORDINATES);
    let entry =
        |binding: u32, buffer| wgpu::BindGroupEntry { binding, resource: wgpu::Buffer::as_entire_binding(buffer) };
    for (name, count) in [("slopes", subject.positions.len()), ("ordinates", subject.triangles.len())] {
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &compute,
            entry_point: Some(name),
            compilation_options: Default::default(),
            cache: None,
        });
        let used: &[u32] = if name == "slopes" { &[0, 1, 3, 4, 5] } else { &[0, 1, 2, 5, 6] };
        let all = inputs.iter().chain([&cubics]).enumerate().map(|(i, buffer)| entry(i as u32, buffer));
        let entries: Vec<_> = all.filter(|entry| used.contains(&entry.binding)).collect();
        let layout = &pipeline.get_bind_group_layout(0);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((count as u32).div_ceil(64), 1, 1);
    }
    let codes = drawn(subject, device, &mut encoder, &cubics, &matrices);
    let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
    let read =
        |size| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let (numbers, pixels) = (read(bytes), read(u64::from(4 * SIDE * SIDE)));
    encoder.copy_buffer_to_buffer(&cubics, 0, &numbers, 0, bytes);
    encoder.copy_texture_to_buffer(
        codes.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &pixels,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIDE), rows_per_image: None },
        },
        codes.size(),
    );
    queue.submit([encoder.finish()]);
    let bytes_of = |buffer: &wgpu::Buffer| {
        buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        buffer.slice(..).get_mapped_range().unwrap().to_vec()
    };
    let numbers: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes_of(&numbers));
    let rows = numbers.as_chunks::<4>().0.as_chunks::<12>().0.to_vec();
    (rows, bytes_of(&pixels))
}

/// Returns a device for the best card that Vulkan knows, with its name. If there is none, the test is skipped.
fn device() -> Option<(String, wgpu::Device, wgpu::Queue)> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = wgpu::Backends::VULKAN;
    let options = wgpu::RequestAdapterOptions::default();
    let found = pollster::block_on(wgpu::Instance::new(descriptor).request_adapter(&options));
    let skipped = |error| skip("GPU", &format!("a test of the graphics card: {error}"));
    let adapter = found.map_err(skipped).ok()?;
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some((adapter.get_info().name, device, queue))
}

/// Draws with `c1_phong.wgsl` under the library's standard lighting.
fn drawn(
    subject: &Subject,
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    cubics: &wgpu::Buffer,
    matrices: &[f32],
) -> wgpu::Texture {
    let is_orthographic = u32::from(subject.frame.view.distance.is_infinite());
    let scene: Vec<f32> = [
        matrices,
        &[0.36, 0.48, 0.8, 20.0],
        &[0.1, 0.1, 0.1, f32::from_bits(is_orthographic)],
        &[0.6, 0.6, 0.6, 0.0],
        &[0.3, 0.3, 0.3, 0.0],
    ]
    .concat();
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let scene = buffer(cast_slice(&scene), wgpu::BufferUsages::UNIFORM);
    let corners = subject.triangles.iter().flatten().map(|v| *v as usize);
    let vertices: Vec<f32> =
        corners.flat_map(|v| [subject.positions[v], subject.normals[v]].concat()).map(|x| x as f32).collect();
    let vertices = buffer(cast_slice(&vertices), wgpu::BufferUsages::VERTEX);
    let source = wgpu::ShaderSource::Wgsl(C1_PHONG.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("triangle_vertex"),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 24,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: wgpu::TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("c1_phong_pixel"),
            compilation_options: Default::default(),
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let texture = |format, usage| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    };
    let codes = texture(format, wgpu::TextureUsages::COPY_SRC);
    let depth = texture(wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty());
    let (codes_view, depth_view) = (codes.create_view(&Default::default()), depth.create_view(&Default::default()));
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: scene.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: cubics.as_entire_binding() },
        ],
    });
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: None,
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &codes_view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &depth_view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.set_vertex_buffer(0, vertices.slice(..));
    pass.draw(0..3 * subject.triangles.len() as u32, 0..1);
    drop(pass);
    codes
}

#[test]
fn card_gives_plain_rusts_ordinates_and_the_librarys_pixels() {
    let Some((card, device, queue)) = device() else { return };
    for subject in subjects() {
        let (numbers, pixels) = on_card(&subject, &device, &queue);
        let theirs = subject.ordinates();
        assert_eq!(numbers.len(), theirs.len());
        for (t, (own, theirs)) in numbers.iter().zip(&theirs).enumerate() {
            // A triangle seen edge on may count as facing away for one of the two.
            if own[0] == [0.0; 4] || theirs[0] == [0.0; 4] {
                continue;
            }
            for (own, theirs) in own.as_flattened().iter().zip(theirs.as_flattened()) {
                assert!((own - theirs).abs() < 2e-3, "{card}, {}, triangle {t}: {own} {theirs}", subject.name);
            }
        }
        let frame = &subject.frame;
        let image = Reference::new(frame, &Shade::new(Shader::C1Phong)).image();
        let codes = Quantizer::new(&Transfer::Linear, Bits::Eight).quantize(&image);
        let (mut worst, mut compared, ours) = (0, 0, codes.bytes().unwrap());
        for (i, counts) in coverage::interior_mask(frame).into_iter().enumerate() {
            if counts {
                compared += 1;
                worst = worst.max(ours[3 * i].abs_diff(pixels[4 * i]));
            }
        }
        assert!(compared > 10_000 && worst <= 2, "{card}, {}: {worst} codes over {compared} pixels", subject.name);
    }
}
