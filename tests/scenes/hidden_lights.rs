//! The scenes whose light is hidden: `scenes/door_ajar.toml` and `builtin:rooms`. Their walls are closed, their lamps are hidden
//! from what they must be hidden from, and the direct light of the rooms is that of a closed form.

mod closed;
mod door_ajar;
mod rooms;
