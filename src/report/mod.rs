//! Error against run time: how far images are from each other and from the truth, and what it costs to get there.
//!
//! **Law:** nothing here knows of flags, terminals or exit codes, and nothing here decides anything in a render. Metrics and
//! statistics are plain f64 on whole images, written from their definitions.
//!
//! Data flows one way: [`measure::experiment`] runs what is asked for, interleaved, and takes each run's error
//! ([`measure::run_error`], [`measure::spectrum`]) against a truth ([`measure::reference`]); [`analysis::findings`] turns runs
//! into findings by means of [`analysis::point`], [`analysis::curve`], [`analysis::level`] and [`analysis::bias`], and
//! [`analysis::summary`] ranks them; [`write::contents`] holds
//! all of it, and [`write::words`], [`write::figures`] and [`write::plot`], [`write::page`] and [`write::results`] say it.
//!
//! # How to read a report
//!
//! **The error** is everywhere the root of relMSE (see [`measure::metrics`]): 5 % means that pixels are off by about 5 % of
//! what they should show, black ones counting with a floor of 0.1. It is measured against a reference, not guessed from the
//! samples. (What `octray render` tells of its own image, without a reference, is its *noise*: the root of the mean variance
//! of the pixels by the mean radiance. Bright pixels rule it, where relMSE has all pixels count alike.)
//!
//! **The plots** have logarithmic axes, on which the law of random sampling, error = c / sqrt(n), is a straight line of
//! slope -0.5: four times the samples halve the error. Two lines of that slope keep their distance, and the horizontal
//! distance is what counts: how many times as long the upper one takes for the same error. The plot against samples shows
//! what a sample is worth; the plot against seconds also what it costs. A line that bends to the horizontal is biased: more
//! samples bring it closer to a wrong image, and the dotted level, with its interval, is how wrong that is. Wide bands at few
//! samples mean that rare bright samples rule: some runs have met one and some have not. Where a few pixels hold most of the
//! error there is no band, since none would hold the truth ([`analysis::point::Point::outliers`]).
//!
//! **Efficiency** is 1 / (relMSE x CPU seconds) at the largest budget. Of independent samples it is the same at every budget,
//! and the ratio of two efficiencies is the ratio of times to the same error. Where samples know of each other it grows with the
//! budget, and that ratio depends on the error: so times to one error are told with that error.
//!
//! **Slopes** are of the error against samples: -0.5 for independent samples, steeper where samples know of each other. The
//! interval tells whether -0.5 is excluded; nine of 95 % would miss one slope in three reports, so they are widened until all
//! hold at once in 95 of 100. What lies outside of the measured budgets is told as extrapolated, from the last budget along the
//! slope of the last three and with an interval that holds that slope's as well ([`analysis::curve`]); `--reach` runs on instead.
//!
//! **Intervals** hold the truth in 95 of 100 cases; tests with synthetic runs count how often (93 to 97 % for every kind that
//! is printed). They come from the spread of the runs in every tile of the film ([`analysis::statistics::Estimate`]).
//!
//! **Bias** is the difference of the mean of all images of a configuration from the reference's mean. Its score z is that
//! over its standard error. Noise stays within 3; beyond 5 the strategy is called biased. All strategies share one reference,
//! whose own mean is a little off by chance: so the scores of good strategies lean to the same side. A strategy that is exact
//! and still too dark, with its noise in few pixels, is called undersampled ([`analysis::findings::Verdict`]): what no sample
//! has found, no standard error knows.
//!
//! **What the error is made of**: the spread of the MSE of single runs (Celarek et al. 2019), the error without the worst
//! pixel of every thousand, its power spectrum, and how full the SIMD lanes were, in the shading stages and in the tree.
//!
//! **Seconds** are CPU seconds of all threads, of rendering alone; wall seconds of every run are in `converge.csv`. On a busy
//! machine CPU seconds move by some per cent, wall seconds by whole factors. Intervals do not hold that.

pub mod analysis;
pub mod measure;
pub mod write;
