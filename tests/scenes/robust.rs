//! What real scenes do to a renderer: odd scales, places far from the origin, closed meshes, slivers, lights that touch
//! walls, emission of 1e-20 and 1e20. No sample may be anything but finite, and both engines must have the same bits.

mod closed;
mod limits;
mod radiance;
mod shapes;
mod stiff;
mod twins;
