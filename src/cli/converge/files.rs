//! What `converge` writes, and where.

use crate::cli::output::write_json;
use crate::error::{Error, Result};
use crate::files::atomic;
use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::Finding;
use crate::report::analysis::summary::of_case;
use crate::report::measure::experiment::{Case, Experiment};
use crate::report::write::contents::Contents;
use crate::report::write::figures::{Figure, figures};
use crate::report::write::heatmap::Canvas;
use crate::report::write::page::{self, heat_scale};
use crate::report::write::plot::Layout;
use crate::report::write::results::{Results, csv};
use crate::report::write::words::Words;
use std::fs;
use std::path::{Path, PathBuf};

/// What the names of files in `--out DIR` end in; scenes have other extensions, references are never written where they are
/// given.
pub const EXTENSIONS: &[&str] = &["html", "csv", "json", "svg", "png"];

/// The files of one `--out DIR`.
pub struct Files {
    directory: PathBuf,
}

impl Files {
    /// Makes the directory and asks whether it takes files: before the work, not after it.
    pub fn new(directory: &Path) -> Result<Files> {
        fs::create_dir_all(directory).map_err(|error| Error::Write {
            path: directory.to_owned(),
            message: format!("{error}; --out names the directory of the report: choose another place"),
        })?;
        let files = Files { directory: directory.to_owned() };
        for name in ["report.html", "converge.csv", "converge.json"] {
            atomic::check(&files.path(name))?;
        }
        Ok(files)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.join(name)
    }

    /// Where the rendered reference of a case is kept.
    pub fn reference(&self, experiment: &Experiment, case: usize) -> PathBuf {
        self.path(&format!("reference{}.exr", suffixes(experiment)[case]))
    }

    /// Where the parts of a reference that was stopped are kept.
    pub fn unfinished_reference(&self, experiment: &Experiment, case: usize) -> PathBuf {
        self.path(&format!("reference{}.unfinished", suffixes(experiment)[case]))
    }

    /// Where the runs of a part go.
    pub fn part(&self) -> PathBuf {
        self.path("converge.part")
    }

    /// Where an interrupted call keeps its runs.
    pub fn unfinished(&self) -> PathBuf {
        self.path("converge.unfinished")
    }

    fn text(&self, name: &str, text: &str) -> Result<()> {
        atomic::write(&self.path(name), |out| out.write_all(text.as_bytes()))
    }

    /// Writes everything.
    pub fn write(&self, contents: &Contents) -> Result<()> {
        let &Contents { experiment, measured, findings, shown, .. } = contents;
        self.plots(experiment, findings)?;
        self.images(experiment, shown)?;
        self.text("converge.csv", &csv(experiment, measured))?;
        write_json(&self.path("converge.json"), &Results::new(contents))?;
        self.text("report.html", &page::html(contents))
    }

    /// All plots of every case.
    fn plots(&self, experiment: &Experiment, findings: &[Finding]) -> Result<()> {
        for (index, suffix) in suffixes(experiment).iter().enumerate() {
            let words = Words { experiment, findings: of_case(findings, index).collect() };
            for Figure { plot, name } in figures(&words, &experiment.case_title(index)) {
                let name = format!("{name}{suffix}.svg");
                self.text(&name, &plot.svg(Layout::FILE).into_string())?;
            }
        }
        Ok(())
    }

    /// The images at equal time and their heatmaps.
    fn images(&self, experiment: &Experiment, shown: &[Shown]) -> Result<()> {
        let labels = (0..experiment.entries()).map(|own| file_name(&experiment.label(own).replace(' ', "-")));
        let labels = numbered(labels.collect());
        for (index, suffix) in suffixes(experiment).iter().enumerate() {
            let of_case: Vec<&Shown> = shown.iter().filter(|shown| shown.case == index).collect();
            let scale = heat_scale(&of_case);
            for shown in of_case {
                let name = format!("{}{suffix}", labels[shown.configuration]);
                shown.image.save_png(self.path(&format!("{name}.png")), experiment.exposure)?;
                let heatmap = Canvas::with_legend(&shown.errors, shown.image.width, scale);
                heatmap.save(&self.path(&format!("{name}-error.png")))?;
            }
        }
        Ok(())
    }
}

/// What tells the files of each case from those of others: the scene where there are several, the light where it is not all.
fn suffixes(experiment: &Experiment) -> Vec<String> {
    let several = experiment.cases.iter().any(|other| other.scene_name != experiment.cases[0].scene_name);
    let suffix = |case: &Case| {
        let scene = several.then_some(case.scene_name.as_str());
        let light = (!case.is_whole()).then_some(case.light.as_str());
        scene.into_iter().chain(light).map(|part| format!("-{}", file_name(part))).collect()
    };
    numbered(experiment.cases.iter().map(suffix).collect())
}

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}

/// The names, numbered where two are alike to a file system that does not tell capitals.
fn numbered(names: Vec<String>) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for name in names {
        let is_taken = |taken: &[String], name: &str| taken.iter().any(|other| other.eq_ignore_ascii_case(name));
        let mut unique = name.clone();
        let mut number = 2;
        while is_taken(&taken, &unique) {
            unique = format!("{name}-{number}");
            number += 1;
        }
        taken.push(unique);
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_files_have_one_name() {
        let names = ["a b", "a/b", "A_b", "c", "ä"].map(file_name);
        assert_eq!(numbered(names.to_vec()), ["a_b", "a_b-2", "A_b-3", "c", "_"]);
    }
}
