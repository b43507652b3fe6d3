//! All channels together: the display's transfer functions, and what speaks against them.

use std::fmt;

use super::{
    Channel,
    fit::{FitError, GammaFit, GogFit, MatchedLevel, Spread},
    observation::{Judgement, Observation},
    plan::Plan,
};
use crate::light::{Transfer, TransferError, Transfers};

/// Difference threshold above which an observer is not sure enough, as a share of the light.
const LARGEST_THRESHOLD: f64 = 0.1;
/// Half-width of the 95 % interval of γ above which a channel should be measured again.
const WIDEST: f64 = 0.1;
/// Standard errors beyond which a level disagrees with the γ of its channel.
const FARTHEST_Z: f64 = 3.0;
/// χ² of one degree of freedom at 0.1 %: from here on an offset is taken for real.
const OFFSET_CHI_SQUARED: f64 = 10.828;

/// What the answers of one channel give.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelEstimate {
    /// Which.
    pub channel: Channel,
    /// γ with its spread, or why there is none.
    pub fit: Result<GammaFit, FitError>,
    /// The difference threshold as a share of the light, by the answers of this channel alone; that of
    /// [`ChannelEstimate::fit`] is by those of all.
    pub own_threshold: Option<f64>,
    /// What each level says by itself; empty where there is no γ.
    pub levels: Vec<MatchedLevel>,
    /// An offset, where the answers are much likelier with one.
    pub offset: Option<GogFit>,
    /// Plain differences that were shown, and how many were judged wrongly.
    pub catches: [usize; 2],
}

/// What speaks against an estimate.
#[derive(Clone, Debug, PartialEq)]
pub enum Doubt {
    /// There is no γ.
    None(Channel, FitError),
    /// Plain differences were judged wrongly: channel, how many, of how many.
    Missed(Channel, usize, usize),
    /// The observer tells brighter from darker only at large differences: the threshold as a share.
    Unsure(Channel, f64),
    /// The interval is wide: ± this much.
    Wide(Channel, f64),
    /// A level disagrees with the γ: its light share, and how much more light the γ gives it, as a share.
    Disagrees(Channel, f64, f64),
    /// A power with an offset is much likelier than one without.
    Offset(Channel, GogFit),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::None(channel, error) => write!(f, "{channel}: no gamma: {error}."),
            Doubt::Missed(channel, missed, of) => {
                write!(f, "{channel}: {missed} of {of} plain differences were judged wrongly; match it again.")
            }
            Doubt::Unsure(channel, threshold) => write!(
                f,
                "{channel}: differences below {:.0} % were guessed; sit so that the rows blend, and match it again.",
                threshold * 100.0
            ),
            Doubt::Wide(channel, half) => write!(f, "{channel}: gamma is known only to ± {half:.2}; match it again."),
            Doubt::Disagrees(channel, share, excess) => write!(
                f,
                "{channel}: at {:.0} % of full light this gamma is {:.1} % too {}: the screen is not an exact power.",
                share * 100.0,
                excess.abs() * 100.0,
                if *excess > 0.0 { "bright" } else { "dark" }
            ),
            Doubt::Offset(channel, fit) => write!(
                f,
                "{channel}: gamma {:.2} with an offset of {:+.3} explains the answers much better (χ² {:.1}).",
                fit.gamma, fit.offset, fit.chi_squared
            ),
        }
    }
}

/// A channel by its own answers.
type Alone = Result<GammaFit, FitError>;

impl ChannelEstimate {
    fn new(channel: Channel, plan: &Plan, own: &[Observation], alone: &Alone, spread: &Spread) -> Self {
        let fit = alone.and_then(|_| GammaFit::new(own, spread));
        let levels = fit.map_or_else(|_| Vec::new(), |fit| MatchedLevel::of_all(own, plan, &fit));
        let offset = fit.ok().and_then(|fit| GogFit::new(own, &fit));
        let gamma = fit.map_or(Transfer::Srgb, |fit| Transfer::Gamma(fit.gamma));
        let catches: Vec<bool> = own.iter().filter_map(|o| o.missed(&gamma)).collect();
        let missed = catches.iter().filter(|missed| **missed).count();
        Self {
            channel,
            fit,
            own_threshold: alone.ok().map(|fit| fit.threshold()),
            levels,
            offset: offset.filter(|fit| fit.chi_squared > OFFSET_CHI_SQUARED),
            catches: [catches.len(), missed],
        }
    }

    /// What speaks against this channel's γ.
    #[must_use]
    pub fn doubts(&self) -> Vec<Doubt> {
        let channel = self.channel;
        let fit = match &self.fit {
            Ok(fit) => fit,
            Err(error) => return vec![Doubt::None(channel, *error)],
        };
        let mut doubts = Vec::new();
        let [shown, missed] = self.catches;
        if missed > 0 {
            doubts.push(Doubt::Missed(channel, missed, shown));
        }
        let threshold = self.own_threshold.map_or(fit.threshold(), |own| own.max(fit.threshold()));
        if threshold > LARGEST_THRESHOLD {
            doubts.push(Doubt::Unsure(channel, threshold));
        }
        let half = (fit.interval[1] - fit.interval[0]) / 2.0;
        if half > WIDEST {
            doubts.push(Doubt::Wide(channel, half));
        }
        let apart = self.levels.iter().filter(|level| level.z.abs() > FARTHEST_Z);
        doubts.extend(apart.map(|level| Doubt::Disagrees(channel, level.share, level.excess)));
        doubts.extend(self.offset.map(|fit| Doubt::Offset(channel, fit)));
        doubts
    }

    /// The channel as a transfer function, γ rounded to what a profile is to say: with the offset where there is one.
    ///
    /// # Errors
    /// When a γ lies outside what a display could have.
    fn transfer(&self) -> Option<Result<Transfer, TransferError>> {
        let rounded = |value: f64| (value * 1e3).round() / 1e3;
        let fit = self.fit.ok()?;
        Some(match self.offset {
            Some(gog) => Transfer::gog(rounded(gog.gamma), rounded(1.0 - gog.offset), rounded(gog.offset)),
            None => Transfer::gamma(rounded(fit.gamma)),
        })
    }
}

/// What a run gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// In the order of the plan.
    pub channels: Vec<ChannelEstimate>,
    /// Answers in all.
    pub answers: usize,
    /// Whether the answers came by slider.
    pub by_slider: bool,
}

/// γ of each channel of the plan from the answers of a run, in any order.
#[must_use]
pub fn estimate(plan: &Plan, observations: &[Observation]) -> Estimates {
    let own = |channel: &Channel| -> Vec<Observation> {
        observations.iter().filter(|o| o.stimulus.channel == *channel).copied().collect()
    };
    let own: Vec<_> = plan.channels.iter().map(own).collect();
    let alone: Vec<Alone> = own.iter().map(|own| GammaFit::new(own, &Spread::default())).collect();
    // One observer: what one channel tells of the spread holds for the others.
    let spread = |but: usize| {
        let others = alone.iter().enumerate().filter(|(i, _)| *i != but);
        let fitted = others.filter_map(|(i, fit)| Some((&own[i], fit.ok()?.gamma)));
        fitted.fold(Spread::default(), |spread, (own, gamma)| spread.and(own, gamma))
    };
    let one = |(i, channel): (usize, &Channel)| ChannelEstimate::new(*channel, plan, &own[i], &alone[i], &spread(i));
    let channels = plan.channels.iter().enumerate().map(one).collect();
    let by_slider = observations.iter().any(|o| o.judgement == Judgement::Matched);
    Estimates { channels, answers: observations.len(), by_slider }
}

impl Estimates {
    /// One channel.
    #[must_use]
    pub fn of(&self, channel: Channel) -> Option<&ChannelEstimate> {
        self.channels.iter().find(|estimate| estimate.channel == channel)
    }

    /// The display's transfer functions: of red, green and blue where all were matched, else that of gray for the three.
    /// `None` where a channel is missing or has no γ.
    #[must_use]
    pub fn transfers(&self) -> Option<Transfers> {
        let of = |channel| self.of(channel)?.transfer()?.ok();
        match (of(Channel::Red), of(Channel::Green), of(Channel::Blue)) {
            (Some(red), Some(green), Some(blue)) => Some(Transfers::new([red, green, blue])),
            _ => of(Channel::Gray).map(Transfers::from),
        }
    }

    /// For [`Measurement::with`](crate::display::Measurement::with): with what the screen was measured.
    #[must_use]
    pub fn with(&self) -> String {
        let (method, what) = if self.by_slider { ("slider", "matches") } else { ("staircase", "answers") };
        format!("visual nulling by {method}, {} {what}", self.answers)
    }

    /// What speaks against the estimates.
    #[must_use]
    pub fn doubts(&self) -> Vec<Doubt> {
        self.channels.iter().flat_map(ChannelEstimate::doubts).collect()
    }
}
