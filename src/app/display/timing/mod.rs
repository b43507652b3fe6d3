//! How evenly frames come, measured while something changes with each of them.

mod report;
mod run;
mod tool;

pub use report::TimingReport;
pub use run::{FLICKER_WARNING, Patch, Place, Scene, TimingPage, TimingPlan, TimingRequest};
pub use tool::TimingTool;
