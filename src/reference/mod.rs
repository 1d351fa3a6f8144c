//! The scalar reference: path tracing as a textbook writes it, one path at a time, early returns.
//!
//! **Law:** this folder never names `lanes`, `packet` or `wide`. It shares with the packet engine the prepared scene, the
//! sample numbers, `math` and the film, and nothing else; every formula is written here a second time, from its source.
//! The same files are compiled twice, with `Real = f32` ([`single`]: the packet engine must equal its bits) and with
//! `Real = f64` ([`double`]: the yardstick for rounding error).

pub mod double;
pub mod single;

use crate::trace::{LIGHT_SAMPLE, LIGHT_SAMPLE_BLOCKED, PathStep, RAY, ShadowStep, TraceVertex};

/// What the steps of a path of [`single`] come to, ray by ray. (Its f64 values are widened f32, so no bit is lost.)
pub fn path_steps(vertices: &[TraceVertex]) -> Vec<PathStep> {
    let narrow = |v: [f64; 3]| v.map(|c| c as f32);
    let mut steps: Vec<PathStep> = Vec::new();
    for vertex in vertices {
        if vertex.event == RAY {
            steps.push(PathStep {
                origin: narrow(vertex.position),
                direction: narrow(vertex.direction),
                beta: narrow(vertex.beta),
                triangle: vertex.triangle,
                t: f32::INFINITY,
                shadow: None,
                radiance: narrow(vertex.radiance),
            });
        }
        let Some(step) = steps.last_mut() else { continue };
        match vertex.event {
            "hit" => (step.triangle, step.t) = (vertex.triangle, vertex.t as f32),
            LIGHT_SAMPLE | LIGHT_SAMPLE_BLOCKED => {
                step.shadow = Some(ShadowStep {
                    direction: narrow(vertex.direction),
                    contribution: narrow(vertex.gain),
                    blocked: vertex.event == LIGHT_SAMPLE_BLOCKED,
                });
            }
            _ => {}
        }
        step.radiance = narrow(vertex.radiance);
    }
    steps
}
