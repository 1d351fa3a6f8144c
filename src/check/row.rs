//! What a check comes to: one row of the result.

use serde::Serialize;

/// What a check has found, before its name and its time are put to it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Whether it holds.
    pub pass: bool,
    /// What was measured.
    pub figure: f64,
    /// The largest figure that passes.
    pub bound: f64,
    /// Cases tried: rays, samples, inputs.
    pub cases: u64,
    /// What was tried, in a few words.
    pub tried: String,
    /// What the user should know besides; may be empty.
    pub note: String,
    /// The `octray trace` command that shows the worst case, where a path does.
    pub trace: Option<String>,
}

impl Outcome {
    /// Holds if `figure` is at most `bound`; a figure that is no number does not.
    pub fn at_most(figure: f64, bound: f64) -> Outcome {
        let pass = figure <= bound;
        Outcome { pass, figure, bound, cases: 0, tried: String::new(), note: String::new(), trace: None }
    }

    /// Fails because the check could not be made.
    pub fn impossible(why: impl Into<String>) -> Outcome {
        Outcome { note: why.into(), ..Outcome::at_most(f64::NAN, 0.0) }
    }

    /// A property of the input: holds, whatever it is.
    pub fn remark(figure: f64, note: impl Into<String>) -> Outcome {
        Outcome { note: note.into(), ..Outcome::at_most(figure, f64::INFINITY) }
    }

    /// Says what was tried: so many of what `what` names.
    pub fn tried(mut self, cases: u64, what: impl Into<String>) -> Outcome {
        (self.cases, self.tried) = (cases, what.into());
        self
    }

    /// Says something besides.
    pub fn note(mut self, note: impl Into<String>) -> Outcome {
        self.note = note.into();
        self
    }

    /// Says which path shows the worst case.
    pub fn trace(mut self, command: Option<String>) -> Outcome {
        self.trace = command;
        self
    }

    /// Fails for `reason` besides what the figure says.
    pub fn and(mut self, holds: bool, reason: impl Into<String>) -> Outcome {
        if !holds {
            self.pass = false;
            let reason = reason.into();
            self.note = if self.note.is_empty() { reason } else { format!("{reason}; {}", self.note) };
        }
        self
    }
}

/// One row of the result.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// `group/what`.
    pub name: String,
    /// Whether it holds.
    pub pass: bool,
    /// What was measured; JSON has `null` for what is no finite number.
    pub figure: f64,
    /// The largest figure that passes.
    pub bound: f64,
    /// Cases tried.
    pub cases: u64,
    /// Wall seconds it took.
    pub seconds: f64,
    /// What was tried, in a few words.
    pub tried: String,
    /// What the user should know besides; may be empty.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub note: String,
    /// The `octray trace` command that shows the worst case of a failure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace: Option<String>,
}

impl Row {
    /// The row of a check.
    pub fn new(name: String, outcome: Outcome, seconds: f64) -> Row {
        let Outcome { pass, figure, bound, cases, tried, note, trace } = outcome;
        Row { name, pass, figure, bound, cases, seconds, tried, note, trace: trace.filter(|_| !pass) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_that_are_no_numbers_fail_and_only_failures_are_traced() {
        assert!(!Outcome::at_most(f64::NAN, f64::INFINITY).pass && Outcome::at_most(0.0, 0.0).pass);
        assert!(!Outcome::impossible("no such scene").pass && Outcome::remark(f64::INFINITY, "open").pass);
        let failed = Outcome::at_most(0.0, 1.0).note("a").and(true, "b").and(false, "c");
        assert!(!failed.pass && failed.note == "c; a");
        let traced = |figure| Row::new("a/b".into(), Outcome::at_most(figure, 1.0).trace(Some("t".into())), 0.0).trace;
        assert_eq!((traced(0.0), traced(2.0)), (None, Some("t".to_string())));
    }
}
