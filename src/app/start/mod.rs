//! The start page: the experiments to choose from, the sessions in the results folder, and the form that starts one.

mod cards;
mod form;
mod page;
mod sessions;

pub use page::{Destination, Start};
