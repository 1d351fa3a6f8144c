//! Whole renders in wall time, one thread: throughput is in camera paths, packet engine beside scalar reference.
//!
//! `cargo bench --bench render`. Both engines' pictures are first checked to be the same, bit for bit. `octray bench`
//! states CPU time and tells the stages apart.

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use octray::{Engine, Scene, Settings, render};
use std::hint::black_box;
use std::time::Duration;

const SCENES: [(&str, &str); 3] = [
    ("cornell", concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell.toml")),
    ("furnace", concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/furnace.toml")),
    ("heavy 50000", "builtin:heavy:50000"),
];

fn renders(criterion: &mut Criterion) {
    for (name, path) in SCENES {
        let scene = Scene::load(path).expect("a scene of ours");
        let prepared = scene.prepare().expect("a scene of ours");
        let by =
            |engine| Settings { engine, spp: 4, threads: 1, width: Some(96), height: Some(96), ..scene.settings() };
        let [packet, scalar] = [Engine::Packet, Engine::Scalar].map(|engine| render(&prepared, &by(engine)));
        assert!(packet.film.pixels == scalar.film.pixels, "{name}: the engines give different pictures");

        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(packet.stats.paths)).sampling_mode(SamplingMode::Flat);
        for engine in [Engine::Packet, Engine::Scalar] {
            let settings = by(engine);
            group.bench_function(engine.name(), |b| b.iter(|| black_box(render(&prepared, &settings))));
        }
        group.finish();
    }
}

fn short() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .sample_size(10)
}

criterion_group! {
    name = whole;
    config = short();
    targets = renders
}
criterion_main!(whole);
