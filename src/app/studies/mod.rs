//! The studies, their sessions, and what can be done with them.
//!
//! | file | contents |
//! |---|---|
//! | [`page`] | the page, its state and its dialogs |
//! | [`actions`], [`cards`] | what can be done with the chosen study; what stands beside it |
//! | [`list`], [`grid`] | the studies to choose from; the participants and sessions of one |
//! | [`session`], [`form`] | the dialog that begins a session; its fields and their errors |
//! | [`request_form`], [`jobs`] | the dialogs of a plan, a pilot and an export; what runs in the background |

mod actions;
mod cards;
mod form;
mod grid;
mod jobs;
mod list;
mod page;
mod request_form;
mod session;

pub use page::{Destination, Studies};
