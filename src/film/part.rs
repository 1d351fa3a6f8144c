//! Parts of a film that were rendered by themselves, and the film that they make together.
//!
//! The film is covered by tiles of [`SIDE`] x [`SIDE`] pixels. Their order is fixed and looks random, so that neighbours, which
//! cost alike, go to different parts; part K of N has every N-th tile from the K-th on. All samples of a pixel are taken by one
//! part, in their order, so merging copies sums and adds nothing: it is exact by construction, in whatever order parts come.
//!
//! Layers and alpha, where a part was made with some, are copied as well.
//!
//! In memory the film of a part is a strip, a row of [`PIXELS`] pixels a tile; those that a tile at the film's edge lacks stay
//! empty. In its file they are left out.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::files::memory;
use crate::files::sealed::{self, Found, Numbers};
use crate::film::Film;
use crate::film::layers::{LayerPixel, Layers, NUMBERS};
use crate::sampler::sobol::GROUPS;
use crate::settings::{Crop, Layer, MAX_FILM_PIXELS, MAX_FILM_SIDE, Sampler, Shard};

/// Columns and rows of a tile.
pub const SIDE: u32 = 16;
/// Pixels of a tile.
pub const PIXELS: u32 = SIDE * SIDE;

const MAGIC: &str = "octray part of a render, version 1";

/// The tiles of a part, cut to `crop`, of a film of so many columns and rows.
pub fn tiles((width, height): (u32, u32), crop: Crop, shard: Shard) -> Vec<Crop> {
    let columns = width.div_ceil(SIDE);
    let in_crop = |tile: u32| {
        let (x, y) = (tile % columns * SIDE, tile / columns * SIDE);
        let (left, top) = (x.max(crop.x), y.max(crop.y));
        let right = (x + SIDE).min(crop.x + crop.width);
        let bottom = (y + SIDE).min(crop.y + crop.height);
        (left < right && top < bottom).then(|| Crop { x: left, y: top, width: right - left, height: bottom - top })
    };
    let mut all: Vec<(u32, Crop)> =
        (0..columns * height.div_ceil(SIDE)).filter_map(|tile| Some((tile, in_crop(tile)?))).collect();
    // Those of the crop alone, so that parts of a crop are alike as well.
    all.sort_unstable_by_key(|&(tile, _)| (scrambled(tile), tile));
    let own = all.into_iter().skip(shard.number as usize - 1).step_by(shard.count as usize);
    own.map(|(_, area)| area).collect()
}

/// A one-to-one map of 32 bits that leaves no order to see (the finalizer of MurmurHash3, Appleby 2011).
fn scrambled(number: u32) -> u32 {
    let mut bits = number.wrapping_add(0x9e37_79b9);
    bits = (bits ^ bits >> 16).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ bits >> 13).wrapping_mul(0xc2b2_ae35);
    bits ^ bits >> 16
}

/// The strip of the tiles `areas`, empty.
///
/// # Errors
/// [`Error::Memory`].
pub fn strip(areas: &[Crop], sampler: Sampler) -> Result<Film> {
    let width = areas.len() as u32 * PIXELS;
    let height = u32::from(width > 0);
    Film::try_of_sampler(Crop { x: 0, y: 0, width, height }, sampler)
}

/// What a part says of itself besides its sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// What decides the bits of the whole picture, as (name, value).
    pub recipe: Vec<(String, String)>,
    /// What the header of the whole image is to say.
    pub metadata: Vec<(String, String)>,
    /// Columns and rows of the film.
    pub film: (u32, u32),
    /// x, y, columns and rows of the part of it that all parts together are.
    pub crop: [u32; 4],
    /// Which part it is, from 1, and of how many.
    pub shard: (u32, u32),
    /// Samples in every pixel.
    pub spp: u32,
    /// What the whole image is to hold beside radiance ([`Layers::wanted`]).
    #[serde(default = "variance_alone")]
    pub layers: Vec<String>,
    /// The whole image is to hold alpha.
    #[serde(default)]
    pub alpha: bool,
    /// Sums by group follow those of all samples; else sums of squares.
    pub grouped: bool,
}

/// The names of the layers that are wanted.
pub fn layer_names(layers: &Layers) -> Vec<String> {
    layers.wanted.iter().map(Layer::to_string).collect()
}

/// The layers of parts that do not say.
fn variance_alone() -> Vec<String> {
    layer_names(&Layers::default())
}

impl About {
    fn crop(&self) -> Crop {
        let [x, y, width, height] = self.crop;
        Crop { x, y, width, height }
    }

    /// The layers that are wanted; `None` if one of them is none.
    fn wanted(&self) -> Option<Vec<Layer>> {
        self.layers.iter().map(|name| name.parse().ok()).collect()
    }

    /// Whether layers follow the sums of a tile.
    fn has_layers(&self) -> bool {
        self.alpha || self.wanted().is_some_and(|wanted| Layer::are_of_hits(&wanted))
    }

    /// Its tiles, in the order of its sums.
    pub fn tiles(&self) -> Vec<Crop> {
        tiles(self.film, self.crop(), Shard { number: self.shard.0, count: self.shard.1 })
    }

    /// What differs in `other`, which is to be a part of the same picture; `None`: it may be one.
    pub fn differs(&self, other: &About) -> Option<String> {
        let pairs = self.recipe.iter().zip(&other.recipe);
        let names = |about: &About| about.recipe.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        if names(self) != names(other) {
            return Some("it is of another version of octray".into());
        }
        if let Some(((name, own), (_, theirs))) = pairs.into_iter().find(|(own, theirs)| own != theirs) {
            return Some(format!("its {name} is {theirs}, and not {own}"));
        }
        let texts = [
            ("film", format!("{:?}", self.film), format!("{:?}", other.film)),
            ("crop", format!("{:?}", self.crop), format!("{:?}", other.crop)),
            ("number of samples a pixel", self.spp.to_string(), other.spp.to_string()),
            ("number of parts", self.shard.1.to_string(), other.shard.1.to_string()),
            ("sampler", self.grouped.to_string(), other.grouped.to_string()),
            ("list of layers", format!("{:?}", self.layers), format!("{:?}", other.layers)),
            ("alpha", self.alpha.to_string(), other.alpha.to_string()),
            ("header", format!("{:?}", self.metadata), format!("{:?}", other.metadata)),
        ];
        let different = texts.into_iter().find(|(_, own, theirs)| own != theirs);
        different.map(|(name, own, theirs)| format!("its {name} is {theirs}, and not {own}"))
    }

    /// Whether a render can have left this: a file with a right checksum may still be made by somebody else.
    fn is_sound(&self) -> bool {
        let About { film: (width, height), crop: [x, y, w, h], shard: (number, count), .. } = *self;
        let inside =
            |start: u32, length: u32, end: u32| length > 0 && u64::from(start) + u64::from(length) <= end.into();
        (1..=MAX_FILM_SIDE).contains(&width)
            && (1..=MAX_FILM_SIDE).contains(&height)
            && inside(x, w, width)
            && inside(y, h, height)
            && u64::from(w) * u64::from(h) <= MAX_FILM_PIXELS
            && (1..=count).contains(&number)
            && self.spp > 0
            && self.wanted().is_some()
    }
}

/// Writes the part whose strip is `film` to `path`, whole or not at all.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, about: &About, film: &Film) -> Result<()> {
    let tiles = about.tiles();
    let of_tile = |tile: usize| tile * PIXELS as usize..tile * PIXELS as usize + pixels(&tiles[tile]);
    sealed::write(path, MAGIC, about, |out| {
        for tile in 0..tiles.len() {
            film.pixels[of_tile(tile)].iter().try_for_each(|pixel| out.numbers(&pixel.sum))?;
            if about.grouped {
                film.groups[of_tile(tile)].iter().try_for_each(|groups| out.numbers(groups.0.as_flattened()))?;
            } else {
                film.squares[of_tile(tile)].iter().try_for_each(|squares| out.numbers(&squares.0))?;
            }
            if about.has_layers() {
                let mut pixels = film.layers.pixels[of_tile(tile)].iter();
                pixels.try_for_each(|pixel| out.numbers(&pixel.to_array().map(f64::from)))?;
            }
        }
        Ok(())
    })
}

fn pixels(area: &Crop) -> usize {
    area.width as usize * area.height as usize
}

/// A part that was opened: whole, and possible as a part.
pub struct Part {
    /// What it says of itself.
    pub about: About,
    numbers: Numbers,
}

/// Opens a part.
///
/// # Errors
/// [`Error::Read`]; [`Error::Parse`] if it is none, or not as it was written.
pub fn open(path: &Path) -> Result<Part> {
    let fault = |message: &str| Err(Error::parse(path, None, message));
    match sealed::open::<About>(path, MAGIC)? {
        Found::Damaged => fault("not a part of a render, or a damaged one: render that part again"),
        Found::OtherVersion => fault("a part of a render by another version of octray"),
        Found::Whole(about, numbers) => {
            let layers = if about.has_layers() { NUMBERS as u64 } else { 0 };
            let each = 3 + if about.grouped { 3 * GROUPS as u64 } else { 3 } + layers;
            let count = |about: &About| about.tiles().iter().map(|tile| pixels(tile) as u64).sum::<u64>();
            if !about.is_sound() || count(&about).checked_mul(each) != Some(numbers.left()) {
                return fault("a part that no render can have left: render that part again");
            }
            Ok(Part { about, numbers })
        }
    }
}

impl Part {
    /// An empty film for the picture that this is a part of.
    ///
    /// # Errors
    /// [`Error::Memory`].
    pub fn whole(&self) -> Result<Film> {
        let about = &self.about;
        let sampler = if about.grouped { Sampler::Sobol } else { Sampler::Independent };
        let mut film = Film::try_of_sampler(about.crop(), sampler)?;
        let [x, y, width, height] = about.crop;
        let whole = (x, y, (width, height)) == (0, 0, about.film);
        film.place = (!whole).then_some(crate::film::Place { x, y, film: about.film });
        film.spp = about.spp;
        film.metadata.clone_from(&about.metadata);
        let count = if about.has_layers() { film.pixels.len() } else { 0 };
        let pixels = memory::table(count, "the layers of the image")?;
        film.layers = Layers { wanted: about.wanted().unwrap_or_default(), alpha: about.alpha, pixels };
        Ok(film)
    }

    /// Puts its sums into `film`, made by [`Part::whole`] of a part that does not differ.
    ///
    /// # Errors
    /// [`Error::Read`] and [`Error::Parse`] if the file, `path`, cannot be read any more, or holds what is no sum.
    pub fn put(mut self, path: &Path, film: &mut Film) -> Result<()> {
        let fault =
            || Error::parse(path, None, "its sums are not finite, or it has changed meanwhile: render it again");
        let [left, top, width, _] = self.about.crop;
        for tile in self.about.tiles() {
            let rows = tile.y - top..tile.y - top + tile.height;
            let start = |y: u32| y as usize * width as usize + (tile.x - left) as usize;
            let indices = || rows.clone().flat_map(|y| start(y)..start(y) + tile.width as usize);
            for index in indices() {
                film.pixels[index].sum = self.sums().ok_or_else(fault)?;
            }
            for index in indices() {
                match film.groups.get_mut(index) {
                    Some(groups) => {
                        for group in &mut groups.0 {
                            *group = self.sums().ok_or_else(fault)?;
                        }
                    }
                    None => film.squares[index].0 = self.sums().ok_or_else(fault)?,
                }
            }
            if self.about.has_layers() {
                for index in indices() {
                    film.layers.pixels[index] = self.layers().ok_or_else(fault)?;
                }
            }
        }
        Ok(())
    }

    fn layers(&mut self) -> Option<LayerPixel> {
        let numbers = self.numbers.array::<NUMBERS>()?.map(|number| number as f32);
        numbers.iter().all(|number| number.is_finite()).then(|| LayerPixel::from_array(numbers))
    }

    fn sums(&mut self) -> Option<[f64; 3]> {
        self.numbers.array::<3>().filter(|sums| sums.iter().all(|sum| sum.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_share_the_pixels_of_any_crop_evenly() {
        for (film, crop) in [
            ((100, 70), Crop { x: 0, y: 0, width: 100, height: 70 }),
            ((512, 512), Crop { x: 17, y: 300, width: 200, height: 31 }),
            ((5, 5), Crop { x: 4, y: 0, width: 1, height: 5 }),
        ] {
            for count in [1, 2, 3, 7, 64] {
                let mut seen = vec![0; film.0 as usize * film.1 as usize];
                let mut lengths = Vec::new();
                for number in 1..=count {
                    let own = tiles(film, crop, Shard { number, count });
                    lengths.push(own.len());
                    for tile in &own {
                        assert!(tile.width > 0 && tile.width <= SIDE && tile.height > 0 && tile.height <= SIDE);
                        for (y, x) in (tile.y..tile.y + tile.height)
                            .flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| (y, x)))
                        {
                            seen[(y * film.0 + x) as usize] += 1;
                        }
                    }
                }
                let inside = |x: u32, y: u32| {
                    (crop.x..crop.x + crop.width).contains(&x) && (crop.y..crop.y + crop.height).contains(&y)
                };
                for (index, times) in (0..).zip(seen) {
                    assert_eq!(times, i32::from(inside(index % film.0, index / film.0)));
                }
                assert!(lengths.iter().max().unwrap() - lengths.iter().min().unwrap() <= 1);
            }
        }
    }

    #[test]
    fn forged_parts_are_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.part");
        let about = About {
            recipe: Vec::new(),
            metadata: Vec::new(),
            film: (3, 2),
            crop: [1, 0, 2, 2],
            shard: (1, 1),
            spp: 4,
            layers: variance_alone(),
            alpha: false,
            grouped: false,
        };
        let forge = |change: fn(&mut About), numbers: &[f64]| {
            let mut about = about.clone();
            change(&mut about);
            sealed::write(&path, MAGIC, &about, |out| out.numbers(numbers)).unwrap();
            let part = open(&path)?;
            let mut film = part.whole()?;
            part.put(&path, &mut film).map(|()| film)
        };
        let numbers: Vec<f64> = (0..24).map(f64::from).collect();
        let film = forge(|_| (), &numbers).unwrap();
        assert_eq!((film.pixels[3].sum, film.squares[0].0), ([9.0, 10.0, 11.0], [12.0, 13.0, 14.0]));
        let changes: [fn(&mut About); 8] = [
            |a| a.film = (0, 2),
            |a| a.film = (u32::MAX, u32::MAX),
            |a| a.crop = [2, 0, 2, 2],
            |a| a.crop = [u32::MAX, 0, 2, 2],
            |a| a.shard = (2, 1),
            |a| a.shard = (0, 0),
            |a| a.spp = 0,
            |a| a.grouped = true,
        ];
        for change in changes {
            assert!(matches!(forge(change, &numbers), Err(Error::Parse { .. })));
        }
        let mut not_finite = numbers.clone();
        not_finite[23] = f64::INFINITY;
        assert!(forge(|_| (), &not_finite).is_err() && forge(|_| (), &numbers[1..]).is_err());
    }
}
