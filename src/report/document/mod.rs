//! What a document consists of: sections of blocks, built once and shown by every skin. Their numbers are written as in
//! a paper, by [`numbers`].

mod block;
pub mod numbers;

pub use block::{Block, Document, Section, Table};
