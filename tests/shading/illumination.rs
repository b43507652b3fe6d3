//! Compares the light of lit surfaces with other implementations, and checks properties that it must have.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};
use machband::shading::lighting::Microfacets;
use machband::shading::{Lamp, LampPosition, Lighting, Material, Refraction, Specular};
use proptest::prelude::*;

use crate::common::golden;

const GLASS: Microfacets = Microfacets { c1: None, slope: 0.3, index: DVec3::new(1.5, 1.8, 2.2) };
const DULL: Microfacets = Microfacets { c1: Some(1.7), ..GLASS };
const MODELS: [(&str, Specular); 4] = [
    ("phong", Specular::Phong),
    ("blinn", Specular::Blinn),
    ("gaussian", Specular::CookTorrance(DULL)),
    ("beckmann", Specular::CookTorrance(GLASS)),
];

fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

/// The scene of scripts/golden_shading.py.
fn scene(specular_model: Specular) -> Lighting {
    let material = Material {
        color: DVec3::new(0.9, 0.5, 0.1),
        specular_color: DVec3::new(0.8, 1.0, 0.6),
        ambient: 0.2,
        diffuse: 0.55,
        specular: 0.4,
        shininess: 12.5,
        specular_model,
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

fn model(name: &str) -> Specular {
    MODELS.iter().find(|(known, _)| *known == name).unwrap().1
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
    let rows = golden("illumination.csv");
    assert_eq!(rows.len(), 192);
    for (name, numbers) in rows {
        let c1 = (name == "gaussian").then(|| numbers[1]);
        let v = vectors(&numbers[2..]);
        let highlight = Microfacets { c1, slope: numbers[0], index: v[0] }.highlight(v[1], v[2], v[3]);
        let error = (highlight - v[4]).abs() / v[4].max(DVec3::splat(1e-9));
        assert!(error.max_element() < 1e-10, "{name} {numbers:?}: {highlight}");
    }
}

#[test]
fn whole_model_agrees_with_python() {
    let rows = golden("illumination_scene.csv");
    assert_eq!(rows.len(), 80);
    for (name, numbers) in rows {
        let v = vectors(&numbers);
        let light = scene(model(&name)).light(v[0], v[1], v[2]);
        assert!((light - v[3]).abs().max_element() < 1e-12, "{name} {numbers:?}: {light}");
    }
}

fn models() -> impl Strategy<Value = Specular> {
    (0..MODELS.len()).prop_map(|i| MODELS[i].1)
}

/// Ordinary numbers and numbers that break careless code.
fn odd() -> impl Strategy<Value = f64> {
    prop_oneof![
        -2.0..2.0,
        -1e-160..1e-160,
        Just(0.0),
        Just(1.0),
        Just(-1.0),
        Just(1e-300),
        Just(1e300),
        Just(f64::INFINITY),
        Just(f64::NAN),
    ]
}

fn odd_vectors() -> impl Strategy<Value = DVec3> {
    (odd(), odd(), odd()).prop_map(DVec3::from)
}

/// Unit vectors, many of them perpendicular or nearly perpendicular to z, and the zero vector.
fn odd_directions() -> impl Strategy<Value = DVec3> {
    let grazing = (-1e-9..1e-9, 0.0..2.0 * PI).prop_map(|(z, a)| DVec3::new(a.cos(), a.sin(), z).normalize());
    let any = odd_vectors().prop_map(DVec3::normalize_or_zero);
    prop_oneof![directions(), grazing, any, Just(DVec3::Z), Just(DVec3::NEG_Z), Just(DVec3::X), Just(DVec3::ZERO)]
}

proptest! {

    #[test]
    fn rotating_everything_changes_nothing(
        specular in models(), p in directions(), n in directions(), v in directions(), axis in directions(), a in 0.0..6.3,
    ) {
        let turn = DMat3::from_quat(DQuat::from_axis_angle(axis, a));
        let lighting = scene(specular);
        let mut turned = lighting.clone();
        for lamp in &mut turned.lamps {
            match &mut lamp.position {
                LampPosition::Direction(v) | LampPosition::Point { position: v, .. } => *v = turn * *v,
            }
        }
        // The microfacets' light has a pole where the view direction is along the surface.
        prop_assume!(n.dot(v).abs() > 1e-2);
        let (before, after) = (lighting.light(p, n, v), turned.light(turn * p, turn * n, turn * v));
        prop_assert!((before - after).abs().max_element() < 1e-12 * (1.0 + before.max_element()), "{before} {after}");
    }

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

    #[test]
    fn light_is_finite_for_any_vectors(
        specular in models(), p in odd_vectors(), n in odd_directions(), v in odd_directions(), l in odd_directions(),
    ) {
        let mut lighting = scene(specular);
        lighting.lamps.push(Lamp { position: LampPosition::Direction(l), intensity: DVec3::ONE });
        let position = LampPosition::Point { position: p, attenuation: [1.0, 0.0, 0.0] };
        lighting.lamps.push(Lamp { position, intensity: DVec3::ONE });
        let light = lighting.light(p, n, v);
        prop_assert!(light.is_finite() && light.min_element() >= 0.0, "{light}");
        prop_assert_eq!(lighting.light(p, DVec3::NAN, v), lighting.ambient_light());
    }
}
