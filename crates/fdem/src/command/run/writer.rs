//! A thread that writes frames, history and checkpoints during the run.
//!
//! The run hands it copies through a queue, and it writes them in their order: the files to which a
//! checkpoint refers are on the disk before the checkpoint is. The queue is short, so that the copies do not
//! fill the memory; a run that is faster than the writer waits. The writer waits for the disk only when
//! nothing waits for the writer, and before a checkpoint.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::thread::JoinHandle;

use fdem_results::Row;
use fdem_simulation::{Forces, Snapshot};

use crate::command::failure::Failure;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::recorder::Recorder;
use crate::command::run::results::Results;
use crate::command::threads;

/// Tasks that wait besides the one that is being written. With one place the run need not wait where a frame
/// and a checkpoint are due at the same step; each place costs the memory of a frame.
const PLACES: usize = 1;

/// A task of the writer: it writes rows of the history, and after them a frame, a checkpoint or nothing. Rows
/// share a place in the queue with the frame or checkpoint that follows them.
pub(crate) struct WriterTask<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    pub(crate) rows: Vec<Row>,
    pub(crate) then: Then<D, N>,
}

/// The second part of a task.
pub(crate) enum Then<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    Nothing,
    /// The frames that follow have another mesh, with these outlines.
    Outlines(<[[f64; D]; N] as Results<D, N>>::Outlines),
    Frame(Box<(Snapshot<D, N>, Forces<D>)>),
    /// The state in which a run is interrupted between two frames.
    LastState(Box<(Snapshot<D, N>, Forces<D>)>),
    Checkpoint(Box<Checkpoint<D, N>>),
}

/// The thread, and the queue to it.
pub(crate) struct Writer<const D: usize, const N: usize>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// `None` once the thread is to end.
    queue: Option<SyncSender<WriterTask<D, N>>>,
    /// Number of tasks that have been handed over and are not done.
    undone: Arc<AtomicUsize>,
    /// `None` once it has ended.
    thread: Option<JoinHandle<Result<Recorder<D, N>, Failure>>>,
}

impl<const D: usize, const N: usize> Writer<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Starts the thread.
    pub(crate) fn start(recorder: Recorder<D, N>) -> Result<Self, Failure> {
        let (queue, tasks) = sync_channel(PLACES);
        let undone = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&undone);
        let thread = threads::start("results", move || write(recorder, &tasks, &count));
        let thread = thread.map_err(|error| {
            Failure::Unusable(format!("cannot start the thread that writes results: {error}"))
        })?;
        Ok(Self { queue: Some(queue), undone, thread: Some(thread) })
    }

    /// Hands over a task, and waits for a place in the queue.
    ///
    /// # Errors
    /// The error for which the thread has ended.
    pub(crate) fn send(&mut self, task: WriterTask<D, N>) -> Result<(), Failure> {
        self.undone.fetch_add(1, Ordering::Relaxed);
        match self.queue.as_ref().map(|queue| queue.send(task)) {
            Some(Ok(())) => Ok(()),
            _ => self.finish().map(drop),
        }
    }

    /// Whether the queue has a place, so that the run need not wait to hand something over.
    pub(crate) fn has_room(&self) -> bool {
        // One task may be in work, and is not in the queue.
        self.undone.load(Ordering::Relaxed) <= PLACES
    }

    /// Hands over a task if there is a place in the queue, and gives it back if there is none.
    ///
    /// # Errors
    /// The error for which the thread has ended.
    pub(crate) fn offer(&mut self, task: WriterTask<D, N>) -> Result<Option<WriterTask<D, N>>, Failure> {
        self.undone.fetch_add(1, Ordering::Relaxed);
        match self.queue.as_ref().map(|queue| queue.try_send(task)) {
            Some(Ok(())) => Ok(None),
            Some(Err(TrySendError::Full(task))) => {
                self.undone.fetch_sub(1, Ordering::Relaxed);
                Ok(Some(task))
            }
            _ => self.finish().map(|_| None),
        }
    }

    /// Notices whether the thread could not write something.
    ///
    /// # Errors
    /// The error for which the thread has ended.
    pub(crate) fn check(&mut self) -> Result<(), Failure> {
        // The thread ends early only on an error.
        match &self.thread {
            Some(thread) if thread.is_finished() => self.finish().map(drop),
            _ => Ok(()),
        }
    }

    /// Waits until all is written, and ends the thread.
    ///
    /// # Errors
    /// The first error of the thread. Later tasks have not been written.
    pub(crate) fn finish(&mut self) -> Result<Recorder<D, N>, Failure> {
        drop(self.queue.take());
        let ended = self.thread.take().map(JoinHandle::join);
        match ended {
            Some(Ok(written)) => written,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Err(Failure::Unusable("the thread that writes results has ended".to_owned())),
        }
    }
}

impl<const D: usize, const N: usize> Drop for Writer<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// The tasks of a run that ends with an error are written, too.
    fn drop(&mut self) {
        drop(self.queue.take());
        if let Some(thread) = self.thread.take() {
            // The error of the run has been reported already.
            let _ = thread.join();
        }
    }
}

/// Writes tasks until the queue closes, and tidies up between them.
fn write<const D: usize, const N: usize>(
    mut recorder: Recorder<D, N>,
    tasks: &Receiver<WriterTask<D, N>>,
    undone: &AtomicUsize,
) -> Result<Recorder<D, N>, Failure>
where
    [[f64; D]; N]: Results<D, N>,
{
    loop {
        let task = match tasks.try_recv() {
            Err(TryRecvError::Empty) if recorder.tidy()? => continue,
            Err(TryRecvError::Empty) => tasks.recv().ok(),
            task => task.ok(),
        };
        let Some(WriterTask { rows, then }) = task else { break };
        recorder.rows(&rows)?;
        match then {
            Then::Nothing => {}
            Then::Outlines(outlines) => recorder.outline(outlines),
            Then::Frame(frame) => recorder.frame(&frame.0, &frame.1)?,
            Then::LastState(frame) => recorder.last_state(&frame.0, &frame.1)?,
            Then::Checkpoint(state) => recorder.save(&state)?,
        }
        undone.fetch_sub(1, Ordering::Relaxed);
    }
    recorder.tidy_up()?;
    recorder.release();
    Ok(recorder)
}
