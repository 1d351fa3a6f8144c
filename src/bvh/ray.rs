//! Rays and hits as tables: packets of eight lanes, and queues of any length (one array a field).

use crate::lanes::{F32x8, LANES, U32x8, Vec3x8};

/// The triangle id of a ray that hits nothing.
pub const NO_HIT: u32 = u32::MAX;

/// Eight rays. A hit counts if `tmin < t <= tmax`, with `t` in units of the direction's length. A ray that is not made of
/// numbers (an origin or direction of infinity or NaN, a `tmin` or `tmax` of NaN) hits nothing.
#[derive(Clone, Copy, Default)]
pub struct RayPacket {
    /// Origins, scene units.
    pub origin: Vec3x8,
    /// Directions; any finite length but 0.
    pub direction: Vec3x8,
    /// Where the rays begin (exclusive); 0 or more.
    pub tmin: F32x8,
    /// Where the rays end (inclusive).
    pub tmax: F32x8,
}

/// Eight closest hits. A hit is `P = (1-u-v) v0 + u v1 + v v2`. Where nothing is hit: `triangle` is [`NO_HIT`], `t` is the
/// ray's `tmax`, `u` and `v` are 0.
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
    /// Hits `first .. first + 8` become those of `packet`.
    #[inline(always)]
    pub fn set_packet(&mut self, first: usize, packet: &HitPacket) {
        packet.t.store(&mut self.t, first);
        packet.triangle.store(&mut self.triangle, first);
        packet.u.store(&mut self.u, first);
        packet.v.store(&mut self.v, first);
    }
}
