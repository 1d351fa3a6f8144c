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
    for signal in [SIGINT, SIGTERM] {
        // In this order: the first signal finds the flag unset and sets it, the second finds it set.
        let registered = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)));
        registered.map_err(|error| Error::Usage(format!("signals cannot be handled on this system: {error}")))?;
    }
    Ok(stop)
}
