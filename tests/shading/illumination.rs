//! Compares the light of lit surfaces with other implementations, and checks properties that it must have.

use std::f64::consts::PI;

use glam::DVec3;
use machband::shading::lighting::Microfacets;
use machband::shading::{Highlight, Lamp, LampPosition, Lighting, Material, Refraction};
use proptest::prelude::*;

use crate::{golden, numbers};

const GLASS: Microfacets = Microfacets { c1: None, slope: 0.3, index: DVec3::new(1.5, 1.8, 2.2) };
const DULL: Microfacets = Microfacets { c1: Some(1.7), ..GLASS };
const MODELS: [(&str, Highlight, Microfacets); 4] = [
    ("phong", Highlight::Phong, GLASS),
    ("blinn", Highlight::Blinn, GLASS),
    ("gaussian", Highlight::TorranceSparrow, DULL),
    ("beckmann", Highlight::CookTorrance, GLASS),
];

/// Returns the model and the numbers of a row.
fn named<'a>(row: &[&'a str]) -> (&'a str, Vec<f64>) {
    (row[0], numbers(&row[1..]))
}

fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

/// The scene of scripts/golden_shading.py.
fn scene(name: &str) -> Lighting {
    let (_, highlight, facets) = MODELS.into_iter().find(|(known, ..)| *known == name).unwrap();
    let material = Material {
        color: DVec3::new(0.9, 0.5, 0.1),
        specular_color: DVec3::new(0.8, 1.0, 0.6),
        ambient: 0.2,
        diffuse: 0.55,
        specular: 0.4,
        shininess: 12.5,
        highlight,
        facets,
    };
    let lamp = |position, r, g, b| Lamp { position, intensity: DVec3::new(r, g, b) };
    let point = |x, y, z, attenuation| LampPosition::Point { position: DVec3::new(x, y, z), attenuation };
    let lamps = vec![
        lamp(LampPosition::Direction(DVec3::new(2.0, 3.0, 6.0) / 7.0), 0.9, 0.8, 0.7),
        lamp(point(1.5, -0.5, 2.0, [0.5, 0.25, 0.125]), 1.0, 0.1, 0.4),
        lamp(point(-0.25, 0.5, 0.75, [0.1, 0.2, 0.3]), 0.2, 2.0, 0.3),
    ];
    Lighting { material, ambient: DVec3::new(0.3, 0.5, 0.7), lamps }
}

/// Makes a unit vector from two numbers within 0…1; all directions are equally likely.
fn direction((u, v): (f64, f64)) -> DVec3 {
    let (z, angle) = (2.0 * u - 1.0, 2.0 * PI * v);
    DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z).normalize()
}

fn directions() -> impl Strategy<Value = DVec3> {
    (0.0..1.0f64, 0.0..1.0f64).prop_map(direction)
}

#[test]
fn highlights_of_microfacets_agree_with_python() {
    let rows = golden("highlight");
    assert_eq!(rows.len(), 192);
    for (name, numbers) in rows.iter().map(|row| named(row)) {
        let c1 = (name == "gaussian").then(|| numbers[1]);
        let v = vectors(&numbers[2..]);
        let highlight = Microfacets { c1, slope: numbers[0], index: v[0] }.highlight(v[1], v[2], v[3]);
        let error = (highlight - v[4]).abs() / v[4].max(DVec3::splat(1e-9));
        assert!(error.max_element() < 1e-10, "{name} {numbers:?}: {highlight}");
    }
}

#[test]
fn whole_model_agrees_with_python() {
    let rows = golden("scene");
    assert_eq!(rows.len(), 80);
    for (name, numbers) in rows.iter().map(|row| named(row)) {
        let v = vectors(&numbers);
        let light = scene(name).light(v[0], v[1], v[2]);
        assert!((light - v[3]).abs().max_element() < 1e-12, "{name} {numbers:?}: {light}");
    }
}

proptest! {
    #[test]
    fn refraction_obeys_snell_and_is_reversible(
        l in directions(), n in directions(), ratio in prop_oneof![Just(1.0), 0.2..3.0f64],
    ) {
        let along = |v: DVec3| v - v.dot(n) * n;
        let sin = along(l).length();
        match Refraction::of(l, n, ratio) {
            Refraction::Transmitted(t) => {
                // The vector has unit length, lies beyond the surface and has Snell's sine, and light from there returns
                // along the way it came. Near grazing angles, one of the two directions is near the critical angle,
                // where the error is the square root of the rounding error.
                prop_assert!(ratio * sin < 1.0 + 1e-14 && (t.length() - 1.0).abs() < 1e-14);
                prop_assert!((along(t) + ratio * along(l)).length() < 1e-14 && t.dot(n) * l.dot(n) <= 0.0, "{t} {l}");
                prop_assume!(t.dot(n).abs() > 1e-3 && l.dot(n).abs() > 1e-3);
                let Refraction::Transmitted(back) = Refraction::of(t, n, 1.0 / ratio) else { panic!("no way back") };
                prop_assert!((back - l).length() < 1e-11, "{back} {l}");
            }
            Refraction::TotalReflection(r) => {
                prop_assert!(ratio * sin > 1.0 - 1e-14 && (r + l - 2.0 * l.dot(n) * n).length() < 1e-14, "{r} {l}");
            }
        }
    }
}
