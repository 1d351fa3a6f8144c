//! What was learned of which cells see each other: with which probability a shadow ray between two of them is traced at all.
//! Plain data, frozen while anything is rendered with it; [`crate::learn::visibility`] says where the numbers come from.
//!
//! Few cells hold emitters, so those are numbered, and the table has a byte for each cell and each of these numbers.

use crate::tables::lights::learned::Grid;
use crate::tables::prepared::PreparedScene;

/// Of [`Visibility::numbers`]: no emitter reaches into the cell. Nothing is known of pairs with this number.
pub const NO_EMITTER: u32 = 0;
/// Steps of probabilities: what a byte can say, 1 to 256 of them, is exact in f32, and so is one over it times the steps.
pub const STEPS: f32 = 256.0;

/// The tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Visibility {
    /// Where cells are.
    pub grid: Grid,
    /// Per cell, its number among those that emitters reach into, from 1 on in the order of the cells, or [`NO_EMITTER`].
    pub numbers: Vec<u32>,
    /// How many numbers there are, [`NO_EMITTER`] included.
    pub number_count: u32,
    /// Per pair ([`Visibility::pair`]), the probability with which shadow rays are traced, in [`STEPS`], less one.
    pub survival: Vec<u8>,
}

impl Visibility {
    /// Tables that know nothing: every shadow ray is traced.
    pub fn new(scene: &PreparedScene) -> Visibility {
        let grid = Grid::new(scene);
        let mut numbers = vec![NO_EMITTER; grid.cells() as usize];
        for emitter in &scene.emitters {
            let vertices = scene.triangles[emitter.triangle as usize].vertices;
            let bound = |pick: fn(f32, f32) -> f32| {
                grid.axes(std::array::from_fn(|axis| {
                    vertices.map(|vertex| vertex[axis]).into_iter().fold(vertices[0][axis], pick)
                }))
            };
            let (low, high) = (bound(f32::min), bound(f32::max));
            for z in low[2]..=high[2] {
                for y in low[1]..=high[1] {
                    (low[0]..=high[0]).for_each(|x| numbers[grid.cell([x, y, z]) as usize] = 1);
                }
            }
        }
        for light in scene.delta_lights.records.iter().filter(|light| light.distant == 0) {
            numbers[grid.cell(grid.axes(light.position)) as usize] = 1;
        }
        let mut last = NO_EMITTER;
        for number in numbers.iter_mut().filter(|number| **number != NO_EMITTER) {
            last += 1;
            *number = last;
        }
        let number_count = last + 1;
        Visibility { grid, numbers, number_count, survival: vec![u8::MAX; (grid.cells() * number_count) as usize] }
    }

    /// The pair of the cells of a receiver and of a point on a light. A point that rounding has put beside the cells of its
    /// light makes a pair of which nothing is known.
    #[inline]
    pub fn pair(&self, receiver: u32, light: u32) -> u32 {
        receiver * self.number_count + self.numbers[light as usize]
    }

    /// How many [`STEPS`] are the probability with which the shadow rays of a pair are traced.
    #[inline]
    pub fn steps(&self, pair: u32) -> u32 {
        u32::from(self.survival[pair as usize]) + 1
    }

    /// The tables and their sizes in bytes.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        vec![("cells of lights", size_of_val(&self.numbers[..])), ("visibility of cells", self.survival.len())]
    }
}
