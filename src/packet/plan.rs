//! The plan: the stages that a render needs, in the order in which they run.
//!
//! **Invariant:** a stage that is not needed is not in the list, is never called, and its queue holds no memory. A stage's
//! variant is chosen here, once, at the SIMD level in use; [`super::explain`] says of the same list what it does and what was
//! left out.

use crate::packet::context::StageFn;
use crate::packet::counters::Stage;
use crate::packet::decisions::Decisions;
use crate::packet::queues::TileState;
use crate::setup::Setup;
use crate::simd::by_level;

/// What a render runs.
pub struct Plan {
    /// Makes the rays of the first round.
    pub generate_camera_rays: StageFn,
    /// The stages of a round of a pass for layers ([`super::layers`]), in order.
    pub layers_round: [StageFn; 2],
    /// The stages of a round, in order.
    pub round: Vec<(Stage, StageFn)>,
    /// What the stages read.
    pub decisions: Decisions,
}

impl Plan {
    /// The plan of one render.
    pub fn new(setup: &Setup) -> Plan {
        let decisions = Decisions::new(setup);
        let (generate_camera_rays, layers_round, round) = by_level!(kernels::variants::stages(setup, &decisions));
        Plan { generate_camera_rays, layers_round, round, decisions }
    }

    /// One thread's queues, for `capacity` paths.
    pub fn tile_state(&self, capacity: usize) -> TileState {
        self.decisions.tile_state(capacity)
    }
}
