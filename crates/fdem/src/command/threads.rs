//! Threads that begin even where memory ends soon, and how many a simulation may have.

use std::io;
use std::num::NonZero;
use std::sync::mpsc;
use std::thread::{Builder, JoinHandle};

use memmap2::MmapMut;

/// Stack of a thread, bytes.
const STACK: usize = 2 << 20;

/// Memory that a thread needs when it begins, besides its stack, bytes: more than enough.
const BEGINNING: usize = 1 << 18;

/// Starts a thread with a name, and returns when it has begun.
///
/// The standard library and the C library end a program that has no memory for the beginning of a thread.
/// This function therefore checks first that there is some, and the work that may take all memory comes after
/// it.
///
/// # Errors
/// No memory, or no thread left.
pub(crate) fn start<R: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> R + Send + 'static,
) -> io::Result<JoinHandle<R>> {
    // Memory of the system, which a new thread uses: the heap may have some that the thread cannot use.
    drop(MmapMut::map_anon(STACK + BEGINNING)?);
    let (begin, begun) = mpsc::channel();
    let begun_work = move || {
        // The other end waits for it.
        let _ = begin.send(());
        work()
    };
    let thread = Builder::new().name(name.to_owned()).stack_size(STACK).spawn(begun_work)?;
    begun.recv().map_err(io::Error::other)?;
    Ok(thread)
}

/// Threads of a simulation for each processor, beyond which they only wait for each other.
const EACH: usize = 16;

/// Bounds of the largest number of threads: one that is allowed on every machine, and one that starts in
/// seconds.
const ALLOWED: usize = 64;
const STARTED: usize = 1024;

/// Largest number of threads of a simulation on this machine.
pub(crate) fn most() -> usize {
    most_on(std::thread::available_parallelism().map_or(1, NonZero::get))
}

fn most_on(processors: usize) -> usize {
    processors.saturating_mul(EACH).clamp(ALLOWED, STARTED)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_bounded_by_the_processors() {
        assert_eq!([1, 2, 8, 64, usize::MAX].map(most_on), [64, 64, 128, 1024, 1024]);
    }
}
