//! Meshes, their instances and transforms, and cameras placed by a matrix, as programs describe them.

use crate::common::{Maker, small};
use glam::{DMat3, DVec3};
use octray::scene::desc::{CornerDesc, EnvironmentDesc, InstanceDesc, LightDesc, SceneDesc};
use octray::scene::transform::{Similarity, Transform, rotation};
use octray::scene::validate;
use octray::{Error, PreparedScene, render};

/// A lit room with a box that carries corner normals; the box is a mesh of its own, with one instance under `transform`.
fn room(transform: Transform) -> SceneDesc {
    let mut maker = Maker::default();
    let grey = maker.diffuse([0.5; 3], [0.0; 3]);
    let lamp = maker.diffuse([0.0; 3], [5.0, 4.0, 3.0]);
    maker.cuboid([-2.0; 3], [2.0; 3], true, grey);
    maker.quad([[-0.5, 1.9, -0.5], [0.5, 1.9, -0.5], [0.5, 1.9, 0.5], [-0.5, 1.9, 0.5]], lamp);
    let mut scene = maker.whole();
    let mut block = Maker::default();
    block.cuboid([-0.3, -0.4, -0.5], [0.3, 0.2, 0.1], false, grey);
    let corner = |t: &octray::scene::desc::TriangleDesc| {
        let normal = |v: u32| DVec3::from(block.mesh.positions[v as usize].map(f64::from)).normalize();
        CornerDesc { normals: t.vertices.map(|v| normal(v).as_vec3().to_array()), uvs: [[0.25, 0.5]; 3] }
    };
    block.mesh.corners = block.mesh.triangles.iter().map(corner).collect();
    scene.add_mesh(block.mesh, transform);
    scene.camera.position = [0.3, 0.2, 1.8];
    (scene.name, scene.film) = ("a room".into(), (16, 12));
    scene
}

fn similarity(scale: f64) -> Similarity {
    Similarity { scale, rotation: rotation([1.0, 2.0, -0.5], 40.0), translate: [0.4, -0.7, 0.2] }
}

/// The rows of the affine map that a similarity is.
fn rows(similarity: &Similarity) -> [[f64; 4]; 3] {
    std::array::from_fn(|i| {
        let [x, y, z] = similarity.rotation[i].map(|r| r * similarity.scale);
        [x, y, z, similarity.translate[i]]
    })
}

fn prepared(scene: &SceneDesc) -> PreparedScene {
    PreparedScene::new(scene).unwrap_or_else(|error| panic!("{error}"))
}

fn assert_same_tables(a: &PreparedScene, b: &PreparedScene) {
    assert_eq!(a.triangles.len(), b.triangles.len());
    assert_eq!(bytemuck::cast_slice::<_, u8>(&a.triangles), bytemuck::cast_slice::<_, u8>(&b.triangles));
    assert_eq!(bytemuck::cast_slice::<_, u8>(&a.corners), bytemuck::cast_slice::<_, u8>(&b.corners));
}

#[test]
fn two_instances_of_a_mesh_are_two_meshes() {
    for second in
        [Transform::Identity, Transform::Similarity(similarity(0.5)), Transform::Matrix(rows(&similarity(-0.7)))]
    {
        let mut shared = room(Transform::Similarity(similarity(1.0)));
        let mut apart = shared.clone();
        shared.instances.push(InstanceDesc { mesh: 1, transform: second });
        apart.add_mesh(apart.meshes[1].clone(), second);
        assert_eq!((shared.meshes.len(), apart.meshes.len()), (2, 3));
        assert_same_tables(&prepared(&shared), &prepared(&apart));
        assert_eq!(shared.geometry().triangles.len(), 14 + 12 + 12);
    }
}

#[test]
fn the_identity_changes_no_bit() {
    let mut alone = room(Transform::Identity);
    alone.meshes.remove(0);
    alone.instances = vec![InstanceDesc::default()];
    alone.meshes[0].positions[0] = [-0.0, 1e-45, 0.1];
    let borrowed = alone.geometry();
    assert!(matches!(borrowed.positions, std::borrow::Cow::Borrowed(_)));
    let mut twice = alone.clone();
    twice.instances.push(InstanceDesc::default());
    let geometry = twice.geometry();
    let (n, bits) = (borrowed.positions.len(), |p: &[[f32; 3]]| bytemuck::cast_slice::<_, u32>(p).to_vec());
    for part in [&geometry.positions[..n], &geometry.positions[n..]] {
        assert_eq!(bits(part), bits(&borrowed.positions));
    }
    assert_eq!(geometry.corners[..12], borrowed.corners[..]);
    // What a mesh without corners gets beside one that has some.
    assert_eq!(room(Transform::Identity).geometry().corners[..14], [CornerDesc::default(); 14]);
}

#[test]
fn a_matrix_stands_where_the_similarity_does() {
    for scale in [1.0, 0.3, -1.0, -2.5] {
        let similarity = similarity(scale);
        let (a, b) = (Transform::Similarity(similarity), Transform::Matrix(rows(&similarity)));
        assert_eq!((a.mirrors(), b.mirrors()), (scale < 0.0, scale < 0.0));
        let (a, b) = (room(a), room(b));
        let (a, b) = (a.geometry(), b.geometry());
        let near = |p: [f32; 3], q: [f32; 3]| {
            p.iter().zip(q).all(|(p, q)| (p - q).abs() <= 2.0 * f32::EPSILON * p.abs().max(0.25))
        };
        assert!(a.positions.iter().zip(b.positions.iter()).all(|(&p, &q)| near(p, q)), "{scale}");
        assert_eq!(a.triangles, b.triangles);
        for (p, q) in a.corners.iter().zip(b.corners.iter()) {
            assert!(p.normals.iter().zip(q.normals).all(|(&p, q)| near(p, q)) && p.uvs == q.uvs, "{scale}");
        }
    }
}

#[test]
fn fronts_and_normals_follow_a_skewing_mirroring_matrix() {
    for sign in [1.0, -1.0] {
        let matrix = [[0.8, 0.3, 0.0, 0.1], [0.0, 0.5 * sign, 0.2, -0.3], [0.1, 0.0, 1.5, 0.2]];
        let scene = room(Transform::Matrix(matrix));
        let centre = scene.meshes[1].positions.iter().map(|p| DVec3::from(p.map(f64::from))).sum::<DVec3>() / 24.0;
        let centre = DVec3::from(matrix.map(|m| DVec3::new(m[0], m[1], m[2]).dot(centre) + m[3]));
        let tables = prepared(&scene);
        let linear = DMat3::from_cols_array_2d(&[0, 1, 2].map(|i| matrix.map(|row| row[i])));
        for (i, record) in tables.triangles[14..].iter().enumerate() {
            let front = DVec3::from(record.normal.map(f64::from));
            assert!(front.dot(DVec3::from(record.vertices[0].map(f64::from)) - centre) > 0.0, "{sign}, {i}");
            for (n, object) in tables.corners[14 + i].normals.iter().zip(scene.meshes[1].corners[i].normals) {
                let wanted = (linear.inverse().transpose() * DVec3::from(object.map(f64::from))).normalize();
                assert!((DVec3::from(n.map(f64::from)) - wanted).length() < 1e-6, "{sign}, {i}");
            }
        }
    }
}

/// Asserts that `scene` is refused with one message that has all these words.
fn refused(scene: &SceneDesc, words: &[&str]) {
    assert!(validate::check(scene).is_err());
    match PreparedScene::new(scene).err() {
        Some(Error::Scene { message, .. }) => {
            assert!(words.iter().all(|word| message.contains(word)) && message.lines().count() == 1, "{message}");
        }
        other => panic!("{words:?}: {other:?}"),
    }
}

#[test]
fn bad_instances_lights_and_matrices_are_named() {
    let mut missing = room(Transform::Identity);
    missing.instances[1].mesh = 7;
    refused(&missing, &["instance 1", "mesh 7", "2 meshes"]);
    let flat = [[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
    refused(&room(Transform::Matrix(flat)), &["instance 1", "singular"]);
    for x in [f64::NAN, f64::INFINITY, 1e39] {
        let mut matrix = rows(&similarity(1.0));
        matrix[1][3] = x;
        refused(&room(Transform::Matrix(matrix)), &["instance 1", "finite"]);
    }
    for scale in [0.0, f64::NAN] {
        refused(&room(Transform::Similarity(similarity(scale))), &["instance 1", "scale"]);
    }
    let singular = Similarity { rotation: [[1.0; 3]; 3], ..similarity(1.0) };
    refused(&room(Transform::Similarity(singular)), &["instance 1", "singular"]);
    refused(
        &room(Transform::Similarity(similarity(f64::from(f32::MAX) * 8.0))),
        &["instance 1 of mesh 1", "out of the range"],
    );
    let mut long = room(Transform::Identity);
    long.meshes[1].corners[3].normals[0] = [2.0, 0.0, 0.0];
    refused(&long, &["instance 1 of mesh 1", "number 3", "normals"]);
    long.instances[1].transform = Transform::Similarity(similarity(1.0));
    assert!(PreparedScene::new(&long).is_ok(), "a transform makes unit vectors of normals");
    let mut skies = room(Transform::Identity);
    skies.lights = vec![LightDesc::Environment(EnvironmentDesc::Constant { radiance: [1.0; 3] }); 2];
    refused(&skies, &["lights 0 and 1", "environments", "at most one"]);
    skies.set_environment(Some(EnvironmentDesc::Constant { radiance: [0.5; 3] }));
    assert_eq!(skies.environment(), Some(&EnvironmentDesc::Constant { radiance: [0.5; 3] }));
    assert!(PreparedScene::new(&skies).is_ok());
    let mut camera = room(Transform::Identity);
    camera.camera.to_world = Some(flat);
    refused(&camera, &["camera", "singular"]);
    let mut matrix = rows(&similarity(1.0));
    camera.camera.to_world = Some(matrix);
    camera.camera.position = [f64::NAN; 3];
    assert!(PreparedScene::new(&camera).is_ok(), "the matrix stands in place of the position");
    matrix.iter_mut().for_each(|row| row[1] *= 1e8);
    camera.camera.to_world = Some(matrix);
    refused(&camera, &["camera", "lengths of its axes"]);
}

#[test]
fn a_matrix_camera_sees_what_a_camera_that_looks_at_sees() {
    for aperture_radius in [0.0, 0.1] {
        let mut scene = room(Transform::Similarity(similarity(0.5)));
        scene.camera.look_at = [-0.1, -0.3, 0.0];
        scene.camera.vertical_fov = 60.0;
        (scene.camera.aperture_radius, scene.camera.focus_distance) = (aperture_radius, 1.5);
        let eye = DVec3::from(scene.camera.position);
        let backward = (eye - DVec3::from(scene.camera.look_at)).normalize();
        let right = DVec3::from(scene.camera.up).cross(backward).normalize();
        let columns = [right, backward.cross(right), backward, eye];
        let mut placed = scene.clone();
        placed.camera.to_world = Some(std::array::from_fn(|i| columns.map(|column| column[i])));
        // Not looked at.
        (placed.camera.position, placed.camera.look_at) = ([50.0; 3], [60.0; 3]);
        let [a, b] = [scene, placed].map(|scene| render(&prepared(&scene), &small(16, 12, 16)).film);
        let mean = |film: &octray::Film| film.pixels.iter().map(|p| p.sum[0]).sum::<f64>() / (192.0 * 16.0);
        let apart = a.pixels.iter().zip(&b.pixels).filter(|(p, q)| (p.sum[0] - q.sum[0]).abs() > 1e-3 * p.sum[0].abs());
        assert!(mean(&a) > 0.01 && (mean(&a) - mean(&b)).abs() < 5e-3 * mean(&a), "{} {}", mean(&a), mean(&b));
        assert!(apart.count() <= 10, "a few paths may take another way by rounding");
    }
}
