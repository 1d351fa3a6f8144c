//! What the paths of a training render have found after each bounce at a diffuse surface: integers, so that adding them up in
//! any order gives the same bits.

use crate::math::{INV_PI, min};
use crate::tables::guide::{BINS, Guide, LUMINANCE, PART};

/// What sums of radiance are in: 2^-36 of the scene's unit. Sums stop at their largest number, which no order of adding changes.
pub const UNIT: f32 = 68_719_476_736.0;
/// What sums of squares of ratios are in.
pub const SQUARE_UNIT: f32 = 65_536.0;
/// Most that the square of what a path gains counts, over that of its leaf's mean.
const MOST_OF_LEAF: f32 = 1_048_576.0;
/// Most that the square of what a path gains counts, over that of what its pixel shows: fireflies must not decide alone.
const MOST_OF_PIXEL: f32 = 400.0;

/// The luminance of a radiance.
#[inline(always)]
pub fn luminance([r, g, b]: [f32; 3]) -> f32 {
    r * LUMINANCE[0] + g * LUMINANCE[1] + b * LUMINANCE[2]
}

/// A direction that a path has gone on in from a diffuse surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Step {
    /// The path, as the engine counts them.
    pub path: u32,
    /// Its place ([`Guide::leaves`]) and leaf.
    pub place: u32,
    pub leaf: u32,
    /// The bin of the direction.
    pub bin: u32,
    /// The sum of the absolute components of the direction.
    pub norm: f32,
    /// The cosine between direction and normal.
    pub cosine: f32,
    /// The density with which the direction was drawn, per steradian.
    pub pdf_dir: f32,
    /// What the guide's own density of it was.
    pub pdf_guide: f32,
    /// The luminance of the throughput, roulette included.
    pub throughput: f32,
    /// The luminance that the path had gathered when it set out.
    pub before: f32,
}

/// What a path has found in a direction that it went on in, for tables whose leaves are not known yet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// As in [`Step`].
    pub place: u32,
    pub bin: u32,
    pub norm: f32,
    pub cosine: f32,
    /// The luminance found; above 0.
    pub found: f32,
}

/// The directions of a pilot one by one, in no particular order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcomes {
    /// The place of every one, whatever it has led to.
    pub places: Vec<u32>,
    /// Those that have led to light.
    pub outcomes: Vec<Outcome>,
    /// Of each of these, the pixel of the pilot's grid and the luminance that it has brought there.
    pub gains: Vec<(u32, f32)>,
}

/// Sums of one leaf.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// Directions drawn.
    pub count: u64,
    /// Radiance found times cosine over density, in 1 / [`UNIT`].
    pub irradiance: u64,
    /// Squares of what directions drawn by the cosine would have brought, over that of the mean.
    pub plain: u64,
    /// The same of directions drawn from the mixture.
    pub mixed: u64,
    /// As `irradiance`, by bin.
    pub bins: [u64; BINS],
}

impl Leaf {
    /// Nothing yet.
    pub const EMPTY: Leaf = Leaf { count: 0, irradiance: 0, plain: 0, mixed: 0, bins: [0; BINS] };

    /// What half of its places have seen, as far as is known.
    pub fn halve(&mut self) {
        let Leaf { count, irradiance, plain, mixed, bins } = self;
        [count, irradiance, plain, mixed].into_iter().chain(bins).for_each(|sum| *sum /= 2);
    }

    /// Adds the square of what a direction drawn with density `pdf_dir` has brought, over the mean, and of what it would have in
    /// the mixture; both as if directions were drawn by the cosine.
    pub fn judge(&mut self, ratio: f32, pdf_cosine: f32, pdf_dir: f32, pdf_guide: f32) {
        let better = pdf_cosine / (PART * pdf_guide + (1.0 - PART) * pdf_cosine);
        let square = min(ratio * ratio, MOST_OF_LEAF) * pdf_cosine / pdf_dir;
        self.plain = self.plain.saturating_add(fixed(square, SQUARE_UNIT));
        self.mixed = self.mixed.saturating_add(fixed(square * better, SQUARE_UNIT));
    }

    /// Adds all of `other`.
    pub fn add(&mut self, other: &Leaf) {
        self.count += other.count;
        self.irradiance = self.irradiance.saturating_add(other.irradiance);
        self.plain = self.plain.saturating_add(other.plain);
        self.mixed = self.mixed.saturating_add(other.mixed);
        for (mine, theirs) in self.bins.iter_mut().zip(&other.bins) {
            *mine = mine.saturating_add(*theirs);
        }
    }
}

/// All records, of one thread or of all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GuideRecords {
    /// By leaf.
    pub leaves: Vec<Leaf>,
    /// By pixel of the pilot's grid, the sum of the paths' luminances, in 1 / [`UNIT`].
    pub image: Vec<u64>,
    /// Squares of what paths bring after their bounces at diffuse surfaces, over what their pixels show, as if directions had been
    /// drawn by the cosine: what there is for guiding to make less of.
    pub indirect: u64,
    /// The directions one by one, where they are asked for.
    pub outcomes: Option<Outcomes>,
}

/// `value` in `unit`, cut to an integer; 0 unless it is a finite number above 0.
pub fn fixed(value: f32, unit: f32) -> u64 {
    if value < f32::INFINITY { (value * unit) as u64 } else { 0 }
}

/// The square of what a path brings to its pixel over what that shows, cut.
fn square_of_pixel(gain: f32, inverse: f32) -> f32 {
    let part = gain * inverse;
    min(part * part, MOST_OF_PIXEL)
}

impl Outcomes {
    /// As [`GuideRecords::indirect`], of paths that were not guided, by what pixels are now known to show.
    pub fn indirect(&self, inverse: &[f32]) -> u64 {
        let squares = self.gains.iter().map(|&(pixel, gain)| square_of_pixel(gain, inverse[pixel as usize]));
        squares.fold(0, |sum: u64, square| sum.saturating_add(fixed(square, SQUARE_UNIT)))
    }

    fn take(&mut self, other: &mut Outcomes) {
        self.places.append(&mut other.places);
        self.outcomes.append(&mut other.outcomes);
        self.gains.append(&mut other.gains);
    }
}

impl GuideRecords {
    /// No records yet, for so many leaves and pixels.
    pub fn new(leaves: usize, pixels: usize) -> GuideRecords {
        GuideRecords { leaves: vec![Leaf::EMPTY; leaves], image: vec![0; pixels], ..GuideRecords::default() }
    }

    /// Notes a direction at a place, in its leaf, that leads below the surface.
    pub fn note_lost(&mut self, place: u32, leaf: u32) {
        self.leaves[leaf as usize].count += 1;
        if let Some(outcomes) = &mut self.outcomes {
            outcomes.places.push(place);
        }
    }

    /// Notes a step of a path of grid pixel `pixel` whose luminance was `after` in the end.
    pub fn note(&mut self, guide: &Guide, step: &Step, after: f32, pixel: usize) {
        let leaf = &mut self.leaves[step.leaf as usize];
        leaf.count += 1;
        if let Some(outcomes) = &mut self.outcomes {
            outcomes.places.push(step.place);
        }
        let gain = after - step.before;
        let found = gain / step.throughput;
        let value = found * step.cosine / step.pdf_dir;
        let units = fixed(value, UNIT);
        if units == 0 {
            return;
        }
        leaf.irradiance = leaf.irradiance.saturating_add(units);
        let bin = &mut leaf.bins[step.bin as usize];
        *bin = bin.saturating_add(units);
        if let Some(outcomes) = &mut self.outcomes {
            let Step { place, bin, norm, cosine, .. } = *step;
            outcomes.outcomes.push(Outcome { place, bin, norm, cosine, found });
            outcomes.gains.push((pixel as u32, gain));
        }
        let pdf_cosine = step.cosine * INV_PI;
        let mean = guide.reflected[step.leaf as usize];
        if mean > 0.0 {
            leaf.judge(found / mean, pdf_cosine, step.pdf_dir, step.pdf_guide);
        }
        let square = square_of_pixel(gain, guide.pixels.inverse[pixel]) * step.pdf_dir / pdf_cosine;
        self.indirect = self.indirect.saturating_add(fixed(square, SQUARE_UNIT));
    }

    /// Notes a path of grid pixel `pixel` whose luminance was `after` in the end.
    pub fn note_path(&mut self, pixel: usize, after: f32) {
        let sum = &mut self.image[pixel];
        *sum = sum.saturating_add(fixed(after, UNIT));
    }

    /// Adds all of `other`, and leaves it empty.
    pub fn take(&mut self, other: &mut GuideRecords) {
        for (mine, theirs) in self.leaves.iter_mut().zip(&mut other.leaves).filter(|(_, theirs)| theirs.count > 0) {
            mine.add(theirs);
            *theirs = Leaf::EMPTY;
        }
        for (mine, theirs) in self.image.iter_mut().zip(&mut other.image) {
            *mine = mine.saturating_add(*theirs);
            *theirs = 0;
        }
        self.indirect = self.indirect.saturating_add(std::mem::take(&mut other.indirect));
        if let (Some(mine), Some(theirs)) = (&mut self.outcomes, &mut other.outcomes) {
            mine.take(theirs);
        }
    }
}
