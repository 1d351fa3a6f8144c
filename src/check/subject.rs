//! What applies to a scene of the user's: properties of the input are remarks, never failures.

use crate::check::item::SceneCheck;

/// The checks.
pub const CHECKS: &[SceneCheck] = &[];
