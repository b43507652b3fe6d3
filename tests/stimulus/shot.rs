//! A mesh as a renderer draws it: in linear light, and with encoded values as a renderer that ignores gamma does.

use glam::DVec2;
use machband::{
    light::{Bits, Quantizer, Transfer},
    shading::{Frame, Reference, Scene, Shade, Shader, Surface, shapes},
    stimulus::{Renderer, Shot},
};

fn frame(mesh: shapes::Shape, size: u32) -> Frame {
    Scene::default().frame(&Surface::new(shapes::mesh(mesh, 200).unwrap()), size, size)
}

fn naive(shader: Shader) -> Renderer {
    Renderer { shade: Shade::new(shader), naive: true }
}

/// Encoding the lights before interpolating them gives other codes between vertices, and the same at them.
#[test]
fn ignoring_gamma_shows_only_between_vertices() {
    let frame = frame(shapes::Shape::Cube, 128);
    let transfers = Transfer::Srgb.into();
    let shots = [Renderer::gouraud(), naive(Shader::Gouraud)].map(|renderer| renderer.shoot(&frame, &transfers));
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
    // What the display sends is what the codes mean: less light between vertices, and the same around the surface.
    let [linear, encoded] = shots.map(|shot| shot.emitted());
    let apart = linear.data.iter().zip(&encoded.data).map(|(a, b)| a - b).fold(0.0_f32, f32::max);
    assert!(apart > 0.005, "{apart}");
    assert!((linear.pixel(0, 0)[0] - encoded.pixel(0, 0)[0]).abs() < 1e-6);
    assert!(!naive(Shader::Phong).is_naive(), "Phong lights every pixel");
}

/// Light along a row of pixel centers is that of the picture's row, and nothing beside the surface.
#[test]
fn light_along_a_row_is_the_pictures() {
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
