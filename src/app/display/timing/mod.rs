//! How evenly frames come, measured while something changes with each of them.

mod page;
mod report;
mod run;
mod scene;
mod tool;

pub use page::{TimingPage, TimingRequest};
pub use report::TimingReport;
pub use run::{FLICKER_WARNING, TimingPlan};
pub use scene::{Patch, Place, Scene};
pub use tool::TimingTool;
