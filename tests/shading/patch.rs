//! The patch shader: a comparison with another implementation, and its smoothness while a mesh turns.

use crate::{frame, standard};
use glam::{DMat3, DQuat, DVec2, DVec3};
use machband::shading::{
    Field, Frame, Patches, Surface, View,
    cubic::Gradient,
    shapes::{self, Shape},
};

#[test]
fn cubics_match_numpy() {
    let text = include_str!("../golden/patch.csv");
    let (mut places, mut lights, mut gradients, mut triangles) = (vec![], vec![], vec![], vec![]);
    let mut samples = vec![];
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (kind, values) = line.split_once(',').expect("a kind");
        let v: Vec<f64> = values.split(',').map(|v| v.parse().expect("a number")).collect();
        match kind {
            "vertex" => {
                places.push(DVec2::new(v[0], v[1]));
                lights.push(DVec3::new(v[2], v[3], v[4]));
                gradients.push([0, 1, 2].map(|c| [v[5 + 2 * c], v[6 + 2 * c]]));
            }
            "triangle" => triangles.push([0, 1, 2].map(|k| v[k] as u32)),
            _ => samples.push((v[0] as usize, v[1], v[2], DVec3::new(v[3], v[4], v[5]))),
        }
    }
    let mut frame = frame(&places, &triangles, |_| DVec3::ZERO);
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
