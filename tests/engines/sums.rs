//! The radiance of long paths: sums that lose nothing, the same in both engines, and closed boxes that they are needed for.

use crate::common::{Maker, first_difference, small};
use octray::internal::packet::queues::RadianceSum;
use octray::internal::reference::single::{Vec3, observer::CompensatedSum};
use octray::internal::sampler::{random_words, unit};
use octray::{Engine, Settings, Strategy, render};

/// Both engines' sums of the same terms, which must have the same bits.
fn sum(terms: impl Iterator<Item = [f32; 3]>) -> [f32; 3] {
    let (mut packet, mut scalar) = (RadianceSum::default(), CompensatedSum::default());
    for [r, g, b] in terms {
        packet.add([r, g, b, 0.0]);
        scalar.add(Vec3::new(r, g, b));
    }
    let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
    let (packet, scalar) = (packet.value(), scalar.value().to_array());
    assert!(packet.iter().zip(&scalar).all(same), "{packet:?} and {scalar:?}");
    packet
}

/// Long series of all shapes against their sums in f64, within one rounding.
#[test]
fn sums_of_a_million_terms_are_right_to_the_last_bit_or_two() {
    const TERMS: u32 = 1 << 20;
    let number = |i: u32, k: u32| unit(random_words(i, k, 1, 77)[0]);
    let series: [(&str, &dyn Fn(u32) -> f32); 6] = [
        ("alike", &|_| 0.1),
        ("geometric", &|i| 0.99999f64.powi(i as i32) as f32),
        ("random", &|i| number(i, 0)),
        ("one huge, then tiny", &|i| if i == 0 { 1e9 } else { 1e-3 }),
        ("tiny, then one huge", &|i| if i == TERMS - 1 { 1e9 } else { 1e-3 }),
        ("of all sizes", &|i| 10f32.powi((30.0 * number(i, 1)) as i32 - 15) * number(i, 2)),
    ];
    for (name, term) in series {
        let exact: f64 = (0..TERMS).map(|i| f64::from(term(i))).sum();
        let [got, scaled, _] = sum((0..TERMS).map(|i| [term(i), 0.5 * term(i), 0.0]));
        assert!((f64::from(got) / exact - 1.0).abs() < 1.2e-7, "{name}: {got}, not {exact}");
        assert_eq!(scaled, 0.5 * got, "{name}");
    }
}

/// What is not finite stays so, whatever comes after it; sums of nothing are 0.
#[test]
fn what_is_not_finite_is_never_lost() {
    for bad in [f32::NAN, f32::INFINITY] {
        for at in 0..3 {
            let [got, fine, _] = sum((0..3).map(|i| [if i == at { bad } else { 1.0 }, 1.0, 0.0]));
            assert!(!got.is_finite() && fine == 3.0, "{got} {fine}");
        }
    }
    assert!(!sum([[3e38; 3], [3e38; 3]].into_iter())[0].is_finite());
    assert_eq!(sum([[0.0; 3], [1e-45; 3]].into_iter()), [1e-45; 3]);
}

/// A closed box whose walls all emit 1: after `depth` events a path has gathered the geometric sum of the f32 albedo, to
/// 1e-5 (albedo 0.9999) and 1e-4 (0.99999: its throughput, rounded 3e5 times, has wandered off by then).
#[test]
fn closed_boxes_have_their_geometric_sums() {
    for (albedo, depth, bound) in
        [(0.5, 40, 1e-6), (0.99, 2_000, 2e-6), (0.9999, 150_000, 1e-5), (0.99999, 300_000, 1e-4)]
    {
        let mut maker = Maker::default();
        let wall = maker.diffuse([albedo, 0.5 * albedo, 0.0], [1.0; 3]);
        maker.cuboid([-1.0; 3], [1.0; 3], true, wall);
        let scene = maker.seen([0.1, 0.2, 0.3], [0.4, -0.1, -1.0], 40.0);
        let settings = Settings { strategy: Strategy::Bsdf, max_depth: Some(depth), rr_depth: None, ..small(4, 2, 1) };
        let film = render(&scene, &settings).film;
        for (channel, albedo) in [albedo, 0.5 * albedo, 0.0].into_iter().enumerate() {
            let albedo = f64::from(albedo as f32);
            let truth = (1.0 - albedo.powi(depth as i32 + 1)) / (1.0 - albedo);
            for pixel in &film.pixels {
                let error = pixel.sum[channel] / truth - 1.0;
                assert!(error.abs() < bound, "albedo {albedo}: {} instead of {truth}: {error:e}", pixel.sum[channel]);
            }
            println!("albedo {albedo}: relative error {:e}", film.pixels[0].sum[channel] / truth - 1.0);
        }
        if depth < 10_000 {
            let scalar = render(&scene, &Settings { engine: Engine::Scalar, ..settings }).film;
            assert_eq!(first_difference(&film, &scalar), None, "albedo {albedo}");
        }
    }
}
