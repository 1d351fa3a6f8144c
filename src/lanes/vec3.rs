//! Eight vectors of three components.

use super::types::F32x8;
use std::ops::{Add, Mul, Neg, Sub};

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

impl Vec3x8 {
    /// From its components.
    #[inline(always)]
    pub fn new(x: F32x8, y: F32x8, z: F32x8) -> Self {
        Self { x, y, z }
    }
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: [f32; 3]) -> Self {
        Self { x: F32x8::splat(v[0]), y: F32x8::splat(v[1]), z: F32x8::splat(v[2]) }
    }
    /// `x x' + y y' + z z'`, added from left to right as glam's scalar `Vec3` does.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F32x8 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    /// Cross product, in the operation order of glam's scalar `Vec3`.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }
    /// Every component times `factor`.
    #[inline(always)]
    pub fn scale(self, factor: F32x8) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
    /// Absolute value of every component.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }
    /// The largest component, as `max(max(x, y), z)`.
    #[inline(always)]
    pub fn max_element(self) -> F32x8 {
        self.x.max(self.y).max(self.z)
    }
}

macro_rules! vec3_operator {
    ($trait:ident, $function:ident) => {
        impl $trait for Vec3x8 {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self { x: self.x.$function(other.x), y: self.y.$function(other.y), z: self.z.$function(other.z) }
            }
        }
    };
}
vec3_operator!(Add, add);
vec3_operator!(Sub, sub);
vec3_operator!(Mul, mul);

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
