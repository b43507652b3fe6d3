//! The limits by which results are judged.

/// Probability below which a difference is told apart from chance.
pub(super) const ALPHA: f64 = 0.05;
/// Krippendorff's α from which he calls data reliable.
pub(super) const RELIABLE: f64 = 0.8;
/// And from which he allows tentative conclusions.
pub(super) const TENTATIVE: f64 = 0.667;
/// Cohen's κ up to which agreement is "slight" at most, Landis & Koch (1977).
pub(super) const LOW_KAPPA: f64 = 0.2;
