//! The studies, their sessions, and what can be done with them.
//!
//! | file | contents |
//! |---|---|
//! | [`page`] | the page: the chosen study, its actions and cards |
//! | [`list`], [`grid`] | the studies to choose from; the participants and sessions of one |
//! | [`session`], [`form`] | the dialog that begins a session; its fields and their errors |
//! | [`pilot`], [`jobs`] | the dialogs of a pilot and an export; what runs in the background |

mod form;
mod grid;
mod jobs;
mod list;
mod page;
mod pilot;
mod session;

pub use page::{Destination, Studies};
