//! `octray merge`: the parts of a render, made by themselves, to the image that one machine would have made.

use crate::cli::args;
use crate::cli::examples;
use crate::cli::layers::{EncodingArgs, left_out};
use crate::cli::messages::tell;
use crate::cli::output::{check_place, make_directory, print};
use crate::cli::{places, report, warn};
use crate::error::{Error, Result};
use crate::film::part::{self, Part};
use crate::image::check_output_path;
use std::path::{Path, PathBuf};

/// Flags of `octray merge`.
#[derive(clap::Args)]
#[command(after_help = examples::MERGE)]
pub struct MergeArgs {
    /// Parts, as `octray render --shard K/N -o FILE` has written them, in any order
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// Image to write: .exr, .png, .hdr or .pfm; may be given several times; its directory is made if need be
    #[arg(short, long, value_name = "FILE", required_unless_present = "list")]
    output: Vec<PathBuf>,
    /// Only say which parts there are and which are missing; exit status 1 if any is
    #[arg(long, conflicts_with = "output")]
    list: bool,
    /// Stops of exposure for PNG; other formats hold radiance as it is
    #[arg(long, value_name = "EV", default_value = "0", value_parser = args::exposure, allow_negative_numbers = true)]
    exposure: f64,
    #[command(flatten)]
    encoding: EncodingArgs,
}

/// Numbers that a message names, at most.
const MOST_NAMED: usize = 20;

/// Runs the command; the exit status.
pub fn run(args: &MergeArgs) -> Result<u8> {
    for path in &args.output {
        check_place(path, |path| check_output_path(path))?;
        places::claim(path)?;
    }
    if !args.list {
        args.encoding.check(&args.output)?;
    }
    let found = places::reading(|| Ok(open(&args.parts)))?;
    found.faults.iter().for_each(report);
    let missing = found.missing();
    if args.list {
        print(&found.text(&missing))?;
        return Ok(if !found.faults.is_empty() { 2 } else { u8::from(!missing.is_empty()) });
    }
    // All of them are told before any is the reason to end.
    if !missing.is_empty() {
        report(&Error::Usage(missing_text(&missing, found.count)));
    }
    if !missing.is_empty() || !found.faults.is_empty() {
        return Ok(2);
    }
    merge(args, found.parts)
}

/// The parts of one picture, and what else was found.
struct Found {
    /// By their numbers.
    parts: Vec<(PathBuf, Part)>,
    /// How many there are to be.
    count: u32,
    /// Files that are no parts of it, or twice the same.
    faults: Vec<Error>,
}

/// Opens the files: each one's faults are its own, and the first part says what picture it is.
fn open(paths: &[PathBuf]) -> Found {
    let mut found = Found { parts: Vec::new(), count: 0, faults: Vec::new() };
    let mut taken: std::collections::HashMap<u32, usize> = std::collections::HashMap::new();
    for path in paths {
        let part = match part::open(path) {
            Ok(part) => part,
            Err(error) => {
                found.faults.push(error);
                continue;
            }
        };
        let fault = |message: String| Error::parse(path, None, message);
        if let Some((first, of_first)) = found.parts.first()
            && let Some(difference) = of_first.about.differs(&part.about)
        {
            let first = first.display();
            found.faults.push(fault(format!("no part of the image that {first} is a part of: {difference}")));
            continue;
        }
        found.count = part.about.shard.1;
        let number = part.about.shard.0;
        match taken.insert(number, found.parts.len()) {
            None => found.parts.push((path.clone(), part)),
            Some(place) => {
                let other = found.parts[place].0.display();
                found.faults.push(fault(format!("part {number} of {}, as {other} is: leave one out", found.count)));
                taken.insert(number, place);
            }
        }
    }
    found.parts.sort_by_key(|(_, part)| part.about.shard.0);
    found
}

impl Found {
    /// The numbers of the parts that are not there.
    fn missing(&self) -> Vec<u32> {
        let mut there = self.parts.iter().map(|(_, part)| part.about.shard.0).peekable();
        (1..=self.count).filter(|number| there.next_if_eq(number).is_none()).collect()
    }

    /// What there is.
    fn text(&self, missing: &[u32]) -> String {
        let Some((_, first)) = self.parts.first() else { return "no part\n".to_owned() };
        let [_, _, width, height] = first.about.crop;
        let value =
            |name: &str| first.about.recipe.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str());
        let mut text = format!(
            "{} of {} parts of {}: {width} x {height} pixels, {} samples a pixel\n",
            self.parts.len(),
            self.count,
            value("scene").unwrap_or("a scene"),
            first.about.spp
        );
        for (path, part) in &self.parts {
            text += &format!("  {}: part {}\n", path.display(), part.about.shard.0);
        }
        if !missing.is_empty() {
            text += &format!("{}\n", missing_text(missing, self.count));
        }
        text
    }
}

fn missing_text(missing: &[u32], count: u32) -> String {
    let named: Vec<String> = missing.iter().take(MOST_NAMED).map(u32::to_string).collect();
    let more = missing.len() - named.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let (parts, are) = if missing.len() == 1 { ("part", "is") } else { ("parts", "are") };
    format!("{parts} {}{more} of {count} {are} missing", named.join(", "))
}

/// Puts the parts together and writes the images.
fn merge(args: &MergeArgs, parts: Vec<(PathBuf, Part)>) -> Result<u8> {
    let Some((_, first)) = parts.first() else { return Ok(2) };
    let mut film = first.whole()?;
    let count = parts.len();
    for (path, part) in parts {
        part.put(&path, &mut film)?;
        tell(&format!("{}: put in its place", path.display()));
    }
    film.encoding = args.encoding.encoding();
    let found = args.encoding.beyond_half(&film, &args.output).into_iter().chain(left_out(&film, &args.output));
    found.for_each(|warning| warn(&warning));
    let (mut written, mut status): (Vec<&Path>, u8) = (Vec::new(), 0);
    for path in &args.output {
        match make_directory(path).and_then(|()| film.save_exposed(path, args.exposure)) {
            Ok(()) => written.push(path),
            Err(error) => {
                report(&error);
                status = error.exit_status();
            }
        }
    }
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    if !names.is_empty() {
        let (width, height, spp) = (film.width, film.height, film.spp);
        print(&format!(
            "wrote {}\n  {width} x {height} pixels, {spp} samples a pixel, of {count} parts\n",
            names.join(", ")
        ))?;
    }
    Ok(status)
}
