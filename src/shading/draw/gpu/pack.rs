//! Packs a frame into the bytes that the WGSL reads; `gpu/bindings.wgsl` defines the layouts.

use glam::{DVec2, DVec3};

use crate::{
    light::{Bits, Transfer, quantize::reference_code},
    shading::{
        frame::{Across, ControlPoints, Field, Frame, FrameVertex, Patches},
        lighting::{Facets, Lamp, LampPosition, Microfacets, Specular},
        shaders::{Painted, PaintedTriangle, Shade, Shader, flat, quadratic},
    },
};

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Globals {
    size: [f32; 2],
    boundary: f32,
    distance: f32,
    ambient: [f32; 4],
    diffuse: [f32; 4],
    specular: [f32; 4],
    index: [f32; 4],
    lamp_count: u32,
    points: u32,
    exponent: f32,
    pixels_per_unit: f32,
    paint: [u32; 4],
    lamps: [[[f32; 4]; 3]; MAX_LAMPS],
}

/// The maximum number of lamps, which is the size of `lamps` in the WGSL.
pub const MAX_LAMPS: usize = 64;

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Vertex {
    place: [f32; 4],
    light: [f32; 4],
    ambient: [f32; 4],
    normal: [f32; 4],
    eye: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Triangle {
    corners: [u32; 3],
    padding: u32,
    slopes: [f32; 4],
}

/// Packs a vector and a number.
fn four(v: DVec3, w: f64) -> [f32; 4] {
    let [x, y, z] = v.as_vec3().to_array();
    [x, y, z, w as f32]
}

fn globals(frame: &Frame, shade: &Shade, transfer: &Transfer, paint: [u32; 4]) -> Globals {
    let material = &frame.lighting.material;
    let facets = match material.specular_model {
        Specular::CookTorrance(facets) => facets,
        Specular::Phong | Specular::Blinn => Microfacets { facets: Facets::Beckmann, slope: 1.0, index: DVec3::ONE },
    };
    let c1 = if let Facets::Gaussian { c1 } = facets.facets { c1 } else { 0.0 };
    let mut lamps = [[[0.0; 4]; 3]; MAX_LAMPS];
    for (place, lamp) in lamps.iter_mut().zip(&frame.lighting.lamps) {
        *place = pack_lamp(lamp);
    }
    Globals {
        size: [frame.width as f32, frame.height as f32],
        boundary: shade.strip().max(0.0) as f32,
        distance: if frame.view.distance.is_finite() { frame.view.distance as f32 } else { 0.0 },
        ambient: four(frame.lighting.ambient_light(), 0.0),
        diffuse: four(material.diffuse * material.color, material.shininess),
        specular: four(material.specular * material.specular_color, facets.slope),
        index: four(facets.index, c1),
        lamp_count: frame.lighting.lamps.len().min(MAX_LAMPS) as u32,
        points: table(transfer).len() as u32,
        exponent: if let Transfer::Gamma(gamma) = transfer { gamma.recip() as f32 } else { 1.0 },
        pixels_per_unit: frame.view.pixels_per_unit() as f32,
        paint,
        lamps,
    }
}

/// Returns the background, encoded and rounded as in an 8-bit image.
pub fn background(frame: &Frame, transfer: &Transfer) -> [f64; 3] {
    let code = |light: f64| reference_code(transfer, Bits::Eight, light as f32);
    frame.background.to_array().map(|light| f64::from(code(light)) / f64::from(Bits::Eight.max_code()))
}

/// Returns the contents of the buffers, in the order of their bindings.
pub fn buffers(frame: &Frame, shade: &Shade, transfer: &Transfer) -> [Vec<u8>; 5] {
    let vertex = |v: &FrameVertex| Vertex {
        place: four(v.screen.extend(v.depth), 0.0),
        light: four(v.light, 0.0),
        ambient: four(v.ambient, 0.0),
        normal: four(v.normal, 0.0),
        eye: four(v.eye, 0.0),
    };
    let triangle = |t: usize| Triangle {
        corners: frame.triangles[t].vertices,
        padding: 0,
        slopes: slopes(frame.corners(t).map(|v| v.screen)),
    };
    let mut constants = constants(frame, shade);
    let paint = push_paint(frame, shade.shader, &mut constants);
    [
        bytes(&[globals(frame, shade, transfer, paint)]),
        bytes(&frame.vertices.iter().map(vertex).collect::<Vec<_>>()),
        bytes(&frame.each_triangle(triangle)),
        bytes(&constants),
        bytes(&table(transfer)),
    ]
}

/// Returns the items as bytes. If there are none, returns room for one item, because empty bindings are not allowed.
fn bytes<T: bytemuck::Pod>(items: &[T]) -> Vec<u8> {
    if items.is_empty() { vec![0; size_of::<T>()] } else { bytemuck::cast_slice(items).to_vec() }
}

/// Returns the change of the weights of corners B and C per pixel, to the right and down.
fn slopes([a, b, c]: [DVec2; 3]) -> [f32; 4] {
    let area = Frame::area2(a, b, c);
    let (ab, ca) = (b - a, a - c);
    [ca.y / area, -ca.x / area, ab.y / area, -ab.x / area].map(|slope| slope as f32)
}

fn pack_lamp(lamp: &Lamp) -> [[f32; 4]; 3] {
    let intensity = four(lamp.intensity, 0.0);
    match lamp.position {
        LampPosition::Direction(toward) => [four(toward, 0.0), intensity, [0.0; 4]],
        LampPosition::Point { position, attenuation } => {
            [four(position, 1.0), intensity, four(DVec3::from_array(attenuation), 0.0)]
        }
    }
}

/// Returns the points of the transfer table, if the transfer function needs one. The curve of gain, offset and gamma
/// gets enough points that the straight lines between them are off by less than a tenth of a code.
fn table(transfer: &Transfer) -> Vec<[f32; 4]> {
    let points: Vec<[f64; 2]> = match transfer {
        Transfer::Table(table) => table.linear().iter().zip(table.encoded()).map(|(l, e)| [*l, *e]).collect(),
        Transfer::Gog(_) => {
            let mut points: Vec<[f64; 2]> = (0..=GOG_POINTS)
                .map(|i| f64::from(i) / f64::from(GOG_POINTS))
                .map(|encoded| [transfer.linear_from_encoded(encoded), encoded])
                .collect();
            // If several encoded values are dark, the light starts to rise at the last of them.
            points.dedup_by(|next, last| {
                let dark = next[0] <= last[0];
                if dark {
                    last[1] = next[1];
                }
                dark
            });
            points
        }
        Transfer::Linear | Transfer::Gamma(_) | Transfer::Srgb => return Vec::new(),
    };
    (0..points.len())
        .map(|i| {
            let ([linear, encoded], next) = (points[i], points[(i + 1).min(points.len() - 1)]);
            let slope = if next[0] > linear { (next[1] - encoded) / (next[0] - linear) } else { 0.0 };
            [linear as f32, encoded as f32, slope as f32, 0.0]
        })
        .collect()
}

/// The number of line segments that approximate the curve of gain, offset and gamma.
const GOG_POINTS: u32 = 4096;

/// Returns the number of rows of [`constants`] per triangle. A row has three entries: one per corner or per edge
/// opposite it.
pub const fn rows(shader: Shader) -> u32 {
    match shader {
        Shader::Flat | Shader::Quadratic | Shader::Gradient | Shader::GradientRepaired => 1,
        Shader::Patch | Shader::C1Phong => 3,
        _ => 0,
    }
}

/// Returns the data that the shader needs per triangle in addition to its vertices: [`rows`] rows for each triangle.
fn constants(frame: &Frame, shade: &Shade) -> Vec<[f32; 4]> {
    let triangles = 0..frame.triangles.len();
    match shade.shader {
        Shader::Flat => triangles.flat_map(|t| [four(flat::light(frame, t), 0.0); 3]).collect(),
        Shader::Quadratic => {
            triangles.flat_map(|t| quadratic::bulges(frame, t).map(|bulge| four(bulge, 0.0))).collect()
        }
        Shader::Gradient | Shader::GradientRepaired => triangles.flat_map(|t| apexes(frame, t)).collect(),
        Shader::Patch => {
            let patches = Patches::new(frame, Field::Light, shade.gradients);
            triangles.flat_map(|t| ordinates(&patches.control_points[t]).map(|light| four(light, 0.0))).collect()
        }
        Shader::C1Phong => {
            let [normals, positions] =
                [Field::Normal, Field::Position].map(|field| Patches::new(frame, field, shade.gradients));
            let of = |t: usize| [&normals, &positions].map(|patches| ordinates(&patches.control_points[t]));
            let pack = |[normals, positions]: [[DVec3; 9]; 2]| (0..9).map(move |i| four(normals[i], positions[i].z));
            triangles.flat_map(|t| pack(of(t))).collect()
        }
        _ => Vec::new(),
    }
}

/// Adds the paint of the triangles, the coats and the texels; returns where each begins. See `shaders/painted.wgsl`.
fn push_paint(frame: &Frame, shader: Shader, constants: &mut Vec<[f32; 4]>) -> [u32; 4] {
    let Some(painted) = Painted::of(frame, shader) else { return [0; 4] };
    let triangles = constants.len() as u32;
    for PaintedTriangle { corners, nearness, coat } in &painted.triangles {
        for (corner, near) in corners.iter().zip(nearness) {
            let [u, v] = corner.place.as_vec2().to_array();
            constants.push(four(corner.color, *near));
            constants.push(four(corner.tangent.truncate(), corner.tangent.w));
            constants.push([u, v, f32::from_bits(*coat), 0.0]);
        }
    }
    let coats = constants.len() as u32;
    let mut texels: Vec<[f32; 4]> = Vec::new();
    for texture in painted.coats.iter().flat_map(|coat| [&coat.base, &coat.normals]) {
        constants.push(
            texture.as_ref().map_or([0.0; 4], |texture| {
                [texels.len() as u32, texture.width, texture.height, 0].map(f32::from_bits)
            }),
        );
        texels.extend(texture.iter().flat_map(|texture| &texture.texels).map(|[x, y, z]| [*x, *y, *z, 0.0]));
    }
    let first = constants.len() as u32;
    constants.append(&mut texels);
    [triangles, coats, first, 0]
}

/// Returns the ordinates that, together with the corners' light values, determine all others: the ones toward the next
/// corner, the ones toward the corner after that, and the middle ones.
fn ordinates(points: &ControlPoints) -> [DVec3; 9] {
    [3, 5, 7, 4, 6, 8, 12, 13, 14].map(|at| points[at])
}

/// Returns the light of the neighbor's apex across each edge, with 1 in the last place if there is a neighbor.
fn apexes(frame: &Frame, triangle: usize) -> [[f32; 4]; 3] {
    frame.triangles[triangle].across.map(|across| match across {
        Across::Triangle { apex, .. } => four(frame.vertices[apex as usize].light, 1.0),
        Across::Nothing => [0.0; 4],
    })
}
