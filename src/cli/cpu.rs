//! Whether this CPU has the instructions the build uses, asked before any of them runs.
//!
//! `is_x86_feature_detected!` cannot answer: it is folded to `true` at compile time for features the build enables, so the
//! CPU is asked by `cpuid`.

/// The first instruction set of this build that the CPU (or its operating system) lacks.
#[cfg(target_arch = "x86_64")]
pub fn missing() -> Option<&'static str> {
    use raw_cpuid::{CpuIdResult, cpuid};
    const NONE: CpuIdResult = CpuIdResult { eax: 0, ebx: 0, ecx: 0, edx: 0 };
    let leaf = |number: u32| if cpuid!(number & 0x8000_0000).eax >= number { cpuid!(number) } else { NONE };
    let (basic, structured, extended) = (leaf(1), leaf(7), leaf(0x8000_0001));
    // (used by this build, name, register of cpuid, its bit): AMD64 manual, volume 3, appendix E. A chain of tests
    // against constants and no collection: what is compiled here must itself run on the oldest x86-64.
    let needed = [
        (cfg!(target_feature = "sse4.2"), "SSE4.2", basic.ecx, 1 << 20),
        (cfg!(target_feature = "avx"), "AVX", basic.ecx, 1 << 28),
        (cfg!(target_feature = "avx"), "an operating system that saves AVX registers (OSXSAVE)", basic.ecx, 1 << 27),
        (cfg!(target_feature = "fma"), "FMA", basic.ecx, 1 << 12),
        (cfg!(target_feature = "avx2"), "AVX2", structured.ebx, 1 << 5),
        (cfg!(target_feature = "bmi1"), "BMI1", structured.ebx, 1 << 3),
        (cfg!(target_feature = "bmi2"), "BMI2", structured.ebx, 1 << 8),
        (cfg!(target_feature = "avx512f"), "AVX-512F", structured.ebx, 1 << 16),
        (cfg!(target_feature = "lzcnt"), "LZCNT", extended.ecx, 1 << 5),
    ];
    for (used, name, register, bit) in needed {
        if used && register & bit == 0 {
            return Some(name);
        }
    }
    None
}

/// Other processors are built for their baseline.
#[cfg(not(target_arch = "x86_64"))]
pub fn missing() -> Option<&'static str> {
    None
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_cpu_that_runs_this_test_has_all_it_needs() {
        assert_eq!(super::missing(), None);
    }
}
