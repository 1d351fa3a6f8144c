//! Whether this CPU has the instructions the build uses, asked before any of them runs.
//!
//! `is_x86_feature_detected!` cannot answer: it is folded to `true` at compile time for features the build enables, so the
//! CPU is asked by `cpuid`.

/// The build's instruction sets that this CPU (or its operating system) lacks.
#[cfg(target_arch = "x86_64")]
pub fn missing() -> Vec<&'static str> {
    use std::arch::x86_64::{__cpuid, __cpuid_count};
    // (used by this build, name, register of cpuid, bit); bit numbers from the AMD64 manual, volume 3, appendix E.
    let leaf = |number: u32| if __cpuid(number & 0x8000_0000).eax >= number { __cpuid_count(number, 0) } else { NONE };
    let (basic, structured, extended) = (leaf(1), leaf(7), leaf(0x8000_0001));
    let needed = [
        (cfg!(target_feature = "sse4.2"), "SSE4.2", basic.ecx, 20),
        (cfg!(target_feature = "avx"), "AVX", basic.ecx, 28),
        // AVX registers are only usable if the system saves them.
        (cfg!(target_feature = "avx"), "OSXSAVE (the operating system must support AVX)", basic.ecx, 27),
        (cfg!(target_feature = "fma"), "FMA", basic.ecx, 12),
        (cfg!(target_feature = "avx2"), "AVX2", structured.ebx, 5),
        (cfg!(target_feature = "bmi1"), "BMI1", structured.ebx, 3),
        (cfg!(target_feature = "bmi2"), "BMI2", structured.ebx, 8),
        (cfg!(target_feature = "avx512f"), "AVX-512F", structured.ebx, 16),
        (cfg!(target_feature = "lzcnt"), "LZCNT", extended.ecx, 5),
    ];
    needed.iter().filter(|(used, _, register, bit)| *used && register >> bit & 1 == 0).map(|row| row.1).collect()
}

#[cfg(target_arch = "x86_64")]
const NONE: std::arch::x86_64::CpuidResult = std::arch::x86_64::CpuidResult { eax: 0, ebx: 0, ecx: 0, edx: 0 };

/// Other processors are built for their baseline.
#[cfg(not(target_arch = "x86_64"))]
pub fn missing() -> Vec<&'static str> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_cpu_that_runs_this_test_has_all_it_needs() {
        assert!(super::missing().is_empty(), "{:?}", super::missing());
    }
}
