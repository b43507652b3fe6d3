//! The ordinal model that an analysis fits and a plan simulates.

use serde::Serialize;

use crate::{
    analysis::{Link, MAX_COEFFICIENTS, MAX_MINUTES, Slopes, terms::Terms},
    text::names::one_of,
};

/// The ordinal model.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Model {
    /// Terms of the model: names of factors. Prefix a numeric term with num:, and join the factors of an interaction
    /// with : or * [default: every factor that varies].
    #[arg(long, value_name = "T,…")]
    pub terms: Option<Terms>,
    /// Link function of the cumulative model.
    #[arg(long, default_value_t, value_parser = one_of::<Link>(Link::NAMES))]
    pub link: Link,
    /// Random slopes: for each term that varies within participants, where the design supports it (independent), or
    /// with all their correlations (correlated).
    #[arg(long, default_value_t, value_parser = one_of::<Slopes>(Slopes::NAMES))]
    pub slopes: Slopes,
    /// Also analyze a study that is larger than usual: more than 10 factors, 120 levels of a factor, 5,000 conditions,
    /// 20,000 participants, 120 coefficients or 5 minutes of simulated studies, or names of more than 200 bytes. The
    /// time grows with their square or cube.
    #[arg(long)]
    pub large: bool,
}

impl Model {
    /// Returns the maximum number of coefficients.
    pub fn max_coefficients(&self) -> usize {
        if self.large { usize::MAX } else { MAX_COEFFICIENTS }
    }

    /// Returns how many minutes of one processor the simulated studies may take.
    pub fn max_minutes(&self) -> u64 {
        if self.large { u64::MAX } else { MAX_MINUTES }
    }
}
