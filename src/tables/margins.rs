//! How far off a triangle, and off its edges, rays must start.
//!
//! The point is a sum of corners, and the triangle test of the next ray sees the corners moved: both err by half-ulps of the
//! corners' coordinates. For common triangles offsets follow all coordinates: at no more than 512 times the size of what lies
//! there (else the triangle is huge) that is 1e-4 of a tenth of it, and rays then start outside the box they leave, which
//! spares a tenth of all visits to leaves. Of triangles that are tested in f64 ([`crate::bvh::precise`]) only the rounding of
//! the point counts, and of that only what lies along the normal: rays may leave a floor of any size at y = 0 from y = 0.
//!
//! Barycentric weights, and `t` with them, are off by 2^-24 times the aspect (longest edge over height) of a triangle, that is
//! more along a long edge: half the aspect times that edge is added. Measured: a closed prism of aspect 500 lost 4.7 % of its
//! rays at every bounce while slivers had no offset of their own (and none now that it is tested in f64), a tilted corridor of
//! 1 x 1 x 10 lost 8e-7 while only slivers beyond an aspect of 16 had one.

use glam::DVec3;

/// [`Margins::offset`] of triangles that are tested in f64.
pub const PRECISE_OFFSET: f32 = -1.0;

/// How many half-ulps of their coordinates points are kept off the edges: see [`Margins::inset`].
const INSET_HALF_ULPS: f64 = 32.0;

/// The largest inset: at f32's half-ulp of 2^-24 a weight of 1/16.
const LARGEST_INSET: f64 = (1u32 << 20) as f64;

/// Margins of one triangle; shading multiplies them with its half-ulp (2^-24 in f32).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// What the triangle's shape adds to the offset of rays, scene units; or [`PRECISE_OFFSET`].
    pub offset: f32,
    /// The least barycentric weight of a point that rays leave: it then keeps 32 half-ulps of its coordinates, as far as they
    /// reach across the edge, off every edge, so that rounding does not put it behind the wall that meets it there. Points
    /// elsewhere do not move (drawing all of them towards the centre was tried: on a ground of 9,000 units it moved
    /// them by 0.07). Measured at 10 and 1,000 scene sizes from the origin, rays lost at every bounce in a closed
    /// mesh without and with it: a box 3e-7 and 3e-5, then none of 2.6e7; a corner of 45 degrees 1e-5 and 9e-4, then
    /// none; of 10 degrees 4e-6 and 4e-4, then 8e-7 and 7e-5. 0 for triangles that are tested in f64: there it is kept in f64.
    pub inset: f32,
}

impl Margins {
    /// The margins of a triangle of positive area; `precise`: it is tested in f64.
    pub fn of(vertices: [[f32; 3]; 3], precise: bool) -> Margins {
        let v = vertices.map(|v| DVec3::from(v.map(f64::from)));
        let edges: [DVec3; 3] = std::array::from_fn(|i| v[(i + 2) % 3] - v[(i + 1) % 3]);
        let double_area = edges[0].cross(edges[1]);
        let longest = edges.iter().map(|edge| edge.length()).fold(0.0, f64::max);
        let aspect = longest * longest / double_area.length();
        let inset = edges.iter().map(|edge| {
            // Coordinates across the edge, over the height on it.
            let across = double_area.cross(*edge).normalize().abs();
            let reach = v.iter().map(|v| across.dot(v.abs())).fold(0.0, f64::max);
            INSET_HALF_ULPS * reach * edge.length() / double_area.length()
        });
        Margins {
            offset: if precise { PRECISE_OFFSET } else { (0.5 * aspect * longest) as f32 },
            inset: if precise { 0.0 } else { inset.fold(0.0, f64::max).min(LARGEST_INSET) as f32 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn right_angled(width: f32, at: f32) -> [[f32; 3]; 3] {
        [[at, 0.0, 0.0], [at + 1.0, 0.0, 0.0], [at, width, 0.0]]
    }

    #[test]
    fn offsets_grow_with_the_aspect() {
        let offset = |width| Margins::of(right_angled(width, 0.0), false).offset;
        assert!((offset(1.0) - 2f32.sqrt()).abs() < 1e-6 && (offset(0.025) - 20.0).abs() < 0.1);
        assert_eq!(Margins::of(right_angled(1e-6, 0.0), true).offset, PRECISE_OFFSET);
    }

    #[test]
    fn insets_grow_with_the_coordinates_across_the_edges_up_to_a_sixteenth() {
        assert!((Margins::of(right_angled(1.0, 7.0), false).inset - 256.0).abs() < 1e-3);
        // A corridor of width 1, however long, keeps points off its walls by the rounding of its width.
        let wall = |length: f32| [[0.5, -0.5, -length], [0.5, 0.5, -length], [0.5, 0.5, length]];
        for length in [1.0, 1e3, 1e6] {
            assert!(Margins::of(wall(length), false).inset < 33.0, "{length}");
            assert_eq!(Margins::of(wall(length), true).inset, 0.0, "{length}");
        }
        assert_eq!(Margins::of(right_angled(1.0, 1e7), false).inset, LARGEST_INSET as f32);
    }
}
