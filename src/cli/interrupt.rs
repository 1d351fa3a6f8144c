//! Ctrl-C: the first asks for a stop in good order, the second ends the program.

use crate::error::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Set once the user (or the system) has asked for a stop. A second request ends the program at once, with the status that
/// shells give an interrupted one.
pub fn requested() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in requests() {
        // In this order: the first signal finds the flag unset and sets it, the second finds it set.
        let registered = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)));
        registered.map_err(|error| Error::Usage(format!("signals cannot be handled on this system: {error}")))?;
    }
    Ok(stop)
}

/// The signals that ask for a stop: also those of Ctrl-\ and of a terminal that is closed. (That last one stays without effect
/// where whoever started us wants it to, as `nohup` does. Shells have those of keys ignored in what they run behind, where a
/// script may still send one.)
#[cfg(unix)]
fn requests() -> Vec<i32> {
    use signal_hook::consts::{SIGHUP, SIGQUIT};
    let hangs_up = ignored() >> (SIGHUP - 1) & 1 == 0;
    [SIGINT, SIGTERM, SIGQUIT].into_iter().chain(hangs_up.then_some(SIGHUP)).collect()
}

#[cfg(not(unix))]
fn requests() -> Vec<i32> {
    vec![SIGINT, SIGTERM]
}

/// Signals that are ignored, bit `s - 1` for signal `s`, as far as the system tells.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let bits = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    bits.and_then(|bits| u64::from_str_radix(bits.trim(), 16).ok()).unwrap_or(0)
}

/// A file that grows beyond a limit (`ulimit -f`) is an error of that file, and not the end of the program.
pub fn survive_full_files() {
    #[cfg(unix)]
    let _ = flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
}
