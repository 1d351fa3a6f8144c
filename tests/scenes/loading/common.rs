//! Little scenes in a folder of their own.

use octray::scene::SceneDesc;
use std::path::{MAIN_SEPARATOR, PathBuf};

/// A triangle at the origin that faces +z, without material.
pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// A TOML that shows `mesh.obj`; what is appended goes on below `[[mesh]]`.
pub const TOML: &str = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n[[mesh]]\nobj = \"mesh.obj\"\n";

/// A folder of files that vanishes with the value.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new(files: &[(&str, &str)]) -> Folder {
        let folder = Folder(tempfile::tempdir().expect("a temporary folder"));
        for (name, text) in files {
            folder.write(name, text.as_bytes());
        }
        folder
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        std::fs::write(path, bytes).expect("a file");
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Loads a file; an error comes back as its message without the folder's name.
    pub fn load(&self, name: &str) -> Result<SceneDesc, String> {
        SceneDesc::load(self.path(name)).map_err(|e| {
            assert_eq!(e.exit_status(), 2, "{e}");
            e.to_string().replace(&format!("{}{MAIN_SEPARATOR}", self.0.path().display()), "")
        })
    }
}

/// Loads `text` as an OBJ beside nothing else.
pub fn load_obj(text: &str) -> Result<SceneDesc, String> {
    Folder::new(&[("mesh.obj", text)]).load("mesh.obj")
}

/// Loads an OBJ that uses the material `m`, which `mtl` describes.
pub fn load_mtl(mtl: &str) -> Result<SceneDesc, String> {
    let obj = format!("mtllib mesh.mtl\nusemtl m\n{TRIANGLE}");
    Folder::new(&[("mesh.obj", &obj), ("mesh.mtl", mtl)]).load("mesh.obj")
}

/// Loads [`TOML`] with `more` below it, over one triangle.
pub fn load_toml(more: &str) -> Result<SceneDesc, String> {
    let toml = format!("{TOML}{more}");
    Folder::new(&[("mesh.obj", TRIANGLE), ("scene.toml", &toml)]).load("scene.toml")
}

/// Whether a warning has all these words.
pub fn warned(scene: &SceneDesc, words: &[&str]) -> bool {
    scene.warnings.iter().any(|warning| words.iter().all(|word| warning.contains(word)))
}

/// The front normal of a triangle, twice its area long.
pub fn front(scene: &SceneDesc, triangle: usize) -> glam::DVec3 {
    let geometry = scene.geometry();
    let t = &geometry.triangles[triangle];
    let [a, b, c] = geometry.vertices(triangle).map(|v| glam::DVec3::from(v.map(f64::from)));
    let normal = (b - a).cross(c - a);
    if t.flipped { -normal } else { normal }
}
