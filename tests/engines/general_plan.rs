//! Plans that leave nothing out: the same pictures, bit for bit, and what they say of themselves.

use crate::common::{first_difference, prepared, rooms, small, windows};
use octray::internal::packet::explain;
use octray::internal::packet::plan::Plan;
use octray::internal::setup::Setup;
use octray::{
    Engine, Guide, Lights, PlanChoice, PreparedScene, Roulette, Sampler, Scene, Settings, Strategy, Train, render,
};

/// Renders by every plan, and by the scalar engine, which knows of none.
fn all_alike(scene: &PreparedScene, settings: &Settings, what: &str) {
    let own = render(scene, &Settings { plan: PlanChoice::Scene, ..settings.clone() }).film;
    let scalar = render(scene, &Settings { engine: Engine::Scalar, ..settings.clone() }).film;
    assert_eq!(first_difference(&own, &scalar), None, "{what}: scalar");
    for &plan in &PlanChoice::ALL[1..] {
        let film = render(scene, &Settings { plan, ..settings.clone() }).film;
        assert_eq!(first_difference(&own, &film), None, "{what}: --plan {plan}");
    }
}

#[test]
fn no_part_that_is_put_back_changes_a_bit_of_the_shipped_scenes() {
    let mut count = 0;
    for entry in std::fs::read_dir("scenes").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let scene = prepared(path.to_str().unwrap());
        for (number, &strategy) in Strategy::ALL.iter().enumerate() {
            let sampler = Sampler::ALL[number % 2];
            let lights = [Lights::Tree, Lights::Power, Lights::Uniform][number % 3];
            let settings = Settings { strategy, sampler, lights, max_depth: Some(6), ..small(24, 16, 2) };
            all_alike(&scene, &settings, &format!("{}, {strategy}, {sampler}, {lights}", path.display()));
        }
        count += 1;
    }
    assert!(count >= 10, "{count} scenes");
}

/// Where shadow rays miss the lamps they are sent to by rounding, which is rare: of so many samples some do on these plates.
#[test]
fn nor_where_shadow_rays_miss_their_lamps() {
    let scene = prepared("scenes/glossy_plates.toml");
    let settings = Settings { max_depth: Some(4), ..small(256, 192, 4) };
    all_alike(&scene, &settings, "glossy_plates");
}

#[test]
fn nor_of_scenes_made_in_code_nor_of_what_is_learned() {
    let builtin = |name: &str| Scene::load(name).unwrap().prepare().unwrap();
    let scenes = [
        ("heavy", builtin("builtin:heavy:2000")),
        ("hall", builtin("builtin:lamp_hall:100")),
        ("rooms", builtin("builtin:rooms")),
        ("rooms with sky", rooms(true)),
        ("windows", windows(false)),
        ("windows and lamps", windows(true)),
        ("cornell", prepared("scenes/cornell.toml")),
        ("leaves", prepared("scenes/leaves.toml")),
    ];
    for (name, scene) in scenes {
        for lights in [Lights::Learned, Lights::NeePlusPlus] {
            for (guide, roulette) in [(Guide::Off, Roulette::Albedo), (Guide::On, Roulette::Learned)] {
                let train = Train::Paths(2048);
                let settings = Settings { lights, guide, roulette, train, max_depth: Some(5), ..small(20, 14, 2) };
                all_alike(&scene, &settings, &format!("{name}, {lights}, guide {guide}"));
            }
        }
    }
}

#[test]
fn the_general_plan_holds_every_stage_and_leaves_out_no_part() {
    let scene = prepared("scenes/cornell.toml");
    let told = |plan: PlanChoice| {
        let setup = Setup::new(&scene, &Settings { plan, ..Settings::plain() });
        let stages = explain::stages(&setup, &Plan::new(&setup));
        let stages: Vec<&str> = stages.iter().map(|planned| planned.stage).collect();
        (stages, explain::left_out(&setup).iter().map(|left| left.what).collect::<Vec<_>>())
    };
    let (stages, left_out) = told(PlanChoice::General);
    let general = ["shade_mirror", "shade_dielectric", "shade_conductor", "shade_plastic", "shade_principled"];
    for stage in ["shade_miss", "shade_emitter"].into_iter().chain(general) {
        assert!(stages.contains(&stage), "{stage} of {stages:?}");
    }
    assert_eq!(left_out, Vec::<&str>::new());
    let (own, left_out) = told(PlanChoice::Scene);
    assert!(own.len() < stages.len() && left_out.contains(&"textures") && left_out.contains(&"lens"));
    assert!(!told(PlanChoice::Lens).1.contains(&"lens") && told(PlanChoice::Lens).1.contains(&"textures"));
}
