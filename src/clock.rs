//! Seconds of CPU time and peak memory, as the system counts them.
//!
//! Wall time is `std::time::Instant`'s business. CPU time is what speed figures are stated in: it does not move when other
//! programs share the cores.

use std::time::Instant;

use rustix::time::{ClockId, Timespec, clock_gettime};

fn seconds(time: Timespec) -> f64 {
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// CPU seconds (user and system) of all threads of this process so far.
pub fn process_cpu_seconds() -> f64 {
    seconds(clock_gettime(ClockId::ProcessCPUTime))
}

/// CPU seconds (user and system) of the calling thread so far.
pub fn thread_cpu_seconds() -> f64 {
    seconds(clock_gettime(ClockId::ThreadCPUTime))
}

/// Wall and CPU time since it was started.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    wall: Instant,
    cpu: f64,
}

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Stopwatch {
        Stopwatch { wall: Instant::now(), cpu: process_cpu_seconds() }
    }
    /// Wall seconds since the start.
    pub fn wall_seconds(&self) -> f64 {
        self.wall.elapsed().as_secs_f64()
    }
    /// CPU seconds (user and system, all threads of the process) since the start.
    pub fn cpu_seconds(&self) -> f64 {
        process_cpu_seconds() - self.cpu
    }
}

/// The most memory this process has held in RAM at once, in bytes; `None` where the system does not say (it is `VmHWM` of
/// `/proc/self/status`, so Linux only).
pub fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?;
    Some(kilobytes.trim().parse::<u64>().ok()? * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpu_clocks_advance_with_work_and_the_process_has_at_least_the_thread() {
        let (process, thread) = (process_cpu_seconds(), thread_cpu_seconds());
        while thread_cpu_seconds() - thread < 0.01 {
            std::hint::black_box(thread.sin());
        }
        assert!(process_cpu_seconds() - process >= 0.009);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn peak_memory_is_known_on_linux() {
        assert!(peak_rss_bytes().is_some_and(|bytes| bytes > 100_000));
    }
}
