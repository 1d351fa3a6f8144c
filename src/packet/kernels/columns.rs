//! How lanes are read from queues and written to them.

use super::here;
use crate::bvh::ray::RayQueue;
use crate::packet::queues::{Columns3, IndexList, Slots};
use here::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};

/// Vectors, eight at a time.
pub trait VectorLanes {
    /// Rows `first .. first + 8`.
    fn load(&self, first: usize) -> Vec3x8;
    /// The rows named by `indices`.
    fn gather(&self, indices: U32x8) -> Vec3x8;
    /// The lanes of `mask` become the rows from `at` on.
    fn append(&mut self, at: usize, values: Vec3x8, mask: u8);
}

impl VectorLanes for Columns3 {
    #[inline(always)]
    fn load(&self, first: usize) -> Vec3x8 {
        Vec3x8::new(F32x8::load(&self.x, first), F32x8::load(&self.y, first), F32x8::load(&self.z, first))
    }
    #[inline(always)]
    fn gather(&self, indices: U32x8) -> Vec3x8 {
        let column = |c: &[f32]| F32x8::gather(c, indices);
        Vec3x8::new(column(&self.x), column(&self.y), column(&self.z))
    }
    #[inline(always)]
    fn append(&mut self, at: usize, values: Vec3x8, mask: u8) {
        values.x.compress(mask).store(&mut self.x, at);
        values.y.compress(mask).store(&mut self.y, at);
        values.z.compress(mask).store(&mut self.z, at);
    }
}

/// Row numbers, eight at a time.
pub trait RowLanes {
    /// Appends rows `first .. first + 8` where `mask` says so.
    fn append(&mut self, first: usize, mask: u8);
    /// Block `first .. first + 8` of the list: its rows (idle lanes repeat row 0) and the lanes in use.
    fn block(&self, first: usize) -> (U32x8, Mask8);
}

impl RowLanes for IndexList {
    #[inline(always)]
    fn append(&mut self, first: usize, mask: u8) {
        let rows = U32x8::lane_numbers() + U32x8::splat(first as u32);
        rows.compress(mask).store(&mut self.rows, self.len);
        self.len += mask.count_ones() as usize;
    }
    #[inline(always)]
    fn block(&self, first: usize) -> (U32x8, Mask8) {
        let active = Mask8::first((self.len - first).min(LANES));
        (active.select_u32(U32x8::load(&self.rows, first), U32x8::ZERO), active)
    }
}

/// What stays with eight paths.
pub trait SlotLanes {
    /// What roulette goes by becomes `albedo` for the slots in the lanes of `mask`.
    fn set_albedo(&mut self, slot: U32x8, albedo: F32x8, mask: u8);
    /// Adds to the radiance of the slots in the lanes of `mask`, which name each slot at most once.
    fn add(&mut self, slot: U32x8, gain: Vec3x8, mask: u8);
}

impl SlotLanes for Slots {
    #[inline(always)]
    fn set_albedo(&mut self, slot: U32x8, albedo: F32x8, mask: u8) {
        let (slot, albedo) = (slot.to_array(), albedo.to_array());
        let mut rest = mask;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            self.albedo[slot[lane] as usize] = albedo[lane];
        }
    }
    #[inline(always)]
    fn add(&mut self, slot: U32x8, gain: Vec3x8, mask: u8) {
        let (slot, gain) = (slot.to_array(), [gain.x.to_array(), gain.y.to_array(), gain.z.to_array()]);
        let mut rest = mask;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            self.radiance[slot[lane] as usize].add([gain[0][lane], gain[1][lane], gain[2][lane], 0.0]);
        }
    }
}

/// The origins and directions of the lanes of `mask` become rays from `at` on; `tmin` and `tmax` keep what they hold.
#[inline(always)]
pub fn append_rays(rays: &mut RayQueue, at: usize, origin: Vec3x8, direction: Vec3x8, mask: u8) {
    origin.x.compress(mask).store(&mut rays.ox, at);
    origin.y.compress(mask).store(&mut rays.oy, at);
    origin.z.compress(mask).store(&mut rays.oz, at);
    direction.x.compress(mask).store(&mut rays.dx, at);
    direction.y.compress(mask).store(&mut rays.dy, at);
    direction.z.compress(mask).store(&mut rays.dz, at);
}
