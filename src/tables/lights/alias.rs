//! The alias table: an entry drawn in proportion to its weight, at the same cost whatever the number of entries.
//!
//! Weights are turned into whole shares first, of which there are 2^32 for every entry, and the table is built from them by
//! subtraction alone: what it draws is what the shares say, to the last one. So the probabilities that an estimator is
//! told can be those with which entries are drawn, even where weights differ by more than a float can hold.

/// One column of the alias table (Walker 1977, built as Vose 1991 does).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AliasColumn {
    /// The column's own entry is chosen where the low word of the selection is below this.
    pub threshold: u32,
    /// Else this one.
    pub alias: u32,
}

/// Shares that a column holds.
const COLUMN: u64 = 1 << 32;

/// `weights`, whose sum is `total`, in whole shares that sum to 2^32 times their number. What has a weight has a share.
pub(super) fn whole_shares(weights: &[f64], total: f64) -> Vec<u64> {
    let all = weights.len() as u64 * COLUMN;
    let unit = all as f64 / total;
    let mut shares: Vec<u64> =
        weights.iter().map(|&w| if w > 0.0 { ((w * unit).round() as u64).max(1) } else { 0 }).collect();
    // What rounding leaves, or takes too much, falls to the largest, where it is least of all.
    if let Some(largest) = (0..shares.len()).max_by_key(|&i| shares[i]) {
        let others: u64 = shares.iter().sum::<u64>() - shares[largest];
        shares[largest] = all - others;
    }
    shares
}

/// Vose's method in whole numbers: every column holds the shares of at most two entries, 2^32 of them. `shares` are those
/// of [`whole_shares`].
pub(super) fn alias_table(mut shares: Vec<u64>) -> Vec<AliasColumn> {
    let n = shares.len();
    // A full column never needs its alias, which is itself.
    let mut columns: Vec<AliasColumn> = (0..n).map(|i| AliasColumn { threshold: u32::MAX, alias: i as u32 }).collect();
    let (mut small, mut large): (Vec<u32>, Vec<u32>) = (0..n as u32).partition(|&i| shares[i as usize] < COLUMN);
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        let share = shares[s as usize];
        columns[s as usize] = AliasColumn { threshold: share as u32, alias: l };
        shares[l as usize] -= COLUMN - share;
        if shares[l as usize] < COLUMN {
            large.pop();
            small.push(l);
        }
    }
    columns
}

/// With which probability [`super::table::Fixed::choose`] draws every entry of a table, when the words it is given are
/// uniform but for `zeros` low bits, which are 0: by counting those words, exactly.
pub(super) fn probabilities_by_word(columns: &[AliasColumn], zeros: u32) -> Vec<f64> {
    let mut words = vec![0u64; columns.len()];
    // Word w falls at place w n: column by the high word, threshold by the low one.
    let step = (columns.len() as u64) << zeros;
    let first_at = |place: u64| place.div_ceil(step);
    for (i, column) in columns.iter().enumerate() {
        let start = i as u64 * COLUMN;
        let [begin, fork, end] = [start, start + u64::from(column.threshold), start + COLUMN].map(first_at);
        words[i] += fork - begin;
        words[column.alias as usize] += end - fork;
    }
    let all = (COLUMN >> zeros) as f64;
    words.into_iter().map(|count| count as f64 / all).collect()
}

/// The factor s for which densities max(s v, `least`) of all v above 0 integrate to 1 within 1e-7, where v is constant over
/// a measure a: `cells` are the (v, a). The measures must fall well below 1 / `least` together.
pub(super) fn factor_above<C: Iterator<Item = (f64, f64)>>(cells: impl Fn() -> C, least: f64) -> f64 {
    let lit = || cells().filter(|&(value, _)| value > 0.0);
    let mut factor = 1.0 / lit().map(|(value, measure)| value * measure).sum::<f64>();
    // Newton's method: the integral is convex in s and made of straight pieces, so from above it ends on the right one. A
    // cell that falls below the least density never rises again.
    for _ in 0..100 {
        let (mut raised, mut rest) = (0.0, 0.0);
        for (value, measure) in lit() {
            if value * factor < least {
                raised += least * measure;
            } else {
                rest += value * measure;
            }
        }
        let next = (1.0 - raised) / rest;
        if next >= factor * (1.0 - 1e-7) {
            break;
        }
        factor = next;
    }
    factor
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{random_words, unit};

    /// Weights of all kinds: alike, apart by powers of ten, one for all, with zeros among them.
    fn weights() -> Vec<Vec<f64>> {
        let random = |n: u32, span: f64| {
            let weight = |i: u32| 10f64.powf(span * f64::from(unit(random_words(i, n, 3, 5)[0])));
            (0..n).map(weight).collect::<Vec<f64>>()
        };
        let mut list = vec![vec![1.0], vec![1.0; 7], vec![1.0, 1e12], vec![1e12, 1.0, 0.0, 1e-12], vec![0.0, 3.0, 0.0]];
        list.extend(
            [(2, 1.0), (3, 30.0), (100, 2.0), (1000, 0.1), (1000, 24.0), (4096, 12.0)].map(|(n, s)| random(n, s)),
        );
        list
    }

    #[test]
    fn a_table_holds_the_shares_it_was_made_of() {
        for weights in weights() {
            let total = weights.iter().sum::<f64>();
            let shares = whole_shares(&weights, total);
            let n = weights.len() as u64;
            assert_eq!(shares.iter().sum::<u64>(), n * COLUMN);
            for (&share, &weight) in shares.iter().zip(&weights) {
                assert_eq!(share > 0, weight > 0.0, "{weight} of {total}");
                let exact = weight / total * (n * COLUMN) as f64;
                assert!((share as f64 - exact).abs() <= 1.0 + n as f64 + 1e-15 * exact, "{share} for {exact}");
            }
            let mut held = vec![0u64; weights.len()];
            for (i, column) in alias_table(shares.clone()).into_iter().enumerate() {
                held[i] += u64::from(column.threshold);
                held[column.alias as usize] += COLUMN - u64::from(column.threshold);
            }
            assert_eq!(held, shares);
        }
    }

    /// The factor leaves what it need not raise in proportion, and all densities integrate to 1.
    #[test]
    fn densities_above_a_least_one_integrate_to_one() {
        for values in weights() {
            for least in [0.0, 1e-6, 1.0 / 16.0, 0.5] {
                let measure = |i: usize| (1.0 + (i % 3) as f64) / (2.0 * values.len() as f64);
                let cells = || values.iter().enumerate().map(|(i, &value)| (value, measure(i)));
                let factor = factor_above(cells, least);
                let density = |value: f64| if value > 0.0 { (value * factor).max(least) } else { 0.0 };
                let total: f64 = cells().map(|(value, measure)| density(value) * measure).sum();
                assert!((total - 1.0).abs() < 1e-7, "{} values, least {least}: {total}", values.len());
            }
        }
    }
}
