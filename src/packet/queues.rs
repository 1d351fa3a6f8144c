//! Every queue and every path field: what it means, in which unit and space. All are one array a field, eight lanes a block,
//! sized once for a tile of `capacity` paths plus a spare block, so that a compressed store never needs a check.

use crate::bvh::ray::{HitQueue, RayQueue};
use crate::film::layers::FirstHit;
use crate::lanes::LANES;
use crate::learn::guide::steps::StepRecords;
use crate::learn::records::{Lesson, LightRecords};
use crate::learn::visibility::records::VisibilityRecords;
use crate::tables::materials::PerKind;

/// [`PathQueue::slot`], bit 31: emission found by this ray counts 1 (camera ray, or the last lobe was a delta).
pub const COUNTS_ONE: u32 = 1 << 31;
/// [`PathQueue::slot`], bit 30: emission found by this ray counts 0 (the one-sample coin chose the light).
pub const COUNTS_ZERO: u32 = 1 << 30;
/// The path's place in the tile, without the flags.
pub const SLOT: u32 = COUNTS_ZERO - 1;

/// Three columns that hold vectors or colours.
#[derive(Default)]
pub struct Columns3 {
    /// First components.
    pub x: Vec<f32>,
    /// Second components.
    pub y: Vec<f32>,
    /// Third components.
    pub z: Vec<f32>,
}

impl Columns3 {
    fn with_len(len: usize) -> Columns3 {
        let column = || vec![0.0; len.next_multiple_of(LANES) + LANES];
        Columns3 { x: column(), y: column(), z: column() }
    }
}

/// Paths whose next ray is to be traced.
pub struct PathQueue {
    /// The rays, world space, unit directions, `tmin` 0, `tmax` infinite.
    pub rays: RayQueue,
    /// Throughput.
    pub beta: Columns3,
    /// Density per steradian with which the ray's direction was drawn; kept only where MIS needs it.
    pub pdf_dir: Vec<f32>,
    /// Cosine between the direction and the normal where it was drawn; kept only where MIS needs it for a constant
    /// environment and the density does not tell it.
    pub cosine: Vec<f32>,
    /// Unit normal where the direction was drawn; kept only where MIS asks the light tree.
    pub normal: Columns3,
    /// Row of what was learned of the lights where the direction was drawn; kept only where MIS asks for it.
    pub row: Vec<u32>,
    /// The path's slot in [`Slots`], and its flags.
    pub slot: Vec<u32>,
    /// Rows in use.
    pub len: usize,
}

/// Hits on surfaces of one material kind, dense.
pub struct SurfaceQueue {
    /// Triangle ids.
    pub triangle: Vec<u32>,
    /// Barycentric weights of the second vertices.
    pub u: Vec<f32>,
    /// Barycentric weights of the third vertices.
    pub v: Vec<f32>,
    /// Unit directions of the rays that hit.
    pub direction: Columns3,
    /// Where the rays found the hits; kept only where a triangle is huge.
    pub position: Columns3,
    /// Throughput.
    pub beta: Columns3,
    /// Slots, without flags.
    pub slot: Vec<u32>,
    /// Rows in use.
    pub len: usize,
}

/// Light samples whose visibility is to be found: a shadow ray carries its finished contribution.
pub struct ShadowQueue {
    /// The segments, world space; directions reach from origin to light point, `tmax` is where they end (infinite:
    /// environment).
    pub rays: RayQueue,
    /// The emitters they aim at (`LightSamples::target`); kept only where there are some.
    pub target: Vec<u32>,
    /// What may block them at their very end ([`crate::tables::lights::targets::Targets::before`]); filled where it matters.
    pub before: Vec<u32>,
    /// Rounding makes some of them miss.
    pub missed: bool,
    /// What the path gains if nothing blocks the segment: throughput, BSDF, cosine, radiance, density and weight included.
    pub contribution: Columns3,
    /// Slots, without flags.
    pub slot: Vec<u32>,
    /// What they tell a training render, by row; empty in other renders.
    pub lessons: Vec<Lesson>,
    /// One bit a ray, eight rays a byte: blocked.
    pub blocked: Vec<u8>,
    /// Closest hits, where cut-outs make it matter what blocks a segment.
    pub hits: HitQueue,
    /// Rows in use.
    pub len: usize,
}

/// Rows of another queue, by index.
pub struct IndexList {
    /// The rows, ascending.
    pub rows: Vec<u32>,
    /// How many.
    pub len: usize,
}

/// The radiance of a path, summed with compensation (Kahan, "Further remarks on reducing truncation errors", CACM 8(1), 1965):
/// what an addition rounds away is added to the next term. In a closed box a path adds up 1e5 and more numbers of one size;
/// a plain sum of f32 is 3e-3 too small there, this one right to the last bit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct RadianceSum {
    /// The sum per channel (the fourth value pads to a vector).
    sum: [f32; 4],
    /// What rounding has taken from it.
    lost: [f32; 4],
}

impl RadianceSum {
    /// Adds to every channel.
    #[inline(always)]
    pub fn add(&mut self, gain: [f32; 4]) {
        for ((sum, lost), gain) in self.sum.iter_mut().zip(&mut self.lost).zip(gain) {
            let term = gain + *lost;
            let next = *sum + term;
            // The exact error of that, whichever of the two is larger (Knuth's two-sum).
            let taken = next - *sum;
            *lost = (*sum - (next - taken)) + (term - taken);
            *sum = next;
        }
    }

    /// The sum.
    #[inline(always)]
    pub fn value(&self) -> [f32; 3] {
        let [r, g, b, _] = self.sum;
        [r, g, b]
    }
}

/// What stays with a path from its camera ray to the film.
pub struct Slots {
    /// Pixel addresses ([`crate::sampler::pixel_address`]).
    pub pixel: Vec<u32>,
    /// Sample numbers.
    pub sample: Vec<u32>,
    /// Radiance gathered so far.
    pub radiance: Vec<RadianceSum>,
    /// Product of the albedos so far over what roulette has let through; kept only where roulette goes by it.
    pub albedo: Vec<f32>,
    /// One over what the path's pixel is expected to show; kept only where roulette goes by it.
    pub inverse_pixel: Vec<f32>,
    /// Slots in use.
    pub len: usize,
}

fn words(len: usize) -> Vec<u32> {
    vec![0; len.next_multiple_of(LANES) + LANES]
}

impl PathQueue {
    /// An empty queue for `capacity` paths, with the columns that are needed.
    pub fn new(capacity: usize, needs: QueueNeeds) -> PathQueue {
        let column =
            |needed: bool| if needed { vec![0.0; capacity.next_multiple_of(LANES) + LANES] } else { Vec::new() };
        PathQueue {
            rays: RayQueue::with_len(capacity),
            beta: Columns3::with_len(capacity),
            pdf_dir: column(needs.pdf),
            cosine: column(needs.cosine),
            normal: Columns3::with_len(if needs.normal { capacity } else { 0 }),
            row: words(if needs.row { capacity } else { 0 }),
            slot: words(capacity),
            len: 0,
        }
    }
}

impl SurfaceQueue {
    /// An empty queue for `capacity` hits, with a column for where they were found if `position`.
    pub fn new(capacity: usize, position: bool) -> SurfaceQueue {
        let column = || vec![0.0; capacity.next_multiple_of(LANES) + LANES];
        SurfaceQueue {
            triangle: words(capacity),
            u: column(),
            v: column(),
            direction: Columns3::with_len(capacity),
            position: Columns3::with_len(if position { capacity } else { 0 }),
            beta: Columns3::with_len(capacity),
            slot: words(capacity),
            len: 0,
        }
    }
}

impl ShadowQueue {
    /// An empty queue for `capacity` segments that end at `tmax` unless they say otherwise, with targets if `aimed`, and for
    /// `hits` of their hits.
    pub fn new(capacity: usize, tmax: f32, aimed: bool, hits: usize) -> ShadowQueue {
        let mut rays = RayQueue::with_len(capacity);
        rays.tmax.fill(tmax);
        ShadowQueue {
            rays,
            target: words(if aimed { capacity } else { 0 }),
            before: Vec::new(),
            missed: false,
            contribution: Columns3::with_len(capacity),
            slot: words(capacity),
            lessons: Vec::new(),
            blocked: Vec::new(),
            hits: HitQueue::with_len(hits),
            len: 0,
        }
    }
}

impl IndexList {
    /// An empty list for `capacity` rows.
    pub fn new(capacity: usize) -> IndexList {
        IndexList { rows: words(capacity), len: 0 }
    }
}

impl Slots {
    /// Room for `capacity` paths, with what is needed of each.
    pub fn new(capacity: usize, needs: QueueNeeds) -> Slots {
        let len = capacity.next_multiple_of(LANES) + LANES;
        let column = |needed: bool| if needed { vec![1.0; len] } else { Vec::new() };
        Slots {
            pixel: words(capacity),
            sample: words(capacity),
            radiance: vec![RadianceSum::default(); len],
            albedo: column(needs.albedo),
            inverse_pixel: column(needs.inverse_pixel),
            len: 0,
        }
    }
}

/// Which queues a plan needs; the others hold no memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct QueueNeeds {
    /// Densities of directions.
    pub pdf: bool,
    /// Cosines of directions.
    pub cosine: bool,
    /// Normals where directions were drawn.
    pub normal: bool,
    /// Rows of what was learned of the lights.
    pub row: bool,
    /// Products of albedos.
    pub albedo: bool,
    /// What pixels are expected to show.
    pub inverse_pixel: bool,
    /// Rays that left the scene.
    pub misses: bool,
    /// Hits on emitters.
    pub emitters: bool,
    /// Hits on surfaces, by material kind.
    pub surfaces: PerKind<bool>,
    /// Shadow rays.
    pub shadow: bool,
    /// What shadow rays aim at.
    pub targets: bool,
    /// Where hits were found.
    pub positions: bool,
    /// Rays that pass cut-outs.
    pub alpha_masks: bool,
}

/// Everything one thread owns while it renders: the queues of one tile.
pub struct TileState {
    /// Rays to be traced now.
    pub paths: PathQueue,
    /// Rays to be traced after this bounce.
    pub next: PathQueue,
    /// Closest hits of [`TileState::paths`], row by row.
    pub hits: HitQueue,
    /// Rows of `paths` that hit nothing.
    pub misses: IndexList,
    /// Rows of `paths` that hit an emitter.
    pub emitters: IndexList,
    /// Rows of the rays just traced that have hit what is cut out.
    pub passing: IndexList,
    /// Hits on surfaces, by material kind.
    pub surfaces: PerKind<SurfaceQueue>,
    /// Shadow rays of this bounce.
    pub shadow: ShadowQueue,
    /// What light samples were worth, if this is a training render.
    pub records: Option<LightRecords>,
    /// Which cells see each other, if this is a training render.
    pub sightings: Option<VisibilityRecords>,
    /// What directions have found, if this is a training render.
    pub steps: Option<StepRecords>,
    /// What camera rays have found, by slot, if this is a pass for layers.
    pub first_hits: Vec<FirstHit>,
    /// The paths of the tile.
    pub slots: Slots,
    /// Working memory of the traversal.
    pub scratch: crate::bvh::Scratch,
}

impl TileState {
    /// Queues for `capacity` paths, as far as they are needed.
    pub fn new(capacity: usize, needs: QueueNeeds, shadow_tmax: f32) -> TileState {
        let size = |needed: bool| if needed { capacity } else { 0 };
        TileState {
            paths: PathQueue::new(capacity, needs),
            next: PathQueue::new(capacity, needs),
            hits: HitQueue::with_len(capacity),
            misses: IndexList::new(size(needs.misses)),
            emitters: IndexList::new(size(needs.emitters)),
            passing: IndexList::new(size(needs.alpha_masks)),
            surfaces: PerKind::new(|kind| SurfaceQueue::new(size(needs.surfaces[kind]), needs.positions)),
            shadow: ShadowQueue::new(
                size(needs.shadow),
                shadow_tmax,
                needs.targets,
                size(needs.shadow && needs.alpha_masks),
            ),
            records: None,
            sightings: None,
            steps: None,
            first_hits: Vec::new(),
            slots: Slots::new(capacity, needs),
            scratch: Default::default(),
        }
    }
}
