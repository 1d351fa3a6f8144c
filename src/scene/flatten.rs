//! All triangles of a scene in world space, as the tables and whoever judges a whole scene read them.

use crate::scene::desc::{CornerDesc, InstanceDesc, MeshDesc, SceneDesc, TriangleDesc};
use crate::scene::transform::Transform;
use glam::DVec3;
use std::borrow::Cow;

/// The triangles of all instances, instance after instance; borrowed from the scene where its only instance stands where
/// its mesh does.
#[derive(Clone, Debug, Default)]
pub struct Geometry<'a> {
    /// Vertex positions in world space, scene units.
    pub positions: Cow<'a, [[f32; 3]]>,
    /// Triangles, which name [`Geometry::positions`]; the index is the triangle id.
    pub triangles: Cow<'a, [TriangleDesc]>,
    /// What their corners carry, normals in world space: empty, or one entry a triangle.
    pub corners: Cow<'a, [CornerDesc]>,
}

impl SceneDesc {
    /// The triangles of all instances in world space.
    ///
    /// # Panics
    /// Where an instance names no mesh, which [`validate::check`](crate::scene::validate::check) refuses.
    pub fn geometry(&self) -> Geometry<'_> {
        if let [InstanceDesc { mesh, transform: Transform::Identity }] = self.instances[..] {
            let MeshDesc { positions, triangles, corners } = &self.meshes[mesh as usize];
            return Geometry { positions: positions.into(), triangles: triangles.into(), corners: corners.into() };
        }
        let mut whole = MeshDesc::default();
        for instance in &self.instances {
            add(&mut whole, &self.meshes[instance.mesh as usize], &instance.transform);
        }
        Geometry { positions: whole.positions.into(), triangles: whole.triangles.into(), corners: whole.corners.into() }
    }
}

impl Geometry<'_> {
    /// The lower and the upper corner of the box about all triangles, scene units; `None` if there are none.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let used = self.triangles.iter().flat_map(|triangle| triangle.vertices);
        let corners = used.map(|v| DVec3::from(self.positions[v as usize].map(f64::from)));
        corners.map(|corner| (corner, corner)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The vertices of a triangle.
    pub fn vertices(&self, triangle: usize) -> [[f32; 3]; 3] {
        self.triangles[triangle].vertices.map(|v| self.positions[v as usize])
    }
}

/// Adds an instance. Meshes without corners cost nothing unless another mesh has some.
fn add(whole: &mut MeshDesc, mesh: &MeshDesc, transform: &Transform) {
    let (vertices, before) = (whole.positions.len() as u32, whole.triangles.len());
    whole.positions.extend(mesh.positions.iter().map(|&p| transform.apply(p)));
    let mirrored = transform.mirrors();
    whole.triangles.extend(mesh.triangles.iter().map(|t| TriangleDesc {
        vertices: t.vertices.map(|v| vertices + v),
        material: t.material,
        flipped: t.flipped != mirrored,
    }));
    if !mesh.corners.is_empty() {
        whole.corners.resize(before, CornerDesc::default());
        let moved =
            |c: &CornerDesc| CornerDesc { normals: c.normals.map(|n| transform.apply_to_normal(n)), uvs: c.uvs };
        whole.corners.extend(mesh.corners.iter().map(moved));
    } else if !whole.corners.is_empty() {
        whole.corners.resize(whole.triangles.len(), CornerDesc::default());
    }
}
