//! Rows of the samplers: four words for one address, by lanes and one at a time.

use crate::cli::bench::measure::{Case, Row};
use crate::clock::thread_cpu_seconds;
use crate::lanes::{LANES, U32x8};
use crate::packet::queues::{QueueNeeds, Slots};
use crate::render::fill_slots;
use crate::sampler::{ALL_WORDS, bsdf_block, sample_words};
use crate::settings::{Crop, Engine, Sampler};
use crate::simd::native::numbers::sample_words_x8;
use std::hint::black_box;

/// How the rows of this file begin.
pub const WHAT: &str = "four numbers, ";

/// Addresses in a round.
const ADDRESSES: usize = 1 << 16;

/// A round for each sampler and engine, whose words are compared first.
pub fn cases<'a>(seed: u32, faults: &mut Vec<String>) -> Vec<Case<'a>> {
    let mut cases = Vec::new();
    for &sampler in Sampler::ALL {
        let what = format!("{WHAT}{sampler}");
        let lanes = move |slots: &Slots, first: usize| {
            let (pixel, sample) = (U32x8::load(&slots.pixel, first), U32x8::load(&slots.sample, first));
            sample_words_x8::<ALL_WORDS>(sampler, pixel, sample, bsdf_block(1), seed)
        };
        let scalar = move |slots: &Slots, at: usize| {
            sample_words(sampler, slots.pixel[at], slots.sample[at], bsdf_block(1), seed)
        };
        let slots = addresses();
        let differ = |first: &usize| {
            let words = lanes(&slots, *first).map(U32x8::to_array);
            (0..LANES).any(|lane| words.map(|word| word[lane]) != scalar(&slots, first + lane))
        };
        if (0..ADDRESSES).step_by(LANES).any(|first| differ(&first)) {
            faults.push(format!("{what}: lanes and scalar code draw different numbers"));
        }
        for engine in [Engine::Packet, Engine::Scalar] {
            let (slots, what) = (addresses(), what.clone());
            cases.push(Box::new(move || {
                let start = thread_cpu_seconds();
                match engine {
                    Engine::Packet => (0..ADDRESSES).step_by(LANES).for_each(|first| {
                        black_box(lanes(&slots, first));
                    }),
                    Engine::Scalar => (0..ADDRESSES).for_each(|at| {
                        black_box(scalar(&slots, at));
                    }),
                }
                let seconds = thread_cpu_seconds() - start;
                vec![Row {
                    what: what.clone(),
                    engine: engine.name(),
                    ns_per_item: Some(seconds * 1e9 / ADDRESSES as f64),
                    clock: "cpu",
                    items: ADDRESSES as u64,
                    lanes_used: (engine == Engine::Packet).then_some(1.0),
                    ..Row::default()
                }]
            }) as Case);
        }
    }
    cases
}

/// The first 64 samples of 32 x 32 pixels, in the order of a tile.
fn addresses() -> Slots {
    let mut slots = Slots::new(ADDRESSES, QueueNeeds::default());
    fill_slots(&mut slots, &mut Vec::new(), Crop { x: 0, y: 0, width: 32, height: 32 }, 0, 64);
    slots
}
