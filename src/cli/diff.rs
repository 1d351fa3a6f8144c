//! `octray diff`: how far one picture is from another.

use crate::cli::output::{JsonArgs, check_place, make_directory, table};
use crate::cli::warn;
use crate::error::{Error, Result};
use crate::image::{Bounds, Format, Image, check_output_path};
use crate::report::measure::metrics::{Fault, Metrics, compare, relative_errors};
use crate::report::write::heatmap::{Canvas, Scale};
use std::path::{Path, PathBuf};

/// Printed below the flags.
const DEFINITIONS: &str = "\
Sums run over all pixels and channels, in linear Rec.709. mse: mean of (a-b)^2; relmse: mean of (a-b)^2 / (b^2 + 0.01); \
mape: mean of |a-b| / (|b| + 0.01); bias_z: difference of the mean values over its standard error, from the variance layers \
of EXR files. If B has such layers, its noise is subtracted from mse and relmse. Of crops in EXR files the pixels that both \
have are compared.";

/// Flags of `octray diff`.
#[derive(clap::Args)]
#[command(after_help = DEFINITIONS)]
pub struct DiffArgs {
    /// The picture to judge: .exr, .pfm, .hdr or .png
    a: PathBuf,
    /// The reference
    b: PathBuf,
    /// Write the relative error of every pixel as a picture: viridis, logarithmic, with its scale beside it
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
        if [&args.a, &args.b].iter().any(|input| same_file(input, path)) {
            return Err(Error::Usage(format!("--heatmap {}: that is one of the pictures compared", path.display())));
        }
    }
    let (mut a, mut b) = (Image::read(&args.a)?, Image::read(&args.b)?);
    let windows = a.windows.is_some() || b.windows.is_some();
    let area = if windows { overlap(args, &a, &b)? } else { a.data() };
    if windows {
        (a, b) = (a.part(area), b.part(area));
    }
    let metrics = compare(&a, &b).map_err(|fault| explain(shifted(fault, area), &args.a, &args.b))?;
    let clipped = |path: &Path| matches!(Format::of(path), Ok(Format::Png));
    for path in [&args.a, &args.b].into_iter().filter(|path| clipped(path)) {
        warn(&format!("{}: a PNG is rounded to 8 bits and cut at white; compare .exr or .pfm files", path.display()));
    }
    if let Some(path) = &args.heatmap {
        let errors = relative_errors(&a, &b);
        make_directory(path)?;
        Canvas::with_legend(&errors, a.width, Scale::fitting(&errors)).save(path)?;
    }
    let corners = |of: Bounds| [i64::from(of.x), i64::from(of.y), i64::from(of.width), i64::from(of.height)];
    let found = Found { metrics, compared: corners(area), display_window: corners(a.display()) };
    args.json.deliver(&found, || {
        let Bounds { x, y, width, height } = area;
        let of = a.display();
        let note = format!(
            "compared: the {width} x {height} pixels at {x},{y} that both have, of a display window of {} x {}\n",
            of.width, of.height
        );
        if windows { note + &text(&metrics) } else { text(&metrics) }
    })?;
    Ok(0)
}

/// What is printed as JSON. Rectangles are x, y, width, height.
#[derive(serde::Serialize)]
struct Found {
    #[serde(flatten)]
    metrics: Metrics,
    /// The pixels compared: where both data windows overlap.
    compared: [i64; 4],
    /// What both pictures are to show; of renders, the whole film.
    display_window: [i64; 4],
}

/// Where the data windows of `a` and `b` overlap, which have one display window.
fn overlap(args: &DiffArgs, a: &Image, b: &Image) -> Result<Bounds> {
    let bounds = |of: Bounds| format!("{} x {} at {},{}", of.width, of.height, of.x, of.y);
    let (name_a, name_b) = (args.a.display(), args.b.display());
    if a.display() != b.display() {
        return Err(Error::Usage(format!(
            "{name_a} has a display window of {} and {name_b} one of {}: only pictures of one film can be compared",
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

/// `fault` with the pixel as the files count it, where pictures were cut to `area`.
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
        Ok(Format::Png) => check_place(path, |path| check_output_path(path)),
        _ => Err(Error::Usage(format!("--heatmap {}: a heatmap is a PNG; name a .png file", path.display()))),
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Why the pictures in the files `a` and `b` cannot be compared.
pub fn explain(fault: Fault, a: &Path, b: &Path) -> Error {
    match fault {
        Fault::Size((w, h), (other_w, other_h)) => Error::Usage(format!(
            "{} has {w} x {h} pixels and {} has {other_w} x {other_h}: only pictures of one size can be compared",
            a.display(),
            b.display()
        )),
        Fault::Empty => Error::parse(a, None, "the picture has no pixels"),
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

fn text(m: &Metrics) -> String {
    let number = |value: f64| format!("{value:.6e}");
    let raw = |value: f64, noise: f64| match noise > 0.0 {
        true => format!("{value:.6e} before the reference's noise of {noise:.3e} was subtracted"),
        false => String::new(),
    };
    let mean = |[r, g, b]: [f64; 3]| format!("{r:.6} {g:.6} {b:.6}");
    let (bias, bias_note) = match (m.bias_se, m.bias_z) {
        (Some(se), Some(z)) => (format!("{z:.2}"), format!("{:+.3e}, standard error {se:.3e}", m.bias)),
        _ => ("-".to_owned(), format!("{:+.3e}; its standard error needs variance layers", m.bias)),
    };
    let row = |name: &str, value: String, note: String| vec![name.to_owned(), value, note];
    table(&[
        row("mse", number(m.mse), raw(m.mse_raw, m.noise_mse)),
        row("rmse", number(m.rmse), String::new()),
        row("relmse", number(m.relmse), raw(m.relmse_raw, m.noise_relmse)),
        row("mape", number(m.mape), String::new()),
        row("mean_a", mean(m.mean_a), String::new()),
        row("mean_b", mean(m.mean_b), String::new()),
        row("bias_z", bias, bias_note),
    ])
}
