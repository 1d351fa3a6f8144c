//! What radiances count in, so that the products of a path's estimate stay inside f32.
//!
//! An estimate multiplies radiance with BSDFs (1.6e11 at the tip of the narrowest GGX lobe) and divides it by densities (1e-10
//! for a light in a deep tree). With radiances near 1 there is room for all of it; with radiances of 1e30 there is not. So
//! extreme scenes count in a unit of their own, a power of two: every product then has the bits it has in the scene of ordinary
//! radiance, and the film, which sums in f64, turns samples back.

use crate::scene::desc::{EnvironmentDesc, SceneDesc};

/// The binary exponents between which the largest radiance of a scene is ordinary: its unit is 1.
pub const ORDINARY: std::ops::RangeInclusive<i32> = -40..=40;

/// The unit of radiance in which `desc` is rendered, W sr^-1 m^-2: a power of two; 1 unless its largest radiance is extreme.
pub fn radiance_unit(desc: &SceneDesc) -> f64 {
    let emitted = desc.materials.iter().flat_map(|material| material.emission).fold(0.0, f64::max);
    // In scenes of ordinary size; f32 has room for others.
    let sent = desc.delta_lights().flat_map(|desc| desc.light.strength()).fold(0.0, f64::max);
    let surrounding = match desc.environment() {
        None => 0.0,
        Some(EnvironmentDesc::Constant { radiance }) => radiance.iter().copied().fold(0.0, f64::max),
        Some(EnvironmentDesc::Map(map)) => {
            f64::from(map.texels.iter().flatten().copied().fold(0.0, f32::max)) * map.scale
        }
    };
    let brightest = emitted.max(surrounding).max(sent);
    if brightest < f64::MIN_POSITIVE {
        return 1.0;
    }
    let exponent = (brightest.to_bits() >> 52) as i32 - 1023;
    // Bright scenes keep as much room below as they can: dim lights beside bright ones must not sink under f32. Of dim ones
    // the brightest light counts about 1.
    let power = match exponent {
        e if e > *ORDINARY.end() => e - ORDINARY.end(),
        e if e < *ORDINARY.start() => e,
        _ => 0,
    };
    f64::from_bits(((power + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::desc::{MapDesc, MaterialDesc};

    #[test]
    fn only_extreme_scenes_have_a_unit_of_their_own() {
        let of = |emission: f64, environment: Option<EnvironmentDesc>| {
            let mut scene = SceneDesc::default();
            scene.materials.push(MaterialDesc { emission: [0.0, emission, 0.5 * emission], ..MaterialDesc::default() });
            scene.set_environment(environment);
            radiance_unit(&scene)
        };
        for ordinary in [0.0, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1.9e12] {
            assert_eq!(of(ordinary, None), 1.0, "{ordinary}");
        }
        let two = |n: i32| 2f64.powi(n);
        assert_eq!([of(two(41), None), of(1.99 * two(99), None)], [2.0, two(59)]);
        assert_eq!(
            [of(two(-41), None), of(1.99 * two(-120), None), of(1e-300, None)],
            [two(-41), two(-120), two(-997)]
        );
        let constant = |c: f64| Some(EnvironmentDesc::Constant { radiance: [c, 0.0, 0.0] });
        assert_eq!([of(1e-20, constant(1.0)), of(1.0, constant(two(80)))], [1.0, two(40)]);
        let map = |scale: f64| {
            let texels = vec![[0.0, 2.0, 1.0], [0.0; 3]];
            Some(EnvironmentDesc::Map(MapDesc { width: 2, height: 1, texels, scale, ..MapDesc::default() }))
        };
        assert_eq!([of(1e-20, map(two(80))), of(1e-20, map(two(-80)))], [two(41), two(-67)]);
    }
}
