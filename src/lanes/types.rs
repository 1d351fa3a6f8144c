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
///
/// ```
/// use octray::{F32x8, Mask8};
/// let lanes = F32x8::from_array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
/// let large = lanes.gt(F32x8::splat(4.5));
/// assert_eq!((large.bits(), large.count()), (0b1110_0000, 3));
/// assert!((large & Mask8::first(6)).any());
/// ```
#[derive(Clone, Copy, Default)]
#[repr(transparent)]
pub struct Mask8(pub(super) f32x8);

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
