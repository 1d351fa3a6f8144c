//! Seconds of CPU time and peak memory, as the system counts them.
//!
//! Wall time is `std::time::Instant`'s business. CPU time is what speed figures are stated in: it does not move when other
//! programs share the cores.

use std::time::Instant;

/// CPU seconds (user and system) of all threads of this process so far. Windows counts them in ticks of 1/64 s.
pub fn process_cpu_seconds() -> f64 {
    system::process_cpu_seconds()
}

/// CPU seconds (user and system) of the calling thread so far.
pub fn thread_cpu_seconds() -> f64 {
    system::thread_cpu_seconds()
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
    /// CPU seconds (user and system, all threads of the process) since the start. On Windows the wall seconds at least
    /// while they are below 1/16 s, which are four ticks.
    pub fn cpu_seconds(&self) -> f64 {
        let cpu = process_cpu_seconds() - self.cpu;
        // A few ticks say little, and none would make speeds infinite: of a process that works all along, the wall time is
        // the least it can have taken.
        if cpu < 4.0 * system::TICK { cpu.max(self.wall_seconds()) } else { cpu }
    }
}

/// The most memory this process has held in RAM at once, in bytes; `None` where the system does not say.
pub fn peak_rss_bytes() -> Option<u64> {
    system::peak_rss_bytes()
}

#[cfg(unix)]
mod system {
    use rustix::time::{ClockId, Timespec, clock_gettime};

    /// The step of the CPU time of a process.
    pub const TICK: f64 = 0.0;

    fn seconds(time: Timespec) -> f64 {
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    }

    pub fn process_cpu_seconds() -> f64 {
        seconds(clock_gettime(ClockId::ProcessCPUTime))
    }

    pub fn thread_cpu_seconds() -> f64 {
        seconds(clock_gettime(ClockId::ThreadCPUTime))
    }

    /// `VmHWM` of `/proc/self/status`: the `ru_maxrss` of `getrusage` on Linux begins with the peak of whoever started us.
    #[cfg(not(target_vendor = "apple"))]
    pub fn peak_rss_bytes() -> Option<u64> {
        let status = std::fs::read_to_string("/proc/self/status").ok()?;
        let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?;
        Some(kilobytes.trim().parse::<u64>().ok()? * 1024)
    }

    #[cfg(target_vendor = "apple")]
    pub fn peak_rss_bytes() -> Option<u64> {
        use nix::sys::resource::{UsageWho, getrusage};
        u64::try_from(getrusage(UsageWho::RUSAGE_SELF).ok()?.max_rss()).ok()
    }
}

#[cfg(windows)]
mod system {
    use std::sync::LazyLock;
    use std::time::{Duration, Instant};
    use winsafe::{FILETIME, HPROCESS, HTHREAD};

    /// The step of the CPU time of a process.
    pub const TICK: f64 = 1.0 / 64.0;

    /// `FILETIME` counts 100 ns.
    fn seconds(kernel: FILETIME, user: FILETIME) -> f64 {
        (u64::from(kernel) + u64::from(user)) as f64 * 1e-7
    }

    pub fn process_cpu_seconds() -> f64 {
        HPROCESS::GetCurrentProcess().GetProcessTimes().map_or(0.0, |(_, _, kernel, user)| seconds(kernel, user))
    }

    /// By the thread's cycles, since its time moves in ticks of 1/64 s only, longer than much of what is timed. A cycle is
    /// one of the time stamp counter of x86-64, which runs at a constant rate (Chromium's `base::ThreadTicks` has its
    /// thread time on Windows from the same two facts). Other processors are left with the ticks.
    pub fn thread_cpu_seconds() -> f64 {
        static CYCLES_PER_SECOND: LazyLock<f64> = LazyLock::new(cycles_per_second);
        let rate = if cfg!(target_arch = "x86_64") { *CYCLES_PER_SECOND } else { 0.0 };
        match cycles() {
            Some(cycles) if rate > 0.0 => cycles as f64 / rate,
            _ => ticks(),
        }
    }

    fn cycles() -> Option<u64> {
        HTHREAD::GetCurrentThread().QueryThreadCycleTime().ok()
    }

    fn ticks() -> f64 {
        HTHREAD::GetCurrentThread().GetThreadTimes().map_or(0.0, |(_, _, kernel, user)| seconds(kernel, user))
    }

    /// The most of 20 intervals of 1 ms: those in which the thread had to wait hold fewer cycles. 0 where cycles are not
    /// told or stand still for an interval, being ticks by another name (as under Wine).
    fn cycles_per_second() -> f64 {
        let interval = || -> Option<f64> {
            let (start, first) = (Instant::now(), cycles()?);
            while start.elapsed() < Duration::from_millis(1) {
                std::hint::spin_loop();
            }
            let (passed, last) = (start.elapsed().as_secs_f64(), cycles()?);
            (last > first).then(|| (last - first) as f64 / passed)
        };
        let rates: Option<Vec<f64>> = (0..20).map(|_| interval()).collect();
        rates.unwrap_or_default().into_iter().fold(0.0, f64::max)
    }

    pub fn peak_rss_bytes() -> Option<u64> {
        let memory = HPROCESS::GetCurrentProcess().GetProcessMemoryInfo().ok()?;
        u64::try_from(memory.PeakWorkingSetSize).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cpu_clocks_advance_with_work_and_the_process_has_at_least_the_thread() {
        let (process, thread) = (process_cpu_seconds(), thread_cpu_seconds());
        // Each of the two may be a tick off.
        let work = 0.01 + 8.0 * system::TICK;
        while thread_cpu_seconds() - thread < work {
            std::hint::black_box(thread.sin());
        }
        assert!(process_cpu_seconds() - process >= 0.9 * work - 2.0 * system::TICK);
    }

    #[test]
    fn a_thread_that_works_has_no_more_cpu_time_than_passes_and_one_that_sleeps_has_next_to_none() {
        thread_cpu_seconds();
        let (wall, thread) = (Instant::now(), thread_cpu_seconds());
        std::thread::sleep(std::time::Duration::from_millis(50));
        let asleep = thread_cpu_seconds() - thread;
        assert!((0.0..0.01).contains(&asleep), "{asleep} s of CPU time in a sleep of 0.05 s");
        while wall.elapsed().as_secs_f64() < 0.1 {
            std::hint::black_box(thread.sin());
        }
        let (cpu, passed) = (thread_cpu_seconds() - thread, wall.elapsed().as_secs_f64());
        assert!(cpu <= 1.01 * passed, "{cpu} s of CPU time in {passed} s");
    }

    #[test]
    fn the_smallest_work_that_is_timed_takes_some_time() {
        thread_cpu_seconds();
        let (watch, start) = (Stopwatch::start(), thread_cpu_seconds());
        let sum: f64 = (0..100_000).map(|i| std::hint::black_box(f64::from(i)).sqrt()).sum();
        let (seconds, process) = (thread_cpu_seconds() - start, watch.cpu_seconds());
        assert!(seconds > 0.0 && process > 0.0 && sum > 0.0, "{seconds} s of the thread, {process} s of the process");
    }

    #[test]
    #[cfg(any(target_os = "linux", target_os = "macos", windows))]
    fn peak_memory_holds_what_was_touched() {
        let touched = std::hint::black_box(vec![1u8; 32 << 20]);
        let peak = peak_rss_bytes().unwrap();
        assert!(touched.iter().all(|byte| *byte == 1));
        assert!((32 << 20..1 << 40).contains(&peak), "{peak} bytes");
    }
}
