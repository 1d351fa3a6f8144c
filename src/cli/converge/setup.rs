//! From flags to an experiment.

use crate::api::Scene;
use crate::camera;
use crate::cli::args;
use crate::cli::args::RrDepth;
use crate::cli::converge::ConvergeArgs;
use crate::cli::diff::explain;
use crate::cli::warn;
use crate::error::{Error, Result};
use crate::image::Image;
use crate::report::measure::experiment::{Budget, Case, Configuration, Experiment};
use crate::report::measure::metrics;
use crate::report::measure::run_error::Region;
use crate::report::measure::truth::{Reference, Source};
use crate::scene::SceneDesc;
use crate::settings::{Crop, Settings};
use crate::setup::frame::Frame;
use std::path::Path;

/// `[NAME=]X,Y,W,H`.
pub fn region(text: &str) -> std::result::Result<(String, Crop), String> {
    let (name, place) = text.rsplit_once('=').unwrap_or((text, text));
    match name.trim() {
        "" => Err("give the region a name before the `=`, or leave the `=` out".into()),
        name => Ok((name.to_owned(), args::crop(place)?)),
    }
}

/// Loads the scene and lays out what is to be run.
pub fn experiment(args: &ConvergeArgs) -> Result<Experiment> {
    let scene = Scene::load(&args.scene)?;
    scene.desc.warnings.iter().for_each(|warning| warn(warning));
    let of_scene = scene.settings();
    let settings = Settings {
        width: Some(args.width),
        height: Some(args.height),
        max_depth: args.max_depth.or(of_scene.max_depth),
        rr_depth: args.rr_depth.map_or(of_scene.rr_depth, |RrDepth(depth)| depth),
        seed: args.seed,
        threads: args.threads.unwrap_or(0) as usize,
        ..of_scene
    };
    let film = Frame::new(&settings, scene.desc.film)?.film;
    camera::warnings(&scene.desc.camera, film.1).iter().for_each(|warning| warn(warning));
    let mut configurations = Vec::new();
    for &engine in args.engine.as_ref().map_or(&[settings.engine][..], |list| &list.0) {
        for &sampler in args.sampler.as_ref().map_or(&[settings.sampler][..], |list| &list.0) {
            for &lights in args.lights.as_ref().map_or(&[settings.lights][..], |list| &list.0) {
                let each = args.strategies.0.iter();
                configurations.extend(each.map(|&strategy| Configuration { strategy, lights, sampler, engine }));
            }
        }
    }
    let regions = args.region.iter().map(|(name, area)| checked_region(name, *area, film)).collect::<Result<_>>()?;
    let cases = cases(&scene, &args.only_light)?;
    Ok(Experiment { cases, configurations, budgets: budgets(args), repeats: args.repeats, settings, regions })
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

/// What shines in a scene: materials in the order of the scene, then the surroundings.
fn lights(desc: &SceneDesc) -> Vec<String> {
    let placed = || desc.instances.iter().flat_map(|instance| &desc.meshes[instance.mesh as usize].triangles);
    let used = |index: usize| placed().any(|triangle| triangle.material as usize == index);
    let shining = desc.materials.iter().enumerate();
    let shining = shining.filter(|(index, m)| m.emission.iter().any(|e| *e > 0.0) && used(*index));
    let surroundings = desc.environment().into_iter().map(|_| ENVIRONMENT.to_owned());
    shining.map(|(_, material)| material.name.clone()).chain(surroundings).collect()
}

const ENVIRONMENT: &str = "environment";
const ALL: &str = "all";
const EACH: &str = "each";

/// The scenes that `--only-light` asks for.
fn cases(scene: &Scene, asked: &[String]) -> Result<Vec<Case>> {
    let known = lights(&scene.desc);
    let mut names = Vec::new();
    let default = [ALL.to_owned()];
    for name in if asked.is_empty() { &default } else { asked } {
        match name.as_str() {
            EACH => names.extend(std::iter::once(ALL.to_owned()).chain(known.iter().cloned())),
            ALL => names.push(ALL.to_owned()),
            name if known.iter().any(|light| light == name) => names.push(name.to_owned()),
            _ => {
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                return Err(Error::Usage(format!(
                    "--only-light {name}: no material of that name shines in {}; its lights: {known} (or `all`, `each`)",
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
    names.into_iter().map(|name| case(scene, name)).collect()
}

fn case(scene: &Scene, light: String) -> Result<Case> {
    let mut only = scene.clone();
    if light != ALL {
        for material in only.desc.materials.iter_mut().filter(|material| material.name != light) {
            material.emission = [0.0; 3];
            material.emission_texture = None;
        }
        if light != ENVIRONMENT {
            only.desc.set_environment(None);
        }
    }
    let prepared = only.prepare()?;
    if light == ALL {
        prepared.warnings.iter().for_each(|warning| warn(warning));
    }
    Ok(Case { light, desc: only.desc, scene: prepared })
}

/// How a reference is rendered: by the strategy that loses least anywhere, in the fast engine.
pub fn reference_configuration(experiment: &Experiment) -> Configuration {
    let Settings { lights, sampler, .. } = experiment.settings;
    let Settings { strategy, engine, .. } = Settings::default();
    Configuration { strategy, lights, sampler, engine }
}

/// `--reference FILE`.
pub fn reference_from_file(path: &Path, experiment: &Experiment) -> Result<Reference> {
    if experiment.cases.len() > 1 {
        let message = "--reference shows one scene; with several --only-light leave it out or measure one at a time";
        return Err(Error::Usage(message.into()));
    }
    let image = Image::read(path)?;
    let (width, height) = experiment.film();
    if (image.width, image.height) != (width, height) {
        return Err(Error::Usage(format!(
            "--reference {}: it has {} x {} pixels and the film {width} x {height}; give --width {} --height {} or another \
             reference",
            path.display(),
            image.width,
            image.height,
            image.width,
            image.height
        )));
    }
    if image.windows.is_some() {
        return Err(Error::Usage(format!(
            "--reference {}: it is a crop, or its pixels lie elsewhere than in the film; render the whole film",
            path.display()
        )));
    }
    metrics::check(&image, &image).map_err(|fault| explain(fault, path, path))?;
    Ok(Reference { image, source: Source::File { path: path.display().to_string() } })
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
    fn regions_may_have_names() {
        let area = Crop { x: 1, y: 2, width: 3, height: 4 };
        assert_eq!(region("plate=1,2,3,4"), Ok(("plate".into(), area)));
        assert_eq!(region("1,2,3,4"), Ok(("1,2,3,4".into(), area)));
        for text in ["=1,2,3,4", "plate=", "plate=1,2,3", "plate=1,2,0,4"] {
            assert!(region(text).is_err(), "{text}");
        }
    }

    #[test]
    fn every_light_of_a_scene_by_itself() {
        let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/lecture_lights.toml")).unwrap();
        let found = cases(&scene, &["each".into(), "blue".into()]).unwrap();
        assert_eq!(found.iter().map(|case| case.light.as_str()).collect::<Vec<_>>(), ["all", "blue", "grey"]);
        let shining = |case: &Case| case.desc.materials.iter().filter(|m| m.emission != [0.0; 3]).count();
        assert_eq!(found.iter().map(shining).collect::<Vec<_>>(), [2, 1, 1]);
        let error = cases(&scene, &["red".into()]).err().unwrap().to_string();
        assert!(error.contains("its lights: blue, grey"), "{error}");
    }
}
