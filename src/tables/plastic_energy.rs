//! How much of a plastic's base may shine through its coat, so that the two together never reflect more than arrives.
//!
//! Computed while loading, in f64, with `libm` for sines: the same bits on every platform.

use std::f64::consts::PI;

/// The factor on a plastic's albedo.
///
/// The base reflects albedo (1 - F(o)) (1 - F(i)) / pi times this. With 1 / mean(1 - F) a smooth coat and a white base
/// together reflect exactly 1. A rough coat can reflect more than F(o), by far where F has a deep minimum near grazing
/// (indices above 3): there the factor is lowered until no direction reflects more than 1.
pub fn base_scale(ior: f64, alpha: f64) -> f64 {
    let [coarse, fine, finer, finest] = [(16, 16), (32, 48), (48, 64), (64, 96)].map(|(m, n)| Quadrature::new(m, n));
    let room = |quadrature: &Quadrature, cosine: f64| quadrature.room(cosine, ior, alpha);
    // Cosines from 1e-6 to 1, a quarter more each: what is sought is as wide as its own cosine.
    const LAST: usize = 60;
    let cosine = |i: usize| libm::pow(1e-6, 1.0 - i as f64 / LAST as f64);
    let lowest = (0..=LAST).map(|i| (room(&coarse, cosine(i)), i)).reduce(|a, b| if b.0 < a.0 { b } else { a });
    let at = lowest.map_or(LAST, |(_, i)| i);
    // Ternary search between the neighbours.
    let (mut low, mut high) = (cosine(at.saturating_sub(1)), cosine((at + 1).min(LAST)));
    for _ in 0..10 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if room(&fine, a) < room(&fine, b) { high = b } else { low = a }
    }
    let cosine = 0.5 * (low + high);
    let (checked, lowest) = (room(&finer, cosine), room(&finest, cosine));
    // Twice what two rules differ by, and what was found to cover the rest of their errors and those of the search: the
    // higher the index, the sharper the minimum near grazing.
    let sure = lowest - 2.0 * (lowest - checked).abs() - 3e-5 * ior;
    sure.min(1.0 - 1e-5) / mean_transmittance(ior)
}

/// Mean of 1 - F over the cosine-weighted hemisphere: the integral of (1 - F(c)) 2 c dc.
fn mean_transmittance(ior: f64) -> f64 {
    // In the root of the cosine: next to grazing 1 - F is steep.
    let mean = |(root, weight): (f64, f64)| weight * transmittance(root * root, ior) * 4.0 * root * root * root;
    gauss_legendre(64).into_iter().map(mean).sum()
}

/// 1 - F from outside, for unpolarised light: a sum of positive terms, so that no digit is lost however little it is.
fn transmittance(cosine: f64, ior: f64) -> f64 {
    let cosine_t = ((ior - 1.0) * (ior + 1.0) + cosine * cosine).sqrt() / ior;
    let (perpendicular, parallel) = (cosine + ior * cosine_t, ior * cosine + cosine_t);
    2.0 * ior * cosine * cosine_t * (1.0 / (perpendicular * perpendicular) + 1.0 / (parallel * parallel))
}

/// Nodes and weights of the Gauss-Legendre rule over [0, 1].
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |i: usize| {
        let mut x = libm::cos(PI * (i as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        // Newton's method on the Legendre polynomial, by its recurrence.
        for _ in 0..6 {
            let (mut before, mut value) = (1.0, x);
            for k in 2..=count {
                let k = k as f64;
                (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
            }
            slope = n * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// A rule for means over the visible normals of a GGX surface, as spherical caps have them (Dupuy and Benyoub 2023): even
/// in height and azimuth.
struct Quadrature {
    /// Heights between the ends of a piece, from its top, and their weights.
    across: Vec<(f64, f64)>,
    /// Cosines and sines of azimuths over half a turn; the other half mirrors it.
    around: Vec<(f64, f64)>,
}

impl Quadrature {
    fn new(across: usize, around: usize) -> Quadrature {
        // Denser towards both ends: one has a root of the height in it, the other the steep rise of masking.
        let graded = |(t, weight): (f64, f64)| (t * t * (3.0 - 2.0 * t), weight * 6.0 * t * (1.0 - t));
        let azimuth = |i: usize| PI * (i as f64 + 0.5) / around as f64;
        Quadrature {
            across: gauss_legendre(across).into_iter().map(graded).collect(),
            around: (0..around).map(|i| (libm::cos(azimuth(i)), libm::sin(azimuth(i)))).collect(),
        }
    }

    /// What the coat does not reflect of light from a direction with this cosine, over 1 - F there: how much of what it
    /// lets through the base may reflect. The coat reflects the mean of F G2 / G1 over its visible normals; the rest is the
    /// mean of (1 - G2 / G1) + (1 - F) G2 / G1, which does not cancel.
    fn room(&self, cosine: f64, ior: f64, alpha: f64) -> f64 {
        let wo = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
        let masking = |v: [f64; 3]| (v[2] * v[2] + alpha * alpha * (v[0] * v[0] + v[1] * v[1])).sqrt() / v[2];
        let masking_o = masking(wo);
        let unit = |v: [f64; 3]| {
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            v.map(|c| c / length)
        };
        let stretched = unit([alpha * wo[0], 0.0, wo[2]]);
        let top = 1.0 + stretched[2];
        let mut sum = 0.0;
        for &(cos, sin) in &self.around {
            // The cosine to the normal at a height above the cap's lower end, and the mirrored direction.
            let reflect = |height: f64| {
                let z = height - stretched[2];
                let radius = (1.0 - z * z).max(0.0).sqrt();
                let normal = unit([alpha * (radius * cos + stretched[0]), alpha * radius * sin, height]);
                let along = wo[0] * normal[0] + wo[2] * normal[2];
                (along.max(0.0), std::array::from_fn(|k| 2.0 * along * normal[k] - wo[k]))
            };
            let rest = |height: f64| {
                let (along, wi): (f64, [f64; 3]) = reflect(height);
                let seen = if wi[2] > 0.0 { (1.0 + masking_o) / (masking_o + masking(wi)) } else { 0.0 };
                (1.0 - seen) + transmittance(along, ior) * seen
            };
            // From where on directions rise above the surface: there the mean has a kink, below it nothing is reflected.
            let (mut below, mut above) = (0.0, top);
            for _ in 0..30 {
                let middle = 0.5 * (below + above);
                if reflect(middle).1[2] > 0.0 { above = middle } else { below = middle }
            }
            let part: f64 = self.across.iter().map(|&(t, weight)| weight * rest(top - (top - above) * t)).sum();
            sum += (above + (top - above) * part) / top;
        }
        sum / self.around.len() as f64 / transmittance(cosine, ior)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_coat_needs_no_lowering_and_a_rough_one_little() {
        for ior in [1.000_001, 1.1, 1.5, 2.5, 20.0] {
            let smooth = base_scale(ior, 1e-4);
            let mean = 1.0 / smooth;
            assert!(mean < 1.001 && mean > 0.1, "mean transmission {mean} at index {ior}");
            for alpha in [0.05, 0.3, 1.0] {
                let rough = base_scale(ior, alpha);
                let kept = if ior < 3.0 { 0.999 } else { 0.5 };
                assert!(rough <= smooth * 1.0005 && rough > kept * smooth, "{rough} after {smooth} at {alpha}, {ior}");
            }
        }
    }

    /// The mean transmittance of index 1.5 is 0.9082 (Egan and Hilgeman 1979 have a closed form for 1 - it: 0.0918).
    #[test]
    fn the_mean_transmittance_is_right() {
        assert!((mean_transmittance(1.5) - 0.908_2).abs() < 1e-4, "{}", mean_transmittance(1.5));
        let midpoints = |ior: f64| {
            let cosines = (0..200_000).map(|i| (f64::from(i) + 0.5) / 200_000.0);
            cosines.map(|c| transmittance(c, ior) * 2.0 * c).sum::<f64>() / 200_000.0
        };
        for ior in [1.000_001, 1.01, 1.5, 3.0, 20.0] {
            let (got, wanted) = (mean_transmittance(ior), midpoints(ior));
            assert!((got - wanted).abs() < 1e-7, "index {ior}: {got}, {wanted}");
        }
    }
}
