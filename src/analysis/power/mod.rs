//! Power by simulation: how often studies of a given size would find an effect if people rated like the ordered-logit
//! observer.
//!
//! Each study is simulated as counts and fitted once, with the same random slopes as in an analysis. Every term is tested
//! against the model without it, and Friedman's test is applied to each factor. The proportion of studies that find an
//! existing effect is the power; the proportion that find a nonexistent effect is the false-alarm rate, which should be α.
//! Simulated participants differ by a normal intercept and, for each [`Slope`], by a normal deviation at each level of a
//! factor: the more people differ in the size of an effect, the lower the power.
//!
//! With few participants, likelihood ratios do not have a χ² distribution. Below
//! [`FEW_FOR_LIKELIHOOD_RATIOS`](crate::analysis::FEW_FOR_LIKELIHOOD_RATIOS) people, their p values come from simulated
//! studies without the effect, once for each term and number of participants.
//!
//! Random numbers come from ChaCha8, initialized with the seed, with a separate stream for each participant in each
//! study. Results depend neither on the number of threads nor on what else is planned. A study of 12 people consists of the study of 8 and four more people, so
//! different numbers of participants are compared on the same people.

mod plan;
mod scenario;

pub use plan::{Plan, Power, Sampling};
pub use scenario::{Effect, Hypothesis, PlanError, Scenario, Shift, Slope, Test};
