//! `octray diff`: how far one image is from another.

use crate::cli::examples;
use crate::cli::numbers::{percent, scientific};
use crate::cli::output::{JsonArgs, aligned_in, check_place, columns, make_directory, wrapped};
use crate::cli::places;
use crate::cli::{warn, warn_of};
use crate::error::{Error, Result};
use crate::image::{Bounds, Format, Image, check_output_path};
use crate::report::measure::flip;
use crate::report::measure::metrics::{Fault, Metrics, compare, relative_errors};
use crate::report::write::heatmap::{Canvas, Scale};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Printed below the flags.
const DEFINITIONS: &str = "\
Sums run over all pixels and channels, in linear Rec.709. mse: mean of (a-b)^2; relmse: mean of (a-b)^2 / (b^2 + 0.01); \
relative error: root of relmse; psnr: -10 log10 of the mean squared difference of what a PNG shows (exposure 0, cut to [0, 1], \
sRGB), in dB; flip: mean HDR-FLIP at 67 pixels a degree; mape: mean of |a-b| / (|b| + 0.01); bias_z: difference of the mean values over its standard \
error, from the variance layers of EXR files. If B has such layers, its noise is subtracted from mse and relmse, since A and B \
are taken to have samples of their own. PNG files are decoded from sRGB; what they were rounded to and cut at counts as error. \
Of crops in EXR files the pixels that both have are compared.";

/// Flags of `octray diff`.
#[derive(clap::Args)]
#[command(after_help = format!("{DEFINITIONS}\n\n{}", examples::DIFF))]
pub struct DiffArgs {
    /// The image to judge: .exr, .pfm, .hdr or .png
    a: PathBuf,
    /// The reference
    b: PathBuf,
    /// Write the relative error of every pixel as an image: viridis, logarithmic, with its scale beside it
    #[arg(long, value_name = "FILE.png")]
    heatmap: Option<PathBuf>,
    #[command(flatten)]
    json: JsonArgs,
}

/// Runs the command; the exit status.
pub fn run(args: &DiffArgs) -> Result<u8> {
    args.json.check()?;
    if let Some(path) = &args.heatmap {
        check_heatmap_path(path)?;
    }
    let (mut a, mut b) = places::reading(|| Ok((Image::read(&args.a)?, Image::read(&args.b)?)))?;
    for (path, image) in [(&args.a, &a), (&args.b, &b)] {
        warn_of(&path.display(), image);
    }
    let windows = a.windows.is_some() || b.windows.is_some();
    let area = if windows { overlap(args, &a, &b)? } else { a.data() };
    if windows {
        (a, b) = (a.part(area), b.part(area));
    }
    let metrics = compare(&a, &b).map_err(|fault| explain(shifted(fault, area), &args.a, &args.b))?;
    let mut conversions = conversions([&args.a, &args.b]);
    // Two PNGs alike may be meant; beside linear data a PNG is mostly a slip. (The text says it in any case.)
    if let ([conversion], true) = (&conversions[..], args.json.to_standard_output()) {
        warn(conversion);
    }
    conversions.dedup();
    let heatmap = match &args.heatmap {
        Some(path) => Some(draw(path, &a, &b)?),
        None => None,
    };
    let corners = |of: Bounds| [i64::from(of.x), i64::from(of.y), i64::from(of.width), i64::from(of.height)];
    let found = Found {
        metrics,
        relative_error: metrics.relmse.sqrt(),
        flip: flip::mean(&flip::hdr(&a, &b, flip::PIXELS_PER_DEGREE)),
        identical: a.pixels == b.pixels,
        compared: corners(area),
        display_window: corners(a.display()),
        conversions,
        heatmap,
    };
    args.json.deliver(&found, || {
        let Bounds { x, y, width, height } = area;
        let of = a.display();
        let place = match windows {
            true => format!(
                "compared: the {width} x {height} pixels at {x},{y} that both have, of a display window of {} x {}",
                of.width, of.height
            ),
            false => format!("compared: {width} x {height} pixels"),
        };
        format!("{place}\n{}", text(&found, columns()))
    })?;
    Ok(0)
}

/// What decoding has done to each of these files that is no linear data.
fn conversions(paths: [&PathBuf; 2]) -> Vec<String> {
    let png = |path: &&PathBuf| matches!(Format::of(path), Ok(Format::Png));
    let sentence = |path: &PathBuf| {
        let bits = png_bits(path).map_or(String::new(), |bits| format!("{bits}-bit "));
        let rounded = png_bits(path).map_or(String::new(), |bits| format!("rounded to {bits} bits and "));
        format!(
            "{}: decoded from {bits}sRGB to linear; it was {rounded}cut at white, which counts as error (.exr and .pfm hold \
             radiance whole)",
            path.display()
        )
    };
    paths.into_iter().filter(png).map(sentence).collect()
}

/// Bits a channel, as the header of a PNG says.
fn png_bits(path: &Path) -> Option<u8> {
    // PNG, third edition, section 11.2.1: the signature, length and name of the first chunk, width, height, then the depth.
    const DEPTH: usize = 8 + 8 + 8;
    let mut header = [0; DEPTH + 1];
    File::open(path).and_then(|mut file| file.read_exact(&mut header)).ok()?;
    Some(header[DEPTH])
}

/// Draws the heatmap.
fn draw(path: &Path, a: &Image, b: &Image) -> Result<Heatmap> {
    let errors = relative_errors(a, b);
    let scale = Scale::fitting(&errors);
    make_directory(path)?;
    Canvas::with_legend(&errors, a.width, scale).save(path)?;
    let [darkest, brightest] = [scale.low, scale.high].map(|exponent| 10f64.powi(exponent));
    Ok(Heatmap { file: path.display().to_string(), darkest, brightest })
}

/// What is printed as JSON. Rectangles are x, y, width, height.
#[derive(serde::Serialize)]
struct Found {
    #[serde(flatten)]
    metrics: Metrics,
    /// Root of `relmse`.
    relative_error: f64,
    /// Mean HDR-FLIP, 67 pixels a degree.
    flip: f64,
    /// Every pixel is the same: there is no noise to subtract.
    identical: bool,
    /// The pixels compared: where both data windows overlap.
    compared: [i64; 4],
    /// What both images are to show; of renders, the whole film.
    display_window: [i64; 4],
    /// What was decoded into linear data, a sentence a file.
    conversions: Vec<String>,
    /// The heatmap, if one was asked for.
    heatmap: Option<Heatmap>,
}

/// A heatmap and the ends of its scale.
#[derive(serde::Serialize)]
struct Heatmap {
    file: String,
    /// The relative error that the darkest colour stands for, and all below it.
    darkest: f64,
    /// That of the brightest, and all above it.
    brightest: f64,
}

/// Where the data windows of `a` and `b` overlap, which have one display window.
fn overlap(args: &DiffArgs, a: &Image, b: &Image) -> Result<Bounds> {
    let bounds = |of: Bounds| format!("{} x {} at {},{}", of.width, of.height, of.x, of.y);
    let (name_a, name_b) = (args.a.display(), args.b.display());
    if a.display() != b.display() {
        return Err(Error::Usage(format!(
            "{name_a} has a display window of {} and {name_b} one of {}: only images of one film can be compared",
            bounds(a.display()),
            bounds(b.display())
        )));
    }
    a.data().overlap(&b.data()).ok_or_else(|| {
        Error::Usage(format!(
            "{name_a} holds {} of the film and {name_b} {}: they have no pixel in common",
            bounds(a.data()),
            bounds(b.data())
        ))
    })
}

/// `fault` with the pixel as the files count it, where images were cut to `area`.
fn shifted(fault: Fault, area: Bounds) -> Fault {
    match fault {
        Fault::Value { in_b, in_variance, x, y, value } => {
            let (x, y) = (x.wrapping_add_signed(area.x), y.wrapping_add_signed(area.y));
            Fault::Value { in_b, in_variance, x, y, value }
        }
        other => other,
    }
}

fn check_heatmap_path(path: &Path) -> Result<()> {
    match Format::of(path) {
        Ok(Format::Png) => check_place(path, |path| check_output_path(path)).and_then(|()| places::claim(path)),
        _ => Err(Error::Usage(format!("--heatmap {}: a heatmap is a PNG; name a .png file", path.display()))),
    }
}

/// Why the images in the files `a` and `b` cannot be compared.
pub fn explain(fault: Fault, a: &Path, b: &Path) -> Error {
    match fault {
        Fault::Size((w, h), (other_w, other_h)) => Error::Usage(format!(
            "{} has {w} x {h} pixels and {} has {other_w} x {other_h}: only images of one size can be compared",
            a.display(),
            b.display()
        )),
        Fault::Empty => Error::parse(a, None, "the image has no pixels"),
        Fault::Value { in_b, in_variance, x, y, value: [r, g, bl] } => {
            let (layer, rule) = match in_variance {
                true => ("variance", "a variance must be finite and at least 0"),
                false => ("value", "every value must be finite; render it again or mend that pixel"),
            };
            let message = format!("the {layer} of pixel {x},{y} is ({r}, {g}, {bl}): {rule}");
            Error::parse(if in_b { b } else { a }, None, message)
        }
    }
}

/// A line of the table.
struct Line {
    name: &'static str,
    value: String,
    /// The value before the reference's noise was subtracted, where that was.
    with_noise: String,
    meaning: String,
}

impl Line {
    fn new(name: &'static str, value: f64, meaning: impl Into<String>) -> Line {
        Line { name, value: scientific(value), with_noise: String::new(), meaning: meaning.into() }
    }

    /// The line with its value before the subtraction.
    fn before(mut self, value: f64) -> Line {
        self.with_noise = scientific(value);
        self
    }
}

/// All that is measured. One more measure is one more line.
fn lines(found: &Found) -> Vec<Line> {
    let m = &found.metrics;
    let bias = "mean of a - b";
    let (bias, bias_z) = match (m.bias_se, m.bias_z) {
        _ if found.identical => (bias.to_owned(), Line::new("bias_z", 0.0, "bias over its standard error")),
        (Some(se), Some(z)) => (
            format!("{bias}; its standard error is {}", scientific(se)),
            Line::new("bias_z", z, "bias over its standard error; noise alone stays within 3"),
        ),
        (se, _) => {
            let needs = "needs variance layers, as EXR files of renders have them";
            let line =
                Line::new("bias_z", 0.0, if se.is_some() { "the variance layers are 0 everywhere" } else { needs });
            (bias.to_owned(), Line { value: "-".to_owned(), ..line })
        }
    };
    let mean = |name, [r, g, b]: [f64; 3]| {
        let channels = [r, g, b].map(scientific).join(" ");
        Line::new(name, (r + g + b) / 3.0, format!("{channels} in red, green, blue"))
    };
    let psnr = "dB, of sRGB values in [0, 1]";
    let relative = format!("root of relmse: {}", percent(found.relative_error));
    vec![
        Line::new("mse", m.mse, "mean of (a - b)^2").before(m.mse_raw),
        Line::new("rmse", m.rmse, "root of mse").before(m.mse_raw.sqrt()),
        Line::new("relmse", m.relmse, "mean of (a - b)^2 / (b^2 + 0.01)").before(m.relmse_raw),
        Line::new("relative error", found.relative_error, relative).before(m.relmse_raw.sqrt()),
        Line { value: m.psnr.map_or("-".to_owned(), scientific), ..Line::new("psnr", 0.0, psnr) },
        Line::new("flip", found.flip, "HDR-FLIP, 67 pixels a degree: 0 no visible difference, 1 the largest"),
        Line::new("mape", m.mape, "mean of |a - b| / (|b| + 0.01)"),
        Line::new("bias", m.bias, bias),
        bias_z,
        mean("mean_a", m.mean_a),
        mean("mean_b", m.mean_b),
    ]
}

fn text(found: &Found, columns: usize) -> String {
    let m = &found.metrics;
    let subtracted = m.noise_mse > 0.0 && !found.identical;
    let mut rows = vec![["measure", "value", "with noise", "meaning"].map(str::to_owned).to_vec()];
    rows.extend(lines(found).into_iter().map(|line| vec![line.name.into(), line.value, line.with_noise, line.meaning]));
    if !subtracted {
        rows.iter_mut().for_each(|row| drop(row.remove(2)));
    }
    let mut notes = Vec::new();
    if found.identical {
        notes.push("The images are the same, pixel by pixel.".to_owned());
    }
    if subtracted {
        notes.push(format!(
            "With noise: before that of the reference, {} of mse and {} of relmse by its variance layers, was subtracted.",
            scientific(m.noise_mse),
            scientific(m.noise_relmse)
        ));
        if m.mse_raw < m.noise_mse || m.relmse_raw < m.noise_relmse {
            notes.push(
                "They differ by less than that noise: they may share samples, and then the figures with noise are right."
                    .to_owned(),
            );
        }
    }
    notes.extend(found.conversions.iter().cloned());
    if let Some(Heatmap { file, darkest, brightest }) = &found.heatmap {
        notes.push(format!(
            "{file}: the relative error of every pixel, from {} and less (dark violet) to {} and more (yellow), logarithmic; \
             the scale stands at its right.",
            percent(*darkest),
            percent(*brightest)
        ));
    }
    let notes: String = notes.iter().map(|note| wrapped(note, columns - 2, 2) + "\n").collect();
    aligned_in(&rows, if subtracted { &[1, 2] } else { &[1] }, columns) + &notes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(a: [f32; 3], b: [f32; 3], variance: Option<[f32; 3]>) -> Found {
        let image = |pixel| Image { width: 1, height: 1, pixels: vec![pixel], ..Image::default() };
        let (a, mut b) = (image(a), image(b));
        b.variance = variance.map(|variance| vec![variance]);
        let metrics = compare(&a, &b).unwrap();
        Found {
            metrics,
            relative_error: metrics.relmse.sqrt(),
            flip: flip::mean(&flip::hdr(&a, &b, flip::PIXELS_PER_DEGREE)),
            identical: a == b || a.pixels == b.pixels,
            compared: [0, 0, 1, 1],
            display_window: [0, 0, 1, 1],
            conversions: Vec::new(),
            heatmap: None,
        }
    }

    #[test]
    fn every_value_has_one_format_and_stands_in_one_column() {
        for (a, b) in [([1.5; 3], [1.0; 3]), ([1e-20; 3], [1e9, 0.0, 3.0]), ([0.5, 0.25, 0.0], [0.5, 0.5, 1.0])] {
            for variance in [None, Some([1e-3; 3])] {
                let text = text(&found(a, b, variance), 120);
                let table: Vec<&str> = text.lines().take(10).collect();
                let end = table[0].find("value").unwrap() + "value".len();
                for line in &table[1..] {
                    let value = &line[..end];
                    assert!(
                        value.ends_with('-') || value.rsplit(' ').next().is_some_and(|v| v.contains("e")),
                        "{text}"
                    );
                    assert!(line[end..].starts_with("  ") && line.len() <= 120, "{text}");
                }
                assert_eq!(text.contains("with noise"), variance.is_some(), "{text}");
            }
        }
    }

    #[test]
    fn equal_images_have_no_noise_to_speak_of() {
        let text = text(&found([0.5; 3], [0.5; 3], Some([0.1; 3])), 120);
        assert!(text.contains("The images are the same") && !text.contains("noise"), "{text}");
        assert!(text.contains("\nmse             0.000e+00  mean") && !text.contains("standard error is"), "{text}");
    }

    #[test]
    fn less_difference_than_noise_is_told() {
        let shared = text(&found([0.5; 3], [0.51; 3], Some([0.1; 3])), 120);
        assert!(shared.contains("they may share samples"), "{shared}");
        let apart = text(&found([0.5; 3], [2.0; 3], Some([0.1; 3])), 120);
        assert!(!apart.contains("they may share samples"), "{apart}");
    }
}
