//! What `octray check` measures: extreme and stiff cases, each held against a bound.
//!
//! **Law:** a check compares what the engines compute with what is known without them: closed forms, sums in f64, the
//! reference compiled for f64, a twin that must have the same bits. It has one figure and one bound, both stated; statistical
//! ones use fixed seeds and pass within five standard errors. Every check is known to fail: the unit tests plant
//! a fault for each (`fault`). Properties of a user's scene are remarks, never failures. Nothing here prints.
//!
//! [`limits`] is the table of how far octray goes, each limit with the row that measures it.
//!
//! A new check is a function and a line in `CHECKS` of its group, and a line in the group's `FAULTS` that names the fault
//! which must fail it; a new fault is a variant of `fault::Fault` and one hook. Scenes are made in `scenes`, under a
//! name that `octray trace` takes, and rendered by `trial`; inputs come from `numbers`.

#[cfg(test)]
mod faults;
#[doc(hidden)]
pub mod item;
pub mod limits;
#[doc(hidden)]
pub mod numbers;
#[doc(hidden)]
pub mod rays;
#[doc(hidden)]
pub mod row;
#[doc(hidden)]
pub mod scenes;
#[doc(hidden)]
pub mod shots;
#[doc(hidden)]
pub mod suite;
#[doc(hidden)]
pub mod trial;
#[doc(hidden)]
pub mod truth;
#[doc(hidden)]
pub mod twin;

#[doc(hidden)]
pub mod camera;
#[doc(hidden)]
pub mod directions;
#[doc(hidden)]
pub mod engines;
#[doc(hidden)]
pub mod environment;
#[doc(hidden)]
pub mod error_bars;
#[doc(hidden)]
#[cfg(feature = "exr")]
pub mod exr_files;
pub mod film;
#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod lights;
#[doc(hidden)]
pub mod materials;
#[doc(hidden)]
pub mod mis;
#[doc(hidden)]
pub mod scale;
#[doc(hidden)]
pub mod subject;
#[doc(hidden)]
pub mod transport;
#[doc(hidden)]
pub mod yardstick;

use crate::error::{Error, Result};
use item::{Effort, SceneSubject};
use row::{Outcome, Row};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// A check, its subject taken up.
struct Job<'a> {
    name: String,
    make: Box<dyn Fn() -> Result<Outcome> + Sync + 'a>,
}

/// Makes the checks of the built-in suite whose names contain `filter`; `done` is told every row, in the order of the table.
///
/// # Errors
/// [`Error::Usage`] if no name contains `filter`.
pub fn run(filter: &str, effort: &Effort, done: &(dyn Fn(&Row) + Sync)) -> Result<Vec<Row>> {
    let checks = suite::SUITE.iter().flat_map(|group| group.iter());
    let jobs = checks
        .map(|check| Job { name: format!("{}/{}", check.group, check.what), make: Box::new(|| (check.run)(effort)) });
    run_jobs(jobs.collect(), filter, effort, done)
}

/// Makes the checks that apply to a scene; else as [`run`].
///
/// # Errors
/// As [`run`].
pub fn run_scene(
    subject: &SceneSubject,
    filter: &str,
    effort: &Effort,
    done: &(dyn Fn(&Row) + Sync),
) -> Result<Vec<Row>> {
    let checks = suite::OF_A_SCENE.iter().flat_map(|group| group.iter());
    let jobs = checks.map(|check| Job {
        name: format!("{}/{}", check.group, check.what),
        make: Box::new(|| (check.run)(subject, effort)),
    });
    run_jobs(jobs.collect(), filter, effort, done)
}

/// The names of the suite's checks, in order.
pub fn names() -> Vec<String> {
    let checks = suite::SUITE.iter().flat_map(|group| group.iter());
    checks.map(|check| format!("{}/{}", check.group, check.what)).collect()
}

fn run_jobs(mut jobs: Vec<Job>, filter: &str, effort: &Effort, done: &(dyn Fn(&Row) + Sync)) -> Result<Vec<Row>> {
    let mut groups: Vec<String> =
        jobs.iter().map(|job| job.name.split('/').next().unwrap_or_default().to_string()).collect();
    groups.dedup();
    jobs.retain(|job| job.name.contains(filter));
    if jobs.is_empty() {
        let groups = groups.join(", ");
        return Err(Error::Usage(format!("no check's name contains `{filter}`; the groups are {groups}")));
    }
    let next = AtomicUsize::new(0);
    let rows: Mutex<Rows> = Mutex::new(Rows { made: jobs.iter().map(|_| None).collect(), told: 0 });
    let work = || {
        while let Some((index, job)) = Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|i| Some((i, jobs.get(i)?)))
        {
            let row = make(job);
            rows.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).add(index, row, done);
        }
    };
    // On the caller's thread if one is enough: that is where tests plant faults.
    match effort.threads.min(jobs.len()) {
        0 | 1 => work(),
        threads => std::thread::scope(|scope| {
            for _ in 1..threads {
                // Where the system refuses to start a thread, those that there are do its work.
                if std::thread::Builder::new().spawn_scoped(scope, work).is_err() {
                    break;
                }
            }
            work();
        }),
    }
    let rows = rows.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    Ok(rows.made.into_iter().flatten().collect())
}

/// The rows made so far, and how many of them have been told.
struct Rows {
    made: Vec<Option<Row>>,
    told: usize,
}

impl Rows {
    /// Takes a row in, and tells those that have no gap before them.
    fn add(&mut self, index: usize, row: Row, done: &(dyn Fn(&Row) + Sync)) {
        self.made[index] = Some(row);
        while let Some(Some(row)) = self.made.get(self.told) {
            done(row);
            self.told += 1;
        }
    }
}

/// Makes a check: one that cannot be made, or panics, has failed.
fn make(job: &Job) -> Row {
    let start = Instant::now();
    let outcome = match catch_unwind(AssertUnwindSafe(|| (job.make)())) {
        Ok(Ok(outcome)) => outcome,
        Ok(Err(error)) => Outcome::impossible(error.to_string()),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
            Outcome::impossible(format!("panicked: {}", text.unwrap_or("for an unknown reason")))
        }
    };
    Row::new(job.name.clone(), outcome, start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use item::Level;

    #[test]
    fn names_are_groups_and_what_and_differ() {
        let mut names = names();
        assert!(names.iter().all(|name| name.split('/').count() == 2 && !name.contains(' ')), "{names:?}");
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn failures_of_every_kind_are_rows_in_the_order_of_the_table() {
        let effort = Effort { level: Level::Quick, threads: 3 };
        let jobs = || {
            let mut jobs: Vec<Job> = (0..40)
                .map(|i| Job {
                    name: format!("a/{i}"),
                    make: Box::new(move || Ok(Outcome::at_most(f64::from(i), f64::from(i / 2 * 2)))),
                })
                .collect();
            jobs.push(Job { name: "b/error".into(), make: Box::new(|| Err(Error::Usage("no".into()))) });
            jobs.push(Job { name: "b/panic".into(), make: Box::new(|| panic!("no {}", 1)) });
            jobs
        };
        let told = Mutex::new(Vec::new());
        let rows = run_jobs(jobs(), "", &effort, &|row| told.lock().unwrap().push(row.name.clone())).unwrap();
        assert_eq!(*told.lock().unwrap(), rows.iter().map(|row| row.name.clone()).collect::<Vec<_>>());
        assert!(rows[..40].iter().enumerate().all(|(i, row)| row.pass == (i % 2 == 0)));
        assert_eq!((&rows[40].note[..], &rows[41].note[..], rows.len()), ("no", "panicked: no 1", 42));
        assert_eq!(run_jobs(jobs(), "b/", &effort, &|_| {}).unwrap().len(), 2);
        let error = run_jobs(jobs(), "c/", &effort, &|_| {}).unwrap_err();
        assert!(error.to_string().contains("the groups are a, b") && error.exit_status() == 2, "{error}");
    }
}
