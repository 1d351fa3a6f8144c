//! SIMD levels: which there are, which the CPU has, which one is used.
//!
//! **Law:** a level changes the time a picture takes and nothing else.

use crate::error::{Error, Result};
use crate::named_choice::named_choice;
use std::sync::atomic::{AtomicU8, Ordering};

named_choice! {
    /// A set of SIMD instructions. Whatever the level, packets have eight lanes and results are the same, bit for bit.
    SimdLevel, "SIMD level", {
        /// What every CPU of the architecture has: on x86-64 SSE2, eight lanes in halves.
        Baseline = "baseline",
        /// AVX2: eight lanes in one register.
        Avx2 = "avx2",
        /// AVX-512: two packets side by side go through the tree together.
        Avx512 = "avx512",
    }
}

/// The environment variable that chooses a level by name.
pub const VARIABLE: &str = "OCTRAY_SIMD";

/// The number of the level in use, [`UNKNOWN`] before it was asked for.
static USED: AtomicU8 = AtomicU8::new(UNKNOWN);
const UNKNOWN: u8 = u8::MAX;

impl SimdLevel {
    /// The levels that this program can use on this CPU, from the lowest: not those below what it was compiled for.
    pub fn available() -> Vec<SimdLevel> {
        SimdLevel::ALL.iter().copied().filter(|&level| level >= COMPILED && level.is_on_this_cpu()).collect()
    }

    /// The level in use: the best of [`SimdLevel::available`] unless `OCTRAY_SIMD` or [`SimdLevel::force`] said otherwise.
    #[inline]
    pub fn used() -> SimdLevel {
        match USED.load(Ordering::Relaxed) {
            UNKNOWN => SimdLevel::choose(),
            number => SimdLevel::ALL[number as usize],
        }
    }

    /// Uses this level from now on, in the whole process: for comparisons, since results do not depend on it.
    ///
    /// # Errors
    /// The level is not [`SimdLevel::available`].
    pub fn force(self) -> Result<()> {
        if !SimdLevel::available().contains(&self) {
            return Err(Error::Usage(self.unavailable()));
        }
        USED.store(self as u8, Ordering::Relaxed);
        Ok(())
    }

    /// Checks what `OCTRAY_SIMD` says, and uses it.
    ///
    /// # Errors
    /// It names no level, or one that is not [`SimdLevel::available`].
    pub fn from_environment() -> Result<()> {
        match std::env::var(VARIABLE) {
            Err(_) => Ok(()),
            Ok(name) if name.is_empty() => Ok(()),
            Ok(name) => {
                let level: SimdLevel = name.parse().map_err(|what| Error::Usage(format!("{VARIABLE}: {what}")))?;
                level.force().map_err(|error| Error::Usage(format!("{VARIABLE}: {error}")))
            }
        }
    }

    /// Chooses the level at its first use. A wrong `OCTRAY_SIMD` is told by [`SimdLevel::from_environment`]; here it is nothing.
    #[cold]
    fn choose() -> SimdLevel {
        if SimdLevel::from_environment().is_err() || USED.load(Ordering::Relaxed) == UNKNOWN {
            let best = SimdLevel::available().last().copied().unwrap_or(COMPILED);
            // Whoever chose in the meantime goes first.
            let _ = USED.compare_exchange(UNKNOWN, best as u8, Ordering::Relaxed, Ordering::Relaxed);
        }
        SimdLevel::ALL[USED.load(Ordering::Relaxed) as usize]
    }

    fn unavailable(self) -> String {
        let known: Vec<&str> = SimdLevel::available().into_iter().map(SimdLevel::name).collect();
        format!("this build on this CPU has no SIMD level `{self}`; it has: {}", known.join(", "))
    }

    /// Whether this CPU has all instructions that code of this level is compiled with, here and in `bvh/sixteen`.
    #[cfg(target_arch = "x86_64")]
    pub(crate) fn is_on_this_cpu(self) -> bool {
        match self {
            SimdLevel::Baseline => true,
            SimdLevel::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            SimdLevel::Avx512 => {
                SimdLevel::Avx2.is_on_this_cpu()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
            }
        }
    }

    /// Whether this CPU has the level: elsewhere there is one.
    #[cfg(not(target_arch = "x86_64"))]
    pub(crate) fn is_on_this_cpu(self) -> bool {
        self == SimdLevel::Baseline
    }
}

/// The level that all code of this build may use without asking.
pub const COMPILED: SimdLevel = if cfg!(all(target_arch = "x86_64", target_feature = "avx2", target_feature = "fma")) {
    SimdLevel::Avx2
} else {
    SimdLevel::Baseline
};

/// The SIMD level in use, and what the program was compiled for: for version lines and reports.
pub fn simd_level() -> &'static str {
    const NATIVE: bool = matches!(COMPILED, SimdLevel::Avx2);
    match SimdLevel::used() {
        SimdLevel::Avx512 if NATIVE => "AVX-512, built for x86-64-v3",
        SimdLevel::Avx512 => "AVX-512, built for x86-64 (SSE2)",
        SimdLevel::Avx2 if NATIVE => "AVX2, built for x86-64-v3",
        SimdLevel::Avx2 => "AVX2, built for x86-64 (SSE2)",
        SimdLevel::Baseline if cfg!(target_arch = "x86_64") => "SSE2, built for x86-64",
        SimdLevel::Baseline => "baseline of an untested architecture",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_available_from_the_compiled_one_up() {
        let available = SimdLevel::available();
        assert_eq!(available.first(), Some(&COMPILED));
        assert!(available.is_sorted() && available.contains(&SimdLevel::used()));
    }

    #[test]
    fn a_level_that_is_not_there_is_refused() {
        for &level in SimdLevel::ALL {
            let told = level.unavailable();
            assert!(told.contains(level.name()) && told.contains(COMPILED.name()), "{told}");
            assert!(SimdLevel::available().contains(&level) || level.force().is_err());
        }
    }
}
