//! The Display pages: the current profile, and the tools that measure the screen.
//!
//! | file | contents |
//! |---|---|
//! | [`tools`] | what is known about the screen, and the list of tools |
//! | [`screen`] | the fields for the screen, and measuring it with a bank card |
//! | [`calibrate`] | what tools share: settings, a run, findings, and the profile to save |
//! | [`photometer`], [`patch_run`] | calibration with a photometer: settings and findings; the patches |
//! | [`sizes`] | whether the luminance depends on the size of a patch |
//! | [`by_eye`], [`match_run`] | matching by eye: settings and findings; the matches |
//! | [`timing`] | whether every refresh shows a new frame |

mod by_eye;
mod calibrate;
mod match_run;
mod patch_run;
mod photometer;
mod screen;
mod sizes;
mod timing;
mod tools;

pub use screen::{CheckedScreen, ScreenForm};
pub use timing::judged_frames;
pub use tools::Display;
