//! Floor −1, the basement: values as words, for people and in files. It uses no other module of this crate.

pub(crate) mod names;
