//! Layers: what image files hold beside radiance, for denoisers and compositors.
//!
//! They are means over the camera rays of the picture's own samples (the same places in the pixel, on the lens, the same numbers),
//! so they have the picture's pixel filter, and are a function of scene, settings and the number of samples alone. A pass of
//! their own gathers them when all samples are taken: renders without layers do nothing for them.
//!
//! | channels | what they hold |
//! | --- | --- |
//! | `Albedo.{R,G,B}` | the colours of surfaces, in [0, 1]: the albedo of diffuse ones, texture included; the reflectance of mirrors and, at normal incidence, of metals; 1 for glass; coat, base and metal of plastic and principled surfaces together, at normal incidence. Emission does not count |
//! | `N.{X,Y,Z}` | unit geometric normals in world space, on the side the ray came from |
//! | `Ns.{X,Y,Z}` | unit normals to shade with, less than 90 degrees from those |
//! | `Z` | the distance of first hits along the camera's axis, scene units, over the rays that hit something; [`NOTHING`] where none does |
//! | `A` | the share of rays that hit something |
//!
//! Rays that hit nothing count with albedo 0 and normal 0. Means of normals are shorter than 1 where normals differ: they are not
//! normalised, as Open Image Denoise wants them. With [`crate::Settings::layers_through_specular`] albedo and normals are those of
//! the first surface that is neither a mirror nor glass, the albedo times what mirrors and glass on the way send on; glass goes
//! the way of the sample, so that its layers are the Fresnel blend of both. `Z` and `A` stay those of the first hit: things are
//! put before and behind each other by them.

use crate::settings::Layer;

/// `Z` of pixels none of whose rays hits anything: a large number that compositors know, as no infinity is.
pub const NOTHING: f32 = 1e10;

/// Mirrors and glass that a ray for layers goes through at most; the next one is taken as it is.
pub const MOST_SPECULAR: u32 = 32;

/// What one camera ray has found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// Linear Rec.709, in [0, 1].
    pub albedo: [f32; 3],
    /// Unit geometric normal.
    pub normal: [f32; 3],
    /// Unit shading normal.
    pub shading_normal: [f32; 3],
    /// Distance along the camera's axis; infinite: nothing is hit.
    pub depth: f32,
}

impl FirstHit {
    /// Nothing.
    pub const NONE: FirstHit =
        FirstHit { albedo: [0.0; 3], normal: [0.0; 3], shading_normal: [0.0; 3], depth: f32::INFINITY };
}

/// The sums of a pixel, in sample order.
#[derive(Clone, Copy, Debug, Default)]
pub struct LayerSums {
    albedo: [f64; 3],
    normal: [f64; 3],
    shading_normal: [f64; 3],
    depth: f64,
    hits: u32,
    rays: u32,
}

impl LayerSums {
    /// Adds one ray.
    pub fn add(&mut self, hit: &FirstHit) {
        let add = |sums: &mut [f64; 3], values: [f32; 3]| {
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += f64::from(value));
        };
        add(&mut self.albedo, hit.albedo);
        add(&mut self.normal, hit.normal);
        add(&mut self.shading_normal, hit.shading_normal);
        self.rays += 1;
        if hit.depth < f32::INFINITY {
            self.depth += f64::from(hit.depth);
            self.hits += 1;
        }
    }

    /// The means.
    pub fn means(&self) -> LayerPixel {
        let rays = f64::from(self.rays.max(1));
        let mean = |sums: [f64; 3]| sums.map(|sum| (sum / rays) as f32);
        LayerPixel {
            albedo: mean(self.albedo),
            normal: mean(self.normal),
            shading_normal: mean(self.shading_normal),
            depth: if self.hits > 0 { (self.depth / f64::from(self.hits)) as f32 } else { NOTHING },
            alpha: (f64::from(self.hits) / rays) as f32,
        }
    }
}

/// The layers of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerPixel {
    /// Mean albedo.
    pub albedo: [f32; 3],
    /// Mean geometric normal.
    pub normal: [f32; 3],
    /// Mean shading normal.
    pub shading_normal: [f32; 3],
    /// Mean depth of what is hit, or [`NOTHING`].
    pub depth: f32,
    /// The share of rays that hit something.
    pub alpha: f32,
}

/// Numbers of a pixel's layers.
pub const NUMBERS: usize = 11;

impl LayerPixel {
    /// All of its numbers, in the order of its fields.
    pub fn to_array(self) -> [f32; NUMBERS] {
        let LayerPixel { albedo: [r, g, b], normal: [x, y, z], shading_normal: [sx, sy, sz], depth, alpha } = self;
        [r, g, b, x, y, z, sx, sy, sz, depth, alpha]
    }

    /// The pixel with these numbers.
    pub fn from_array([r, g, b, x, y, z, sx, sy, sz, depth, alpha]: [f32; NUMBERS]) -> LayerPixel {
        LayerPixel { albedo: [r, g, b], normal: [x, y, z], shading_normal: [sx, sy, sz], depth, alpha }
    }
}

/// The layers of a film.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// Those that files are to hold.
    pub wanted: Vec<Layer>,
    /// Files are to hold alpha.
    pub alpha: bool,
    /// As [`crate::Film::pixels`]; empty until they are gathered.
    pub pixels: Vec<LayerPixel>,
}

impl Default for Layers {
    fn default() -> Layers {
        Layers { wanted: vec![Layer::Variance], alpha: false, pixels: Vec::new() }
    }
}

/// A channel of the layers.
#[derive(Clone, Copy)]
pub struct LayerChannel {
    /// Its name in files.
    pub name: &'static str,
    /// Its value in a pixel.
    pub of: fn(&LayerPixel) -> f32,
}

impl Layers {
    /// Whether files are to hold the variance of the pixels' means.
    pub fn has_variance(&self) -> bool {
        self.wanted.contains(&Layer::Variance)
    }

    /// The alpha of each pixel, if files are to hold it.
    pub fn alphas(&self) -> Option<impl Iterator<Item = f32> + '_> {
        (self.alpha && !self.pixels.is_empty()).then(|| self.pixels.iter().map(|pixel| pixel.alpha))
    }

    /// The channels that files are to hold, if they have been gathered.
    pub fn channels(&self) -> Vec<LayerChannel> {
        if self.pixels.is_empty() {
            return Vec::new();
        }
        const ALBEDO: [LayerChannel; 3] = [
            LayerChannel { name: "Albedo.R", of: |pixel| pixel.albedo[0] },
            LayerChannel { name: "Albedo.G", of: |pixel| pixel.albedo[1] },
            LayerChannel { name: "Albedo.B", of: |pixel| pixel.albedo[2] },
        ];
        const NORMAL: [LayerChannel; 6] = [
            LayerChannel { name: "N.X", of: |pixel| pixel.normal[0] },
            LayerChannel { name: "N.Y", of: |pixel| pixel.normal[1] },
            LayerChannel { name: "N.Z", of: |pixel| pixel.normal[2] },
            LayerChannel { name: "Ns.X", of: |pixel| pixel.shading_normal[0] },
            LayerChannel { name: "Ns.Y", of: |pixel| pixel.shading_normal[1] },
            LayerChannel { name: "Ns.Z", of: |pixel| pixel.shading_normal[2] },
        ];
        const DEPTH: [LayerChannel; 1] = [LayerChannel { name: "Z", of: |pixel| pixel.depth }];
        const ALPHA: LayerChannel = LayerChannel { name: "A", of: |pixel| pixel.alpha };
        let of_layer = |layer: &Layer| match layer {
            Layer::Albedo => &ALBEDO[..],
            Layer::Normal => &NORMAL[..],
            Layer::Depth => &DEPTH[..],
            Layer::Variance => &[],
        };
        self.wanted.iter().flat_map(of_layer).copied().chain(self.alpha.then_some(ALPHA)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_all_rays_and_depths_over_those_that_hit() {
        let mut sums = LayerSums::default();
        let hit = |albedo: f32, depth: f32| FirstHit {
            albedo: [albedo, 0.0, 1.0],
            normal: [0.0, 1.0, 0.0],
            shading_normal: [0.0, 0.0, 1.0],
            depth,
        };
        [hit(0.5, 2.0), FirstHit::NONE, hit(0.25, 3.0), FirstHit::NONE].iter().for_each(|hit| sums.add(hit));
        let wanted = LayerPixel {
            albedo: [0.1875, 0.0, 0.5],
            normal: [0.0, 0.5, 0.0],
            shading_normal: [0.0, 0.0, 0.5],
            depth: 2.5,
            alpha: 0.5,
        };
        assert_eq!(sums.means(), wanted);
        let mut none = LayerSums::default();
        none.add(&FirstHit::NONE);
        assert_eq!(none.means(), LayerPixel { depth: NOTHING, ..LayerPixel::default() });
    }

    #[test]
    fn channels_are_those_that_are_wanted_and_gathered() {
        let names = |layers: &Layers| layers.channels().iter().map(|channel| channel.name).collect::<Vec<_>>();
        let mut layers = Layers { wanted: vec![Layer::Depth, Layer::Albedo], alpha: true, pixels: Vec::new() };
        assert!(names(&layers).is_empty() && layers.alphas().is_none() && !layers.has_variance());
        layers.pixels.push(LayerPixel { albedo: [0.1, 0.2, 0.3], depth: 4.0, alpha: 0.5, ..LayerPixel::default() });
        assert_eq!(names(&layers), ["Z", "Albedo.R", "Albedo.G", "Albedo.B", "A"]);
        let values: Vec<f32> = layers.channels().iter().map(|channel| (channel.of)(&layers.pixels[0])).collect();
        assert_eq!(values, [4.0, 0.1, 0.2, 0.3, 0.5]);
        assert!(Layers::default().has_variance());
    }
}
