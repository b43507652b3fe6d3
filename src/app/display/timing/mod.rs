//! Measures how regular frame intervals are while the content changes in every frame.

mod report;
mod run;
mod tool;

pub use report::TimingReport;
pub use run::{FLICKER_WARNING, Patch, Place, Scene, TimingPage, TimingPlan, TimingRequest};
pub use tool::TimingTool;
