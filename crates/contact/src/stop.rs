//! The flag by which a caller ends a search.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::Error;

/// A flag that the caller may set from any thread; none by default.
#[derive(Clone, Debug, Default)]
pub(crate) struct Stop(Option<Arc<AtomicBool>>);

impl Stop {
    pub(crate) fn new(flag: Arc<AtomicBool>) -> Self {
        Self(Some(flag))
    }

    /// Whether there is a flag.
    pub(crate) fn is_possible(&self) -> bool {
        self.0.is_some()
    }

    /// Returns [`Error::Stopped`] once the flag is set. Engines call it before each part of a search.
    #[inline]
    pub(crate) fn go_on(&self) -> Result<(), Error> {
        match &self.0 {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Error::Stopped),
            _ => Ok(()),
        }
    }
}
