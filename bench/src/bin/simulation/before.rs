//! The version before: another binary of this program, in a process that waits between its turns.

use std::error::Error;
use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A process that simulates the same body, a few steps at each request.
pub(crate) struct Before {
    process: Child,
    asks: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
}

/// Time and contacts of one turn of the earlier version.
pub(crate) struct Turn {
    /// Seconds for all steps of the turn.
    pub(crate) seconds: f64,
    /// Contacts at its end.
    pub(crate) contacts: f64,
}

impl Before {
    /// Starts the process, and waits until it has taken the steps before the first turn.
    pub(crate) fn start(program: &Path, case: [&str; 4]) -> Result<Self, Box<dyn Error>> {
        let told = |error: &dyn std::fmt::Display| format!("{}: {error}", program.display());
        let mut process = Command::new(program)
            .arg("turns")
            .args(case)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| told(&error))?;
        let (asks, answers) = (process.stdin.take(), process.stdout.take());
        let (Some(asks), Some(answers)) = (asks, answers) else { return Err(told(&"no pipes").into()) };
        let mut before = Self { process, asks, answers: BufReader::new(answers).lines() };
        match before.answer()?.as_str() {
            "ready" => Ok(before),
            _ => {
                Err(told(&"not this benchmark of an earlier version; README.md says how to build it").into())
            }
        }
    }

    /// Lets the process take the steps of one turn.
    pub(crate) fn turn(&mut self) -> Result<Turn, Box<dyn Error>> {
        writeln!(self.asks, "turn")?;
        let answer = self.answer()?;
        let turn = answer.split_once(' ').and_then(|(seconds, contacts)| {
            Some(Turn { seconds: seconds.parse().ok()?, contacts: contacts.parse().ok()? })
        });
        Ok(turn.ok_or_else(|| format!("the version before answers {answer:?}"))?)
    }

    /// The next line of the process; empty if it has ended.
    fn answer(&mut self) -> Result<String, Box<dyn Error>> {
        Ok(self.answers.next().transpose()?.unwrap_or_default())
    }
}

impl Drop for Before {
    /// Ends the process and waits for it, so that its memory is free for the next body.
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The other side: takes a turn whenever a line comes in, until the input ends.
pub(crate) fn answer(mut turn: impl FnMut() -> Result<Turn, Box<dyn Error>>) -> Result<(), Box<dyn Error>> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "ready")?;
    out.flush()?;
    for ask in std::io::stdin().lock().lines() {
        ask?;
        let Turn { seconds, contacts } = turn()?;
        writeln!(out, "{seconds} {contacts}")?;
        out.flush()?;
    }
    Ok(())
}
