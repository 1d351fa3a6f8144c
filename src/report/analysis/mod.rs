//! Analysing: what the runs of an experiment say, with their intervals.
//!
//! **Law:** it reads what was measured and writes nothing. (Images at equal time are rendered here, since only findings say
//! how many samples equal time is.)

pub mod bias;
pub mod curve;
pub mod equal_time;
pub mod findings;
pub mod level;
pub mod point;
pub mod statistics;
pub mod summary;
