//! Choosing a light for a receiver, and the probability with which one is chosen. The environment is a light like any other.

use super::Real;
use super::tree::{Receiver, choose_light, environment_eighths, light_probability};
use crate::tables::lights::table::{LightTable, Selection};

/// A light of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// The environment.
    Environment,
    /// The emitter with this number.
    Emitter(u32),
}

/// The light that the selection word `word` chooses for `receiver`, the probability with which it does, and what choosing
/// leaves of the word for further choices.
pub fn choose(lights: &LightTable, receiver: &Receiver, word: u32) -> (Light, Real, u32) {
    let (environment, word) = match (lights.environment.is_some(), lights.records.is_empty()) {
        (false, _) => (false, word),
        (true, true) => (true, word),
        (true, false) => (word >> 29 < eighths(lights, receiver), word << 3),
    };
    if environment {
        return (Light::Environment, probability(lights, receiver, Light::Environment), word);
    }
    let (emitter, probability) = match &lights.selection {
        Selection::Tree(tree) => {
            let (emitter, probability) = choose_light(tree, lights.learned_tree(), receiver, word);
            (emitter, probability * emitter_part(lights, receiver))
        }
        Selection::Fixed(fixed) => {
            let emitter = fixed.choose(word);
            (emitter, lights.probability(emitter) as Real)
        }
    };
    (Light::Emitter(emitter), probability, word)
}

/// The probability with which [`choose`] chooses `light` for `receiver`.
pub fn probability(lights: &LightTable, receiver: &Receiver, light: Light) -> Real {
    match (light, &lights.selection) {
        (Light::Environment, Selection::Tree(_)) => eighths(lights, receiver) as Real * 0.125,
        (Light::Environment, Selection::Fixed(_)) => lights.environment_probability as Real,
        (Light::Emitter(emitter), Selection::Tree(tree)) => {
            light_probability(tree, lights.learned_tree(), receiver, emitter) * emitter_part(lights, receiver)
        }
        (Light::Emitter(emitter), Selection::Fixed(_)) => lights.probability(emitter) as Real,
    }
}

/// How many eighths of the light samples go to the environment if the scene has other lights too.
fn eighths(lights: &LightTable, receiver: &Receiver) -> u32 {
    match &lights.selection {
        Selection::Tree(tree) if lights.environment.is_some() => environment_eighths(tree, receiver),
        _ => 4,
    }
}

/// Under a light tree, the probability with which a light sample goes to another light than the environment.
fn emitter_part(lights: &LightTable, receiver: &Receiver) -> Real {
    if lights.environment.is_some() { (8 - eighths(lights, receiver)) as Real * 0.125 } else { 1.0 }
}
