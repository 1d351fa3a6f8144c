//! Rays and hits: single ones, and queues of any length (one array a field); what walks count.

use crate::fault::{Fault, planted};
use crate::lanes::LANES;

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

/// Eight rays, a row of eight lanes a field: origins (x, y, z), directions, `tmin`, `tmax`.
pub(crate) type RayRows = [[f32; LANES]; 8];
/// Eight hits, a row of eight lanes a field: `t`, triangles, `u`, `v`.
pub(crate) type HitRows = ([f32; LANES], [u32; LANES], [f32; LANES], [f32; LANES]);

/// A ray as the one-ray walks take it.
#[derive(Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: [f32; 3],
    pub(crate) direction: [f32; 3],
    pub(crate) tmin: f32,
    pub(crate) tmax: f32,
}

impl Ray {
    /// Whether it is made of numbers and its direction in range, as [`crate::RayPacket`] has it.
    #[inline(always)]
    pub(crate) fn is_finite(&self) -> bool {
        let [[ox, oy, oz], [dx, dy, dz]] = [self.origin, self.direction];
        let nothing = ((ox * 0.0 + oy * 0.0) + (oz * 0.0 + dx * 0.0)) + (dy * 0.0 + dz * 0.0);
        let longest = dx.abs().max(dy.abs()).max(dz.abs());
        let in_range = (SHORTEST_DIRECTION..=LONGEST_DIRECTION).contains(&longest);
        nothing == 0.0 && in_range && !self.tmin.is_nan() && !self.tmax.is_nan()
    }
}

/// The index of the largest of three magnitudes, the lowest on ties; 2 if they are NaN.
#[inline(always)]
pub(crate) fn dominant_axis(x: f32, y: f32, z: f32) -> usize {
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
pub(crate) const PERMUTATION: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The least largest component of a direction. Boxes take components for at least 2^-80, which in a direction of this length
/// bends a ray by less than they are widened; shorter ones would be led past what they hit.
pub const SHORTEST_DIRECTION: f32 = 1.0 / (1u64 << 56) as f32;
/// The greatest one: the parameters of hits are still normal numbers.
pub const LONGEST_DIRECTION: f32 = (1u64 << 56) as f32;

/// A ray's closest hit.
#[derive(Clone, Copy)]
pub(crate) struct Hit {
    pub(crate) t: f32,
    pub(crate) triangle: u32,
    pub(crate) u: f32,
    pub(crate) v: f32,
}

impl Hit {
    /// Nothing hit up to `tmax`.
    #[inline(always)]
    pub(crate) fn none(tmax: f32) -> Self {
        let triangle = if planted(Fault::MissesHit) { 0 } else { NO_HIT };
        Self { t: tmax, triangle, u: 0.0, v: 0.0 }
    }
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
    /// Closest hits, one array a field, padded as [`RayQueue`]; the fields are those of [`crate::HitPacket`].
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

    /// Rows `from .. from + count` of `other` become the rows from `at` on.
    pub(crate) fn copy_rows(&mut self, at: usize, other: &RayQueue, from: usize, count: usize) {
        let RayQueue { ox, oy, oz, dx, dy, dz, tmin, tmax } = self;
        let columns = [(ox, &other.ox), (oy, &other.oy), (oz, &other.oz), (dx, &other.dx), (dy, &other.dy)];
        for (to, of) in columns.into_iter().chain([(dz, &other.dz), (tmin, &other.tmin), (tmax, &other.tmax)]) {
            to[at..at + count].copy_from_slice(&of[from..from + count]);
        }
    }

    /// The ray of one row.
    #[inline(always)]
    pub(crate) fn ray(&self, row: usize) -> Ray {
        Ray {
            origin: [self.ox[row], self.oy[row], self.oz[row]],
            direction: [self.dx[row], self.dy[row], self.dz[row]],
            tmin: self.tmin[row],
            tmax: self.tmax[row],
        }
    }
}

impl HitQueue {
    /// The hit of one row.
    #[inline(always)]
    pub(crate) fn hit(&self, row: usize) -> Hit {
        Hit { t: self.t[row], triangle: self.triangle[row], u: self.u[row], v: self.v[row] }
    }

    /// The hit of one row becomes `hit`.
    #[inline(always)]
    pub(crate) fn set(&mut self, row: usize, hit: Hit) {
        (self.t[row], self.triangle[row], self.u[row], self.v[row]) = (hit.t, hit.triangle, hit.u, hit.v);
    }
}
