//! Common parts of the benchmarks: a timer, a table, the machine, the packings and bodies, the peers and the
//! pictures.

pub mod bars;
pub mod bodies;
mod packing;
pub mod peers;
pub mod picture;
mod table;
mod timer;

pub use packing::Packing;
pub use table::{Table, grouped, significant};
pub use timer::{Rounds, Task, Times, Turn, times, turns};

/// Processor, cores, compiler and version of this package in one line, for runs with these numbers of
/// threads. Unknown items are left out.
pub fn machine(threads: &[usize]) -> String {
    let mut facts = vec![format!("fdem {}", env!("CARGO_PKG_VERSION")), processor()];
    if let Some(cores) = cores() {
        let used: Vec<String> = threads.iter().map(ToString::to_string).collect();
        let plural = if threads == [1] { "" } else { "s" };
        let several = if cores == 1 { "" } else { "s" };
        facts.push(format!("{cores} core{several}, {} thread{plural} used", used.join(" and ")));
    }
    if let Some(version) = compiler() {
        facts.push(version);
    }
    if cfg!(debug_assertions) {
        facts.push("DEBUG BUILD: these times mean nothing".to_owned());
    }
    facts.join("; ")
}

fn processor() -> String {
    let described = cpuinfo();
    let named = described.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    named.map_or(std::env::consts::ARCH, |(_, name)| name).to_owned()
}

/// The system's description of the processors; empty if there is none.
fn cpuinfo() -> String {
    std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default()
}

/// Number of processors of the machine, also where this process may use fewer of them.
fn cores() -> Option<usize> {
    let listed = cpuinfo().lines().filter(|line| line.starts_with("processor")).count();
    (listed > 0).then_some(listed).or_else(|| std::thread::available_parallelism().ok().map(usize::from))
}

fn compiler() -> Option<String> {
    let output = std::process::Command::new("rustc").arg("--version").output().ok()?;
    let version = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| version.trim().to_owned())
}
