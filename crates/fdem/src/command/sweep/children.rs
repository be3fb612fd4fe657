//! The runs of a sweep as separate processes, several at a time.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use crate::command::failure::Failure;

/// Time between two looks for signals.
const PERIOD: Duration = Duration::from_millis(50);

/// Bytes of the messages of a run that are kept.
const MESSAGES: u64 = 1 << 20;

/// A run that has to be done.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Job {
    /// Number of the run, from 1.
    pub(crate) number: usize,
    /// Arguments of the command.
    pub(crate) arguments: Vec<OsString>,
}

/// Jobs that wait, and the processes that work.
struct Shared {
    waiting: Vec<Job>,
    working: BTreeMap<usize, u32>,
    /// The signal that ends the sweep.
    signal: Option<i32>,
}

/// Does all jobs, `processes` at a time, in their order. `program`: the command and its first arguments.
/// `stop` returns a signal when the sweep is to end: then running jobs get it, are waited for, and no others
/// are begun. `ended` is called for each job that has ended, with its messages.
///
/// # Errors
/// The first failure of `ended`, after which the sweep ends in the same way.
pub(crate) fn work(
    program: &[OsString],
    mut jobs: Vec<Job>,
    processes: usize,
    stop: &mut dyn FnMut() -> Option<i32>,
    ended: &mut dyn FnMut(usize, &str) -> Result<(), Failure>,
) -> Result<Option<i32>, Failure> {
    let workers = processes.clamp(1, jobs.len().max(1));
    jobs.reverse();
    let shared = Mutex::new(Shared { waiting: jobs, working: BTreeMap::new(), signal: None });
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..workers {
            let (shared, sender) = (&shared, sender.clone());
            scope.spawn(move || while one(program, shared, &sender) {});
        }
        drop(sender);
        let mut failure = None;
        loop {
            match receiver.recv_timeout(PERIOD) {
                Ok((number, said)) => {
                    if let (Err(error), None) = (ended(number, &said), &failure) {
                        failure = Some(error);
                        end(&shared, 2);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if let Some(signal) = stop() {
                end(&shared, signal);
            }
        }
        match failure {
            Some(failure) => Err(failure),
            None => Ok(lock(&shared).signal),
        }
    })
}

fn lock(shared: &Mutex<Shared>) -> std::sync::MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Begins no further jobs, and sends the signal to the running ones, once.
fn end(shared: &Mutex<Shared>, signal: i32) {
    let mut shared = lock(shared);
    if shared.signal.is_none() {
        shared.signal = Some(signal);
        shared.waiting.clear();
        // Processes are waited for only after they are taken off this list, so none of these numbers is that
        // of another process.
        shared.working.values().for_each(|process| send(*process, signal));
    }
}

#[cfg(unix)]
fn send(process: u32, signal: i32) {
    use rustix::process::{Pid, Signal, kill_process};
    let signal = match signal {
        1 => Signal::HUP,
        15 => Signal::TERM,
        _ => Signal::INT,
    };
    if let Some(process) = Pid::from_raw(process.cast_signed()) {
        // The process may have ended in the meantime.
        let _ = kill_process(process, signal);
    }
}

/// Where there are no signals, the terminal sends Ctrl-C to all its processes.
#[cfg(not(unix))]
fn send(_: u32, _: i32) {}

/// Does the next job. Returns `false` if there is none.
fn one(program: &[OsString], shared: &Mutex<Shared>, ended: &Sender<(usize, String)>) -> bool {
    let mut guard = lock(shared);
    let Some(Job { number, arguments }) = guard.waiting.pop() else { return false };
    let (name, first) = program
        .split_first()
        .map_or(("fdem".as_ref(), &program[..0]), |(name, first)| (name.as_os_str(), first));
    let mut command = Command::new(name);
    command.args(first).args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    // The process is begun under the lock, so that a signal reaches it or comes before it.
    let begun = command.spawn();
    let said = match begun {
        Err(error) => {
            drop(guard);
            format!("the run cannot be started: {error}")
        }
        Ok(mut child) => {
            guard.working.insert(number, child.id());
            drop(guard);
            let mut said = Vec::new();
            if let Some(messages) = &mut child.stderr {
                // Messages that cannot be read are left out.
                let _ = messages.take(MESSAGES).read_to_end(&mut said);
                let _ = std::io::copy(messages, &mut std::io::sink());
            }
            lock(shared).working.remove(&number);
            let status = child.wait();
            let mut said = String::from_utf8_lossy(&said).trim().to_owned();
            if let (true, Ok(status)) = (said.is_empty(), status) {
                said = format!("the process of the run ended with {status}");
            }
            said
        }
    };
    // The other end is there as long as there are workers.
    ended.send((number, said)).is_ok()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::time::Instant;

    fn shell(number: usize, line: &str) -> Job {
        Job { number, arguments: ["-c", line].map(OsString::from).into() }
    }

    #[test]
    fn all_jobs_are_done_and_heard() {
        let jobs =
            (1..=6).map(|number| shell(number, &format!("echo {number} >&2; exit {number}"))).collect();
        let mut heard = BTreeMap::new();
        let mut ended = |number: usize, said: &str| {
            heard.insert(number, said.to_owned());
            Ok(())
        };
        assert_eq!(work(&["sh".into()], jobs, 3, &mut || None, &mut ended).unwrap(), None);
        assert_eq!(
            heard.into_iter().collect::<Vec<_>>(),
            (1..=6).map(|n| (n, n.to_string())).collect::<Vec<_>>()
        );
    }

    #[test]
    fn a_signal_ends_those_that_work_and_begins_no_more() {
        let jobs = (1..=9)
            .map(|number| shell(number, "trap 'echo caught >&2; exit 1' TERM; while :; do sleep 0.05; done"))
            .collect();
        let start = Instant::now();
        let mut stop = || (start.elapsed() > Duration::from_millis(500)).then_some(15);
        let mut heard = Vec::new();
        let mut ended = |number: usize, said: &str| {
            heard.push((number, said.to_owned()));
            Ok(())
        };
        assert_eq!(work(&["sh".into()], jobs, 2, &mut stop, &mut ended).unwrap(), Some(15));
        heard.sort();
        assert_eq!(heard, [(1, "caught".to_owned()), (2, "caught".to_owned())]);
    }

    #[test]
    fn a_program_that_is_not_there_is_told() {
        let mut heard = String::new();
        let mut ended = |_: usize, said: &str| {
            heard = said.to_owned();
            Ok(())
        };
        work(&["no-such-program".into()], vec![shell(1, "")], 1, &mut || None, &mut ended).unwrap();
        assert!(heard.starts_with("the run cannot be started: "), "{heard}");
    }
}
