//! `octray trace`: one path, vertex by vertex, in both engines. What every failing check points to.

use crate::api::Scene;
use crate::bvh::ray::NO_HIT;
use crate::check::scenes;
use crate::cli::args;
use crate::cli::args::{EstimatorArgs, FilmArgs};
use crate::cli::output::{print, table};
use crate::cli::{prepare, warn};
use crate::error::{Error, Result};
use crate::packet;
use crate::packet::plan::Plan;
use crate::reference::{path_steps, single};
use crate::setup::Setup;
use crate::setup::frame::film_size;
use crate::trace::{PathStep, TraceVertex, Value, first_difference};
use std::path::PathBuf;

/// Flags of `octray trace`.
#[derive(clap::Args)]
pub struct TraceArgs {
    /// A scene file (.toml), a bare .obj, builtin:NAME, or check:NAME as `octray check` names its scenes
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
    let scene = match args.scene.to_str().and_then(|path| path.strip_prefix(scenes::PREFIX)) {
        Some(name) => scenes::load(name)?,
        None => Scene::load(&args.scene)?,
    };
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    args.film.apply(&mut settings);
    let (width, height) = film_size(&settings, scene.desc.film)?;
    let [x, y] = args.pixel;
    if x >= width || y >= height {
        return Err(Error::Usage(format!(
            "pixel {x},{y} does not lie in the film of {width} x {height} pixels: they are counted from 0,0 at the top \
             left"
        )));
    }
    let prepared = prepare(&scene)?;
    let setup = Setup::new(&prepared, &settings);
    setup.warnings.iter().for_each(|warning| warn(warning));
    let mut vertices = Vec::new();
    single::path::trace_path(&setup, (x, y), args.sample, &mut |vertex| vertices.push(vertex));
    let scalar = path_steps(&vertices);
    let packet = packet::trace::trace_path(&setup, &Plan::new(&setup), (x, y), args.sample);
    let difference = first_difference(&scalar, &packet);
    let (strategy, sample, seed) = (settings.strategy, args.sample, settings.seed);
    print(&format!(
        "{}, {strategy}, pixel {x},{y} of {width} x {height}, sample {sample}, seed {seed}\n\n\
         {}steps of the scalar reference\n{}\nboth engines, ray by ray\n{}\n{}\n",
        prepared.name,
        unit_note(prepared.radiance_unit),
        step_table(&vertices),
        comparison(&scalar, &packet),
        verdict(&scalar, difference),
    ))?;
    Ok(if difference.is_none() { 0 } else { 1 })
}

/// What radiances count in, where that is not 1.
fn unit_note(unit: f64) -> String {
    match unit {
        1.0 => String::new(),
        _ => format!(
            "gains, contributions and radiance count in units of {unit:e}: this scene's radiances are extreme\n\n"
        ),
    }
}

/// What the reference did, one row a step.
fn step_table(path: &[TraceVertex]) -> String {
    let heading = ["  depth", "event", "triangle", "t", "position", "throughput", "gain", "pdf", "weight"];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    let unless = |absent: bool, text: String| if absent { "-".to_owned() } else { text };
    for vertex in path {
        let hit = vertex.triangle != NO_HIT;
        rows.push(vec![
            format!("  {}", vertex.depth),
            vertex.event.to_owned(),
            unless(!hit, vertex.triangle.to_string()),
            unless(!hit, number(vertex.t)),
            vector(vertex.position),
            vector(vertex.beta),
            unless(vertex.gain == [0.0; 3], vector(vertex.gain)),
            unless(vertex.pdf == 0.0, number(vertex.pdf)),
            unless(vertex.weight == 0.0, number(vertex.weight)),
        ]);
    }
    table(&rows)
}

/// Every value of every ray in both engines, those that differ marked and with their bits.
fn comparison(scalar: &[PathStep], packet: &[PathStep]) -> String {
    let mut rows = vec![["  depth", "value", "scalar", "packet", ""].map(str::to_owned).to_vec()];
    let mut differ = false;
    for depth in 0..scalar.len().max(packet.len()) {
        let [scalar, packet] = [scalar, packet].map(|path| path.get(depth).map(PathStep::values));
        let Some(names) = scalar.or(packet) else { break };
        for (index, (name, _)) in names.into_iter().enumerate() {
            let [a, b] = [scalar, packet].map(|values| values.map_or(Value::None, |values| values[index].1));
            if (a, b) == (Value::None, Value::None) {
                continue;
            }
            let mark = match (a == b, differ) {
                (true, _) => "",
                (false, false) => "<- the first difference",
                (false, true) => "<- differs",
            };
            differ |= a != b;
            rows.push(vec![format!("  {depth}"), name.to_owned(), shown(a), shown(b), mark.to_owned()]);
            if a != b {
                rows.push(vec!["".into(), "  bits".into(), bits(a), bits(b)]);
            }
        }
    }
    table(&rows)
}

fn verdict(scalar: &[PathStep], difference: Option<(usize, &'static str)>) -> String {
    match difference {
        Some((depth, "end")) => {
            format!("the engines differ: at depth {depth} one has ended its path, the other has not")
        }
        Some((depth, name)) => format!("the engines differ: first in the {name} at depth {depth}"),
        None => {
            let radiance = scalar.last().map_or([0.0; 3], |step| step.radiance);
            format!("radiance {}; both engines agree to the last bit", vector(radiance.map(f64::from)))
        }
    }
}

fn shown(value: Value) -> String {
    match value {
        Value::Triangle(NO_HIT) | Value::None => "-".to_owned(),
        Value::Triangle(id) => id.to_string(),
        Value::Number(value) => number(f64::from(value)),
        Value::Vector(value) => vector(value.map(f64::from)),
        Value::Flag(flag) => if flag { "yes" } else { "no" }.to_owned(),
    }
}

fn bits(value: Value) -> String {
    match value {
        Value::Number(value) => format!("{:08x}", value.to_bits()),
        Value::Vector(value) => value.map(|c| format!("{:08x}", c.to_bits())).join(" "),
        _ => String::new(),
    }
}

/// Nine digits: enough to tell any two f32 values apart.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => if value.is_sign_negative() { "-0" } else { "0" }.to_owned(),
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

    fn step() -> PathStep {
        PathStep {
            origin: [0.0, 1e-9, -2.5],
            direction: [0.0, 0.0, 1.0],
            beta: [1.0; 3],
            triangle: NO_HIT,
            t: f32::INFINITY,
            shadow: None,
            radiance: [0.1; 3],
        }
    }

    #[test]
    fn both_engines_stand_side_by_side_and_the_first_difference_is_marked() {
        let same = comparison(&[step()], &[step()]);
        assert!(same.contains("0 9.99999972e-10 -2.50000000         0 9.99999972e-10 -2.50000000\n"), "{same}");
        assert!(!same.contains("<-") && !same.contains("shadow"), "{same}");
        let other = PathStep { t: 2.0, radiance: [0.1, 0.1, 0.1f32.next_up()], ..step() };
        let text = comparison(&[step()], &[other]);
        let line = |word: &str| text.lines().find(|line| line.contains(word)).unwrap_or_default().to_owned();
        assert!(line(" t ").ends_with("<- the first difference"), "{text}");
        assert!(line(" radiance ").ends_with("<- differs") && text.contains("3dcccccd 3dcccccd 3dccccce"), "{text}");
        let difference = first_difference(&[step()], &[other]);
        assert_eq!(verdict(&[step()], difference), "the engines differ: first in the t at depth 0");
        let longer = comparison(&[step(), step()], &[step()]);
        assert!(longer.contains("<- the first difference"), "{longer}");
    }
}
