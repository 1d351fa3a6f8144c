//! Rays and hits in packets of eight lanes.

use super::here;
use crate::bvh::ray::{HitQueue, HitRows, LONGEST_DIRECTION, RayQueue, RayRows, SHORTEST_DIRECTION};
use here::lanes::{Each, F32x8, Mask8, U32x8, Vec3x8, inlined};

/// Eight rays. A hit counts if `tmin < t <= tmax`, with `t` in units of the direction's length. A ray that is not made of
/// numbers (an origin or direction of infinity or NaN, a `tmin` or `tmax` of NaN) hits nothing, nor does one whose direction's
/// largest component is below 2^-56 or above 2^56.
///
/// ```
/// use octray::{F32x8, Mask8, RayPacket, Scene, Vec3x8};
/// let scene = Scene::load("builtin:heavy:2000")?.prepare()?;
/// let rays = RayPacket {
///     origin: Vec3x8::splat([0.5, 50.0, 0.5]),
///     direction: Vec3x8::splat([0.0, -1.0, 0.0]),
///     tmin: F32x8::ZERO,
///     tmax: F32x8::splat(f32::INFINITY),
/// };
/// let hits = scene.intersect(&rays, Mask8::ALL);
/// println!("distances {:?}, triangles {:?}", hits.t.to_array(), hits.triangle.to_array());
/// # Ok::<(), octray::Error>(())
/// ```
#[derive(Clone, Copy, Default)]
pub struct RayPacket {
    /// Origins, scene units.
    pub origin: Vec3x8,
    /// Directions; the largest component from 2^-56 to 2^56.
    pub direction: Vec3x8,
    /// Where the rays begin (exclusive); 0 or more.
    pub tmin: F32x8,
    /// Where the rays end (inclusive).
    pub tmax: F32x8,
}

impl RayPacket {
    /// Rays `first .. first + 8` of a queue.
    #[inline(always)]
    pub fn load(rays: &RayQueue, first: usize) -> RayPacket {
        let load = |values: &[f32]| F32x8::load(values, first);
        RayPacket {
            origin: Vec3x8::new(load(&rays.ox), load(&rays.oy), load(&rays.oz)),
            direction: Vec3x8::new(load(&rays.dx), load(&rays.dy), load(&rays.dz)),
            tmin: load(&rays.tmin),
            tmax: load(&rays.tmax),
        }
    }

    /// Its fields in their order, vectors by component: what a packet of another level is made of.
    #[inline(always)]
    pub(crate) fn to_rows(self) -> RayRows {
        let (o, d) = (self.origin, self.direction);
        [o.x, o.y, o.z, d.x, d.y, d.z, self.tmin, self.tmax].each(F32x8::to_array)
    }

    /// The packet whose [`RayPacket::to_rows`] are `rows`.
    #[inline(always)]
    pub(crate) fn from_rows(rows: RayRows) -> RayPacket {
        let [ox, oy, oz, dx, dy, dz, tmin, tmax] = rows.each(F32x8::from_array);
        RayPacket { origin: Vec3x8::new(ox, oy, oz), direction: Vec3x8::new(dx, dy, dz), tmin, tmax }
    }

    /// The rays that are made of numbers, with directions in range. Others hit nothing, in any walk; in a packet they would
    /// spoil what is worked out for all its rays at once.
    #[inline(always)]
    pub(crate) fn finite(&self) -> Mask8 {
        let (o, d) = (self.origin.scale(F32x8::ZERO), self.direction.scale(F32x8::ZERO));
        let nothing = ((o.x + o.y) + (o.z + d.x)) + (d.y + d.z);
        let longest = self.direction.abs().max_element();
        let in_range = longest.ge(F32x8::splat(SHORTEST_DIRECTION)) & longest.le(F32x8::splat(LONGEST_DIRECTION));
        nothing.eq(F32x8::ZERO) & in_range & self.tmin.eq(self.tmin) & self.tmax.eq(self.tmax)
    }

    /// Eight rays of which the idle ones are copies of a live one and hit nothing.
    #[inline(always)]
    pub(crate) fn without_garbage(&self, active: Mask8) -> RayPacket {
        if active.all() {
            return *self;
        }
        let first = active.bits().trailing_zeros() as usize & 7;
        let copy = |values: F32x8| active.select(values, F32x8::splat(values.to_array()[first]));
        let copy3 = inlined(
            #[inline(always)]
            |v: Vec3x8| Vec3x8::new(copy(v.x), copy(v.y), copy(v.z)),
        );
        RayPacket {
            origin: copy3(self.origin),
            direction: copy3(self.direction),
            tmin: active.select(self.tmin, F32x8::splat(f32::INFINITY)),
            tmax: active.select(self.tmax, F32x8::splat(f32::NEG_INFINITY)),
        }
    }
}

/// Eight closest hits. A hit is `P = (1-u-v) v0 + u v1 + v v2`. Where nothing is hit: `triangle` is `u32::MAX`, `t` is the
/// ray's `tmax`, `u` and `v` are 0.
///
/// ```
/// use octray::{Mask8, RayPacket, Scene};
/// let scene = Scene::load("builtin:heavy:2000")?.prepare()?;
/// // Idle lanes come back without a hit, whatever they hold.
/// let hits = scene.intersect(&RayPacket::default(), Mask8::NONE);
/// assert!(hits.triangle.to_array().iter().all(|&id| id == u32::MAX));
/// # Ok::<(), octray::Error>(())
/// ```
#[derive(Clone, Copy)]
pub struct HitPacket {
    /// Ray parameters of the hits.
    pub t: F32x8,
    /// Triangle ids, in the file order of the scene.
    pub triangle: U32x8,
    /// Barycentric weights of the second vertices.
    pub u: F32x8,
    /// Barycentric weights of the third vertices.
    pub v: F32x8,
}

impl HitPacket {
    /// Hits `first .. first + 8` of a queue become these.
    #[inline(always)]
    pub fn store(&self, hits: &mut HitQueue, first: usize) {
        self.t.store(&mut hits.t, first);
        self.triangle.store(&mut hits.triangle, first);
        self.u.store(&mut hits.u, first);
        self.v.store(&mut hits.v, first);
    }

    /// Its fields in their order: what a packet of another level is made of.
    #[inline(always)]
    pub(crate) fn to_rows(self) -> HitRows {
        (self.t.to_array(), self.triangle.to_array(), self.u.to_array(), self.v.to_array())
    }

    /// The packet whose [`HitPacket::to_rows`] are `rows`.
    #[inline(always)]
    pub(crate) fn from_rows((t, triangle, u, v): HitRows) -> HitPacket {
        HitPacket {
            t: F32x8::from_array(t),
            triangle: U32x8::from_array(triangle),
            u: F32x8::from_array(u),
            v: F32x8::from_array(v),
        }
    }
}
