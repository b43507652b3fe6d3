//! What about a lighting makes no sense.

use std::fmt;

use glam::DVec3;

use super::{
    lamp::LampPlace,
    lighting::Lighting,
    material::{Material, Specular},
    microfacets::Facets,
};

/// A parameter that makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{parameter} is {value}; expected {expected}")]
pub struct ParameterFault {
    /// Which one, such as `lamps[1].attenuation`; lamps count from 0.
    pub parameter: String,
    /// What it is.
    pub value: String,
    /// What it may be.
    pub expected: &'static str,
}

/// All that is wrong with a lighting, at least one fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightingError {
    /// The faults, in the order of the fields.
    pub faults: Vec<ParameterFault>,
}

impl fmt::Display for LightingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.faults.iter().enumerate() {
            write!(f, "{}{fault}", if i > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}

impl std::error::Error for LightingError {}

/// How far a direction's length may be from 1.
const UNIT: f64 = 1e-6;

impl Lighting {
    /// Whether every parameter makes sense.
    ///
    /// # Errors
    /// With all faults, when a coefficient or a surface colour is outside 0…1, an intensity is negative, an exponent is
    /// not above 0, an attenuation is negative or all 0, a direction is not of unit length, a microfacet parameter is
    /// out of its range, or any of them is not a number or infinite.
    pub fn validate(&self) -> Result<(), LightingError> {
        let mut faults = Vec::new();
        material(&self.material, &mut faults);
        intensity("ambient", self.ambient, &mut faults);
        for (i, lamp) in self.lamps.iter().enumerate() {
            place(i, lamp.place, &mut faults);
            intensity(&format!("lamps[{i}].intensity"), lamp.intensity, &mut faults);
        }
        if faults.is_empty() { Ok(()) } else { Err(LightingError { faults }) }
    }
}

/// Notes a fault unless `good`.
fn check(
    good: bool,
    parameter: impl Into<String>,
    value: impl fmt::Display,
    expected: &'static str,
    faults: &mut Vec<ParameterFault>,
) {
    if !good {
        faults.push(ParameterFault { parameter: parameter.into(), value: value.to_string(), expected });
    }
}

fn within(v: DVec3, least: f64, most: f64) -> bool {
    v.to_array().iter().all(|x| (least..=most).contains(x))
}

fn intensity(parameter: &str, v: DVec3, faults: &mut Vec<ParameterFault>) {
    check(within(v, 0.0, f64::MAX), parameter, v, "red, green and blue, each 0 or more and finite", faults);
}

fn material(material: &Material, faults: &mut Vec<ParameterFault>) {
    for (name, color) in [("color", material.color), ("specular_color", material.specular_color)] {
        let expected = "red, green and blue, each within 0…1";
        check(within(color, 0.0, 1.0), format!("material.{name}"), color, expected, faults);
    }
    let coefficients = [("ambient", material.ambient), ("diffuse", material.diffuse), ("specular", material.specular)];
    for (name, k) in coefficients {
        check((0.0..=1.0).contains(&k), format!("material.{name}"), k, "a number within 0…1", faults);
    }
    let m = material.shininess;
    check(m > 0.0 && m.is_finite(), "material.shininess", m, "a finite number above 0, such as 20", faults);
    if let Specular::CookTorrance(microfacets) = material.specular_model {
        let m = microfacets.slope;
        check((1e-3..=10.0).contains(&m), "material.specular_model.slope", m, "a number within 0.001…10", faults);
        let index = microfacets.index;
        let good = within(index, 1e-3, 1e3);
        let expected = "indices of refraction for red, green and blue, each within 0.001…1000, such as 1.5";
        check(good, "material.specular_model.index", index, expected, faults);
        if let Facets::Gaussian { c1 } = microfacets.facets {
            let good = (0.0..=f64::MAX).contains(&c1);
            check(good, "material.specular_model.c1", c1, "a finite number, 0 or more", faults);
        }
    }
}

fn place(i: usize, place: LampPlace, faults: &mut Vec<ParameterFault>) {
    match place {
        LampPlace::Direction(toward) => {
            let good = (toward.length() - 1.0).abs() <= UNIT;
            check(good, format!("lamps[{i}].direction"), toward, "a vector of length 1", faults);
        }
        LampPlace::Point { position, attenuation } => {
            let expected = "three finite coordinates";
            check(position.is_finite(), format!("lamps[{i}].position"), position, expected, faults);
            let [c1, c2, c3] = attenuation;
            let good = within(DVec3::from_array(attenuation), 0.0, f64::MAX) && c1 + c2 + c3 > 0.0;
            let value = format!("[{c1}, {c2}, {c3}]");
            let expected = "c1, c2 and c3, each 0 or more and finite, one of them above 0";
            check(good, format!("lamps[{i}].attenuation"), value, expected, faults);
        }
    }
}
