//! Patches of an environment map, and what was learned of them: which parts of the sky are worth sampling from where. Through
//! a window a place sees a part of the sky, and which part depends on the place; a map's own distribution knows nothing of it.
//!
//! ```text
//! (row of a hit, word) --shares--> patch --alias table of the patch--> texel
//! ```
//!
//! A patch is a block of texels of about 4 pi / 128 steradians, the same in all places. How samples are spread within it is the
//! map's own [`Distribution`], so a texel's density is that of the map times a ratio that only its patch decides.

use std::sync::Arc;

use crate::tables::lights::alias::{AliasColumn, alias_table, whole_shares};
use crate::tables::lights::environment::{Distribution, EnvironmentMap};

/// Bands of equal height from the top (+y) down.
const BANDS: usize = 8;
/// Parts of a band, of equal azimuth.
const SECTORS: usize = 16;
/// Patches of a map.
pub const PATCHES: usize = BANDS * SECTORS;
/// What the shares of a row sum to.
pub const SHARES: u16 = 1 << 15;

/// A map cut into patches: which texel is in which, and how samples are spread within each.
#[derive(Debug, PartialEq)]
pub struct Patches {
    /// Per texel, its patch.
    of_texel: Vec<u8>,
    /// Where a patch begins in `columns`, and where the last one ends.
    first: [u32; PATCHES + 1],
    /// Patch by patch, the alias table over those of its texels that have a density.
    columns: Vec<TexelColumn>,
    /// The probability of each patch under the map's own distribution.
    pub probability: [f64; PATCHES],
}

/// A column of an alias table over texels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct TexelColumn {
    /// As [`AliasColumn::threshold`].
    threshold: u32,
    /// The texel that is chosen below it.
    own: u32,
    /// The texel that is chosen else.
    alias: u32,
}

impl Patches {
    /// The patches of `map`, whose samples are spread as `distribution` says.
    pub fn new(map: &EnvironmentMap, distribution: &Distribution) -> Patches {
        let (width, height) = (map.width as usize, map.height as usize);
        let band = |row: usize| {
            let y = libm::cos((row as f64 + 0.5) / height as f64 * std::f64::consts::PI);
            ((0.5 * (1.0 - y) * BANDS as f64) as usize).min(BANDS - 1)
        };
        let sector = |column: usize| column * SECTORS / width;
        let bands: Vec<usize> = (0..height).map(band).collect();
        let of_texel: Vec<u8> =
            (0..width * height).map(|i| (bands[i / width] * SECTORS + sector(i % width)) as u8).collect();
        // Per patch, texels and their weights.
        let mut members: Vec<(Vec<u32>, Vec<f64>)> = vec![Default::default(); PATCHES];
        for (texel, &patch) in of_texel.iter().enumerate() {
            let rest = map.texels[texel].pdf_dir - distribution.floor;
            if rest > 0.0 {
                let (texels, weights) = &mut members[patch as usize];
                texels.push(texel as u32);
                weights.push(f64::from(rest) * map.solid_angle(texel));
            }
        }
        let totals: Vec<f64> = members.iter().map(|(_, weights)| weights.iter().sum()).collect();
        let total: f64 = totals.iter().sum();
        let mut first = [0; PATCHES + 1];
        let mut columns = Vec::new();
        for (patch, (texels, weights)) in members.iter().enumerate() {
            let column = |(AliasColumn { threshold, alias }, &own)| TexelColumn {
                threshold,
                own,
                alias: texels[alias as usize],
            };
            columns.extend(alias_table(whole_shares(weights, totals[patch])).into_iter().zip(texels).map(column));
            first[patch + 1] = columns.len() as u32;
        }
        Patches { of_texel, first, columns, probability: std::array::from_fn(|patch| totals[patch] / total) }
    }

    /// The texel of a patch at a place in [0, 1).
    #[inline]
    fn texel(&self, patch: usize, place: f64) -> u32 {
        let first = self.first[patch];
        let count = self.first[patch + 1] - first;
        let x = place * f64::from(count);
        let column = (x as u32).min(count - 1);
        let low = ((x - f64::from(column)) * 4_294_967_296.0) as u32;
        let TexelColumn { threshold, own, alias } = self.columns[(first + column) as usize];
        if low < threshold { own } else { alias }
    }

    /// Shares of [`SHARES`] in proportion to `weights`. What has a probability has a share.
    pub fn shares(&self, weights: &[f64; PATCHES]) -> [u16; PATCHES] {
        let lit: [bool; PATCHES] = self.probability.map(|probability| probability > 0.0);
        let free = f64::from(SHARES) - lit.iter().filter(|lit| **lit).count() as f64;
        let total: f64 = (0..PATCHES).filter(|&patch| lit[patch]).map(|patch| weights[patch]).sum();
        let share = |patch: usize| if lit[patch] { 1 + (weights[patch] / total * free) as u16 } else { 0 };
        let mut shares: [u16; PATCHES] = std::array::from_fn(share);
        // What rounding leaves falls to the largest, where it is least of all.
        if let Some(largest) = (0..PATCHES).max_by_key(|&patch| shares[patch]) {
            shares[largest] += SHARES - shares.iter().sum::<u16>();
        }
        shares
    }
}

/// What was learned of the patches.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedPatches {
    /// The patches.
    pub patches: Arc<Patches>,
    /// Per row, where the share of each patch begins, and [`SHARES`]. Row 0 has the probabilities of the map itself.
    starts: Vec<u16>,
    /// What a share is multiplied by to give the patch's probability over that of the map.
    scale: [f32; PATCHES],
    /// What a sample may be worth: the radiance that a white diffuse surface sends on under an open sky, summed over the
    /// channels.
    pub unit: f32,
}

impl LearnedPatches {
    /// Row 0 only. `mean_radiance`: as [`EnvironmentMap::mean_radiance`].
    pub fn new(patches: Arc<Patches>, mean_radiance: f64) -> LearnedPatches {
        let scale = patches.probability.map(|p| if p > 0.0 { (1.0 / (p * f64::from(SHARES))) as f32 } else { 0.0 });
        // A cosine over the density of a map that shines alike from everywhere, 1 / (4 pi).
        let unit = (4.0 * mean_radiance) as f32;
        let mut learned = LearnedPatches { patches, starts: Vec::new(), scale, unit };
        learned.clear();
        learned
    }

    /// Leaves row 0 only.
    pub fn clear(&mut self) {
        self.starts.clear();
        let probability = self.patches.probability;
        self.push(&probability);
    }

    /// Adds a row with shares in proportion to `weights`.
    pub fn push(&mut self, weights: &[f64; PATCHES]) {
        let mut start = 0;
        for share in self.patches.shares(weights) {
            self.starts.push(start);
            start += share;
        }
        self.starts.push(start);
    }

    /// The shares of a row: where each begins, and where the last one ends.
    #[inline]
    fn row(&self, row: u32) -> &[u16; PATCHES + 1] {
        let first = row as usize * (PATCHES + 1);
        self.starts[first..][..PATCHES + 1].try_into().expect("a row has so many values")
    }

    /// The patch that a word chooses.
    #[inline]
    pub fn patch(&self, row: u32, word: u32) -> usize {
        let (starts, place) = (self.row(row), (word >> 17) as u16);
        // The last patch that begins at or before the place: those that begin where the next one does have no share.
        let mut patch = 0;
        let mut step = PATCHES / 2;
        while step > 0 {
            patch += if starts[patch + step] <= place { step } else { 0 };
            step /= 2;
        }
        patch
    }

    /// The texel that the 64 bits of two words choose, and [`LearnedPatches::ratio`] of its patch.
    #[inline]
    pub fn choose(&self, row: u32, [word, fork]: [u32; 2]) -> (u32, f32) {
        let (patch, starts) = (self.patch(row, word), self.row(row));
        let (begin, share) = (u32::from(starts[patch]), u32::from(starts[patch + 1] - starts[patch]));
        // What the choice of the patch leaves of the bits chooses in it.
        let rest = u64::from(word - (begin << 17)) << 32 | u64::from(fork);
        let place = rest as f64 / (f64::from(share) * 562_949_953_421_312.0);
        (self.patches.texel(patch, place), self.ratio(row, patch))
    }

    /// The probability of a patch over that under the map's own distribution.
    #[inline]
    pub fn ratio(&self, row: u32, patch: usize) -> f32 {
        let starts = self.row(row);
        f32::from(starts[patch + 1] - starts[patch]) * self.scale[patch]
    }

    /// The same of the patch that a texel is in.
    #[inline]
    pub fn ratio_of_texel(&self, row: u32, texel: u32) -> f32 {
        self.ratio(row, usize::from(self.patches.of_texel[texel as usize]))
    }

    /// The tables and their sizes in bytes.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        let texels = size_of_val(&self.patches.of_texel[..]) + size_of_val(&self.patches.columns[..]);
        vec![("environment patches", texels), ("learned shares of patches", size_of_val(&self.starts[..]))]
    }
}
