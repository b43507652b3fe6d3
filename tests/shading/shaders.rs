//! Compares the shaders with numbers computed elsewhere, and checks properties that they must have.

use glam::{DMat3, DQuat, DVec2, DVec3};
use machband::{
    light::Depth,
    shading::{
        Correction, Field, Frame, FrameVertex, Lighting, Patches, Shade, Shader, Shading, Surface, View,
        cubic::Gradient,
        image,
        shapes::{self, Shape},
    },
};

use crate::{
    common::{golden_path, json},
    joined as frame, lit_from, standard, vertex,
};

const CORRECTIONS: [Correction; 3] = [Correction::Off, Correction::Printed, Correction::Repaired];

// ---- frames ----

fn only_ambient() -> Lighting {
    Lighting { lamps: vec![], ..lit_from(DVec3::Z) }
}

/// Makes a square of `cells`² cells of two triangles each, with jittered inner vertices and the light that `light`
/// gives for each position.
fn grid(cells: usize, light: impl Fn(DVec2) -> DVec3) -> Frame {
    let (places, triangles) = crate::grid(cells, 160.0, 0.3, 7);
    let places: Vec<DVec2> = places.iter().map(|p| ((p + 20.0) * 256.0).round() / 256.0).collect();
    crate::frame(&places, &triangles, light)
}

fn shade(shader: Shader, depth: Depth, boundary: f64) -> Shade {
    Shade { depth, boundary, ..Shade::new(shader) }
}

/// Returns weights all over a triangle, including its corners and edges.
fn all_weights() -> Vec<[f64; 3]> {
    let n = 24;
    (0..=n)
        .flat_map(|i| (0..=n - i).map(move |j| (i, j)))
        .map(|(i, j)| [i, j, n - i - j].map(|k| f64::from(k) / f64::from(n)))
        .collect()
}

// ---- numbers computed elsewhere ----

/// Reads a value of the golden file, in which numbers are strings.
fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().or_else(|| value.as_str()?.parse().ok()).unwrap()
}

fn numbers<const N: usize>(value: &serde_json::Value) -> [f64; N] {
    value.as_array().unwrap().iter().map(number).collect::<Vec<_>>().try_into().unwrap()
}

fn golden() -> serde_json::Value {
    json(&golden_path("shading.json"))
}

/// Makes triangles of the golden file's points A, B, C and D, which is across BC.
fn golden_frame(triangles: &[[u32; 3]]) -> Frame {
    let sample = &golden()["sample"];
    let lighting = lit_from(DVec3::from_array(numbers(&sample["light"]["L"])));
    let vertices = [("A", "A"), ("B", "B"), ("C", "C"), ("D_across_BC", "D")].map(|(place, name)| {
        let place = DVec3::from_array(numbers(&sample["positions"][place]));
        let normal = DVec3::from_array(numbers(&sample["normals_unnormalised"][name])).normalize();
        // The y axis is not flipped because A, B, C are clockwise with y up.
        let vertex = vertex(place.truncate() * 100.0, lighting.light(place, normal, DVec3::Z));
        let expected = number(&sample["intensities"][name]);
        assert!((vertex.light - DVec3::splat(expected)).abs().max_element() < 1e-14, "{name}");
        FrameVertex { normal, eye: place, ..vertex }
    });
    frame(vertices.to_vec(), triangles, lighting)
}

#[test]
fn shaders_agree_with_numbers_computed_elsewhere() {
    let golden = golden();
    let pair = golden_frame(&[[0, 1, 2], [3, 2, 1]]);
    let close = |name: &str, value: DVec3, expected: f64| {
        let error = (value - DVec3::splat(expected)).abs().max_element();
        assert!(error <= 1e-9, "{name}: {value}, not {expected}");
    };

    let shaded = &golden["shaded"]["pair"];
    let mut compared = 0;
    for (key, depth) in [("n=2,b=0.2", Depth::Finite(2)), ("n=3,b=0.2", Depth::Finite(3))] {
        let b = 0.2;
        let light = |w, shader, vertex, reweight| {
            let shade = Shade { vertex, reweight, ..shade(shader, depth, b) };
            Shading::new(&pair, &shade).light(0, w)
        };
        for point in shaded[key].as_array().unwrap() {
            let w: [f64; 3] = numbers(&point["w"]);
            use Correction::{Off, Printed, Repaired};
            use Shader::{Fixed, Gouraud, Gradient, GradientRepaired, Phong};
            for (name, value) in [
                ("gouraud", light(w, Gouraud, Off, Off)),
                ("phong", light(w, Phong, Off, Off)),
                ("fixed_printed", light(w, Fixed, Off, Off)),
                ("grad_printed", light(w, Gradient, Off, Off)),
                ("grad_half_IA_IF", light(w, GradientRepaired, Off, Off)),
                ("vertex_printed_over_fixed", light(w, Fixed, Printed, Off)),
                ("vertex_corrected_over_gouraud", light(w, Gouraud, Repaired, Off)),
                ("reweight_printed", light(w, Gouraud, Off, Printed)),
                ("reweight_corrected", light(w, Gouraud, Off, Repaired)),
            ] {
                close(&format!("{key} {w:?} {name}"), value, number(&point[name]));
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 2 * 12 * 9);
    let face = pair.lighting.light(DVec3::ZERO, DVec3::Z, DVec3::Z);
    close("flat", face, number(&golden["sample"]["flat_face_normal_001"]));
    // With y up, ACB goes around as triangles on the screen do.
    let facing = golden_frame(&[[0, 2, 1]]);
    close("flat", Shading::new(&facing, &Shade::new(Shader::Flat)).light(0, [0.2, 0.3, 0.5]), face.x);
}

// ---- fields and frames ----

/// Returns the position on the screen of the weights `w` of a triangle.
fn place_of(frame: &Frame, triangle: usize, w: [f64; 3]) -> DVec2 {
    frame.corners(triangle).iter().zip(w).map(|(corner, w)| w * corner.screen).sum()
}

#[test]
fn a_linear_field_stays_linear() {
    let field = |p: DVec2| DVec3::new(0.1 + 0.003 * p.x + 0.001 * p.y, 0.9 - 0.004 * p.y, 0.5);
    let grid = grid(6, field);
    let shading = Shading::new(&grid, &Shade::new(Shader::Patch));
    for t in 0..grid.triangles.len() {
        for w in all_weights() {
            let p = place_of(&grid, t, w);
            let error = (shading.light(t, w) - field(p)).abs().max_element();
            assert!(error < 1e-12, "{t} {w:?}: {error}");
        }
    }
}

#[test]
fn a_uniform_field_stays_uniform() {
    // With only ambient light, the light at a point does not depend on its normal.
    let mut field = grid(4, |_| DVec3::splat(0.1));
    field.lighting = only_ambient();
    for (i, vertex) in field.vertices.iter_mut().enumerate() {
        vertex.normal = DVec3::new((i as f64).sin(), (2.0 * i as f64).cos(), 1.0).normalize();
    }
    field.triangles[9].across[0] = None;
    for &shader in Shader::ALL {
        for depth in [Depth::Finite(1), Depth::Finite(3), Depth::Infinite] {
            for vertex in [Correction::Off, Correction::Repaired] {
                for reweight in [Correction::Off, Correction::Repaired] {
                    let shading = Shading::new(&field, &Shade { vertex, reweight, ..shade(shader, depth, 0.3) });
                    for t in 0..field.triangles.len() {
                        for w in all_weights() {
                            let error = (shading.light(t, w) - DVec3::splat(0.1)).abs().max_element();
                            assert!(error < 1e-14, "{shader} {depth} {vertex} {reweight} {w:?}: {error}");
                        }
                    }
                }
            }
        }
    }
}

/// Projects the cube, rotated by `degrees`.
fn cube(degrees: [f64; 3], lighting: &Lighting) -> Frame {
    let view = View::square(200).rotated(degrees);
    Frame::new(&Surface::new(shapes::cube()), &view, lighting, DVec3::splat(0.25))
}

#[test]
fn zero_width_is_gouraud_and_widths_are_limited() {
    let frame = grid(3, |p| DVec3::new((p.x / 30.0).sin(), (p.y / 40.0).cos(), (p.x * p.y / 4000.0).sin()) * 0.4 + 0.5);
    let light = |shader, b, t, w| {
        let shade = Shade { vertex: Correction::Repaired, ..shade(shader, Depth::Finite(2), b) };
        Shading::new(&frame, &shade).light(t, w)
    };
    for shader in [Shader::Fixed, Shader::Gradient, Shader::GradientRepaired] {
        for (t, w) in [(7, [0.02, 0.5, 0.48]), (8, [0.3, 0.34, 0.36]), (9, [0.9, 0.1, 0.0]), (3, [0.0, 0.0, 1.0])] {
            for none in [0.0, -1.0] {
                assert_eq!(light(shader, none, t, w), light(Shader::Gouraud, none, t, w), "{shader}");
            }
            // The light does not jump as the width approaches zero.
            let error = (light(shader, 1e-9, t, w) - light(Shader::Gouraud, 0.0, t, w)).abs().max_element();
            assert!(error < 1e-8, "{shader}: {error}");
            assert_eq!(light(shader, 1.0 / 3.0, t, w), light(shader, 7.0, t, w), "{shader}");
        }
        let differ = |b, c| {
            let w = [0.1, 0.5, 0.4];
            (0..18).any(|t| light(shader, b, t, w) != light(shader, c, t, w))
        };
        assert!(differ(0.0, 0.2) && differ(0.2, 0.33), "{shader}");
    }
}

#[test]
fn quadratic_passes_through_vertices_and_midpoints() {
    // The midpoints are lit as Phong's shader lights them.
    let frame = cube([25.0, 35.0, 10.0], &lit_from(DVec3::new(0.36, 0.48, 0.8)));
    let light = |shader, w| Shading::new(&frame, &Shade::new(shader)).light(2, w);
    for w in [[0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0], [0.0, 1.0, 0.0]] {
        assert!((light(Shader::Quadratic, w) - light(Shader::Phong, w)).abs().max_element() < 1e-12);
    }
    // In between, the light is the quadratic that these six lights determine.
    let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|w| light(Shader::Quadratic, w));
    let middles = [[0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]].map(|w| light(Shader::Quadratic, w));
    for w in all_weights() {
        let part =
            |k: usize| w[k] * (2.0 * w[k] - 1.0) * corners[k] + 4.0 * w[(k + 1) % 3] * w[(k + 2) % 3] * middles[k];
        assert!((light(Shader::Quadratic, w) - (part(0) + part(1) + part(2))).abs().max_element() < 1e-14, "{w:?}");
    }
}

/// Makes a frame with slivers, triangles without area, a fin, borders, vertices at the same position, and a triangle
/// that faces away.
fn ugly() -> Frame {
    // In 256ths of a pixel.
    let places = [
        5120, 5120, 5120, 46_080, 25_600, 25_600, 46_080, 5120, 46_080, 46_080, 5120, 5119, 25_601, 25_600, 25_600,
        25_600, 38_400, 38_400,
    ];
    let vertices = places.chunks_exact(2).enumerate().map(|(i, at)| FrameVertex {
        depth: 0.1 * i as f64,
        normal: if i == 4 { DVec3::NEG_Z } else { DVec3::new((i as f64).sin(), 0.3, 0.6).normalize() },
        ..vertex(DVec2::new(at[0].into(), at[1].into()) / 256.0, DVec3::splat(i as f64 / 8.0))
    });
    let triangles = [0, 1, 2, 2, 1, 4, 3, 2, 4, 0, 2, 3, 5, 0, 3, 0, 2, 6, 2, 7, 6, 2, 7, 2, 1, 4, 8, 2, 1, 8, 3, 1, 0];
    let triangles: Vec<[u32; 3]> = triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    frame(vertices.collect(), &triangles, lit_from(DVec3::new(0.36, 0.48, 0.8)))
}

#[test]
fn every_shader_gives_finite_light_on_every_frame() {
    let toward = DVec3::new(0.36, 0.48, 0.8);
    let frames = [
        ugly(),
        cube([0.0; 3], &lit_from(toward)),
        cube([25.0, 35.0, 10.0], &lit_from(toward)),
        cube([45.0, 0.0, 0.0], &lit_from(DVec3::Y)),
    ];
    assert!(frames[1].triangles.iter().any(|t| t.across.contains(&None)));
    let combinations = CORRECTIONS.into_iter().flat_map(|vertex| CORRECTIONS.map(|reweight| (vertex, reweight)));
    for frame in &frames {
        for &shader in Shader::ALL {
            for (vertex, reweight) in combinations.clone() {
                let options = [(Depth::Finite(1), 0.0), (Depth::Finite(3), 1e-300), (Depth::Infinite, 1.0)];
                for (depth, b) in options {
                    let shade = Shade { vertex, reweight, ..shade(shader, depth, b) };
                    let shading = Shading::new(frame, &shade);
                    for t in 0..frame.triangles.len() {
                        for w in all_weights() {
                            let light = shading.light(t, w);
                            assert!(light.is_finite(), "{shader} {vertex} {reweight} {depth} {b} {t} {w:?}: {light}");
                        }
                    }
                }
            }
            let picture = image(frame, &Shade::new(shader));
            assert!(picture.data.iter().all(|light| light.is_finite()), "{shader}");
            assert_eq!(picture.pixel(0, 0), [0.25; 3]);
            assert!(picture.pixel(70, 100) != [0.25; 3], "{shader}");
        }
    }
}

// ---- the cubics of the patch shader ----

#[test]
fn cubics_match_numpy() {
    let rows = |kind| -> Vec<Vec<f64>> { crate::golden(kind).iter().map(|row| crate::numbers(row)).collect() };
    let vertices = rows("vertex");
    let places: Vec<DVec2> = vertices.iter().map(|v| DVec2::new(v[0], v[1])).collect();
    let lights = vertices.iter().map(|v| DVec3::new(v[2], v[3], v[4]));
    let gradients = vertices.iter().map(|v| [0, 1, 2].map(|c| [v[5 + 2 * c], v[6 + 2 * c]])).collect();
    let triangles: Vec<[u32; 3]> = rows("triangle").iter().map(|v| [0, 1, 2].map(|k| v[k] as u32)).collect();
    let samples = rows("sample").into_iter().map(|v| (v[0] as usize, v[1], v[2], DVec3::new(v[3], v[4], v[5])));
    let mut frame = crate::frame(&places, &triangles, |_| DVec3::ZERO);
    for (vertex, light) in frame.vertices.iter_mut().zip(lights) {
        vertex.light = light;
    }
    let patches = Patches::with_gradients(&frame, Field::Light, gradients);
    assert!(samples.len() >= 100);
    for (t, first, second, expected) in samples {
        // The frame's corners may be in the opposite order.
        let w = frame.triangles[t].vertices.map(|v| {
            let k = triangles[t].iter().position(|own| *own == v).expect("a corner");
            [first, second, 1.0 - first - second][k]
        });
        let light = patches.value(t, w);
        assert!((light - expected).abs().max_element() < 1e-11, "triangle {t}: {light}, expected {expected}");
    }
}

/// Makes a sphere with the curvature that is estimated from its mesh.
fn sphere(vertices: usize) -> Surface {
    Surface::new(shapes::mesh(Shape::Sphere, vertices).expect("a sphere"))
}

/// While a mesh turns, its slopes do not jump when the normal of a vertex begins to face away.
#[test]
fn slopes_do_not_jump_where_a_normal_faces_away() {
    let surface = sphere(642);
    for vertex in &surface.mesh.vertices[..40] {
        let [before, after] = [1e-9, -1e-9].map(|z| {
            let turn = DQuat::from_rotation_arc(vertex.normal, DVec3::new(1.0, 0.0, z).normalize());
            let view = View { rotation: DMat3::from_quat(turn), ..View::square(400) };
            let frame = Frame::new(&surface, &view, &standard(), DVec3::ZERO);
            let own = frame.vertices.iter().position(|own| own.normal.distance(DVec3::X) < 1e-6);
            own.map(|own| Patches::new(&frame, Field::Normal).gradients[own])
        });
        let (Some(before), Some(after)) = (before, after) else { continue };
        let apart =
            |a: Gradient, b: Gradient| (0..3).map(|c| DVec2::from(a[c]).distance(b[c].into())).fold(0.0, f64::max);
        let size = apart(before, [[0.0; 2]; 3]);
        assert!(apart(before, after) < 1e-3 * size, "{}: {before:?}, {after:?}", vertex.position);
    }
}
