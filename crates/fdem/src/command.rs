//! The command line: the only place that knows paths, the terminal and exit codes.
//!
//! Exit code 0: done; 1: a check that was asked for failed; 2: bad input, bad usage, or an output that cannot be
//! written; 128 and the number of the signal: interrupted. Unless it is 0 no output file is left behind, not even a part of one.

mod analyse;
mod args;
mod bench;
mod check;
mod contacts;
mod detect;
mod drawings;
mod explain;
mod failure;
mod frames;
mod generate;
mod input;
mod label_summary;
mod labels;
mod mesh_summary;
mod meshes;
mod new;
mod output;
mod periodic;
mod progress;
mod run;
mod series;
mod series_summary;
mod summary;
mod tables;
mod validate;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, Task};

/// Runs the command with `arguments`, the first of which is the program's name, and returns its exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(run(arguments))
}

/// As [`main`], with the exit code as a number, for programs that do not end with it.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        // Help and version are "errors" of the parser too: it knows which stream and code each needs.
        Err(error) => {
            let _ = error.print();
            return error.exit_code() as u8;
        }
    };
    // Runs of models do not lose what they have when they are interrupted.
    let watched = match arguments.task {
        Task::Run(_) | Task::Resume(_) => Ok(()),
        _ => output::remove_partial_output_when_interrupted(),
    };
    let done = watched.and_then(|()| match arguments.task {
        Task::Contacts(arguments) => contacts::run(&arguments),
        Task::Bench(arguments) => bench::run(&arguments),
        Task::Generate(arguments) => generate::run(&arguments),
        Task::New(arguments) => new::run(&arguments),
        Task::Check(arguments) => check::run(&arguments),
        Task::Run(arguments) => run::run(&arguments),
        Task::Resume(arguments) => run::resume(&arguments),
        Task::Validate(arguments) => validate::run(&arguments),
    });
    match done {
        Ok(()) => 0,
        Err(failure) => {
            // Nothing is left to do if even the error cannot be printed.
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            failure.exit_code()
        }
    }
}
