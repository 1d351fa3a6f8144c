//! How much of a plastic's base may shine through its coat, so that the two together never reflect more than arrives.
//!
//! Computed while loading, in f64, with `libm` for sines: the same bits on every platform.

/// The factor on a plastic's albedo.
///
/// The base reflects albedo (1 - F(o)) (1 - F(i)) / pi times this. With 1 / mean(1 - F) a smooth coat and a white base
/// together reflect exactly 1. A rough coat can reflect a little more than F(o): there the factor is lowered until no
/// direction reflects more than 1.
pub fn base_scale(ior: f64, alpha: f64) -> f64 {
    const STEPS: usize = 64;
    let cosines = || (0..STEPS).map(|i| (i as f64 + 0.5) / STEPS as f64);
    // Mean over the cosine-weighted hemisphere: the integral of (1 - F(c)) 2 c dc.
    let mean = cosines().map(|c| (1.0 - fresnel(c, ior)) * 2.0 * c).sum::<f64>() / STEPS as f64;
    // Where almost nothing reaches the base, it cannot add too much.
    let dark = |through: f64| through < 1e-3;
    let room = cosines().map(|c| (1.0 - fresnel(c, ior), c)).filter(|&(through, _)| !dark(through));
    let lowest = room.map(|(through, c)| (1.0 - coat_albedo(c, ior, alpha)) / through).fold(1.0, f64::min);
    // Half a percent covers the steps of these sums.
    0.995 * lowest / mean
}

/// Fresnel reflectance from outside, for unpolarised light.
fn fresnel(cosine: f64, ior: f64) -> f64 {
    let cosine_t = (1.0 - (1.0 - cosine * cosine) / (ior * ior)).sqrt();
    let parallel = (ior * cosine - cosine_t) / (ior * cosine + cosine_t);
    let perpendicular = (cosine - ior * cosine_t) / (cosine + ior * cosine_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// What a GGX coat reflects of light from a direction with this cosine: the mean of F G2 / G1 over its visible normals
/// (Dupuy and Benyoub 2023), by midpoints.
fn coat_albedo(cosine: f64, ior: f64, alpha: f64) -> f64 {
    const STEPS: usize = 24;
    let wo = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
    let masking = |v: [f64; 3]| (v[2] * v[2] + alpha * alpha * (v[0] * v[0] + v[1] * v[1])).sqrt() / v[2];
    let unit = |v: [f64; 3]| {
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        v.map(|c| c / length)
    };
    let stretched = unit([alpha * wo[0], 0.0, wo[2]]);
    let midpoint = |i: usize| (i as f64 + 0.5) / STEPS as f64;
    let mut sum = 0.0;
    for (i, j) in (0..STEPS * STEPS).map(|n| (n / STEPS, n % STEPS)) {
        let z = (1.0 - midpoint(i)) * (1.0 + stretched[2]) - stretched[2];
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let angle = midpoint(j) * std::f64::consts::TAU;
        let (x, y) = (radius * libm::cos(angle), radius * libm::sin(angle));
        let normal = unit([alpha * (x + stretched[0]), alpha * y, (z + stretched[2]).max(0.0)]);
        let along = wo[0] * normal[0] + wo[2] * normal[2];
        let wi: [f64; 3] = std::array::from_fn(|k| 2.0 * along * normal[k] - wo[k]);
        if wi[2] > 0.0 {
            sum += fresnel(along, ior) * (1.0 + masking(wo)) / (masking(wo) + masking(wi));
        }
    }
    sum / (STEPS * STEPS) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_coat_needs_no_lowering_and_a_rough_one_little() {
        for ior in [1.1, 1.5, 2.5] {
            let smooth = base_scale(ior, 1e-4);
            let mean = 0.995 / smooth;
            assert!(mean < 1.0 && mean > 0.5, "mean transmission {mean} at index {ior}");
            for alpha in [0.05, 0.3, 1.0] {
                let rough = base_scale(ior, alpha);
                assert!(rough <= smooth * 1.0001 && rough > 0.9 * smooth, "{rough} after {smooth} at {alpha}, {ior}");
            }
        }
    }
}
