//! Where to split a set of triangles in two, by the surface area heuristic (Wald 2007, "On fast Construction of SAH-based Bounding
//! Volume Hierarchies").
//!
//! One pass puts every triangle into a bin along each of the three axes; the boxes of both sides of every border are unions of bins
//! from the left and from the right. A second pass moves the triangles into another buffer and finds the bounds of their centres on
//! both sides, so that nothing has to be looked at a third time. Sets of up to eight are sorted along one axis instead.

use crate::bvh::prims::{Area, Known, PrimBox, centre, nothing, swap_halves};
use crate::bvh::threads;
use crate::lanes::{F32x8, LANES, Mask8, U32x8};

/// Bins along an axis; 8, 16 and 32 gave trees of the same quality.
const BINS: usize = 16;
/// Of sets of up to [`FEW`] triangles.
const FEW_BINS: usize = 8;
const FEW: usize = 32;
/// Triangles of a large set that a thread works on at a time.
const CHUNK: usize = 1 << 13;

/// Triangles on the left, and what is known of both sides.
pub(super) type Sides = (usize, [Known; 2]);

/// The way from centres to bins.
#[derive(Clone, Copy)]
struct Grid {
    low: F32x8,
    scale: F32x8,
}

impl Grid {
    /// Bins over the bounds of centres; an axis along which no centres differ, or by more or less than f32 can divide, has only one.
    #[inline(always)]
    fn new(centres: F32x8, bins: usize) -> Self {
        let size = -swap_halves(centres) - centres;
        // A little below the number of bins, so that the highest centre falls into the last.
        let scale = F32x8::splat(bins as f32 * 0.9999) / size;
        let fine = scale.lt(F32x8::splat(f32::INFINITY)) & size.gt(F32x8::ZERO) & Mask8::first(3);
        Self { low: fine.select(centres, F32x8::ZERO), scale: fine.select(scale, F32x8::ZERO) }
    }
    /// Where a centre lies, in bins; what is no number lies in the last bin, `top`.
    #[inline(always)]
    fn place(&self, centre: F32x8, top: F32x8) -> F32x8 {
        ((centre - self.low) * self.scale).min(top)
    }
}

/// A border between bins.
#[derive(Clone, Copy)]
struct Border {
    axis: usize,
    bin: usize,
    left: usize,
    left_box: F32x8,
    right_box: F32x8,
}

/// The boxes and numbers of triangles in `N` bins along each axis.
struct Bins<const N: usize> {
    boxes: [[F32x8; N]; 3],
    counts: [[u32; N]; 3],
}

impl<const N: usize> Bins<N> {
    #[inline(always)]
    fn of(prims: &[PrimBox], grid: &Grid) -> Self {
        let top = F32x8::splat((N - 1) as f32);
        let mut bins = Self { boxes: [[nothing(); N]; 3], counts: [[0; N]; 3] };
        for prim in prims {
            let lanes = prim.lanes();
            let at = U32x8::from_f32(grid.place(centre(lanes), top)).to_array();
            for ((boxes, counts), at) in bins.boxes.iter_mut().zip(&mut bins.counts).zip(at) {
                // No bin is beyond N - 1; this says so to the compiler.
                let bin = at as usize & (N - 1);
                boxes[bin] = boxes[bin].min(lanes);
                counts[bin] += 1;
            }
        }
        bins
    }
    fn union(mut self, other: &Self) -> Self {
        for (own, other) in self.boxes.iter_mut().flatten().zip(other.boxes.iter().flatten()) {
            *own = own.min(*other);
        }
        for (own, other) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            *own += other;
        }
        self
    }

    /// The border that costs least; nothing if no border separates the `total` triangles, or no area is a number.
    #[inline(always)]
    fn best_border(&self, total: usize, area: Area) -> Option<Border> {
        let all = F32x8::splat(total as f32);
        let (mut best, mut code) = (nothing(), U32x8::ZERO);
        let (mut left_boxes, mut right_boxes) = ([[nothing(); N]; 3], [[nothing(); N]; 3]);
        let mut left_counts = [[0f32; N]; 3];
        for axis in 0..3 {
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            let (left, right, before) = (&mut left_boxes[axis], &mut right_boxes[axis], &mut left_counts[axis]);
            let mut count = 0;
            for bin in 1..N {
                left[bin] = left[bin - 1].min(boxes[bin - 1]);
                count += counts[bin - 1];
                before[bin] = count as f32;
            }
            right[N - 1] = boxes[N - 1];
            for bin in (1..N - 1).rev() {
                right[bin] = right[bin + 1].min(boxes[bin]);
            }
            for first in (0..N).step_by(LANES) {
                let eight = |of: &[F32x8; N]| -> [F32x8; LANES] { std::array::from_fn(|i| of[first + i]) };
                let on_left = F32x8::load(before, first);
                // Not below the best, being NaN, where a side is empty.
                let cost = area.eight(eight(left)) * on_left + area.eight(eight(right)) * (all - on_left);
                let less = cost.lt(best);
                best = less.select(cost, best);
                code = less.select_u32(U32x8::splat((axis * N + first) as u32) + U32x8::lane_numbers(), code);
            }
        }
        let least = best.min_of_lanes();
        if least == f32::INFINITY {
            return None;
        }
        let lane = best.eq(F32x8::splat(least)).bits().trailing_zeros() as usize;
        let code = code.to_array()[lane] as usize;
        let (axis, bin) = (code / N, code % N);
        // Exact: a count of more than 2^24 is rounded in `left_counts`.
        let left = self.counts[axis][..bin].iter().sum::<u32>() as usize;
        let (left_box, right_box) = (left_boxes[axis][bin], right_boxes[axis][bin]);
        (0 < left && left < total).then_some(Border { axis, bin, left, left_box, right_box })
    }
}

/// Splits at least two triangles; they end up in `to`, those on the left first.
#[inline(always)]
pub(super) fn split(from: &[PrimBox], to: &mut [PrimBox], known: &Known, area: Area) -> Sides {
    if from.len() <= LANES {
        split_eight(from, to, known, area)
    } else if from.len() <= FEW {
        split_by_bins::<FEW_BINS>(from, to, known, area)
    } else {
        split_by_bins::<BINS>(from, to, known, area)
    }
}

#[inline(always)]
fn split_by_bins<const N: usize>(from: &[PrimBox], to: &mut [PrimBox], known: &Known, area: Area) -> Sides {
    let grid = Grid::new(known.centres, N);
    match Bins::<N>::of(from, &grid).best_border(from.len(), area) {
        None => halve(from, to),
        Some(border) => {
            let [left, right] = partition(from, to, &grid, &border, N);
            (border.left, sides(&border, left, right))
        }
    }
}

fn sides(border: &Border, left: F32x8, right: F32x8) -> [Known; 2] {
    [Known { bounds: border.left_box, centres: left }, Known { bounds: border.right_box, centres: right }]
}

/// Cuts in the middle, as they come: what no border separates, and what has become too deep.
pub(super) fn halve(from: &[PrimBox], to: &mut [PrimBox]) -> Sides {
    to.copy_from_slice(from);
    let half = from.len() / 2;
    (half, [Known::of(&from[..half]), Known::of(&from[half..])])
}

/// One lane of a grid, for all lanes of a centre.
struct Cut {
    axis: U32x8,
    low: F32x8,
    scale: F32x8,
    top: F32x8,
    border: F32x8,
}

impl Cut {
    #[inline(always)]
    fn new(grid: &Grid, border: &Border, bins: usize) -> Self {
        let axis = U32x8::splat(border.axis as u32);
        Self {
            axis,
            low: grid.low.permute(axis),
            scale: grid.scale.permute(axis),
            top: F32x8::splat((bins - 1) as f32),
            border: F32x8::splat(border.bin as f32),
        }
    }
    /// All lanes, if the centre lies in a bin on the left.
    #[inline(always)]
    fn is_left(&self, centre: F32x8) -> Mask8 {
        ((centre.permute(self.axis) - self.low) * self.scale).min(self.top).lt(self.border)
    }
}

/// Moves what lies left of a border to the front of `to`, the rest behind it, both in their order, without a branch; the bounds of
/// the centres on both sides. A function of its own: inlined, the bounds are
/// spilled from registers.
#[inline(never)]
fn partition(from: &[PrimBox], to: &mut [PrimBox], grid: &Grid, border: &Border, bins: usize) -> [F32x8; 2] {
    let cut = Cut::new(grid, border, bins);
    assert_eq!(from.len(), to.len());
    let (mut left, mut right) = (0, border.left);
    let [mut left_centres, mut right_centres] = [nothing(); 2];
    for prim in from {
        let centre = centre(prim.lanes());
        let is_left = cut.is_left(centre);
        left_centres = left_centres.min(is_left.select(centre, nothing()));
        right_centres = right_centres.min(is_left.select(nothing(), centre));
        let side = is_left.bits() as usize & 1;
        to[if side != 0 { left } else { right }] = *prim;
        left += side;
        right += 1 - side;
    }
    debug_assert_eq!((left, right), (border.left, from.len()));
    [left_centres, right_centres]
}

/// [`split`] of a large set by several threads: the same split and the same order.
pub(super) fn split_shared(from: &[PrimBox], to: &mut [PrimBox], known: &Known, area: Area, threads: usize) -> Sides {
    let grid = Grid::new(known.centres, BINS);
    let chunks: Vec<&[PrimBox]> = from.chunks(CHUNK).collect();
    let bins = threads::map(threads, chunks.clone(), |chunk| Bins::<BINS>::of(chunk, &grid));
    let on_left =
        |bins: &Bins<BINS>, border: &Border| bins.counts[border.axis][..border.bin].iter().sum::<u32>() as usize;
    let mut parts = bins.iter();
    let first = parts.next().map(|first| Bins { boxes: first.boxes, counts: first.counts });
    let all = first.map(|first| parts.fold(first, Bins::union));
    let Some(border) = all.and_then(|all| all.best_border(from.len(), area)) else { return halve(from, to) };
    let lefts: Vec<usize> = bins.iter().map(|bins| on_left(bins, &border)).collect();
    let rights: Vec<usize> = chunks.iter().zip(&lefts).map(|(chunk, left)| chunk.len() - left).collect();
    let (left, right) = to.split_at_mut(border.left);
    let targets = threads::cut(left, lefts).into_iter().zip(threads::cut(right, rights));
    let cut = Cut::new(&grid, &border, BINS);
    let work = chunks.into_iter().zip(targets).collect();
    let centres = threads::map(threads, work, |(chunk, (left, right))| partition_chunk(chunk, left, right, &cut));
    let [left, right] = centres.into_iter().fold([nothing(); 2], |[a, b], [c, d]| [a.min(c), b.min(d)]);
    (border.left, sides(&border, left, right))
}

/// [`partition`] into two slices.
#[inline(never)]
fn partition_chunk(from: &[PrimBox], left: &mut [PrimBox], right: &mut [PrimBox], cut: &Cut) -> [F32x8; 2] {
    let (mut left, mut right) = (left.iter_mut(), right.iter_mut());
    let [mut left_centres, mut right_centres] = [nothing(); 2];
    for prim in from {
        let centre = centre(prim.lanes());
        let row = if cut.is_left(centre).bits() & 1 != 0 {
            left_centres = left_centres.min(centre);
            left.next()
        } else {
            right_centres = right_centres.min(centre);
            right.next()
        };
        *row.expect("binned alike") = *prim;
    }
    [left_centres, right_centres]
}

/// Splits up to eight triangles, two at least: the best place in their order along the axis along which centres differ most.
#[inline(always)]
fn split_eight(from: &[PrimBox], to: &mut [PrimBox], known: &Known, area: Area) -> Sides {
    let count = from.len();
    assert!((2..=LANES).contains(&count) && to.len() == count);
    let c = known.centres.to_array();
    let [x, y, z] = [-c[4] - c[0], -c[5] - c[1], -c[6] - c[2]];
    let axis = if x >= y && x >= z { 0 } else { if y >= z { 1 } else { 2 } };
    let mut keys = [f32::INFINITY; LANES];
    for (key, prim) in keys.iter_mut().zip(from) {
        *key = prim.centre(axis);
    }
    let all = F32x8::from_array(keys);
    let mut sorted = [nothing(); LANES];
    for (i, prim) in from.iter().enumerate() {
        // Its place: what is less comes before it, and what is equal and stands before it.
        let key = F32x8::splat(keys[i]);
        let before = all.lt(key).bits() | all.eq(key).bits() & ((1u32 << i) - 1) as u8;
        let place = before.count_ones() as usize & (LANES - 1);
        sorted[place] = prim.lanes();
        to[place.min(count - 1)] = *prim;
    }
    let (mut lefts, mut rights) = ([nothing(); LANES], [nothing(); LANES]);
    for i in 1..count {
        lefts[i] = lefts[i - 1].min(sorted[i - 1]);
    }
    rights[count - 1] = sorted[count - 1];
    for i in (1..count - 1).rev() {
        rights[i] = rights[i + 1].min(sorted[i]);
    }
    let on_left = U32x8::lane_numbers().to_f32();
    let cost = area.eight(lefts) * on_left + area.eight(rights) * (F32x8::splat(count as f32) - on_left);
    // Lane 0 and those behind the last triangle have an empty side.
    let cost = (Mask8::first(count) & cost.lt(nothing())).select(cost, nothing());
    let least = cost.min_of_lanes();
    let left = match least < f32::INFINITY {
        true => (cost.eq(F32x8::splat(least)).bits().trailing_zeros() as usize).clamp(1, count - 1),
        false => count / 2,
    };
    let centres = |of: &[F32x8]| of.iter().fold(nothing(), |all, &lanes| all.min(centre(lanes)));
    let sides = [
        Known { bounds: lefts[left], centres: centres(&sorted[..left]) },
        Known { bounds: rights[left], centres: centres(&sorted[left..count]) },
    ];
    (left, sides)
}
