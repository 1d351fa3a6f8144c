//! The table of planted faults: which rows must fail while one is committed. Groups hold their parts of it.

#[cfg(feature = "exr")]
use crate::check::exr_files;
use crate::check::item::{Check, Effort, Level};
use crate::check::row::Outcome;
use crate::check::{
    camera, directions, engines, environment, error_bars, film, geometry, lights, materials, mis, scale, suite,
    transport, yardstick,
};
use crate::fault::{Fault, tests::with};

/// Per fault, the rows that must fail.
const FAULTS: &[&[(Fault, &[&str])]] = &[
    scale::FAULTS,
    lights::FAULTS,
    mis::FAULTS,
    transport::FAULTS,
    geometry::FAULTS,
    directions::FAULTS,
    materials::FAULTS,
    environment::FAULTS,
    camera::FAULTS,
    film::FAULTS,
    #[cfg(feature = "exr")]
    exr_files::FAULTS,
    error_bars::FAULTS,
    engines::FAULTS,
    yardstick::FAULTS,
];

const QUICK: Effort = Effort { level: Level::Quick, threads: 1 };

fn checks() -> impl Iterator<Item = (&'static Check, String)> {
    suite::SUITE.iter().flat_map(|group| group.iter()).map(|check| (check, format!("{}/{}", check.group, check.what)))
}

fn pairs() -> impl Iterator<Item = (Fault, &'static str)> {
    FAULTS.iter().flat_map(|part| part.iter()).flat_map(|&(fault, rows)| rows.iter().map(move |&row| (fault, row)))
}

/// What a check comes to, panics and errors told as failures.
fn outcome(check: &Check) -> Outcome {
    match std::panic::catch_unwind(|| (check.run)(&QUICK)) {
        Ok(Ok(outcome)) => outcome,
        Ok(Err(error)) => Outcome::impossible(error.to_string()),
        Err(_) => Outcome::impossible("panicked"),
    }
}

#[test]
fn every_row_is_named_by_a_fault_and_every_name_is_a_row() {
    let named: Vec<&str> = pairs().map(|(_, row)| row).collect();
    let unproven: Vec<String> = checks().map(|(_, name)| name).filter(|name| !named.contains(&&name[..])).collect();
    assert!(unproven.is_empty(), "no fault is known to fail these rows: {unproven:?}");
    let unknown: Vec<&&str> = named.iter().filter(|row| !checks().any(|(_, name)| name == **row)).collect();
    assert!(unknown.is_empty(), "no such rows: {unknown:?}");
}

#[test]
fn every_planted_fault_fails_its_rows() {
    let mut wrong = Vec::new();
    for (fault, row) in pairs() {
        let Some((check, _)) = checks().find(|(_, name)| name == row) else { continue };
        let outcome = with(fault, || outcome(check));
        println!("{row} with {fault:?}: {} for {}", outcome.figure, outcome.bound);
        if outcome.pass {
            wrong.push(format!("{row} passes with {fault:?}: {} <= {}", outcome.figure, outcome.bound));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_row_holds_without_a_fault() {
    let mut wrong = Vec::new();
    for (check, name) in checks() {
        let outcome = outcome(check);
        if !outcome.pass {
            wrong.push(format!("{name}: {} > {}, {}", outcome.figure, outcome.bound, outcome.note));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
