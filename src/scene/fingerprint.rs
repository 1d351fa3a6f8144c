//! Whether two scenes are the same, told by 64 bits.

use crate::fingerprint::Fingerprint;
use crate::scene::SceneDesc;
use crate::scene::desc::{CameraDesc, EnvironmentDesc};

/// A fingerprint of everything in `scene` that can change a picture; its name and warnings cannot.
pub fn scene(scene: &SceneDesc) -> u64 {
    let mut print = Fingerprint::default();
    for mesh in &scene.meshes {
        // Without the sizes what ends one mesh could begin the next.
        print.text(&format!("{} {} {}", mesh.positions.len(), mesh.triangles.len(), mesh.corners.len()));
        print.bytes(bytemuck::cast_slice(&mesh.positions));
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.vertices;
            print.bytes(bytemuck::cast_slice(&[a, b, c, triangle.material, triangle.flipped as u32]));
        }
        for corner in &mesh.corners {
            print.bytes(bytemuck::cast_slice(&corner.normals));
            print.bytes(bytemuck::cast_slice(&corner.uvs));
        }
    }
    for texture in &scene.textures {
        print.bytes(bytemuck::cast_slice(&[texture.width, texture.height]));
        print.bytes(bytemuck::cast_slice(&texture.texels));
    }
    for mask in &scene.masks {
        print.bytes(bytemuck::cast_slice(&[mask.width, mask.height]));
        print.bytes(&mask.texels);
    }
    // `{:?}` writes every f64 with as many digits as tell it from its neighbours.
    print.text(&format!("{:?} {:?} {:?} {:?}", scene.instances, scene.materials, scene.camera, scene.filter));
    match scene.environment() {
        Some(EnvironmentDesc::Map(map)) => {
            print.text(&format!("{} {} {:?} {:?}", map.width, map.height, map.rotate, map.scale));
            print.bytes(bytemuck::cast_slice(&map.texels));
        }
        other => print.text(&format!("{other:?}")),
    }
    // Only where there are any: a scene without keeps the fingerprint that parts and checkpoints of it have.
    scene.delta_lights().for_each(|light| print.text(&format!("{:?}", light.light)));
    print.value()
}

/// A fingerprint of cameras, in their order.
pub fn cameras(cameras: &[CameraDesc]) -> u64 {
    let mut print = Fingerprint::default();
    print.text(&format!("{cameras:?}"));
    print.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::desc::{DeltaLight, DeltaLightDesc, LightDesc, MeshDesc};
    use crate::scene::transform::{Similarity, Transform};

    fn sun(y: f64) -> LightDesc {
        let light = DeltaLight::Directional { direction: [0.0, y, 0.0], irradiance: [1.0; 3] };
        LightDesc::Delta(DeltaLightDesc { name: String::new(), light })
    }

    #[test]
    fn what_shows_changes_the_fingerprint_and_a_name_does_not() {
        let load = || SceneDesc::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/sky.toml")).unwrap();
        let print = scene(&load());
        let changed = |change: fn(&mut SceneDesc)| {
            let mut other = load();
            change(&mut other);
            scene(&other) != print
        };
        assert!(!changed(|s| s.name = "other".into()));
        assert!(changed(|s| s.meshes[0].positions[3][1] += 0.5));
        assert!(changed(|s| s.meshes[0].triangles.swap(0, 1)));
        assert!(changed(|s| s.materials[0].emission[2] += 1e-12));
        assert!(changed(|s| s.camera.vertical_fov += 1e-9));
        assert!(changed(
            |s| s.camera.to_world = Some([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
        ));
        assert!(changed(|s| s.instances.push(s.instances[0])));
        assert!(changed(|s| s.instances[0].mesh = 1));
        assert!(changed(|s| s.instances[0].transform = Transform::Similarity(Similarity::default())));
        assert!(changed(|s| s.meshes.push(MeshDesc::default())));
        assert!(changed(|s| s.set_environment(None)));
        assert!(changed(|s| s.lights.push(sun(-1.0))));
        let (mut up, mut down) = (load(), load());
        up.lights.push(sun(1.0));
        down.lights.push(sun(-1.0));
        assert_ne!(scene(&up), scene(&down));
    }
}
