//! Home: what is to be run, for whom, on which screen.

mod form;
mod home;

pub use form::Form;
pub use home::{Destination, Home};
