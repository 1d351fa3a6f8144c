//! Error against run time: how far pictures are from each other and from the truth, and what it costs to get there.
//!
//! **Law:** nothing here knows of flags, terminals or exit codes, and nothing here decides anything in a render. Metrics and
//! statistics are plain f64 on whole pictures, written from their definitions.
//!
//! Data flows one way: [`measure::experiment`] runs what is asked for, interleaved, and takes each run's error
//! ([`measure::run_error`]) against a truth ([`measure::reference`]); [`analysis::findings`] turns runs into findings by means
//! of [`analysis::statistics`]; [`write::words`], [`write::figures`] and [`write::plot`], [`write::page`] and
//! [`write::results`] say them.
//!
//! # How to read a report
//!
//! **The error** is the root of relMSE (see [`measure::metrics`]): 5 % means that pixels are off by about 5 % of what they should
//! show, black ones counting with a floor of 0.1. It is measured against a reference, not guessed from the samples.
//!
//! **The plots** have logarithmic axes, on which the law of random sampling, error = c / sqrt(n), is a straight line of
//! slope -0.5: four times the samples halve the error. Two lines of that slope keep their distance, and the horizontal
//! distance is what counts: how many times as long the upper one takes for the same error. The plot against samples shows
//! what a sample is worth; the plot against seconds also what it costs. A line that bends to the horizontal is biased: more
//! samples bring it closer to a wrong picture, and the dotted level is how wrong that is. Wide bands at few samples mean
//! that rare bright samples rule: some runs have met one and some have not.
//!
//! **Efficiency** is 1 / (relMSE x CPU seconds). Time and relMSE of an exact strategy trade one for one, so the figure is the
//! same at every budget, and the ratio of two efficiencies is the ratio of times to the same error.
//!
//! **Slopes** are of MSE against samples: -1 for independent samples, steeper where samples know of each other, flatter for
//! biased pictures. The interval tells whether -1 is excluded; nine of 95 % would miss
//! one slope in three reports, so they are widened until all hold at once in 95 of 100. At few samples of a heavy-tailed strategy the mean MSE itself
//! is uncertain, and slopes of such a strategy say little; the interval is then wide.
//!
//! **Bias** is the difference of the mean of all pictures of a configuration from the reference's mean. Its score z is that
//! over its standard error. Noise stays within 3; beyond 5 the strategy is called biased. All strategies share one reference,
//! whose own mean is a little off by chance: so the scores of good strategies lean to the same side. A strategy that is exact
//! and still too dark, with its noise in few pixels, is called undersampled ([`analysis::findings::Verdict`]): what no sample has found,
//! no standard error knows.
//!
//! **Seconds** are CPU seconds of all threads, of rendering alone; wall seconds of every run are in `converge.csv`. On a busy
//! machine CPU seconds move by some per cent, wall seconds by whole factors.
//!
//! What is not there: FLIP. The one crate that offers it (`nv-flip`, last released in 2023) compiles C++ and would make a C++
//! compiler a condition of building octray.

pub mod analysis;
pub mod measure;
pub mod write;
