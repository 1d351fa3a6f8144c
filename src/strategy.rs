//! The strategies: how direct light is estimated, one row each. Every predicate and every weight derives from its row.

use crate::named_choice::named_choice;

named_choice! {
    /// How direct light is estimated: the steps of the lecture, in its order.
    Strategy, "strategy", {
        /// Directions uniform over the hemisphere, no light samples. Exact.
        Uniform = "uniform",
        /// Directions by the BSDF, no light samples. Exact.
        Bsdf = "bsdf",
        /// First attempt: light samples and hit emission both count whole. **Biased**: direct light counts twice.
        NeeSum = "nee-sum",
        /// Second attempt: both count half. Exact.
        NeeAverage = "nee-average",
        /// Hit emission never counts. **Biased**: lights are black, mirrored lights and caustics are lost.
        NeeNoEmission = "nee-no-emission",
        /// Hit emission counts only where light sampling cannot work (depth 0, after a delta lobe). Exact.
        Nee = "nee",
        /// Balance heuristic by a fair coin at every vertex. Exact.
        MisOneSample = "mis-one-sample",
        /// Both techniques, balance heuristic (Veach 1997, section 9.2). Exact.
        MisBalance = "mis-balance",
        /// Both techniques, power heuristic with beta = 2. Exact; the default.
        MisPower = "mis-power",
    }
}

/// What a sample of one technique counts; `p` is the density with which it was drawn, `q` the other technique's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// 0: the technique is not used.
    Zero,
    /// 1.
    One,
    /// 1/2.
    Half,
    /// The balance heuristic, p / (p + q).
    Balance,
    /// The balance heuristic where a fair coin has chosen the technique, 2 p / (p + q).
    TwiceBalance,
    /// The power heuristic, p^2 / (p^2 + q^2).
    Power,
}

/// One strategy.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Which.
    pub strategy: Strategy,
    /// The step of the lecture.
    pub lecture: &'static str,
    /// Directions are uniform over the hemisphere; else drawn by the BSDF. (Delta lobes always are as the BSDF has them.)
    pub uniform_directions: bool,
    /// A fair coin decides, at every vertex that is no delta lobe, which technique's sample counts.
    pub coin: bool,
    /// What a light sample counts; [`Weight::Zero`]: none is drawn.
    pub light_sample: Weight,
    /// What emission found by a hit counts after a direction drawn from a density.
    pub hit: Weight,
    /// What it counts at depth 0 and after a delta lobe, where light sampling cannot work.
    pub certain_hit: Weight,
}

/// The row of most strategies: directions by the BSDF, no coin, what light sampling cannot find counts 1.
const fn row(strategy: Strategy, lecture: &'static str, light_sample: Weight, hit: Weight) -> Row {
    Row { strategy, lecture, uniform_directions: false, coin: false, light_sample, hit, certain_hit: Weight::One }
}

/// The strategies, in the order of [`Strategy::ALL`].
pub const TABLE: [Row; 9] = {
    use Strategy::*;
    use Weight::*;
    [
        Row { uniform_directions: true, ..row(Uniform, "uniform hemisphere sampling", Zero, One) },
        row(Bsdf, "BRDF sampling", Zero, One),
        row(NeeSum, "first attempt", One, One),
        row(NeeAverage, "second attempt: averaging", Half, Half),
        Row { certain_hit: Zero, ..row(NeeNoEmission, "removing emittance", One, Zero) },
        row(Nee, "NEE unlocked: 0/1 weights", One, Zero),
        Row { coin: true, ..row(MisOneSample, "balance heuristic, one sample", TwiceBalance, TwiceBalance) },
        row(MisBalance, "balance heuristic, both samples", Balance, Balance),
        row(MisPower, "(Veach 1997, power heuristic)", Power, Power),
    ]
};

impl Weight {
    /// What the weights of both techniques add up to if this is that of one and `other` that of the other.
    const fn sums_to_one(self, other: Weight) -> bool {
        use Weight::*;
        matches!(
            (self, other),
            (Zero, One)
                | (One, Zero)
                | (Half, Half)
                | (Balance, Balance)
                | (TwiceBalance, TwiceBalance)
                | (Power, Power)
        )
    }

    /// What the sample of a delta light counts by this rule: all of its light, since no hit finds any of it.
    pub const fn of_delta_light(self) -> f32 {
        match self {
            Weight::Zero => 0.0,
            Weight::One | Weight::Half | Weight::Balance | Weight::Power => 1.0,
            // The coin has chosen the light half of the time.
            Weight::TwiceBalance => 2.0,
        }
    }

    /// The weight in words.
    fn formula(self) -> &'static str {
        match self {
            Weight::Zero => "0",
            Weight::One => "1",
            Weight::Half => "1/2",
            Weight::Balance => "p / (p + q)",
            Weight::TwiceBalance => "2 p / (p + q)",
            Weight::Power => "p^2 / (p^2 + q^2)",
        }
    }
}

impl Strategy {
    /// The strategy's row.
    pub const fn row(self) -> &'static Row {
        &TABLE[self as usize]
    }
    /// Whether light sources are sampled.
    pub const fn samples_lights(self) -> bool {
        !matches!(self.row().light_sample, Weight::Zero)
    }
    /// Whether the expected image is wrong on purpose: emission is counted more or less than once somewhere.
    pub const fn is_biased(self) -> bool {
        let row = self.row();
        !(row.light_sample.sums_to_one(row.hit) && matches!(row.certain_hit, Weight::One))
    }
    /// Whether weights come from the densities of both techniques.
    pub const fn is_mis(self) -> bool {
        matches!(self.row().hit, Weight::Balance | Weight::TwiceBalance | Weight::Power)
    }
}

/// The table as Markdown, one row a strategy: README.md shows it.
pub fn markdown() -> String {
    let head =
        "| strategy | lecture | directions | a light sample counts | emission found by a hit counts | expected value |";
    let mut lines = vec![head.to_string(), "| --- | --- | --- | --- | --- | --- |".to_string()];
    for row in &TABLE {
        let directions = if row.uniform_directions { "uniform over the hemisphere" } else { "by the BSDF" };
        let light = if row.strategy.samples_lights() { row.light_sample.formula() } else { "not drawn" };
        let (light, hit) = match row.coin {
            true => (
                format!("{light} if the coin chose it, else 0"),
                format!("{} if the coin chose it, else 0", row.hit.formula()),
            ),
            false => (light.to_string(), row.hit.formula().to_string()),
        };
        let hit = match row.certain_hit == row.hit {
            true => hit,
            false => format!("{hit}; {} at depth 0 and after a delta lobe", row.certain_hit.formula()),
        };
        let value = if row.strategy.is_biased() { "**biased**" } else { "exact" };
        lines.push(format!("| `{}` | {} | {directions} | {light} | {hit} | {value} |", row.strategy, row.lecture));
    }
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stand_in_the_order_of_the_strategies() {
        assert!(TABLE.iter().map(|row| row.strategy).eq(Strategy::ALL.iter().copied()));
    }

    #[test]
    fn predicates_derive_from_the_rows() {
        let of = |holds: fn(Strategy) -> bool| Strategy::ALL.iter().copied().filter(|&s| holds(s)).collect::<Vec<_>>();
        use Strategy::*;
        assert_eq!(of(Strategy::is_biased), [NeeSum, NeeNoEmission]);
        assert_eq!(of(Strategy::is_mis), [MisOneSample, MisBalance, MisPower]);
        assert_eq!(of(|s| !s.samples_lights()), [Uniform, Bsdf]);
    }

    #[test]
    fn the_readme_shows_the_table() {
        assert!(include_str!("../README.md").contains(&markdown()), "put this into README.md:\n{}", markdown());
    }
}
