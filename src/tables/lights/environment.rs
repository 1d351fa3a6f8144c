//! The environment map: radiance by direction, and how light samples are spread over it.
//!
//! A latitude-longitude picture, +y up, its centre column towards -z, columns rising towards +x. Radiance is constant in a
//! texel, and light samples are uniform in a texel's solid angle, so the density of light samples is proportional to
//! radiance exactly, not just nearly (Pharr, Jakob and Humphreys, pbrt-v4, section 12.5, chooses by bilinear cells).
//! Rows end at the stored cosines of [`EnvironmentMap::row_edges`], in sampling, in looking up and in the solid angles the
//! densities are made of: one partition of the sphere, whatever the rounding.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};

use crate::fault::{Fault, planted};
use crate::sampler::index_below;
use crate::scene::desc::{EnvironmentDesc, MapDesc};
use crate::tables::lights::alias::{AliasColumn, alias_table};

/// What surrounds a scene.
pub enum Environment {
    /// The same radiance from everywhere, in the scene's unit.
    Constant([f32; 3]),
    /// Radiance by direction.
    Map(Box<EnvironmentMap>),
}

impl Environment {
    /// The environment that `desc` describes; radiances count in `unit`.
    pub fn new(desc: &EnvironmentDesc, unit: f64) -> Environment {
        match desc {
            EnvironmentDesc::Constant { radiance } => Environment::Constant(radiance.map(|c| (c / unit) as f32)),
            EnvironmentDesc::Map(map) => Environment::Map(Box::new(EnvironmentMap::new(map, unit))),
        }
    }

    /// Radiance averaged over the sphere and summed over the channels, in the scene's unit.
    pub fn mean_radiance(&self) -> f64 {
        match self {
            Environment::Constant(radiance) => radiance.iter().map(|&c| f64::from(c)).sum(),
            Environment::Map(map) => map.mean_radiance,
        }
    }
}

/// One texel: 16 bytes, read whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(16))]
pub struct Texel {
    /// Radiance, in the scene's unit, linear Rec.709.
    pub radiance: [f32; 3],
    /// Its mean over the channels, as a density per steradian over the whole sphere (integrates to 1).
    pub pdf_dir: f32,
}

/// A latitude-longitude map, ready to be sampled and looked up.
pub struct EnvironmentMap {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Texels, row by row from the top (+y).
    pub texels: Vec<Texel>,
    /// Cosines of the angle to +y at which rows begin and end, descending from 1 to -1: `height + 1` values.
    pub row_edges: Vec<f32>,
    /// Radiance averaged over the sphere and summed over the channels, in the scene's unit.
    pub mean_radiance: f64,
    /// Turns, in [0, 1), by which the picture is turned about +y (from +z towards +x).
    pub turn: f32,
    plain: OnceLock<Distribution>,
    compensated: OnceLock<Distribution>,
}

/// How light samples are spread over the texels: with density `max(pdf_dir - floor, 0) * factor` of [`Texel::pdf_dir`].
#[derive(Debug, PartialEq)]
pub struct Distribution {
    /// Alias table over all texels.
    pub columns: Vec<AliasColumn>,
    /// What is taken off every texel's density, per steradian.
    pub floor: f32,
    /// Makes the rest integrate to 1.
    pub factor: f32,
}

impl Distribution {
    /// The texel that two words choose: `word` a column of the table, `fork` between the column's two texels.
    #[inline]
    pub fn choose(&self, word: u32, fork: u32) -> u32 {
        let column = index_below(word, self.columns.len() as u32);
        let AliasColumn { threshold, alias } = self.columns[column as usize];
        if fork < threshold { column } else { alias }
    }
}

impl EnvironmentMap {
    /// The tables of `desc`, which must have passed [`crate::scene::validate::check`] and have light in it. Radiances count
    /// in `unit`.
    pub fn new(desc: &MapDesc, unit: f64) -> EnvironmentMap {
        let (width, height) = (desc.width, desc.height);
        let angle = |row: u32| row as f64 / height as f64 * std::f64::consts::PI;
        let mut map = EnvironmentMap {
            width,
            height,
            texels: Vec::new(),
            row_edges: (0..=height).map(|row| libm::cos(angle(row)) as f32).collect(),
            mean_radiance: 0.0,
            turn: turn(desc.rotate),
            plain: OnceLock::new(),
            compensated: OnceLock::new(),
        };
        let radiance = |i: usize| desc.texels[i].map(|c| (c as f64 * desc.scale / unit) as f32);
        let mean = |rgb: [f32; 3]| rgb.iter().map(|&c| c as f64).sum::<f64>() / 3.0;
        let count = desc.texels.len();
        let total: f64 = (0..count).map(|i| mean(radiance(i)) * map.solid_angle(i)).sum();
        let texel = |i: usize| Texel { radiance: radiance(i), pdf_dir: (mean(radiance(i)) / total) as f32 };
        map.mean_radiance = 3.0 * total / (4.0 * std::f64::consts::PI);
        map.texels = (0..count).map(texel).collect();
        map
    }

    /// The solid angle of texel `i`, steradians.
    pub fn solid_angle(&self, i: usize) -> f64 {
        let row = i / self.width as usize;
        let height = self.row_edges[row] as f64 - self.row_edges[row + 1] as f64;
        let height = if planted(Fault::TallRows) { 1.01 * height } else { height };
        std::f64::consts::TAU * height / self.width as f64
    }

    /// The distribution of light samples, made when it is first asked for.
    ///
    /// Plain, it is proportional to radiance. `compensated`, it leaves out what lies below the mean (Karlik, Sik, Vevoda,
    /// Skrivan and Krivanek, "MIS Compensation", ACM TOG 38(6), 2019): only for strategies that also draw from the BSDF and
    /// weigh by both densities, since light samples then never go where the map is dimmer than its mean.
    /// Measured on the pavilion of `scenes/sky.toml` (mis-power, 64 samples): relMSE falls by 2.1 under its own map, by 1.3
    /// under Poly Haven's royal_esplanade, 1.2 and 1.3 under Blender's studio and city, at 3 to 5 % fewer CPU seconds.
    pub fn distribution(&self, compensated: bool) -> &Distribution {
        if compensated {
            self.compensated.get_or_init(|| self.spread(0.25 * std::f32::consts::FRAC_1_PI))
        } else {
            self.plain.get_or_init(|| self.spread(0.0))
        }
    }

    /// The distribution over what of each texel's density lies above `floor`; over all of it if next to nothing does.
    fn spread(&self, floor: f32) -> Distribution {
        let rest = |texel: &Texel| (texel.pdf_dir - floor).max(0.0) as f64;
        let weights: Vec<f64> = self.texels.iter().enumerate().map(|(i, t)| rest(t) * self.solid_angle(i)).collect();
        let total: f64 = weights.iter().sum();
        // A map without contrast would be left with its rounding errors.
        if floor > 0.0 && total < 1e-3 {
            return self.spread(0.0);
        }
        Distribution { columns: alias_table(&weights, total), floor, factor: (1.0 / total) as f32 }
    }

    /// The tables and their sizes in bytes; distributions as far as they have been asked for.
    pub fn tables(&self) -> Vec<(&'static str, usize)> {
        let bytes = |d: &OnceLock<Distribution>| d.get().map_or(0, |d| size_of_val(&d.columns[..]));
        vec![
            ("environment texels", size_of_val(&self.texels[..])),
            ("environment rows", size_of_val(&self.row_edges[..])),
            ("environment alias table", bytes(&self.plain)),
            ("environment alias table (compensated)", bytes(&self.compensated)),
        ]
    }
}

/// Degrees as turns in [0, 1).
fn turn(degrees: f64) -> f32 {
    let turn = (degrees / 360.0 - (degrees / 360.0).floor()) as f32;
    if turn < 1.0 { turn } else { 0.0 }
}
