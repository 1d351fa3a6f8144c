//! What real scenes do to a renderer: odd scales, places far from the origin, closed meshes, slivers, lights that touch
//! walls, emission of 1e-20 and 1e20. No sample may be anything but finite, and both engines must have the same bits.

#[path = "robust/closed.rs"]
mod closed;
mod common;
#[path = "robust/limits.rs"]
mod limits;
#[path = "robust/shapes.rs"]
mod shapes;
#[path = "robust/stiff.rs"]
mod stiff;
#[path = "robust/twins.rs"]
mod twins;
