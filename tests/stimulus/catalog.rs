//! Every stimulus in the catalog: its light matches an independent script, its codes match their recorded hash, and its
//! edges are sharp if they run along the pixels.

use glam::DVec2;
use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{Frame, Scene, Shade, Shader, Surface, shapes},
    stimulus::{KINDS, along, catalog, emitted},
};
use sha2::{Digest as _, Sha256};

/// Side of the golden images.
const SIZE: u32 = 96;

#[test]
fn light_matches_the_independent_script() {
    let golden = include_str!("../golden/catalog.csv");
    let mut seen = 0;
    for line in golden.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<u32>().unwrap();
        let stimulus = crate::stimuli(cells[0])[number(1) as usize].clone();
        let light = stimulus.linear(SIZE).pixel(number(2), number(3))[stimulus.strongest_channel()];
        let expected: f64 = cells[5].parse().unwrap();
        let tolerance = if cells[4] == "1" { 3e-3 } else { 1e-6 };
        assert!((f64::from(light) - expected).abs() < tolerance, "{line}: {light}");
        seen += 1;
    }
    // The shaded mesh has its own references in tests/shading.
    assert_eq!(seen, 40 * 3 * (catalog::all().len() - 1));
}

/// `UPDATE_HASHES=1` writes the file again. A changed hash means a changed stimulus for everyone who has used it.
#[test]
fn codes_match_their_recorded_hashes() {
    let quantizer = Quantizer::new(&Transfer::Srgb, Bits::Eight);
    let mut text =
        String::from("# SHA-256 of the 8-bit sRGB codes, 96 px a side, of every catalog entry and variant.\n");
    for entry in catalog::all() {
        for (variant, stimulus) in crate::stimuli(entry.kind).iter().enumerate() {
            let image = stimulus.codes(SIZE, &quantizer);
            let hash: String =
                Sha256::digest(image.bytes().unwrap()).iter().map(|byte| format!("{byte:02x}")).collect();
            text += &format!("{},{variant},{hash}\n", entry.kind);
        }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/catalog_hashes.csv");
    if std::env::var_os("UPDATE_HASHES").is_some() {
        std::fs::write(path, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), text);
    assert!(catalog::all().iter().map(|entry| entry.kind).eq(KINDS.iter().copied()));
}

fn frame(mesh: shapes::Shape, size: u32) -> Frame {
    Scene::default().frame(&Surface::new(shapes::mesh(mesh, 200).unwrap()), size, size)
}

/// The light along a row of pixel centers equals that row of the picture, and there is none beyond the surface.
#[test]
fn light_along_a_row_matches_the_picture() {
    let frame = frame(shapes::Shape::Torus, 96);
    for shade in [Shader::Gouraud, Shader::Patch].map(Shade::new) {
        let image = emitted(&frame, &shade);
        for y in [10, 48, 70] {
            let ends = [0.0, 96.0].map(|x| DVec2::new(x, f64::from(y) + 0.5));
            for (x, light) in along(&frame, &shade, ends, 96).into_iter().enumerate() {
                let shown = image.pixel(x as u32, y)[0];
                let expected = light.map_or(frame.background.x, |light| light.x) as f32;
                assert!((shown - expected).abs() < 1e-5, "({x}, {y}): {shown}, not {expected}");
            }
        }
    }
}
