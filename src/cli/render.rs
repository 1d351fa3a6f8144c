//! `octray render`: a scene to image files.

use crate::api::Scene;
use crate::camera;
use crate::cli::args;
use crate::cli::args::{EstimatorArgs, FilmArgs, PlanArgs};
use crate::cli::examples;
use crate::cli::frames::{FrameArgs, Names, Shot};
use crate::cli::interrupt;
use crate::cli::keep::{KeepArgs, Watcher, partial_path, remove_partial};
use crate::cli::layers::{EncodingArgs, LayerArgs};
use crate::cli::messages::{self, tell};
use crate::cli::numbers::{percent, three_digits};
use crate::cli::output::{check_json_path, check_place, make_directory, print, write_json};
use crate::cli::places;
use crate::cli::progress::{Bar, Form, load};
use crate::cli::resume::{State, recipe_of};
use crate::cli::stats::Report;
use crate::cli::view::ViewArgs;
use crate::cli::{prepare, report, warn};
use crate::error::{Error, Result};
use crate::files::atomic;
use crate::film::part::{self, About};
use crate::film::{Film, OutOfRange};
use crate::image::{Format, check_output_path};
use crate::render::sequence::{Sequence, seed_of};
use crate::render::{Render, try_render_from};
use crate::scene::desc::CameraDesc;
use crate::scene::validate::camera_fault;
use crate::settings::{Crop, Engine, PlanChoice, Sampler, Settings, Shard};
use crate::setup::frame::Frame;
use crate::setup::recipe::Recipe;
use crate::tables::{PreparedScene, scale_limits};
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// What the help says of noise.
pub const NOISE: &str = "\
Noise, of which the progress bar, the summary and --target-error speak, is the standard error of a pixel relative to the mean \
radiance: the root of the mean variance of the pixels' means over the mean radiance, channels averaged, as the samples' own \
spread tells it. To it --target-error adds what bright light that no sample has met may come to. It is not the relative error \
of diff and converge (the root of relMSE), which needs a reference: estimated from the image itself, relMSE saturates near 1 a \
pixel at just the bright outliers that it should report, since the outlier is its own reference.";

/// Flags of `octray render`.
#[derive(clap::Args)]
#[command(after_help = format!("{NOISE}\n\n{}", examples::RENDER))]
pub struct RenderArgs {
    /// A scene file (.toml), a bare .obj, a .gltf or .glb, or builtin:NAME
    scene: PathBuf,
    /// Image to write: .exr, .png, .hdr or .pfm; may be given several times; its directory is made if need be. With --shard
    /// the file of the part, of any name
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    #[arg(long, value_name = "N", help = spp_help(), value_parser = args::positive, allow_negative_numbers = true)]
    spp: Option<u32>,
    /// Wall time of rendering, ended on whole passes: 10s, 1m30s, 2h, 500ms or plain seconds; the first of --spp, --time and
    /// --target-error to be reached stops
    #[arg(long, value_name = "TIME", value_parser = args::seconds, allow_negative_numbers = true)]
    time: Option<Duration>,
    /// Stop once the noise, as defined below, is down to E (0.05 or 5%); after at least 16 samples a pixel, 16,384 in all
    #[arg(long, value_name = "E", value_parser = args::relative_error, allow_hyphen_values = true)]
    target_error: Option<f64>,
    #[command(flatten)]
    estimator: EstimatorArgs,
    /// packet: eight rays at a time; scalar: the plain reference. Both give the same bits
    #[arg(long, value_name = "E", default_value_t = Settings::default().engine,
          value_parser = |text: &str| args::named::<Engine>(text, &[]))]
    engine: Engine,
    #[command(flatten)]
    plan: PlanArgs,
    /// Worker threads [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096), allow_negative_numbers = true)]
    threads: Option<u16>,
    #[command(flatten)]
    film: FilmArgs,
    /// Render this rectangle of the film only
    #[arg(long, value_name = "X,Y,W,H", value_parser = args::crop, allow_hyphen_values = true)]
    crop: Option<Crop>,
    /// Render part K of N, every N-th tile of a fixed order with all its samples, for octray merge; parts may be made anywhere
    #[arg(long, value_name = "K/N", allow_hyphen_values = true)]
    shard: Option<Shard>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    sequence: FrameArgs,
    /// Stops of exposure for PNG; other formats hold radiance as it is
    #[arg(long, value_name = "EV", default_value = "0", value_parser = args::exposure, allow_negative_numbers = true)]
    exposure: f64,
    #[command(flatten)]
    layers: LayerArgs,
    #[command(flatten)]
    encoding: EncodingArgs,
    /// Write what the render cost and met as JSON
    #[arg(long, value_name = "FILE")]
    stats: Option<PathBuf>,
    #[command(flatten)]
    keeping: KeepArgs,
    /// How progress is told
    #[arg(long, value_name = "FORM", value_enum, default_value_t = Form::Auto)]
    progress: Form,
    /// No progress bar and no summary; warnings stay
    #[arg(long)]
    quiet: bool,
}

impl RenderArgs {
    fn form(&self) -> Form {
        if self.quiet && self.progress == Form::Auto { Form::None } else { self.progress }
    }
}

fn spp_help() -> String {
    format!(
        "Samples a pixel [default: the scene's, else {}; with --time or --target-error alone: as many as it takes]",
        Settings::default().spp
    )
}

/// Runs the command; the exit status.
pub fn run(args: &RenderArgs) -> Result<u8> {
    if args.engine == Engine::Scalar && args.plan.plan != PlanChoice::Scene {
        let message = "--plan: the scalar engine has no plan; leave out --plan or --engine scalar";
        return Err(Error::Usage(message.into()));
    }
    if args.progress == Form::Json {
        messages::as_json();
    }
    match args.shard {
        Some(_) => check_shard(args)?,
        None => {
            args.layers.check(&args.output)?;
            args.encoding.check(&args.output)?;
        }
    }
    let (checkpoint, preview) = args.keeping.files();
    let names = Names { outputs: &args.output, stats: args.stats.as_deref(), checkpoint, preview };
    let shots = args.sequence.shots(names)?;
    shots.iter().try_for_each(|shot| check_outputs(shot, args.shard))?;
    args.keeping.check(&shots, args.shard.is_none())?;
    let mut scene = load(&args.scene, args.quiet)?;
    if args.view.places_camera() && args.sequence.moves() {
        let message = "--look-from, --look-at, --up and --fov place a camera that stands still: leave out --frames and --camera-path";
        return Err(Error::Usage(message.into()));
    }
    args.view.apply(&mut scene.desc)?;
    let of_path = places::reading(|| args.sequence.place(&mut scene.desc))?;
    scene.desc.warnings.extend(of_path);
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    // Whatever can be wrong with any frame is told before the first.
    let cameras: Vec<CameraDesc> = shots.iter().map(|shot| args.sequence.camera(&scene.desc, shot.frame)).collect();
    let frame = Frame::new(&settings(args, &scene), scene.desc.film)?;
    for (shot, camera) in shots.iter().zip(&cameras) {
        let place = shot.frame.map(|frame| format!("frame {frame}: ")).unwrap_or_default();
        let fault =
            |message: &str| Error::Scene { scene: scene.desc.name.clone(), message: format!("{place}{message}") };
        camera_fault(camera).map_or(Ok(()), |message| Err(fault(&format!("camera: {message}"))))?;
        scale_limits::check_reach(camera).map_err(|message| fault(&message))?;
    }
    let of_view: BTreeSet<String> = cameras.iter().flat_map(|desc| camera::warnings(desc, frame.film.1)).collect();
    of_view.iter().for_each(|warning| warn(warning));
    scene.desc.warnings.extend(of_view);
    scene.desc.camera = cameras[0];
    let prepared = prepare(&scene)?;
    let mut sequence = args.sequence.sequence(&scene.desc, &prepared);
    let stop = interrupt::requested()?;
    let mut complete = true;
    for (shot, camera) in shots.iter().zip(cameras) {
        if args.sequence.is_left_out(shot) {
            continue;
        }
        scene.desc.camera = camera;
        complete &= render_shot(args, shot, &scene, (&prepared, &mut sequence), &stop)?;
        if stop.load(Ordering::Relaxed) {
            complete = false;
            break;
        }
    }
    Ok(if complete { 0 } else { 1 })
}

/// Renders one image, or one frame of a sequence, and writes its files; whether all of it was done.
fn render_shot(
    args: &RenderArgs,
    shot: &Shot,
    scene: &Scene,
    (prepared, sequence): (&PreparedScene, &mut Sequence),
    stop: &AtomicBool,
) -> Result<bool> {
    let mut settings = settings(args, scene);
    let first_seed = settings.seed;
    settings.seed = seed_of(first_seed, i64::from(shot.frame.unwrap_or(0)));
    let frame = Frame::new(&settings, scene.desc.film)?;
    let learned_from =
        shot.frame.filter(|_| settings.learns()).map(|frame| sequence.cameras(frame)).unwrap_or_default();
    let path = args.keeping.path(shot);
    let recipe = recipe_of(&scene.desc, &settings, &frame, &learned_from);
    let mut state = State::new(path, &recipe, settings.shard);
    let start = state.read(&mut settings, args.keeping.resumes())?;
    let (start_spp, resumed) = (start.as_ref().map_or(0, |film| film.spp), start.is_some());
    let mut warnings = scene.desc.warnings.clone();
    warnings.extend_from_slice(&prepared.warnings);
    shot.outputs.iter().chain(&shot.stats).chain(&shot.preview).try_for_each(|path| make_directory(path))?;
    let bar = Bar::new(&settings, shot.frame, args.form());
    let watcher = Watcher::new(&args.keeping, &state, shot.preview.as_deref(), &bar, stop, args.exposure);
    let mut render = match shot.frame {
        Some(frame) => {
            let of_sequence = Settings { seed: first_seed, ..settings.clone() };
            sequence.try_render(frame, &of_sequence, start, &watcher)
        }
        None => try_render_from(prepared, &settings, start, &watcher),
    }?;
    bar.finish();
    if let Some(learning) = &render.stats.learning {
        tell(&format!("training: {} paths in {} s", learning.paths, three_digits(learning.seconds)));
    }

    render.film.exposure = args.exposure;
    render.film.encoding = args.encoding.encoding();
    render.film.metadata.extend(shot.frame.map(|frame| ("frame".to_owned(), frame.to_string())));
    if !render.stats.finished {
        return stopped(shot, &state, &render, (settings.spp, settings.shard.is_some())).map(|()| false);
    }
    let mut found = findings(&render);
    found.extend(beyond_f32(&render, &shot.outputs));
    found.extend(args.encoding.beyond_half(&render.film, &shot.outputs));
    // What of the view was known has been told before.
    found.extend(render.stats.warnings.iter().filter(|warning| !warnings.contains(warning)).cloned());
    found.iter().for_each(|warning| warn(warning));
    warnings.extend(found);
    // Every file is tried: one full disk must not cost the image that fits elsewhere.
    let (mut written, mut complete) = (Vec::new(), true);
    for path in &shot.outputs {
        let saved = match settings.shard {
            Some(shard) => part::write(path, &about(&settings, shard, &frame, &recipe, &render.film), &render.film),
            None => make_directory(path).and_then(|()| render.film.save(path)),
        };
        match saved {
            Ok(()) => written.push(path.as_path()),
            Err(error) => {
                report(&error);
                complete = false;
            }
        }
    }
    if let Some(path) = &shot.stats
        && let Err(error) = write_json(path, &Report::new(prepared, &settings, &frame, &render, start_spp, &warnings))
    {
        report(&error);
        complete = false;
    }
    if !complete {
        // The samples outlive their files.
        let path = state.rescue(&render.film, render.stats.render_s)?;
        let flag =
            if state.path() == Some(&path) { String::new() } else { format!(" with --checkpoint {}", path.display()) };
        warn(&format!(
            "the finished render is kept in {}: the same command{flag} writes its files once they can be written",
            path.display()
        ));
        return Ok(false);
    }
    match args.keeping.keeps() {
        true => state.keep(&render.film, render.stats.render_s, true)?,
        false => state.remove(),
    }
    if resumed {
        remove_partial(&shot.outputs);
    }
    if !args.quiet {
        print(&summary(&settings, &render, &written, shot.frame.is_some()))?;
    }
    messages::event(&json!({
        "event": "finished",
        "frame": shot.frame,
        "files": written.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
        "samples_per_pixel": render.film.spp,
        "seconds": render.stats.render_s,
        "noise": render.film.relative_error(),
    }));
    Ok(true)
}

/// Keeps what an interrupted render, which was to have `spp` samples a pixel, has come to, and writes the picture so far.
fn stopped(shot: &Shot, state: &State, render: &Render, (spp, of_part): (u32, bool)) -> Result<()> {
    let film = &render.film;
    if film.most_spp() == 0 {
        warn("stopped before the first sample: there is nothing to keep");
        return Ok(());
    }
    let kept = match state.path() {
        Some(_) => Some(state.rescue(film, render.stats.render_s)?),
        None => None,
    };
    let mut partial = Vec::new();
    // The strip of a part is no picture.
    let images = if of_part { &[][..] } else { &shot.outputs };
    for path in images.iter().filter_map(|path| partial_path(path)) {
        match film.save(&path) {
            Ok(()) => partial.push(path.display().to_string()),
            Err(error) => report(&error),
        }
    }
    let of = if spp == u32::MAX { String::new() } else { format!(" of {spp}") };
    let done = film.spp_in_words();
    let so_far = if partial.is_empty() { String::new() } else { format!("; the image so far: {}", partial.join(", ")) };
    let on = match &kept {
        Some(path) if Some(path.as_path()) == state.path() => {
            format!("the same command goes on from there ({})", path.display())
        }
        Some(path) => format!("the same command with --checkpoint {} goes on from there", path.display()),
        None => "nothing is kept of them: the image is no file, and no --checkpoint is named".to_owned(),
    };
    warn(&format!("stopped after {done}{of} samples a pixel; {on}{so_far}"));
    Ok(())
}

/// Refuses with `--shard` what needs the whole image, or more than one file.
fn check_shard(args: &RenderArgs) -> Result<()> {
    let refused = |message: &str| Err(Error::Usage(format!("--shard: {message}")));
    match () {
        _ if args.time.is_some() => {
            refused("--time ends all pixels at once, which parts that are made apart cannot: use --spp")
        }
        _ if args.target_error.is_some() => refused("--target-error goes by the noise of the whole image: use --spp"),
        _ if args.keeping.files().1.is_some() => refused("--preview shows whole images: leave it out"),
        _ if args.output.len() > 1 => refused("a part is one file: give one -o, and images to octray merge"),
        _ => args.encoding.check_part(),
    }
}

/// What a part of the picture of `settings` says of itself.
fn about(settings: &Settings, shard: Shard, frame: &Frame, recipe: &Recipe, film: &Film) -> About {
    let Crop { x, y, width, height } = frame.crop;
    About {
        recipe: recipe.0.clone(),
        metadata: film.metadata.clone(),
        film: frame.film,
        crop: [x, y, width, height],
        shard: (shard.number, shard.count),
        spp: film.spp,
        layers: part::layer_names(&film.layers),
        alpha: film.layers.alpha,
        grouped: settings.sampler == Sampler::Sobol,
    }
}

/// Everything that can be known about the outputs before the work starts.
fn check_outputs(shot: &Shot, shard: Option<Shard>) -> Result<()> {
    let images = shot.outputs.iter();
    let check = |path: &Path| if shard.is_some() { atomic::check(path) } else { check_output_path(path) };
    images.clone().try_for_each(|path| check_place(path, check))?;
    images.clone().try_for_each(|path| places::claim(path))?;
    shot.stats.iter().try_for_each(|path| check_json_path("--stats", path))
}

/// Flag over scene over default.
fn settings(args: &RenderArgs, scene: &Scene) -> Settings {
    let mut settings = scene.settings();
    args.estimator.apply(&mut settings);
    args.film.apply(&mut settings);
    args.layers.apply(&mut settings);
    settings.spp = match (args.spp, args.time.is_some() || args.target_error.is_some()) {
        (Some(spp), _) => spp,
        // Time or error alone decide: neither the scene's samples nor the default may end the render sooner.
        (None, true) => u32::MAX,
        (None, false) => settings.spp,
    };
    settings.time = args.time;
    settings.target_error = args.target_error;
    settings.engine = args.engine;
    settings.plan = args.plan.plan;
    settings.threads = args.threads.unwrap_or(0) as usize;
    settings.crop = args.crop;
    settings.shard = args.shard;
    settings
}

/// What the user should know about a finished render.
fn findings(render: &Render) -> Vec<String> {
    let stats = &render.stats;
    let mut found = Vec::new();
    if stats.nonfinite > 0 {
        let places = stats.nonfinite_samples.iter();
        let places = places.map(|f| format!("pixel {},{} sample {} in {}", f.x, f.y, f.sample, f.stage));
        let places = places.collect::<Vec<_>>().join("; ");
        found.push(format!(
            "{} samples were not finite and count as black: {places}; see octray trace",
            stats.nonfinite
        ));
    }
    if stats.guarded > 0 {
        found.push(format!(
            "{} paths were cut at the guard of {} events: the image may be too dark; use --rr-depth or --max-depth",
            stats.guarded,
            crate::settings::DEPTH_GUARD
        ));
    }
    if render.film.mean_radiance() == [0.0; 3] {
        let hint =
            "check what the camera sees and that emitters face it: they shine on the side their winding faces only";
        found.push(format!("the finished image is all black; {hint}"));
    }
    found
}

/// What the image files cannot hold as it is.
fn beyond_f32(render: &Render, outputs: &[PathBuf]) -> Option<String> {
    let film = &render.film;
    let OutOfRange { means, large_variances, small_variances } = film.out_of_range();
    let exr = outputs.iter().any(|path| matches!(Format::of(path), Ok(Format::Exr)));
    let mut parts = Vec::new();
    let mut part = |count: usize, what: &str, bound: f32| {
        if count > 0 {
            parts.push(format!("{count} pixels have {what} beyond {bound:.1e}, which stands in its place"));
        }
    };
    part(means, "a mean", f32::MAX);
    // In an image of ordinary brightness a standard deviation of 1e-19 more or less is nothing.
    let dim = film.mean_radiance().into_iter().fold(0.0, f64::max) < 1e-13;
    if exr {
        part(large_variances, "a variance", f32::MAX);
        part(if dim { small_variances } else { 0 }, "a variance", f32::MIN_POSITIVE);
    }
    let what = "error figures made of these are wrong; scale the lights' radiance";
    (!parts.is_empty()).then(|| format!("image files hold f32: {}: {what}", parts.join("; ")))
}

/// A few lines: what was written, how it was rendered, its noise, how to go on.
fn summary(settings: &Settings, render: &Render, written: &[&Path], of_sequence: bool) -> String {
    let (film, stats) = (&render.film, &render.stats);
    let bias = if settings.strategy.is_biased() { " (biased)" } else { "" };
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    let mut lines = vec![match written {
        [] => "nothing written".to_owned(),
        _ => format!("wrote {}", names.join(", ")),
    }];
    let size = match settings.shard {
        Some(shard) => format!("part {shard} of an image"),
        None => format!("{} x {} pixels", film.width, film.height),
    };
    lines.push(format!(
        "  {size}, {} sample{} a pixel, {}{bias}, {}, {} s, {} Mpaths/s",
        film.spp,
        if film.spp == 1 { "" } else { "s" },
        settings.strategy,
        settings.sampler,
        three_digits(stats.render_s),
        three_digits(stats.paths as f64 / stats.render_s.max(1e-9) * 1e-6),
    ));
    lines.extend(noise(settings, render).map(|noise| format!("  {noise}")));
    // What an interrupted render says on standard error is how to go on.
    if stats.finished && !of_sequence && settings.shard.is_none() {
        lines.extend(next_step(written).map(|step| format!("next: {step}")));
    }
    lines.join("\n") + "\n"
}

/// The noise, and what it takes to halve it or whether it is what was asked for. Nothing of a black image.
fn noise(settings: &Settings, render: &Render) -> Option<String> {
    let film = &render.film;
    if !film.sums().tell_errors() {
        let least = if settings.sampler == Sampler::Sobol { 4 } else { 2 };
        return Some(format!("noise unknown: it takes {least} samples a pixel to tell"));
    }
    let noise = film.relative_error()?;
    let unseen = render.stats.unseen_error.unwrap_or(0.0);
    let mut text = format!("noise {} of the mean radiance", percent(noise));
    match settings.target_error {
        Some(target) => {
            if unseen > 0.1 * noise {
                text += &format!(", light not met up to {}", percent(unseen));
            }
            let reached = if noise.hypot(unseen) <= target { "reached" } else { "not reached" };
            text += &format!("; the target of {} is {reached}", percent(target));
        }
        // An interrupted render has its own way to go on.
        None if noise > 0.0 && render.stats.finished => {
            text += &format!("; --spp {} halves it", u64::from(film.spp) * 4)
        }
        None => {}
    }
    Some(text)
}

/// What to do with the files that were written.
fn next_step(written: &[&Path]) -> Option<String> {
    let comparable = |path: &&&Path| matches!(Format::of(path), Ok(Format::Exr | Format::Pfm | Format::Hdr));
    let kept = written.iter().find(|path| matches!(Format::of(path), Ok(Format::Exr)));
    match kept.or_else(|| written.iter().find(comparable)) {
        Some(path) => Some(format!("octray diff {} REFERENCE.exr tells its error", path.display())),
        None if written.is_empty() => None,
        None => Some("-o NAME.exr keeps radiance and noise, which octray diff compares".to_owned()),
    }
}
