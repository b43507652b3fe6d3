//! The page on which a definition is duplicated and edited without a text editor. [`Draft`](crate::store::draft::Draft)
//! keeps the comments and the layout of the original.
//!
//! | file | contents |
//! |---|---|
//! | [`page`] | the page: leaving it, saving, the summary |
//! | [`form`] | the draft, what was typed, and the errors of each field |
//! | [`sections`], [`task`] | the fields; those of the task, its method and its answers |
//! | [`preview`] | one trial, and the stimuli of all conditions |

mod form;
mod page;
mod preview;
mod sections;
mod task;

pub use page::Editor;
pub use preview::Thumbnails;
