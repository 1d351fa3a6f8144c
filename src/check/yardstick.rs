//! The f64 yardstick: every kernel against itself in f64.

use crate::check::item::Check;

/// The checks.
pub const CHECKS: &[Check] = &[];

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = &[];
