//! Peers in other languages: programs that search on request. For the protocol see
//! `bench/external/README.md`.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// The command that starts a peer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// Name in the tables.
    pub name: String,
    words: Vec<String>,
}

impl Command {
    /// Parses `NAME=PROGRAM ARGUMENT...`, with words separated by spaces; `None` if a part is missing.
    pub fn parse(text: &str) -> Option<Self> {
        let (name, command) = text.split_once('=')?;
        let words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        (!name.is_empty() && !words.is_empty()).then(|| Self { name: name.to_owned(), words })
    }
}

/// The result of a peer for one round.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Time from coordinates in its memory to pairs in its memory, by its own clock.
    pub seconds: f64,
    /// Number of pairs.
    pub pairs: u64,
}

/// A running peer with the bodies of one set in its memory; it is ended when dropped.
pub struct External {
    child: Child,
    input: ChildStdin,
    lines: Receiver<String>,
    patience: Duration,
    /// Its version, and a description of the call.
    pub about: (String, String),
}

impl External {
    /// Starts a peer with `file`, little-endian `f64` numbers of bodies of `dimension` axes. `kind` is the
    /// cut-off or the kind of bodies. The peer must answer within `patience`.
    ///
    /// # Errors
    /// The program does not start, or cannot search these bodies; the text gives the reason.
    pub fn start(
        command: &Command,
        (file, dimension): (&Path, usize),
        kind: &str,
        threads: usize,
        patience: Duration,
    ) -> Result<Self, String> {
        let (program, own) = command.words.split_first().ok_or("no command")?;
        let mut child = std::process::Command::new(program)
            .args(own)
            .arg(file)
            .args([&dimension.to_string(), kind, &threads.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("cannot be started: {error}"))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipe".to_owned());
        };
        // A separate thread reads lines, so that waiting for them can time out.
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        let mut external = Self { child, input, lines, patience, about: (String::new(), String::new()) };
        let line = external.line()?;
        let about = line.strip_prefix("ready ").and_then(|about| about.split_once("; "));
        let (version, how) = about.ok_or_else(|| format!("not ready: {line}"))?;
        external.about = (version.to_owned(), how.to_owned());
        Ok(external)
    }

    /// One search.
    ///
    /// # Errors
    /// The reason why there is no answer.
    pub fn round(&mut self) -> Result<Answer, String> {
        self.input.write_all(b"round\n").map_err(|error| error.to_string())?;
        let line = self.line()?;
        // Its threads may spin for a while; they must not take time from the next search.
        std::thread::sleep(Duration::from_millis(20));
        let numbers = line.split_once(' ').and_then(|(time, pairs)| {
            let milliseconds: f64 = time.parse().ok().filter(|&time| time > 0.0)?;
            Some(Answer { seconds: 1e-3 * milliseconds, pairs: pairs.parse().ok()? })
        });
        numbers.ok_or_else(|| format!("not an answer: {line}"))
    }

    fn line(&self) -> Result<String, String> {
        let line = self.lines.recv_timeout(self.patience).map_err(|error| match error {
            RecvTimeoutError::Timeout => format!("no answer within {} s", self.patience.as_secs_f64()),
            RecvTimeoutError::Disconnected => "ended without an answer".to_owned(),
        })?;
        line.strip_prefix("error ").map_or(Ok(line.clone()), |reason| Err(reason.to_owned()))
    }
}

impl Drop for External {
    fn drop(&mut self) {
        // Both calls fail only if the program has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn start(script: &str) -> Result<External, String> {
        let words = ["sh", "-c", script].map(str::to_owned).to_vec();
        let command = Command { name: "sh".to_owned(), words };
        External::start(&command, (Path::new("points"), 3), "1", 2, Duration::from_millis(500))
    }

    #[test]
    fn a_round_is_answered_and_an_error_comes_out() {
        let mut external =
            start("echo \"ready 1.0; $0 $1 $2 $3\"; read x; echo 250 7; read x; echo error tired").unwrap();
        assert_eq!(external.about, ("1.0".to_owned(), "points 3 1 2".to_owned()));
        assert_eq!(external.round(), Ok(Answer { seconds: 0.25, pairs: 7 }));
        assert_eq!(external.round(), Err("tired".to_owned()));
        assert!(external.round().is_err());
    }

    #[test]
    fn what_cannot_take_part_says_why() {
        let reason = |script| start(script).err().unwrap();
        assert_eq!(reason("echo error 3D only"), "3D only");
        assert_eq!(reason("echo hello"), "not ready: hello");
        assert_eq!(reason("exit 1"), "ended without an answer");
        assert_eq!(reason("exec sleep 9"), "no answer within 0.5 s");
        let mut wrong = start("echo 'ready 1; x'; read x; echo 0 many").unwrap();
        assert_eq!(wrong.round(), Err("not an answer: 0 many".to_owned()));
    }

    #[test]
    fn commands() {
        let command = Command::parse("scipy=python3 a.py scipy").unwrap();
        assert_eq!((command.name.as_str(), command.words.len()), ("scipy", 3));
        assert_eq!(
            [Command::parse("scipy"), Command::parse("=a"), Command::parse("a= ")],
            [None, None, None]
        );
    }
}
