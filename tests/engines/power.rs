//! Lights chosen by power: what is drawn is what estimators are told, however far powers lie apart.

use crate::common::{Maker, estimate, first_difference, small};
use octray::internal::sampler::{random_words, unit};
use octray::internal::tables::lights::table::{Fixed, LightTable, Selection};
use octray::scene::desc::EnvironmentDesc;
use octray::{Engine, Lights, PreparedScene, Settings, Strategy, render};

/// A lamp of one triangle for each radiance, in a row above a floor.
fn lamps(radiances: &[f64], environment: bool) -> PreparedScene {
    let mut maker = Maker::default();
    let floor = maker.diffuse([0.5; 3], [0.0; 3]);
    maker.quad([[-5.0, 0.0, 5.0], [5.0, 0.0, 5.0], [5.0, 0.0, -5.0], [-5.0, 0.0, -5.0]], floor);
    for (i, &radiance) in radiances.iter().enumerate() {
        let material = maker.diffuse([0.0; 3], [radiance; 3]);
        let x = i as f32 * 0.01;
        maker.quad([[x, 1.0, 0.0], [x + 0.008, 1.0, 0.0], [x + 0.008, 1.0, 0.008], [x, 1.0, 0.008]], material);
        maker.mesh.triangles.pop();
    }
    if environment {
        maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    }
    maker.seen([0.0, 2.0, 3.0], [0.0; 3], 40.0)
}

/// Radiances alike, apart by 1e12 and 1e30, and of every power of ten in between.
fn radiances() -> Vec<Vec<f64>> {
    let random = |n: u32, span: f64| {
        let exponent = |i: u32| span * (f64::from(unit(random_words(i, n, 3, 5)[0])) - 0.5);
        (0..n).map(|i| 10f64.powf(exponent(i))).collect::<Vec<f64>>()
    };
    let mut list = vec![vec![1.0; 7], vec![1.0, 1e12], vec![1e30, 1.0], vec![1e-12, 1.0, 1.0, 1.0, 1e12]];
    list.extend([random(3, 30.0), random(100, 2.0), random(1000, 0.1), random(1000, 40.0)]);
    list
}

/// How many of the words that are multiples of `step` choose each lamp: by bisection, since in a column of the table the
/// choice changes once.
fn words_by_lamp(fixed: &Fixed, count: u64, step: u64) -> Vec<u64> {
    let mut words = vec![0; count as usize];
    let choose = |index: u64| fixed.choose((index * step) as u32);
    for column in 0..count {
        let first = |column: u64| (column << 32).div_ceil(count * step);
        let (begin, end) = (first(column), first(column + 1));
        let own = choose(begin);
        let (mut low, mut high) = (begin, end - 1);
        let other = choose(high);
        while low < high {
            let middle = (low + high).div_ceil(2);
            if choose(middle) == own { low = middle } else { high = middle - 1 }
        }
        words[own as usize] += low + 1 - begin;
        words[other as usize] += end - (low + 1);
    }
    words
}

#[test]
fn lamps_are_chosen_as_often_as_is_stated_and_none_is_forgotten() {
    for radiances in radiances() {
        for environment in [false, true] {
            let scene = lamps(&radiances, environment);
            let table = LightTable::new(&scene, Lights::Power, false);
            let Selection::Fixed(fixed @ Fixed::Alias(_)) = &table.selection else { panic!("an alias table") };
            let n = radiances.len();
            assert_eq!(table.probabilities.len(), n);
            // Beside an environment half of the samples go to lamps, and words have three bits less.
            let (part, step) = if environment { (0.5, 8) } else { (1.0, 1) };
            let words = words_by_lamp(fixed, n as u64, step);
            assert_eq!(words.iter().sum::<u64>(), (1 << 32) / step);
            for (i, &words) in words.iter().enumerate() {
                let drawn = words as f64 * step as f64 / 2f64.powi(32) * part;
                let stated = table.probability(i as u32);
                assert_eq!(stated, drawn as f32, "lamp {i} of {n}");
                assert!(f64::from(stated) >= 1.0 / (16.0 * n as f64), "lamp {i} of {n}: {stated}");
            }
            // Lamps that need no raising keep their proportions.
            let total: f64 = radiances.iter().sum();
            let brightest = (0..n).max_by(|&a, &b| radiances[a].total_cmp(&radiances[b])).expect("a lamp");
            for (i, radiance) in radiances.iter().enumerate().filter(|(_, r)| **r / total > 0.2 / n as f64) {
                let ratio = f64::from(table.probability(i as u32)) / f64::from(table.probability(brightest as u32));
                assert!((ratio / (radiance / radiances[brightest]) - 1.0).abs() < 1e-4, "lamp {i} of {n}: {ratio}");
            }
        }
    }
}

/// A dim lamp beside one 1e12 times as strong that shines the other way: light samples by power find it, in both engines.
#[test]
fn a_dim_lamp_is_found_beside_one_that_outshines_it() {
    for contrast in [1e3, 1e12, 1e25] {
        let mut maker = Maker::default();
        let floor = maker.diffuse([0.5; 3], [0.0; 3]);
        let (dim, bright) = (maker.diffuse([0.0; 3], [1.0; 3]), maker.diffuse([0.0; 3], [contrast; 3]));
        maker.quad([[-2.0, 0.0, 2.0], [2.0, 0.0, 2.0], [2.0, 0.0, -2.0], [-2.0, 0.0, -2.0]], floor);
        maker.quad([[-0.2, 1.0, -0.2], [0.3, 1.0, -0.2], [0.3, 1.0, 0.3], [-0.2, 1.0, 0.3]], dim);
        // Turned over: it shines upwards.
        maker.quad([[-0.8, 1.0, 0.3], [-0.3, 1.0, 0.3], [-0.3, 1.0, -0.2], [-0.8, 1.0, -0.2]], bright);
        let scene = maker.seen([0.0, 0.5, 0.4], [0.0; 3], 1.0);
        let with = |lights, spp| {
            let settings = Settings { strategy: Strategy::Nee, lights, max_depth: Some(1), ..small(8, 8, spp) };
            let film = render(&scene, &settings).film;
            let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings }).film;
            assert_eq!(first_difference(&film, &scalar), None, "{lights}, {contrast:e}");
            estimate(&film, 0..8, 0..8, 0)
        };
        let [uniform, power, tree] = [Lights::Uniform, Lights::Power, Lights::Tree].map(|lights| with(lights, 1024));
        for (name, got) in [("power", power), ("tree", tree)] {
            let z = (got.mean - uniform.mean) / got.error.hypot(uniform.error);
            assert!(z.abs() < 5.0, "{name}, {contrast:e}: {} +- {}, not {}", got.mean, got.error, uniform.mean);
            assert!(got.error < 0.05 * got.mean, "{name}, {contrast:e}: {} +- {} proves nothing", got.mean, got.error);
        }
    }
}
