//! Guided directions: looking up what was learned, densities, and drawing.

use super::bsdf::sample::{BsdfSample, max_element};
use super::warp::{cosine_hemisphere_pdf_dir, sample_cosine_hemisphere, to_world};
use super::{Real, Vec3, vec3};
use crate::tables::guide::{CELL_BITS, DENSITY, GUIDED, Guide, KEPT, LUMINANCE, Lobes, PART, SIDE};
use crate::tables::materials::MaterialRecord;

/// Where a hit looks up what was learned.
#[derive(Clone, Copy)]
pub struct GuidePlace<'a> {
    guide: &'a Guide,
    /// The place ([`Guide::leaves`]).
    pub place: u32,
    /// The leaf.
    pub leaf: u32,
    /// Directions are guided there.
    pub guided: bool,
}

impl<'a> GuidePlace<'a> {
    /// That of a hit at `origin` on a surface of this unit shading normal.
    pub fn find(guide: &'a Guide, origin: Vec3, normal: Vec3) -> GuidePlace<'a> {
        let last = ((1 << CELL_BITS) - 1) as Real;
        let cell = |x: Real, low: f32| {
            let along = (x - low as Real) * guide.scale as Real;
            let along = if along > 0.0 { along } else { 0.0 };
            (if along < last { along } else { last }) as u32
        };
        let cells = [cell(origin.x, guide.low[0]), cell(origin.y, guide.low[1]), cell(origin.z, guide.low[2])];
        let mut place = face(normal);
        for bit in (0..CELL_BITS).rev() {
            for cell in cells.iter().rev() {
                place = place << 1 | (cell >> bit & 1);
            }
        }
        let entry = guide.leaves[place as usize];
        GuidePlace { guide, place, leaf: u32::from(entry & (GUIDED - 1)), guided: entry & GUIDED != 0 }
    }

    /// The density, per steradian, with which a unit direction is drawn here that a cosine would draw with `pdf_cosine`.
    pub fn pdf_dir(&self, direction: Vec3, pdf_cosine: Real) -> Real {
        if !self.guided {
            return pdf_cosine;
        }
        PART as Real * self.guide_pdf_dir(direction) + (1.0 - PART as Real) * pdf_cosine
    }

    /// The guide's own density.
    pub fn guide_pdf_dir(&self, direction: Vec3) -> Real {
        let ([column, row], norm) = bin(direction);
        let Lobes { rows, columns } = &self.guide.lobes[self.leaf as usize];
        let [row_share, column_share] = [share(rows, row) as Real, share(&columns[row], column) as Real];
        row_share * column_share * DENSITY as Real / (norm * norm * norm)
    }

    /// Draws a direction on a diffuse surface, by the guide or by the cosine as `choice` has it; `None` if it leads below.
    pub fn sample(&self, material: &MaterialRecord, n: Vec3, u: [Real; 2], choice: Real) -> Option<BsdfSample> {
        let direction = match self.guided && choice < PART as Real {
            true => self.draw(u),
            false => to_world(sample_cosine_hemisphere(u), n),
        };
        let cosine = n.dot(direction);
        if !(cosine > 0.0) {
            return None;
        }
        let pdf_cosine = cosine_hemisphere_pdf_dir(cosine);
        let pdf_dir = self.pdf_dir(direction, pdf_cosine);
        let color = vec3(material.color);
        let albedo = max_element(color);
        Some(BsdfSample { direction, weight: color * (pdf_cosine / pdf_dir), pdf_dir, cosine, albedo, delta: false })
    }

    /// A unit direction by the guide's own density.
    fn draw(&self, u: [Real; 2]) -> Vec3 {
        let Lobes { rows, columns } = &self.guide.lobes[self.leaf as usize];
        let (row, v) = find(rows, u[0]);
        let (column, u) = find(&columns[row], u[1]);
        let along = |bin: usize, part: Real| (bin as Real + part) * (1.0 / SIDE as Real);
        from_square([along(column, u), along(row, v)])
    }

    /// [`KEPT`] times what the path is expected to bring to its pixel, over what that shows.
    /// `throughput`: times albedo; `inverse`: one over what the pixel shows.
    pub fn expected(&self, throughput: Vec3, inverse: Real) -> Real {
        KEPT as Real * luminance(throughput) * self.guide.reflected[self.leaf as usize] as Real * inverse
    }
}

/// The luminance of a radiance.
pub fn luminance(v: Vec3) -> Real {
    let [r, g, b] = LUMINANCE.map(|c| c as Real);
    v.x * r + v.y * g + v.z * b
}

/// Two times the dominant axis of a normal, plus 1 if it points down.
fn face(n: Vec3) -> u32 {
    let size = n.abs();
    let (axis, largest) = if size.x >= size.y && size.x >= size.z {
        (0, n.x)
    } else if size.y >= size.z {
        (2, n.y)
    } else {
        (4, n.z)
    };
    axis + u32::from(largest < 0.0)
}

/// Column and row of a unit direction's bin in the octahedral map, and the sum of its absolute components.
pub fn bin(d: Vec3) -> ([usize; 2], Real) {
    let norm = d.x.abs() + d.y.abs() + d.z.abs();
    let inverse = 1.0 / norm;
    let [x, y] = folded([d.x * inverse, d.y * inverse], d.z < 0.0);
    let bin = |x: Real| {
        let along = (x * 0.5 + 0.5) * SIDE as Real;
        if along > 0.0 { (along as usize).min(SIDE - 1) } else { 0 }
    };
    ([bin(x), bin(y)], norm)
}

/// The unit direction at coordinates of the map in [0, 1].
fn from_square([u, v]: [Real; 2]) -> Vec3 {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let [x, y] = folded([x, y], z < 0.0);
    let d = Vec3::new(x, y, z);
    d * (1.0 / d.dot(d).sqrt())
}

/// The lower half of the octahedron lies outside the diagonals of the square's quadrants.
fn folded([x, y]: [Real; 2], below: bool) -> [Real; 2] {
    if below { [Real::copysign(1.0 - y.abs(), x), Real::copysign(1.0 - x.abs(), y)] } else { [x, y] }
}

/// The share of entry `at`, in 65,536ths.
fn share(starts: &[u16; SIDE], at: usize) -> u16 {
    starts[(at + 1) % SIDE].wrapping_sub(starts[at])
}

/// The entry that `u` falls into, and where in it.
fn find(starts: &[u16; SIDE], u: Real) -> (usize, Real) {
    let along = u * 65_536.0;
    let after = starts.partition_point(|&start| start as Real <= along);
    let at = after - 1;
    (at, (along - starts[at] as Real) / share(starts, at) as Real)
}
