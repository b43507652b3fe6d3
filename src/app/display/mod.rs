//! The display: what is known of the screen, and the tools that find it out. One tool a file or folder.
//!
//! | room | what |
//! |---|---|
//! | [`tools`] | the profile in use and the list of tools |
//! | [`geometry`], [`card`] | size and distance; a card as a ruler |
//! | [`photometer`], [`matching`] | the light of each code, with a photometer or by eye |
//! | [`calibrate`] | what these two have in common |
//! | [`signs`] | the minus sign of print |
//! | [`check`] | fields that show whether a profile is right |
//! | [`steps`] | steps of equal brightness |
//! | [`timing`] | whether frames follow the screen's refresh |

mod calibrate;
mod card;
mod check;
mod geometry;
mod matching;
mod photometer;
mod signs;
mod steps;
pub mod timing;
mod tools;

pub use card::{CardHelper, CardOutcome};
pub use tools::Display;
