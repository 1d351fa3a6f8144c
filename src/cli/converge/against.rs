//! `--against FILE.csv`: what other renderers made, measured beside ours.
//!
//! A row is one image: `name,seconds,image`, in any order of columns, and where they are known `scene` and `spp`. Seconds are
//! CPU seconds of all threads, of rendering alone. Images are named relative to the CSV file. Rows of one name, scene and number
//! of samples are repeats of one budget; without samples each image stands for itself.

use crate::cli::converge::setup::whole_image;
use crate::error::{Error, Result};
use crate::files::read;
use crate::image::Image;
use crate::report::measure::experiment::{Experiment, Run, spectrum_of};
use crate::report::measure::run_error::measure;
use crate::report::measure::truth::Reference;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// One row.
#[derive(Debug, PartialEq)]
struct Row {
    line: u64,
    name: String,
    case: usize,
    /// Samples a pixel, where the file says it: for all rows of a name and scene, or for none.
    spp: Option<u32>,
    seconds: f64,
    image: PathBuf,
}

/// Images of other renderers, read and not yet measured.
pub struct Others(Vec<(Row, Image)>);

/// Reads the files and the images that they name.
pub fn read(paths: &[PathBuf], experiment: &Experiment) -> Result<Others> {
    let mut others = Vec::new();
    for path in paths {
        let text = read::bytes(path)?;
        let rows = rows(path, &text, experiment)?;
        one_kind(path, &rows)?;
        for row in rows {
            let image = whole_image(&row.image, "--against", experiment)?;
            others.push((row, image));
        }
    }
    // Budgets ascend.
    others.sort_by(|(a, _), (b, _)| a.spp.cmp(&b.spp).then(a.seconds.total_cmp(&b.seconds)));
    Ok(Others(others))
}

impl Others {
    /// Measures the images and puts them beside the runs of `experiment`.
    pub fn join(self, experiment: &mut Experiment, references: &[Reference]) {
        let mut repeats: HashMap<(usize, usize, usize), u32> = HashMap::new();
        for (number, (row, image)) in self.0.into_iter().enumerate() {
            let known = experiment.others.iter().position(|name| *name == row.name);
            let other = known.unwrap_or_else(|| {
                experiment.others.push(row.name);
                experiment.others.len() - 1
            });
            // Images of unknown samples stand each for themselves.
            let budget = row.spp.map_or(number, |spp| spp as usize);
            let repeat = repeats.entry((row.case, other, budget)).or_default();
            experiment.others_runs.push(Run {
                case: row.case,
                configuration: experiment.configurations.len() + other,
                budget,
                repeat: *repeat,
                seed: 0,
                spp: row.spp.unwrap_or(0),
                seconds: row.seconds,
                cpu_seconds: row.seconds,
                error: measure(&image, &references[row.case].image, &experiment.regions),
                rays: [0; 3],
                lanes_used: None,
                walk_lanes_used: None,
                faults: 0,
                spectrum: spectrum_of(&image, &references[row.case].image),
            });
            *repeat += 1;
            experiment.others_images.push(image);
        }
    }
}

/// The rows of the file's text.
fn rows(path: &Path, text: &[u8], experiment: &Experiment) -> Result<Vec<Row>> {
    let bad = |line: u64, message: String| Error::parse(path, Some(line as usize), message);
    let of_reader = |error: csv::Error| bad(error.position().map_or(1, csv::Position::line), error.to_string());
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text);
    let head = reader.headers().map_err(of_reader)?.clone();
    let column = |name: &str| head.iter().position(|column| column.eq_ignore_ascii_case(name));
    let needed = |name: &str| {
        column(name).ok_or_else(|| {
            bad(1, format!("no column `{name}`; the first line names them: name,seconds,image[,scene][,spp]"))
        })
    };
    let (name, seconds, image) = (needed("name")?, needed("seconds")?, needed("image")?);
    let (scene, spp) = (column("scene"), column("spp"));
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(of_reader)?;
        let line = record.position().map_or(1, csv::Position::line);
        let field = |column: usize| record.get(column).unwrap_or_default();
        if field(name).is_empty() {
            return Err(bad(line, "the name is empty".into()));
        }
        if (0..experiment.configurations.len()).any(|own| experiment.label(own) == field(name)) {
            let name = field(name);
            return Err(bad(line, format!("the name `{name}` is that of a strategy measured here: choose another")));
        }
        let time = field(seconds).parse::<f64>().ok().filter(|time| *time > 0.0 && time.is_finite());
        let time = time.ok_or_else(|| bad(line, format!("seconds `{}`: give a number above 0", field(seconds))))?;
        let samples = match spp.map(&field) {
            None | Some("") => None,
            Some(text) => {
                let samples = text.parse::<u32>().ok().filter(|samples| *samples > 0);
                let wrong = || bad(line, format!("spp `{text}`: give a whole number from 1 on, or leave it empty"));
                Some(samples.ok_or_else(wrong)?)
            }
        };
        let case = case_of(scene.map(&field), experiment).map_err(|message| bad(line, message))?;
        let directory = path.parent().unwrap_or(Path::new(""));
        let image = directory.join(field(image));
        rows.push(Row { line, name: field(name).to_owned(), case, spp: samples, seconds: time, image });
    }
    match rows.is_empty() {
        true => Err(bad(1, "no rows below the first line".into())),
        false => Ok(rows),
    }
}

/// Refuses a name of which some images of a scene have samples and some have not: they would be points of two curves.
fn one_kind(path: &Path, rows: &[Row]) -> Result<()> {
    for row in rows {
        let twin = |other: &&Row| (&other.name, other.case) == (&row.name, row.case);
        if let Some(other) = rows.iter().filter(twin).find(|other| other.spp.is_some() != row.spp.is_some()) {
            let (first, second) = (row.line.min(other.line), row.line.max(other.line));
            let message = format!(
                "`{}` has spp in one of the lines {first} and {second}: give it in both or in neither",
                row.name
            );
            return Err(Error::parse(path, Some(second as usize), message));
        }
    }
    Ok(())
}

/// The whole scene that a row speaks of.
fn case_of(scene: Option<&str>, experiment: &Experiment) -> std::result::Result<usize, String> {
    let whole: Vec<(usize, &str)> = (experiment.cases.iter().enumerate())
        .filter(|(_, case)| case.is_whole())
        .map(|(index, case)| (index, case.scene_name.as_str()))
        .collect();
    let names = || whole.iter().map(|(_, name)| *name).collect::<Vec<_>>().join(", ");
    match (scene.unwrap_or_default(), whole.as_slice()) {
        ("", [(only, _)]) => Ok(*only),
        ("", _) => Err(format!("the scene is not named, and there are several: {}", names())),
        (scene, _) => {
            let found = whole.iter().find(|(_, name)| *name == scene);
            found.map(|(index, _)| *index).ok_or_else(|| format!("scene `{scene}` is not measured; known: {}", names()))
        }
    }
}
