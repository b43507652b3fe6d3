//! The Home page, on which the user chooses the experiment, the participant and the screen.

mod form;
mod home;

pub use form::Form;
pub use home::{Destination, Home};
