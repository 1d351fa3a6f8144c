//! The pass that gathers layers ([`crate::film::layers`]) once all samples are taken: the camera rays of those samples again, by
//! the same threads over the same tiles.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::Result;
use crate::files::memory;
use crate::film::Film;
use crate::film::layers::{LayerPixel, LayerSums};
use crate::packet::counters::Counters;
use crate::packet::layers::find_first_hits;
use crate::packet::plan::Plan;
use crate::reference::single;
use crate::render::shared::{Locked, Operations, SharedSum};
use crate::render::tiles::Layout;
use crate::render::workers::{PATHS_AT_ONCE, Worker, fill_slots, together};
use crate::settings::Crop;
use crate::setup::Setup;

/// One pass.
pub(super) struct Pass<'a> {
    pub(super) setup: &'a Setup<'a>,
    pub(super) plan: &'a Plan,
    pub(super) layout: &'a Layout,
    /// Samples a pixel.
    pub(super) spp: u32,
    /// Somebody wants the render to end; it stays so.
    pub(super) stop: &'a AtomicBool,
    /// Is told now and then that the pass goes on; returns false if it is to end.
    pub(super) tell: &'a (dyn Fn() -> bool + Sync),
}

/// Room for the layers of `film`: had before a render, so that no samples are lost for want of it.
pub(super) fn room(film: &Film) -> Result<Vec<LayerPixel>> {
    let (width, height) = (film.width, film.height);
    memory::table(width as usize * height as usize, &format!("the layers of {width} x {height} pixels"))
}

impl Pass<'_> {
    /// Fills `pixels`, in the order of the film's, which has rows of `width`; whether all of it was done.
    pub(super) fn run(&self, workers: &mut [Worker], pixels: &mut [LayerPixel], width: u32) -> bool {
        let tiles: Vec<Locked<&mut [LayerPixel]>> = self.layout.pieces(pixels).map(Locked::new).collect();
        let next = SharedSum::new(0);
        let work = |worker: &mut Worker| self.work(worker, &tiles, &next);
        together(workers, work);
        drop(tiles);
        self.layout.to_rows(pixels, width);
        !self.stop.load(Ordering::Relaxed)
    }

    /// One thread's part.
    fn work(&self, worker: &mut Worker, tiles: &[Locked<&mut [LayerPixel]>], next: &SharedSum) {
        // Not the samples' operations, which statistics tell.
        let mut operations = Operations::default();
        let mut sums: Vec<LayerSums> = Vec::new();
        loop {
            let number = next.add(1, &mut operations) as usize;
            let (Some(tile), Some(&area)) = (tiles.get(number), self.layout.areas.get(number)) else { return };
            let mut pixels = tile.lock(&mut operations);
            sums.clear();
            sums.resize(pixels.len(), LayerSums::default());
            let at_once = (PATHS_AT_ONCE / pixels.len().max(1)).max(1) as u32;
            for first in (0..self.spp).step_by(at_once as usize) {
                if self.stop.load(Ordering::Relaxed) {
                    return;
                }
                let range = first..self.spp.min(first.saturating_add(at_once));
                self.add_samples(worker, area, range, &mut sums);
                if !(self.tell)() {
                    self.stop.store(true, Ordering::Relaxed);
                }
            }
            pixels.iter_mut().zip(&sums).for_each(|(pixel, sums)| *pixel = sums.means());
        }
    }

    /// Adds samples `range` of every pixel of `area`: of so few that their rays are followed at once.
    fn add_samples(&self, worker: &mut Worker, area: Crop, range: std::ops::Range<u32>, sums: &mut [LayerSums]) {
        match &mut worker.state {
            Some(state) => {
                fill_slots(&mut state.slots, &mut worker.pixel_of_slot, area, range.start, range.len() as u32);
                find_first_hits(self.setup, self.plan, state, &mut Counters::default());
                for (hit, &pixel) in state.first_hits.iter().zip(&worker.pixel_of_slot) {
                    sums[pixel as usize].add(hit);
                }
            }
            None => {
                for (index, sums) in sums.iter_mut().enumerate() {
                    let pixel = (area.x + index as u32 % area.width, area.y + index as u32 / area.width);
                    let find = |sample| single::layers::find_first_hit(self.setup, pixel, sample);
                    range.clone().for_each(|sample| sums.add(&find(sample)));
                }
            }
        }
    }
}
