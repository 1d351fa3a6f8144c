//! `octray trace`: one path, vertex by vertex, in both engines. What every failing check points to.

use super::args::{self, EstimatorArgs, FilmArgs};
use super::output::{print, table};
use super::warn;
use crate::bvh::ray::NO_HIT;
use crate::error::{Error, Result};
use crate::lanes::LANES;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::tile::trace_paths;
use crate::reference::{TraceVertex, single};
use crate::sampler::pixel_address;
use crate::scene::Scene;
use crate::setup::Setup;
use std::path::PathBuf;

/// Flags of `octray trace`.
#[derive(clap::Args)]
pub struct TraceArgs {
    /// A scene file (.toml), a bare .obj, or builtin:NAME
    scene: PathBuf,
    /// The pixel, counted from the top left of the film
    #[arg(long, value_name = "X,Y", value_parser = args::pixel, allow_hyphen_values = true)]
    pixel: [u32; 2],
    /// The sample's number, from 0
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    sample: u32,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    film: FilmArgs,
}

/// Runs the command; the exit status: 1 if the engines disagree.
pub fn run(args: &TraceArgs) -> Result<u8> {
    let scene = Scene::load(&args.scene)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    args.film.apply(&mut settings);
    let ((width, height), _) = settings.film_and_crop(scene.desc.film)?;
    let [x, y] = args.pixel;
    if x >= width || y >= height {
        return Err(Error::Usage(format!("pixel {x},{y} does not lie in the film of {width} x {height} pixels")));
    }
    let prepared = scene.prepare()?;
    let setup = Setup::new(&prepared, &settings);
    let mut path = Vec::new();
    single::path::trace_path(&setup, (x, y), args.sample, &mut |vertex| path.push(vertex));
    let (verdict, agree) = compare(&path, packet_radiance(&setup, (x, y), args.sample));
    print(&format!("{}{verdict}", vertices(&path)))?;
    Ok(if agree { 0 } else { 1 })
}

/// What the packet engine gathers on the same path, alone in its lanes.
fn packet_radiance(setup: &Setup, (x, y): (u32, u32), sample: u32) -> [f32; 3] {
    let plan = Plan::new(setup);
    let mut state = plan.tile_state(LANES);
    state.slots.pixel[0] = pixel_address(x, y);
    state.slots.sample[0] = sample;
    state.slots.radiance[0] = [0.0; 4];
    state.slots.len = 1;
    trace_paths(setup, &plan, &mut state, &mut Counters::default());
    let [r, g, b, _] = state.slots.radiance[0];
    [r, g, b]
}

/// Whether both engines gathered the same radiance, to the last bit, and a line that says so.
fn compare(path: &[TraceVertex], packet: [f32; 3]) -> (String, bool) {
    let scalar = path.last().map_or([0.0; 3], |vertex| vertex.radiance).map(|value| value as f32);
    let agree = scalar.map(f32::to_bits) == packet.map(f32::to_bits);
    let [scalar, packet] = [scalar, packet].map(|radiance| vector(radiance.map(f64::from)));
    let verdict = if agree {
        format!("radiance {scalar}; both engines agree to the last bit\n")
    } else {
        format!("the engines differ: radiance {scalar} (scalar), {packet} (packet)\n")
    };
    (verdict, agree)
}

/// A path as a table, one row a step.
fn vertices(path: &[TraceVertex]) -> String {
    let heading = ["step", "depth", "event", "triangle", "t", "position", "throughput", "radiance", "pdf", "weight"];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    for (step, vertex) in path.iter().enumerate() {
        let triangle = if vertex.triangle == NO_HIT { "-".to_owned() } else { vertex.triangle.to_string() };
        rows.push(vec![
            step.to_string(),
            vertex.depth.to_string(),
            vertex.event.to_owned(),
            triangle,
            number(vertex.t),
            vector(vertex.position),
            vector(vertex.beta),
            vector(vertex.radiance),
            number(vertex.pdf),
            number(vertex.weight),
        ]);
    }
    table(&rows)
}

/// Nine digits: enough to tell any two f32 values apart.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        magnitude if !magnitude.is_finite() => value.to_string(),
        magnitude if (1e-3..1e6).contains(&magnitude) => {
            let digits = (8 - magnitude.log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.8e}"),
    }
}

fn vector(value: [f64; 3]) -> String {
    value.map(number).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_a_row_a_step_and_the_engines_are_compared_by_bits() {
        let step = |depth, radiance: f32| TraceVertex {
            depth,
            event: "emission",
            triangle: NO_HIT,
            t: f64::INFINITY,
            position: [0.0, 1e-9, -2.5],
            beta: [1.0; 3],
            radiance: [f64::from(radiance); 3],
            pdf: 0.0,
            weight: 1.0,
        };
        let path = [step(0, 0.0), step(1, 0.1)];
        let text = vertices(&path);
        assert_eq!(text.lines().count(), 3);
        assert!(text.contains("0 1.00000000e-9 -2.50000000  1.00000000"), "{text}");
        assert!(text.contains("0.100000001") && text.contains(" inf "), "{text}");
        assert!(compare(&path, [0.1; 3]).1);
        assert!(!compare(&path, [0.1, 0.1, 0.1f32.next_up()]).1);
        assert!(compare(&[], [0.0; 3]).1 && !compare(&[], [-0.0; 3]).1);
    }
}
