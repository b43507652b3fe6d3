//! Compares drawing in lanes of f32 with the f64 reference: the same pixels and the same light, for any number of
//! threads.

use glam::{DVec2, DVec3};
use machband::light::{Bits, ChannelQuantizer, Depth, LinearImage, Transfer};
use machband::shading::{
    Correction, Encoder, Frame, Lamp, LampPosition, Lighting, Material, Mesh, Prepared, Reference, Shade, Shader,
    Specular, Surface, View, coverage, shapes,
};
use pulp::Arch;

use crate::{covers, random};

/// Makes triangles that pass through each other, some of them thin.
fn ugly(seed: u32) -> Mesh {
    let place = |i: u32| DVec3::from_array([0, 1, 2].map(|c| 2.0 * random(u64::from(seed * 1000 + 3 * i + c)) - 1.0));
    let mut places: Vec<DVec3> = (0..90).map(place).collect();
    // These points lie next to others and make slivers.
    places.extend((0..30).map(|i| place(i) + 0.01 * place(i + 200)));
    let mut triangles: Vec<[u32; 3]> = (0..30).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    triangles.extend((0..20).map(|t| [t, t + 1, t + 30]));
    triangles.extend((0..20).map(|t| [t, t + 90, t + 40]));
    Mesh::new(&places, &triangles, 180.0).unwrap()
}

const SKY: DVec3 = DVec3::new(0.1, 0.2, 0.4);

fn frame(mesh: Mesh, [width, height]: [u32; 2], fill: f64, lighting: &Lighting, background: DVec3) -> Frame {
    let view = View { width, height, fill, ..View::square(1).rotated([25.0, 35.0, 10.0]) };
    Frame::new(&Surface::new(mesh), &view, lighting, background)
}

fn colored(color: DVec3) -> Lighting {
    Lighting { material: Material { color, ..Material::standard() }, ..Lighting::standard() }
}

fn brown() -> Lighting {
    colored(DVec3::new(0.9, 0.6, 0.3))
}

/// Meshes of every kind, fully, partly or barely within windows of awkward sizes, in gray, yellow and other colors.
fn scenes() -> Vec<(&'static str, Frame)> {
    let yellow = colored(DVec3::new(1.0, 1.0, 0.0));
    let mut yellow_dull = yellow.clone();
    yellow_dull.material.specular = 0.0;
    let mut scenes = vec![
        ("cube", frame(shapes::cube(), [131, 97], 0.9, &brown(), DVec3::ZERO)),
        ("cube, gray", frame(shapes::cube(), [97, 131], 0.9, &Lighting::standard(), DVec3::splat(0.5))),
        ("cube, huge", frame(shapes::cube(), [75, 130], 40.0, &brown(), SKY)),
        ("torus, yellow", frame(shapes::torus(20, 12, 0.0), [160, 160], 1.0, &yellow_dull, DVec3::ZERO)),
        ("sphere", frame(shapes::sphere(8), [64, 64], 1.3, &yellow, DVec3::ZERO)),
        ("blob", frame(shapes::blob(313), [200, 180], 0.9, &brown(), SKY)),
        ("blob, one pixel", frame(shapes::blob(20), [1, 1], 0.9, &brown(), SKY)),
        ("blob, tiny", frame(shapes::blob(771), [37, 3], 0.9, &brown(), SKY)),
        ("blob, encoded", frame(shapes::blob(313), [120, 100], 0.9, &brown(), SKY).encoded(&Transfer::Srgb.into())),
    ];
    for seed in 0..4 {
        scenes.push(("ugly", frame(ugly(seed), [150, 101], 1.1, &brown(), SKY)));
        scenes.push(("ugly, huge", frame(ugly(seed + 10), [133, 70], 25.0, &brown(), SKY)));
    }
    scenes
}

/// Every shader, with depths and widths that take different code paths.
fn shades() -> Vec<Shade> {
    let widths = [0.05, 1.0 / 3.0, 1.0];
    let mut strips: Vec<_> = [1, 2, 3, 4, 5, 32].into_iter().flat_map(|n| widths.map(|width| (n, width))).collect();
    strips.extend([(0, 0.2), (3, 0.0), (3, f64::NAN)]);
    let mut shades = crate::shades(&strips);
    shades.push(Shade { vertex: Correction::Repaired, ..Shade::new(Shader::GradientRepaired) });
    shades.push(Shade { vertex: Correction::Printed, reweight: Correction::Printed, ..Shade::new(Shader::Fixed) });
    shades.push(Shade { reweight: Correction::Repaired, ..Shade::new(Shader::Gouraud) });
    shades
}

fn drawn(frame: &Frame, shade: &Shade) -> LinearImage {
    Prepared::new(frame, shade).image()
}

/// Returns the largest difference between the light drawn in lanes and the reference, relative to full light or to the
/// largest light if it is above that.
fn error(frame: &Frame, shade: &Shade) -> f32 {
    let (fast, slow) = (drawn(frame, shade), Reference::new(frame, shade).image());
    assert_eq!((fast.width, fast.height), (slow.width, slow.height));
    let most = slow.data.iter().fold(1.0, |most: f32, light| most.max(light.abs()));
    // NaN counts as a difference unless it is in both images.
    let difference = |(a, b): (&f32, &f32)| if a.to_bits() == b.to_bits() { 0.0 } else { (a - b).abs() };
    let difference = fast.data.iter().zip(&slow.data).map(difference);
    difference.fold(0.0, |worst: f32, d| if d <= worst { worst } else { d }) / most
}

#[test]
fn light_matches_the_reference() {
    for (name, frame) in scenes() {
        for shade in shades() {
            let error = error(&frame, &shade);
            // The coefficients of a cubic are sums of up to twelve ordinates, rounded to f32.
            let most = if shade.has_gradients() { 4e-5 } else { 1e-5 };
            assert!(error <= most, "{name}, {shade:?}: {error}");
        }
    }
}

#[test]
fn phong_matches_the_reference_under_any_lamps() {
    let near = Lamp {
        position: LampPosition::Point { position: DVec3::new(0.5, 0.8, 1.5), attenuation: [0.2, 0.3, 0.4] },
        intensity: DVec3::new(0.8, 0.7, 0.2),
    };
    let far = Lamp { intensity: DVec3::new(0.1, 0.5, 0.3), ..Lamp::directional(DVec3::new(-1.0, 0.3, 0.4)) };
    for lamps in [vec![], vec![near], vec![far], vec![near, far], vec![Lamp { intensity: DVec3::ONE, ..near }]] {
        for distance in [f64::INFINITY, 3.0] {
            for specular_model in [Specular::Phong, Specular::Blinn] {
                for (specular, shininess) in [(0.0, 0.5), (0.4, 1.0), (0.4, 7.0), (0.4, 64.0), (0.4, 3.5), (0.4, 500.0)]
                {
                    let mut lighting = Lighting { lamps: lamps.clone(), ..brown() };
                    (lighting.material.specular, lighting.material.shininess) = (specular, shininess);
                    lighting.material.specular_model = specular_model;
                    let view = View { distance, ..View::square(90).rotated([10.0, 20.0, 30.0]) };
                    let surface = Surface::new(shapes::blob(60));
                    let frame = Frame::new(&surface, &view, &lighting, SKY);
                    let error = error(&frame, &Shade::new(Shader::Phong));
                    assert!(error <= 1e-5, "{lighting:?}, distance {distance}: {error}");
                }
            }
        }
    }
}

#[test]
fn every_pixel_shows_the_nearest_triangle() {
    for (name, mut frame) in scenes() {
        // Separate all triangles, and use each triangle's number as its light.
        let corners = frame.triangles.iter().flat_map(|t| t.vertices).map(|v| frame.vertices[v as usize]);
        let numbered = corners.enumerate().map(|(i, mut vertex)| {
            vertex.light = DVec3::splat((i / 3) as f64);
            vertex
        });
        frame.vertices = numbered.collect();
        for (t, triangle) in (0..).zip(&mut frame.triangles) {
            triangle.vertices = [3 * t, 3 * t + 1, 3 * t + 2];
        }
        frame.background = DVec3::splat(-1.0);
        let seen_at = |x: u32, y: u32| {
            let p = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let mut seen = (f64::INFINITY, coverage::NONE);
            for t in (0..frame.triangles.len()).filter(|t| covers(&frame, *t, p)) {
                let depths = frame.corners(t).map(|v| v.depth);
                let depth = frame.weights(t, p).iter().zip(depths).map(|(w, depth)| w * depth).sum();
                seen = if depth < seen.0 { (depth, t as u32) } else { seen };
            }
            seen.1
        };
        let visible: Vec<u32> =
            (0..frame.height).flat_map(|y| (0..frame.width).map(move |x| (x, y))).map(|(x, y)| seen_at(x, y)).collect();
        assert!(coverage::visible(&frame) == visible, "{name}");
        let expected: Vec<f32> = visible.iter().map(|t| if *t == coverage::NONE { -1.0 } else { *t as f32 }).collect();
        let image = drawn(&frame, &Shade::new(Shader::Gouraud));
        let seen: Vec<f32> = image.data.iter().step_by(3).copied().collect();
        assert!(seen == expected, "{name}");
        if name != "cube, huge" && !name.starts_with("ugly, huge") {
            assert!(seen.iter().any(|t| *t >= 0.0), "{name}: nothing is seen");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    for (name, frame) in scenes() {
        for shader in [Shader::Gouraud, Shader::Fixed, Shader::Patch, Shader::Phong] {
            let shade = Shade::new(shader);
            let bits = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| drawn(&frame, &shade)).data.into_iter().map(f32::to_bits).collect::<Vec<_>>()
            };
            assert!(bits(1) == bits(3), "{name}, {shader}");
        }
    }
}

#[test]
fn vectors_of_any_width_make_the_same_picture() {
    let mut machines = vec![Arch::Scalar];
    #[cfg(target_arch = "x86_64")]
    machines.extend(pulp::x86::V3::try_new().map(Arch::V3));
    for (name, frame) in &scenes()[..6] {
        for shader in Shader::ALL {
            for (n, vertex) in [(1, Correction::Off), (3, Correction::Repaired), (7, Correction::Printed)] {
                let shade = Shade { depth: Depth::Finite(n), vertex, reweight: vertex, ..Shade::new(*shader) };
                let prepared = Prepared::new(frame, &shade);
                let bits = |image: LinearImage| image.data.into_iter().map(f32::to_bits).collect::<Vec<_>>();
                let own = bits(prepared.image());
                for arch in &machines {
                    assert!(bits(prepared.image_on(*arch)) == own, "{name}, {shade:?}, {arch:?}");
                }
            }
        }
    }
}

#[test]
fn every_code_begins_at_its_threshold() {
    for transfer in [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2)] {
        let (encoder, quantizer) = (Encoder::new(&transfer), ChannelQuantizer::new(&transfer, Bits::Eight));
        let mut lights: Vec<f32> = (1..=255).map(|code| quantizer.threshold(code)).collect();
        lights.extend(lights.clone().iter().map(|light| light.next_down()));
        lights.extend([0.0, -0.0, -1.0, 1.0, 2.0, f32::NAN, 1e30, f32::MIN_POSITIVE, 1e-40]);
        // Every light from 2^-16 to 1 with the same distance between its bits.
        lights.extend((0x3780_0000..0x3f80_0000).step_by(99_991).map(f32::from_bits));
        for light in lights {
            // As many pixels as one vector has.
            let mut frame = frame(shapes::cube(), [16, 1], 99.0, &Lighting::standard(), DVec3::ZERO);
            frame.vertices.iter_mut().for_each(|vertex| vertex.light = DVec3::splat(f64::from(light)));
            let mut pixels = [0; 64];
            Prepared::new(&frame, &Shade::new(Shader::Gouraud)).codes(&encoder, &mut pixels);
            let code = quantizer.code(light) as u8;
            assert_eq!(pixels.as_chunks().0, [[code, code, code, 255]; 16], "{transfer}, {light}");
        }
    }
}
