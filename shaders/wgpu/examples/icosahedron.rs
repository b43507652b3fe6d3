//! Draws an icosahedron with the normals of a sphere with c1_phong into a picture, without a window: `cargo run --example
//! icosahedron [picture.png]`.

use std::error::Error;

use machband_c1::{C1Mesh, Camera, Passes, SHADER};
use wgpu::util::DeviceExt as _;

const SIDE: u32 = 512;

fn main() -> Result<(), Box<dyn Error>> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))?;

    // A mesh: positions, normals, and triangles that share their vertices. The neighbors of a corner lie at an edge's
    // length from it, and those of another triangle farther away.
    let golden = f64::midpoint(1.0, 5_f64.sqrt());
    let signs = [[-1.0, -golden], [-1.0, golden], [1.0, -golden], [1.0, golden]];
    let positions: Vec<_> = signs.iter().flat_map(|[x, y]| [[0.0, *x, *y], [*x, *y, 0.0], [*y, 0.0, *x]]).collect();
    let normals: Vec<_> = positions.iter().map(|p| p.map(|x| x / (golden + 2.0).sqrt())).collect();
    let dot = |i: u32, j: u32| (0..3).map(|k| positions[i as usize][k] * positions[j as usize][k]).sum::<f64>();
    let is_edge = |i: u32, j: u32| (dot(i, j) - golden).abs() < 1e-9;
    let triples = (0..12_u32).flat_map(|i| (i + 1..12).flat_map(move |j| (i + 1..12).map(move |k| [i, j, k])));
    let is_outward = |[a, b, c]: [[f64; 3]; 3]| {
        (0..3).map(|i| a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3])).sum::<f64>() > 0.0
    };
    let triangles: Vec<_> = triples
        .filter(|[i, j, k]| is_edge(*i, *j) && is_edge(*j, *k) && is_edge(*k, *i))
        .filter(|t| is_outward(t.map(|v| positions[v as usize])))
        .collect();
    let passes = Passes::new(&device);
    let mesh = C1Mesh::new(&device, &queue, &positions, &normals, &triangles);

    // A view, with matrices as columns: the mesh lies 6 units in front of the eye, which sees from 3 units on.
    let model_view = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., -6., 1.];
    let projection = [2.6, 0., 0., 0., 0., 2.6, 0., 0., 0., 0., -1., -1., 0., 0., -3., 0.];
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
        // A convex mesh needs no depth.
        depth_stencil: None,
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
    let picture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
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
            view: &picture.create_view(&Default::default()),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
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
    let path = std::env::args().nth(1).unwrap_or_else(|| "icosahedron.png".to_owned());
    let mut writer = png::Encoder::new(std::fs::File::create(&path)?, SIDE, SIDE);
    writer.set_color(png::ColorType::Rgba);
    writer.write_header()?.write_image_data(&buffer.slice(..).get_mapped_range()?)?;
    println!("{}: {} triangles on {}", path, triangles.len(), adapter.get_info().name);
    Ok(())
}
