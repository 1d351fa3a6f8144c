//! The environment map: radiance by direction, and how light samples are spread over it.
//!
//! A latitude-longitude picture, +y up, its centre column towards -z, columns rising towards +x. Radiance is constant in a
//! texel, and light samples are uniform in a texel's solid angle, so the density of light samples is proportional to
//! radiance exactly, not just nearly (Pharr, Jakob and Humphreys, pbrt-v4, section 12.5, chooses by bilinear cells), but
//! for a least density ([`LEAST_DENSITY`]).
//!
//! Rows end at the stored versines of [`EnvironmentMap::row_edges`], in sampling, in looking up and in the solid angles the
//! densities are made of: one partition of the sphere, whatever the rounding. The versine 1 - |y| is the height between a
//! point of the unit sphere and the nearer pole's plane, so it is even in area, and close to a pole, where y rounds to 1, it
//! keeps all its digits: it is (x^2 + z^2) / (1 + |y|) of a direction, and 2 sin^2 of half the angle to the pole. With rows
//! told apart by y, those at the poles are 1.3 % wrong in a map of 4,096 rows, and empty in one of 16,384.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};

use crate::fault::{Fault, planted};
use crate::scene::desc::{EnvironmentDesc, MapDesc};
use crate::tables::lights::alias::{AliasColumn, alias_table, factor_above, whole_shares};

/// Light samples come to what shines with at least this part of the density that uniform directions have, so that a dim sky
/// is found where the sun that outshines it cannot be seen. (Small, since what goes to the dim is lost for the bright: where
/// all light comes from one texel it costs a variance of 1/256 of the squared mean.)
pub const LEAST_DENSITY: f64 = 1.0 / 256.0;

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

    /// What f32 cannot hold of it, in words.
    pub fn warning(&self) -> Option<String> {
        let Environment::Map(map) = self else { return None };
        let error = map.power_error();
        (error > 1e-3).then(|| {
            format!(
                "the environment map's {} rows are so narrow that its light comes out {:.2} % wrong; scale it down to \
                 16384 rows or fewer",
                map.height,
                100.0 * error
            )
        })
    }
}

/// One texel: 16 bytes, read whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(16))]
pub struct Texel {
    /// Radiance, in the scene's unit, linear Rec.709.
    pub radiance: [f32; 3],
    /// Its mean over the channels as a density per steradian over the whole sphere (integrates to 1); where anything
    /// shines, not below [`LEAST_DENSITY`] of the uniform one.
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
    /// Versines (1 - |y|) at which rows begin and end, ascending from 0 at a pole to 1 at the equator: both hemispheres have
    /// the same. Row `k` from either pole lies between values `k` and `k + 1`; the middle one of an odd number of rows lies
    /// in both hemispheres.
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
    /// The texel that the 64 bits of two words choose. (32 would not even reach all texels of a large map alike.)
    #[inline]
    pub fn choose(&self, [word, fork]: [u32; 2]) -> u32 {
        let count = self.columns.len() as u64;
        let place = u64::from(word) * count + ((u64::from(fork) * count) >> 32);
        let column = (place >> 32) as u32;
        let AliasColumn { threshold, alias } = self.columns[column as usize];
        if (place as u32) < threshold { column } else { alias }
    }
}

impl EnvironmentMap {
    /// The tables of `desc`, which must have passed [`crate::scene::validate::check`] and have light in it. Radiances count
    /// in `unit`.
    pub fn new(desc: &MapDesc, unit: f64) -> EnvironmentMap {
        let (width, height) = (desc.width, desc.height);
        let mut map = EnvironmentMap {
            width,
            height,
            texels: Vec::new(),
            row_edges: row_edges(height),
            mean_radiance: 0.0,
            turn: turn(desc.rotate),
            plain: OnceLock::new(),
            compensated: OnceLock::new(),
        };
        let radiance = |i: usize| desc.texels[i].map(|c| (c as f64 * desc.scale / unit) as f32);
        let mean = |rgb: [f32; 3]| rgb.iter().map(|&c| c as f64).sum::<f64>() / 3.0;
        let cells = || (0..desc.texels.len()).map(|i| (mean(radiance(i)), map.solid_angle(i)));
        let sphere = 4.0 * std::f64::consts::PI;
        let mean_radiance = 3.0 * cells().map(|(mean, solid_angle)| mean * solid_angle).sum::<f64>() / sphere;
        let least = LEAST_DENSITY / sphere;
        let factor = factor_above(cells, least);
        let density = |mean: f64| if mean > 0.0 { (mean * factor).max(least) } else { 0.0 };
        let texel = |radiance: [f32; 3]| Texel { radiance, pdf_dir: density(mean(radiance)) as f32 };
        map.texels = (0..desc.texels.len()).map(|i| texel(radiance(i))).collect();
        map.mean_radiance = mean_radiance;
        map
    }

    /// The solid angle of texel `i`, steradians.
    pub fn solid_angle(&self, i: usize) -> f64 {
        let row = (i / self.width as usize) as u32;
        let from_pole = row.min(self.height - 1 - row) as usize;
        let height = self.row_edges[from_pole + 1] as f64 - self.row_edges[from_pole] as f64;
        let height = if planted(Fault::TallRows) { 1.01 * height } else { height };
        let hemispheres = if self.is_middle(row) { 2.0 } else { 1.0 };
        std::f64::consts::TAU * height * hemispheres / self.width as f64
    }

    /// By how much of itself the map's power differs from what it is between unrounded row edges.
    fn power_error(&self) -> f64 {
        let row_angle = std::f64::consts::PI / self.height as f64;
        // cos a - cos b, without cancellation.
        let height = |row: usize| 2.0 * libm::sin((row as f64 + 0.5) * row_angle) * libm::sin(0.5 * row_angle);
        let width = self.width as usize;
        let solid_angle = |row: usize| std::f64::consts::TAU * height(row) / width as f64;
        let power = |texel: &Texel| texel.radiance.iter().map(|&c| c as f64).sum::<f64>();
        let row_power = |row: usize| self.texels[row * width..][..width].iter().map(power).sum::<f64>();
        let [mut exact, mut stored] = [0.0; 2];
        for row in 0..self.height as usize {
            let power = row_power(row);
            exact += power * solid_angle(row);
            stored += power * self.solid_angle(row * width);
        }
        (stored / exact - 1.0).abs()
    }

    /// Whether the row lies in both hemispheres.
    #[inline]
    pub fn is_middle(&self, row: u32) -> bool {
        2 * row + 1 == self.height
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
        Distribution { columns: alias_table(whole_shares(&weights, total)), floor, factor: (1.0 / total) as f32 }
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

/// The versines at which rows end, from a pole to the equator.
fn row_edges(height: u32) -> Vec<f32> {
    let versine = |row: u32| {
        let sine = libm::sin(row as f64 / height as f64 * std::f64::consts::FRAC_PI_2);
        (2.0 * sine * sine) as f32
    };
    (0..height.div_ceil(2)).map(versine).chain([1.0]).collect()
}

/// Degrees as turns in [0, 1).
fn turn(degrees: f64) -> f32 {
    let turn = (degrees / 360.0 - (degrees / 360.0).floor()) as f32;
    if turn < 1.0 { turn } else { 0.0 }
}
