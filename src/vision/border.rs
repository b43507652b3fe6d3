//! The edges of what is predicted.

/// What lies beyond the edges of an image or profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// It continues as it ends: a ramp between endless plateaus.
    Continues,
    /// Something else: a channel ignores anything within 1.5 periods of an edge.
    Cut,
}

/// A channel ignores bands within this many of its periods from an edge.
const MARGIN_PERIODS: f64 = 1.5;
/// Nearer than this, the edge itself makes the response, which is not used at all.
const BESIDE_PERIODS: f64 = 0.75;

impl Border {
    /// Width of the margin along the edges in which bands are ignored, degrees.
    pub(super) fn margin_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => MARGIN_PERIODS / frequency,
        }
    }

    /// Width of the margin along the edges in which the response is not used, degrees.
    pub(super) fn beside_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => BESIDE_PERIODS / frequency,
        }
    }
}
