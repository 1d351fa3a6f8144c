//! What `converge` writes, and where.

use crate::cli::converge::of_case;
use crate::cli::output::write_json;
use crate::cli::warn;
use crate::error::{Error, Result};
use crate::image::atomic;
use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::Finding;
use crate::report::measure::experiment::{Case, Experiment, Measurements};
use crate::report::measure::machine::Machine;
use crate::report::measure::truth::Reference;
use crate::report::write::figures;
use crate::report::write::heatmap::Canvas;
use crate::report::write::page::{Page, heat_scale};
use crate::report::write::plot::Layout;
use crate::report::write::results::{Results, csv};
use crate::report::write::words::Words;
use std::fs;
use std::path::{Path, PathBuf};

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
    pub fn reference(&self, case: &Case) -> PathBuf {
        self.path(&format!("reference{}.exr", suffix(&case.light)))
    }

    /// Where an interrupted call keeps its runs.
    pub fn unfinished(&self) -> PathBuf {
        self.path("converge.unfinished")
    }

    /// Removes what an interrupted call has kept, now that all is done.
    pub fn remove_unfinished(&self) {
        let path = self.unfinished();
        if path.exists()
            && let Err(error) = fs::remove_file(&path)
        {
            warn(&format!("{}: no longer needed, and cannot be removed: {error}", path.display()));
        }
    }

    fn text(&self, name: &str, text: &str) -> Result<()> {
        atomic::write(&self.path(name), |out| out.write_all(text.as_bytes()))
    }

    /// Writes everything.
    #[allow(clippy::too_many_arguments)] // what a report is made of
    pub fn write(
        &self,
        experiment: &Experiment,
        references: &[Reference],
        measured: &Measurements,
        findings: &[Finding],
        shown: &[Shown],
        command: &str,
        finished: bool,
    ) -> Result<()> {
        let machine = Machine::here();
        let page = Page { experiment, references, measured, findings, shown, machine: &machine, command, finished };
        self.plots(experiment, findings)?;
        self.pictures(experiment, shown)?;
        let results = Results::new(experiment, references, measured, findings, shown, &machine, command, finished);
        self.text("converge.csv", &csv(experiment, measured))?;
        write_json(&self.path("converge.json"), &results)?;
        self.text("report.html", &page.html())
    }

    /// Both plots of every case.
    fn plots(&self, experiment: &Experiment, findings: &[Finding]) -> Result<()> {
        for (index, case) in experiment.cases.iter().enumerate() {
            let words = Words { experiment, findings: of_case(findings, index).collect() };
            let [by_seconds, by_samples] = figures::plots(&words, &case.light);
            for (plot, against) in [(by_seconds, "seconds"), (by_samples, "samples")] {
                let name = format!("error-against-{against}{}.svg", suffix(&case.light));
                self.text(&name, &plot.svg(Layout::FILE).into_string())?;
            }
        }
        Ok(())
    }

    /// The pictures at equal time and their heatmaps.
    fn pictures(&self, experiment: &Experiment, shown: &[Shown]) -> Result<()> {
        for (index, case) in experiment.cases.iter().enumerate() {
            let of_case: Vec<&Shown> = shown.iter().filter(|shown| shown.case == index).collect();
            let scale = heat_scale(&of_case);
            for shown in of_case {
                let name = file_name(&experiment.label(shown.configuration).replace(' ', "-")) + &suffix(&case.light);
                shown.film.save(self.path(&format!("{name}.png")))?;
                let heatmap = Canvas::with_legend(&shown.errors, shown.film.width, scale);
                heatmap.save(&self.path(&format!("{name}-error.png")))?;
            }
        }
        Ok(())
    }
}

/// What tells the files of a case from those of the whole scene.
fn suffix(light: &str) -> String {
    if light == "all" { String::new() } else { format!("-{}", file_name(light)) }
}

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}
