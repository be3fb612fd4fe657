//! The command line: the only place that knows paths, the terminal and exit codes.
//!
//! Exit code 0: done; 1: a requested check failed; 2: bad input, bad usage, or an output that cannot be
//! written; 128 plus the number of the signal: interrupted. Unless the code is 0, no output file is left
//! behind, not even a partial one; only simulations keep their results.

mod analyse;
mod args;
mod aside;
mod bench;
mod check;
mod contacts;
mod couples;
mod cut_elements;
mod cutoff;
mod device;
pub mod device_name;
mod drawings;
mod explain;
mod failure;
mod folder_lock;
mod frames;
mod generate;
mod input;
mod label_axes;
mod label_middles;
mod label_summary;
mod labels;
mod lengths;
mod materials;
mod memory;
mod mesh_summary;
mod meshes;
mod model_file;
mod new;
mod output;
mod outputs;
mod packing;
mod periodic;
pub mod pieces;
mod progress;
mod ranks;
mod ranks_contacts;
mod ranks_file;
mod rehearsal;
mod run;
mod series;
mod series_summary;
mod series_table;
pub mod session;
mod shapes;
mod summary;
pub mod sweep;
mod tables;
mod templates;
mod threads;
mod validate;

use std::ffi::OsString;
use std::io::{self, Write};
use std::process::ExitCode;

use clap::Parser;

use args::{Arguments, ContactsArguments, Task};
use failure::Failure;
use ranks::{Ranks, is_another_rank};
pub use tables::network_file;

/// Runs the command with `arguments`, the first of which is the program's name, and returns its exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(run(arguments))
}

/// Like [`main`], with the exit code as a number, for programs that do not end with it.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        // All ranks have the same arguments, so one of them answers.
        Err(error) if is_another_rank() => return error.exit_code() as u8,
        Err(error) => return help_or_refusal(&error),
    };
    let ranks = match Ranks::start() {
        Ok(ranks) => ranks,
        Err(failure) if is_another_rank() => return failure.exit_code(),
        Err(failure) => return refusal(&failure),
    };
    let code = carry_out(arguments, &ranks);
    // MPI ends here, on all ranks together.
    drop(ranks);
    code
}

/// Carries out the task, and returns the exit code.
fn carry_out(arguments: Arguments, ranks: &Ranks) -> u8 {
    // Interrupted simulations keep their results and handle signals themselves.
    let watched = match arguments.task {
        Task::Run(_) | Task::Resume(_) | Task::Sweep(_) => Ok(()),
        _ => output::remove_partial_output_when_interrupted(),
    };
    let watched = ranks.agree(watched).and_then(|()| refuse_several(&arguments.task, ranks));
    let done = watched.and_then(|()| match arguments.task {
        Task::Contacts(arguments) => find_contacts(&arguments, ranks),
        Task::Bench(arguments) => bench::run(&arguments),
        Task::Generate(arguments) => generate::run(&arguments),
        Task::New(arguments) => new::run(&arguments),
        Task::Materials(arguments) => materials::run(&arguments),
        Task::Check(arguments) => check::run(&arguments),
        Task::Run(arguments) => run::run(&arguments, ranks.communicator()),
        Task::Resume(arguments) => run::resume(&arguments, ranks.communicator()),
        Task::Sweep(arguments) => sweep::run(&arguments),
        Task::Validate(arguments) => validate::run(&arguments),
        Task::Devices => device::list(),
    });
    match done {
        Ok(()) => 0,
        // All ranks have the same failure.
        Err(failure) if !ranks.prints() => failure.exit_code(),
        Err(failure) => refusal(&failure),
    }
}

/// Refuses tasks that work in one process, on several ranks.
fn refuse_several(task: &Task, ranks: &Ranks) -> Result<(), Failure> {
    let name = match task {
        Task::Contacts(_) | Task::Run(_) | Task::Resume(_) => return Ok(()),
        Task::Bench(_) => "bench",
        Task::Generate(_) => "generate",
        Task::New(_) => "new",
        Task::Materials(_) => "materials",
        Task::Check(_) => "check",
        Task::Sweep(_) => "sweep",
        Task::Validate(_) => "validate",
        Task::Devices => "devices",
    };
    ranks.refuse_several(name)
}

fn find_contacts(arguments: &ContactsArguments, ranks: &Ranks) -> Result<(), Failure> {
    match ranks.communicator() {
        Some(communicator) => ranks_contacts::run(arguments, communicator),
        None => contacts::run(arguments),
    }
}

/// Prints a failure, and returns its exit code.
fn refusal(failure: &Failure) -> u8 {
    // Nothing can be done if even the error cannot be printed.
    let _ = writeln!(io::stderr(), "error: {failure}");
    failure.exit_code()
}

/// Prints the message of the parser and returns the exit code. Help and version are also "errors" of the
/// parser: they go to standard output, and it is an error if it cannot be written.
fn help_or_refusal(error: &clap::Error) -> u8 {
    if error.use_stderr() {
        // Nothing can be done if even the error cannot be printed.
        let _ = error.print();
        return error.exit_code() as u8;
    }
    match output::check_stdout().and_then(|()| error.print()).and_then(|()| io::stdout().flush()) {
        // It is no error if the reader ends early (`| head`).
        Err(problem) if problem.kind() != io::ErrorKind::BrokenPipe => {
            let _ = writeln!(io::stderr(), "error: cannot write standard output: {problem}");
            2
        }
        _ => error.exit_code() as u8,
    }
}

/// Notes that the program was started without standard output (`>&-`). The standard library opens
/// `/dev/null` in its place before `main`, so only code that runs earlier can find out.
pub fn stdout_is_closed() {
    output::stdout_is_closed();
}
