//! Choosing a light for eight receivers at once, and the probability with which one is chosen. The environment is a light
//! like any other.

use super::here;
use crate::tables::lights::table::{Fixed, LightTable, Selection};
use here::kernels::lights::tree::{Receivers, choose_lights, environment_eighths, light_probabilities};
use here::lanes::{F32x8, Mask8, U32x8};

/// The lights that eight samples go to.
pub struct Choice {
    /// Lanes whose sample goes to the environment.
    pub environment: Mask8,
    /// The emitters or delta lights that the other lanes' samples go to.
    pub emitter: U32x8,
    /// Light selection probabilities.
    pub probability: F32x8,
    /// What choosing leaves of the selection words, for further choices.
    pub word: U32x8,
}

/// Lights that may have been chosen.
pub enum Light8 {
    /// The environment, in every lane.
    Environment,
    /// Emitters.
    Emitters(U32x8),
}

/// The lights that the selection words `word` choose for `receivers`. Lanes not `active` hold anything.
#[inline(always)]
pub fn choose(lights: &LightTable, receivers: &Receivers, active: Mask8, word: U32x8) -> Choice {
    let eighths = eighths(lights, receivers);
    let (environment, word) = match (lights.environment.is_some(), lights.count() == 0) {
        (false, _) => (Mask8::NONE, word),
        (true, true) => (Mask8::ALL, word),
        (true, false) => ((word >> 29).lt_signed(eighths), word << 3),
    };
    if lights.count() == 0 {
        return Choice { environment, emitter: U32x8::ZERO, probability: environment_part(lights, eighths), word };
    }
    let (emitter, probability) = match &lights.selection {
        Selection::Tree(tree) => {
            let (emitter, probability) =
                choose_lights(tree, lights.learned_tree(), receivers, active.and_not(environment), word);
            (emitter, probability * emitter_part(lights, eighths))
        }
        Selection::Fixed(fixed) => {
            let emitter = match fixed {
                Fixed::Single => U32x8::ZERO,
                Fixed::Uniform(count) => word.multiply_high(U32x8::splat(*count)),
                // A table lookup a lane: the scalar rule is the lane rule.
                Fixed::Alias(_) => U32x8::from_array(word.to_array().map(|word| fixed.choose(word))),
            };
            (emitter, fixed_probabilities(lights, emitter))
        }
    };
    let probability = match lights.environment.is_some() {
        true => environment.select(environment_part(lights, eighths), probability),
        false => probability,
    };
    Choice { environment, emitter, probability, word }
}

/// The probabilities with which [`choose`] chooses `light` for `receivers`; only lanes of `active` are asked for.
#[inline(always)]
pub fn probability(lights: &LightTable, receivers: &Receivers, active: Mask8, light: Light8) -> F32x8 {
    match (light, &lights.selection) {
        (Light8::Environment, _) => environment_part(lights, eighths(lights, receivers)),
        (Light8::Emitters(emitter), Selection::Fixed(_)) => fixed_probabilities(lights, emitter),
        (Light8::Emitters(emitter), Selection::Tree(tree)) => {
            let part = emitter_part(lights, eighths(lights, receivers));
            light_probabilities(tree, lights.learned_tree(), receivers, active, emitter) * part
        }
    }
}

/// How many eighths of the light samples go to the environment if the scene has other lights too.
#[inline(always)]
fn eighths(lights: &LightTable, receivers: &Receivers) -> U32x8 {
    match &lights.selection {
        Selection::Tree(tree) if lights.environment.is_some() => environment_eighths(tree, receivers),
        _ => U32x8::splat(4),
    }
}

/// Under a light tree, the probabilities with which light samples go to other lights than the environment.
#[inline(always)]
fn emitter_part(lights: &LightTable, eighths: U32x8) -> F32x8 {
    match lights.environment {
        Some(_) => (U32x8::splat(8) - eighths).to_f32() * F32x8::splat(0.125),
        None => F32x8::ONE,
    }
}

/// The probabilities with which light samples go to the environment.
#[inline(always)]
fn environment_part(lights: &LightTable, eighths: U32x8) -> F32x8 {
    match &lights.selection {
        Selection::Tree(_) => eighths.to_f32() * F32x8::splat(0.125),
        Selection::Fixed(_) => F32x8::splat(lights.environment_probability),
    }
}

/// The probabilities with which light samples go to lights where places do not matter.
#[inline(always)]
fn fixed_probabilities(lights: &LightTable, emitter: U32x8) -> F32x8 {
    match lights.probabilities[..] {
        [same] => F32x8::splat(same),
        _ => F32x8::gather(&lights.probabilities, emitter),
    }
}
