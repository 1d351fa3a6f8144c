//! `octray check`: extreme and stiff cases against what is known of them; or what applies to a scene.

use crate::check;
use crate::check::item::{Effort, Level, SceneSubject};
use crate::check::row::Row;
use crate::cli::args;
use crate::cli::examples;
use crate::cli::numbers::count;
use crate::cli::output::{JsonArgs, columns, print, wrapped};
use crate::cli::progress::load;
use crate::cli::{prepare, warn};
use crate::error::Result;
use crate::simd::simd_level;
use std::path::PathBuf;
use std::sync::Mutex;

/// Flags of `octray check`.
#[derive(clap::Args)]
#[command(after_help = examples::CHECK)]
pub struct CheckArgs {
    /// A scene file (.toml), a bare .obj, a .gltf or .glb, or builtin:NAME: what applies to it, instead of the built-in suite
    scene: Option<PathBuf>,
    /// Only the checks whose names contain TEXT
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    filter: String,
    /// A hundred times as many rays and samples
    #[arg(long)]
    thorough: bool,
    /// Also what was found besides the figure, below each row that holds
    #[arg(long)]
    notes: bool,
    /// Checks made at once [default: one for every core]
    #[arg(long, value_name = "N", value_parser = args::positive, allow_negative_numbers = true)]
    threads: Option<u32>,
    #[command(flatten)]
    json: JsonArgs,
}

/// Runs the command; the exit status: 1 if a check fails.
pub fn run(args: &CheckArgs) -> Result<u8> {
    args.json.check()?;
    let cores = || std::thread::available_parallelism().map_or(1, |n| n.get());
    let level = if args.thorough { Level::Thorough } else { Level::Default };
    let effort = Effort { level, threads: args.threads.map_or_else(cores, |n| n as usize) };
    let columns = columns();
    // Lines come out one by one, since a row may take seconds; what goes wrong in that is told at the end.
    let failed: Mutex<Option<crate::error::Error>> = Mutex::new(None);
    let told = |row: &Row| {
        if !args.json.to_standard_output()
            && let Err(error) = print(&line(row, args.notes, columns))
        {
            *failed.lock().unwrap_or_else(|poisoned| poisoned.into_inner()) = Some(error);
        }
    };
    let rows = match &args.scene {
        None => check::run(&args.filter, &effort, &told)?,
        Some(path) => {
            let scene = load(path, false)?;
            scene.desc.warnings.iter().for_each(|warning| warn(warning));
            let prepared = prepare(&scene)?;
            let path = path.to_string_lossy();
            let subject = SceneSubject { scene: &scene, path: &path, prepared: &prepared, settings: scene.settings() };
            check::run_scene(&subject, &args.filter, &effort, &told)?
        }
    };
    if let Some(error) = failed.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner()) {
        return Err(error);
    }
    let failures = rows.iter().filter(|row| !row.pass).count();
    args.json.deliver(&rows, || summary(&rows, failures))?;
    Ok((failures > 0) as u8)
}

/// The name and the figure share so many columns: a long name takes those that the figure leaves.
const NAME_AND_FIGURE: usize = 49;
/// Where what was tried begins.
const TRIED: usize = 80;
/// Where notes begin, and what was tried where a terminal is narrow.
const INDENT: usize = 6;

/// A row: the verdict, its name, figure, bound, seconds, what was tried; below it what else there is to say of failures. In at
/// most `columns` columns, but for names that are longer.
fn line(row: &Row, notes: bool, columns: usize) -> String {
    let verdict = if row.pass { "pass" } else { "FAIL" };
    let (tried, figure, bound) = (format!("{} {}", count(row.cases), row.tried), number(row.figure), bound(row.bound));
    let room = NAME_AND_FIGURE.saturating_sub(row.name.len() + 2);
    let start = format!("{verdict}  {}  {figure:>room$}  {bound:>11}  {:6.2} s", row.name, row.seconds);
    let mut text = match columns >= TRIED + 40 && start.len() + 2 <= TRIED {
        true => format!("{start}  {}\n", wrapped(&tried, columns - TRIED, TRIED)),
        false => format!("{start}\n{:INDENT$}{}\n", "", wrapped(&tried, columns - INDENT, INDENT)),
    };
    if !row.note.is_empty() && (notes || !row.pass || row.bound == f64::INFINITY) {
        text += &format!("{:INDENT$}{}\n", "", wrapped(&row.note, columns - INDENT, INDENT));
    }
    if let Some(command) = &row.trace {
        text += &format!("{:INDENT$}look at it: {command}\n", "");
    }
    text
}

fn summary(rows: &[Row], failures: usize) -> String {
    let seconds: f64 = rows.iter().map(|row| row.seconds).sum();
    let cases: u64 = rows.iter().map(|row| row.cases).sum();
    let verdict = match failures {
        0 => "all hold".to_string(),
        1 => "1 fails".to_string(),
        n => format!("{n} fail"),
    };
    let checks = if rows.len() == 1 { "1 check".to_string() } else { format!("{} checks", rows.len()) };
    format!("{checks}, {} cases, {seconds:.1} s, {}: {verdict}\n", count(cases), simd_level())
}

fn bound(bound: f64) -> String {
    if bound == f64::INFINITY { "(remark)".into() } else { format!("<= {}", number(bound)) }
}

/// Three digits.
fn number(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        size if !size.is_finite() => "none".into(),
        size if (1e-2..1e4).contains(&size) => {
            let digits = (2 - size.log10().floor() as i32).max(0) as usize;
            let text = format!("{x:.digits$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
        }
        _ => format!("{x:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::row::Outcome;

    #[test]
    fn numbers_are_short() {
        let numbers = [0.0, 5.0, 1234.0, 0.5, 0.012345, 1e-7, 123456.0, f64::NAN].map(number);
        assert_eq!(numbers, ["0", "5", "1234", "0.5", "0.0123", "1.00e-7", "1.23e5", "none"]);
    }

    #[test]
    fn failures_say_what_to_look_at_and_what_holds_is_one_line() {
        let row = |figure| {
            let outcome = Outcome::at_most(figure, 1.0).tried(1000, "rays").note("worst here").trace(Some("x".into()));
            Row::new("a/b".into(), outcome, 0.5)
        };
        let failed = line(&row(2.0), false, 120);
        assert!(
            failed.starts_with("FAIL  a/b") && failed.contains("1,000 rays\n      worst here\n      look at it: x\n")
        );
        assert_eq!((line(&row(0.5), false, 120).lines().count(), line(&row(0.5), true, 120).lines().count()), (1, 2));
        assert!(summary(&[row(2.0), row(0.5)], 1).starts_with("2 checks, 2,000 cases, 1.0 s"));
        assert!(summary(&[row(2.0)], 1).starts_with("1 check,") && summary(&[row(2.0)], 1).ends_with(": 1 fails\n"));
    }

    /// Every row of the suite with the longest texts it has.
    #[test]
    fn rows_fit_the_terminal() {
        let outcome = |figure| {
            let outcome = Outcome::at_most(figure, 1.234e-10).note("so ".repeat(60).trim());
            outcome.tried(20_643_840, "points of quadratures ".repeat(6).trim())
        };
        for name in check::names() {
            for (figure, columns) in [(0.0, 80), (-1.234e-10, 100), (-1.234e-10, 120), (0.0, 120)] {
                let text = line(&Row::new(name.clone(), outcome(figure), 100.0), true, columns);
                assert!(text.lines().all(|line| line.len() <= columns), "{columns}:\n{text}");
            }
            let wide = line(&Row::new(name, outcome(0.0), 100.0), true, 120);
            assert!(wide.lines().nth(1).is_some_and(|line| line.starts_with(&" ".repeat(TRIED))), "{wide}");
        }
    }
}
