//! What every stage is told.

use crate::packet::counters::Counters;
use crate::packet::decisions::Decisions;
use crate::packet::queues::TileState;
use crate::setup::Setup;

/// One round of stages of one render.
pub struct StageContext<'a> {
    /// The render.
    pub setup: &'a Setup<'a>,
    /// What was decided for it.
    pub decisions: &'a Decisions,
    /// Scattering events that lie behind the rays of this round: the number of the event that its hits come to.
    pub depth: u32,
}

/// A stage: reads some queues of a tile and appends to others.
pub type StageFn = fn(&StageContext, &mut TileState, &mut Counters);

impl StageContext<'_> {
    /// Whether the hits of this round scatter no more: all events are behind them.
    pub fn is_over(&self) -> bool {
        self.depth == self.setup.max_depth
    }

    /// Whether the event of this round is the last one.
    pub fn is_last_event(&self) -> bool {
        self.depth + 1 == self.setup.max_depth
    }
}
