//! What a training render writes down of eight light samples.

use super::here;
use crate::learn::patches::PatchVisit;
use crate::learn::records::{CAP, Lesson, LightRecords, PLAIN_UNIT, SQUARE_UNIT, Visit};
use crate::tables::lights::learned::{LearnedLights, NO_SLOT};
use crate::tables::lights::patches::LearnedPatches;
use crate::tables::lights::table::{LightTable, Selection};
use crate::tables::lights::targets::{DELTA, MISSED};
use crate::tables::lights::tree::{LEAF, LightTree};
use here::kernels::lights::light_sample::LightSamples;
use here::kernels::lights::tree::{Receivers, cluster_importances, shares, sum};
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8, Vec3x8};

/// Eight light samples of a training render.
pub struct Samples<'a> {
    /// The lights.
    pub lights: &'a LightTable<'a>,
    /// Where they are wanted.
    pub receivers: Receivers,
    /// Keys of the receivers.
    pub key: U32x8,
    /// The samples.
    pub sample: &'a LightSamples,
    /// Their contributions without the paths' throughputs.
    pub gain: Vec3x8,
    /// The words that choose patches of an environment map.
    pub word: U32x8,
    /// Lanes that drew one.
    pub drawn: Mask8,
    /// Lanes whose sample has got a shadow ray.
    pub traced: Mask8,
}

/// Writes down samples that cannot contribute; what the others tell goes to `pending`, in the order of the lanes.
#[inline(never)]
pub fn record(samples: &Samples, pending: &mut Vec<Lesson>, records: &mut LightRecords) {
    here::run(
        #[inline(always)]
        || {
            let Some(learned) = &samples.lights.learned else { return };
            let columns = |v: Vec3x8| [v.x.to_array(), v.y.to_array(), v.z.to_array()];
            let (origin, normal) = (columns(samples.receivers.origin), columns(samples.receivers.normal));
            let (key, row) = (samples.key.to_array(), samples.receivers.row.to_array());
            let (target, tmax) = (samples.sample.target.to_array(), samples.sample.shadow_tmax.to_array());
            let gain = (samples.gain.x + samples.gain.y + samples.gain.z).to_array();
            let word = samples.word.to_array();
            let mut lanes = samples.drawn.bits();
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                lanes &= lanes - 1;
                let at = |v: &[[f32; LANES]; 3]| Vec3x8::splat([v[0][lane], v[1][lane], v[2][lane]]);
                // Shadow rays to directional lights leave the scene as those to the environment do.
                let chosen = tmax[lane] < f32::INFINITY || target[lane] & DELTA != 0;
                let lesson = match (&samples.lights.selection, &learned.patches) {
                    (_, Some(patches)) if !chosen => {
                        let patch = patch_visit(patches, key[lane], row[lane], word[lane], gain[lane]);
                        Lesson { patch: Some(patch), ..Lesson::default() }
                    }
                    (Selection::Tree(tree), _) if chosen && learned.slot_count > 0 => {
                        let place = Place { origin: at(&origin), normal: at(&normal), key: key[lane], row: row[lane] };
                        lesson(tree, learned, &place, target[lane] & !(MISSED | DELTA), gain[lane])
                    }
                    _ => Lesson::default(),
                };
                if samples.traced.bits() >> lane & 1 == 1 {
                    pending.push(lesson);
                } else {
                    records.note(&lesson, false);
                }
            }
        },
    )
}

/// What a sample of an environment map tells that the word `word` has chosen a patch for, and that contributes `gain` if it is
/// free.
#[inline(always)]
fn patch_visit(patches: &LearnedPatches, key: u32, row: u32, word: u32, gain: f32) -> PatchVisit {
    let patch = patches.patch(row, word);
    let ratio = patches.ratio(row, patch);
    let worth = gain * ratio / patches.unit;
    let worth = if worth < CAP { worth } else { CAP };
    let square = worth * worth * SQUARE_UNIT;
    let without = square / ratio;
    PatchVisit {
        key,
        patch: patch as u32,
        square: square as u64,
        with: (without / ratio) as u64,
        without: without as u64,
    }
}

/// One receiver, eight times given, and where it looks up.
struct Place {
    origin: Vec3x8,
    normal: Vec3x8,
    key: u32,
    row: u32,
}

/// What a sample of `light` tells that contributes `gain` if it is free.
#[inline(always)]
fn lesson(tree: &LightTree, learned: &LearnedLights, place: &Place, light: u32, gain: f32) -> Lesson {
    let mut lesson = Lesson::default();
    let (mut path, mut node, mut worth) = (tree.paths[light as usize], 0, gain);
    while learned.slots[node as usize] != NO_SLOT {
        let column = (path & 7) as usize;
        path >>= 3;
        let raw = cluster_importances(&tree.nodes[node as usize], place.origin, place.normal);
        let word = learned.word(place.row, node);
        let bytes = word.to_le_bytes();
        let weighed = raw * F32x8::from_array(bytes.map(f32::from));
        let weighed = weighed.to_array().each(F32x8::splat);
        let shares = shares(&weighed);
        let total = sum(&shares);
        let share = (shares[column] / total).to_array()[0];
        worth *= share;
        let promised = raw.to_array()[column] * learned.unit;
        let ratio = if promised > 0.0 { worth / promised } else { 0.0 };
        let ratio = if ratio < CAP { ratio } else { CAP };
        lesson.push(Visit {
            pair: place.key * learned.slot_count + learned.slots[node as usize],
            column: column as u32,
            plain: PLAIN_UNIT / u32::from(bytes[column]),
            square: (ratio * ratio * SQUARE_UNIT) as u32,
        });
        let child = tree.nodes[node as usize].child[column];
        if child & LEAF != 0 {
            break;
        }
        node = child;
    }
    lesson
}
