//! The ladder, first rung: operations on lanes and the numbers of the samplers, against plain arithmetic; and who may name
//! whom in the sources.

mod lanes;
mod layering;
mod sobol;
