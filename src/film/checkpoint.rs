//! A film as it is, sums and all: what an interrupted render leaves behind so that it can go on.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::film::Film;
use crate::film::sealed;
use crate::film::sums::{GroupSums, Pixel, SquareSums};
use crate::sampler::sobol::GROUPS;

const MAGIC: &str = "octray unfinished render, version 2";
/// Numbers a pixel: sums and sums of squares of three channels. (Pixels that are sampled in groups have no sums of squares any
/// more: zeros stand in their place, so that files of earlier versions can be gone on with.)
const NUMBERS: usize = 6;
/// Numbers a pixel has besides if it is sampled in groups: the sums of each.
const GROUP_NUMBERS: usize = 3 * GROUPS as usize;

/// An unfinished render.
#[derive(Debug)]
pub struct Checkpoint {
    /// What decides the picture's bits, as (name, value).
    pub settings: Vec<(String, String)>,
    /// Wall seconds it has taken.
    pub seconds: f64,
    /// What it has come to.
    pub film: Film,
}

#[derive(Serialize, Deserialize)]
struct Header {
    settings: Vec<(String, String)>,
    seconds: f64,
    width: u32,
    height: u32,
    spp: u32,
    /// Sums by group follow those of all samples.
    grouped: bool,
}

/// Writes `state` to `path`, whole or not at all.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, state: &Checkpoint) -> Result<()> {
    let film = &state.film;
    let header = Header {
        settings: state.settings.clone(),
        seconds: state.seconds,
        width: film.width,
        height: film.height,
        spp: film.spp,
        grouped: !film.groups.is_empty(),
    };
    let squares = |index: usize| film.squares.get(index).copied().unwrap_or_default();
    let pixels = film.pixels.iter().enumerate();
    let numbers = pixels.flat_map(|(index, pixel)| pixel.sum.into_iter().chain(squares(index).0));
    let numbers = numbers.chain(film.groups.iter().flat_map(|group| group.0.into_iter().flatten()));
    sealed::write(path, MAGIC, &header, numbers)
}

/// Reads what [`write()`] has written.
///
/// # Errors
/// [`Error::Read`]; [`Error::Parse`] if it is not such a file or not a whole one.
pub fn read(path: &Path) -> Result<Checkpoint> {
    let fault = || Error::parse(path, None, "not an unfinished render, or a damaged one; delete it to start anew");
    let (header, numbers) = sealed::read::<Header>(path, MAGIC)?.ok_or_else(fault)?;
    unfinished(header, &numbers).ok_or_else(fault)
}

fn unfinished(header: Header, numbers: &[f64]) -> Option<Checkpoint> {
    let count = (header.width as usize).checked_mul(header.height as usize)?;
    let each = if header.grouped { NUMBERS + GROUP_NUMBERS } else { NUMBERS };
    if numbers.len() != count.checked_mul(each)? || header.spp == 0 {
        return None;
    }
    let (numbers, groups) = numbers.split_at(count * NUMBERS);
    let group = |n: &[f64; GROUP_NUMBERS]| GroupSums(std::array::from_fn(|i| std::array::from_fn(|c| n[3 * i + c])));
    let pixels = numbers.as_chunks::<NUMBERS>().0;
    let squares = if header.grouped { &[][..] } else { pixels };
    let film = Film {
        width: header.width,
        height: header.height,
        spp: header.spp,
        pixels: pixels.iter().map(|n| Pixel { sum: [n[0], n[1], n[2]] }).collect(),
        squares: squares.iter().map(|n| SquareSums([n[3], n[4], n[5]])).collect(),
        groups: groups.as_chunks().0.iter().map(group).collect(),
        ..Film::default()
    };
    Some(Checkpoint { settings: header.settings, seconds: header.seconds, film })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Crop, Sampler};

    #[test]
    fn a_film_comes_back_bit_for_bit_and_damage_is_seen() {
        for sampler in Sampler::ALL {
            comes_back(*sampler);
        }
    }

    fn comes_back(sampler: Sampler) {
        let mut film = Film::of_sampler(Crop { x: 0, y: 0, width: 3, height: 2 }, sampler);
        film.spp = 5;
        for i in 0..6 {
            assert!(film.add(i, i as u32, [i as f32 / 3.0, 1e-30, 1e30]));
        }
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.exr.unfinished");
        let settings = vec![("seed".to_owned(), "7".to_owned()), ("scene".to_owned(), "a\nb\"c".to_owned())];
        write(&path, &Checkpoint { settings: settings.clone(), seconds: 1.25, film: film.clone() }).unwrap();
        let found = read(&path).unwrap();
        assert_eq!((found.film.pixels, found.film.spp, found.seconds), (film.pixels, 5, 1.25));
        assert_eq!((found.film.squares, found.film.groups), (film.squares, film.groups));
        assert_eq!(found.settings, settings);
        let bytes = std::fs::read(&path).unwrap();
        for damaged in [&bytes[..bytes.len() - 1], &bytes[1..], b"", b"text", &[&bytes[..], &[0]].concat()] {
            std::fs::write(&path, damaged).unwrap();
            assert!(read(&path).unwrap_err().to_string().contains("delete it to start anew"));
        }
    }
}
