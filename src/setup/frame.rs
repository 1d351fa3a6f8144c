//! The film of a render and the part of it that is rendered, resolved in one place.

use crate::error::Error;
use crate::settings::{Crop, MAX_FILM_PIXELS, MAX_FILM_SIDE, Settings};

/// A film and the part of it to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Size of the whole film (width, height).
    pub film: (u32, u32),
    /// The part that is rendered.
    pub crop: Crop,
}

impl Frame {
    /// What `settings` ask for, for a scene whose own film is `scene_film` (width, height).
    ///
    /// # Errors
    /// [`Error::Usage`] if the film has too many columns or rows or none, if the crop is empty or leaves the film, or if
    /// there are more pixels than a render may hold.
    pub fn new(settings: &Settings, scene_film: (u32, u32)) -> Result<Frame, Error> {
        let (width, height) = film_size(settings, scene_film)?;
        let frame = Frame::nearest(settings, scene_film);
        let crop = settings.crop.unwrap_or(frame.crop);
        if crop != frame.crop {
            return Err(Error::Usage(format!(
                "crop {},{},{},{} does not lie in the film of {width} x {height} pixels: X + W and Y + H must not \
                 exceed it, W and H must be at least 1",
                crop.x, crop.y, crop.width, crop.height
            )));
        }
        if crop.width as u64 * crop.height as u64 > MAX_FILM_PIXELS {
            return Err(Error::Usage(format!(
                "{} x {} pixels are more than one render may hold ({MAX_FILM_PIXELS}); render it in crops",
                crop.width, crop.height
            )));
        }
        Ok(frame)
    }

    /// The frame that exists and comes nearest to what `settings` ask for: sizes and crop are cut to what is possible.
    pub fn nearest(settings: &Settings, scene_film: (u32, u32)) -> Frame {
        let (width, height) = wanted(settings, scene_film);
        let (width, height) = (width.clamp(1, MAX_FILM_SIDE), height.clamp(1, MAX_FILM_SIDE));
        let crop = settings.crop.unwrap_or(Crop { x: 0, y: 0, width, height });
        let (x, y) = (crop.x.min(width - 1), crop.y.min(height - 1));
        let crop = Crop { x, y, width: crop.width.clamp(1, width - x), height: crop.height.clamp(1, height - y) };
        Frame { film: (width, height), crop }
    }
}

fn wanted(settings: &Settings, scene_film: (u32, u32)) -> (u32, u32) {
    (settings.width.unwrap_or(scene_film.0), settings.height.unwrap_or(scene_film.1))
}

/// The film's size for a scene whose own film is `scene_film`.
///
/// # Errors
/// [`Error::Usage`] if it has too many columns or rows, or none.
pub fn film_size(settings: &Settings, scene_film: (u32, u32)) -> Result<(u32, u32), Error> {
    let (width, height) = wanted(settings, scene_film);
    if !(1..=MAX_FILM_SIDE).contains(&width) || !(1..=MAX_FILM_SIDE).contains(&height) {
        return Err(Error::Usage(format!(
            "a film of {width} x {height} pixels: width and height must be between 1 and {MAX_FILM_SIDE}"
        )));
    }
    Ok((width, height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crop_must_lie_in_the_film() {
        let crop = |x, y, width, height| Settings { crop: Some(Crop { x, y, width, height }), ..Settings::default() };
        let film = (8, 4);
        let whole = Crop { x: 0, y: 0, width: 8, height: 4 };
        assert_eq!(Frame::new(&Settings::default(), film).unwrap(), Frame { film, crop: whole });
        assert!(Frame::new(&crop(7, 3, 1, 1), film).is_ok());
        for settings in [crop(8, 0, 1, 1), crop(0, 4, 1, 1), crop(0, 0, 0, 1), crop(u32::MAX, 0, u32::MAX, 1)] {
            assert!(Frame::new(&settings, film).unwrap_err().to_string().contains("film of 8 x 4"));
        }
        assert!(Frame::new(&crop(8, 0, 1, 1), (9, 1)).is_ok());
        assert!(Frame::new(&Settings { width: Some(0), ..Settings::default() }, film).is_err());
        assert!(Frame::new(&Settings::default(), (65_535, 65_535)).is_err());
    }
}
