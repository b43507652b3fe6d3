//! The fast rasteriser against the plain f64 reference: the same pixels, the same light, whatever the threads and bands.

use glam::DVec3;
use machband::light::{Depth, LinearImage, Transfer};
use machband::shading::raster::{Encoder, Prepared, Rasterizer};
use machband::shading::{
    Correction, Frame, Gradients, Lamp, Lighting, Mesh, Reference, Shade, Shader, Specular, Surface, View, shapes,
};

/// A number within −1…1 that looks random.
fn noise(seed: u32) -> f64 {
    let mut z = seed.wrapping_mul(0x9E37_79B9) ^ 0x5bd1_e995;
    for _ in 0..3 {
        z ^= z >> 15;
        z = z.wrapping_mul(0x85EB_CA6B);
        z ^= z >> 13;
    }
    f64::from(z) / f64::from(u32::MAX) * 2.0 - 1.0
}

/// Triangles through each other, thin ones among them.
fn ugly(seed: u32) -> Mesh {
    let places: Vec<DVec3> =
        (0..90).map(|i| DVec3::from_array([0, 1, 2].map(|c| noise(seed * 1000 + 3 * i + c)))).collect();
    let mut triangles: Vec<[u32; 3]> = (0..30).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    triangles.extend((0..20).map(|t| [t, t + 1, t + 30]));
    Mesh::new(&places, &triangles, 180.0).unwrap()
}

fn frame(mesh: Mesh, width: u32, height: u32, fill: f64, background: DVec3) -> Frame {
    let view = View { width, height, fill, ..View::square(1).rotated([25.0, 35.0, 10.0]) };
    let lighting = Lighting::standard().with_color(DVec3::new(0.9, 0.6, 0.3));
    Frame::new(&Surface::new(mesh), &view, &lighting, background)
}

fn drawn(frame: &Frame, shade: &Shade, threads: usize, rows: u32) -> LinearImage {
    let mut image = LinearImage::new(0, 0);
    Rasterizer::new(threads).draw_linear(&Prepared::with_bands(frame, shade, rows), &mut image);
    image
}

fn largest_difference(a: &LinearImage, b: &LinearImage) -> f32 {
    assert_eq!((a.width, a.height), (b.width, b.height));
    a.data.iter().zip(&b.data).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn scenes() -> Vec<(&'static str, Frame)> {
    let sky = DVec3::new(0.1, 0.2, 0.4);
    let mut scenes = vec![
        ("cube", frame(shapes::cube(), 131, 97, 0.9, DVec3::ZERO)),
        ("cube, huge", frame(shapes::cube(), 75, 130, 40.0, sky)),
    ];
    for seed in 0..4 {
        scenes.push(("ugly", frame(ugly(seed), 150, 101, 1.1, sky)));
        scenes.push(("ugly, huge", frame(ugly(seed + 10), 133, 70, 25.0, sky)));
    }
    scenes
}

/// Every shader, with depths and widths that take different ways through the rasteriser.
fn shades() -> Vec<Shade> {
    let mut shades = Vec::new();
    for &shader in Shader::ALL {
        let plain = Shade::new(shader);
        shades.push(plain);
        match shader {
            Shader::Fixed | Shader::Gradient | Shader::GradientRepaired | Shader::Exact | Shader::Cut => {
                for n in [1, 2, 3, 4, 5, 9, 32] {
                    for boundary in [0.05, 1.0 / 3.0, 1.0] {
                        shades.push(Shade { depth: Depth::Finite(n), boundary, ..plain });
                    }
                }
                shades.push(Shade { depth: Depth::Infinite, ..plain });
                shades.push(Shade { boundary: 0.0, ..plain });
            }
            Shader::Patch => {
                shades.push(Shade { gradients: Gradients::Ring, ..plain });
                shades.push(Shade { gradients: Gradients::Quadric, ..plain });
            }
            _ => {}
        }
    }
    shades.push(Shade { vertex: Correction::Repaired, ..Shade::new(Shader::Exact) });
    shades.push(Shade { vertex: Correction::Printed, reweight: Correction::Printed, ..Shade::new(Shader::Fixed) });
    shades.push(Shade { reweight: Correction::Repaired, ..Shade::new(Shader::Gouraud) });
    shades
}

#[test]
fn light_is_the_references() {
    let mut worst = std::collections::BTreeMap::new();
    for (name, frame) in scenes() {
        for shade in shades() {
            let (fast, slow) = (drawn(&frame, &shade, 1, 16), Reference::new(&frame, &shade).image());
            let largest = slow.data.iter().fold(1.0, |a: f32, b| a.max(b.abs()));
            let difference = largest_difference(&fast, &slow) / largest;
            let entry = worst.entry((shade.shader.name(), name)).or_insert(0f32);
            *entry = entry.max(difference);
            if !(difference <= 1e-5) {
                println!("{name}, {shade:?}: {difference} of {largest}");
            }
        }
    }
    println!("{worst:#?}");
    assert!(worst.values().all(|w| *w <= 1e-5));
}

#[test]
fn threads_and_bands_do_not_show() {
    for (name, frame) in scenes() {
        let shade = Shade::new(Shader::Gouraud);
        let one = drawn(&frame, &shade, 1, 16);
        for (threads, rows) in [(2, 16), (3, 1), (1, 7), (2, 64), (3, 1000)] {
            assert!(one == drawn(&frame, &shade, threads, rows), "{name}, {threads} threads, bands of {rows} rows");
        }
    }
}

#[test]
fn codes_are_the_quantizers() {
    let transfers =
        [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2), Transfer::Gamma(0.3), Transfer::Gamma(9.0)];
    for (name, frame) in scenes() {
        let shade = Shade::new(Shader::Gouraud);
        let prepared = Prepared::new(&frame, &shade);
        let light = drawn(&frame, &shade, 1, 16);
        for transfer in &transfers {
            let encoder = Encoder::new(transfer);
            let mut codes = vec![0; (4 * frame.width * frame.height) as usize];
            Rasterizer::new(2).draw_codes(&prepared, &encoder, &mut codes);
            for (pixel, light) in codes.chunks(4).zip(light.data.chunks(3)) {
                let expected: Vec<u8> = light.iter().map(|l| encoder.quantizer().code(*l) as u8).chain([255]).collect();
                assert_eq!(pixel, expected, "{name}, {transfer}");
            }
        }
    }
}
