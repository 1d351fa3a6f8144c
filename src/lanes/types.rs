//! The types, and how an operator of theirs is that of `wide`; what else they can do is in a file each.

use wide::{f32x8, u32x8};

/// Lanes in a packet.
pub const LANES: usize = 8;

/// Eight `f32`.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct F32x8(pub(super) f32x8);

/// Eight `u32`; arithmetic wraps.
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct U32x8(pub(super) u32x8);

/// Eight booleans, kept as vectors: every lane is all ones (true) or all zeros (false).
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct Mask8(pub(super) f32x8);

/// Eight vectors, one array a component.
#[derive(Clone, Copy, Default)]
pub struct Vec3x8 {
    /// First components.
    pub x: F32x8,
    /// Second components.
    pub y: F32x8,
    /// Third components.
    pub z: F32x8,
}

macro_rules! binary_operator {
    ($type:ident, $trait:ident, $function:ident) => {
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(self.0.$function(other.0))
            }
        }
    };
}
pub(super) use binary_operator;
