//! The sequence of matches.

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};

use super::rows::Rows;
use crate::{
    display::channel::{Channel, SettingsError},
    light::{CodeImage, random::shuffle},
};

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
    /// One row out of this many is lit: 4 or 2. With 2, the rows blend at half the viewing distance, but each match is
    /// half as precise.
    pub period: u32,
    /// Thickness of a row, 1 or 2 pixels; use 2 for interlaced pictures and for panels that invert their polarity from
    /// row to row.
    pub row_px: u32,
    /// Matches per channel; their spread gives the uncertainty.
    pub matches: usize,
}

impl Default for MatchSettings {
    /// Ten matches each of red, green and blue.
    fn default() -> Self {
        let channels = vec![Channel::Red, Channel::Green, Channel::Blue];
        Self { channels, period: 4, row_px: 1, matches: 10 }
    }
}

impl MatchSettings {
    /// The field of rows.
    #[must_use]
    pub fn rows(&self) -> Rows {
        Rows { lit: 1, period: self.period, row_px: self.row_px }
    }

    /// Total number of matches.
    #[must_use]
    pub fn total(&self) -> usize {
        self.matches * self.channels.len()
    }

    /// Expected duration in seconds.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.total() as f64 * MATCH_S
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

impl Match {
    /// Draws the image: a square of `side` pixels with a square patch of about `patch_px` pixels.
    #[must_use]
    pub fn picture(&self, side: u32, patch_px: u32) -> CodeImage {
        self.rows.picture(self.channel, self.channel.rgb(self.code), [side, side], patch_px)
    }
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
    pub fn new(settings: &MatchSettings, seed: u64, done: Vec<Match>) -> Result<Self, SettingsError> {
        Channel::check_for_profile(&settings.channels)?;
        if !(2..=50).contains(&settings.matches) {
            return Err(SettingsError(format!("{} matches of each channel; expected 2 to 50", settings.matches)));
        }
        let starts = starts(settings, &mut ChaCha8Rng::seed_from_u64(seed));
        let is_other = |at: usize, one: &Match| {
            starts.get(at).is_none_or(|start| (start.channel, start.rows) != (one.channel, one.rows))
        };
        if let Some(at) = done.iter().enumerate().position(|(at, one)| is_other(at, one)) {
            return Err(SettingsError(format!(
                "match {} belongs to other settings; expected the settings that the file was started with, or another file",
                at + 1
            )));
        }
        let shown = starts.get(done.len()).copied();
        Ok(Self { starts, done, shown })
    }

    /// The match on the screen; `None` when all are done.
    #[must_use]
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
    #[must_use]
    pub fn done(&self) -> &[Match] {
        &self.done
    }

    /// Total number of matches.
    #[must_use]
    pub fn total(&self) -> usize {
        self.starts.len()
    }

    /// Expected remaining time in seconds.
    #[must_use]
    pub fn remaining_s(&self) -> f64 {
        (self.total() - self.done.len()) as f64 * MATCH_S
    }
}

fn starts(settings: &MatchSettings, rng: &mut ChaCha8Rng) -> Vec<Match> {
    let rows = settings.rows();
    let mut channels = settings.channels.clone();
    shuffle(&mut channels, rng);
    let mut start = |channel: Channel| {
        let draw = (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let gamma = START_GAMMA.0 * (START_GAMMA.1 / START_GAMMA.0).powf(draw);
        Match { channel, rows, code: (255.0 * rows.share().powf(gamma.recip())).round() as u8 }
    };
    channels.iter().flat_map(|channel| vec![*channel; settings.matches]).map(&mut start).collect()
}
