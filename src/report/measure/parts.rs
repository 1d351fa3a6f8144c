//! Runs of one experiment, made by several machines: part K of N has every N-th run from the K-th on, in the order in which one
//! machine makes them. Each measures against a reference of the same bits; merging puts the runs in their order and adds up what
//! was pooled.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::files::sealed::{self, Found};
use crate::report::measure::experiment::{Experiment, Measurements, Run};
use crate::report::measure::run_error::Pool;
use crate::report::measure::truth::Reference;
use crate::settings::Shard;

const MAGIC: &str = "octray part of converge, version 1";

/// Writes the runs of a part to `path`, whole or not at all.
///
/// # Errors
/// [`Error::Write`].
pub fn write(
    path: &Path,
    experiment: &Experiment,
    shard: Shard,
    references: &[Reference],
    done: &Measurements,
) -> Result<()> {
    let header = (experiment.key(references), (shard.number, shard.count), &done.runs);
    sealed::write(path, MAGIC, &header, |out| {
        done.pools.iter().flatten().flat_map(Pool::numbers).try_for_each(|number| out.numbers(&[number]))
    })
}

/// The runs of all `paths`, which are all parts of `experiment`, as if one machine had made them.
///
/// # Errors
/// [`Error::Read`] and [`Error::Parse`] name the file that is none of its parts, damaged or there twice; [`Error::Usage`] the
/// parts that are missing.
pub fn merged(experiment: &mut Experiment, references: &[Reference], paths: &[PathBuf]) -> Result<Measurements> {
    let mut measured = experiment.start();
    let mut runs: Vec<(usize, Run)> = Vec::new();
    let mut found: Vec<(Shard, &Path)> = Vec::new();
    let pixels = experiment.pixels();
    let each = Pool::count_of_numbers(pixels);
    for path in paths {
        let fault = |message: String| Error::parse(path, None, message);
        let opened = sealed::open::<(String, (u32, u32), Vec<Run>)>(path, MAGIC)?;
        let ((key, (number, count), own), mut numbers) = match opened {
            Found::Whole(header, numbers) => (header, numbers),
            Found::OtherVersion => return Err(fault("a part by another version of octray".into())),
            Found::Damaged => {
                return Err(fault("not a part of converge, or a damaged one: make that part again".into()));
            }
        };
        if key != experiment.key(references) {
            return Err(fault("a part of other runs: scenes, flags, version or reference differ".into()));
        }
        let shard = Shard { number, count };
        if let Some((other, first)) = found.first()
            && other.count != count
        {
            return Err(fault(format!("part {shard}, and {} is {other}", first.display())));
        }
        if let Some((_, twin)) = found.iter().find(|(other, _)| *other == shard) {
            return Err(fault(format!("part {shard}, as {} is: leave one out", twin.display())));
        }
        // The runs are judged as those of the part.
        experiment.shard = Some(shard).filter(|shard| (1..=shard.count).contains(&shard.number));
        let sound = experiment.shard.is_some()
            && own.len() == experiment.run_count()
            && experiment.has_made(&own)
            && numbers.left() == each as u64 * measured.pools.iter().flatten().count() as u64;
        experiment.shard = None;
        if !sound {
            return Err(fault("a part that is not complete: make it again with the same --repeats".into()));
        }
        found.push((shard, path));
        runs.extend((0..).zip(own).map(|(own, run)| (number as usize - 1 + own * count as usize, run)));
        for pool in measured.pools.iter_mut().flatten() {
            let of_pool: Vec<f64> = numbers.by_ref().take(each).collect();
            if of_pool.len() != each || !of_pool.iter().all(|number| number.is_finite()) {
                return Err(fault("its sums are not finite: make that part again".into()));
            }
            pool.take(&Pool::from_numbers(&of_pool));
        }
    }
    let count = found.first().map_or(0, |(shard, _)| shard.count);
    let is_there = |number: &u32| found.iter().any(|(shard, _)| shard.number == *number);
    let missing: Vec<String> =
        (1..=count).filter(|number| !is_there(number)).map(|number| number.to_string()).collect();
    if !missing.is_empty() {
        let named = missing.iter().take(20).cloned().collect::<Vec<_>>().join(", ");
        return Err(Error::Usage(format!("{} of {count} parts are missing: {named}", missing.len())));
    }
    runs.sort_by_key(|(number, _)| *number);
    measured.runs = runs.into_iter().map(|(_, run)| run).collect();
    Ok(measured)
}
