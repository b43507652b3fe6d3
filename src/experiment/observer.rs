//! Simulated observers. They rate by a known rule, so that an analysis can be tested before any data are collected.

use std::{collections::HashMap, sync::Mutex, time::Duration};

use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng as _},
};
use rand_distr::{Distribution as _, StandardNormal};

use super::{
    participant::{Identity, fnv1a},
    protocol::Protocol,
    session::{Effect, Event, Session, State, TrialResponse},
    task::{Answer, Presentation, Senses},
};
use crate::{
    light::interpolation::Depth,
    stimulus::{Stimulus, ViewingConditions},
    text::Cell,
    vision::Criterion,
};

/// An observer that rates stimuli.
pub trait Observer: Sync {
    /// Returns the rating of a stimulus on a scale with this many categories, from 0. `subject` is the participant's own
    /// standard normal deviate.
    fn rate(&self, stimulus: &Stimulus, categories: usize, subject: f64, rng: &mut ChaCha8Rng) -> u8;
    /// Returns how strongly the participant sees the band of a stimulus, on an axis on which a look has noise of standard
    /// deviation 1: signal detection. 0 is nothing to see.
    fn strength(&self, stimulus: &Stimulus, subject: f64) -> f64;
    /// Returns the probability of a random answer.
    fn lapse(&self) -> f64;
}

/// How strongly a band must be seen to count as seen; see [`Observer::strength`].
const CRITERION: f64 = 1.0;

/// Returns the answer of an observer to a trial of any task.
fn answered(
    observer: &dyn Observer,
    protocol: &Protocol,
    shown: &Presentation,
    subject: f64,
    rng: &mut ChaCha8Rng,
) -> Answer {
    let task = &protocol.task;
    let categories = protocol.response.categories.len();
    if task.is_default() {
        return Answer::Key(observer.rate(&shown.stimuli[0], categories, subject, rng));
    }
    if unit(rng) < observer.lapse() {
        return match task.dial() {
            Some(dial) => Answer::Value(dial.at(unit(rng))),
            None => Answer::Key(any_key(categories, rng)),
        };
    }
    let mean = |stimulus: &Stimulus| observer.strength(stimulus, subject);
    let mut noisy = |stimulus: &Stimulus| {
        let noise: f64 = StandardNormal.sample(rng);
        mean(stimulus) + noise
    };
    task.answer(shown, Senses { noisy: &mut noisy, mean: &mean, criterion: CRITERION })
}

/// Presses keys at random: each rating is equally probable.
#[derive(Clone, Copy, Debug)]
pub struct UniformObserver;

impl Observer for UniformObserver {
    fn rate(&self, _: &Stimulus, categories: usize, _: f64, rng: &mut ChaCha8Rng) -> u8 {
        any_key(categories, rng)
    }

    fn strength(&self, _: &Stimulus, _: f64) -> f64 {
        0.0
    }

    fn lapse(&self) -> f64 {
        1.0
    }
}

/// Returns each rating with the same probability.
fn any_key(categories: usize, rng: &mut ChaCha8Rng) -> u8 {
    ((u128::from(rng.next_u64()) * categories as u128) >> 64) as u8
}

/// Returns a random key, with the probability `lapse`, or otherwise the rating with standard logistic noise, by inversion.
fn rated(lapse: f64, categories: usize, rng: &mut ChaCha8Rng, rating: impl FnOnce(f64) -> u8) -> u8 {
    if unit(rng) < lapse {
        return any_key(categories, rng);
    }
    let u = unit(rng);
    rating((u / (1.0 - u)).ln())
}

/// Returns the rating of a latent value: the number of thresholds below it. The three thresholds of an observer belong to
/// four categories and lie at ¼, ½ and ¾ of their scale. Those of another number of categories, at j/`categories`, are
/// on the lines through them.
fn rating(thresholds: [f64; 3], categories: usize, latent: f64) -> u8 {
    let [first, second, third] = thresholds;
    let at = |share: f64| {
        let (from, to, along) =
            if share < 0.5 { (first, second, 4.0 * share - 1.0) } else { (second, third, 4.0 * share - 2.0) };
        // Exactly the given thresholds where they apply.
        from * (1.0 - along) + to * along
    };
    (1..categories).filter(|threshold| latent > at(*threshold as f64 / categories as f64)).count() as u8
}

/// The parameters of an observer, as in its file.
pub trait ObserverParameters: serde::de::DeserializeOwned + Default {
    /// All thresholds are above this.
    const ABOVE: f64;
    /// Returns the boundaries between ratings.
    fn thresholds(&self) -> [f64; 3];
    /// Returns each other parameter with its name and its range.
    fn parameters(&mut self) -> Vec<(&'static str, &mut f64, [f64; 2])>;
}

/// Declares the parameters of an observer, with their defaults and ranges.
macro_rules! parameters {
    ($(#[$meta:meta])* $name:ident, $thresholds:expr, above $above:expr, {
        $($(#[doc = $about:literal])+ $field:ident: $default:expr, $range:expr;)*
    }) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            /// The boundaries between ratings, in ascending order.
            pub thresholds: [f64; 3],
            $($(#[doc = $about])+ pub $field: f64,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { thresholds: $thresholds, $($field: $default,)* }
            }
        }

        impl ObserverParameters for $name {
            const ABOVE: f64 = $above;
            fn thresholds(&self) -> [f64; 3] {
                self.thresholds
            }
            fn parameters(&mut self) -> Vec<(&'static str, &mut f64, [f64; 2])> {
                vec![$((stringify!($field), &mut self.$field, $range),)*]
            }
        }
    };
}

parameters! {
    /// An ordered-logit observer: P(rating ≤ j) = 1/(1+e^(η−θ_j)), with
    ///
    /// η = `depth`·q − `fall`·log₂⁺(w/w₀) − `narrow`·log₂⁺(w₀/w) + `oblique`·|sin 2θ| + `contrast`·log₂(c/½) +
    /// `subject_sd`·z
    ///
    /// where q = 1/n (for n = ∞, q = 1/`infinite_as`, because the slope of 2.5 in the middle of that ramp is close to that
    /// of n = 5), w is the width, w₀ is the width of the strongest band, θ is the orientation, c = (high−low)/(high+low), z
    /// is the participant's deviate, and log₂⁺ = max(log₂, 0). A step (w = 0) and a uniform field (c = 0) have no band and
    /// are rated 0.
    ///
    /// By default, it follows the findings of Bangay §3.2. Visibility decreases with width, and also for very narrow ramps.
    /// It decreases with n and is still decreasing after n = 3. A linear ramp is always visible. Orientation has no effect.
    /// The numbers are chosen so that the results look like Bangay's Figure 4; they are not estimated from data.
    OrderedLogit, [0.0, 1.5, 3.5], above f64::NEG_INFINITY, {
        /// Standard deviation of the participants' intercepts.
        subject_sd: 0.6, [0.0, 100.0];
        /// Weight of 1/n.
        depth: 6.0, [-1000.0, 1000.0];
        /// The finite n as which n = ∞ counts.
        infinite_as: 5.0, [1.0, 1000.0];
        /// Width of the strongest band, as a proportion of the window.
        strongest_width: 0.05, [1e-6, 1.0];
        /// Loss for each doubling of the width above `strongest_width`.
        fall: 0.7, [-1000.0, 1000.0];
        /// Loss for each halving of the width below `strongest_width`.
        narrow: 0.9, [-1000.0, 1000.0];
        /// Weight of |sin 2θ|, which grows with the distance from the cardinal orientations.
        oblique: 0.0, [-1000.0, 1000.0];
        /// Weight of each doubling of Michelson contrast relative to ½.
        contrast: 0.0, [-1000.0, 1000.0];
        /// Probability of pressing a random key.
        lapse: 0.01, [0.0, 1.0];
    }
}

impl OrderedLogit {
    /// Returns the linear predictor η of a stimulus for a participant, or −∞ if there is no band to see.
    pub fn predictor(&self, stimulus: &Stimulus, subject: f64) -> f64 {
        let number = |name: &str| Cell::from(stimulus.get(name)?).as_number();
        let depth = match stimulus.get("depth").and_then(|d| d.to_string().parse().ok()) {
            Some(Depth::Finite(n)) => self.depth / f64::from(n),
            Some(Depth::Infinite) => self.depth / self.infinite_as,
            None => 0.0,
        };
        if number("width") == Some(0.0) {
            return f64::NEG_INFINITY;
        }
        let octaves = number("width").map_or(0.0, |w| (w / self.strongest_width).log2());
        let loss = if octaves > 0.0 { self.fall * octaves } else { -self.narrow * octaves };
        let oblique = number("orientation_deg").map_or(0.0, |deg| (2.0 * deg).to_radians().sin().abs());
        let contrast = match (number("low"), number("high")) {
            (Some(low), Some(high)) if high > low => (high - low) / (high + low),
            (Some(_), Some(_)) => return f64::NEG_INFINITY,
            _ => 0.5,
        };
        depth - loss + self.oblique * oblique + self.contrast * (contrast / 0.5).log2() + self.subject_sd * subject
    }

    /// Returns a rating on a scale with this many categories for a linear predictor.
    pub fn rate_at(&self, predictor: f64, categories: usize, rng: &mut ChaCha8Rng) -> u8 {
        rated(self.lapse, categories, rng, |noise| rating(self.thresholds, categories, predictor + noise))
    }
}

impl Observer for OrderedLogit {
    fn rate(&self, stimulus: &Stimulus, categories: usize, subject: f64, rng: &mut ChaCha8Rng) -> u8 {
        self.rate_at(self.predictor(stimulus, subject), categories, rng)
    }

    /// ln(1 + e^η), which falls to 0 where no band is rated, and is η where it is clear.
    fn strength(&self, stimulus: &Stimulus, subject: f64) -> f64 {
        let predictor = self.predictor(stimulus, subject);
        if predictor > 30.0 { predictor } else { predictor.exp().ln_1p() }
    }

    fn lapse(&self) -> f64 {
        self.lapse
    }
}

parameters! {
    /// An invented observer that rates what the vision model predicts: the bright band of a ramp, or the difference of a
    /// shaded mesh from the smooth surface, in times threshold. Its criterion was not fitted to people.
    VisionRater, [0.25, 1.0, 4.0], above 0.0, {
        /// See [`Criterion::spread`].
        spread: 0.8, [1e-6, 1000.0];
        /// Standard deviation between participants, in units of ln times threshold.
        subject_sd: 0.4, [0.0, 100.0];
        /// Probability of pressing a random key.
        lapse: 0.01, [0.0, 1.0];
    }
}

impl VisionRater {
    /// Returns the criterion by which this observer rates.
    pub fn criterion(&self) -> Criterion {
        Criterion { thresholds: self.thresholds, spread: self.spread }
    }
}

/// A [`VisionRater`] with what it sees in stimuli, each computed once.
#[derive(Debug)]
pub struct VisionObserver {
    rater: VisionRater,
    viewing: ViewingConditions,
    /// What it saw, by [`Stimulus::key`].
    seen: Mutex<HashMap<String, f64>>,
}

impl VisionObserver {
    /// Judges every condition of `protocol` at its window size.
    ///
    /// # Errors
    /// Returns the reason why a stimulus cannot be rated.
    pub fn new(rater: VisionRater, protocol: &Protocol) -> Result<Self, String> {
        let conditions = protocol.conditions();
        let viewing = ViewingConditions::new(protocol.viewing.window_deg);
        let stimuli: Vec<&Stimulus> = conditions.iter().map(|condition| &condition.stimulus).collect();
        let found = viewing.visible(&stimuli, None).map_err(|error| error.to_string())?;
        let seen = stimuli.into_iter().zip(found).map(|(stimulus, visible)| {
            let unrated = || {
                format!(
                    "the vision model does not say how visible the bands in a stimulus of the kind {} are; expected a mach-band, or a mesh whose smooth surface is known",
                    stimulus.kind()
                )
            };
            Ok((stimulus.key(), visible.rated().ok_or_else(unrated)?))
        });
        let seen = seen.collect::<Result<_, String>>()?;
        Ok(Self { rater, viewing, seen: Mutex::new(seen) })
    }

    /// Returns what the observer sees in a stimulus, in times threshold; 0 if the model does not say.
    pub fn seen(&self, stimulus: &Stimulus) -> f64 {
        let key = stimulus.key();
        let known = self.seen.lock().ok().and_then(|seen| seen.get(&key).copied());
        known.unwrap_or_else(|| {
            let visible = self.viewing.visible(&[stimulus], None).ok().and_then(|visible| visible.first()?.rated());
            let times = visible.unwrap_or(0.0);
            if let Ok(mut seen) = self.seen.lock() {
                seen.insert(key, times);
            }
            times
        })
    }
}

impl Observer for VisionObserver {
    fn rate(&self, stimulus: &Stimulus, categories: usize, subject: f64, rng: &mut ChaCha8Rng) -> u8 {
        let VisionRater { thresholds, spread, subject_sd, lapse } = self.rater;
        let seen = self.seen(stimulus).max(0.0).ln() + subject_sd * subject;
        rated(lapse, categories, rng, |noise| rating(thresholds.map(f64::ln), categories, seen + spread * noise))
    }

    /// In times threshold: a band at its threshold lies one standard deviation of the noise above nothing.
    fn strength(&self, stimulus: &Stimulus, subject: f64) -> f64 {
        self.seen(stimulus).max(0.0) * (self.rater.subject_sd * subject).exp()
    }

    fn lapse(&self) -> f64 {
        self.rater.lapse
    }
}

/// Returns a uniform random number in the open interval (0, 1).
fn unit(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
}

/// Median response time of a simulated observer, seconds.
const RESPONSE_MEDIAN_S: f64 = 1.6;
/// Standard deviation of the logarithm of the response time.
const RESPONSE_SIGMA: f64 = 0.4;

/// Lets an observer rate every remaining trial as fast as the records can be stored. Time is simulated and starts at
/// `start`. A rating depends only on the seed, the participant, the session and the trial, so an interrupted session
/// continues as if it had never been interrupted.
///
/// # Errors
/// Returns the first error of `record`. The response must be on disk when `record` returns.
pub fn simulate<E>(
    session: &mut Session,
    observer: &dyn Observer,
    identity: &Identity,
    start: Duration,
    mut record: impl FnMut(&TrialResponse) -> Result<(), E>,
) -> Result<(), E> {
    let seed = session.schedule().seed;
    let subject: f64 = StandardNormal.sample(&mut stream(seed, &["subject", identity.subject()]));
    let intervals = session.protocol().task.layout().intervals();
    let mut rng = stream(seed, &["trials", identity.subject(), identity.session()]);
    let mut now = start;
    loop {
        let protocol = session.protocol();
        let wait = match session.state() {
            State::Recovery { .. } | State::Closing { .. } => Some(protocol.recovery_duration()),
            State::Gap { .. } => Some(protocol.gap_duration()),
            State::Stimulus { interval, .. } if interval + 1 < intervals => protocol.presentation_duration(),
            _ => None,
        };
        if let Some(wait) = wait {
            now += wait;
            session.step(Event::Frame, now);
            continue;
        }
        let effect = match session.state() {
            State::Done | State::Left => return Ok(()),
            State::Stimulus { .. } | State::Response { .. } => {
                let (Some(trial), Some(shown)) = (session.current(), session.shown()) else { return Ok(()) };
                // Each trial has its own position in the key stream: 64 blocks of 16 words per trial.
                rng.set_word_pos(trial as u128 * 1024);
                let answer = answered(observer, session.protocol(), shown, subject, &mut rng);
                let normal: f64 = StandardNormal.sample(&mut rng);
                now += Duration::from_secs_f64(RESPONSE_MEDIAN_S * (RESPONSE_SIGMA * normal).exp());
                let key = match answer {
                    Answer::Key(key) => key,
                    Answer::Value(value) => {
                        session.step(Event::Adjust(value), now);
                        0
                    }
                };
                session.step(Event::Rate(key), now)
            }
            State::Paused(_) => session.step(Event::Resume, now),
            _ => session.step(Event::Continue, now),
        };
        if let Effect::Record(response) = effect {
            record(&response)?;
            session.step(Event::Stored, now);
        }
    }
}

fn stream(seed: u64, name: &[&str]) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(fnv1a(name.join("\0").as_bytes()));
    rng
}
