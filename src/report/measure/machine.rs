//! Where figures were measured.

use serde::Serialize;

/// The machine, as far as it tells.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The processor's name; `unknown` where the system does not say.
    pub cpu: String,
    /// Threads it runs at once.
    pub cores: usize,
    /// Operating system and architecture.
    pub os: String,
}

impl Machine {
    /// This one.
    pub fn here() -> Machine {
        Machine {
            cpu: processor().unwrap_or_else(|| "unknown processor".to_owned()),
            cores: std::thread::available_parallelism().map_or(1, |n| n.get()),
            os: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

/// The name that every x86-64 processor gives itself.
#[cfg(target_arch = "x86_64")]
fn processor() -> Option<String> {
    let brand = raw_cpuid::CpuId::new().get_processor_brand_string()?;
    Some(brand.as_str().trim().to_owned()).filter(|name| !name.is_empty())
}

/// The name that the system has for it.
#[cfg(not(target_arch = "x86_64"))]
fn processor() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let (_, name) = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "))?;
    Some(name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_has_a_name_on_one_line() {
        let Machine { cpu, cores, os } = Machine::here();
        assert!(cpu.len() > 3 && !cpu.contains(['\0', '\n']) && cpu == cpu.trim(), "{cpu:?}");
        assert!(cores > 0 && os.contains(' '));
    }

    #[test]
    fn an_x86_64_processor_has_the_name_that_linux_shows() {
        let Ok(info) = std::fs::read_to_string("/proc/cpuinfo") else { return };
        if cfg!(target_arch = "x86_64") {
            assert!(info.contains(&Machine::here().cpu), "{:?}", Machine::here().cpu);
        }
    }
}
