use octray::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let scene = Scene::load(&a[1]).unwrap();
    let p = scene.prepare().unwrap();
    let mut s = Settings {
        spp: a[2].parse().unwrap(),
        width: Some(a[3].parse().unwrap()),
        height: Some(a[3].parse().unwrap()),
        threads: 1,
        ..scene.settings()
    };
    if a.len() > 4 {
        s.max_depth = a[4].parse().ok();
    }
    for e in [Engine::Packet, Engine::Scalar] {
        if std::env::var("ONLY_PACKET").is_ok() && e == Engine::Scalar {
            continue;
        }
        let r = render(&p, &Settings { engine: e, ..s.clone() });
        println!(
            "{e}: cpu {:.3} wall {:.3} Mpaths/s {:.3} rays {:?} Mrays/s {:.2} mean {:?}",
            r.stats.cpu_s,
            r.stats.render_s,
            r.stats.paths as f64 / r.stats.cpu_s / 1e6,
            r.stats.rays,
            r.stats.rays.total() as f64 / r.stats.cpu_s / 1e6,
            r.film.mean_radiance()
        );
        for t in &r.stats.stages {
            println!(
                "   {:22} {:6.1}% lanes {:.1}%",
                t.stage,
                t.seconds / r.stats.cpu_s * 100.,
                t.lanes_used as f64 / t.lanes_possible as f64 * 100.
            );
        }
    }
}
