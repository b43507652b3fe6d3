//! The normal distribution's one number that every floor needs.

/// Standard errors from an estimate to either end of its 95 % interval: the 97.5 % quantile of the normal distribution.
pub const Z_95: f64 = 1.959_963_984_540_054;
