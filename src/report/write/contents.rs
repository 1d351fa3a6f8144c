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
    /// All runs were made.
    pub finished: bool,
}
