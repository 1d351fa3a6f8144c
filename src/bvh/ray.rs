//! Rays and hits: single, packets of eight lanes, and queues of any length (one array a field); what walks count.

use crate::fault::{Fault, planted};
use crate::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8};

/// The triangle id of a ray that hits nothing.
pub const NO_HIT: u32 = u32::MAX;
/// Above all ids of triangles, also as a signed number.
pub const ANY_ID: u32 = i32::MAX as u32;

/// What walks count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WalkCounters {
    /// Rays asked about.
    pub rays: u64,
    /// Rays that took part in the steps (nodes, leaves) of packet walks.
    pub lanes_used: u64,
    /// Rays that could have: eight or sixteen times the steps, as many as a walk follows together.
    pub lanes_possible: u64,
}

/// A ray as the one-ray walks take it.
#[derive(Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: [f32; 3],
    pub(super) direction: [f32; 3],
    pub(super) tmin: f32,
    pub(super) tmax: f32,
}

impl Ray {
    /// Whether it is made of numbers and its direction in range, as [`RayPacket::finite`] has it.
    #[inline(always)]
    pub(super) fn is_finite(&self) -> bool {
        let [[ox, oy, oz], [dx, dy, dz]] = [self.origin, self.direction];
        let nothing = ((ox * 0.0 + oy * 0.0) + (oz * 0.0 + dx * 0.0)) + (dy * 0.0 + dz * 0.0);
        let longest = dx.abs().max(dy.abs()).max(dz.abs());
        let in_range = (SHORTEST_DIRECTION..=LONGEST_DIRECTION).contains(&longest);
        nothing == 0.0 && in_range && !self.tmin.is_nan() && !self.tmax.is_nan()
    }
}

/// The index of the largest of three magnitudes, the lowest on ties; 2 if they are NaN.
#[inline(always)]
pub(super) fn dominant_axis(x: f32, y: f32, z: f32) -> usize {
    let (x, y, z) = (x.abs(), y.abs(), z.abs());
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// `[kx, ky, kz]` by `kz`.
pub(super) const PERMUTATION: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The least largest component of a direction. Boxes take components for at least 2^-80, which in a direction of this length
/// bends a ray by less than they are widened; shorter ones would be led past what they hit.
pub const SHORTEST_DIRECTION: f32 = 1.0 / (1u64 << 56) as f32;
/// The greatest one: the parameters of hits are still normal numbers.
pub const LONGEST_DIRECTION: f32 = (1u64 << 56) as f32;

/// A ray's closest hit.
#[derive(Clone, Copy)]
pub(super) struct Hit {
    pub(super) t: f32,
    pub(super) triangle: u32,
    pub(super) u: f32,
    pub(super) v: f32,
}

impl Hit {
    /// Nothing hit up to `tmax`.
    #[inline(always)]
    pub(super) fn none(tmax: f32) -> Self {
        let triangle = if planted(Fault::MissesHit) { 0 } else { NO_HIT };
        Self { t: tmax, triangle, u: 0.0, v: 0.0 }
    }
}

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
    /// The rays that are made of numbers, with directions in range. Others hit nothing, in any walk; in a packet they would spoil what is worked out
    /// for all its rays at once.
    #[inline(always)]
    pub(super) fn finite(&self) -> Mask8 {
        let (o, d) = (self.origin.scale(F32x8::ZERO), self.direction.scale(F32x8::ZERO));
        let nothing = ((o.x + o.y) + (o.z + d.x)) + (d.y + d.z);
        let longest = self.direction.abs().max_element();
        let in_range = longest.ge(F32x8::splat(SHORTEST_DIRECTION)) & longest.le(F32x8::splat(LONGEST_DIRECTION));
        nothing.eq(F32x8::ZERO) & in_range & self.tmin.eq(self.tmin) & self.tmax.eq(self.tmax)
    }

    /// Eight rays of which the idle ones are copies of a live one and hit nothing.
    #[inline(always)]
    pub(super) fn without_garbage(&self, active: Mask8) -> RayPacket {
        if active.all() {
            return *self;
        }
        let first = active.bits().trailing_zeros() as usize & 7;
        let copy = |values: F32x8| active.select(values, F32x8::splat(values.to_array()[first]));
        let copy3 = |v: Vec3x8| Vec3x8::new(copy(v.x), copy(v.y), copy(v.z));
        RayPacket {
            origin: copy3(self.origin),
            direction: copy3(self.direction),
            tmin: active.select(self.tmin, F32x8::splat(f32::INFINITY)),
            tmax: active.select(self.tmax, F32x8::splat(f32::NEG_INFINITY)),
        }
    }
}

/// Eight closest hits. A hit is `P = (1-u-v) v0 + u v1 + v v2`. Where nothing is hit: `triangle` is [`NO_HIT`], `t` is the
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

macro_rules! columns {
    ($(#[$doc:meta])* $name:ident { $($(#[$fdoc:meta])* $field:ident: $type:ty = $fill:expr,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default)]
        pub struct $name {
            $($(#[$fdoc])* pub $field: Vec<$type>,)*
        }
        impl $name {
            /// Room for `len` rows, rounded up to whole blocks of 8 plus one spare block, filled with neutral values.
            pub fn with_len(len: usize) -> Self {
                let mut queue = Self::default();
                queue.resize(len);
                queue
            }
            /// Makes room for `len` rows as [`Self::with_len`] does; rows that are there keep their values.
            pub fn resize(&mut self, len: usize) {
                let padded = len.next_multiple_of(LANES) + LANES;
                $(self.$field.resize(padded, $fill);)*
            }
        }
    };
}

columns! {
    /// Rays, one array a field, padded to whole blocks of 8 lanes plus a spare one. How many of them are rays is the
    /// caller's to say: the padding holds harmless rays (origin 0, direction +x, `tmax` infinite) unless overwritten.
    ///
    /// ```
    /// use octray::{HitQueue, RayQueue, Scene};
    /// let scene = Scene::load("builtin:heavy:2000")?.prepare()?;
    /// let mut rays = RayQueue::with_len(1000);
    /// for i in 0..1000 {
    ///     (rays.ox[i], rays.oy[i], rays.dx[i], rays.dy[i]) = (i as f32 * 0.001, 50.0, 0.0, -1.0);
    /// }
    /// let mut hits = HitQueue::default();
    /// scene.intersect_stream(&rays, &mut hits);
    /// let mut blocked = Vec::new();
    /// scene.occluded_stream(&rays, &mut blocked);
    /// assert_eq!(hits.triangle[7] != u32::MAX, blocked[0] >> 7 & 1 == 1);
    /// # Ok::<(), octray::Error>(())
    /// ```
    RayQueue {
        /// Origins, x.
        ox: f32 = 0.0,
        /// Origins, y.
        oy: f32 = 0.0,
        /// Origins, z.
        oz: f32 = 0.0,
        /// Directions, x.
        dx: f32 = 1.0,
        /// Directions, y.
        dy: f32 = 0.0,
        /// Directions, z.
        dz: f32 = 0.0,
        /// Where the rays begin (exclusive).
        tmin: f32 = 0.0,
        /// Where the rays end (inclusive).
        tmax: f32 = f32::INFINITY,
    }
}

columns! {
    /// Closest hits, one array a field, padded as [`RayQueue`]; the fields are those of [`HitPacket`].
    HitQueue {
        /// Ray parameters of the hits.
        t: f32 = 0.0,
        /// Triangle ids, [`NO_HIT`] where nothing is hit.
        triangle: u32 = NO_HIT,
        /// Barycentric weights of the second vertices.
        u: f32 = 0.0,
        /// Barycentric weights of the third vertices.
        v: f32 = 0.0,
    }
}

impl RayQueue {
    /// Rows in whole blocks, padding included, the spare block not.
    pub fn len(&self) -> usize {
        self.ox.len().saturating_sub(LANES)
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The ray of one row.
    #[inline(always)]
    pub(super) fn ray(&self, row: usize) -> Ray {
        Ray {
            origin: [self.ox[row], self.oy[row], self.oz[row]],
            direction: [self.dx[row], self.dy[row], self.dz[row]],
            tmin: self.tmin[row],
            tmax: self.tmax[row],
        }
    }

    /// Rays `first .. first + 8`.
    #[inline(always)]
    pub fn packet(&self, first: usize) -> RayPacket {
        let load = |values: &[f32]| F32x8::load(values, first);
        RayPacket {
            origin: Vec3x8::new(load(&self.ox), load(&self.oy), load(&self.oz)),
            direction: Vec3x8::new(load(&self.dx), load(&self.dy), load(&self.dz)),
            tmin: load(&self.tmin),
            tmax: load(&self.tmax),
        }
    }
}

impl HitQueue {
    /// The hit of one row.
    #[inline(always)]
    pub(super) fn hit(&self, row: usize) -> Hit {
        Hit { t: self.t[row], triangle: self.triangle[row], u: self.u[row], v: self.v[row] }
    }

    /// The hit of one row becomes `hit`.
    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, hit: Hit) {
        (self.t[row], self.triangle[row], self.u[row], self.v[row]) = (hit.t, hit.triangle, hit.u, hit.v);
    }

    /// Hits `first .. first + 8` become those of `packet`.
    #[inline(always)]
    pub fn set_packet(&mut self, first: usize, packet: &HitPacket) {
        packet.t.store(&mut self.t, first);
        packet.triangle.store(&mut self.triangle, first);
        packet.u.store(&mut self.u, first);
        packet.v.store(&mut self.v, first);
    }
}
