//! Every stimulus in the catalog: its light matches an independent script, its codes match their recorded hash, and its
//! edges are sharp if they run along the pixels. Also tests a mesh as a renderer draws it, in linear light or ignoring
//! gamma.

use glam::{DVec2, DVec3};
use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{Frame, Reference, Scene, Shade, Shader, Surface, shapes},
    stimulus::{KINDS, Renderer, Shot, Stimulus, catalog},
};
use sha2::{Digest as _, Sha256};

/// Side of the golden images.
const SIZE: u32 = 96;

fn case(kind: &str, variant: usize) -> Stimulus {
    catalog::entry(kind).unwrap().stimuli().swap_remove(variant)
}

#[test]
fn light_matches_the_independent_script() {
    let golden = include_str!("../golden/catalog.csv");
    let mut seen = 0;
    for line in golden.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |i: usize| cells[i].parse::<u32>().unwrap();
        let stimulus = case(cells[0], number(1) as usize);
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
        for (variant, stimulus) in entry.stimuli().iter().enumerate() {
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

fn naive(shader: Shader) -> Renderer {
    Renderer { shade: Shade::new(shader), naive: true }
}

/// Encoding the light before interpolation gives different codes between vertices but the same codes at the vertices.
#[test]
fn ignoring_gamma_shows_only_between_vertices() {
    let frame = frame(shapes::Shape::Cube, 128);
    let transfers = Transfer::Srgb.into();
    let renderers = [Renderer::gouraud(), naive(Shader::Gouraud)];
    let shots = renderers.map(|renderer| renderer.shoot(&frame, &transfers));
    let code = |shot: &Shot<'_>, t, w| {
        let light = Reference::new(&shot.frame, &shot.shade).light(t, w).x as f32;
        i32::from(Quantizer::new(shot.transfers.clone(), Bits::Eight).channel(0).code(light))
    };
    let mut apart = 0;
    for t in 0..frame.triangles.len() {
        for w in [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0]] {
            let [linear, naive] = shots.each_ref().map(|shot| code(shot, t, w));
            assert!(w[0] < 1.0 || (naive - linear).abs() <= 1, "{naive} {linear}");
            apart = apart.max((naive - linear).abs());
        }
    }
    assert!(apart >= 2, "{apart}");
    // The display emits what the codes mean: less light between vertices, and the same light around the surface.
    let [linear, encoded] = shots.map(|shot| shot.emitted());
    let apart = linear.data.iter().zip(&encoded.data).map(|(a, b)| a - b).fold(0.0_f32, f32::max);
    assert!(apart > 0.005, "{apart}");
    assert!((linear.pixel(0, 0)[0] - encoded.pixel(0, 0)[0]).abs() < 1e-6);
    // Where all vertices have the same light, so does every pixel between them.
    let mut uniform = frame.clone();
    uniform.vertices.iter_mut().for_each(|vertex| vertex.light = DVec3::splat(0.3));
    let [linear, encoded] = renderers.map(|renderer| renderer.shoot(&uniform, &transfers).emitted());
    assert!(linear.data.iter().zip(&encoded.data).all(|(a, b)| (a - b).abs() < 1e-5));
    assert!(!naive(Shader::Phong).is_naive(), "Phong lights every pixel");
}

/// The light along a row of pixel centers equals that row of the picture, and there is none beyond the surface.
#[test]
fn light_along_a_row_matches_the_picture() {
    let frame = frame(shapes::Shape::Torus, 96);
    for renderer in [Renderer::gouraud(), naive(Shader::Gouraud), Renderer::new(Shade::new(Shader::Patch))] {
        let shot = renderer.shoot(&frame, &Transfer::Srgb.into());
        let image = shot.emitted();
        for y in [10, 48, 70] {
            let ends = [0.0, 96.0].map(|x| DVec2::new(x, f64::from(y) + 0.5));
            for (x, light) in shot.along(ends, 96).into_iter().enumerate() {
                let shown = image.pixel(x as u32, y)[0];
                let expected = light.map_or(frame.background.x, |light| light.x) as f32;
                // Pictures are drawn in f32.
                assert!((shown - expected).abs() < 1e-5, "({x}, {y}): {shown}, not {expected}");
            }
        }
    }
}
