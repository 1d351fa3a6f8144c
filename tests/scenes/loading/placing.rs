//! Meshes far from the origin: `translate` brings back every digit of the file, since vertices are read and placed in f64.

use super::common::*;
use octray::scene::SceneDesc;
use octray::scene::transform::rotation;

/// A house of 12 by 8 by 6 (units of 1/1024 apart), with a pentagon that its first corner does not see as a whole; smooth
/// and textured. `at`: where its corner lies.
fn house(at: [f64; 3]) -> String {
    let corners = [
        [0.0, 0.0, 0.0],
        [12.0, 0.0, 0.5],
        [12.0009765625, 6.0, 0.0],
        [5.5, 2.0029296875, 0.25],
        [0.0, 6.0, -0.0009765625],
        [4.0, 1.5, 8.0],
    ];
    let vertices = corners.map(|c| {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|i| at[i] + c[i]);
        format!("v {x} {y} {z}\n")
    });
    let faces = "vt 0.1 0.2\nvt 0.7 0.3\nvt 16777.2 -3\nvn 0.1 0.2 0.9\nvn -0.3 0 1\nvn 0 0 -2\n\
                 f 4/1/1 5/2/2 1/3/1 2/1/1 3/2/2\nf 1/1/3 2/2/3 6/3/3\nf 3 5 6\n";
    vertices.concat() + faces
}

fn placed(obj: &str, lines: &str) -> SceneDesc {
    let toml = format!("{TOML}{lines}");
    Folder::new(&[("mesh.obj", obj), ("scene.toml", &toml)]).load("scene.toml").expect(lines)
}

/// Where the house may lie: a country's grid, an earth-centred frame, a tile far away, all exact in f64 with its corners.
const PLACES: [[f64; 3]; 4] = [
    [448_262.0, 5_411_932.0, 112.0],
    [4_201_338.0, 168_113.0, -4_780_222.0],
    [1e9, -2e9, 0.0],
    [-16_777_217.0, 33_554_433.0, 1_048_577.0],
];

fn assert_same(a: &SceneDesc, b: &SceneDesc, what: &str) {
    let (a, b) = (a.geometry(), b.geometry());
    let bits = |p: &[[f32; 3]]| p.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&a.positions), bits(&b.positions), "{what}");
    assert_eq!(a.triangles, b.triangles, "{what}");
    assert_eq!(a.corners, b.corners, "{what}");
}

#[test]
fn a_translation_brings_back_every_digit() {
    let zero = |[x, y, z]: [f64; 3]| format!("translate = [{x:?}, {y:?}, {z:?}]");
    for at in PLACES {
        let back = placed(&house(at), &zero(at.map(|x| -x)));
        assert_same(&back, &placed(&house([0.0; 3]), ""), &format!("{at:?}"));
        // Quarter turns and powers of two are exact too.
        let turn = "scale = -0.25\nrotate = {axis = [0, 0, 1], degrees = 90}\n";
        let [x, y, z] = at.map(|x| -0.25 * x);
        let back = placed(&house(at), &format!("{turn}{}", zero([y, -x, -z])));
        assert_same(&back, &placed(&house([0.0; 3]), turn), &format!("{at:?}, turned"));
    }
}

/// Any transform: the file's f64 numbers, the formula in f64, one rounding.
#[test]
fn vertices_are_rounded_once() {
    let vertices = [[448262.123, 5411932.456, 112.789], [448263.001, 5411931.999, 0.1], [0.3, 448262.125, 1e-7]];
    let text: String = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    for (scale, degrees, translate) in
        [(1.0, 0.0, [-448262.0, -5411932.0, 0.0]), (0.7, 33.0, [2.5e6, -3.1e6, 7.0]), (-1e-3, -120.5, [0.1, 0.2, 0.3])]
    {
        let [x, y, z] = translate;
        let lines = format!(
            "scale = {scale:?}\nrotate = {{axis = [1, -2, 0.5], degrees = {degrees:?}}}\ntranslate = [{x:?}, {y:?}, {z:?}]"
        );
        let scene = placed(&format!("{text}f 1 2 3\n"), &lines);
        let turn = rotation([1.0, -2.0, 0.5], degrees);
        for (p, found) in vertices.iter().zip(scene.geometry().positions.iter()) {
            let p = p.map(|x: f64| x * scale);
            let expected: [f32; 3] = std::array::from_fn(|i| {
                (turn[i][0] * p[0] + turn[i][1] * p[1] + turn[i][2] * p[2] + translate[i]) as f32
            });
            assert_eq!(found.map(f32::to_bits), expected.map(f32::to_bits), "{lines}");
        }
    }
    // Millimetres of a country's grid, by decimals that f64 does not hold exactly.
    let scene = placed(&format!("{text}f 1 2 3\n"), "translate = [-448262, -5411932, -112]");
    for (found, expected) in scene.geometry().positions[0].iter().zip([0.123, 0.456, 0.789]) {
        assert!((f64::from(*found) - expected).abs() < 3e-8, "{found} {expected}");
    }
}

#[test]
fn numbers_beyond_f32_are_fine_once_they_are_scaled() {
    let obj = "v 0 0 0\nv 1e39 0 0\nv 0 3e39 0\nf 1 2 3\n";
    let scene = placed(obj, "scale = 1e-39");
    assert_eq!(scene.geometry().positions[1..], [[(1e39 * 1e-39) as f32, 0.0, 0.0], [0.0, (3e39 * 1e-39) as f32, 0.0]]);
    for (obj, lines, words) in [
        (obj, "", "mesh.obj:2: `1e39`"),
        ("v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n", "scale = 1e-30", "mesh.obj:2: `1e999`"),
        (obj, "scale = 0.5", "scene.toml:4: the transform moves vertices"),
    ] {
        let toml = format!("{TOML}{lines}");
        let message = Folder::new(&[("mesh.obj", obj), ("scene.toml", &toml)]).load("scene.toml").expect_err(lines);
        assert!(message.starts_with(words), "{message}");
    }
}
