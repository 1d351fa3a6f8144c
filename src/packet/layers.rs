//! The pass for layers over one tile: camera rays, and what they hit.

use crate::film::layers::FirstHit;
use crate::packet::context::StageContext;
use crate::packet::counters::Counters;
use crate::packet::plan::Plan;
use crate::packet::queues::TileState;
use crate::packet::tile::begin;
use crate::setup::Setup;

/// Finds what the camera rays of the samples in `state.slots` hit; it is then in `state.first_hits`.
pub fn find_first_hits(setup: &Setup, plan: &Plan, state: &mut TileState, counters: &mut Counters) {
    begin(setup, plan, state, counters);
    state.first_hits.clear();
    state.first_hits.resize(state.slots.len, FirstHit::NONE);
    let mut depth = 0;
    while state.paths.len > 0 {
        let context = StageContext { setup, decisions: &plan.decisions, depth };
        state.next.len = 0;
        plan.layers_round.iter().for_each(|run| run(&context, state, counters));
        std::mem::swap(&mut state.paths, &mut state.next);
        depth += 1;
    }
}
