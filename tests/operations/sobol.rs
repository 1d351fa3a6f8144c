//! The `sobol` sampler, by the numbers that lanes draw.
//!
//! Statistical bounds are 5 standard errors (a false alarm once in 1.7 million comparisons) or, for chi-square figures,
//! what corresponds to them; seeds are fixed, so a test that passes once passes always.

use octray::Sampler;
use octray::internal::lanes::{LANES, U32x8};
use octray::internal::sampler::sobol::{GROUPS, sobol_words};
use octray::internal::sampler::{ALL_WORDS, CAMERA_BLOCK, LIGHT_WORDS, LOBE_WORDS, PIXEL_WORDS, ROULETTE_WORD};
use octray::internal::sampler::{bsdf_block, light_block, sample_words, unit};
use octray::internal::simd::native::numbers::sobol::sobol_words_x8;

const SIGMAS: f64 = 5.0;

/// Blocks of every kind, and for each its words in the order of the dimensions that make them.
const BLOCKS: [(u32, [usize; 4]); 5] =
    [(0, [0, 1, 2, 3]), (1, [1, 2, 0, 3]), (2, [0, 1, 3, 2]), (7, [1, 2, 0, 3]), (40, [0, 1, 3, 2])];

/// The first `count` points of a group, by lanes; words in the order of dimensions.
fn points(pixel: u32, group: u32, (block, order): (u32, [usize; 4]), seed: u32, count: u32) -> Vec<[u32; 4]> {
    let mut points = Vec::new();
    for first in (0..count).step_by(LANES) {
        let sample = U32x8::from_array(std::array::from_fn(|lane| (first + lane as u32) * GROUPS + group));
        let words = sobol_words_x8::<ALL_WORDS>(U32x8::splat(pixel), sample, block, seed).map(U32x8::to_array);
        points.extend((0..LANES).map(|lane| order.map(|word| words[word][lane])));
    }
    points.truncate(count as usize);
    points
}

/// Generator matrices by their textbook definition: `[dimension][digit][bit of the index]`, digit 0 after the point.
fn matrices() -> [[[bool; 12]; 12]; 4] {
    type Matrix = [[bool; 12]; 12];
    let matrix = |entry: &dyn Fn(usize, usize) -> bool| -> Matrix {
        std::array::from_fn(|digit| std::array::from_fn(|bit| entry(digit, bit)))
    };
    // Initial numbers and the inner coefficients of the polynomial, as Joe and Kuo print them.
    let sobol = |initial: &[u64], inner: u64| {
        let degree = initial.len();
        let mut m = initial.to_vec();
        for k in degree..12 {
            let mut next = m[k - degree] ^ m[k - degree] << degree;
            for i in 1..degree {
                next ^= (inner >> (degree - 1 - i) & 1) * (m[k - i] << i);
            }
            m.push(next);
        }
        // v = m / 2^(bit + 1): digit 0 is its half.
        matrix(&|digit, bit| digit <= bit && m[bit] >> (bit - digit) & 1 == 1)
    };
    // The second is Pascal's triangle modulo 2, by Lucas's theorem.
    [
        matrix(&|digit, bit| digit == bit),
        matrix(&|digit, bit| digit & bit == digit),
        sobol(&[1, 3], 1),
        sobol(&[1, 1, 3], 1),
    ]
}

/// Rank over GF(2).
fn rank(rows: &[u32]) -> u32 {
    let mut basis: Vec<u32> = Vec::new();
    for &row in rows {
        let rest = basis.iter().fold(row, |row, &vector| row.min(row ^ vector));
        if rest != 0 {
            basis.push(rest);
        }
    }
    basis.len() as u32
}

#[test]
fn lanes_have_the_bits_of_the_scalar_twin() {
    for first in 0..3000u32 {
        let pixel: [u32; LANES] = std::array::from_fn(|lane| first * 977 + lane as u32 * 65_536);
        // Neighbours, as in tiles; and samples of every size at once.
        let sample: [u32; LANES] = std::array::from_fn(|lane| match first % 3 {
            0 => first.wrapping_mul(2_654_435_761) >> (lane * 4),
            1 => u32::MAX - lane as u32 * first,
            _ => first / 7 + lane as u32,
        });
        for block in [CAMERA_BLOCK, light_block(first), bsdf_block(first * 50)] {
            let (pixels, samples) = (U32x8::from_array(pixel), U32x8::from_array(sample));
            let four = sobol_words_x8::<ALL_WORDS>(pixels, samples, block, first).map(U32x8::to_array);
            let three = sobol_words_x8::<LIGHT_WORDS>(pixels, samples, block, first).map(U32x8::to_array);
            let two = sobol_words_x8::<PIXEL_WORDS>(pixels, samples, block, first).map(U32x8::to_array);
            let lobe = sobol_words_x8::<LOBE_WORDS>(pixels, samples, block, first).map(U32x8::to_array);
            let roulette = sobol_words_x8::<ROULETTE_WORD>(pixels, samples, block, first).map(U32x8::to_array);
            let bsdf = block > 0 && block % 2 == 0;
            let unused = if bsdf { 2 } else { 3 };
            for lane in 0..LANES {
                let scalar = sobol_words(pixel[lane], sample[lane], block, first);
                assert_eq!(scalar, sample_words(Sampler::Sobol, pixel[lane], sample[lane], block, first));
                assert_eq!(four.map(|word| word[lane]), scalar, "sample {}", sample[lane]);
                for word in (0..4).filter(|&word| word != unused) {
                    assert_eq!(three[word][lane], scalar[word]);
                }
                assert!(
                    !bsdf || [lobe[2][lane], lobe[3][lane], roulette[3][lane]] == [scalar[2], scalar[3], scalar[3]]
                );
                assert!(block != CAMERA_BLOCK || [two[0][lane], two[1][lane]] == [scalar[0], scalar[1]]);
            }
        }
    }
}

/// Every way to cut the unit cube into 2^m or fewer equal boxes of sides 2^-k: the points fill them as those of the textbook
/// matrices do, all boxes equally where the rows that name them are independent. Scrambles and shuffles of another kind, or
/// other matrices, would not.
#[test]
fn points_are_the_textbook_nets_scrambled() {
    let matrices = matrices();
    for block in BLOCKS {
        for m in 0..=7u32 {
            let points = points(3 << 16 | 5, m % GROUPS, block, 11, 1 << m);
            for cut in 0..(m + 1).pow(4) {
                let k = [0, 1, 2, 3].map(|d| cut / (m + 1).pow(d) % (m + 1));
                if k.iter().sum::<u32>() > m {
                    continue;
                }
                let row = |d: usize, digit: u32| {
                    let columns = (0..m).filter(|&bit| matrices[d][digit as usize][bit as usize]);
                    columns.map(|bit| 1 << bit).sum::<u32>()
                };
                let rows: Vec<u32> = (0..4).flat_map(|d| (0..k[d]).map(move |digit| row(d, digit))).collect();
                let rank = rank(&rows);
                let mut boxes = std::collections::HashMap::new();
                for point in &points {
                    let name = std::array::from_fn::<u64, 4, _>(|d| u64::from(point[d]) >> (32 - k[d]));
                    *boxes.entry(name).or_insert(0u32) += 1;
                }
                assert_eq!(boxes.len(), 1 << rank, "block {block:?}, 2^{m} points, cut {k:?}");
                assert!(boxes.values().all(|&count| count == 1 << (m - rank)), "2^{m} points, cut {k:?}");
                // The best pair, and every dimension alone: one point each.
                assert!(k[2] + k[3] > 0 || rank == k[0] + k[1], "a (0, {m}, 2)-net");
                assert!(k.iter().filter(|&&k| k > 0).count() > 1 || rank == k.iter().sum::<u32>());
            }
        }
    }
}

/// Later runs of 2^m points are nets as the first ones are, and long sets stay stratified in every dimension.
#[test]
fn every_aligned_run_of_points_is_stratified() {
    for block in BLOCKS {
        let all = points(77, 1, block, 3, 1 << 13);
        for m in [3, 6, 10, 13] {
            for run in all.chunks(1 << m) {
                for dimension in 0..4 {
                    let mut cells = vec![false; 1 << m];
                    run.iter().for_each(|point| cells[(point[dimension] >> (32 - m)) as usize] = true);
                    assert!(cells.iter().all(|&hit| hit), "block {block:?}, runs of 2^{m}, dimension {dimension}");
                }
            }
        }
    }
}

/// Chi-square of counts that should be equal, in standard deviations beyond its mean (Wilson and Hilferty 1931).
fn unevenness(counts: &[u32]) -> f64 {
    let mean = counts.iter().sum::<u32>() as f64 / counts.len() as f64;
    let freedom = (counts.len() - 1) as f64;
    let chi_square: f64 = counts.iter().map(|&count| (count as f64 - mean).powi(2) / mean).sum();
    let spread = 2.0 / (9.0 * freedom);
    ((chi_square / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// One point alone is as random as an independent one: every bit of every word, words of a block together, points of two
/// groups, two pixels, two blocks together.
#[test]
fn single_points_are_uniform_over_scrambles() {
    let count = 1 << 16;
    for (block, sample) in [(0, 0), (1, 0), (2, 4), (1, 23), (2, 64), (3, 1001), (4, 70_000)] {
        let words: Vec<[u32; 4]> = (0..count).map(|pixel| sobol_words(pixel, sample, block, 9)).collect();
        let others: [Vec<[u32; 4]>; 3] = [
            (0..count).map(|pixel| sobol_words(pixel, sample + 1, block, 9)).collect(),
            (0..count).map(|pixel| sobol_words(pixel + 1, sample, block, 9)).collect(),
            (0..count).map(|pixel| sobol_words(pixel, sample, block + 2, 9)).collect(),
        ];
        let check = |what: &str, cell: &dyn Fn(usize) -> u32| {
            let mut cells = [0; 256];
            (0..count as usize).for_each(|i| cells[cell(i) as usize] += 1);
            let sigmas = unevenness(&cells);
            assert!(sigmas < SIGMAS, "block {block}, sample {sample}, {what}: {sigmas:.1}");
        };
        for a in 0..4 {
            for shift in [24, 16, 8, 0] {
                check(&format!("word {a} >> {shift}"), &|i| words[i][a] >> shift & 255);
            }
            for b in 0..4 {
                if a < b {
                    check(&format!("words {a}, {b}"), &|i| words[i][a] >> 28 << 4 | words[i][b] >> 28);
                }
                for (others, what) in others.iter().zip(["group", "pixel", "block"]) {
                    let what = format!("words {a}, {b} of another {what}");
                    check(&what, &|i| words[i][a] >> 28 << 4 | others[i][b] >> 28);
                }
            }
        }
        check("all words", &|i| words[i].iter().fold(0, |cell, word| cell << 2 | word >> 30));
        check("all words, second digits", &|i| words[i].iter().fold(0, |cell, word| cell << 2 | word >> 29 & 3));
    }
}

/// exp(x) over its mean, less 1: smooth and not symmetric.
fn ramp(word: u32) -> f64 {
    f64::from(unit(word)).exp() / (1f64.exp() - 1.0) - 1.0
}

/// Mean squared error of the mean of `count` points, over scrambles, and how many standard errors their mean is off.
fn mean_squared_error(f: impl Fn(u32, u32) -> f64, scrambles: u32, count: u32) -> (f64, f64) {
    let means: Vec<f64> = (0..scrambles)
        .map(|pixel| (0..count).map(|point| f(pixel, point * GROUPS)).sum::<f64>() / count as f64)
        .collect();
    let squares = means.iter().map(|mean| mean * mean).sum::<f64>() / scrambles as f64;
    let off = means.iter().sum::<f64>() / (scrambles as f64 * squares).sqrt();
    (squares, off)
}

/// A smooth function of some words, of mean 0: its error falls as n^-3 but for logarithms (Owen 1997), where that of
/// independent numbers falls as n^-1; the mean over scrambles is right at every n, a power of two or not.
#[test]
fn smooth_integrands_converge_faster_than_1_over_n() {
    let by = |words: &'static [usize], block: u32| {
        move |pixel: u32, sample: u32| {
            let all = sobol_words(pixel, sample, block, 21);
            words.iter().map(|&word| 1.0 + ramp(all[word])).product::<f64>() - 1.0
        }
    };
    for (block, words, steepest) in [
        (0, &[0][..], -2.8),
        (2, &[2], -2.8),
        (1, &[3], -2.8),
        (0, &[0, 1], -2.4),
        (1, &[1, 2], -2.4),
        (0, &[2, 3], -2.2),
        (1, &[0, 1, 2], -2.0),
        (2, &[0, 1, 2, 3], -1.7),
    ] {
        let (mut xs, mut ys) = (Vec::new(), Vec::new());
        for log in 4..=12 {
            let (error, off) = mean_squared_error(by(words, block), 48, 1 << log);
            assert!(off.abs() < SIGMAS, "block {block}, words {words:?}, 2^{log} points: {off:.1} standard errors off");
            xs.push(f64::from(log));
            ys.push(error.log2());
        }
        let n = xs.len() as f64;
        let (x, y) = (xs.iter().sum::<f64>() / n, ys.iter().sum::<f64>() / n);
        let slope = xs.iter().zip(&ys).map(|(a, b)| (a - x) * (b - y)).sum::<f64>()
            / xs.iter().map(|a| (a - x) * (a - x)).sum::<f64>();
        println!("block {block}, words {words:?}: n^{slope:.2}");
        assert!(slope < steepest, "block {block}, words {words:?}: n^{slope:.2}");
    }
    for count in [1, 3, 5, 12, 33, 100, 129, 1000] {
        let (error, off) = mean_squared_error(by(&[0, 1, 2, 3], 2), 2000, count);
        let alone = mean_squared_error(by(&[0, 1, 2, 3], 2), 20_000, 1).0;
        assert!(off.abs() < SIGMAS, "{count} points: {off:.1} standard errors off");
        assert!(error < 1.2 * alone / f64::from(count), "{count} points: never worse than independent ones");
    }
}

/// Two blocks know nothing of each other but the order of their points, in which a pair of neighbours is a pair in both. What
/// depends on two blocks and on neither alone is then up to twice as noisy as with independent samples (twice, for signs of
/// the first digits), never more; its mean is right.
#[test]
fn blocks_together_are_at_most_twice_as_noisy() {
    for log in [2, 3, 4, 6, 8] {
        for (a, b) in [(0, 1), (1, 2), (2, 3), (2, 4), (1, 9)] {
            let both = |pixel: u32, sample: u32| {
                ramp(sobol_words(pixel, sample, a, 5)[1]) * ramp(sobol_words(pixel, sample, b, 5)[1])
            };
            let (error, off) = mean_squared_error(both, 4000, 1 << log);
            let variance = mean_squared_error(both, 40_000, 1).0;
            let ratio = error * f64::from(1 << log) / variance;
            assert!(off.abs() < SIGMAS, "blocks {a}, {b}: {off:.1} standard errors off");
            // 4,000 squares of nearly normal means: the ratio's standard error is about 2.5 %.
            assert!((0.9..2.0).contains(&ratio), "blocks {a}, {b}, 2^{log} points: {ratio:.3}");
        }
    }
}

/// The image of errors of a smooth integrand is white noise: its power spectrum is flat in rings, and no pixel knows of its
/// neighbours.
#[test]
fn errors_of_pixels_are_white_noise() {
    const SIDE: usize = 64;
    for (block, word, samples) in [(0, 0, 64), (1, 1, 20), (2, 0, 16)] {
        let error = |x: usize, y: usize| {
            let pixel = octray::internal::sampler::pixel_address(x as u32, y as u32);
            (0..samples).map(|sample| ramp(sobol_words(pixel, sample, block, 0)[word])).sum::<f64>()
        };
        let image: Vec<Vec<f64>> = (0..SIDE).map(|y| (0..SIDE).map(|x| error(x, y)).collect()).collect();
        let power = image.iter().flatten().map(|e| e * e).sum::<f64>();
        // A plain Fourier transform, rows then columns.
        let wave = |k: usize| std::f64::consts::TAU * (k % SIDE) as f64 / SIDE as f64;
        let rows: Vec<Vec<[f64; 2]>> = image
            .iter()
            .map(|row| {
                let term = |u: usize| {
                    let part = |f: fn(f64) -> f64| (0..SIDE).map(|x| row[x] * f(wave(u * x))).sum();
                    [part(f64::cos), part(f64::sin)]
                };
                (0..SIDE).map(term).collect()
            })
            .collect();
        let mut rings = [(0.0, 0.0); 8];
        for v in 0..SIDE {
            // Of the two equal halves of a real image's spectrum, one, without the terms that are their own mirror images.
            for u in 1..SIDE / 2 {
                let (mut re, mut im) = (0.0, 0.0);
                for (y, row) in rows.iter().enumerate() {
                    let (sine, cosine) = wave(v * y).sin_cos();
                    re += row[u][0] * cosine - row[u][1] * sine;
                    im += row[u][0] * sine + row[u][1] * cosine;
                }
                let frequency = ((u * u + v.min(SIDE - v).pow(2)) as f64).sqrt();
                let ring = &mut rings[((frequency / (SIDE / 2) as f64 * 6.0) as usize).min(7)];
                ring.0 += (re * re + im * im) / power;
                ring.1 += 1.0;
            }
        }
        for (ring, (sum, count)) in rings.into_iter().enumerate() {
            // Powers of white noise are exponential numbers of mean 1.
            let sigmas = (sum / count - 1.0) * f64::sqrt(count);
            assert!(sigmas.abs() < SIGMAS, "block {block}, ring {ring} of {count} waves: {sigmas:.1}");
        }
        for (dx, dy) in [(1, 0), (0, 1), (1, 1), (2, 0), (0, 2), (4, 0), (0, 4), (8, 8), (16, 0), (0, 16)] {
            let product = |i: usize| image[i / SIDE][i % SIDE] * image[(i / SIDE + dy) % SIDE][(i % SIDE + dx) % SIDE];
            let sigmas = (0..SIDE * SIDE).map(product).sum::<f64>() / power * SIDE as f64;
            assert!(sigmas.abs() < SIGMAS, "block {block}, pixels {dx},{dy} apart: {sigmas:.1}");
        }
    }
}
