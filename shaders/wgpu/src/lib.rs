//! Phong shading with C1 normals for [wgpu](https://docs.rs/wgpu): the passes and buffers around the shaders of this kit.
//!
//! ```toml
//! machband-c1 = { path = "machband/shaders/wgpu" }
//! ```
//!
//! ```ignore
//! let passes = Passes::new(&device);                              // once
//! let mesh = C1Mesh::new(&device, &queue, &positions, &normals, &triangles);
//! mesh.update(&device, &queue, &mut encoder, &passes, &camera);   // whenever the camera or the mesh moves
//! // Then draw with `SHADER`, or with its functions in your own shader:
//! pass.set_vertex_buffer(0, mesh.vertices.slice(..));             // positions and normals, three numbers each
//! pass.draw(0..mesh.count, 0..1);                                 // with `mesh.coefficients` at binding 1
//! ```
//!
//! `cargo run --example icosahedron` in this folder draws a picture without a window.

#[path = "../../ordinates.rs"]
pub mod ordinates;

use wgpu::{
    TextureFormat::{Rgba32Float, Rgba32Uint},
    util::DeviceExt as _,
};

pub use ordinates::{Camera, Surface};

/// The vertex and pixel shaders, `wgsl/c1.wgsl`.
pub const SHADER: &str = include_str!("../../wgsl/c1.wgsl");

/// The passes that compute the coefficients, `wgsl/coefficients.wgsl`.
pub const COEFFICIENTS: &str = include_str!("../../wgsl/coefficients.wgsl");

/// Entries in each row of a texture.
const PER_ROW: usize = 64;

/// The two compute passes.
#[derive(Debug)]
pub struct Passes {
    slopes: wgpu::ComputePipeline,
    coefficients: wgpu::ComputePipeline,
}

impl Passes {
    /// Compiles the passes.
    pub fn new(device: &wgpu::Device) -> Self {
        let source = wgpu::ShaderSource::Wgsl(COEFFICIENTS.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("c1"), source });
        let pass = |name| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(name),
                layout: None,
                module: &module,
                entry_point: Some(name),
                compilation_options: Default::default(),
                cache: None,
            })
        };
        Self { slopes: pass("slopes"), coefficients: pass("coefficients") }
    }
}

/// A mesh on the card. For several views in one frame, make one for each.
#[derive(Debug)]
pub struct C1Mesh {
    /// A position and a normal for each corner of each triangle, three numbers each.
    pub vertices: wgpu::Buffer,
    /// The number of corners.
    pub count: u32,
    /// What [`SHADER`] reads at binding 1: the coefficients of the last [`C1Mesh::update`].
    pub coefficients: wgpu::Texture,
    /// What the passes read at bindings 1 to 3.
    pub inputs: [wgpu::Texture; 3],
    /// The slopes at the points.
    pub slopes: wgpu::Texture,
    points: u32,
    camera: wgpu::Buffer,
}

impl C1Mesh {
    /// Computes the curvature of a mesh and sends it to the card. Vertices with the same position and normal must be one;
    /// triangles go around counterclockwise as seen from outside.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        positions: &[[f64; 3]],
        normals: &[[f64; 3]],
        triangles: &[[u32; 3]],
    ) -> Self {
        Self::of(device, queue, &Surface::new(positions, normals, triangles))
    }

    /// Sends a surface to the card.
    pub fn of(device: &wgpu::Device, queue: &wgpu::Queue, surface: &Surface) -> Self {
        let Surface { positions, normals, curvature, triangles, sides, .. } = surface;
        let (starts, ring) = surface.rings();
        let single = |numbers: &[f64; 3], last: f64| [numbers[0], numbers[1], numbers[2], last].map(|x| x as f32);
        let point = |v: usize| {
            let [a, b, c] = &curvature[v];
            let (start, end) = (f64::from(starts[v]), f64::from(starts[v + 1]));
            let (a, b, c) = (single(a, 0.0), single(b, 0.0), single(c, 0.0));
            [single(&positions[v], start), single(&normals[v], end), a, b, c]
        };
        let points: Vec<[[f32; 4]; 5]> = (0..positions.len()).map(point).collect();
        let corner = |(t, sides): (&[u32; 3], &[[u32; 2]; 3])| [0, 1, 2].map(|k| [t[k], sides[k][0], sides[k][1], 0]);
        let corners: Vec<[[u32; 4]; 3]> = triangles.iter().zip(sides).map(corner).collect();
        let of_corner = |v: &u32| [positions[*v as usize], normals[*v as usize]].map(|x| x.map(|x| x as f32));
        let vertices: Vec<[[f32; 3]; 2]> = triangles.iter().flatten().map(of_corner).collect();
        let filled = |format, texels, entries, data: &[u8]| {
            let descriptor = descriptor(format, texels, entries);
            let wgpu::Extent3d { width, height, .. } = descriptor.size;
            let size = width * height * format.block_copy_size(None).unwrap_or(16);
            let padded = [data, &vec![0; size as usize - data.len()][..]].concat();
            device.create_texture_with_data(queue, &descriptor, Default::default(), &padded)
        };
        let (count, faces) = (positions.len(), triangles.len());
        Self {
            vertices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("c1 vertices"),
                contents: bytemuck::cast_slice(&vertices),
                usage: wgpu::BufferUsages::VERTEX,
            }),
            count: 3 * faces as u32,
            coefficients: device.create_texture(&descriptor(Rgba32Float, 9, faces)),
            inputs: [
                filled(Rgba32Float, 5, count, bytemuck::cast_slice(&points)),
                filled(Rgba32Uint, 1, ring.len(), bytemuck::cast_slice(&ring)),
                filled(Rgba32Uint, 3, faces, bytemuck::cast_slice(&corners)),
            ],
            slopes: device.create_texture(&descriptor(Rgba32Float, 2, count)),
            points: count as u32,
            camera: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("c1 camera"),
                size: 160,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    /// Returns the uniform of the passes for a view; `width` is that of the target, which only passes that draw need.
    pub fn uniform(&self, camera: &Camera, width: u32) -> [u32; 40] {
        let Camera { model_view, projection, size } = camera;
        let mut numbers = [0; 40];
        let floats = model_view.iter().chain(projection).chain(size).map(|x| (*x as f32).to_bits());
        numbers.iter_mut().zip(floats.chain([self.points, self.count / 3, width])).for_each(|(to, from)| *to = from);
        numbers
    }

    /// Records the computation of the coefficients of a view. The queue writes the camera before the commands run, so an
    /// encoder can hold one update of each mesh.
    pub fn update(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        passes: &Passes,
        camera: &Camera,
    ) {
        queue.write_buffer(&self.camera, 0, bytemuck::cast_slice(&self.uniform(camera, 0)));
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let ([points, ring, corners], slopes) = (self.inputs.each_ref().map(view), view(&self.slopes));
        let coefficients = view(&self.coefficients);
        let of_slopes = [(1, &points), (2, &ring), (5, &slopes)];
        let of_coefficients = [(1, &points), (3, &corners), (4, &slopes), (6, &coefficients)];
        for (pipeline, views, count) in
            [(&passes.slopes, &of_slopes[..], self.points), (&passes.coefficients, &of_coefficients, self.count / 3)]
        {
            let camera = (0, self.camera.as_entire_binding());
            let views = views.iter().map(|(binding, view)| (*binding, wgpu::BindingResource::TextureView(view)));
            let entries: Vec<_> = std::iter::once(camera)
                .chain(views)
                .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
                .collect();
            let layout = &pipeline.get_bind_group_layout(0);
            let group = device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries });
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
        }
    }
}

/// A texture of entries of so many texels each, which the passes read and write.
fn descriptor(format: wgpu::TextureFormat, texels: usize, entries: usize) -> wgpu::TextureDescriptor<'static> {
    let (width, height) = ((texels * PER_ROW) as u32, entries.div_ceil(PER_ROW).max(1) as u32);
    let read = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST;
    let written = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT;
    wgpu::TextureDescriptor {
        label: Some("c1"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: if format == Rgba32Float { read | written } else { read },
        view_formats: &[],
    }
}
