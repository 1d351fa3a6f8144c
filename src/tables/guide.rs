//! What was learned of the directions light comes from at diffuse surfaces, and of how much it is. Plain data, frozen while
//! anything is rendered with it; [`crate::learn::guide`] says where the numbers come from.
//!
//! ```text
//! face of the normal, Morton code of the cell --leaves--> leaf --lobes--> row of bins --> bin of the octahedral map
//!                                                              --reflected--> mean radiance that white surfaces send on
//! ```
//!
//! The map from directions to the square is the octahedral one (Meyer et al., "On Floating-Point Normal Vectors", 2010): it is
//! made of `+ - * /` alone. It keeps areas up to the cube of the sum of the direction's absolute components.

use bytemuck::{Pod, Zeroable};

use crate::tables::lights::learned::{CELLS, Grid};
use crate::tables::prepared::PreparedScene;

/// Bits of a cell's number along each axis: 64 cells along the longest side of the scene.
pub const CELL_BITS: u32 = 6;
/// Cells of the cube about the scene.
pub const CODES: usize = 1 << (3 * CELL_BITS);
/// Dominant axis of the shading normal, and its sign.
pub const FACES: usize = 6;
/// Entries of [`Guide::leaves`]: a power of two, so that a masked index lies in it for certain; those beyond the faces are idle.
pub const PLACES: usize = 8 * CODES;
/// Bins along each side of the octahedral map. (8: 4.8 times less error than without guiding where 16 give 6.9 and 32, at 25 %
/// more time, 6.95.)
pub const SIDE: usize = 16;
/// Bins of the octahedral map.
pub const BINS: usize = SIDE * SIDE;
/// What probabilities of rows and columns are in.
pub const WHOLE: f32 = 65_536.0;
/// The density in the square, as a product of a row's and a column's share, per steradian times the cube of the L1 norm: the
/// square has an area of 4.
pub const DENSITY: f32 = (BINS as f64 / 4.0 / (65_536.0 * 65_536.0)) as f32;
/// The part of the directions that is drawn from what was learned where guiding pays; the others are drawn by the cosine. (0.3
/// to 0.7 are as good.)
pub const PART: f32 = 0.5;
/// Learned roulette keeps paths for certain that are expected to bring one over this of what their pixel shows. (1 is 15 % less
/// efficient in `builtin:rooms`, 2 by 4 %; 4 is as good.)
pub const KEPT: f32 = 3.0;
/// Flag of [`Guide::leaves`]: directions are guided there.
pub const GUIDED: u16 = 1 << 15;
/// Most leaves there may be.
pub const MOST_LEAVES: usize = GUIDED as usize;
/// The luminance of linear Rec.709, for weighing paths.
pub const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Where directions are drawn from in one leaf: where the shares of rows begin, and within each row those of its columns, in
/// 65,536ths. The first entry is always 0, the last at least 1: so the next entry minus this one, wrapping and with the first
/// after the last, is a share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Lobes {
    /// Of the rows.
    pub rows: [u16; SIDE],
    /// By row, of its columns.
    pub columns: [[u16; SIDE]; SIDE],
}

impl Lobes {
    /// All bins alike.
    pub fn uniform() -> Lobes {
        let starts: [u16; SIDE] = std::array::from_fn(|at| (at * (65_536 / SIDE)) as u16);
        Lobes { rows: starts, columns: [starts; SIDE] }
    }

    /// What [`Guide::densities`] holds of them.
    pub fn densities(&self) -> [f32; BINS] {
        let share = |starts: &[u16; SIDE], at: usize| f32::from(starts[(at + 1) % SIDE].wrapping_sub(starts[at]));
        let density = |row, column| share(&self.rows, row) * share(&self.columns[row], column) * DENSITY;
        std::array::from_fn(|bin| density(bin / SIDE, bin % SIDE))
    }
}

/// What the pixels of a film are expected to show, from the training render.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pixels {
    /// Per column of the film, the column of `inverse`.
    pub columns: Vec<u32>,
    /// Per row of the film, where the row of `inverse` begins.
    pub rows: Vec<u32>,
    /// One over the expected luminance, in one over [`PreparedScene::radiance_unit`]; 0: not known.
    pub inverse: Vec<f32>,
}

impl Pixels {
    /// Nothing is known over a grid of so many columns and rows.
    pub fn unknown((columns, rows): (u32, u32)) -> Pixels {
        let mut pixels = Pixels { inverse: vec![0.0; (columns * rows) as usize], ..Pixels::default() };
        pixels.spread((columns, rows), (columns, rows));
        pixels
    }

    /// Lays the grid under a film.
    pub fn spread(&mut self, (columns, rows): (u32, u32), film: (u32, u32)) {
        let scaled = |at: u32, from: u32, to: u32| (u64::from(at) * u64::from(to) / u64::from(from)) as u32;
        self.columns = (0..film.0).map(|x| scaled(x, film.0, columns)).collect();
        self.rows = (0..film.1).map(|y| scaled(y, film.1, rows) * columns).collect();
    }

    /// Where `inverse` has a pixel, by its address ([`crate::sampler::pixel_address`]).
    #[inline]
    pub fn index(&self, pixel: u32) -> usize {
        (self.rows[(pixel >> 16) as usize] + self.columns[(pixel & 0xffff) as usize]) as usize
    }

    /// One over what a pixel is expected to show.
    #[inline]
    pub fn inverse(&self, pixel: u32) -> f32 {
        self.inverse[self.index(pixel)]
    }
}

/// The tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// Where the cube about the scene begins, scene units.
    pub low: [f32; 3],
    /// Cells a scene unit.
    pub scale: f32,
    /// Per face and Morton code (`face << 18 | code`), the leaf, and [`GUIDED`].
    pub leaves: Box<[u16; PLACES]>,
    /// Per leaf, where directions are drawn from.
    pub lobes: Vec<Lobes>,
    /// Per leaf and bin ([`BINS`] each, `row * SIDE + column`), the density in the square that they are drawn with, per steradian
    /// times the cube of the L1 norm: [`Lobes::densities`], since it is asked for more often than directions are drawn.
    pub densities: Vec<f32>,
    /// Per leaf, the mean radiance that a white surface sends on of what a path finds on its way (light samples aside, by their
    /// weights); 0: not known.
    pub reflected: Vec<f32>,
    /// What pixels are expected to show.
    pub pixels: Pixels,
}

impl Guide {
    /// Tables that know nothing, over a grid of pixels of this size.
    pub fn new(scene: &PreparedScene, grid: (u32, u32)) -> Guide {
        let cells = Grid::new(scene);
        let leaves = vec![0; PLACES].into_boxed_slice();
        let mut guide = Guide {
            low: cells.low,
            scale: cells.scale * ((1 << CELL_BITS) / CELLS) as f32,
            leaves: leaves.try_into().unwrap_or_else(|_| unreachable!("as many as there are")),
            lobes: vec![Lobes::uniform(); FACES],
            densities: Lobes::uniform().densities().repeat(FACES),
            reflected: vec![0.0; FACES],
            pixels: Pixels::unknown(grid),
        };
        for face in 0..FACES {
            guide.leaves[face * CODES..(face + 1) * CODES].fill(face as u16);
        }
        guide
    }

    /// The tables and their sizes in bytes.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        vec![
            ("guide leaves by place", size_of_val(&self.leaves[..])),
            ("guide lobes", size_of_val(&self.lobes[..])),
            ("guide densities", size_of_val(&self.densities[..])),
            ("guide radiance", size_of_val(&self.reflected[..])),
            (
                "guide pixels",
                size_of_val(&self.pixels.columns[..])
                    + size_of_val(&self.pixels.rows[..])
                    + size_of_val(&self.pixels.inverse[..]),
            ),
        ]
    }
}
