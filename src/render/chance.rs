//! The brightest light that a path may meet by chance: what a picture's samples may all have missed without a trace.

use crate::setup::Setup;
use crate::strategy::Weight;
use crate::tables::lights::environment::Environment;
use crate::tables::materials::MaterialKind;

/// The largest radiance (root mean square over the channels, W sr^-1 m^-2) that a direction drawn after an event may bring
/// in whole; 0 where light samples see to all lights. They do if the strategy counts hits by densities or not at all and all
/// surfaces are diffuse. They do not under `uniform`, `bsdf`, `nee-sum` and `nee-average`, and not where mirrors, glass,
/// metal or coats lead paths from a diffuse surface to a light: that is a caustic.
pub(super) fn brightest_by_chance(setup: &Setup) -> f64 {
    use MaterialKind::{Conductor, Dielectric, Mirror, Plastic, Principled};
    let scene = setup.scene;
    let hits_count = matches!(setup.strategy.row().hit, Weight::One | Weight::Half);
    let leads_on =
        [Mirror, Conductor, Dielectric, Plastic, Principled].into_iter().any(|kind| scene.features.kinds[kind]);
    let scatters = setup.max_depth > 0 && scene.features.scatters();
    if !scatters || !(hits_count || leads_on) {
        return 0.0;
    }
    let strength = |radiance: [f32; 3]| radiance.iter().map(|&c| f64::from(c) * f64::from(c)).sum::<f64>();
    // Textures on emitters only darken them.
    let emitters = scene.emitters.iter().map(|emitter| strength(emitter.radiance)).fold(0.0, f64::max);
    let environment = match &scene.environment {
        None => 0.0,
        Some(Environment::Constant(radiance)) => strength(*radiance),
        Some(Environment::Map(map)) => map.texels.iter().map(|texel| strength(texel.radiance)).fold(0.0, f64::max),
    };
    (emitters.max(environment) / 3.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::Scene;
    use crate::settings::Settings;
    use crate::strategy::Strategy;

    #[test]
    fn light_is_met_by_chance_where_light_samples_do_not_see_to_it() {
        let of = |name: &str, strategy: Strategy, max_depth: Option<u32>| {
            let path = format!("{}/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            let scene = Scene::load(path).and_then(|scene| scene.prepare()).unwrap();
            brightest_by_chance(&Setup::new(&scene, &Settings { strategy, max_depth, ..Settings::default() }))
        };
        let lamp = [18.387f32, 13.9873, 6.75357].map(f64::from);
        let lamp = (lamp.iter().map(|c| c * c).sum::<f64>() / 3.0).sqrt();
        for &strategy in Strategy::ALL {
            use Strategy::{Bsdf, NeeAverage, NeeSum, Uniform};
            let by_chance = matches!(strategy, Bsdf | Uniform | NeeSum | NeeAverage);
            assert_eq!(of("cornell", strategy, None), if by_chance { lamp } else { 0.0 }, "{strategy}");
            assert_eq!(of("cornell_mirror", strategy, Some(1)), lamp, "{strategy}");
            assert_eq!(of("cornell_mirror", strategy, Some(0)), 0.0, "{strategy}");
        }
        // The sun of a map, which diffuse surfaces alone leave to light samples.
        assert!(of("sky", Strategy::Bsdf, None) > 1.0 && of("sky", Strategy::MisPower, None) == 0.0);
    }
}
