//! Image files: what is written comes back, the right way up, with the same bytes each time, whole or not at all.

use octray::Crop;
use octray::internal::film::Film;
use octray::internal::image::{Image, check_output_path};
use std::fs;
use std::path::Path;

/// A film whose every pixel, channel and sample is different, over a wide range.
fn film(width: u32, height: u32) -> Film {
    let mut film = Film::new(Crop { x: 0, y: 0, width, height });
    film.spp = 4;
    for index in 0..film.pixels.len() {
        for sample in 0..4 {
            let value = (index as f32 + 1.0) * 0.01 * (1.0 + 0.1 * sample as f32);
            assert!(film.add(index, sample, [value, value * value, 1.0 / value]));
        }
    }
    film.metadata = vec![("spp".into(), "4".into()), ("scene".into(), "Küche → hell.toml".into())];
    film
}

fn means(film: &Film) -> Vec<[f32; 3]> {
    (0..film.height).flat_map(|y| (0..film.width).map(move |x| film.mean(x, y))).collect()
}

fn names_in(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn pfm_and_exr_keep_every_bit() {
    let directory = tempfile::tempdir().unwrap();
    for (width, height) in [(1, 1), (7, 3), (64, 40)] {
        let film = film(width, height);
        for name in ["a.pfm", "a.exr", "a.EXR"] {
            let path = directory.path().join(name);
            film.save(&path).unwrap();
            let image = Image::read(&path).unwrap();
            assert_eq!((image.width, image.height), (width, height), "{name}");
            assert_eq!(image.pixels, means(&film), "{name}");
            assert_eq!(image.pixel(width - 1, 0), film.mean(width - 1, 0), "{name}");
        }
    }
}

#[test]
fn pfm_is_little_endian_and_stored_from_the_bottom_row_up() {
    let directory = tempfile::tempdir().unwrap();
    let film = film(2, 3);
    let path = directory.path().join("a.pfm");
    film.save(&path).unwrap();
    let bytes = fs::read(&path).unwrap();
    let header = b"PF\n2 3\n-1.0\n";
    assert!(bytes.starts_with(header));
    assert_eq!(bytes.len(), header.len() + 2 * 3 * 12);
    let value = |index: usize| f32::from_le_bytes(bytes[header.len() + 4 * index..][..4].try_into().unwrap());
    assert_eq!(value(0), film.mean(0, 2)[0]);
    assert_eq!(value(3 * 2 * 2 + 5), film.mean(1, 0)[2]);
}

#[test]
fn pfm_reads_both_byte_orders_and_grey() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.pfm");
    let mut bytes = b"Pf\n1 2\n1.0\n".to_vec();
    bytes.extend(2.5f32.to_be_bytes());
    bytes.extend(0.25f32.to_be_bytes());
    fs::write(&path, &bytes).unwrap();
    assert_eq!(Image::read(&path).unwrap().pixels, [[0.25; 3], [2.5; 3]]);
}

#[test]
fn exr_has_variance_of_the_mean_and_settings() {
    let directory = tempfile::tempdir().unwrap();
    let film = film(5, 4);
    let path = directory.path().join("a.exr");
    film.save(&path).unwrap();
    let image = Image::read(&path).unwrap();
    let variance = image.variance.expect("variance channels");
    assert_eq!(variance[2 * 5 + 3], film.variance(3, 2));
    assert!(variance.iter().flatten().all(|v| *v > 0.0));
    let expected = [("spp", "4"), ("scene", "Küche → hell.toml")];
    let expected = expected.map(|(key, value)| (key.to_owned(), value.to_owned()));
    assert_eq!(image.metadata, expected);
}

#[test]
fn png_holds_srgb_after_exposure_with_row_0_on_top() {
    let directory = tempfile::tempdir().unwrap();
    let mut film = Film::new(Crop { x: 0, y: 0, width: 2, height: 2 });
    film.spp = 1;
    film.add(0, 0, [0.5, 0.0, 4.0]);
    film.add(3, 0, [0.25, 0.002, 1.0]);
    let path = directory.path().join("a.png");
    let stored = |film: &Film| {
        film.save(&path).unwrap();
        image::open(&path).unwrap().into_rgb8().into_raw()
    };
    assert_eq!(stored(&film), [188, 0, 255, 0, 0, 0, 0, 0, 0, 137, 7, 255]);
    film.exposure = 1.0;
    assert_eq!(stored(&film)[9], 188);
    // Reading undoes the curve to within half a step.
    let back = Image::read(&path).unwrap();
    assert!((back.pixel(1, 1)[0] - 0.5).abs() < 0.004);
}

#[test]
fn hdr_is_within_half_a_mantissa_step_and_the_right_way_up() {
    let directory = tempfile::tempdir().unwrap();
    // Below 8 columns and above: readers take different paths for the two.
    for (width, height) in [(3, 2), (40, 30)] {
        let film = film(width, height);
        let path = directory.path().join("a.hdr");
        film.save(&path).unwrap();
        let image = Image::read(&path).unwrap();
        assert_eq!((image.width, image.height), (width, height));
        for (read, wrote) in image.pixels.iter().zip(means(&film)) {
            let largest = wrote.iter().copied().fold(0.0, f32::max);
            for c in 0..3 {
                assert!((read[c] - wrote[c]).abs() <= largest / 255.0, "{read:?} {wrote:?}");
            }
        }
    }
}

#[test]
fn the_same_film_gives_the_same_bytes() {
    let directory = tempfile::tempdir().unwrap();
    let film = film(20, 10);
    for extension in ["exr", "png", "hdr", "pfm"] {
        let [first, second] = ["a", "b"].map(|name| {
            let path = directory.path().join(name).with_extension(extension);
            film.save(&path).unwrap();
            fs::read(path).unwrap()
        });
        assert_eq!(first, second, "{extension}");
    }
}

#[test]
fn a_finished_file_replaces_the_old_one_and_leaves_nothing_beside_it() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.pfm");
    fs::write(&path, "old").unwrap();
    check_output_path(&path).unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old", "asking must not touch the file");
    film(4, 4).save(&path).unwrap();
    assert_eq!(names_in(directory.path()), ["a.pfm"]);
    assert_eq!(Image::read(&path).unwrap().width, 4);
}

#[test]
fn a_failing_write_keeps_the_old_file_and_leaves_nothing_beside_it() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.png");
    fs::write(&path, "old").unwrap();
    let error = octray::internal::files::atomic::write(&path, |out| {
        out.write_all(b"half a picture")?;
        Err(std::io::Error::other("the disk is on fire"))
    });
    let error = error.unwrap_err();
    assert!(error.to_string().contains("the disk is on fire") && error.to_string().contains("a.png"), "{error}");
    assert_eq!(error.exit_status(), 1);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(names_in(directory.path()), ["a.png"]);
}

#[test]
#[cfg(unix)]
fn links_are_followed_and_permissions_kept() {
    use std::os::unix::fs::PermissionsExt;
    let directory = tempfile::tempdir().unwrap();
    let (path, link) = (directory.path().join("real.pfm"), directory.path().join("link.pfm"));
    fs::write(&path, "old").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    std::os::unix::fs::symlink(&path, &link).unwrap();
    film(2, 2).save(&link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(Image::read(&path).unwrap().width, 2);
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
}

#[test]
fn a_place_that_cannot_be_written_is_found_before_rendering() {
    let directory = tempfile::tempdir().unwrap();
    fs::create_dir(directory.path().join("folder.png")).unwrap();
    fs::write(directory.path().join("file"), "").unwrap();
    for (name, status, message) in [
        ("a.jpg", 2, "unknown image extension `.jpg`; use .exr, .png, .hdr or .pfm"),
        ("a", 2, "no extension"),
        ("missing/a.png", 1, "does not exist; make it first"),
        ("file/a.png", 1, "is not a directory"),
        ("folder.png", 1, "it is a directory"),
    ] {
        let path = directory.path().join(name);
        let error = check_output_path(&path).unwrap_err();
        assert_eq!(error.exit_status(), status, "{name}");
        assert!(error.to_string().contains(message) && error.to_string().contains(name), "{error}");
    }
    assert_eq!(names_in(directory.path()), ["file", "folder.png"]);
}

#[test]
fn damaged_files_are_errors_that_name_the_file() {
    let directory = tempfile::tempdir().unwrap();
    for (name, bytes) in [
        ("a.pfm", &b"PF\n4294967295 4294967295\n-1.0\n"[..]),
        ("b.pfm", b"PF\n2 2\n0\n"),
        ("c.pfm", b"PF\n2"),
        ("d.pfm", b""),
        ("e.exr", b"\x76\x2f\x31\x01 nonsense"),
        ("f.hdr", b"#?RADIANCE\n\n-Y 5 +X 5\n"),
        ("g.png", b"not a png"),
    ] {
        let path = directory.path().join(name);
        fs::write(&path, bytes).unwrap();
        let error = Image::read(&path).unwrap_err();
        assert!(error.to_string().contains(name) && error.exit_status() == 2, "{error}");
    }
    assert!(Image::read(directory.path().join("none.exr")).unwrap_err().to_string().contains("cannot read"));
}
