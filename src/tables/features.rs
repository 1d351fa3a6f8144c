//! What a scene holds: what a plan may need, and what reports say of it.

use crate::scene::desc::SceneDesc;
use crate::tables::corners::{CornerRecord, FLAT};
use crate::tables::materials::{MaterialKind, PerKind};
use crate::tables::triangles::CLASS_EMITS;

/// What a scene holds, hence what a plan may need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Features {
    /// Of each kind whether some triangle that can be hit has it.
    #[serde(flatten)]
    pub kinds: PerKind<bool>,
    /// Emissive triangles.
    pub emissive_triangles: usize,
    /// Point, spot and directional lights.
    pub delta_lights: usize,
    /// Something surrounds the scene.
    pub environment: bool,
    /// Some triangle is part of a smooth surface.
    pub smooth_normals: bool,
    /// Some material has a texture.
    pub textures: bool,
    /// Of some triangle only a part is there.
    #[serde(rename = "cut_outs")]
    pub alpha_masks: bool,
}

impl Features {
    /// What `desc` holds; of materials, only what a triangle that can be hit has.
    pub(super) fn new(
        desc: &SceneDesc,
        degenerate: &[bool],
        classes: &[u8],
        corners: &[CornerRecord],
        alpha_masks: bool,
    ) -> Features {
        let visible = || classes.iter().zip(degenerate).filter(|(_, degenerate)| !**degenerate).map(|(class, _)| class);
        let uses = |kind: MaterialKind| visible().any(|class| class & !CLASS_EMITS == kind as u8);
        Features {
            kinds: PerKind::new(uses),
            emissive_triangles: visible().filter(|&class| class & CLASS_EMITS != 0).count(),
            delta_lights: desc.delta_lights().count(),
            environment: desc.environment().is_some(),
            smooth_normals: corners.iter().any(|corner| corner.smoothness != FLAT),
            textures: desc.materials.iter().any(|m| m.texture.is_some() || m.emission_texture.is_some()),
            alpha_masks,
        }
    }

    /// Whether any surface scatters light.
    pub fn scatters(&self) -> bool {
        MaterialKind::ALL.into_iter().any(|kind| kind.scatters() && self.kinds[kind])
    }
}
