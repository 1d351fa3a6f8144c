//! A film as it is, sums and all: what an interrupted render leaves behind so that it can go on.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::files::memory;
use crate::files::sealed::{self, Found, Numbers};
use crate::film::sums::{GroupSums, Pixel, SquareSums};
use crate::film::{Film, TileCounts};
use crate::sampler::sobol::GROUPS;

const MAGIC: &str = "octray unfinished render, version 3";

/// An unfinished render.
#[derive(Debug)]
pub struct Checkpoint {
    /// What decides the picture's bits, as (name, value).
    pub settings: Vec<(String, String)>,
    /// Wall seconds it has taken.
    pub seconds: f64,
    /// It has all the samples that were asked for.
    pub finished: bool,
    /// What it has come to.
    pub film: Film,
}

/// The numbers behind it: the sums of all pixels, then the sums of their squares, or those by group.
#[derive(Serialize, Deserialize)]
struct Header {
    settings: Vec<(String, String)>,
    seconds: f64,
    finished: bool,
    width: u32,
    height: u32,
    spp: u32,
    /// Of an uneven film, the tiles' columns and rows and the samples of each.
    uneven: Option<((u32, u32), Vec<u32>)>,
    /// Sums by group follow those of all samples.
    grouped: bool,
}

/// Writes `film`, which `settings` decide, to `path`, whole or not at all. It has taken `seconds`; `finished`: nothing is left to
/// do.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, settings: &[(String, String)], (seconds, finished): (f64, bool), film: &Film) -> Result<()> {
    let header = Header {
        settings: settings.to_vec(),
        seconds,
        finished,
        width: film.width,
        height: film.height,
        spp: film.spp,
        uneven: film.uneven.as_ref().map(|uneven| (uneven.tile, uneven.counts.clone())),
        grouped: !film.groups.is_empty(),
    };
    sealed::write(path, MAGIC, &header, |out| {
        film.pixels.iter().try_for_each(|pixel| out.numbers(&pixel.sum))?;
        film.squares.iter().try_for_each(|squares| out.numbers(&squares.0))?;
        film.groups.iter().try_for_each(|groups| out.numbers(groups.0.as_flattened()))
    })
}

/// Reads what [`write()`] has written.
///
/// # Errors
/// [`Error::Read`]; [`Error::Parse`] if it is not such a file, not a whole one or of another version; [`Error::Memory`].
pub fn read(path: &Path) -> Result<Checkpoint> {
    let fault = |message: &str| Error::parse(path, None, message);
    let damaged = || fault("not an unfinished render, or a damaged one; delete it to start anew");
    match sealed::open(path, MAGIC)? {
        Found::Damaged => Err(damaged()),
        Found::OtherVersion => Err(fault(
            "an unfinished render of another version of octray; finish it with that one, delete that file, or write to \
             another image",
        )),
        Found::Whole(header, mut numbers) => unfinished(header, &mut numbers)?.ok_or_else(damaged),
    }
}

/// `None` if the numbers, though they are what was written, are no film that a render could have left.
fn unfinished(header: Header, numbers: &mut Numbers) -> Result<Option<Checkpoint>> {
    let Header { settings, seconds, finished, width, height, spp, uneven, grouped } = header;
    let uneven = uneven.map(|(tile, counts)| TileCounts { tile, counts });
    let pixels = u64::from(width) * u64::from(height);
    let each = 3 + if grouped { 3 * u64::from(GROUPS) } else { 3 };
    let sound = pixels.checked_mul(each) == Some(numbers.left())
        && seconds >= 0.0
        && seconds.is_finite()
        && uneven.as_ref().map_or(spp > 0, |uneven| are_counts(uneven, (width, height), spp));
    let (true, Ok(count)) = (sound, usize::try_from(pixels)) else { return Ok(None) };
    let what = format!("an unfinished render of {width} x {height} pixels");
    let mut film = Film { width, height, spp, uneven, ..Film::default() };
    film.pixels = memory::reserved(count, &what)?;
    let (squares, groups) = if grouped { (0, count) } else { (count, 0) };
    film.squares = memory::reserved(squares, &what)?;
    film.groups = memory::reserved(groups, &what)?;
    // Sums of finite samples are finite, unless they are as bright as no scene may be.
    let mut finite = || numbers.array::<3>().filter(|sums| sums.iter().all(|sum| sum.is_finite()));
    for _ in 0..count {
        let Some(sum) = finite() else { return Ok(None) };
        film.pixels.push(Pixel { sum });
    }
    for _ in 0..squares {
        let Some(sums) = finite() else { return Ok(None) };
        film.squares.push(SquareSums(sums));
    }
    for _ in 0..groups {
        let mut sums = GroupSums::default();
        for group in &mut sums.0 {
            let Some(of_group) = finite() else { return Ok(None) };
            *group = of_group;
        }
        film.groups.push(sums);
    }
    Ok(Some(Checkpoint { settings, seconds, finished, film }))
}

/// Whether these are the counts of an uneven film of such a size, of which some pixels have `spp` samples and some have more.
fn are_counts(uneven: &TileCounts, film: (u32, u32), spp: u32) -> bool {
    let TileCounts { tile, counts } = uneven;
    if tile.0 == 0 || tile.1 == 0 {
        return false;
    }
    let (columns, rows) = TileCounts::grid(*tile, film);
    let (least, most) = (counts.iter().min(), counts.iter().max());
    counts.len() as u64 == u64::from(columns) * u64::from(rows) && least == Some(&spp) && most > least
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
        for uneven in [None, Some(TileCounts { tile: (2, 2), counts: vec![7, 5] })] {
            film.uneven = uneven;
            write(&path, &settings, (1.25, true), &film).unwrap();
            let found = read(&path).unwrap();
            assert_eq!((&found.film.pixels, found.film.spp, found.seconds), (&film.pixels, 5, 1.25));
            assert_eq!((&found.film.squares, &found.film.groups), (&film.squares, &film.groups));
            assert_eq!((found.settings, found.film.uneven), (settings.clone(), film.uneven.clone()));
            assert!(found.finished);
        }
        let bytes = std::fs::read(&path).unwrap();
        for damaged in [&bytes[..bytes.len() - 1], &bytes[1..], b"", b"text", &[&bytes[..], &[0]].concat()] {
            std::fs::write(&path, damaged).unwrap();
            assert!(read(&path).unwrap_err().to_string().contains("delete it to start anew"));
        }
        let older = String::from_utf8_lossy(&bytes[..MAGIC.len()]).replace('3', "2");
        let rest = &bytes[MAGIC.len()..bytes.len() - 8];
        let mut sum = sealed::Checksum::default();
        let older = [older.as_bytes(), rest].concat();
        sum.add(&older);
        std::fs::write(&path, [&older[..], &sum.value().to_le_bytes()].concat()).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("of another version of octray"));
    }

    /// What has a right checksum may still be made by somebody else.
    #[test]
    fn forged_files_are_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.unfinished");
        let forge = |change: fn(&mut Header), numbers: &[f64]| {
            let uneven = None;
            let (seconds, finished, grouped) = (1.0, false, false);
            let mut header =
                Header { settings: Vec::new(), seconds, finished, width: 2, height: 1, spp: 4, uneven, grouped };
            change(&mut header);
            sealed::write(&path, MAGIC, &header, |out| out.numbers(numbers)).unwrap();
            read(&path).map(|found| found.film.spp).map_err(|error| error.to_string())
        };
        let fine = [1.0; 12];
        assert_eq!(forge(|_| (), &fine), Ok(4));
        let mut not_finite = fine;
        not_finite[11] = f64::NAN;
        assert!(forge(|_| (), &not_finite).is_err());
        assert!(forge(|_| (), &fine[1..]).is_err());
        let changes: [fn(&mut Header); 9] = [
            |h| h.width = 3,
            |h| (h.width, h.height) = (u32::MAX, u32::MAX),
            |h| h.grouped = true,
            |h| h.spp = 0,
            |h| h.seconds = -1.0,
            |h| h.uneven = Some(((0, 1), vec![4, 5])),
            |h| h.uneven = Some(((1, 1), vec![4, 4])),
            |h| h.uneven = Some(((1, 1), vec![3, 5])),
            |h| h.uneven = Some(((1, 1), vec![4, 5, 6])),
        ];
        for change in changes {
            let refused = forge(change, &fine).unwrap_err();
            assert!(refused.contains("delete it to start anew"), "{refused}");
        }
        assert_eq!(forge(|h| h.uneven = Some(((1, 1), vec![4, 5])), &fine), Ok(4));
    }
}
