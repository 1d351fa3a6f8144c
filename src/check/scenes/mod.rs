//! The scenes of the suite, by name: `check:NAME:NUMBER:..`, which `octray trace` takes like a file.
//!
//! A scene is a function of its numbers alone, so that a row which fails can be looked at path by path.

pub mod closed;
pub mod floors;
pub mod lamps;
pub mod maker;
pub mod mirrors;
pub mod places;
pub mod rooms;
pub mod skies;

use crate::api::Scene;
use crate::error::{Error, Result};
use crate::nearest::close;
use crate::scene::SceneDesc;

/// A scene of the suite.
pub struct SceneMaker {
    /// Its name.
    pub name: &'static str,
    /// What its numbers mean, in order; each must be given.
    pub numbers: &'static [&'static str],
    /// Makes it from its numbers.
    pub make: fn(&[f64]) -> SceneDesc,
}

/// All of them.
const ALL: &[&[SceneMaker]] =
    &[rooms::SCENES, lamps::SCENES, skies::SCENES, floors::SCENES, closed::SCENES, places::SCENES, mirrors::SCENES];

/// What a path begins with that names one of these scenes.
pub const PREFIX: &str = "check:";

/// The scene that `name` means, `PREFIX` left out.
///
/// # Errors
/// [`Error::Scene`] if there is none of that name, or if its numbers are not as it wants them.
pub fn load(name: &str) -> Result<Scene> {
    let fault = |message: String| Err(Error::Scene { scene: format!("{PREFIX}{name}"), message });
    let mut parts = name.split(':');
    let wanted = parts.next().unwrap_or_default();
    let Some(maker) = ALL.iter().flat_map(|makers| makers.iter()).find(|maker| maker.name == wanted) else {
        let names = || ALL.iter().flat_map(|makers| makers.iter().map(|maker| maker.name));
        return fault(match close(wanted, names()) {
            Some(near) => format!("the suite has no such scene; did you mean `{PREFIX}{near}`?"),
            None => format!("the suite has no such scene; known: {}", names().collect::<Vec<_>>().join(", ")),
        });
    };
    let numbers: Option<Vec<f64>> = parts.map(|part| part.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.filter(|numbers| numbers.len() == maker.numbers.len()) {
        Some(numbers) => Ok(scene(maker, &numbers)),
        None => fault(format!("numbers wanted behind the name: {}", maker.numbers.join(", "))),
    }
}

/// A scene, with the name by which [`load`] finds it again.
fn scene(maker: &SceneMaker, numbers: &[f64]) -> Scene {
    let mut desc = (maker.make)(numbers);
    let numbers: String = numbers.iter().map(|number| format!(":{number:e}")).collect();
    desc.name = format!("{PREFIX}{}{numbers}", maker.name);
    Scene::from(desc)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_once_and_faults_are_told() {
        let mut names: Vec<&str> = ALL.iter().flat_map(|makers| makers.iter().map(|maker| maker.name)).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "a name stands for one scene");
        let fault = |name: &str| load(name).map(|scene| scene.desc.name).unwrap_err().to_string();
        assert!(fault("corridr:1").contains("did you mean `check:corridor`"));
        for name in ["corridor", "corridor:x", "corridor:inf", "corridor:1:2"] {
            assert!(fault(name).contains("numbers wanted"), "{name}");
        }
        let named = load("corridor:1000").unwrap().desc.name;
        assert_eq!(load(&named["check:".len()..]).unwrap().desc.name, named);
    }
}
