//! `octray trace`: one path, step by step, and both engines beside each other. What every failing check points to.

mod compare;
mod json;
mod story;

use crate::check::scenes;
use crate::cli::args;
use crate::cli::args::{EstimatorArgs, FilmArgs};
use crate::cli::examples;
use crate::cli::output::{JsonArgs, columns};
use crate::cli::progress::load;
use crate::cli::view::ViewArgs;
use crate::cli::{prepare, warn};
use crate::error::{Error, Result};
use crate::packet;
use crate::packet::plan::Plan;
use crate::reference::{path_steps, single};
use crate::render::pilot::resolve;
use crate::scene::SceneDesc;
use crate::scene::desc::DeltaLight;
use crate::settings::Settings;
use crate::setup::Setup;
use crate::setup::frame::film_size;
use crate::trace::{PathStep, TraceVertex, first_difference};
use std::path::PathBuf;

/// Printed below the flags.
const ABOUT: &str = "\
The story of one sample: every ray, what it hits, the light sample and the BSDF sample with their densities and MIS weights, \
what each adds to the radiance, and why the path ends. The scalar reference tells it; the packet engine follows the same path, \
and both must agree on every value to the last bit. A pixel is the mean of its samples: a bright one is found in the list of \
octray check or by trying --sample 0, 1, 2 ..";

/// Flags of `octray trace`.
#[derive(clap::Args)]
#[command(after_help = format!("{ABOUT}\n\n{}", examples::TRACE))]
pub struct TraceArgs {
    /// A scene file (.toml), a bare .obj, a .gltf or .glb, builtin:NAME, or check:NAME as `octray check` names its scenes
    scene: PathBuf,
    /// The pixel, counted from the top left of the film
    #[arg(long, value_name = "X,Y", value_parser = args::pixel, allow_hyphen_values = true)]
    pixel: [u32; 2],
    /// The sample's number, from 0
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    sample: u32,
    /// Show every value of every ray in both engines, though they agree
    #[arg(long)]
    both: bool,
    #[command(flatten)]
    estimator: EstimatorArgs,
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    json: JsonArgs,
}

/// A path, and what it was followed with.
struct Traced<'a> {
    scene: &'a SceneDesc,
    settings: &'a Settings,
    /// What radiances count in, W sr^-1 m^-2.
    radiance_unit: f64,
    /// The kinds of the delta lights.
    delta_kinds: Vec<&'static str>,
    film: (u32, u32),
    pixel: (u32, u32),
    sample: u32,
    /// What the reference did, step by step.
    vertices: Vec<TraceVertex>,
    /// Its rays.
    scalar: Vec<PathStep>,
    /// The packet engine's.
    packet: Vec<PathStep>,
    /// The depth and the value at which they part.
    difference: Option<(usize, &'static str)>,
}

impl Traced<'_> {
    /// The radiance of the sample.
    fn radiance(&self) -> [f32; 3] {
        self.scalar.last().map_or([0.0; 3], |step| step.radiance)
    }

    /// The name of the material of a triangle.
    fn material(&self, triangle: u32) -> Option<&str> {
        let mut left = triangle as usize;
        for instance in &self.scene.instances {
            let triangles = &self.scene.meshes.get(instance.mesh as usize)?.triangles;
            if let Some(found) = triangles.get(left) {
                return Some(&self.scene.materials.get(found.material as usize)?.name);
            }
            left -= triangles.len();
        }
        None
    }
}

/// Runs the command; the exit status: 1 if the engines disagree.
pub fn run(args: &TraceArgs) -> Result<u8> {
    args.json.check()?;
    let (mut settings, mut scene) = match args.scene.to_str().and_then(|path| path.strip_prefix(scenes::PREFIX)) {
        // As `check` renders them.
        Some(name) => scenes::load(name).map(|scene| (scene.settings().without_learning(), scene))?,
        None => load(&args.scene, false).map(|scene| (scene.settings(), scene))?,
    };
    args.view.apply(&mut scene.desc)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
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
    let setup = resolve(&prepared, &settings);
    setup.warnings.iter().for_each(|warning| warn(warning));
    let traced = follow(&scene.desc, &settings, &setup, (x, y), args.sample);
    args.json.deliver(&json::Told::new(&traced), || {
        let engines = match args.both || traced.difference.is_some() {
            true => format!("both engines, ray by ray\n{}\n", compare::comparison(&traced.scalar, &traced.packet)),
            false => String::new(),
        };
        let verdict = compare::verdict(&traced.scalar, traced.difference);
        format!("{}\n{engines}{verdict}\n", story::story(&traced, columns()))
    })?;
    Ok(if traced.difference.is_none() { 0 } else { 1 })
}

/// Follows the path in both engines.
fn follow<'a>(
    scene: &'a SceneDesc,
    settings: &'a Settings,
    setup: &Setup,
    pixel: (u32, u32),
    sample: u32,
) -> Traced<'a> {
    let mut vertices = Vec::new();
    single::path::trace_path(setup, pixel, sample, &mut |vertex| vertices.push(vertex));
    let scalar = path_steps(&vertices);
    let packet = packet::trace::trace_path(setup, &Plan::new(setup), pixel, sample);
    let difference = first_difference(&scalar, &packet);
    let (film, radiance_unit) = (setup.frame.film, setup.scene.radiance_unit);
    let delta_kinds = setup.scene.delta_lights.lights().iter().map(DeltaLight::kind).collect();
    Traced { scene, settings, radiance_unit, delta_kinds, film, pixel, sample, vertices, scalar, packet, difference }
}
