//! Scene loading.
use octray::scene::SceneDesc;
#[test]
fn cornell() {
    for s in ["cornell", "cornell_mirror", "furnace"] {
        let scene = SceneDesc::load(format!("scenes/{s}.toml")).unwrap();
        println!("{scene:#?}");
        for (i, t) in scene.triangles.iter().enumerate() {
            let [a, b, c] = t.vertices.map(|v| glam::Vec3::from(scene.positions[v as usize]));
            println!("{i} {} {:?}", scene.materials[t.material as usize].name, (b - a).cross(c - a).normalize());
        }
        println!("{:?}", scene.warnings);
    }
}
#[test]
fn heavy() {
    let t = std::time::Instant::now();
    let scene = SceneDesc::load("builtin:heavy").unwrap();
    println!("{} {} {:?}", scene.triangles.len(), scene.positions.len(), t.elapsed());
    for n in [2000, 20000] {
        let scene = SceneDesc::load(format!("builtin:heavy:{n}")).unwrap();
        assert_eq!(scene.triangles.len(), n);
    }
    println!("{}", SceneDesc::load("builtin:havy").unwrap_err());
    println!("{}", SceneDesc::load("builtin:heavy:3").unwrap_err());
}
