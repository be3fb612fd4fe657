//! The memory of the last search, for the next one.
//!
//! Memory that comes from the system is filled with zeros, page by page, which takes half as long as a whole
//! search. No threads are kept: a process with idle ones cannot be forked without a warning.

use std::any::Any;
use std::sync::{Mutex, PoisonError};

static KEPT: Mutex<Option<Box<dyn Any + Send>>> = Mutex::new(None);

/// Memory beyond this goes back to the system. Some two million elements take as much.
pub(crate) const MAX_BYTES: usize = 1 << 27;

/// Takes the search that was kept, if it is of this type.
pub(crate) fn take<S: 'static>() -> Option<S> {
    let kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner).take()?;
    kept.downcast::<S>().ok().map(|search| *search)
}

/// Keeps `search`, which holds `bytes` bytes and has no threads.
pub(crate) fn keep<S: Send + 'static>(search: S, bytes: usize) {
    if bytes <= MAX_BYTES {
        *KEPT.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(search));
    }
}
