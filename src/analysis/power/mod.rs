//! Power by simulation: how often studies of a given size would find an effect, if people rated as the ordered-logit
//! observer does.
//!
//! A study is simulated as counts, fitted once, and every term is tested against the model without it; Friedman's test
//! is applied to each factor. The proportion of studies that find an existing effect is the power; the proportion that
//! find a nonexistent effect is the false-alarm rate, which should be α. Simulated subjects differ only by a normal
//! intercept: if real people also differ in the size of an effect, power is lower.
//!
//! Random numbers: ChaCha8 seeded with the seed, and a stream for each subject of each study. Results depend neither on
//! the number of threads nor on what else is planned, and a study of 12 is the study of 8 with four more people,
//! so that numbers of participants are compared on the same people.

mod hypothesis;
mod plan;
mod scenario;

pub use hypothesis::{Effect, Hypothesis, Test};
pub use plan::{ModelChoice, Plan, Power, Sampling, clopper_pearson};
pub use scenario::{PlanError, Shift};
