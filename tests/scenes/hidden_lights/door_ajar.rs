//! `scenes/door_ajar.toml`.

use super::closed::{assert_tight, corners, enclosed, material, of};
use octray::internal::reference::single;
use octray::internal::sampler::{random_words, unit};
use octray::scene::SceneDesc;
use octray::{PreparedScene, Scene};

fn scene() -> SceneDesc {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/door_ajar.toml");
    Scene::load(path).unwrap_or_else(|error| panic!("{error}")).desc
}

/// Whether a material is that of the room's or the corridor's surfaces.
fn is_wall(name: &str) -> bool {
    ["parquet", "plaster", "teal", "frame", "carpet", "corridor"].contains(&name)
}

#[test]
fn the_room_and_the_corridor_are_one_closed_surface() {
    let scene = scene();
    let volume = enclosed(&scene, &of(&scene, is_wall));
    let (room, passage, corridor) = (5.0 * 4.2 * 2.6, 0.9 * 2.05 * 0.16, 7.8 * 1.64 * 2.5);
    assert!((volume / (room + passage + corridor) - 1.0).abs() < 1e-6, "{volume}");
    assert_tight(scene);
}

#[test]
fn all_fronts_of_the_furniture_look_outwards() {
    let scene = scene();
    let things = of(&scene, |name| !is_wall(name) && name != "lamp");
    // Each thing begins where the vertex numbers of the one before end.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut last = 0;
    for i in things {
        let vertices = scene.geometry().triangles[i].vertices;
        let (first, highest) = (vertices.into_iter().min().unwrap_or(0), vertices.into_iter().max().unwrap_or(0));
        if first > last || groups.is_empty() {
            groups.push(Vec::new());
        }
        last = last.max(highest);
        groups.last_mut().expect("a group").push(i);
    }
    assert!(groups.len() > 90, "{} things", groups.len());
    for group in groups {
        // Some have no bottom: about their lowest corner it would add nothing.
        let points = group.iter().flat_map(|&i| corners(&scene, i));
        let foot = points.min_by(|a, b| a.y.total_cmp(&b.y)).expect("a corner");
        let volume = |&i: &usize| {
            let [a, b, c] = corners(&scene, i).map(|p| p - foot);
            a.dot(b.cross(c)) / 6.0
        };
        assert!(group.iter().map(volume).sum::<f64>() > 1e-6, "{} at {foot}", material(&scene, group[0]));
    }
}

/// No point of the room, its walls and its furniture sees the lamp: some do of the door, its frame and the floor that the door
/// has been swung over, no others.
#[test]
fn no_point_of_the_room_sees_the_lamp() {
    let desc = scene();
    let prepared = PreparedScene::new(&desc).unwrap_or_else(|error| panic!("{error}"));
    let lamp = of(&desc, |name| name == "lamp");
    assert_eq!(lamp.len(), 2);
    let (mut tried, mut seen) = (0, 0);
    let mut stack = single::intersect::stack(&prepared.bvh);
    for triangle in of(&desc, |name| !["corridor", "carpet", "lamp"].contains(&name)) {
        let of_door = ["door", "frame"].contains(&material(&desc, triangle));
        for i in 0..100 {
            let [u, v, s, t] = random_words(triangle as u32, i, 0, 7).map(unit);
            // The half of the square beyond the diagonal is turned over.
            let fold = |u: f32, v: f32| if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let ((u, v), (s, t)) = (fold(u, v), fold(s, t));
            let [a, b, c] = corners(&desc, lamp[i as usize % 2]).map(|p| p.as_vec3());
            let target = a + s * (b - a) + t * (c - a);
            let record = &prepared.triangles[triangle];
            let from = single::surface::surface_point(record, None, u, v, -glam::Vec3::from(record.normal));
            let direction = target - from.origin;
            let ray = single::intersect::Ray { origin: from.origin, direction, tmin: 0.0, tmax: 0.999 };
            let blocked = single::intersect::intersect(&prepared.bvh, &ray, &mut stack).is_some();
            // From the hinge; the door stands 36 degrees open.
            let (x, z) = (from.origin.x - 1.01, from.origin.z);
            let at_door = of_door || (x.hypot(z) < 0.88 && z < 36f32.to_radians().tan() * x);
            tried += 1;
            seen += u32::from(!blocked);
            assert!(blocked || at_door, "{:?} of {} sees the lamp", from.origin, material(&desc, triangle));
        }
    }
    assert!(tried > 50_000 && seen > 50, "{tried} tried, {seen} of the door see the lamp");
}
