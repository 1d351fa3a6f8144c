//! FLIP against the authors' own program, version 1.7 (`flip-evaluator` of the Python package index), on pairs made of
//! integers.

use super::*;

use Kind::{Hdr, Ldr};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Ldr,
    Hdr,
}

/// A number in 0..=256 that looks random.
fn noise(x: u32, y: u32, c: u32, seed: u32) -> f32 {
    ((x * 1_103 + y * 12_289 + c * 31 + seed * 7_919) * (x * y + 7 * x + 13 * y + c + seed + 1) % 257) as f32
}

fn image(width: u32, height: u32, value: impl Fn(u32, u32, u32) -> f32) -> Image {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let pixels = places.map(|(x, y)| [0, 1, 2].map(|c| value(x, y, c))).collect();
    Image { width, height, pixels, ..Image::default() }
}

type Value = Box<dyn Fn(u32, u32, u32) -> f32>;

/// The pair of this name: (reference, test).
fn pair(name: &str) -> (Image, Image) {
    let steps = |x: u32| 2.0f32.powi(x as i32 / 2 - 9);
    let spark = |level: f32, spark: f32| level % 4.0 + if spark == 0.0 { 4_001.0 } else { 1.0 };
    let (width, height, reference, test): (u32, u32, Value, Value) = match name {
        "noise" => {
            (23, 17, Box::new(|x, y, c| noise(x, y, c, 1) / 256.0), Box::new(|x, y, c| noise(x, y, c, 2) / 256.0))
        }
        "weak noise" => {
            let ramp = |x, y, c| (x + 2 * y + 9 * c + 20) as f32;
            let noisy = move |x, y, c| (ramp(x, y, c) + noise(x, y, c, 3) % 9.0) / 256.0;
            (40, 31, Box::new(move |x, y, c| ramp(x, y, c) / 256.0), Box::new(noisy))
        }
        "identical" => {
            (19, 5, Box::new(|x, y, c| noise(x, y, c, 4) / 256.0), Box::new(|x, y, c| noise(x, y, c, 4) / 256.0))
        }
        "impulse" => {
            let point = |x, y, _| if (x, y) == (16, 14) { 1.0 } else { 0.25 };
            (33, 29, Box::new(|_, _, _| 0.25), Box::new(point))
        }
        "corner" => {
            let point = |x, y, c: u32| if (x, y) == (0, 26) { [1.0, 0.0, 0.5][c as usize] } else { 0.25 };
            (25, 27, Box::new(|_, _, _| 0.25), Box::new(point))
        }
        "edge" => {
            let edge = |at: u32| move |x, _, _| if x >= at { 200.0 / 256.0 } else { 20.0 / 256.0 };
            (30, 22, Box::new(edge(15)), Box::new(edge(16)))
        }
        "black" => (21, 13, Box::new(|_, _, _| 0.0), Box::new(|x, y, c| noise(x, y, c, 5) / 256.0)),
        "turned black" => (21, 13, Box::new(|x, y, c| (noise(x, y, c, 5) + 1.0) / 256.0), Box::new(|_, _, _| 0.0)),
        "green blue" => (9, 8, Box::new(|_, _, c| (c == 1) as u8 as f32), Box::new(|_, _, c| (c == 2) as u8 as f32)),
        "one pixel" => {
            let linear = |slope: u32, start: u32| move |_, _, c| (slope * c + start) as f32 / 256.0;
            (1, 1, Box::new(linear(40, 50)), Box::new(linear(10, 90)))
        }
        "column" => {
            let noisy = |_, y, c| ((5 * y + c) as f32 + noise(0, y, c, 6) % 17.0) / 256.0;
            (1, 37, Box::new(|_, y, c| (5 * y + c) as f32 / 256.0), Box::new(noisy))
        }
        "sparks" => {
            let sparks = move |a, b| move |x, y, c| spark(noise(x, y, c, a), noise(x, y, 0, b)) / 16.0;
            (47, 35, Box::new(sparks(7, 8)), Box::new(sparks(9, 10)))
        }
        "range" => {
            let exact = move |x, c| steps(x) * (3 + c) as f32 / 4.0;
            let noisy = move |x, y, c| exact(x, c) * (200.0 + noise(x, y, c, 11) % 100.0) / 256.0;
            (38, 26, Box::new(move |x, _, c| exact(x, c)), Box::new(noisy))
        }
        "half black" => {
            let rows = |count: u32| move |x, y, c| if y < count { (noise(x, y, c, 12) + 1.0) / 256.0 } else { 0.0 };
            (31, 24, Box::new(rows(6)), Box::new(rows(7)))
        }
        _ => unreachable!("a pair of this name"),
    };
    (image(width, height, reference), image(width, height, test))
}

/// What the authors' program finds: the mean, and the pixels (0, 0), (w - 1, h - 1), (w / 2, h / 2), (w / 3, h - 1).
#[rustfmt::skip]
const AUTHORS: [(&str, Kind, f64, f64, [f64; 4]); 33] = [
    ("noise", Ldr, PIXELS_PER_DEGREE, 0.396707, [0.668725, 0.655352, 0.475556, 0.519520]),
    ("noise", Hdr, PIXELS_PER_DEGREE, 0.356037, [0.557223, 0.593424, 0.423381, 0.457210]),
    ("weak noise", Ldr, PIXELS_PER_DEGREE, 0.086266, [0.179045, 0.072164, 0.092946, 0.094261]),
    ("weak noise", Hdr, PIXELS_PER_DEGREE, 0.065676, [0.252575, 0.029405, 0.060762, 0.046057]),
    ("identical", Ldr, PIXELS_PER_DEGREE, 0.000000, [0.000000, 0.000000, 0.000000, 0.000000]),
    ("identical", Hdr, PIXELS_PER_DEGREE, 0.000000, [0.000000, 0.000000, 0.000000, 0.000000]),
    ("impulse", Ldr, PIXELS_PER_DEGREE, 0.004122, [0.000000, 0.000000, 0.351878, 0.000000]),
    ("impulse", Hdr, PIXELS_PER_DEGREE, 0.000675, [0.000000, 0.000000, 0.065286, 0.000000]),
    ("corner", Ldr, PIXELS_PER_DEGREE, 0.005854, [0.000000, 0.000000, 0.000000, 0.007560]),
    ("corner", Hdr, PIXELS_PER_DEGREE, 0.014809, [0.000000, 0.000000, 0.000000, 0.018885]),
    ("edge", Ldr, PIXELS_PER_DEGREE, 0.076045, [0.000000, 0.000000, 0.448259, 0.002293]),
    ("edge", Hdr, PIXELS_PER_DEGREE, 0.066280, [0.000000, 0.000000, 0.399618, 0.001624]),
    ("black", Ldr, PIXELS_PER_DEGREE, 0.970545, [0.975307, 0.977172, 0.967302, 0.973817]),
    ("turned black", Ldr, PIXELS_PER_DEGREE, 0.970611, [0.975362, 0.977226, 0.967369, 0.973870]),
    ("turned black", Hdr, PIXELS_PER_DEGREE, 0.972987, [0.974983, 0.983407, 0.972587, 0.974760]),
    ("green blue", Ldr, PIXELS_PER_DEGREE, 1.000000, [1.000000, 1.000000, 1.000000, 1.000000]),
    ("green blue", Hdr, PIXELS_PER_DEGREE, 0.996167, [0.996167, 0.996167, 0.996167, 0.996167]),
    ("one pixel", Ldr, PIXELS_PER_DEGREE, 0.358447, [0.358447, 0.358447, 0.358447, 0.358447]),
    ("one pixel", Hdr, PIXELS_PER_DEGREE, 0.212327, [0.212327, 0.212327, 0.212327, 0.212327]),
    ("column", Ldr, PIXELS_PER_DEGREE, 0.169063, [0.317127, 0.172649, 0.186904, 0.172649]),
    ("column", Hdr, PIXELS_PER_DEGREE, 0.171216, [0.583446, 0.053812, 0.131368, 0.053812]),
    ("sparks", Ldr, PIXELS_PER_DEGREE, 0.228336, [0.245213, 0.243722, 0.251317, 0.558096]),
    ("sparks", Hdr, PIXELS_PER_DEGREE, 0.358016, [0.302385, 0.339730, 0.359494, 0.893621]),
    ("range", Ldr, PIXELS_PER_DEGREE, 0.046383, [0.013646, 0.000000, 0.118599, 0.081148]),
    ("range", Hdr, PIXELS_PER_DEGREE, 0.091141, [0.007058, 0.117120, 0.093180, 0.103340]),
    ("half black", Ldr, PIXELS_PER_DEGREE, 0.130912, [0.043917, 0.000000, 0.009573, 0.000000]),
    ("half black", Hdr, PIXELS_PER_DEGREE, 0.151439, [0.035815, 0.000000, 0.023311, 0.000000]),
    ("noise", Ldr, 30.0, 0.661258, [0.551391, 0.963007, 0.963606, 0.967054]),
    ("noise", Hdr, 30.0, 0.578946, [0.466417, 0.817705, 0.814375, 0.858354]),
    ("edge", Ldr, 120.0, 0.091531, [0.000000, 0.000000, 0.295427, 0.105260]),
    ("sparks", Hdr, 20.0, 0.683325, [0.594757, 0.529225, 0.704065, 0.795982]),
    ("weak noise", Ldr, 7.0, 0.132038, [0.209881, 0.128368, 0.111586, 0.141919]),
    ("range", Hdr, 100.0, 0.085092, [0.011120, 0.120655, 0.081202, 0.095165]),
];

#[test]
fn figures_are_those_of_the_authors_program() {
    for (name, kind, pixels_per_degree, expected_mean, expected) in AUTHORS {
        let (reference, test) = pair(name);
        let errors = match kind {
            Ldr => ldr(&test, &reference, 0.0, pixels_per_degree),
            Hdr => hdr(&test, &reference, pixels_per_degree),
        };
        let (width, height) = (reference.width as usize, reference.height as usize);
        let places = [(0, 0), (width - 1, height - 1), (width / 2, height / 2), (width / 3, height - 1)];
        let found = places.map(|(x, y)| errors[y * width + x]);
        let pixels_off = (0..4).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
        let mean_off = (mean(&errors) - expected_mean).abs();
        // In f32 the derivative filters find edges of 1e-8 of a flat area's brightness, and the root in the difference
        // of features makes 1e-4 of that: two flat areas of different brightness are no closer.
        let (mean_bound, pixel_bound) = match name {
            "edge" | "one pixel" => (1e-4, 1e-4),
            _ => (3e-6, 4e-6),
        };
        assert!(mean_off < mean_bound && pixels_off < pixel_bound, "{name} {kind:?}: {} {found:?}", mean(&errors));
    }
}

#[test]
fn an_exposure_is_a_factor_before_the_cut() {
    let (reference, test) = pair("sparks");
    let brighter = |image: &Image| image_of(image, |v| v * 4.0);
    let found = ldr(&test, &reference, 2.0, PIXELS_PER_DEGREE);
    assert_eq!(found, ldr(&brighter(&test), &brighter(&reference), 0.0, PIXELS_PER_DEGREE));
    // HDR chooses its exposures: a factor on both images, here a power of two, moves the range alone.
    let (found, scaled) =
        (hdr(&test, &reference, PIXELS_PER_DEGREE), hdr(&brighter(&test), &brighter(&reference), PIXELS_PER_DEGREE));
    assert!(found.iter().zip(&scaled).all(|(a, b)| (a - b).abs() < 1e-9));
}

fn image_of(image: &Image, change: impl Fn(f32) -> f32) -> Image {
    Image { pixels: image.pixels.iter().map(|pixel| pixel.map(&change)).collect(), ..image.clone() }
}

#[test]
fn errors_are_shares_and_symmetric_in_ldr() {
    for name in ["noise", "weak noise", "impulse", "corner", "edge", "black", "green blue", "one pixel", "column"] {
        let (reference, test) = pair(name);
        for pixels_per_degree in [0.5, 5.0, 67.0, 200.0] {
            let errors = ldr(&test, &reference, 0.0, pixels_per_degree);
            assert!(errors.iter().all(|error| (0.0..=1.0 + 1e-12).contains(error)), "{name}");
            assert_eq!(errors, ldr(&reference, &test, 0.0, pixels_per_degree), "{name}");
            let same = ldr(&test, &test, 0.0, pixels_per_degree);
            assert!(same.iter().all(|error| *error == 0.0), "{name}");
        }
    }
}

#[test]
fn black_references_and_negative_values_give_finite_figures() {
    let (black, test) = pair("black");
    let errors = hdr(&test, &black, PIXELS_PER_DEGREE);
    assert!(mean(&errors) > 0.9 && errors.iter().all(|error| error.is_finite()));
    assert_eq!(mean(&hdr(&black, &black, PIXELS_PER_DEGREE)), 0.0);
    let below = image_of(&test, |v| v - 0.5);
    assert_eq!(hdr(&below, &test, 67.0), hdr(&image_of(&below, |v| v.max(0.0)), &test, 67.0));
    assert_eq!(ldr(&below, &test, 0.0, 67.0), ldr(&image_of(&below, |v| v.max(0.0)), &test, 0.0, 67.0));
    let huge = image_of(&test, |_| f32::MAX);
    assert!(hdr(&huge, &test, 67.0).iter().chain(&hdr(&test, &huge, 67.0)).all(|error| error.is_finite()));
    assert!(ldr(&Image::default(), &Image::default(), 0.0, 67.0).is_empty());
    assert_eq!(mean(&[]), 0.0);
}
