//! The alias table: an entry drawn in proportion to its weight, at the same cost whatever the number of entries.

/// One column of the alias table (Walker 1977, built as Vose 1991 does).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AliasColumn {
    /// The column's own entry is chosen where the low word of the selection is below this.
    pub threshold: u32,
    /// Else this one.
    pub alias: u32,
}

/// Vose's method: every column holds at most two entries and the columns are equally likely. `total` is the sum of
/// `weights`.
pub(super) fn alias_table(weights: &[f64], total: f64) -> Vec<AliasColumn> {
    let n = weights.len();
    let mut share: Vec<f64> = weights.iter().map(|w| w / total * n as f64).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| share[i] < 1.0);
    let full = |i: usize| AliasColumn { threshold: u32::MAX, alias: i as u32 };
    let mut columns: Vec<AliasColumn> = (0..n).map(full).collect();
    while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
        small.pop();
        columns[s] = AliasColumn { threshold: (share[s] * 4_294_967_296.0) as u32, alias: l as u32 };
        share[l] -= 1.0 - share[s];
        if share[l] < 1.0 {
            large.pop();
            small.push(l);
        }
    }
    columns
}
