//! The tree of nodes, flattened: where each node stands.

use super::file::File;
use crate::error::Result;
use crate::scene::transform::Transform;
use glam::{DMat4, DQuat, DVec3};
use gltf::json::scene::Node;

/// A node of the scene, and the way from its space to the world's.
pub struct Placed {
    /// Its number.
    pub node: usize,
    /// From its space to world space.
    pub to_world: DMat4,
}

/// The nodes of the scene that the file shows by default, parents before their children.
pub fn placed(file: &File<'_>, warnings: &mut Vec<String>) -> Result<Vec<Placed>> {
    let root = &file.root;
    let shown = root.scene.map_or(0, |scene| scene.value());
    let roots: Vec<usize> = match root.scenes.get(shown) {
        Some(scene) => scene.nodes.iter().map(|node| node.value()).collect(),
        None => {
            warnings.push(format!("{}: it has no scene: all of its nodes are shown", file.path.display()));
            let mut is_child = vec![false; root.nodes.len()];
            root.nodes.iter().flat_map(|node| node.children.iter().flatten()).for_each(|child| {
                is_child[child.value()] = true;
            });
            (0..root.nodes.len()).filter(|&node| !is_child[node]).collect()
        }
    };
    let mut seen = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    let mut waiting: Vec<(usize, DMat4)> = roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)).collect();
    while let Some((number, parent)) = waiting.pop() {
        if std::mem::replace(&mut seen[number], true) {
            let why = "it stands at two places of the tree of nodes, or below itself: each node may stand at one";
            return Err(file.fault(format_args!("nodes[{number}]"), why));
        }
        let node = &root.nodes[number];
        let to_world = parent * matrix(node);
        placed.push(Placed { node: number, to_world });
        let children = node.children.iter().flatten().rev();
        waiting.extend(children.map(|child| (child.value(), to_world)));
    }
    Ok(placed)
}

/// From a node's space to its parent's (glTF 2.0, section 3.5.3).
fn matrix(node: &Node) -> DMat4 {
    if let Some(columns) = node.matrix {
        return DMat4::from_cols_array(&columns.map(f64::from));
    }
    let vector = |v: Option<[f32; 3]>, other: f64| v.map_or(DVec3::splat(other), |v| DVec3::from(v.map(f64::from)));
    let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    DMat4::from_scale_rotation_translation(vector(node.scale, 1.0), rotation, vector(node.translation, 0.0))
}

/// What an instance says of a node's place; `None` if nothing can stand there.
pub fn transform(to_world: &DMat4) -> Option<Transform> {
    if *to_world == DMat4::IDENTITY {
        return Some(Transform::Identity);
    }
    let transform = Transform::Matrix(rows(to_world));
    transform.fault().is_none().then_some(transform)
}

/// The upper three rows.
pub fn rows(matrix: &DMat4) -> [[f64; 4]; 3] {
    [0, 1, 2].map(|i| matrix.row(i).to_array())
}
