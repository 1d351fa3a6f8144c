//! Where f32 ends, and what is said of it; emitters that see nothing.

use super::shapes::render_sanely;
use crate::common::{Maker, small};
use octray::internal::tables::scale_limits::{LARGEST_COORDINATE, SMALLEST_SIZE};
use octray::{PreparedScene, Settings};

fn floor_and_lamp(scale: f32, shift: f32) -> Maker {
    let mut maker = Maker::default();
    let (grey, lamp) = (maker.diffuse([0.5; 3], [0.0; 3]), maker.diffuse([0.0; 3], [1.0; 3]));
    maker.quad([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]], grey);
    maker.quad([[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]], lamp);
    maker.mesh.positions.iter_mut().for_each(|p| *p = p.map(|x| x * scale + shift));
    maker.desc.camera.position = [f64::from(shift), f64::from(shift + 0.5 * scale), f64::from(shift + 3.0 * scale)];
    maker.desc.camera.look_at = [f64::from(shift); 3];
    (maker.desc.name, maker.desc.film) = ("floor and lamp".into(), (8, 8));
    maker
}

fn error(maker: &Maker) -> String {
    PreparedScene::new(&maker.whole()).err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn coordinates_that_overflow_end_in_an_error() {
    for scale in [2e12, 1e18, 1e19, 1e30] {
        assert!(error(&floor_and_lamp(scale, 0.0)).contains("use larger units"), "{scale}");
    }
    for scale in [1e-11, 1e-18, 1e-25] {
        assert!(error(&floor_and_lamp(scale, 0.0)).contains("use smaller units"), "{scale}");
    }
    let mut far_camera = floor_and_lamp(1.0, 0.0);
    far_camera.desc.camera.position = [0.0, 0.0, 1e20];
    assert!(error(&far_camera).contains("the camera reaches to 1.0e20"), "{}", error(&far_camera));
    for scale in [LARGEST_COORDINATE * 0.3, SMALLEST_SIZE] {
        let scene =
            PreparedScene::new(&floor_and_lamp(scale as f32, 0.0).whole()).unwrap_or_else(|error| panic!("{error}"));
        let film = render_sanely(&scene, &small(8, 8, 16), &format!("{scale}"));
        assert!(film.mean_radiance()[0] > 0.01, "{scale}: {:?}", film.mean_radiance());
    }
}

#[test]
fn scenes_far_from_the_origin_are_warned_about() {
    let warnings = |shift: f32| {
        let scene = PreparedScene::new(&floor_and_lamp(1.0, shift).whole()).unwrap_or_else(|error| panic!("{error}"));
        render_sanely(&scene, &Settings { max_depth: Some(3), ..small(8, 8, 4) }, &format!("{shift} away"));
        scene.warnings
    };
    assert_eq!(warnings(0.0), [""; 0]);
    assert_eq!(warnings(1.9e3), [""; 0]);
    for shift in [4e3, 1e5, 1e6] {
        assert!(warnings(shift).iter().any(|w| w.contains("of its own sizes from the origin")), "{shift}");
    }
}

#[test]
fn emitters_that_see_nothing_are_named() {
    let warnings = |maker: &Maker| {
        let scene = PreparedScene::new(&maker.whole()).unwrap_or_else(|error| panic!("{error}"));
        scene.warnings
    };
    let mut room = floor_and_lamp(1.0, 0.0);
    assert_eq!(warnings(&room), [""; 0]);
    // The lamp turned round shines at the sky.
    room.mesh.triangles[2].flipped = true;
    assert_eq!(warnings(&room), [""; 0], "half of it still shines at the floor");
    room.mesh.triangles[3].flipped = true;
    let said = warnings(&room);
    assert!(
        said.len() == 1 && said[0].contains("`m1` sees nothing") && said[0].contains("flip the winding"),
        "{said:?}"
    );
    // The camera above looks at it: it is there to be seen.
    room.desc.camera.position = [0.0, 3.0, 0.1];
    assert_eq!(warnings(&room), [""; 0]);
    // With a lid between it and the camera it is not, but it sees the lid.
    room.quad([[-1.0, 2.0, -1.0], [1.0, 2.0, -1.0], [1.0, 2.0, 1.0], [-1.0, 2.0, 1.0]], 0);
    assert_eq!(warnings(&room), [""; 0]);
    // Many emissive materials: each that is blind is named, the others are not.
    let mut many = floor_and_lamp(1.0, 0.0);
    for i in 0..300 {
        let lamp = many.diffuse([0.0; 3], [1.0; 3]);
        let x = i as f32 * 0.006 - 0.9;
        let corners = [[x, 0.5, -0.1], [x + 0.004, 0.5, -0.1], [x + 0.004, 0.5, 0.1], [x, 0.5, 0.1]];
        let mut turned = corners;
        turned.reverse();
        many.quad(if i % 100 == 99 { turned } else { corners }, lamp);
    }
    many.mesh.triangles.retain(|t| t.material != 1);
    let said = warnings(&many);
    assert_eq!(said.len(), 3, "{said:?}");
}

/// Lamps that are far larger or far smaller than what they light, whichever way everything is turned and wherever the camera is.
#[test]
fn no_size_of_a_lamp_hides_what_it_lights() {
    let turns = [glam::DMat3::IDENTITY, super::shapes::skew()];
    let square = |half: f64, y: f64, up: bool, turn: glam::DMat3| -> [[f32; 3]; 4] {
        let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
        let corners = corners.map(|[x, z]| (turn * glam::DVec3::new(x * half, y, z * half)).as_vec3().to_array());
        if up { corners } else { [corners[3], corners[2], corners[1], corners[0]] }
    };
    for turn in turns {
        // A tilted square of 1e6 has f32 corners 0.06 apart: there the lamp stays lower.
        let largest = if turn == turns[0] { 1e6 } else { 1e4 };
        for (lamp, floor) in [(largest, 4.0), (largest, 1e-2), (1e-3, 4.0), (1e-3, largest), (1.0, largest), (2.0, 1.0)]
        {
            for (camera, lights_floor) in [(1.5, true), (30.0, true), (-5.0, true), (-5.0, false)] {
                let mut maker = Maker::default();
                let (grey, light) = (maker.diffuse([0.5; 3], [0.0; 3]), maker.diffuse([0.0; 3], [1.0; 3]));
                maker.quad(square(floor, 0.0, true, turn), grey);
                maker.quad(square(lamp, 2.0, !lights_floor, turn), light);
                let eye = turn * glam::DVec3::new(0.1, camera, 0.2);
                (maker.desc.camera.position, maker.desc.camera.look_at) = (eye.to_array(), [0.0; 3]);
                (maker.desc.camera.up, maker.desc.name, maker.desc.film) = ([0.3, 0.2, 0.9], "lamp".into(), (4, 4));
                let said = PreparedScene::new(&maker.whole()).unwrap_or_else(|error| panic!("{error}")).warnings;
                let blind = said.iter().filter(|warning| warning.contains("sees nothing")).count();
                assert_eq!(blind, !lights_floor as usize, "lamp {lamp}, floor {floor}, camera {camera}: {said:?}");
            }
        }
    }
}
