//! The `fdem` program, run as a user runs it: exit codes, messages, and that nothing partial is left behind.
//!
//! - `contacts`: good packings of every form and the files written for them.
//! - `bad_input`: files, options and outputs that must be refused.
//! - `bench`: the timings of the engines.
//! - `formats`: the formats of the written files.
//! - `analyse`: the analysis of the network.
//! - `generate`: packings from seeds.
//! - `periodic`: boxes that repeat, threads, and predictions before a search.
//! - `couples`: couples with forces that a file gives.
//! - `pairs`: cut-offs by pairs of types.
//! - `bodies`: elements that are parts of bodies.
//! - `labels`: images of bodies.
//! - `fluid`: fluid in cracks: results, stages, refusals.
//! - `pores`: liquid in pores: consolidation, stages, refusals.
//! - `rigid`: rigid bodies in model files.
//! - `devices`: graphics processors.
//! - `mesh`: meshes, several files, spheres against walls.
//! - `model`: new models, and models checked without a run.
//! - `conditions`: runs and stages that end on a condition; servos.
//! - `stages`: runs in stages.
//! - `joints`: joints that are open from the start, and the energies of joints.
//! - `scaling`: runs with mass scaling.
//! - `earlier`: runs that begin with the end of another one.
//! - `balance`: the energy balance at the end of a run.
//! - `runs`: simulations, interrupted and killed.
//! - `spheres`: files of runs of spheres.
//! - `series`: files of several frames, each with its box, of any format.
//! - `sweeps`: many runs of one model.
//! - `drawings`: pictures, plots and reports.
//! - `beds`: a real bed that this project did not make.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

mod analyse;
mod bad_input;
mod balance;
mod beds;
mod bench;
mod bodies;
mod conditions;
mod contacts;
mod couples;
mod devices;
mod drawings;
mod earlier;
mod flat;
mod fluid;
mod formats;
mod generate;
mod joints;
mod labels;
mod mesh;
mod model;
mod pairs;
mod periodic;
mod pores;
mod rigid;
mod runs;
mod scaling;
mod series;
mod spheres;
mod stages;
mod sweeps;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A limit of the address space, kB, with which the program and the thread that waits for signals start,
/// whatever its size: with less the system cannot load it, or the standard library ends it.
#[cfg(target_os = "linux")]
fn least_memory() -> u32 {
    let fdem = assert_cmd::cargo::cargo_bin!("fdem").display().to_string();
    let starts = |kilobytes: &u32| {
        // A backtrace takes memory too, and may wait forever for a lock if there is none.
        let line = format!("ulimit -v {kilobytes} && RUST_BACKTRACE=0 exec {fdem} generate gas -n 1");
        Command::new("sh").args(["-c", &line]).output().unwrap().status.success()
    };
    (10_000..100_000).step_by(500).find(starts).unwrap()
}

/// Whether tests that kill runs at many moments, or limit memory in many ways, try all of these instead of
/// some: `just thorough` sets `FDEM_THOROUGH`.
fn thorough() -> bool {
    std::env::var_os("FDEM_THOROUGH").is_some()
}

/// An empty folder and the program run in it.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    /// Names of all files in the folder, hidden ones too.
    fn files(&self) -> Vec<String> {
        let names = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> =
            names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("fdem"));
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap(), arguments)
    }

    /// Like [`Bench::run`], with `input` on standard input.
    fn run_with(&self, arguments: &[&str], input: &[u8]) -> Run {
        let mut command = assert_cmd::Command::from_std(self.command(arguments));
        Run::of(command.write_stdin(input).output().unwrap(), arguments)
    }
}

/// The output of the program.
struct Run {
    code: Option<i32>,
    stdout: String,
    stderr: String,
    line: String,
}

impl Run {
    fn of(output: Output, arguments: &[&str]) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
            line: arguments.join(" "),
        }
    }

    #[track_caller]
    fn succeeds(self) -> Self {
        assert_eq!(self.code, Some(0), "fdem {}\n{}", self.line, self.stderr);
        self
    }

    /// Exit code 2, nothing on standard output, and a message with all of `parts`.
    #[track_caller]
    fn refused_with(self, parts: &[&str]) -> Self {
        assert_eq!(self.code, Some(2), "fdem {}\n{}", self.line, self.stderr);
        assert_eq!(self.stdout, "", "fdem {}", self.line);
        for part in parts {
            assert!(self.stderr.contains(part), "fdem {}: {part:?} is not in\n{}", self.line, self.stderr);
        }
        self
    }

    /// The data rows of the CSV on standard output.
    fn rows(&self) -> Vec<&str> {
        let mut lines = self.stdout.lines();
        assert_eq!(lines.next(), Some("i,j,distance,overlap"));
        lines.collect()
    }
}

/// The folder of data that this project did not make, if it is there.
fn foreign_data(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!("SKIPPED: {} is not there", path.display());
    None
}
