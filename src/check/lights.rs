//! Lights near, far, tiny, bright, many.

use crate::check::item::Check;

/// The checks.
pub const CHECKS: &[Check] = &[];

/// Which rows a planted fault must fail.
#[cfg(test)]
pub const FAULTS: &[(crate::fault::Fault, &[&str])] = &[];
