//! From flags to an experiment.

use crate::api::Scene;
use crate::camera;
use crate::cli::args::RrDepth;
use crate::cli::converge::flags::ConvergeArgs;
use crate::cli::diff::explain;
use crate::cli::progress::load;
use crate::cli::{warn, warn_of};
use crate::error::{Error, Result};
use crate::image::Image;
use crate::report::measure::experiment::{ALL_LIGHTS, Budget, Case, Configuration, Experiment};
use crate::report::measure::metrics;
use crate::report::measure::run_error::Region;
use crate::report::measure::truth::{Reference, Source};
use crate::scene::SceneDesc;
use crate::scene::desc::LightDesc;
use crate::settings::{Crop, Lights, Settings};
use crate::setup::frame::Frame;
use crate::setup::unseen;
use std::path::{Path, PathBuf};

/// Loads the scenes and lays out what is to be run.
pub fn experiment(args: &ConvergeArgs) -> Result<Experiment> {
    let seen = |path: &PathBuf| {
        let mut scene = load(path, args.quiet)?;
        args.view.apply(&mut scene.desc)?;
        Ok(scene)
    };
    let scenes: Vec<Scene> = args.scenes.iter().map(seen).collect::<Result<_>>()?;
    let names = scene_names(&args.scenes);
    let of_scenes = shared_settings(&scenes);
    let settings = Settings {
        width: Some(args.width),
        height: Some(args.height),
        seed: args.seed,
        threads: args.threads.unwrap_or(0) as usize,
        train: args.train.unwrap_or(of_scenes.train),
        ..of_scenes
    };
    let mut cases = Vec::new();
    for (scene, name) in scenes.iter().zip(&names) {
        scene.desc.warnings.iter().for_each(|warning| warn(warning));
        let film = Frame::new(&settings, scene.desc.film)?.film;
        camera::warnings(&scene.desc.camera, film.1).iter().for_each(|warning| warn(warning));
        cases.extend(cases_of(scene, name, args)?);
    }
    let mut configurations = Vec::new();
    for &engine in args.engine.as_ref().map_or(&[settings.engine][..], |list| &list.0) {
        for &sampler in args.sampler.as_ref().map_or(&[settings.sampler][..], |list| &list.0) {
            for &lights in args.lights.as_ref().map_or(&[settings.lights][..], |list| &list.0) {
                for &guide in args.guide.as_ref().map_or(&[settings.guide][..], |list| &list.0) {
                    let each = args.strategies.0.iter();
                    let of = |&strategy| Configuration { strategy, lights, guide, sampler, engine };
                    configurations.extend(each.map(of));
                }
            }
        }
    }
    for strategy in &args.strategies.0 {
        // Of one scene all cases have the same name.
        let mut told: Vec<String> = cases.iter().filter_map(|case| unseen(&case.scene, *strategy)).collect();
        told.dedup();
        told.iter().for_each(|warning| warn(warning));
    }
    let film = (args.width, args.height);
    let regions = args.region.iter().map(|(name, area)| checked_region(name, *area, film)).collect::<Result<_>>()?;
    Ok(Experiment {
        cases,
        configurations,
        others: Vec::new(),
        others_runs: Vec::new(),
        others_images: Vec::new(),
        budgets: budgets(args),
        repeats: args.repeats,
        reach: args.reach,
        settings,
        regions,
        exposure: args.exposure,
        shard: args.shard,
    })
}

/// What scenes are called: their files' stems, numbered where two are alike.
fn scene_names(paths: &[PathBuf]) -> Vec<String> {
    let stem = |path: &PathBuf| match path.to_str().filter(|text| text.starts_with(BUILTIN)) {
        // `builtin:heavy:20000` has no directory and no extension.
        Some(text) => text[BUILTIN.len()..].replace(':', "-"),
        None => path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned()),
    };
    let mut names: Vec<String> = Vec::new();
    for path in paths {
        let first = stem(path);
        let mut name = first.clone();
        let mut number = 2;
        while names.contains(&name) {
            name = format!("{first}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

const BUILTIN: &str = "builtin:";

/// The settings of the scenes where all agree, else the defaults: what is compared over scenes has to be one thing.
fn shared_settings(scenes: &[Scene]) -> Settings {
    // What is compared with what is said by flags; nothing is learned but by them.
    let all: Vec<Settings> = scenes.iter().map(|scene| scene.settings().without_learning()).collect();
    let first = all[0].clone();
    let default = Settings::plain();
    let agree = |same: fn(&Settings, &Settings) -> bool| all.iter().all(|other| same(&first, other));
    let (lights, sampler) = (agree(|a, b| a.lights == b.lights), agree(|a, b| a.sampler == b.sampler));
    for (alike, what, taken) in
        [(lights, "light selection", default.lights.name()), (sampler, "sampler", default.sampler.name())]
    {
        if !alike {
            warn(&format!("the scenes' files name different defaults of the {what}: all are measured with {taken}"));
        }
    }
    Settings {
        lights: if lights { first.lights } else { default.lights },
        sampler: if sampler { first.sampler } else { default.sampler },
        ..first
    }
}

/// Ascending, each once.
fn budgets(args: &ConvergeArgs) -> Vec<Budget> {
    if args.times.is_empty() {
        let mut spps = args.spps.clone();
        spps.sort_unstable();
        spps.dedup();
        return spps.into_iter().map(Budget::Spp).collect();
    }
    let mut times = args.times.clone();
    times.sort_unstable();
    times.dedup();
    times.into_iter().map(Budget::Time).collect()
}

fn checked_region(name: &str, area: Crop, film: (u32, u32)) -> Result<Region> {
    let whole = Settings { width: Some(film.0), height: Some(film.1), crop: Some(area), ..Settings::default() };
    let inside = Frame::new(&whole, film).map_err(|error| Error::Usage(format!("--region {name}: {error}")));
    inside.map(|_| Region { name: name.to_owned(), area })
}

/// What shines in a scene: materials in the order of the scene, then delta lights, then the surroundings.
fn lights(desc: &SceneDesc) -> Vec<String> {
    let placed = || desc.instances.iter().flat_map(|instance| &desc.meshes[instance.mesh as usize].triangles);
    let used = |index: usize| placed().any(|triangle| triangle.material as usize == index);
    let shining = desc.materials.iter().enumerate();
    let shining = shining.filter(|(index, m)| m.emission.iter().any(|e| *e > 0.0) && used(*index));
    let surroundings = desc.environment().into_iter().map(|_| ENVIRONMENT.to_owned());
    let deltas = desc.delta_lights().map(|light| light.name.clone());
    shining.map(|(_, material)| material.name.clone()).chain(deltas).chain(surroundings).collect()
}

const ENVIRONMENT: &str = "environment";
const EACH: &str = "each";

/// The cases of one scene that `--only-light` asks for.
fn cases_of(scene: &Scene, name: &str, args: &ConvergeArgs) -> Result<Vec<Case>> {
    let known = lights(&scene.desc);
    let mut names = Vec::new();
    let default = [ALL_LIGHTS.to_owned()];
    for light in if args.only_light.is_empty() { &default[..] } else { &args.only_light } {
        match light.as_str() {
            // One light by itself is the whole scene.
            EACH if known.len() == 1 => names.push(ALL_LIGHTS.to_owned()),
            EACH => names.extend(std::iter::once(ALL_LIGHTS.to_owned()).chain(known.iter().cloned())),
            light if light == ALL_LIGHTS || known.iter().any(|known| known == light) => names.push(light.to_owned()),
            _ => {
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                return Err(Error::Usage(format!(
                    "--only-light {light}: nothing of that name shines in {}; its lights: {known} (or `all`, `each`)",
                    scene.desc.name
                )));
            }
        }
    }
    let mut seen = Vec::new();
    names.retain(|name| {
        !seen.contains(name) && {
            seen.push(name.clone());
            true
        }
    });
    names.into_iter().map(|light| case(scene, name, light, args)).collect()
}

fn case(scene: &Scene, name: &str, light: String, args: &ConvergeArgs) -> Result<Case> {
    let mut only = scene.clone();
    let whole = light == ALL_LIGHTS;
    if !whole {
        for material in only.desc.materials.iter_mut().filter(|material| material.name != light) {
            material.emission = [0.0; 3];
            material.emission_texture = None;
        }
        if light != ENVIRONMENT {
            only.desc.set_environment(None);
        }
        only.desc.lights.retain(|other| !matches!(other, LightDesc::Delta(delta) if delta.name != light));
    }
    let prepared = only.prepare()?;
    if whole {
        prepared.warnings.iter().for_each(|warning| warn(warning));
    }
    let of_scene = scene.settings();
    Ok(Case {
        scene_name: name.to_owned(),
        light,
        desc: only.desc,
        scene: prepared,
        max_depth: args.max_depth.or(of_scene.max_depth),
        rr_depth: args.rr_depth.map_or(of_scene.rr_depth, |RrDepth(depth)| depth),
    })
}

/// How a reference is rendered: by the strategy that loses least anywhere, in the fast engine, with nothing learned.
pub fn reference_configuration(experiment: &Experiment) -> Configuration {
    let Settings { lights, sampler, .. } = experiment.settings;
    let lights = if lights.learns() { Lights::Tree } else { lights };
    let Settings { strategy, engine, guide, .. } = Settings::plain();
    Configuration { strategy, lights, guide, sampler, engine }
}

/// `--reference FILE`, once for every case, in their order; `None` where none is given.
pub fn references_from_files(paths: &[PathBuf], experiment: &Experiment) -> Result<Option<Vec<Reference>>> {
    if paths.is_empty() {
        return Ok(None);
    }
    if paths.len() != experiment.cases.len() {
        let cases: Vec<String> = (0..experiment.cases.len()).map(|case| experiment.case_title(case)).collect();
        return Err(Error::Usage(format!(
            "--reference: {} for {} cases; name one for each, in this order: {}",
            paths.len(),
            cases.len(),
            cases.join("; ")
        )));
    }
    paths.iter().map(|path| reference_from_file(path, experiment)).collect::<Result<_>>().map(Some)
}

fn reference_from_file(path: &Path, experiment: &Experiment) -> Result<Reference> {
    let image = whole_image(path, "--reference", experiment)?;
    Ok(Reference { image, source: Source::File { path: path.display().to_string() } })
}

/// An image of the whole film that `flag` names.
pub fn whole_image(path: &Path, flag: &str, experiment: &Experiment) -> Result<Image> {
    let image = Image::read(path)?;
    warn_of(&format!("{flag} {}", path.display()), &image);
    let (width, height) = experiment.film();
    if (image.width, image.height) != (width, height) {
        return Err(Error::Usage(format!(
            "{flag} {}: it has {} x {} pixels and the film {width} x {height}; give --width {} --height {} or another image",
            path.display(),
            image.width,
            image.height,
            image.width,
            image.height
        )));
    }
    if image.windows.is_some() {
        return Err(Error::Usage(format!(
            "{flag} {}: it is a crop, or its pixels lie elsewhere than in the film; render the whole film",
            path.display()
        )));
    }
    metrics::check(&image, &image).map_err(|fault| explain(fault, path, path))?;
    Ok(image)
}

/// What was typed, as a shell takes it.
pub fn command() -> String {
    let quoted = |argument: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
        match !argument.is_empty() && argument.chars().all(plain) {
            true => argument,
            false => format!("'{}'", argument.replace('\'', "'\\''")),
        }
    };
    let arguments = std::env::args_os().skip(1).map(|argument| quoted(argument.to_string_lossy().into_owned()));
    std::iter::once("octray".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_called_by_their_files_and_never_alike() {
        let paths = ["a/room.toml", "b/room.toml", "builtin:heavy:20000", "room.obj", "x"].map(PathBuf::from);
        assert_eq!(scene_names(&paths), ["room", "room-2", "heavy-20000", "room-3", "x"]);
    }

    #[test]
    fn every_light_of_a_scene_by_itself() {
        use clap::Parser;
        #[derive(Parser)]
        struct Flags {
            #[command(flatten)]
            converge: ConvergeArgs,
        }
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/lecture_lights.toml");
        let scene = Scene::load(path).unwrap();
        let cases = |lights: &[&str]| {
            let only = lights.iter().flat_map(|light| ["--only-light", light]);
            let flags = Flags::parse_from(["x", path, "--out", "x"].into_iter().chain(only)).converge;
            cases_of(&scene, "lecture_lights", &flags)
        };
        let found = cases(&["each", "blue"]).unwrap();
        assert_eq!(found.iter().map(|case| case.light.as_str()).collect::<Vec<_>>(), ["all", "blue", "grey"]);
        let shining = |case: &Case| case.desc.materials.iter().filter(|m| m.emission != [0.0; 3]).count();
        assert_eq!(found.iter().map(shining).collect::<Vec<_>>(), [2, 1, 1]);
        let one = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml");
        let flags = Flags::parse_from(["x", one, "--out", "x", "--only-light", "each"]).converge;
        assert_eq!(cases_of(&Scene::load(one).unwrap(), "cornell", &flags).unwrap().len(), 1);
        let error = cases(&["red"]).err().unwrap().to_string();
        assert!(error.contains("its lights: blue, grey"), "{error}");
    }
}
