//! What a training render writes down of its light samples: an observer of its paths.

use super::lights::choose::{Light, choose};
use super::lights::factors::factors;
use super::lights::tree::{Receiver, importance, shares};
use super::observer::{Choice, Event, Observer, Path};
use super::{Real, Vec3};
use crate::learn::records::{CAP, Lesson, LightRecords, PLAIN_UNIT, SQUARE_UNIT, Visit};
use crate::tables::lights::learned::NO_SLOT;
use crate::tables::lights::table::Selection;
use crate::tables::lights::tree::LEAF;

/// Writes light samples down.
pub struct Recorder<'a> {
    /// Where to.
    pub records: &'a mut LightRecords,
}

impl Observer for Recorder<'_> {
    fn note(&mut self, _: &Path, event: Event) {
        match event {
            Event::LightIdle(choice, _) => self.records.note(&lesson(&choice, 0.0), false),
            Event::Light { choice, light, f_cosine, weight, blocked, .. } => {
                // Without the path's throughput: what the place makes of the light, however the path got there.
                let gain: Vec3 = f_cosine * light.radiance * (weight / light.pdf_dir);
                self.records.note(&lesson(&choice, gain.x + gain.y + gain.z), !blocked);
            }
            _ => {}
        }
    }
}

/// What the sample of a choice tells that contributes `gain` if it is free; nothing if it went to the environment.
fn lesson(choice: &Choice, gain: Real) -> Lesson {
    let mut lesson = Lesson::default();
    let (Selection::Tree(tree), Some(learned)) = (&choice.lights.selection, &choice.lights.learned) else {
        return lesson;
    };
    let receiver = Receiver { origin: choice.point.origin, normal: choice.point.normal, row: choice.place.row };
    let (Light::Emitter(light), ..) = choose(choice.lights, &receiver, choice.word) else { return lesson };
    let mut path = tree.paths[light as usize];
    let mut node = 0;
    // What is left of the gain once the node's own choice no longer divides it.
    let mut worth = gain;
    loop {
        let slot = learned.slots[node as usize];
        if slot == NO_SLOT {
            return lesson;
        }
        let clusters = &tree.nodes[node as usize];
        let column = (path & 7) as usize;
        path >>= 3;
        let factors = factors(Some(learned), receiver.row, node);
        let shares = shares(clusters, &factors, &receiver);
        worth *= shares[column] / shares.iter().fold(0.0, |sum, share| sum + share);
        let promised = importance(clusters, column, &receiver) * learned.unit as Real;
        let ratio = if promised > 0.0 { worth / promised } else { 0.0 };
        let ratio = if ratio < CAP as Real { ratio } else { CAP as Real };
        lesson.push(Visit {
            pair: choice.place.key * learned.slot_count + slot,
            column: column as u32,
            plain: PLAIN_UNIT / factors[column] as u32,
            square: (ratio * ratio * SQUARE_UNIT as Real) as u32,
        });
        let child = clusters.child[column];
        if child & LEAF != 0 {
            return lesson;
        }
        node = child;
    }
}
