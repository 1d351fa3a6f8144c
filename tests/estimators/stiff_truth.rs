//! Closed forms where single precision is at its end: needle lamps, lamps next to floors, floors a million times larger than
//! what stands on them, doubled faces. All exact strategies must agree with Lambert's formula.

use crate::common::{Maker, estimate, polygon_irradiance, small};
use glam::{DMat3, DVec3};
use octray::scene::desc::{CameraDesc, EnvironmentDesc, TriangleDesc};
use octray::{PreparedScene, Settings, Strategy, render};
use std::f64::consts::PI;

/// Mean of a picture and its standard error.
fn mean(scene: &PreparedScene, strategy: Strategy, spp: u32) -> (f64, f64) {
    let settings = Settings { strategy, max_depth: Some(1), ..small(8, 8, spp) };
    let render = render(scene, &settings);
    assert_eq!(render.stats.nonfinite, 0);
    let got = estimate(&render.film, 0..8, 0..8, 0);
    (got.mean, got.error)
}

/// A floor triangle of about `half` (normal up before `turn`), a lamp of these corners over it that faces it, and a camera that
/// looks at the origin from `eye` above.
struct Stand {
    half: f64,
    lamp: [DVec3; 4],
    eye: f64,
    turn: DMat3,
}

impl Stand {
    fn scene(&self) -> PreparedScene {
        let mut maker = Maker::default();
        let (floor, lamp) = (maker.diffuse([1.0; 3], [0.0; 3]), maker.diffuse([0.0; 3], [1.0; 3]));
        let place = |p: DVec3| (self.turn * p).as_vec3().to_array();
        let corners = [[-1.0, 1.1], [1.2, 0.8], [0.1, -1.3]].map(|[x, z]| place(DVec3::new(x, 0.0, z) * self.half));
        maker.mesh.positions.extend(corners);
        maker.mesh.triangles.push(TriangleDesc { vertices: [0, 1, 2], material: floor, flipped: false });
        maker.quad(self.lamp.map(place), lamp);
        let mut scene = maker.whole();
        scene.camera = CameraDesc {
            position: (self.turn * DVec3::Y * self.eye).to_array(),
            look_at: [0.0; 3],
            up: (self.turn * DVec3::Z).to_array(),
            vertical_fov: 1e-2,
            ..CameraDesc::default()
        };
        scene.film = (8, 8);
        scene.name = "a stand".into();
        PreparedScene::new(&scene).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Radiance of the floor at the origin.
    fn truth(&self) -> f64 {
        let corners = self.lamp.map(|p| DVec3::from((self.turn * p).as_vec3().to_array().map(f64::from)));
        polygon_irradiance(DVec3::ZERO, self.turn * DVec3::Y, &corners) / PI
    }
}

fn lamp(x: f64, z: f64, height: f64) -> [DVec3; 4] {
    [[-0.37, -0.43], [0.63, -0.43], [0.63, 0.57], [-0.37, 0.57]].map(|[u, v]| DVec3::new(u * x, height, v * z))
}

/// Every strategy must come to the truth within 5 standard errors and `bound`.
fn agrees(stand: &Stand, strategies: &[Strategy], spp: u32, bound: f64, what: &str) {
    let (scene, truth) = (stand.scene(), stand.truth());
    for &strategy in strategies {
        let (mean, error) = mean(&scene, strategy, spp);
        let off = (mean / truth - 1.0).abs();
        assert!(off < 5.0 * error / truth + bound, "{what}, {strategy}: {mean} +- {error}, truth {truth}");
        // Strategies that can hit a needle only by chance prove less, but something.
        assert!(error / truth < 0.2, "{what}, {strategy}: noise of {}", error / truth);
    }
}

fn skew() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(0.3, 0.8, -0.52).normalize(), 0.7)
}

#[test]
fn a_lamp_of_ten_heights_above_a_floor_at_any_height() {
    for height in [1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let stand = Stand {
            half: 2.0,
            lamp: lamp(10.0 * height, 10.0 * height, height),
            eye: 0.5 * height,
            turn: DMat3::IDENTITY,
        };
        agrees(&stand, &[Strategy::Nee, Strategy::MisBalance, Strategy::Bsdf], 4096, 1e-4, &format!("height {height}"));
    }
    // On a tilted floor the point itself is rounded along the normal: at 0, where it is seen here, by little.
    for height in [1e-2, 1e-3, 1e-4] {
        let stand =
            Stand { half: 2.0, lamp: lamp(10.0 * height, 10.0 * height, height), eye: 0.5 * height, turn: skew() };
        agrees(
            &stand,
            &[Strategy::Nee, Strategy::MisBalance, Strategy::Bsdf],
            1024,
            1e-3,
            &format!("tilted, {height}"),
        );
    }
}

/// A lamp 10,000 times longer than wide lost 14 % of its light to itself, in every strategy that samples lights.
#[test]
fn needle_lamps_give_all_their_light() {
    for turn in [DMat3::IDENTITY, skew()] {
        for width in [1e-2, 1e-3, 1e-4, 1e-6] {
            for (x, z) in [(1.0, width), (width, 1.0)] {
                let stand = Stand { half: 20.0, lamp: lamp(x, z, 1.0), eye: 0.5, turn };
                let what = format!("needle {x} x {z}");
                // f32 places the corners of a tilted needle by 1e-7: the truth is that of the rounded corners.
                let bound = if turn == DMat3::IDENTITY { 1e-4 } else { 1e-4 + 2e-7 / width };
                agrees(&stand, &[Strategy::Nee, Strategy::MisPower], 1024, bound, &what);
            }
        }
    }
    let stand = Stand { half: 20.0, lamp: lamp(1.0, 1e-3, 1.0), eye: 0.5, turn: skew() };
    agrees(&stand, &[Strategy::Bsdf], 16_384, 1e-3, "needle found by chance");
}

/// A ground of 1e6 lamps made what stands on it four times too bright; one of 1e7 black.
#[test]
fn a_ground_far_larger_than_what_stands_on_it_does_not_move_it() {
    for half in [1e1, 1e3, 1e5, 1e6, 1e7] {
        let stand = Stand { half, lamp: lamp(1.0, 1.0, 1.0), eye: 0.5, turn: DMat3::IDENTITY };
        agrees(&stand, &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf], 2048, 1e-4, &format!("ground {half}"));
    }
    for half in [1e1, 1e2, 1e3, 1e4] {
        let stand = Stand { half, lamp: lamp(1.0, 1.0, 1.0), eye: 0.5, turn: skew() };
        agrees(&stand, &[Strategy::Nee, Strategy::MisPower, Strategy::Bsdf], 2048, 1e-3, &format!("tilted {half}"));
    }
}

/// A closed room whose walls cross the ground it stands on.
#[test]
fn nothing_leaves_a_room_that_stands_on_a_huge_ground() {
    for half in [1e3f32, 1e5, 1e7] {
        let mut maker = Maker::default();
        let white = maker.diffuse([1.0; 3], [0.0; 3]);
        maker.quad([[-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half], [-half, 0.0, -half]], white);
        maker.cuboid([-1.3, -0.4, -0.9], [1.1, 1.7, 1.2], true, white);
        maker.desc.set_environment(Some(EnvironmentDesc::Constant { radiance: [1.0; 3] }));
        let scene = maker.seen([0.2, 0.8, 0.5], [0.1, 0.0, -0.3], 80.0);
        let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(100), rr_depth: None, ..small(24, 24, 16) };
        let render = render(&scene, &settings);
        assert_eq!(render.film.mean_radiance(), [0.0; 3], "ground {half}, of {} rays", render.stats.rays.bounce);
    }
}

/// Exporters double faces; panels are made two-sided by a reversed copy; walls lie in lamps.
#[test]
fn doubled_faces_shine_once_in_every_strategy() {
    let square = [[-1.0, 2.0, -1.0], [1.0, 2.0, -1.0], [1.0, 2.0, 1.0], [-1.0, 2.0, 1.0]];
    // Along the same diagonal.
    let reversed = [0, 3, 2, 1].map(|i| square[i]);
    /// A quad and whether it shines.
    type Face = ([[f32; 3]; 4], bool);
    // What lies there, in this order, and what arrives of the lamp's light.
    let cases: [(&str, &[Face], f64); 5] = [
        ("doubled", &[(square, true), (square, true)], 1.0),
        ("with a reversed copy", &[(square, true), (reversed, true)], 1.0),
        ("reversed first", &[(reversed, true), (square, true)], 1.0),
        ("behind a wall", &[(square, false), (square, true)], 0.0),
        ("before a wall", &[(square, true), (reversed, false)], 1.0),
    ];
    for (what, quads, share) in cases {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.6; 3], [0.0; 3]), maker.diffuse([0.0; 3], [1.0; 3]));
        for &(corners, shines) in quads {
            maker.quad(corners, if shines { lamp } else { grey });
        }
        maker.quad([[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]], grey);
        let scene = maker.seen([3.0, 1.0, 0.5], [0.0, 0.0, 0.0], 1e-3);
        assert_eq!(scene.warnings.iter().filter(|warning| warning.contains("dropped")).count(), 1, "{what}");
        let corners = square.map(|p| DVec3::from(p.map(f64::from)));
        let truth = 0.6 / PI * polygon_irradiance(DVec3::ZERO, DVec3::Y, &corners) * share;
        for strategy in [Strategy::Bsdf, Strategy::Nee, Strategy::MisPower] {
            let (mean, error) = mean(&scene, strategy, 1024);
            assert!((mean - truth).abs() <= 5.0 * error + 1e-4, "{what}, {strategy}: {mean} +- {error}, truth {truth}");
        }
    }
}

/// Lamps and walls that share a plane but not their corners: ties are decided alike for hits and shadow rays.
#[test]
fn strategies_agree_where_a_wall_shares_a_lamps_plane() {
    for wall_first in [true, false] {
        let mut maker = Maker::default();
        let (grey, lamp) = (maker.diffuse([0.6; 3], [0.0; 3]), maker.diffuse([0.0; 3], [1.0; 3]));
        let wall = [[-1.5, 2.0, -1.5], [0.4, 2.0, -1.5], [0.4, 2.0, 1.5], [-1.5, 2.0, 1.5]];
        let panel = [[-1.0, 2.0, -1.0], [1.0, 2.0, -1.0], [1.0, 2.0, 1.0], [-1.0, 2.0, 1.0]];
        for first in [true, false] {
            if first == wall_first { maker.quad(wall, grey) } else { maker.quad(panel, lamp) }
        }
        maker.quad([[-4.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, -4.0], [-4.0, 0.0, -4.0]], grey);
        let scene = maker.seen([3.0, 1.0, 0.5], [0.0, 0.0, 0.0], 1e-1);
        let [bsdf, nee, mis] = [Strategy::Bsdf, Strategy::Nee, Strategy::MisPower].map(|s| mean(&scene, s, 8192));
        for (other, what) in [(nee, "nee"), (mis, "mis-power")] {
            let bound = 5.0 * (bsdf.1.powi(2) + other.1.powi(2)).sqrt();
            assert!((bsdf.0 - other.0).abs() < bound, "wall first {wall_first}: bsdf {bsdf:?}, {what} {other:?}");
        }
    }
}
