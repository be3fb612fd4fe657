//! The `fdem` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    fdem::command::main(std::env::args_os())
}
