//! The files in `shaders/` that programmers copy: they are valid, they are up to date, and they give the library's
//! results.

use std::{fs, path::Path};

use bytemuck::cast_slice;
use glam::{DMat3, DVec3};
use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{
        Field, Frame, Mesh, Patches, Shade, Shader, Surface, Vertex, View, coverage,
        cubic::{self, Camera},
        shapes::{self, Shape},
    },
};
use machband_c1::{C1Mesh, COEFFICIENTS, Passes, SHADER as C1};
use naga::{
    ShaderStage,
    back::{glsl, hlsl, msl, spv},
    valid::{Capabilities, ModuleInfo, ValidationFlags, Validator},
};
use wgpu::util::DeviceExt as _;

use crate::{common::skip, standard};

fn parsed(source: &str) -> (naga::Module, ModuleInfo) {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
    let info = validated(&module);
    (module, info)
}

fn validated(module: &naga::Module) -> ModuleInfo {
    Validator::new(ValidationFlags::all(), Capabilities::default()).validate(module).unwrap()
}

/// Names the resources in GLSL as the WGSL does; naga numbers them, and names blocks by stage, so that the stages of a
/// program would not link.
fn named(module: &naga::Module, mut text: String) -> String {
    for (_, global) in module.global_variables.iter() {
        let (Some(binding), Some(name)) = (global.binding, &global.name) else { continue };
        for stage in ["vs", "fs", "cs"] {
            text = text.replace(&format!("_group_{}_binding_{}_{stage}", binding.group, binding.binding), name);
        }
    }
    for stage in ["Vertex", "Fragment", "Compute"] {
        text = text.replace(&format!("_block_0{stage}"), "_block");
    }
    text
}

/// Returns an entry point in GLSL.
fn in_glsl(source: &str, entry: &naga::EntryPoint, version: glsl::Version) -> Result<String, glsl::Error> {
    // In OpenGL, the last corner of a triangle provokes its flat outputs.
    let (mut module, _) = parsed(&source.replace("PROVOKING = 0u", "PROVOKING = 2u"));
    // What other entry points use need not exist in this version.
    module.entry_points.retain(|other| other.name == entry.name);
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    let info = validated(&module);
    let pipeline =
        glsl::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone(), multiview: None };
    let mut options = glsl::Options { version, writer_flags: glsl::WriterFlags::empty(), ..Default::default() };
    if !version.is_es() {
        let bindings = module.global_variables.iter().filter_map(|(_, global)| global.binding);
        options.binding_map = bindings.map(|binding| (binding, binding.binding as u8)).collect();
    }
    let mut text = String::new();
    let policies = naga::proc::BoundsCheckPolicies::default();
    glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, policies)?.write()?;
    Ok(named(&module, text))
}

/// Returns the files that are generated from a file in WGSL, with their paths in `shaders/`.
fn generated(name: &str, source: &str) -> Vec<(String, String)> {
    let (module, info) = parsed(source);
    let first = format!(
        "Generated from wgsl/{name}.wgsl, which has the comments. Do not edit: `UPDATE_SHADERS=1 cargo test --test shading \
         generated` writes it."
    );
    let mut hlsl_text = String::new();
    let options = hlsl::Options { shader_model: hlsl::ShaderModel::V5_0, ..Default::default() };
    hlsl::Writer::new(&mut hlsl_text, &options, &Default::default()).write(&module, &info, None).unwrap();
    let mut files = vec![(format!("hlsl/{name}.hlsl"), format!("// {first}\n{hlsl_text}"))];
    for entry in &module.entry_points {
        let ending = match entry.stage {
            ShaderStage::Vertex => "vert",
            ShaderStage::Fragment => "frag",
            _ => "comp",
        };
        let versions = [("glsl", glsl::Version::Desktop(450)), ("glsl_es", glsl::Version::new_gles(300))];
        // GLSL ES 3.00 has no compute shaders; GLSL 4.5 does not need passes that draw.
        let (from, to) = match &entry.name[..] {
            "everywhere" | "slopes_texel" | "coefficients_texel" => (1, 2),
            _ => (0, if ending == "comp" { 1 } else { 2 }),
        };
        for (folder, version) in versions.into_iter().take(to).skip(from) {
            let text = in_glsl(source, entry, version).unwrap();
            let (version, rest) = text.split_once('\n').unwrap();
            files.push((format!("{folder}/{}.{ending}", entry.name), format!("{version}\n// {first}\n{rest}")));
        }
    }
    files
}

#[test]
fn generated_shaders_are_those_of_the_wgsl() {
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let files: Vec<_> =
        [("c1", C1), ("coefficients", COEFFICIENTS)].iter().flat_map(|(n, s)| generated(n, s)).collect();
    if std::env::var_os("UPDATE_SHADERS").is_some() {
        for (path, text) in &files {
            let path = shaders.join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
    }
    for (path, text) in &files {
        let known = fs::read_to_string(shaders.join(path)).unwrap_or_default();
        assert!(known == *text, "{path} is not what wgsl/ gives; UPDATE_SHADERS=1 writes it");
    }
    for folder in ["glsl", "glsl_es", "hlsl"] {
        for file in fs::read_dir(shaders.join(folder)).unwrap() {
            let path = format!("{folder}/{}", file.unwrap().file_name().to_str().unwrap());
            assert!(files.iter().any(|(known, _)| *known == path), "{path} is not generated");
        }
    }
    for source in [C1, COEFFICIENTS] {
        let (module, info) = parsed(source);
        spv::write_vec(&module, &info, &Default::default(), None).unwrap();
        msl::write_string(&module, &info, &Default::default(), &Default::default()).unwrap();
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

/// A mesh, its frame, and what the kit computes for it.
struct Subject {
    name: String,
    frame: Frame,
    surface: cubic::Surface,
    camera: Camera,
}

impl Subject {
    fn new(name: &str, mesh: &Mesh, distance: f64) -> Subject {
        let view = View { distance, ..View::square(SIDE) }.rotated([25.0, -35.0, 0.0]);
        let frame = Frame::new(&Surface::new(mesh.clone()), &view, &standard(), DVec3::ZERO);
        let of = |vector: fn(&Vertex) -> DVec3| mesh.vertices.iter().map(|v| vector(v).to_array()).collect::<Vec<_>>();
        let surface = cubic::Surface::new(&of(|v| v.position), &of(|v| v.normal), &mesh.triangles);
        let camera = camera(&frame);
        Subject { name: format!("{name} from {distance}"), frame, surface, camera }
    }
}

const SIDE: u32 = 256;

fn subjects() -> Vec<Subject> {
    let meshes: Vec<(String, Mesh)> =
        Shape::ALL.iter().map(|shape| (shape.to_string(), shapes::mesh(*shape, 320).unwrap())).collect();
    let of = |(name, mesh): &(String, Mesh)| [f64::INFINITY, 3.0].map(|distance| Subject::new(name, mesh, distance));
    meshes.iter().flat_map(of).collect()
}

#[test]
fn plain_rust_gives_the_librarys_coefficients() {
    for subject in subjects() {
        let theirs = Patches::new(&subject.frame, Field::Normal).coefficients;
        let own = cubic::coefficients(&subject.surface, &subject.camera);
        assert_eq!(own.iter().filter(|k| k[0] != [0.0; 3]).count(), theirs.len(), "{}", subject.name);
        let mut worst = [0f64; 2];
        for (t, theirs) in theirs.iter().enumerate() {
            // Near a silhouette, slopes are steep, and the library's places on the screen are multiples of 1/256 pixel.
            let vertices = subject.frame.corners(t);
            let is_steep = vertices.iter().any(|v| v.normal.dot(subject.frame.view.to_viewer(v.eye)) < 0.3);
            let own = own[subject.frame.triangles[t].of_mesh as usize].map(|k| k.map(f64::from));
            for w in
                [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.6, 0.3, 0.1], [0.1, 0.3, 0.6], [0.1, 0.6, 0.3], [1.0 / 3.0; 3]]
            {
                let difference = DVec3::from(cubic::value(&own, w)) - DVec3::from(cubic::value(theirs, w));
                let worst = &mut worst[usize::from(is_steep)];
                *worst = worst.max(difference.abs().max_element());
            }
        }
        assert!(worst[0] < 4e-3 && worst[1] < 0.15, "{}: {worst:?}", subject.name);
    }
}

fn floats(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|x| *x as f32).collect()
}

/// The kit's crate includes the same file as the library, as another type.
fn of_kit(&Camera { model_view, projection, size }: &Camera) -> machband_c1::Camera {
    machband_c1::Camera { model_view, projection, size }
}

/// A graphics card.
struct Card {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Card {
    /// Returns a mesh with the coefficients of a view, which the two passes compute.
    fn mesh(&self, surface: &cubic::Surface, camera: &Camera) -> C1Mesh {
        let cubic::Surface { vertices, positions, normals, curvature, triangles, sides } = surface.clone();
        let surface = machband_c1::Surface { vertices, positions, normals, curvature, triangles, sides };
        let mesh = C1Mesh::of(&self.device, &self.queue, &surface);
        let mut encoder = self.device.create_command_encoder(&Default::default());
        mesh.update(&self.device, &self.queue, &mut encoder, &Passes::new(&self.device), &of_kit(camera));
        self.queue.submit([encoder.finish()]);
        mesh
    }

    /// Compiles `c1.wgsl`.
    fn pipeline(&self, format: wgpu::TextureFormat, depth: wgpu::TextureFormat) -> wgpu::RenderPipeline {
        let source = wgpu::ShaderSource::Wgsl(C1.into());
        let module = &self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let attributes = &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
        let buffer = wgpu::VertexBufferLayout { array_stride: 24, step_mode: wgpu::VertexStepMode::Vertex, attributes };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("c1_vertex"),
                compilation_options: Default::default(),
                buffers: &[Some(buffer)],
            },
            primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: depth,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("c1_phong_pixel"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Draws with `c1.wgsl` under the library's standard lighting; returns the linear light of every pixel as codes.
    fn drawn(&self, mesh: &C1Mesh, camera: &Camera) -> Vec<u8> {
        let Camera { model_view, projection, .. } = camera;
        let is_orthographic = u32::from(projection[15] == 1.0);
        let lights = [
            [0.36, 0.48, 0.8, 20.0],
            [0.1, 0.1, 0.1, f32::from_bits(is_orthographic)],
            [0.6, 0.6, 0.6, 0.0],
            [0.3, 0.3, 0.3, 0.0],
        ];
        let scene = [&floats(model_view)[..], &floats(projection), lights.as_flattened()].concat();
        let (contents, usage) = (cast_slice(&scene), wgpu::BufferUsages::UNIFORM);
        let scene = self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage });
        let (format, depth) = (wgpu::TextureFormat::Rgba8Unorm, wgpu::TextureFormat::Depth32Float);
        let pipeline = self.pipeline(format, depth);
        let texture = |format, usage| {
            self.device.create_texture(&wgpu::TextureDescriptor {
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
        let depth = texture(depth, wgpu::TextureUsages::empty()).create_view(&Default::default());
        let coefficients = mesh.coefficients.create_view(&Default::default());
        let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: scene.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&coefficients) },
            ],
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        let view = &codes.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: None,
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_vertex_buffer(0, mesh.vertices.slice(..));
        pass.draw(0..mesh.count, 0..1);
        drop(pass);
        self.read(encoder, &codes)
    }

    /// Returns the bytes of a texture whose rows have multiples of 256 bytes.
    fn read(&self, mut encoder: wgpu::CommandEncoder, texture: &wgpu::Texture) -> Vec<u8> {
        let bytes_per_row = texture.width() * texture.format().block_copy_size(None).unwrap();
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(bytes_per_row * texture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
        self.queue.submit([encoder.finish()]);
        buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.unwrap());
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        buffer.slice(..).get_mapped_range().unwrap().to_vec()
    }
}

/// Returns the best card that Vulkan knows. If there is none, the test is skipped.
fn card() -> Option<Card> {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = wgpu::Backends::VULKAN;
    let options = wgpu::RequestAdapterOptions::default();
    let found = pollster::block_on(wgpu::Instance::new(descriptor).request_adapter(&options));
    let skipped = |error| skip("GPU", &format!("a test of the graphics card: {error}"));
    let adapter = found.map_err(skipped).ok()?;
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some(Card { name: adapter.get_info().name, device, queue })
}

/// The passes that draw are tested in a browser, where `scripts/check_kit.sh` runs the GLSL ES that is generated from them.
#[test]
fn card_gives_plain_rusts_coefficients_and_the_librarys_pixels() {
    let Some(card) = card() else { return };
    for subject in subjects() {
        let theirs = cubic::coefficients(&subject.surface, &subject.camera);
        let mesh = card.mesh(&subject.surface, &subject.camera);
        let bytes = card.read(card.device.create_command_encoder(&Default::default()), &mesh.coefficients);
        let numbers = bytemuck::pod_collect_to_vec::<u8, f32>(&bytes);
        for (t, (own, theirs)) in numbers.as_chunks::<36>().0.iter().zip(&theirs).enumerate() {
            // A triangle seen edge on may count as facing away for one of the two.
            if own[..3] == [0.0; 3] || theirs[0] == [0.0; 3] {
                continue;
            }
            for (own, theirs) in own.iter().zip(theirs.as_flattened()) {
                let apart = (own - theirs).abs() / theirs.abs().max(1.0);
                // Near a silhouette, slopes are steep, and single precision shows. The pixels below have no such room.
                assert!(apart < 2e-2, "{}, {}, {t}: {own} {theirs}", card.name, subject.name);
            }
        }
        let (frame, pixels) = (&subject.frame, card.drawn(&mesh, &subject.camera));
        let image = machband::shading::image(frame, &Shade::new(Shader::C1Phong));
        let codes = Quantizer::new(&Transfer::Linear.into(), Bits::Eight).quantize(&image);
        let (mut differ, mut compared, ours) = (0, 0, codes.bytes().unwrap());
        for (i, counts) in coverage::interior_mask(frame).into_iter().enumerate() {
            if counts {
                compared += 1;
                differ += usize::from(ours[3 * i].abs_diff(pixels[4 * i]) > 1);
            }
        }
        let what = format!("{}, {}: {differ} of {compared} pixels differ by more than 1 code", card.name, subject.name);
        assert!(compared > 5_000 && 5_000 * differ <= compared, "{what}");
    }
}
