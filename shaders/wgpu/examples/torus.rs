//! Draws a coarse torus with c1_phong into a picture, without a window: `cargo run --example torus [picture.png]`.

use std::{error::Error, f64::consts::TAU};

use machband_c1::{C1Mesh, Camera, Passes, SHADER};
use wgpu::util::DeviceExt as _;

const SIDE: u32 = 512;

fn main() -> Result<(), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;

    // A mesh: positions, normals, and triangles that share their vertices.
    let (around, along) = (20, 12);
    let (positions, normals): (Vec<_>, Vec<_>) = (0..around * along)
        .map(|i| {
            let [u, v] = [(i / along, around), (i % along, along)].map(|(i, n)| f64::from(i) / f64::from(n) * TAU);
            let normal = [u.cos() * v.cos(), u.sin() * v.cos(), v.sin()];
            let ring = [u.cos(), u.sin(), 0.0];
            (std::array::from_fn(|k| ring[k] + 0.4 * normal[k]), normal)
        })
        .unzip();
    let at = |i: u32, j: u32| i % around * along + j % along;
    let quads = (0..around).flat_map(|i| (0..along).map(move |j| (i, j)));
    let triangles: Vec<_> = quads
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    let passes = Passes::new(&device);
    let mesh = C1Mesh::new(&device, &queue, &positions, &normals, &triangles);

    // A view, with matrices as columns: the torus is tilted by 50° and lies 4 units in front of the eye.
    let (sin, cos) = 50_f64.to_radians().sin_cos();
    let model_view = [1., 0., 0., 0., 0., cos, sin, 0., 0., -sin, cos, 0., 0., 0., -4., 1.];
    let (near, far, zoom) = (2.0, 6.0, 2.4);
    let depth = [-far / (far - near), -far * near / (far - near)];
    let projection = [zoom, 0., 0., 0., 0., zoom, 0., 0., 0., 0., depth[0], -1., 0., 0., depth[1], 0.];
    let camera = Camera { model_view, projection, size: [f64::from(SIDE); 2] };

    let mut encoder = device.create_command_encoder(&Default::default());
    mesh.update(&device, &queue, &mut encoder, &passes, &camera);

    // The uniform `Scene` of c1.wgsl: the matrices, the lamp and the shininess, and the ambient, diffuse and specular light.
    let lights = [[0.36, 0.48, 0.8, 20.0], [0.1, 0.1, 0.1, 0.0], [0.6, 0.6, 0.6, 0.0], [0.3, 0.3, 0.3, 0.0]];
    let scene: Vec<f32> =
        model_view.iter().chain(&projection).chain(lights.as_flattened()).map(|x| *x as f32).collect();
    let scene = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&scene),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let source = wgpu::ShaderSource::Wgsl(SHADER.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
    let attributes = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
    let format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("c1_vertex"),
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
    let picture = texture(format, wgpu::TextureUsages::COPY_SRC);
    let depth = texture(wgpu::TextureFormat::Depth32Float, wgpu::TextureUsages::empty());
    let [color, depth] = [&picture, &depth].map(|texture| texture.create_view(&Default::default()));
    let coefficients = mesh.coefficients.create_view(&Default::default());
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: scene.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&coefficients) },
        ],
    });
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &color,
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

    // Copies the picture to the processor.
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * SIDE * SIDE),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIDE), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(picture.as_image_copy(), to, picture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    let path = std::env::args().nth(1).unwrap_or_else(|| "torus.png".to_owned());
    let mut writer = png::Encoder::new(std::fs::File::create(&path)?, SIDE, SIDE);
    writer.set_color(png::ColorType::Rgba);
    writer.write_header()?.write_image_data(&buffer.slice(..).get_mapped_range()?)?;
    println!("{}: {} triangles on {}", path, triangles.len(), adapter.get_info().name);
    Ok(())
}
