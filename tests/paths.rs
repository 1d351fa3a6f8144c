//! Whole paths: the packet engine has the bits of the scalar reference, whatever the threads, passes and crops.

mod common;

use common::{SCENES, first_difference, prepared, small};
use octray::{Crop, Engine, Lights, Settings, Strategy, render};

#[test]
fn engines_agree_bit_for_bit_on_every_scene_and_strategy() {
    for path in SCENES {
        let scene = prepared(path);
        for &strategy in Strategy::ALL {
            for (lights, max_depth) in [(Lights::Uniform, None), (Lights::Power, Some(3))] {
                let settings = Settings { strategy, lights, max_depth, ..small(33, 27, 3) };
                let packet = render(&scene, &settings);
                let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings });
                let difference = first_difference(&packet.film, &scalar.film);
                assert_eq!(difference, None, "{path}, {strategy}, {lights}, depth {max_depth:?}");
                assert_eq!(packet.stats.rays, scalar.stats.rays, "{path}, {strategy}");
                assert_eq!((packet.stats.nonfinite, packet.stats.guarded), (0, 0), "{path}, {strategy}");
            }
        }
    }
}
