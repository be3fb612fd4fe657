//! The `fdem` command.

mod reserve;

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: reserve::Reserve = reserve::Reserve::new();

fn main() -> ExitCode {
    fdem::command::main(std::env::args_os())
}

/// Records whether the program was started without standard output (`>&-`). The standard library opens
/// `/dev/null` in its place before `main`, and everything printed would be lost without an error.
#[cfg(unix)]
#[ctor::ctor(unsafe)]
fn look_at_stdout() {
    use std::fs::symlink_metadata;
    use std::io::ErrorKind;
    // A system that does not list open files gives no answer.
    let is_listed =
        |file: &str| !symlink_metadata(file).is_err_and(|error| error.kind() == ErrorKind::NotFound);
    if is_listed("/dev/fd/") && !is_listed("/dev/fd/1") {
        fdem::command::stdout_is_closed();
    }
}
