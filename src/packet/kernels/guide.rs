//! Guided directions, eight hits at a time: looking up what was learned, densities, and drawing.

use super::here;
use crate::learn::guide::records::Step;
use crate::learn::guide::steps::StepRecords;
use crate::tables::guide::{BINS, CELL_BITS, CODES, GUIDED, Guide, KEPT, LUMINANCE, Lobes, PART, PLACES, SIDE, WHOLE};
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8, Vec3x8, count_at_most, inlined};

/// Where eight hits look up what was learned.
pub struct Places<'a> {
    guide: &'a Guide,
    /// Places ([`Guide::leaves`]).
    place: U32x8,
    /// Leaves.
    pub leaf: U32x8,
    /// Lanes whose directions are guided.
    pub guided: Mask8,
}

impl Places<'_> {
    /// Those of hits at `origin` on surfaces of these unit shading normals.
    #[inline(always)]
    pub fn find(guide: &Guide, origin: Vec3x8, normal: Vec3x8) -> Places<'_> {
        let place = places(guide, origin, normal);
        let entries = place.to_array().map(|place| u32::from(guide.leaves[place as usize & (PLACES - 1)]));
        let entries = U32x8::from_array(entries);
        let flag = U32x8::splat(u32::from(GUIDED));
        let leaf = entries & U32x8::splat(u32::from(GUIDED) - 1);
        Places { guide, place, leaf, guided: (entries & flag).eq(flag) }
    }

    /// The densities, per steradian, with which unit directions are drawn here that a cosine would draw with `pdf_cosine`; and
    /// what the guide's own are, where any lane asks: where one is guided, or always if `all`.
    #[inline(always)]
    pub fn pdf_dir(&self, direction: Vec3x8, pdf_cosine: F32x8, all: bool) -> (F32x8, F32x8) {
        if !all && !self.guided.any() {
            return (pdf_cosine, F32x8::ZERO);
        }
        let pdf_guide = self.guide_pdf_dir(direction);
        let mixture = F32x8::splat(PART) * pdf_guide + F32x8::splat(1.0 - PART) * pdf_cosine;
        (self.guided.select(mixture, pdf_cosine), pdf_guide)
    }

    /// The guide's own densities.
    #[inline(always)]
    fn guide_pdf_dir(&self, direction: Vec3x8) -> F32x8 {
        let (square, norm) = to_square(direction);
        let at = self.leaf << BINS.ilog2() | bin(square);
        F32x8::gather(&self.guide.densities, at) / (norm * norm * norm)
    }

    /// Unit directions by the guide's own densities for the lanes of `lanes`; `u` places them.
    #[inline(always)]
    pub fn sample(&self, lanes: Mask8, u: [F32x8; 2]) -> Vec3x8 {
        let at: [F32x8; 2] = u.each(
            #[inline(always)]
            |u| u * F32x8::splat(WHOLE),
        );
        let whole = at.each(
            #[inline(always)]
            |at| U32x8::from_f32(at).to_array(),
        );
        let leaf = self.leaf.to_array();
        let (mut row, mut column) = ([[0; LANES]; 3], [[0; LANES]; 3]);
        let mut rest = lanes.bits();
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let Lobes { rows, columns } = &self.guide.lobes[leaf[lane] as usize];
            [row[0][lane], row[1][lane], row[2][lane]] = find(rows, whole[0][lane]);
            let columns = &columns[row[0][lane] as usize % SIDE];
            [column[0][lane], column[1][lane], column[2][lane]] = find(columns, whole[1][lane]);
        }
        let along = |found: &[[u32; LANES]; 3], at: F32x8| {
            let [bin, start, share] = (*found).each(
                #[inline(always)]
                |found| U32x8::from_array(found).to_f32(),
            );
            (bin + (at - start) / share) * F32x8::splat(1.0 / SIDE as f32)
        };
        from_square([along(&column, at[1]), along(&row, at[0])])
    }

    /// What the paths are expected to bring to their pixels, over what these show, twice: what survives is to bring half as
    /// much. `throughput`: times albedo; `inverse`: one over what the pixels show.
    #[inline(always)]
    pub fn expected(&self, throughput: Vec3x8, inverse: F32x8) -> F32x8 {
        let reflected = F32x8::gather(&self.guide.reflected, self.leaf);
        F32x8::splat(KEPT) * luminances(throughput) * reflected * inverse
    }
}

/// Luminances.
#[inline(always)]
fn luminances(v: Vec3x8) -> F32x8 {
    let [r, g, b] = LUMINANCE.each(F32x8::splat);
    v.x * r + v.y * g + v.z * b
}

/// Indices into [`Guide::leaves`].
#[inline(always)]
fn places(guide: &Guide, origin: Vec3x8, normal: Vec3x8) -> U32x8 {
    let last = F32x8::splat(((1u32 << CELL_BITS) - 1) as f32);
    let axis = inlined(
        #[inline(always)]
        |x: F32x8, i: usize| {
            let along = (x - F32x8::splat(guide.low[i])) * F32x8::splat(guide.scale);
            // Idle lanes may hold anything.
            spread(U32x8::from_f32(along.max(F32x8::ZERO).min(last)))
        },
    );
    let code = axis(origin.x, 0) | axis(origin.y, 1) << 1 | axis(origin.z, 2) << 2;
    code + face(normal) * U32x8::splat(CODES as u32)
}

/// Two times the dominant axis, plus 1 if it points down.
#[inline(always)]
fn face(normal: Vec3x8) -> U32x8 {
    let size = normal.abs();
    let along_x = size.x.ge(size.y) & size.x.ge(size.z);
    let along_y = size.y.ge(size.z).and_not(along_x);
    let largest = along_x.select(normal.x, along_y.select(normal.y, normal.z));
    let axis = along_x.select_u32(U32x8::ZERO, along_y.select_u32(U32x8::splat(2), U32x8::splat(4)));
    axis + largest.lt(F32x8::ZERO).select_u32(U32x8::splat(1), U32x8::ZERO)
}

/// Two idle bits above each of the lowest ten.
#[inline(always)]
fn spread(x: U32x8) -> U32x8 {
    let x = (x | x << 16) & U32x8::splat(0x0300_00ff);
    let x = (x | x << 8) & U32x8::splat(0x0300_f00f);
    let x = (x | x << 4) & U32x8::splat(0x030c_30c3);
    (x | x << 2) & U32x8::splat(0x0924_9249)
}

/// The octahedral map: coordinates in [0, 1], and the sums of the absolute components.
#[inline(always)]
fn to_square(d: Vec3x8) -> ([F32x8; 2], F32x8) {
    let (one, half) = (F32x8::ONE, F32x8::splat(0.5));
    let norm = d.x.abs() + d.y.abs() + d.z.abs();
    let inverse = one / norm;
    let (x, y) = (d.x * inverse, d.y * inverse);
    let [x, y] = folded([x, y], d.z.lt(F32x8::ZERO));
    ([x * half + half, y * half + half], norm)
}

/// Its inverse: unit directions.
#[inline(always)]
fn from_square([u, v]: [F32x8; 2]) -> Vec3x8 {
    let (one, two) = (F32x8::ONE, F32x8::splat(2.0));
    let (x, y) = (two * u - one, two * v - one);
    let z = one - x.abs() - y.abs();
    let [x, y] = folded([x, y], z.lt(F32x8::ZERO));
    let d = Vec3x8::new(x, y, z);
    d.scale(one / d.dot(d).sqrt())
}

/// Mirrors points of the lanes of `below` in the diagonals of their quadrants: the lower half of the octahedron.
#[inline(always)]
fn folded([x, y]: [F32x8; 2], below: Mask8) -> [F32x8; 2] {
    let one = F32x8::ONE;
    [below.select((one - y.abs()).copysign(x), x), below.select((one - x.abs()).copysign(y), y)]
}

/// The bins of points of the square.
#[inline(always)]
fn bin(square: [F32x8; 2]) -> U32x8 {
    let last = F32x8::splat((SIDE - 1) as f32);
    // Idle lanes may hold anything.
    let [column, row] = square.each(
        #[inline(always)]
        |at| U32x8::from_f32((at * F32x8::splat(SIDE as f32)).max(F32x8::ZERO).min(last)),
    );
    row << SIDE.ilog2() | column
}

/// The last entry that begins at or before `whole`; where it begins, and its share.
#[inline(always)]
fn find(starts: &[u16; SIDE], whole: u32) -> [u32; 3] {
    // The first begins at 0: one is found at least.
    let at = count_at_most(starts, whole as u16) as usize - 1;
    let [start, end] = [starts[at % SIDE], starts[(at + 1) % SIDE]];
    [at as u32, u32::from(start), u32::from(end.wrapping_sub(start))]
}

/// What a training render writes down of the directions that eight hits have gone on in.
pub struct Going<'a> {
    /// Where.
    pub places: &'a Places<'a>,
    /// Lanes that drew one.
    pub drawn: Mask8,
    /// Lanes whose direction is above the surface.
    pub above: Mask8,
    /// Lanes that go on.
    pub alive: Mask8,
    /// The paths.
    pub slot: U32x8,
    /// The directions.
    pub direction: Vec3x8,
    /// Their cosines.
    pub cosine: F32x8,
    /// Their densities.
    pub pdf_dir: F32x8,
    /// The guide's own densities.
    pub pdf_guide: F32x8,
    /// Throughputs, roulette included.
    pub throughput: Vec3x8,
}

/// Writes down eight directions.
#[inline(never)]
pub fn note(going: &Going, steps: &mut StepRecords) {
    here::run(
        #[inline(always)]
        || {
            let (place, leaf) = (going.places.place.to_array(), going.places.leaf.to_array());
            let mut lost = going.drawn.and_not(going.above).bits();
            while lost != 0 {
                let lane = lost.trailing_zeros() as usize;
                steps.records.note_lost(place[lane], leaf[lane]);
                lost &= lost - 1;
            }
            let (square, norm) = to_square(going.direction);
            let (bin, norm) = (bin(square).to_array(), norm.to_array());
            let (path, throughput) = (going.slot.to_array(), luminances(going.throughput).to_array());
            let (cosine, pdf_dir) = (going.cosine.to_array(), going.pdf_dir.to_array());
            let pdf_guide = going.pdf_guide.to_array();
            let mut rest = going.alive.bits();
            while rest != 0 {
                let lane = rest.trailing_zeros() as usize;
                rest &= rest - 1;
                steps.push(Step {
                    path: path[lane],
                    place: place[lane],
                    leaf: leaf[lane],
                    bin: bin[lane],
                    norm: norm[lane],
                    cosine: cosine[lane],
                    pdf_dir: pdf_dir[lane],
                    pdf_guide: pdf_guide[lane],
                    throughput: throughput[lane],
                    before: 0.0,
                });
            }
        },
    )
}
