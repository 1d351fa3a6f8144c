//! What a report is made of.

use crate::report::analysis::equal_time::Shown;
use crate::report::analysis::findings::Finding;
use crate::report::analysis::summary::Summary;
use crate::report::measure::experiment::{Experiment, Measurements};
use crate::report::measure::machine::Machine;
use crate::report::measure::truth::Reference;

/// Everything that the page, the tables and the files of a report say.
#[derive(Clone, Copy)]
pub struct Contents<'a> {
    /// What was run.
    pub experiment: &'a Experiment,
    /// One a case.
    pub references: &'a [Reference],
    /// The runs.
    pub measured: &'a Measurements,
    /// What they say.
    pub findings: &'a [Finding],
    /// What they say of several cases together.
    pub summaries: &'a [Summary],
    /// Images at equal time.
    pub shown: &'a [Shown],
    /// Where it ran.
    pub machine: &'a Machine,
    /// What was typed.
    pub command: &'a str,
    /// How far the runs have come.
    pub state: State,
}

/// How far the runs of a report have come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// More are being made while this is written.
    Running,
    /// More were asked for, and stopped.
    Stopped,
    /// All were made.
    Finished,
}

impl Contents<'_> {
    /// How many runs there are: "30 of 54 runs", "60 runs, 6 of them to reach an error".
    pub fn so_far(&self) -> String {
        let (all, asked) = (self.measured.runs.len(), self.experiment.run_count());
        let own = self.experiment.asked_of(&self.measured.runs);
        match all - own {
            0 => format!("{own} of {asked} runs"),
            beyond => format!("{all} runs, {beyond} of them to reach an error"),
        }
    }
}
