//! What `converge` writes, and where.

use crate::cli::output::write_json;
use crate::error::{Error, Result};
use crate::image::atomic;
use crate::report::analysis::Finding;
use crate::report::equal_time::Shown;
use crate::report::experiment::{Case, Experiment, Measurements};
use crate::report::machine::Machine;
use crate::report::reference::Reference;
use crate::report::results::{Results, csv};
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
        match case.light.as_str() {
            "all" => self.path("reference.exr"),
            light => self.path(&format!("reference-{}.exr", file_name(light))),
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
        let results =
            Results::new(experiment, references, measured, findings, shown, &machine, command, finished);
        self.text("converge.csv", &csv(experiment, measured))?;
        write_json(&self.path("converge.json"), &results)
    }
}

/// A name that every file system takes.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect()
}
