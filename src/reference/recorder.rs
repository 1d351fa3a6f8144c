//! What a training render writes down of its light samples and directions: an observer of its paths.

use super::guide::{bin, luminance};
use super::lights::choose::{Light, choose};
use super::lights::factors::factors;
use super::lights::sample::environment_words;
use super::lights::tree::{Receiver, importance, shares};
use super::lights::visibility::pair;
use super::observer::{Choice, Event, Observer, Path};
use super::{Real, Vec3};
use crate::learn::guide::records::Step;
use crate::learn::guide::steps::StepRecords;
use crate::learn::patches::PatchVisit;
use crate::learn::records::{CAP, Lesson, LightRecords, PLAIN_UNIT, SQUARE_UNIT, Visit};
use crate::learn::visibility::records::VisibilityRecords;
use crate::setup::Setup;
use crate::tables::guide::SIDE;
use crate::tables::lights::learned::NO_SLOT;
use crate::tables::lights::patches::LearnedPatches;
use crate::tables::lights::table::Selection;
use crate::tables::lights::tree::LEAF;

/// Writes down what is asked for.
pub struct Recorder<'a> {
    /// The render.
    pub setup: &'a Setup<'a>,
    /// Where light samples go to.
    pub lights: Option<&'a mut LightRecords>,
    /// Where shadow rays go to, whether they are free.
    pub sightings: Option<&'a mut VisibilityRecords>,
    /// Where directions go to.
    pub steps: Option<&'a mut StepRecords>,
    /// The direction drawn last, until the path has gone on in it.
    pub step: Option<Step>,
}

impl Recorder<'_> {
    /// Tells that the path it was told of, of the pixel with this address, has ended.
    pub fn end_path(&mut self, pixel: u32, radiance: Vec3) {
        if let (Some(steps), Some(guide)) = (&mut self.steps, &self.setup.guide) {
            steps.end_paths(guide, std::iter::once((pixel, narrow(radiance))));
        }
        self.step = None;
    }

    fn note_light(&mut self, choice: &Choice, gain: Real, free: bool) {
        if let Some(lights) = &mut self.lights {
            lights.note(&lesson(choice, gain), free);
        }
    }
}

fn narrow(v: Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

impl Observer for Recorder<'_> {
    fn note(&mut self, path: &Path, event: Event) {
        // What is found after the last event is too little to learn from.
        let last = path.depth + 1 == self.setup.max_depth;
        match event {
            Event::LightIdle(choice, _) => self.note_light(&choice, 0.0, false),
            Event::Light { choice, light, f_cosine, weight, blocked, .. } => {
                // Without the path's throughput: what the place makes of the light, however the path got there.
                let gain: Vec3 = f_cosine * light.radiance * (weight / light.pdf_dir);
                self.note_light(&choice, gain.x + gain.y + gain.z, !blocked);
                if let (Some(records), Some(visibility)) = (&mut self.sightings, &choice.lights.visibility)
                    && let Some(pair) = pair(visibility, choice.point.origin, light)
                {
                    records.note(pair, !blocked);
                }
            }
            Event::Lost(Some(place), _) if !last => {
                if let Some(steps) = &mut self.steps {
                    steps.records.note_lost(place.place, place.leaf);
                }
            }
            Event::Bounce(_, _, _, bounce) if !last && self.steps.is_some() => {
                self.step = bounce.place.map(|place| {
                    let ([column, row], norm) = bin(bounce.direction);
                    Step {
                        path: 0,
                        place: place.place,
                        leaf: place.leaf,
                        bin: (row * SIDE + column) as u32,
                        norm: norm as f32,
                        cosine: bounce.cosine as f32,
                        pdf_dir: bounce.pdf_dir as f32,
                        pdf_guide: place.guide_pdf_dir(bounce.direction) as f32,
                        throughput: 0.0,
                        before: 0.0,
                    }
                });
            }
            Event::Ray(_) => {
                if let (Some(steps), Some(step)) = (&mut self.steps, self.step.take()) {
                    steps.push(Step { throughput: luminance(path.beta) as f32, ..step });
                    steps.set_out(|_| narrow(path.radiance.value()));
                }
            }
            _ => {}
        }
    }
}

/// What a sample of an environment map tells that contributes `gain` if it is free, where choosing a light has left `word`.
fn patch_visit(patches: &LearnedPatches, choice: &Choice, word: u32, gain: Real) -> PatchVisit {
    let [word, _] = environment_words(choice.lights, word, choice.fork);
    let patch = patches.patch(choice.place.row, word);
    // Its probability over that under the map's own distribution, under which the sample would have contributed so much more.
    let ratio = patches.ratio(choice.place.row, patch) as Real;
    let worth = gain * ratio / patches.unit as Real;
    let worth = if worth < CAP as Real { worth } else { CAP as Real };
    let square = worth * worth * SQUARE_UNIT as Real;
    let without = square / ratio;
    PatchVisit {
        key: choice.place.key,
        patch: patch as u32,
        square: square as u64,
        with: (without / ratio) as u64,
        without: without as u64,
    }
}

/// What the sample of a choice tells that contributes `gain` if it is free.
fn lesson(choice: &Choice, gain: Real) -> Lesson {
    let mut lesson = Lesson::default();
    let Some(learned) = &choice.lights.learned else { return lesson };
    let receiver = Receiver { origin: choice.point.origin, normal: choice.point.normal, row: choice.place.row };
    let (light, _, word) = choose(choice.lights, &receiver, choice.word);
    let Light::Emitter(light) = light else {
        let patches = learned.patches.as_ref();
        lesson.patch = patches.map(|patches| patch_visit(patches, choice, word, gain));
        return lesson;
    };
    let Selection::Tree(tree) = &choice.lights.selection else { return lesson };
    if learned.slot_count == 0 {
        return lesson;
    }
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
