//! What is decided once for a render, for its stages to read.

use crate::packet::queues::{QueueNeeds, TileState};
use crate::settings::Roulette;
use crate::setup::Setup;
use crate::strategy::Weight;
use crate::tables::lights::table::{EnvironmentLight, Selection};
use crate::tables::materials::{KindRow, Lobes, MaterialKind, PerKind, TABLE};

/// The facts.
pub struct Decisions {
    /// Queues and columns that exist.
    pub needs: QueueNeeds,
    /// The kinds that have a queue.
    pub kinds: Vec<MaterialKind>,
    /// Some surface is smooth or textured: stages load what its corners carry.
    pub detail: bool,
    /// Diffuse surfaces look up what was learned of directions.
    pub learned: bool,
    /// Every triangle has this class, so hits need not be looked up ([`crate::tables::PreparedScene::classes`]).
    pub only_class: Option<u8>,
    /// Shadow rays leave the scene (infinity), or say one by one where they end (`None`).
    pub shadow_tmax: Option<f32>,
    /// Whether emission can count after a last event whose direction was drawn from a density.
    pub last_drawn_counts: bool,
    /// Whether emission can count after a last delta event.
    pub last_delta_counts: bool,
}

impl Decisions {
    /// Those of one render.
    pub fn new(setup: &Setup) -> Decisions {
        let (scene, row) = (setup.scene, setup.strategy.row());
        let emission_counts = row.certain_hit != Weight::Zero || row.hit != Weight::Zero;
        let events = setup.max_depth > 0;
        let some = |holds: fn(&KindRow) -> bool| TABLE.iter().any(|row| holds(row) && scene.features.kinds[row.kind]);
        let glossy = some(|row| row.lobes == Lobes::Density && !row.pdf_is_cosine);
        let pdf = setup.strategy.is_mis() && setup.samples_lights();
        let needs = QueueNeeds {
            pdf,
            cosine: pdf
                && (glossy || setup.guide.is_some())
                && matches!(setup.lights.environment, Some(EnvironmentLight::Constant(_))),
            normal: pdf && matches!(setup.lights.selection, Selection::Tree(_)),
            row: pdf && setup.lights.learned.is_some(),
            albedo: setup.roulette != Roulette::Throughput,
            inverse_pixel: setup.roulette == Roulette::Learned && setup.guide.is_some(),
            misses: scene.environment.is_some() && emission_counts,
            emitters: !scene.emitters.is_empty() && emission_counts,
            surfaces: PerKind::new(|kind| events && kind.scatters() && scene.features.kinds[kind]),
            shadow: some(|row| row.lobes == Lobes::Density) && events && setup.samples_lights(),
            targets: !setup.lights.records.is_empty(),
            positions: scene.bvh.precise_triangles().1 > 0,
            alpha_masks: scene.features.alpha_masks,
        };
        let first = scene.classes.first().copied();
        let lit = !setup.lights.is_empty();
        Decisions {
            needs,
            kinds: MaterialKind::ALL.into_iter().filter(|&kind| needs.surfaces[kind]).collect(),
            detail: !scene.corners.is_empty(),
            learned: setup.guide.is_some(),
            only_class: first.filter(|class| scene.classes.iter().all(|c| c == class)),
            shadow_tmax: setup.lights.records.is_empty().then_some(f32::INFINITY),
            last_drawn_counts: lit && row.hit != Weight::Zero,
            last_delta_counts: lit && row.certain_hit != Weight::Zero,
        }
    }

    /// One thread's queues, for `capacity` paths.
    pub fn tile_state(&self, capacity: usize) -> TileState {
        TileState::new(capacity, self.needs, self.shadow_tmax.unwrap_or(1.0))
    }
}
