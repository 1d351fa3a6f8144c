//! The emitter table: every triangle that emits, whatever the light selection.

use crate::fault::{Fault, planted};
use crate::scene::desc::MaterialDesc;
use crate::scene::flatten::Geometry;
use crate::tables::textures::placed;
use crate::tables::triangles::double_area_vector;

/// One emissive triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// The triangle's id.
    pub triangle: u32,
    /// Its area, square scene units.
    pub area: f64,
    /// Emitted radiance on the front side, in [`PreparedScene::radiance_unit`](crate::PreparedScene::radiance_unit).
    pub radiance: [f32; 3],
    /// The back emits as the front does.
    pub two_sided: bool,
    /// What multiplies the radiance: a texture and its coordinates at the triangle's corners.
    pub texture: Option<(u32, [[f32; 2]; 3])>,
}

/// The emitters of a scene, by ascending triangle id; triangles without area are none. Radiances count in `unit`.
pub(crate) fn emitter_table(
    materials: &[MaterialDesc],
    unit: f64,
    geometry: &Geometry<'_>,
    degenerate: &[bool],
) -> Vec<Emitter> {
    let material = |id: usize| &materials[geometry.triangles[id].material as usize];
    let emission = |id: usize| material(id).emission.map(|c| (c / unit) as f32);
    (0..geometry.triangles.len())
        .filter(|&id| !degenerate[id] && emission(id).iter().any(|&c| c > 0.0))
        .map(|id| Emitter {
            triangle: id as u32,
            area: 0.5 * double_area_vector(geometry.vertices(id)).length(),
            radiance: emission(id),
            two_sided: material(id).two_sided || planted(Fault::BothSidesShine),
            texture: material(id).emission_texture.map(|used| {
                let uvs = geometry.corners.get(id).map_or([[0.0; 2]; 3], |corner| corner.uvs);
                (used.texture, placed(uvs, Some(used)))
            }),
        })
        .collect()
}
