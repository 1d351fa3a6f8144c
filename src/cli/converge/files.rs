//! What `converge` writes, and where.

use crate::cli::output::write_json;
use crate::cli::warn;
use crate::error::{Error, Result};
use crate::image::atomic;
use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::Finding;
use crate::report::analysis::summary::of_case;
use crate::report::measure::experiment::Experiment;
use crate::report::write::contents::Contents;
use crate::report::write::figures::{Figure, figures};
use crate::report::write::heatmap::Canvas;
use crate::report::write::page::{self, heat_scale};
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
    pub fn reference(&self, experiment: &Experiment, case: usize) -> PathBuf {
        self.path(&format!("reference{}.exr", suffix(experiment, case)))
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
        for index in 0..experiment.cases.len() {
            let words = Words { experiment, findings: of_case(findings, index).collect() };
            for Figure { plot, name } in figures(&words, &experiment.case_title(index)) {
                let name = format!("{name}{}.svg", suffix(experiment, index));
                self.text(&name, &plot.svg(Layout::FILE).into_string())?;
            }
        }
        Ok(())
    }

    /// The images at equal time and their heatmaps.
    fn images(&self, experiment: &Experiment, shown: &[Shown]) -> Result<()> {
        for index in 0..experiment.cases.len() {
            let of_case: Vec<&Shown> = shown.iter().filter(|shown| shown.case == index).collect();
            let scale = heat_scale(&of_case);
            for shown in of_case {
                let name =
                    file_name(&experiment.label(shown.configuration).replace(' ', "-")) + &suffix(experiment, index);
                shown.image.save_png(self.path(&format!("{name}.png")), experiment.exposure)?;
                let heatmap = Canvas::with_legend(&shown.errors, shown.image.width, scale);
                heatmap.save(&self.path(&format!("{name}-error.png")))?;
            }
        }
        Ok(())
    }
}

/// What tells the files of a case from those of others: the scene where there are several, the light where it is not all.
fn suffix(experiment: &Experiment, case: usize) -> String {
    let of = &experiment.cases[case];
    let several = experiment.cases.iter().any(|other| other.scene_name != of.scene_name);
    let scene = several.then_some(of.scene_name.as_str());
    let light = (!of.is_whole()).then_some(of.light.as_str());
    scene.into_iter().chain(light).map(|part| format!("-{}", file_name(part))).collect()
}

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}
