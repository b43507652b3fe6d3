//! What is free in a fit, and what the channels share.

use super::{
    reading::Channel,
    sample::Sample,
    shape::{Curve, Family, Shape},
};

/// Where the light at V = 0 comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Black {
    /// The same in all channels, as it must be: the patch is the same.
    Common,
    /// One of each channel: the readings of black differ.
    Own,
    /// The offset's own light in all channels together.
    Offset,
    /// The offset's own light in each channel by itself.
    OwnOffset,
}

/// A family of curves with what the channels share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Model {
    pub family: Family,
    /// One shape for all channels.
    pub pooled: bool,
    pub black: Black,
}

/// Exponents and offsets that are tried.
const GAMMA: (f64, f64) = (0.3, 6.0);
const OFFSET: (f64, f64) = (-0.6, 0.6);

impl Model {
    /// Parameters of a shape.
    fn of_shape(self) -> usize {
        match self.family {
            Family::Srgb => 0,
            Family::Gamma => 1,
            Family::Gog | Family::Table => 2,
        }
    }

    fn shapes(self, width: usize) -> usize {
        if self.pooled { 1 } else { width }
    }

    fn blacks(self, width: usize) -> usize {
        match self.black {
            Black::Common => 1,
            Black::Own => width,
            Black::Offset | Black::OwnOffset => 0,
        }
    }

    /// Number of parameters: shapes, ranges, blacks, in this order.
    pub fn parameters(self, width: usize) -> usize {
        self.shapes(width) * self.of_shape() + width + self.blacks(width)
    }

    /// Index of a channel's γ.
    pub fn gamma_at(self, channel: usize) -> Option<usize> {
        let at = if self.pooled { 0 } else { channel * self.of_shape() };
        (self.of_shape() > 0).then_some(at)
    }

    /// Index of the first range.
    fn ranges_at(self, width: usize) -> usize {
        self.shapes(width) * self.of_shape()
    }

    /// The one channel that a parameter touches; `None` where it touches all.
    pub fn touches(self, width: usize, parameter: usize) -> Option<usize> {
        let ranges = self.ranges_at(width);
        match parameter {
            // The light of all channels is the black of each.
            _ if self.black == Black::Offset => None,
            shape if shape < ranges => (!self.pooled).then(|| shape / self.of_shape()),
            range if range < ranges + width => Some(range - ranges),
            black => (self.black == Black::Own).then(|| black - ranges - width),
        }
    }

    /// The curves of a vector of parameters.
    pub fn curves(self, sample: &Sample, parameters: &[f64]) -> Vec<Curve> {
        let (width, ranges) = (sample.width(), self.ranges_at(sample.width()));
        let shape = |channel: usize| {
            let at = if self.pooled { 0 } else { channel * self.of_shape() };
            match self.family {
                Family::Srgb => Shape::Srgb,
                Family::Gamma => Shape::Gamma(parameters[at]),
                Family::Gog | Family::Table => Shape::Gog(parameters[at], parameters[at + 1]),
            }
        };
        let range = |channel: usize| parameters[ranges + channel].exp();
        let offset: f64 = whites(&sample.channels).map(|channel| range(channel) * shape(channel).offset_light()).sum();
        let black = |channel: usize| match self.black {
            Black::Common => parameters[ranges + width],
            Black::Own => parameters[ranges + width + channel],
            Black::Offset => offset,
            Black::OwnOffset => range(channel) * shape(channel).offset_light(),
        };
        let curve = |channel| Curve { black_cd_m2: black(channel), range_cd_m2: range(channel), shape: shape(channel) };
        (0..width).map(curve).collect()
    }

    /// A vector of parameters to begin with: γ, offset divided by gain, and ranges and black from the readings.
    pub fn start(self, sample: &Sample, gamma: f64, k: f64) -> Vec<f64> {
        let width = sample.width();
        let mean = |wanted: &dyn Fn(usize, f64) -> bool| {
            let found: Vec<f64> = sample.points.iter().filter(|p| wanted(p.channel, p.v)).map(|p| p.y).collect();
            (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
        };
        let black = mean(&|_, v| v == 0.0).unwrap_or(0.0);
        let mut parameters = Vec::with_capacity(self.parameters(width));
        for _ in 0..self.shapes(width) {
            parameters.extend(&[gamma, k][..self.of_shape()]);
        }
        for channel in 0..width {
            let white = mean(&|of, v| of == channel && v == 1.0).unwrap_or(black + 1.0);
            parameters.push((white - black).max(1e-9).ln());
        }
        match self.black {
            Black::Common => parameters.push(black),
            Black::Own => {
                parameters.extend((0..width).map(|channel| mean(&|of, v| of == channel && v == 0.0).unwrap_or(black)));
            }
            Black::Offset | Black::OwnOffset => {}
        }
        parameters
    }

    /// Keeps parameters where a display's can be.
    pub fn clamp(self, width: usize, parameters: &mut [f64]) {
        let ranges = self.ranges_at(width);
        let per = self.of_shape();
        for (at, parameter) in parameters.iter_mut().enumerate() {
            match at {
                shape if shape < ranges && shape % per == 0 => *parameter = parameter.clamp(GAMMA.0, GAMMA.1),
                shape if shape < ranges => *parameter = parameter.clamp(OFFSET.0, OFFSET.1),
                black if black >= ranges + width => *parameter = parameter.max(0.0),
                _ => {}
            }
        }
    }
}

/// The channels that together are white: gray, or all there are.
fn whites(channels: &[Channel]) -> impl Iterator<Item = usize> {
    let gray = channels.iter().position(|channel| *channel == Channel::Gray);
    (0..channels.len()).filter(move |at| gray.is_none_or(|gray| gray == *at))
}
