//! Measures gamma without a photometer: the observer matches a patch to a field of rows by eye.
//!
//! In a field of whole-pixel rows, k of every m rows are lit with the largest code, and the others are dark. Once the
//! rows blend, the field has k/m of the full light, whatever the display's transfer function is. A uniform patch of
//! code c inside the field vanishes if it has the same light. Such matches determine γ in L(c) ∝ (c/255)^γ, Shoaff
//! §2.1.1. Ambient light falls equally on the field and the patch and cancels.
//!
//! **Rows, not columns.** Along a row, the driver (on a CRT, the beam) has to follow every change within one pixel, and
//! a red, green or blue stripe blurs into the next. From row to row, each pixel has the time of a whole line to settle.
//! Two things can still go wrong, and pairs of rows ([`Rows::row_px`] = 2) avoid both. An interlaced picture shows the
//! even rows in one half-frame and the odd rows in the next, so single rows flicker. A panel that inverts its drive
//! polarity from row to row shows the lit rows of a period of 2 with one polarity only, which makes them flicker and
//! shifts their light.
//!
//! **Which rows.** If the field has the share p of full light, a match with the relative precision ε determines γ to
//! within γ·ε/|ln p|: lighting one row of four is twice as precise as lighting one row of two.
//!
//! [`Matching`] presents the matches, and [`estimate()`] derives γ from them. This module has no clock, no file, and no
//! source of randomness: the seed is an argument.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};

use super::channel::Channel;
use crate::{
    light::{CodeImage, Samples, Transfer, Transfers},
    statistics::{mean_and_sd, shuffle, t_quantile},
};

/// A field of rows: `lit` of every `period` rows have the largest code, and the others are dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rows {
    /// Lit rows per period.
    pub lit: u32,
    /// Rows per period.
    pub period: u32,
    /// Thickness of a row in pixels.
    pub row_px: u32,
}

impl Rows {
    /// The field's share of full light, 0…1.
    pub fn share(&self) -> f64 {
        f64::from(self.lit) / f64::from(self.period)
    }

    /// The period in pixels.
    pub fn period_px(&self) -> u32 {
        self.period * self.row_px
    }

    /// Draws the rows over `width` × `height` pixels, with a uniform square patch of about `patch_px` pixels in the
    /// middle. The image has 8 bits and must be shown pixel by pixel.
    ///
    /// The patch is shrunk until it spans whole periods, and it starts where a period starts, so whole periods border
    /// it above and below.
    pub fn picture(&self, channel: Channel, patch: [u8; 3], [width, height]: [u32; 2], patch_px: u32) -> CodeImage {
        let period = self.period_px().max(1);
        let side = patch_px.min(width).min(height) / period * period;
        let left = (width - side) / 2;
        let top = (height - side) / 2 / period * period;
        let mut codes = Vec::with_capacity(width as usize * height as usize * 3);
        for y in 0..height {
            let is_lit = y / self.row_px % self.period < self.lit;
            let row = channel.rgb(if is_lit { 255 } else { 0 });
            let across = (top..top + side).contains(&y);
            codes.extend((0..width).flat_map(|x| if across && (left..left + side).contains(&x) { patch } else { row }));
        }
        CodeImage { width, height, samples: Samples::Eight(codes) }
    }
}

/// Expected time of one match, in seconds: about ten steps at a few per second, past the match and back, then a check.
const MATCH_S: f64 = 10.0;
/// Duration of the blank screen between two images, in seconds; it keeps the afterimage of one image from masking the
/// next. Included in `MATCH_S`.
pub const GAP_S: f64 = 0.4;
/// The patch starts from a code that would match for a γ within this range.
const START_GAMMA: (f64, f64) = (1.2, 4.0);

/// The settings of the matches.
#[derive(Clone, Debug, PartialEq)]
pub struct MatchSettings {
    /// The channels to match, each once.
    pub channels: Vec<Channel>,
    /// The field of rows, of which one of 4 or of 2 is lit. With 2, the rows blend at half the viewing distance, but each
    /// match is half as precise. They are 1 pixel thick, or 2 for interlaced pictures and for panels that invert their
    /// polarity from row to row.
    pub rows: Rows,
    /// Matches per channel; their spread gives the uncertainty.
    pub matches: usize,
}

impl Default for MatchSettings {
    /// Ten matches each of red, green and blue.
    fn default() -> Self {
        let channels = vec![Channel::Red, Channel::Green, Channel::Blue];
        Self { channels, rows: Rows { lit: 1, period: 4, row_px: 1 }, matches: 10 }
    }
}

/// A patch that was adjusted until it vanished in its field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Match {
    /// The lit channel.
    pub channel: Channel,
    /// The field of rows around the patch.
    pub rows: Rows,
    /// The patch's code.
    pub code: u8,
}

/// A run of matches: provides the images and takes the codes.
#[derive(Clone, Debug)]
pub struct Matching {
    /// All matches in their initial state.
    starts: Vec<Match>,
    done: Vec<Match>,
    /// The match on the screen; `None` when all are done.
    shown: Option<Match>,
}

impl Matching {
    /// Plans the matches. The channels come in random order, one after the other so that the eye adapts to each only
    /// once, and each match starts from a random code. Equal settings and seeds give the same matches on every machine.
    /// `done` contains the matches of an earlier run with the same seed.
    ///
    /// # Errors
    /// Returns an error if the settings cannot be run or if `done` comes from other settings.
    pub fn new(settings: &MatchSettings, seed: u64, done: Vec<Match>) -> Result<Self, String> {
        Channel::check_for_profile(&settings.channels)?;
        let starts = starts(settings, &mut ChaCha8Rng::seed_from_u64(seed));
        let is_other = |at: usize, one: &Match| {
            starts.get(at).is_none_or(|start| (start.channel, start.rows) != (one.channel, one.rows))
        };
        if let Some(at) = done.iter().enumerate().position(|(at, one)| is_other(at, one)) {
            return Err(format!(
                "match {} belongs to other settings; expected the settings that the file was started with, or another file",
                at + 1
            ));
        }
        let shown = starts.get(done.len()).copied();
        Ok(Self { starts, done, shown })
    }

    /// The match on the screen; `None` when all are done.
    pub fn shown(&self) -> Option<Match> {
        self.shown
    }

    /// Sets the code of the patch.
    pub fn adjust(&mut self, code: u8) {
        if let Some(shown) = &mut self.shown {
            shown.code = code;
        }
    }

    /// Accepts the current patch and shows the next image. Returns the accepted match.
    pub fn accept(&mut self) -> Option<Match> {
        let accepted = self.shown?;
        self.done.push(accepted);
        self.shown = self.starts.get(self.done.len()).copied();
        Some(accepted)
    }

    /// Undoes the last match and shows it again with the code that was accepted. Returns the match that no longer
    /// counts.
    pub fn undo(&mut self) -> Option<Match> {
        self.shown = Some(self.done.pop()?);
        self.shown
    }

    /// Every match that counts, in order.
    pub fn done(&self) -> &[Match] {
        &self.done
    }

    /// Total number of matches.
    pub fn total(&self) -> usize {
        self.starts.len()
    }

    /// Expected remaining time in seconds.
    pub fn remaining_s(&self) -> f64 {
        (self.total() - self.done.len()) as f64 * MATCH_S
    }
}

fn starts(settings: &MatchSettings, rng: &mut ChaCha8Rng) -> Vec<Match> {
    let rows = settings.rows;
    let mut channels = settings.channels.clone();
    shuffle(&mut channels, rng);
    let mut start = |channel: Channel| {
        let draw = (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let gamma = START_GAMMA.0 * (START_GAMMA.1 / START_GAMMA.0).powf(draw);
        Match { channel, rows, code: (255.0 * rows.share().powf(gamma.recip())).round() as u8 }
    };
    channels.iter().flat_map(|channel| vec![*channel; settings.matches]).map(&mut start).collect()
}

/// Half-width of the 95 % interval of γ above which a channel should be matched again.
const MAX_HALF_WIDTH: f64 = 0.1;

/// The result of the matches of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelGamma {
    /// The exponent γ.
    pub gamma: f64,
    /// The 95 % interval of γ, by Student's t.
    pub interval: [f64; 2],
    /// Number of matches.
    pub matches: usize,
}

/// Estimates γ of each channel that has matches, in the order of [`Channel::ALL`].
pub fn estimate(matches: &[Match]) -> Vec<(Channel, Result<ChannelGamma, String>)> {
    let of = |channel: Channel| {
        let own: Vec<Match> = matches.iter().filter(|one| one.channel == channel).copied().collect();
        (!own.is_empty()).then(|| (channel, channel_gamma(&own)))
    };
    Channel::ALL.iter().copied().filter_map(of).collect()
}

/// A match means (c/255)^γ = share, so ln(255/c), the quantity that varies from match to match, equals |ln share|/γ.
fn channel_gamma(own: &[Match]) -> Result<ChannelGamma, String> {
    let n = own.len() as f64;
    if own.len() < 2 {
        return Err(format!("{} matches; expected at least 2", own.len()));
    }
    if own.iter().any(|one| one.rows != own[0].rows) {
        return Err("the matches have different rows; expected matches of one run".to_owned());
    }
    let codes: Vec<f64> = own.iter().map(|one| f64::from(one.code.max(1))).collect();
    let (mean, sd) = mean_and_sd(&codes.iter().map(|code| (255.0 / code).ln()).collect::<Vec<_>>());
    // Equal codes do not mean zero uncertainty: a match is precise to one code at best.
    let rounding = codes.iter().sum::<f64>().recip() * n / 12f64.sqrt();
    let half = t_quantile(n - 1.0) * sd.hypot(rounding) / n.sqrt();
    // They differ too much, or are too close to black or white.
    if mean - half <= 0.0 {
        return Err("the matches do not determine γ; expected codes that agree with each other".to_owned());
    }
    let gamma = |mean: f64| -own[0].rows.share().ln() / mean;
    let interval = [gamma(mean + half), gamma(mean - half)];
    Ok(ChannelGamma { gamma: gamma(mean), interval, matches: own.len() })
}

impl ChannelGamma {
    /// Returns a warning if γ is too uncertain.
    pub fn warning(&self) -> Option<String> {
        let half = (self.interval[1] - self.interval[0]) / 2.0;
        let advice = "Sit far enough away that the rows blend, and repeat the matches.";
        (half > MAX_HALF_WIDTH).then(|| format!("gamma is uncertain by ± {half:.2}. {advice}"))
    }
}

/// Returns the display's transfer functions: one each for red, green, and blue if all were matched, otherwise the
/// transfer function of gray for all three. `None` if a required channel is missing or has no γ.
pub fn transfers(estimates: &[(Channel, Result<ChannelGamma, String>)]) -> Option<Transfers> {
    let of = |wanted: Channel| {
        let (_, found) = estimates.iter().find(|(channel, _)| *channel == wanted)?;
        // Rounded for a profile; `None` if it is implausible for a display.
        Transfer::gamma((found.as_ref().ok()?.gamma * 1e3).round() / 1e3).ok()
    };
    match (of(Channel::Red), of(Channel::Green), of(Channel::Blue)) {
        (Some(red), Some(green), Some(blue)) => Some(Transfers::new([red, green, blue])),
        _ => of(Channel::Gray).map(Transfers::from),
    }
}
