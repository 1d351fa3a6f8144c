//! What is decided once for a render, for its stages to read.

use crate::fault::{Fault, planted};
use crate::packet::queues::{QueueNeeds, TileState};
use crate::settings::{PlanChoice, Roulette};
use crate::setup::Setup;
use crate::strategy::Weight;
use crate::tables::PreparedScene;
use crate::tables::alpha_masks::{AlphaMaskTable, WHOLE};
use crate::tables::corners::{CornerRecord, FLAT, SMOOTH};
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
    /// Surfaces look their textures up.
    pub textures: bool,
    /// Stages are ready for any environment, whatever there is: light samples draw what a map needs, and rays that leave are
    /// shaded by the map's variant.
    pub any_environment: bool,
    /// Camera rays are ready for any lens and filter.
    pub any_camera: bool,
    /// Tables that the scene does without, of a plan that is more general than the scene needs.
    extra: ExtraTables,
}

/// Tables that say nothing.
#[derive(Default)]
struct ExtraTables {
    corners: Vec<CornerRecord>,
    alpha_masks: AlphaMaskTable,
}

impl Decisions {
    /// Those of one render.
    pub fn new(setup: &Setup) -> Decisions {
        let (scene, row) = (setup.scene, setup.strategy.row());
        let puts_back = |part: PlanChoice| setup.plan.puts_back(part);
        let queues = puts_back(PlanChoice::Queues);
        let emission_counts = row.certain_hit != Weight::Zero || row.hit != Weight::Zero;
        let events = setup.max_depth > 0;
        let some = |holds: fn(&KindRow) -> bool| TABLE.iter().any(|row| holds(row) && scene.features.kinds[row.kind]);
        let glossy = some(|row| row.lobes == Lobes::Density && !row.pdf_is_cosine);
        // Where hits find no light there is nothing to weigh.
        let pdf = setup.strategy.is_mis() && setup.samples_lights() && (queues || setup.lights.can_be_hit());
        let needs = QueueNeeds {
            pdf,
            cosine: pdf
                && (queues
                    || (glossy || setup.guide.is_some())
                        && matches!(setup.lights.environment, Some(EnvironmentLight::Constant(_)))),
            normal: pdf && (queues || matches!(setup.lights.selection, Selection::Tree(_))),
            row: pdf && (queues || setup.lights.learned.is_some()),
            albedo: setup.roulette != Roulette::Throughput,
            inverse_pixel: setup.roulette == Roulette::Learned && setup.guide.is_some(),
            misses: (puts_back(PlanChoice::Environment) || scene.environment.is_some()) && emission_counts,
            emitters: (queues || !scene.emitters.is_empty()) && emission_counts,
            surfaces: PerKind::new(|kind| events && kind.scatters() && (queues || scene.features.kinds[kind])),
            shadow: (queues || some(|row| row.lobes == Lobes::Density)) && events && setup.samples_lights(),
            targets: queues || setup.lights.count() > 0,
            positions: queues || scene.bvh.precise_triangles().1 > 0,
            alpha_masks: puts_back(PlanChoice::CutOuts) || scene.features.alpha_masks,
        };
        let surfaces = puts_back(PlanChoice::Surfaces);
        let first = scene.classes.first().copied();
        let lit = setup.lights.can_be_hit();
        Decisions {
            needs,
            kinds: MaterialKind::ALL.into_iter().filter(|&kind| needs.surfaces[kind]).collect(),
            detail: surfaces || !scene.corners.is_empty(),
            learned: setup.guide.is_some(),
            only_class: first.filter(|class| !queues && scene.classes.iter().all(|c| c == class)),
            shadow_tmax: (!queues && setup.lights.count() == 0).then_some(f32::INFINITY),
            last_drawn_counts: lit && row.hit != Weight::Zero,
            last_delta_counts: lit && row.certain_hit != Weight::Zero,
            textures: surfaces || scene.features.textures,
            any_environment: puts_back(PlanChoice::Environment),
            any_camera: puts_back(PlanChoice::Lens),
            extra: ExtraTables::new(scene, surfaces, needs.alpha_masks),
        }
    }

    /// What the corners of triangles carry; empty where nothing asks for it.
    pub fn corners<'a>(&'a self, scene: &'a PreparedScene) -> &'a [CornerRecord] {
        if scene.corners.is_empty() { &self.extra.corners } else { &scene.corners }
    }

    /// What is cut out.
    pub fn alpha_masks<'a>(&'a self, scene: &'a PreparedScene) -> &'a AlphaMaskTable {
        if scene.alpha_masks.is_empty() { &self.extra.alpha_masks } else { &scene.alpha_masks }
    }

    /// One thread's queues, for `capacity` paths.
    pub fn tile_state(&self, capacity: usize) -> TileState {
        TileState::new(capacity, self.needs, self.shadow_tmax.unwrap_or(1.0))
    }
}

impl ExtraTables {
    /// Those that `scene` has not, as far as they are asked for.
    fn new(scene: &PreparedScene, corners: bool, alpha_masks: bool) -> ExtraTables {
        let mut extra = ExtraTables::default();
        if corners && scene.corners.is_empty() {
            let flat = |normal| CornerRecord { normals: [normal; 3], uvs: [[0.0; 2]; 3], smoothness: FLAT };
            extra.corners = scene.triangles.iter().map(|triangle| flat(triangle.normal)).collect();
            if planted(Fault::BentCorners) {
                let bent =
                    CornerRecord { normals: [[0.6, 0.0, 0.8], [0.0, 0.8, 0.6], [0.8, 0.6, 0.0]], ..extra.corners[0] };
                extra.corners.fill(CornerRecord { smoothness: SMOOTH, ..bent });
            }
        }
        if alpha_masks && scene.alpha_masks.is_empty() {
            extra.alpha_masks.record_of = vec![WHOLE; scene.triangles.len()];
        }
        extra
    }
}
