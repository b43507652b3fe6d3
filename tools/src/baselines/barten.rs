//! Barten's formula for the contrast sensitivity of the eye.

/// Returns the contrast sensitivity for a grating of `frequency` cycles per degree, above 0, on a field of `luminance`
/// cd/m² whose side is `field_deg` degrees (Barten 2003, *Formula for the contrast sensitivity of the human eye*, Proc.
/// SPIE 5294). It covers the optics, photon and neural noise, and the lateral inhibition that attenuates coarse gratings.
#[must_use]
pub fn barten(frequency: f64, luminance: f64, field_deg: f64) -> f64 {
    let square = frequency * frequency;
    // In dimmer light, the pupil is larger, and so is the blur.
    let optics = (-0.0016 * square * (1.0 + 100.0 / luminance).powf(0.08)).exp();
    let field = 1.0 + 144.0 / (field_deg * field_deg) + 0.64 * square;
    let photons = 63.0 / luminance.powf(0.83);
    let inhibition = -(-0.02 * square).exp_m1();
    5200.0 * optics / (field * (photons + 1.0 / inhibition)).sqrt()
}
