//! OBJ files: numbers, indices, normals, transforms, bare OBJs.

use super::common::*;
use octray::scene::is_degenerate;

#[test]
fn every_corner_form_and_relative_indices_work() {
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
    for face in
        ["f 1 2 3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1", "f -3 -2 -1", "f 1 2/1 3/1/1 # end"]
    {
        let scene = load_obj(&format!("{head}{face}\n")).expect(face);
        assert_eq!((scene.geometry().triangles.len(), scene.geometry().triangles[0].flipped), (1, false), "{face}");
        let corners = scene.geometry().vertices(0);
        assert_eq!(corners, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], "{face}");
    }
}

#[test]
fn odd_but_readable_text_is_read() {
    let cases = [
        "\u{feff}v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
        "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
        "\tv\t0  0\t0 # comment\n v 1 0 0 1 # w\nv 0 1 0 0.5 0.5 0.5\nf\t1 2 \\\n 3\n",
        "v 0 0 0 0\nv 1 0 0 2 3 4 5 6\nv 0 1 0 1 2\nvw 1 2\nl 1 2 3\nl 1 2\np 1\nf 1 2 3\ng\no\ns off\nusemtl",
        "f 1 2 3\nusemtl late\nv .0 -0e0 +0\nv 1. 0 0\nv 0 1 0",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/7/9 2/8/9 3//9",
    ];
    for text in cases {
        let scene = load_obj(text).expect(text);
        let corners = scene.geometry().vertices(0);
        assert_eq!(
            (scene.geometry().triangles.len(), corners),
            (1, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
            "{text}"
        );
    }
    // A comment is never joined with the next line; a thousand joined lines are one.
    let scene = load_obj(&format!("# C:\\models\\\n{TRIANGLE}f 1 2 {}3 1\n", "\\\n".repeat(1_000))).unwrap();
    assert_eq!(scene.geometry().triangles.len(), 3);
    let folder = Folder::new(&[]);
    folder.write("mesh.obj", b"# caf\xe9\no \xff\xfe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(folder.load("mesh.obj").unwrap().geometry().triangles.len(), 1);
}

#[test]
fn faults_name_the_line_of_the_obj() {
    let huge = "f 1//1 2//1 3//9223372036854775807";
    let cases = [
        ("v 0 0 0\nv 1 0\nf 1 1 1", "mesh.obj:2: `v` needs three numbers; it has 2"),
        ("v 0 0 0\nv 1 0 # 0\nf 1 1 1", "mesh.obj:2: `v` needs three numbers; it has 2"),
        ("v 0 0 0\nv 1 0 x\nf 1 1 1", "mesh.obj:2: `x` is not a finite number"),
        ("v 0 0 0\nv 1,5 0 0\nf 1 1 1", "mesh.obj:2: `1,5`"),
        ("v 0 0 0\n\nv nan 0 0\nf 1 2 2", "mesh.obj:3: `nan`"),
        ("v 0 0 0\nv 0 -inf 0\nf 1 2 2", "mesh.obj:2: `-inf`"),
        ("v 0 0 0\nv 0 1e39 0\nf 1 2 2", "mesh.obj:2: `1e39`"),
        ("v 0 0 0\nvn 0 0\nf 1 1 1", "mesh.obj:2: `vn` needs three numbers"),
        ("v 0 0 0\nf 1 1 0", "mesh.obj:2: face corner `0`: there is no `v` number 0"),
        ("v 0 0 0\nf 1 1 2", "mesh.obj:2: face corner `2`"),
        ("v 0 0 0\nf -2 1 1", "mesh.obj:2: face corner `-2`"),
        ("v 0 0 0\nvt 0 0\nf 1/1 1/2 1/1", "mesh.obj:3: face corner `1/2`: there is no `vt` number 2"),
        ("v 0 0 0\nvn 0 0 1\nf 1//1 1//-2 1//1", "mesh.obj:3: face corner `1//-2`: there is no `vn` number -2"),
        ("v 0 0 0\nf 1 1 one", "mesh.obj:2: face corner `one`: `one` is not a whole number"),
        ("v 0 0 0\nf 1 1 1/1/1/1", "mesh.obj:2: face corner `1/1/1/1` has more than"),
        ("v 0 0 0\nf 1 1 //", "mesh.obj:2: face corner `//` names no vertex"),
        (&format!("v 0 0 0\nv 0 0 0\nv 0 0 0\nvn 0 0 1\n{huge}"), "mesh.obj:5: face corner `3//9223"),
        ("v 0 0 0\nf 1 1 99999999999999999999", "mesh.obj:2:"),
        ("", "mesh.obj: no triangles"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3 1\np 1\nf 1 2\nf 1\nf", "mesh.obj: no triangles"),
    ];
    for (text, words) in cases {
        let message = load_obj(text).expect_err(text);
        assert!(message.starts_with(words) && !message.contains('\n'), "{text}\n{message}");
    }
}

#[test]
fn small_faces_and_flat_triangles_are_counted_once() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1\nf 1 2 3\nf 1 1 2\nf 1 2 3\nv 2 0 0\nf 1 2 4\n";
    let scene = load_obj(text).unwrap();
    assert_eq!(scene.geometry().triangles.len(), 4);
    assert!(warned(&scene, &["mesh.obj:4:", "2 face(s)"]) && warned(&scene, &["2 triangle(s) have no area"]));
    assert!(is_degenerate([[0.0; 3], [1.0; 3], [2.0; 3]]));
    assert!(is_degenerate([[0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    assert!(is_degenerate([[0.0; 3], [f32::INFINITY, 0.0, 0.0], [0.0, 1.0, 0.0]]));
    // Needles and specks have an area as long as f32 can tell their corners apart.
    assert!(!is_degenerate([[0.0; 3], [1e-45, 0.0, 0.0], [0.0, 1e-45, 0.0]]));
    assert!(!is_degenerate([[0.0; 3], [3e38, 0.0, 0.0], [0.0, 3e38, 0.0]]));
    assert!(!is_degenerate([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 1e-45, 0.0]]));
}

#[test]
fn normals_decide_where_they_oppose_the_winding() {
    let head = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 1\nvn 0 0 -1\nvn 0 0 0\nvn nan 0 0\n";
    let faces = [
        ("f 1//1 2//1 3//1", false),
        ("f 1//2 2//2 3//2", true),
        ("f 1//2 2//2 3//1", true),
        ("f 1//1 2//1 3//2", false),
        ("f 1//1 2//2 3//3", false), // they cancel: the winding stays
        ("f 1//4 2//2 3//2", false), // not numbers: the winding stays
        ("f 1 2 3", false),          // not the normals of the face before
        ("f 1 2 3//2", true),
    ];
    let text: String = faces.iter().map(|(face, _)| format!("{face}\n")).collect();
    let scene = load_obj(&format!("{head}{text}")).unwrap();
    let flipped: Vec<bool> = scene.geometry().triangles.iter().map(|t| t.flipped).collect();
    assert_eq!(flipped, faces.map(|(_, flipped)| flipped));
}

/// The corners of one triangle under the transform lines `more`.
fn moved(obj: &str, more: &str) -> octray::scene::SceneDesc {
    let toml = format!("{TOML}{more}");
    Folder::new(&[("mesh.obj", obj), ("scene.toml", &toml)]).load("scene.toml").expect(more)
}

#[test]
fn transforms_scale_then_rotate_then_translate() {
    let obj = "v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n";
    let all = "scale = 2\nrotate = {axis = [0, 10, 0], degrees = 90}\ntranslate = [10, 20, 30]";
    assert_eq!(
        moved(obj, all).geometry().positions.as_ref(),
        [[10.0, 20.0, 28.0], [10.0, 24.0, 30.0], [16.0, 20.0, 30.0]]
    );
    for (degrees, x) in [(0, [1.0, 0.0, 0.0]), (180, [-1.0, 0.0, 0.0]), (-90, [0.0, -1.0, 0.0]), (450, [0.0, 1.0, 0.0])]
    {
        let scene = moved(obj, &format!("rotate = {{axis = [0, 0, 1e-30], degrees = {degrees}}}"));
        assert_eq!(scene.geometry().positions[0], x, "{degrees}");
    }
    // A third of a turn about the diagonal permutes the axes; only rounding is left.
    let scene = moved(obj, "rotate = {axis = [1, 1, 1], degrees = 120}");
    for (p, q) in scene.geometry().positions.iter().zip([[0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [3.0, 0.0, 0.0]]) {
        assert!(p.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-6), "{p:?} {q:?}");
    }
    // Read and placed in f64, one rounding at the end.
    let scene = moved("v 0.1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3", "scale = 3\ntranslate = [0.7, 0, 0]");
    assert_eq!(scene.geometry().positions[0][0], (0.1 * 3.0 + 0.7) as f32);
    let message = load_toml("scale = 3e38\ntranslate = [3e38, 0, 0]").unwrap_err();
    assert!(message.contains("scene.toml:4:") && message.contains("out of the range of f32"), "{message}");
}

#[test]
fn a_mirroring_transform_keeps_fronts_outside() {
    // A tetrahedron, fronts outside, once with normals that agree and once wound the wrong way with normals that rule.
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let plain = format!("{corners}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    let normals = "vn 0 0 -1\nvn 0 -1 0\nvn -1 0 0\nvn 1 1 1\n";
    let ruled = format!("{corners}{normals}f 2//1 3//1 1//1\nf 4//2 2//2 1//2\nf 3//3 4//3 1//3\nf 4//4 3//4 2//4\n");
    for (obj, scale) in [(&plain, 1), (&plain, -2), (&ruled, 1), (&ruled, -2)] {
        let scene = moved(obj, &format!("scale = {scale}"));
        let centre = glam::DVec3::splat(0.25 * f64::from(scale));
        for i in 0..4 {
            let corner = glam::DVec3::from(scene.geometry().vertices(i)[0].map(f64::from));
            assert!(front(&scene, i).dot(corner - centre) > 0.0, "scale {scale}, face {i}\n{obj}");
        }
    }
}

#[test]
fn a_bare_obj_is_framed_and_lit() {
    // A box of 4 x 1 x 2 about (10, 20, 30), by two triangles.
    let text = "v 8 19.5 29\nv 12 20.5 31\nv 8 20.5 31\nv 12 19.5 29\nf 1 2 3\nf 1 4 2\n";
    let scene = load_obj(text).unwrap();
    let camera = scene.camera;
    assert_eq!((camera.look_at, camera.up, camera.vertical_fov), ([10.0, 20.0, 30.0], [0.0, 1.0, 0.0], 35.0));
    assert_eq!((camera.position[0], camera.position[1], scene.film), (10.0, 20.0, (512, 512)));
    for p in scene.geometry().positions.iter() {
        let depth = camera.position[2] - f64::from(p[2]);
        let reach = depth * 17.5f64.to_radians().tan();
        assert!(depth > 0.0 && (0..2).all(|i| (f64::from(p[i]) - camera.look_at[i]).abs() < reach), "{p:?}");
    }
    assert_eq!(scene.environment(), Some(&octray::scene::desc::EnvironmentDesc::Constant { radiance: [1.0; 3] }));
    assert!(warned(&scene, &["no camera", "-z"]) && warned(&scene, &["white environment"]));
    // What emits needs no environment; what no triangle uses does not emit.
    let lit = load_mtl("newmtl m\nKe 1 1 1\n").unwrap();
    assert!(lit.environment().is_none() && !warned(&lit, &["white environment"]));
    assert!(load_mtl("newmtl m\nnewmtl unused\nKe 1 1 1\n").unwrap().environment().is_some());
    // Boxes without width: a line along z, a speck far from the origin.
    load_obj("v 0 0 0\nv 0 0 1\nv 0 0 2\nf 1 2 3").unwrap();
    load_obj("v 1e6 1e6 1e6\nf 1 1 1").unwrap();
    let message = load_obj("v -3e38 0 0\nv 3e38 0 0\nv 0 3e38 0\nf 1 2 3").unwrap_err();
    assert!(message.contains("cannot be framed"), "{message}");
}
