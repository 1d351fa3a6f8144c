//! The light table: what a light sample reads, for one light selection.
//!
//! A light sample first decides between the environment and the other lights (with probability 1/2 each where a scene has
//! both, unless the light tree knows better), then chooses one of these, then, on a triangle, a point: uniformly by the solid
//! angle that it fills where that is large enough to matter, else uniformly by area. Choosing uses all 32 bits of one random
//! word.
//!
//! Lights are numbered: emissive triangles in the order of their ids, then delta lights in that of the scene.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::fault::{Fault, planted};
use crate::sampler::index_below;
use crate::settings::Lights;
use crate::tables::alpha_masks::AlphaMaskTable;
use crate::tables::lights::alias::{AliasColumn, alias_table, factor_above, probabilities_by_word, whole_shares};
use crate::tables::lights::deltas::DeltaRecord;
use crate::tables::lights::emitters::Emitter;
use crate::tables::lights::environment::{Distribution, Environment, EnvironmentMap};
use crate::tables::lights::learned::LearnedLights;
use crate::tables::lights::patches::LearnedPatches;
use crate::tables::lights::targets::Targets;
use crate::tables::lights::tree::LightTree;
use crate::tables::lights::visibility::Visibility;
use crate::tables::prepared::PreparedScene;
use crate::tables::textures::{NO_TEXTURE, TextureTable};

/// Triangles are sampled by solid angle where the squared distance to their nearest vertex is below this many times
/// their area. Farther away distances and cosines vary so little that drawing by area is as good in most scenes, and
/// costs less: with 50 instead of 2 the Cornell box takes 18 % longer, for 0.3 % less variance. (Where nothing else
/// makes noise it would pay: a lone lamp four of its sizes above an open floor would have 0.4 of its variance.)
pub const MOST_REMOTE: f32 = 2.0;
/// .. where half the solid angle, in turns, is above this (a solid angle of 1e-3 sr: below, a triangle seen along its
/// plane has lost too many digits) ..
pub const LEAST_HALF_ANGLE: f32 = 8e-5;
/// .. and below this (6.22 sr: above, the point all but lies on the triangle, and so do the directions to its vertices)
/// ..
pub const MOST_HALF_ANGLE: f32 = 0.495;
/// .. and where numerator or denominator of the tangent of half the solid angle is above this: where both vanish, the
/// point lies on an edge, where the solid angle jumps between 0 and a hemisphere.
pub const LEAST_TANGENT: f32 = 1e-2;

/// Of n lamps, each has at least this probability over n under [`Lights::Power`]: a weak one that is alone in being seen
/// is found by one light sample in so many. A little more than 1/16, which is promised: a table of 32 bits rounds.
const LEAST_CHOICE: f64 = 1.0 / 15.0;

/// One emissive triangle as light sampling and MIS see it: one cache line.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct LightRecord {
    /// Vertices, scene units.
    pub vertices: [[f32; 3]; 3],
    /// Unit normal of the side that emits.
    pub normal: [f32; 3],
    /// Emitted radiance, in [`PreparedScene::radiance_unit`].
    pub radiance: [f32; 3],
    /// Density of points drawn uniformly on this triangle, per unit area: one over its area. Its sign bit says that
    /// both sides emit. (The probability with which the triangle is chosen at all: [`LightTable::probability`].)
    pub signed_pdf_area: f32,
}

impl LightRecord {
    /// Density of points drawn uniformly on this triangle, per unit area.
    pub fn pdf_area(&self) -> f32 {
        self.signed_pdf_area.abs()
    }

    /// Both sides emit.
    pub fn two_sided(&self) -> bool {
        self.signed_pdf_area.is_sign_negative()
    }
}

/// What multiplies the radiance of lights, or takes it away.
pub struct LightTextures {
    /// All textures of the scene.
    pub textures: Arc<TextureTable>,
    /// Per light, its texture ([`crate::tables::textures::NO_TEXTURE`]: none).
    pub texture: Vec<u32>,
    /// Per light, its texture coordinates: u and v of each vertex.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// If a light is cut out: all cut-outs of the scene, and per light its triangle's id. What is not there emits nothing.
    pub alpha_masks: Option<(Arc<AlphaMaskTable>, Vec<u32>)>,
}

/// What decides which emitter a sample goes to.
#[derive(Clone, Debug)]
pub enum Selection<'a> {
    /// The same probabilities at every place.
    Fixed(Fixed),
    /// By what emitters can send to the point that asks.
    Tree(&'a LightTree),
}

/// A choice of emitters that does not depend on the place.
#[derive(Clone, Debug)]
pub enum Fixed {
    /// There is at most one: nothing to choose.
    Single,
    /// All of so many alike.
    Uniform(u32),
    /// By power, but none next to never.
    Alias(Vec<AliasColumn>),
}

impl Fixed {
    /// The choice by power, where emitters get `to_emitters` of all light samples.
    fn by_power(powers: &[f64], to_emitters: f64) -> Fixed {
        let least = LEAST_CHOICE / powers.len() as f64 / to_emitters;
        let factor = factor_above(|| powers.iter().map(|&power| (power, 1.0)), least);
        let raised = |power: f64| if power > 0.0 { (power * factor).max(least) } else { 0.0 };
        let weights: Vec<f64> = powers.iter().map(|&power| raised(power)).collect();
        Fixed::Alias(alias_table(whole_shares(&weights, weights.iter().sum())))
    }

    /// The emitter that a selection word chooses.
    #[inline]
    pub fn choose(&self, word: u32) -> u32 {
        match self {
            Fixed::Single => 0,
            Fixed::Uniform(count) => index_below(word, *count),
            Fixed::Alias(columns) => {
                let column = index_below(word, columns.len() as u32);
                let low = word.wrapping_mul(columns.len() as u32);
                let AliasColumn { threshold, alias } = columns[column as usize];
                if low < threshold { column } else { alias }
            }
        }
    }
}

/// The environment as a light.
#[derive(Clone, Copy)]
pub enum EnvironmentLight<'a> {
    /// The same radiance from everywhere, in [`PreparedScene::radiance_unit`].
    Constant([f32; 3]),
    /// A map, and how light samples are spread over it.
    Map(&'a EnvironmentMap, &'a Distribution),
}

/// The lights of a scene under one selection.
pub struct LightTable<'a> {
    /// Per emitter of the scene, its record.
    pub records: Vec<LightRecord>,
    /// Per delta light of the scene, its record.
    pub deltas: &'a [DeltaRecord],
    /// Where each of them is among the triangles, for shadow rays.
    pub targets: Targets,
    /// Pictures on lights, if any light has one.
    pub textures: Option<LightTextures>,
    /// Whether any of them emits on both sides.
    pub two_sided: bool,
    /// How a light other than the environment is chosen.
    pub selection: Selection<'a>,
    /// What was learned of the tree's clusters, under [`Selection::Tree`], and of patches of an environment map; only where it
    /// pays.
    pub learned: Option<LearnedLights>,
    /// What was learned of which cells see each other; only under [`Lights::NeePlusPlus`].
    pub visibility: Option<Visibility>,
    /// Per light, the probability with which a light sample goes to it; one value if all have the same. (Not under
    /// [`Selection::Tree`], where it depends on the place.)
    pub probabilities: Vec<f32>,
    /// The environment, if it is a light.
    pub environment: Option<EnvironmentLight<'a>>,
    /// Probability with which a light sample goes to the environment, where it is the same everywhere (that is, but under
    /// [`Selection::Tree`]): 0, 1/2 or 1.
    pub environment_probability: f32,
}

impl<'a> LightTable<'a> {
    /// The table of `scene` under `lights`; `compensated`: see [`EnvironmentMap::distribution`]. Nothing is learned yet: until
    /// [`LightTable::learned`] is set, [`Lights::Learned`] and [`Lights::NeePlusPlus`] choose as [`Lights::Tree`] does.
    pub fn new(scene: &'a PreparedScene, lights: Lights, compensated: bool) -> LightTable<'a> {
        let deltas = &scene.delta_lights.records[..];
        let count = scene.emitters.len() + deltas.len();
        let environment_probability = match (&scene.environment, count) {
            (None, _) => 0.0,
            (Some(_), 0) => 1.0,
            (Some(_), _) => 0.5,
        };
        let tree = if lights.by_tree() { scene.light_tree(|| powers(scene), false) } else { None };
        let to_emitters = 1.0 - environment_probability as f64;
        let stated = if planted(Fault::LopsidedChoice) { 0.9 * to_emitters } else { to_emitters };
        let records = scene.emitters.iter().map(|emitter| {
            let triangle = &scene.triangles[emitter.triangle as usize];
            LightRecord {
                vertices: triangle.vertices,
                normal: triangle.normal,
                radiance: emitter.radiance.map(|c| if planted(Fault::InfiniteRadiance) { f32::INFINITY } else { c }),
                signed_pdf_area: (1.0 / emitter.area) as f32 * if emitter.two_sided { -1.0 } else { 1.0 },
            }
        });
        let selection = match (count, lights, tree) {
            (_, _, Some(tree)) => Selection::Tree(tree),
            (0 | 1, ..) => Selection::Fixed(Fixed::Single),
            (_, Lights::Power, _) => Selection::Fixed(Fixed::by_power(&powers(scene), to_emitters)),
            _ => Selection::Fixed(Fixed::Uniform(count as u32)),
        };
        let environment = scene.environment.as_ref().map(|environment| match environment {
            Environment::Constant(radiance) => EnvironmentLight::Constant(*radiance),
            Environment::Map(map) => EnvironmentLight::Map(map, map.distribution(compensated)),
        });
        LightTable {
            records: records.collect(),
            deltas,
            targets: Targets::new(scene),
            textures: textures(scene),
            two_sided: scene.emitters.iter().any(|emitter| emitter.two_sided),
            probabilities: match &selection {
                Selection::Fixed(Fixed::Alias(columns)) => {
                    // Beside an environment the word's three top bits are used up, and it ends in as many zeros.
                    let zeros = if environment.is_some() { 3 } else { 0 };
                    let drawn = probabilities_by_word(columns, zeros);
                    drawn.into_iter().map(|probability| (probability * stated) as f32).collect()
                }
                _ => vec![(stated / count as f64) as f32; count.min(1)],
            },
            selection,
            learned: None,
            visibility: None,
            environment,
            environment_probability,
        }
    }

    /// Gives it what any scene may need: a tree, where `lights` choose by one, if there is but one lamp, and textures of lights
    /// if none has one. Nothing is drawn otherwise.
    pub fn generalise(&mut self, scene: &'a PreparedScene, lights: Lights) {
        if let (Selection::Fixed(_), true) = (&self.selection, lights.by_tree()) {
            self.selection = scene.light_tree(|| powers(scene), true).map_or(self.selection.clone(), Selection::Tree);
        }
        if self.textures.is_none() {
            self.textures = Some(light_textures(scene, false));
        }
    }

    /// What was learned of the light tree.
    #[inline]
    pub fn learned_tree(&self) -> Option<&LearnedLights> {
        self.learned.as_ref().filter(|learned| learned.slot_count > 0)
    }

    /// What was learned of patches of the environment map.
    #[inline]
    pub fn learned_patches(&self) -> Option<&LearnedPatches> {
        self.learned.as_ref()?.patches.as_ref()
    }

    /// How many lights there are besides the environment.
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.records.len() + self.deltas.len()
    }

    /// Whether there is anything to sample.
    pub fn is_empty(&self) -> bool {
        self.count() == 0 && self.environment.is_none()
    }

    /// Whether rays can find any light.
    pub fn can_be_hit(&self) -> bool {
        !self.records.is_empty() || self.environment.is_some()
    }

    /// The delta light with the number `light`; `None`: that is an emitter.
    #[inline]
    pub fn delta(&self, light: u32) -> Option<&DeltaRecord> {
        self.deltas.get((light as usize).checked_sub(self.records.len())?)
    }

    /// The probability with which a light sample goes to the light with the number `light`.
    #[inline]
    pub fn probability(&self, light: u32) -> f32 {
        if self.probabilities.len() == 1 { self.probabilities[0] } else { self.probabilities[light as usize] }
    }

    /// The tables and their sizes in bytes.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        let mut tables =
            vec![("light records", size_of_val(&self.records[..])), ("delta lights", size_of_val(self.deltas))];
        match &self.selection {
            Selection::Fixed(Fixed::Alias(columns)) => {
                tables.push(("light alias table", size_of_val(&columns[..])));
                tables.push(("light probabilities", size_of_val(&self.probabilities[..])));
            }
            Selection::Tree(tree) => tables.push(("light tree", tree.bytes())),
            _ => {}
        }
        tables.extend(self.learned.iter().flat_map(LearnedLights::tables));
        tables.extend(self.visibility.iter().flat_map(Visibility::tables));
        tables.retain(|table| table.1 > 0);
        tables
    }
}

fn textures(scene: &PreparedScene) -> Option<LightTextures> {
    let emitters = &scene.emitters;
    let masked = emitters.iter().any(|emitter| scene.alpha_masks.cuts(emitter.triangle));
    (masked || emitters.iter().any(|emitter| emitter.texture.is_some())).then(|| light_textures(scene, masked))
}

/// The textures of all lights, whether any has one or not; with alpha masks if some light is `masked`.
fn light_textures(scene: &PreparedScene, masked: bool) -> LightTextures {
    let emitters = &scene.emitters;
    LightTextures {
        textures: scene.textures.clone(),
        texture: emitters.iter().map(|e| e.texture.map_or(NO_TEXTURE, |(texture, _)| texture)).collect(),
        uvs: emitters.iter().map(|e| e.texture.map_or([[0.0; 2]; 3], |(_, uvs)| uvs)).collect(),
        alpha_masks: masked.then(|| (scene.alpha_masks.clone(), emitters.iter().map(|e| e.triangle).collect())),
    }
}

/// What the lights of a scene but for its environment send out, in the order of their numbers; up to a constant factor.
fn powers(scene: &PreparedScene) -> Vec<f64> {
    scene.emitters.iter().map(|emitter| power(scene, emitter)).chain(scene.delta_lights.powers()).collect()
}

/// What an emitter sends out, up to a constant factor: of a picture, its mean (never quite 0, so that a total exists).
pub fn power(scene: &PreparedScene, emitter: &Emitter) -> f64 {
    let sides = if emitter.two_sided { 2.0 } else { 1.0 };
    let mean = emitter.texture.map_or(1.0, |(texture, _)| scene.textures.mean(texture).max(1e-6));
    mean * sides * emitter.area * emitter.radiance.iter().map(|&c| c as f64).sum::<f64>()
}

/// Light kinds in words, for plans and reports.
pub fn selection_name(table: &LightTable) -> String {
    let triangles = match &table.selection {
        _ if table.count() == 0 => None,
        Selection::Fixed(Fixed::Single) => Some("single light"),
        Selection::Fixed(Fixed::Uniform(_)) => Some("uniform"),
        Selection::Fixed(Fixed::Alias(_)) => Some("power (alias table)"),
        Selection::Tree(_) if table.visibility.is_some() => Some("light tree, weighed by visibility"),
        Selection::Tree(_) if table.learned_tree().is_some() => Some("light tree, weighed by what was learned"),
        Selection::Tree(_) => Some("light tree"),
    };
    let patches = table.learned_patches().is_some();
    let environment = table.environment.map(|environment| match environment {
        EnvironmentLight::Map(..) if patches => {
            "environment map, importance sampled, patches weighed by what was learned"
        }
        EnvironmentLight::Constant(_) => "constant environment, by cosine",
        EnvironmentLight::Map(_, Distribution { floor: 0.0, .. }) => "environment map, importance sampled",
        EnvironmentLight::Map(..) => "environment map, importance sampled above its mean",
    });
    let names = triangles.into_iter().chain(environment).collect::<Vec<_>>().join(" or ");
    if table.visibility.is_some() { names + "; roulette of shadow rays by visibility" } else { names }
}
