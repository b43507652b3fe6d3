//! The studies, their sessions, and what can be done with them.
//!
//! | file | contents |
//! |---|---|
//! | [`page`] | the page, its state and its dialogs |
//! | [`study`] | what stands around the grid: what can be done with the chosen study, and what is known about it |
//! | [`list`], [`grid`] | the studies to choose from; the participants and sessions of one |
//! | [`session`], [`form`] | the dialog that begins a session; its fields and their errors |
//! | [`jobs`] | the dialogs of a plan, a pilot and an export, and what runs in the background |

mod form;
mod grid;
mod jobs;
mod list;
mod page;
mod session;
mod study;

pub use page::{Destination, Studies};
