//! Why the command stops, and with which exit code.

use std::fmt;
use std::io;
use std::path::Path;
use std::process::ExitCode;

#[derive(Debug)]
pub(crate) enum Failure {
    /// The input, the options or the output are at fault: exit code 2.
    Unusable(String),
    /// A check that was asked for failed: exit code 1.
    Wrong(String),
    /// Whoever read our standard output has enough (`| head`): not an error.
    ReaderLeft,
}

impl Failure {
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Unusable(_) => ExitCode::from(2),
            Self::Wrong(_) => ExitCode::from(1),
            Self::ReaderLeft => ExitCode::SUCCESS,
        }
    }

    /// An output that cannot be written.
    pub(crate) fn writing(name: &Path, error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Self::ReaderLeft;
        }
        Self::Unusable(format!("cannot write {}: {error}", name.display()))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unusable(message) | Self::Wrong(message) => out.write_str(message),
            Self::ReaderLeft => out.write_str("the reader of the output left"),
        }
    }
}
