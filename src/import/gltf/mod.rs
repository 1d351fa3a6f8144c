//! glTF 2.0 scenes, `.gltf` and `.glb`, to a [`SceneDesc`] (Khronos, "glTF 2.0 Specification"). The `gltf` crate reads the JSON
//! and tells whether its references hold; what they point at is read here, nothing without a look at its bounds.
//!
//! Photometric numbers are taken for radiometric ones: an intensity of 1 cd is 1 W sr^-1 here, an illuminance of 1 lx is
//! 1 W m^-2, an emission of 1 nit 1 W sr^-1 m^-2. So lights and surfaces keep their proportions.

mod accessors;
mod buffers;
mod container;
mod file;
mod lights;
mod materials;
mod meshes;
mod nodes;
mod textures;

use crate::error::{Error, Result};
use crate::scene::desc::{InstanceDesc, SceneDesc};
use buffers::Buffers;
use file::File;
use materials::Materials;
use meshes::Meshes;
use nodes::Placed;
use std::path::Path;

/// Reads the scene that the file shows by default: meshes, materials, lights and cameras. A file without cameras or lights leaves
/// both to the caller.
///
/// # Errors
/// [`Error::Read`] and [`Error::Parse`] name the file, the place in it and what is wrong.
pub fn load(path: &Path, film: (u32, u32)) -> Result<SceneDesc> {
    let (root, blob) = container::read(path)?;
    let buffers = Buffers::read(path, &root, blob)?;
    let file = File { path, root, buffers };
    let mut scene = SceneDesc { name: path.display().to_string(), film, ..SceneDesc::default() };
    let placed = nodes::placed(&file, &mut scene.warnings)?;
    add_meshes(&file, &placed, &mut scene)?;
    lights::add_cameras(&file, &placed, &mut scene);
    lights::add_lights(&file, &placed, &mut scene);
    warn_of_losses(&file, &mut scene.warnings);
    Ok(scene)
}

/// Adds the meshes of all nodes; each is read once, however often it stands in the scene.
fn add_meshes(file: &File<'_>, placed: &[Placed], scene: &mut SceneDesc) -> Result<()> {
    let mut materials = Materials::default();
    let mut meshes = Meshes::default();
    for Placed { node, to_world } in placed {
        let Some(mesh) = file.root.nodes[*node].mesh else { continue };
        let Some(transform) = nodes::transform(to_world) else {
            scene.warnings.push(format!("{}: nodes that are scaled to nothing are left out", file.path.display()));
            continue;
        };
        let primitives = meshes.primitives(file, mesh.value(), &mut materials, scene)?;
        scene.instances.extend(primitives.iter().map(|&mesh| InstanceDesc { mesh, transform }));
    }
    if scene.instances.is_empty() {
        let why = "no triangles: no node of its scene has a mesh of triangles";
        return Err(Error::parse(file.path, None, why));
    }
    Ok(())
}

/// One warning for each thing of the file that is not in the picture; those of meshes and materials are told where they are met.
fn warn_of_losses(file: &File<'_>, warnings: &mut Vec<String>) {
    let (name, root) = (file.path.display(), &file.root);
    let mut tell = |count: usize, what: &str| {
        if count > 0 {
            warnings.push(format!("{name}: {count} {what}"));
        }
    };
    tell(root.animations.len(), "animation(s) are not played: nodes stand as the file has them");
    tell(root.skins.len(), "skin(s) are not applied: meshes stand as they were modelled");
    let others = root.scenes.len().saturating_sub(1);
    tell(others, "other scene(s) are left out: octray renders the one that the file shows by default");
}
