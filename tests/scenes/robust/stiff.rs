//! Stiff cases: everything touches, or is a billion times larger than its neighbour.

use super::shapes::{add, prism, render_sanely, skew, sphere};
use crate::common::{Maker, exact_strategies, small};
use octray::scene::desc::{EnvironmentDesc, Scattering};
use octray::{Lights, PreparedScene, Settings, Strategy};

const DARK: [f64; 3] = [0.0; 3];

/// A square facing up (or down) at height `y`.
fn level(maker: &mut Maker, y: f32, half: f32, down: bool, material: u32) {
    let mut corners = [[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]];
    if down {
        corners.reverse();
    }
    maker.quad(corners, material);
}

/// Every strategy and both light selections, at several depths.
fn assert_sane(scene: &PreparedScene, what: &str) {
    for &strategy in Strategy::ALL {
        for (lights, max_depth) in [(Lights::Uniform, Some(20)), (Lights::Power, Some(1)), (Lights::Power, Some(0))] {
            let settings = Settings { strategy, lights, max_depth, ..small(12, 12, 4) };
            let film = render_sanely(scene, &settings, &format!("{what}, {strategy}, {lights}, depth {max_depth:?}"));
            let squares = film.squares.iter().flat_map(|squares| squares.0);
            let groups = film.groups.iter().flat_map(|groups| groups.0.into_iter().flatten());
            let mut sums = film.pixels.iter().flat_map(|pixel| pixel.sum).chain(squares).chain(groups);
            assert!(
                sums.all(|x| x.is_finite() && x >= 0.0),
                "{what}, {strategy}: sums must be finite and not negative"
            );
        }
    }
}

#[test]
fn lights_that_touch_or_nearly_touch() {
    for (what, height) in [("in the floor's plane", 0.0), ("1e-4 above", 1e-4), ("1e-6 above", 1e-6), ("1e-30", 1e-30)]
    {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.8; 3], DARK), maker.diffuse([0.3; 3], [5.0; 3]));
        level(&mut maker, 0.0, 1.0, false, grey);
        level(&mut maker, height, 0.4, true, lamp);
        assert_sane(&maker.seen([0.0, 0.6, 2.0], [0.0, 0.0, 0.0], 50.0), &format!("a light {what}"));
    }
    let mut maker = Maker::default();
    let (grey, lamp) = (maker.diffuse([0.8; 3], DARK), maker.diffuse([0.0; 3], [5.0; 3]));
    maker.cuboid([-1.0; 3], [1.0; 3], true, grey);
    // Its edge lies in the wall, its back in the ceiling.
    maker.quad([[-1.0, 1.0, -0.3], [0.0, 1.0, -0.3], [0.0, 1.0, 0.3], [-1.0, 1.0, 0.3]], lamp);
    assert_sane(&maker.seen([0.0, 0.0, 0.9], [0.0, 0.2, -1.0], 80.0), "a light touching a wall");
}

/// A light close above a floor: all of it arrives. Form factor of two squares 1e-4 apart: 1 but for their rims.
#[test]
fn a_light_just_above_a_floor_lights_it_fully() {
    for height in [1e-2f32, 1e-3, 1e-4] {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.5; 3], DARK), maker.diffuse([0.0; 3], [1.0; 3]));
        level(&mut maker, 0.0, 1.0, false, grey);
        level(&mut maker, height, 1.0, true, lamp);
        let eye = f64::from(height) * 0.5;
        let scene = maker.seen([0.1, eye, 0.2], [0.1, 0.0, 0.2], 30.0);
        for strategy in exact_strategies() {
            let settings = Settings { strategy, max_depth: Some(1), lights: Lights::Uniform, ..small(8, 8, 256) };
            let mean = render_sanely(&scene, &settings, strategy.name()).mean_radiance()[0];
            // Light sampling by area is hopeless so close; only strategies that follow the BSDF are precise here.
            let precise = !matches!(strategy, Strategy::Nee | Strategy::NeeAverage | Strategy::Uniform);
            assert!(!precise || (mean - 0.5).abs() < 0.02, "{strategy} at {height}: {mean}");
        }
    }
}

#[test]
fn huge_beside_tiny() {
    let mut maker = Maker::default();
    let (grey, huge) = (maker.diffuse([0.8; 3], DARK), maker.diffuse([0.2; 3], [1.0; 3]));
    let tiny = maker.diffuse([0.2; 3], [1e6, 1e5, 1e4]);
    level(&mut maker, 0.0, 10.0, false, grey);
    level(&mut maker, 1e4, 1e6, true, huge);
    maker.quad([[0.0, 0.5, 0.0], [1e-9, 0.5, 0.0], [1e-9, 0.5, 1e-9], [0.0, 0.5, 1e-9]], tiny);
    add(&mut maker, &sphere(1), grey, |p| p * 1e-9 + glam::DVec3::new(0.1, 0.1, 0.1));
    assert_sane(&maker.seen([0.0, 1.0, 3.0], [0.0, 0.2, 0.0], 60.0), "triangles of 1e-9 and 1e6");
}

#[test]
fn emission_from_1e_minus_44_to_1e30() {
    for (what, emission) in [("1e20", 1e20), ("1e-20", 1e-20), ("1e30", 1e30), ("1e-38", 1e-38), ("1e-44", 1e-44)] {
        let mut maker = Maker::default();
        let (white, lamp) = (maker.diffuse([1.0; 3], DARK), maker.diffuse([1.0; 3], [emission, 0.0, emission]));
        level(&mut maker, 0.0, 1.0, false, white);
        level(&mut maker, 1.0, 0.4, true, lamp);
        let scene = maker.seen([0.0, 0.6, 2.0], [0.0, 0.3, 0.0], 50.0);
        for strategy in exact_strategies() {
            for lights in [Lights::Uniform, Lights::Power] {
                let settings = Settings { strategy, lights, max_depth: Some(8), ..small(12, 12, 4) };
                let film = render_sanely(&scene, &settings, &format!("{what}, {strategy}"));
                assert!(film.mean_radiance()[0] > 0.0, "{what}, {strategy}: black");
            }
        }
    }
    let mut maker = Maker::default();
    let white = maker.diffuse([1.0; 3], DARK);
    level(&mut maker, 0.0, 1.0, false, white);
    let (bright, faint) = (maker.diffuse([0.0; 3], [1e20; 3]), maker.diffuse([0.0; 3], [1e-20; 3]));
    level(&mut maker, 1.0, 0.1, true, bright);
    level(&mut maker, 0.5, 0.1, true, faint);
    assert_sane(&maker.seen([0.0, 0.6, 2.0], [0.0, 0.3, 0.0], 50.0), "1e20 beside 1e-20");
}

#[test]
fn albedo_0_and_1_and_mirrors_that_face_each_other() {
    for albedo in [0.0, 1.0] {
        let mut maker = Maker::default();
        let wall = maker.diffuse([albedo; 3], DARK);
        let lamp = maker.diffuse([albedo; 3], [3.0; 3]);
        let mirror = maker.material(Scattering::Mirror { reflectance: [albedo; 3] }, DARK);
        maker.cuboid([-1.0; 3], [1.0; 3], true, wall);
        maker.quad([[-0.99, -0.9, -0.9], [-0.99, 0.9, -0.9], [-0.99, 0.9, 0.9], [-0.99, -0.9, 0.9]], mirror);
        maker.quad([[0.99, -0.9, -0.9], [0.99, -0.9, 0.9], [0.99, 0.9, 0.9], [0.99, 0.9, -0.9]], mirror);
        level(&mut maker, 0.99, 0.3, true, lamp);
        assert_sane(&maker.seen([0.0, 0.0, 0.9], [0.3, 0.1, -1.0], 80.0), &format!("albedo {albedo}"));
    }
}

#[test]
fn cameras_inside_upon_and_along_surfaces() {
    let cases = [
        ("inside a ball", [0.0, 0.5, 0.0], [0.0, 0.5, -1.0]),
        ("on a floor", [0.3, 0.0, 0.9], [0.0, 0.0, 0.0]),
        ("on a floor, looking into it", [0.3, 0.0, 0.9], [0.3, -1.0, 0.9]),
        ("grazing", [0.0, 1e-6, 3.0], [0.0, 1e-6, 0.0]),
        ("on a corner of a triangle", [-1.0, 0.0, 1.0], [0.0, 0.5, 0.0]),
        ("on a light", [0.0, 1.0, 0.0], [0.2, 0.0, 0.1]),
    ];
    for (what, position, look_at) in cases {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.8; 3], DARK), maker.diffuse([0.4; 3], [2.0; 3]));
        level(&mut maker, 0.0, 1.0, false, grey);
        level(&mut maker, 1.0, 0.4, true, lamp);
        add(&mut maker, &sphere(2), grey, |p| p * 0.3 + glam::DVec3::new(0.0, 0.5, 0.0));
        assert_sane(&maker.seen(position, look_at, 60.0), what);
    }
}

#[test]
fn slivers_up_to_an_aspect_of_1e5() {
    for radius in [0.1, 1e-3, 2e-5] {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.8; 3], DARK), maker.diffuse([0.1; 3], [2.0; 3]));
        add(&mut maker, &prism(12, radius), grey, |p| skew() * p);
        add(&mut maker, &prism(3, radius), lamp, |p| skew() * p + glam::DVec3::new(0.0, 1.0, 0.0));
        maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.1; 3] }));
        let eye = skew() * glam::DVec3::new(0.0, 0.0, 3.0 * radius + 0.01);
        assert_sane(&maker.seen(eye.to_array(), [0.0; 3], 90.0), &format!("slivers of {radius}"));
    }
}

/// Slivers that emit (a lamp tube) light what they face: shadow rays end before the lamp, not behind its surface.
#[test]
fn a_tube_of_slivers_gives_all_its_light() {
    let strip = |pieces: u32| {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.5; 3], DARK), maker.diffuse([0.0; 3], [100.0; 3]));
        level(&mut maker, 0.0, 1.0, false, grey);
        for i in 0..pieces {
            let [a, b] = [i, i + 1].map(|k| 2.0 * k as f32 / pieces as f32 - 1.0);
            let slant = |x: f32| 0.7 + 0.2 * x;
            let (low, high) = ([a, slant(a)], [b, slant(b)]);
            maker.quad(
                [[low[0], low[1], 0.0], [high[0], high[1], 0.0], [high[0], high[1], 0.004], [low[0], low[1], 0.004]],
                lamp,
            );
        }
        let scene = maker.seen([0.0, 0.5, 1.5], [0.0, 0.0, 0.0], 30.0);
        let settings = Settings { strategy: Strategy::Nee, max_depth: Some(1), ..small(24, 24, 64) };
        render_sanely(&scene, &settings, "strip").mean_radiance()[0]
    };
    // The same light, once as two triangles of aspect 500, once as 1,000 of aspect 2.
    let (slivers, chunks) = (strip(1), strip(500));
    assert!((slivers / chunks - 1.0).abs() < 0.01, "{slivers} and {chunks}");
}
