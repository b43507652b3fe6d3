//! What a document consists of.

pub(crate) mod numbers;
