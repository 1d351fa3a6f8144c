//! Roulette of shadow rays by what was learned of which cells see each other (Guo, Eisemann and Eisemann 2020; the choices made
//! here are listed in [`crate::learn::visibility`]).

use super::factors::cell;
use super::light_sample::{LightSample, Target};
use super::{Real, Vec3};
use crate::tables::lights::table::LightTable;
use crate::tables::lights::visibility::{STEPS, Visibility};

/// The light sample, if roulette with the number `u` lets its shadow ray from `origin` be traced: its radiance is then over the
/// probability of that. Without anything learned, and to the environment, every shadow ray is traced.
pub fn survivor(lights: &LightTable, origin: Vec3, light: LightSample, u: Real) -> Option<LightSample> {
    let Some(visibility) = &lights.visibility else { return Some(light) };
    let Some(pair) = pair(visibility, origin, &light) else { return Some(light) };
    let steps = visibility.steps(pair) as Real;
    let survival = steps * (1.0 / STEPS as Real);
    (u < survival).then(|| LightSample { radiance: light.radiance * (STEPS as Real / steps), survival, ..light })
}

/// The pair of cells between which the shadow ray of a light sample runs; `None`: it leaves the scene.
pub fn pair(visibility: &Visibility, origin: Vec3, light: &LightSample) -> Option<u32> {
    if matches!(light.target, Target::Environment) {
        return None;
    }
    let point = origin + light.shadow_direction;
    Some(visibility.pair(cell(&visibility.grid, origin), cell(&visibility.grid, point)))
}
