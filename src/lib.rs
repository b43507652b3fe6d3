//! machband: measure, analyze, generate and predict the visibility of Mach bands.
//!
//! **Scope.** Full-screen experiments on Mach bands and related stimuli (ratings, thresholds, comparisons of pairs,
//! adjustment), their exact images, and their data; a model of vision; shaders for meshes that avoid the bands. **Not in
//! scope**: reaction times, other modalities, and anything over a network.
//!
//! **Units.** Light is linear and relative to the screen's maximum, 0…1, unless a name says `encoded` or `code`. Angles
//! are in degrees; visual angles are labeled as such. Lengths on the screen are physical pixels or cm. Times are
//! seconds or [`std::time::Duration`]. Widths of a ramp are proportions of the stimulus window.
//!
//! **Architecture.** A module uses only modules with a lower floor number:
//!
//! | floor | module | contents |
//! |---|---|---|
//! | −1 | [`text`] | values as words, "did you mean …?", and tables of typed values |
//! | −1 | [`system`] | the clock, threads, signals, folders and fonts of the operating system |
//! | 0 | [`statistics`] | intervals, quantiles, tail probabilities, correction for multiple testing, random orders |
//! | 0 | [`light`] | interpolation I_n, transfer functions, conversion of light to codes, images |
//! | 1 | [`display`] | visual angle, cm and pixels; the properties of a screen |
//! | 1 | [`shading`] | meshes, illumination, shaders, and jumps in the slope of their light |
//! | 1 | [`vision`] | predicts whether people can tell one picture from another |
//! | 2 | [`stimulus`] | validated descriptions of stimuli, their images, and predictions for them |
//! | 3 | [`experiment`] | experiment definitions, trial order, sessions, records, observers |
//! | 4 | [`analysis`] | ordinal models and tests of counts of ratings; psychometric functions, d′ and scales |
//! | 4 | [`store`] | every file format |
//! | 5 | [`report`] | tables, figures and study reports |
//! | 6 | [`work`] | what machband can do: one file per operation; a request in, a typed outcome out |
//! | 7–12 | [`app`] | the window, whose own modules have these floors |
//! | 12 | [`cli`] | the commands, of which `run` uses the window |
//!
//! Sources: Bangay, *Methods of Reducing the Visibility of Mach Bands during Gouraud Shading*; Shoaff,
//! *Color, Illumination Models, and Shading*.

// Both panic if the stream is closed or the disk behind it is full; `report::terminal::message` and `cli::print_line`
// do not.
#![deny(clippy::print_stdout, clippy::print_stderr)]
// They take an error for an absence; see `clippy.toml`.
#![deny(clippy::disallowed_methods)]

pub mod analysis;
#[cfg(feature = "window")]
pub mod app;
pub mod cli;
pub mod display;
pub mod experiment;
pub mod light;
pub mod report;
pub mod shading;
pub mod statistics;
pub mod stimulus;
pub mod store;
pub mod system;
pub mod text;
pub mod vision;
pub mod work;
