//! How much memory this process may take: asked before it is taken, so that a file or a flag that wants too much is told so
//! and nothing is killed for it.
//!
//! The limit is what [`set_max_memory`] says, else nine tenths of what the machine or the process's control group has; what a
//! limit on the address space leaves is asked besides. Large tables are claimed by those who make them ([`claim`], [`table`]);
//! the program's allocator refuses whatever else goes beyond (`cli::allocator`).

use crate::error::{Error, Result};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

/// Of the machine's memory, what is taken unless told otherwise: the rest is for the system's file cache and other programs.
const SHARE: f64 = 0.9;

/// 0: not asked for yet.
static LIMIT: AtomicU64 = AtomicU64::new(0);

/// Lets this process take `bytes` of memory in all; `None`: what is right for this machine.
pub fn set_max_memory(bytes: Option<u64>) {
    LIMIT.store(bytes.unwrap_or_else(default_limit).max(1), Ordering::Relaxed);
}

/// The most memory this process may take, bytes; `u64::MAX` where nothing is known of the machine.
pub fn max_memory() -> u64 {
    match LIMIT.load(Ordering::Relaxed) {
        0 => {
            set_max_memory(None);
            LIMIT.load(Ordering::Relaxed)
        }
        limit => limit,
    }
}

/// [`max_memory`] if it was ever asked for or said, else no limit: takes no memory itself.
pub fn known_limit() -> u64 {
    match LIMIT.load(Ordering::Relaxed) {
        0 => u64::MAX,
        limit => limit,
    }
}

fn default_limit() -> u64 {
    system::memory().map_or(u64::MAX, |bytes| (bytes as f64 * SHARE) as u64)
}

/// Whether `bytes` more can be taken for `what`, which reads well before "needs". Takes nothing.
///
/// # Errors
/// [`Error::Memory`] says how much is needed, how much there is, and what to do.
pub fn claim(bytes: u64, what: &str) -> Result<()> {
    let (limit, held) = (max_memory(), system::resident().unwrap_or(0));
    if held.saturating_add(bytes) > limit {
        let held = if held > limit / 16 { format!(", of which {} are taken", amount(held)) } else { String::new() };
        return Err(Error::Memory(format!(
            "{what} needs {} of memory, and this process may take {}{held}: see --max-memory",
            amount(bytes),
            amount(limit)
        )));
    }
    match system::address_space_left() {
        Some(left) if bytes > left => Err(Error::Memory(format!(
            "{what} needs {} of memory, and the limit on this process's address space (ulimit -v) leaves {}",
            amount(bytes),
            amount(left)
        ))),
        _ => Ok(()),
    }
}

/// A table of `count` rows, all `T::default()`, for `what`.
///
/// # Errors
/// As [`claim`], and if the system refuses what was claimed.
pub fn table<T: Clone + Default>(count: usize, what: &str) -> Result<Vec<T>> {
    let mut rows = reserved(count, what)?;
    rows.resize(count, T::default());
    Ok(rows)
}

/// An empty table with room for `count` rows, for `what`.
///
/// # Errors
/// As [`table`].
pub fn reserved<T>(count: usize, what: &str) -> Result<Vec<T>> {
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    claim(bytes, what)?;
    let mut rows = Vec::new();
    fallibly(|| rows.try_reserve_exact(count))
        .map_err(|_| Error::Memory(format!("{what} needs {} of memory, which the system refuses", amount(bytes))))?;
    Ok(rows)
}

thread_local! {
    static FALLIBLE: Cell<bool> = const { Cell::new(false) };
}

/// Does `work`, in which a refused allocation is expected and handled.
fn fallibly<R>(work: impl FnOnce() -> R) -> R {
    let before = FALLIBLE.replace(true);
    let result = work();
    FALLIBLE.set(before);
    result
}

/// Whether the calling thread handles a refused allocation.
pub fn refusal_is_handled() -> bool {
    FALLIBLE.try_with(Cell::get).unwrap_or(false)
}

/// Bytes as people write them: `512 MB`, `1.5 GB`.
pub fn amount(bytes: u64) -> String {
    let unit =
        [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")].into_iter().find(|(size, _)| bytes as f64 >= *size);
    match unit {
        Some((size, name)) => {
            let number = bytes as f64 / size;
            let digits = usize::from(number < 10.0);
            format!("{number:.digits$} {name}")
        }
        None => format!("{bytes} bytes"),
    }
}

#[cfg(target_os = "linux")]
mod system {
    use std::fs::read_to_string;

    /// What the machine has, or the process's control group if that is less; bytes.
    pub fn memory() -> Option<u64> {
        let machine = read_to_string("/proc/meminfo").ok().and_then(|text| {
            let kilobytes = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?.trim().strip_suffix("kB")?;
            Some(kilobytes.trim().parse::<u64>().ok()? * 1024)
        });
        machine.into_iter().chain(control_groups()).min()
    }

    /// The limits of the process's control groups and those above them, of either version; in a container its own group is
    /// the root of what it sees.
    fn control_groups() -> Vec<u64> {
        let mut limits = Vec::new();
        for line in read_to_string("/proc/self/cgroup").unwrap_or_default().lines() {
            let mut fields = line.splitn(3, ':').skip(1);
            let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
            let (root, file) = match controllers {
                "" => ("/sys/fs/cgroup", "memory.max"),
                _ if controllers.split(',').any(|name| name == "memory") => {
                    ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
                }
                _ => continue,
            };
            for group in std::path::Path::new(path).ancestors() {
                let group = group.display().to_string();
                let text = read_to_string(format!("{root}/{}/{file}", group.trim_matches('/')));
                limits.extend(text.ok().and_then(|text| text.trim().parse::<u64>().ok()));
            }
        }
        limits
    }

    /// Pages of `/proc/self/statm` (address space, resident), as bytes.
    fn pages(field: usize) -> Option<u64> {
        let text = read_to_string("/proc/self/statm").ok()?;
        let pages: u64 = text.split(' ').nth(field)?.trim().parse().ok()?;
        Some(pages * rustix::param::page_size() as u64)
    }

    /// What this process holds in RAM.
    pub fn resident() -> Option<u64> {
        pages(1)
    }

    /// What a limit on the address space leaves; `None`: there is no limit.
    pub fn address_space_left() -> Option<u64> {
        let text = read_to_string("/proc/self/limits").ok()?;
        let limit = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
        let soft: u64 = limit.split_whitespace().next()?.parse().ok()?;
        Some(soft.saturating_sub(pages(0)?))
    }
}

/// Elsewhere only `--max-memory` limits, and what the system refuses.
#[cfg(not(target_os = "linux"))]
mod system {
    pub fn memory() -> Option<u64> {
        None
    }

    pub fn resident() -> Option<u64> {
        None
    }

    pub fn address_space_left() -> Option<u64> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_read_well() {
        let amounts = [0, 999, 1500, 2_000_000, 1_500_000_000, 32_212_254_720, u64::MAX].map(amount);
        let expected = ["0 bytes", "999 bytes", "1.5 kB", "2.0 MB", "1.5 GB", "32 GB", "18446744 TB"];
        assert_eq!(amounts, expected);
    }

    #[test]
    fn tables_beyond_the_machine_are_refused_with_what_they_are_for() {
        let refused = table::<[f64; 8]>(usize::MAX / 128, "the film").unwrap_err().to_string();
        assert!(refused.starts_with("the film needs ") && refused.contains(" of memory, "), "{refused}");
        assert_eq!(table::<u32>(3, "a small one").unwrap(), [0; 3]);
        assert!(!refusal_is_handled() && fallibly(refusal_is_handled));
    }
}
