//! Reasons for which the command stops, and their exit codes.

use std::fmt;
use std::io;
use std::path::Path;

#[derive(Debug)]
pub(crate) enum Failure {
    /// The input, the options or the output cannot be used: exit code 2.
    Unusable(String),
    /// A requested check failed, or a simulation stopped early: exit code 1.
    Wrong(String),
    /// A signal interrupted the program: exit code 128 plus its number.
    Interrupted { message: String, signal: i32 },
}

impl Failure {
    pub(crate) fn exit_code(&self) -> u8 {
        match self {
            Self::Unusable(_) => 2,
            Self::Wrong(_) => 1,
            Self::Interrupted { signal, .. } => (128 + signal) as u8,
        }
    }

    /// The failure of `--verify`.
    pub(crate) fn of_couples(name: &str, mismatch: &str) -> Self {
        Self::Wrong(format!(
            "{name}: --verify: {mismatch} (numbered in the order of the file, from 0). This is a bug in fdem: please report it with \
             the file. Nothing was written"
        ))
    }

    /// The failure for an input that cannot be opened or read.
    pub(crate) fn reading(name: &str, error: &io::Error) -> Self {
        Self::Unusable(format!("cannot read {name}: {error}"))
    }

    /// The failure for an output that cannot be written.
    pub(crate) fn writing(path: &Path, error: impl fmt::Display) -> Self {
        Self::Unusable(format!("cannot write {}: {error}", display_name(path)))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unusable(message) | Self::Wrong(message) | Self::Interrupted { message, .. } => {
                out.write_str(message)
            }
        }
    }
}

/// Returns a path as messages show it. Control characters are escaped, so that a file name cannot control the
/// terminal.
pub(crate) fn display_name(path: &Path) -> String {
    let escape = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    path.to_string_lossy().chars().map(escape).collect()
}
