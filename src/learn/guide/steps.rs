//! Paths of a training render that are still on their way.

use crate::learn::guide::records::{GuideRecords, Step, luminance};
use crate::tables::guide::Guide;

/// The records of a training render, and the steps of paths whose end is not known yet.
#[derive(Debug, Default)]
pub struct StepRecords {
    /// The records.
    pub records: GuideRecords,
    steps: Vec<Step>,
    /// Steps that know what their paths had gathered when they set out.
    complete: usize,
}

impl StepRecords {
    /// To be added to `records`.
    pub fn new(records: GuideRecords) -> StepRecords {
        StepRecords { records, ..StepRecords::default() }
    }

    /// Adds a step.
    pub fn push(&mut self, step: Step) {
        self.steps.push(step);
    }

    /// Tells the steps added since the last call what their paths have gathered so far; `radiance`: by path.
    pub fn set_out(&mut self, radiance: impl Fn(usize) -> [f32; 3]) {
        for step in &mut self.steps[self.complete..] {
            step.before = luminance(radiance(step.path as usize));
        }
        self.complete = self.steps.len();
    }

    /// All paths have ended: notes what steps and paths have come to. `ends`: by path, the pixel's address and the radiance.
    pub fn end_paths(&mut self, guide: &Guide, ends: impl ExactSizeIterator<Item = (u32, [f32; 3])> + Clone) {
        let pixels = &guide.pixels;
        let ends: Vec<(u32, f32)> = ends.map(|(pixel, radiance)| (pixel, luminance(radiance))).collect();
        for step in self.steps.drain(..) {
            let (pixel, after) = ends[step.path as usize];
            self.records.note(guide, &step, after, pixels.index(pixel));
        }
        for (pixel, after) in ends {
            self.records.note_path(pixels.index(pixel), after);
        }
        self.complete = 0;
    }
}
