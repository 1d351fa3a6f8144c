//! What the shape of a triangle adds to the care with which rays leave it.
//!
//! The triangle test finds `t` from barycentric weights. Their rounding error is 2^-24 times the triangle's *aspect*
//! (longest edge over height), so on a sliver `t` is off by up to 2^-24 x longest edge x aspect: a ray may then hit
//! the triangle it has just left, from the wrong side, and go on behind it. Measured: a closed prism of aspect 500
//! lost 4.7 % of its rays at every bounce while slivers had no offset of their own; with half that bound as offset it
//! loses 4e-7. Of 1.5 million bounces in a staircase with mouldings of aspect 1,500, 982 hit the triangle they left,
//! now 8 (aspect 6,000 and more); in Sponza 57 of 0.74 million, now none.

use glam::DVec3;

/// Triangles up to this aspect need nothing beyond the common offset: it covers half of 16 longest edges.
const PLAIN_ASPECT: f64 = 16.0;

/// How many half-ulps points are kept off the edges: see [`Margins::inset`].
const INSET_HALF_ULPS: f64 = 32.0;

/// The largest inset: at f32's half-ulp of 2^-24 a weight of 1/16. Met by triangles 3e4 times smaller than their
/// coordinates.
const LARGEST_INSET: f64 = (1u32 << 20) as f64;

/// Margins of one triangle; shading multiplies them with its half-ulp (2^-24 in f32).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Scene units that slivers add to the offset of rays; 0 for triangles of ordinary shape. Never more than an
    /// eighth of the height once multiplied with 2^-24: beyond an aspect of about 2,000 f32 cannot have both, and
    /// false hits come back (at 5,000 1.3e-3 of the rays, 11 % without).
    pub sliver: f32,
    /// The least barycentric weight of a point that rays leave: it then keeps 32 half-ulps off the edges of a
    /// triangle of ordinary shape, so that rounding does not put it behind the wall that meets it there. Points
    /// elsewhere do not move (drawing all of them towards the centre was tried: on a ground of 9,000 units it moved
    /// them by 0.07). Measured at 10 and 1,000 scene sizes from the origin, rays lost at every bounce in a closed
    /// mesh without and with it: a box 3e-7 and 3e-5, then none of 2.6e7; a corner of 45 degrees 1e-5 and 9e-4, then
    /// none; of 10 degrees 4e-6 and 4e-4, then 8e-7 and 7e-5.
    pub inset: f32,
}

impl Margins {
    /// The margins of a triangle of positive area.
    pub fn of(vertices: [[f32; 3]; 3]) -> Margins {
        let [a, b, c] = vertices.map(|v| DVec3::from(v.map(f64::from)));
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = (b - a).cross(c - a).length() / longest;
        let aspect = longest / height;
        let size = [a, b, c].map(|v| v.abs().element_sum()).into_iter().fold(0.0, f64::max);
        let half_ulp = f64::from(f32::EPSILON) * 0.5;
        let sliver = if aspect > PLAIN_ASPECT { (0.5 * longest * aspect).min(height / 8.0 / half_ulp) } else { 0.0 };
        Margins { sliver: sliver as f32, inset: (INSET_HALF_ULPS * size / longest).min(LARGEST_INSET) as f32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn right_angled(width: f32, at: f32) -> Margins {
        Margins::of([[at, 0.0, 0.0], [at + 1.0, 0.0, 0.0], [at, width, 0.0]])
    }

    #[test]
    fn only_slivers_are_treated_as_slivers() {
        assert_eq!(right_angled(1.0, 0.0).sliver, 0.0);
        assert_eq!(right_angled(0.1, 0.0).sliver, 0.0);
        assert!((right_angled(0.01, 0.0).sliver - 50.0).abs() < 0.01);
        // Beyond an aspect of 2,000 the offset shrinks with the height again.
        assert!((right_angled(1e-5, 0.0).sliver / 16_777_216.0 - 1.25e-6).abs() < 1e-9);
    }

    #[test]
    fn insets_grow_with_the_distance_from_the_origin_up_to_a_sixteenth() {
        assert_eq!(right_angled(1.0, 9.0).inset, 320.0 / 2f32.sqrt());
        assert_eq!(right_angled(1.0, 1e7).inset, LARGEST_INSET as f32);
    }
}
