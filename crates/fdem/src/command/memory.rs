//! Memory of the machine, on systems that report it.

use std::fs;

/// Bytes that this process can still allocate: the free memory of the machine, or less if a limit of the
/// process allows less. `None` without `/proc/meminfo`.
pub(crate) fn free() -> Option<f64> {
    let machine = kilobytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:");
    let limits = fs::read_to_string("/proc/self/limits").ok();
    let limit = limits.as_deref().and_then(address_space);
    let taken = fs::read_to_string("/proc/self/status").ok().and_then(|text| kilobytes(&text, "VmSize:"));
    let process = limit.map(|limit| (limit - taken.unwrap_or(0.0)).max(0.0));
    match (machine, process) {
        (Some(machine), Some(process)) => Some(machine.min(process)),
        (machine, process) => machine.or(process),
    }
}

/// Three quarters of the memory of the machine, or of the limit of the process or its group if that is lower,
/// bytes. `None` on systems that do not report it.
pub(crate) fn default_limit() -> Option<u64> {
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| kilobytes(&text, "MemTotal:"));
    let limits = fs::read_to_string("/proc/self/limits").ok();
    let process = limits.as_deref().and_then(address_space);
    // `max` if the group has no limit.
    let group =
        fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    let least = [machine, process, group].into_iter().flatten().reduce(f64::min)?;
    Some((0.75 * least) as u64)
}

/// Value of a line such as `MemAvailable:   123 kB`, bytes.
fn kilobytes(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find(|line| line.starts_with(name))?;
    let number: f64 = line[name.len()..].split_whitespace().next()?.parse().ok()?;
    Some(1024.0 * number)
}

/// The soft limit of the address space, bytes; `None` if there is none.
fn address_space(limits: &str) -> Option<f64> {
    let line = limits.lines().find(|line| line.starts_with("Max address space"))?;
    line["Max address space".len()..].split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_says_is_read() {
        assert_eq!(
            kilobytes("MemTotal: 9 kB\nMemAvailable:   2000 kB\n", "MemAvailable:"),
            Some(2_048_000.0)
        );
        let limits =
            "Limit  Soft Limit  Hard Limit  Units\nMax address space         1024000000 unlimited bytes\n";
        assert_eq!(address_space(limits), Some(1_024_000_000.0));
        assert_eq!(address_space("Max address space         unlimited unlimited bytes\n"), None);
    }
}
