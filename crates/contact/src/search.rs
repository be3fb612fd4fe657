//! The trait of a search: elements in, couples out.

pub(crate) mod level;
pub(crate) mod direct;
pub(crate) mod nbs;
pub(crate) mod multilevel;
pub(crate) mod cgrid;
pub(crate) mod rows;

use crate::couple::Couple;
use crate::elements::Elements;
use crate::error::Error;
use crate::memory::reserve;
use crate::real::Real;

/// A search that finds every couple of touching elements, each once.
///
/// All implementations return the same set of couples for the same elements. Each has its own order, which is
/// a function of the input alone. A search owns its working memory and reuses it from call to call.
///
/// # Example
/// ```
/// use fdem_contact::{Couple, Elements, Nbs, Search};
///
/// let centres = [[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]];
/// let elements = Elements::points(&centres, 1.0)?;
/// let mut nbs = Nbs::new();
///
/// nbs.for_each(&elements, |couple| println!("{} touches {}", couple.i, couple.j))?;
/// assert_eq!(nbs.count(&elements)?, 1);
///
/// let mut couples = Vec::new();
/// nbs.couples(&elements, &mut couples)?;
/// assert_eq!(couples, [Couple::new(0, 1)]);
/// # Ok::<(), fdem_contact::Error>(())
/// ```
pub trait Search<T: Real, const D: usize> {
    /// Calls `visit` with every couple that touches, without storing couples.
    ///
    /// # Errors
    /// An error if the engine cannot hold the elements: [`Error::TooManyElements`], [`Error::DomainTooWide`],
    /// [`Error::OutOfMemory`]. `visit` has not been called then.
    fn for_each(&mut self, elements: &Elements<'_, T, D>, visit: impl FnMut(Couple)) -> Result<(), Error>;

    /// Writes the couples into `couples` in the order of the engine. `couples` is cleared first, and its
    /// memory is reused.
    ///
    /// # Errors
    /// The errors of [`Search::for_each`], and [`Error::OutOfMemory`] if the couples themselves do not fit.
    /// `couples` is empty after an error.
    fn couples(&mut self, elements: &Elements<'_, T, D>, couples: &mut Vec<Couple>) -> Result<(), Error> {
        couples.clear();
        let mut room = Ok(());
        let all = self.for_each(elements, |couple| {
            if couples.len() == couples.capacity() && room.is_ok() {
                room = make_room(couples);
            }
            if room.is_ok() {
                couples.push(couple);
            }
        });
        all.and(room).inspect_err(|_| couples.clear())
    }

    /// The number of couples, without storing them.
    ///
    /// # Errors
    /// As [`Search::for_each`].
    fn count(&mut self, elements: &Elements<'_, T, D>) -> Result<u64, Error> {
        let mut count = 0;
        self.for_each(elements, |_| count += 1)?;
        Ok(count)
    }
}

/// Doubles the capacity, or returns an error if there is no memory for it.
pub(crate) fn make_room<V>(couples: &mut Vec<V>) -> Result<(), Error> {
    reserve(couples, couples.capacity().max(1024))
}
