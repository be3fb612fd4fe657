//! Vectors that grow without spare capacity, and report a lack of memory as an error.

mod pages;

use crate::error::Error;

/// Resizes to `len` entries without spare capacity; existing entries keep their value.
pub(crate) fn resize<V: Clone>(values: &mut Vec<V>, len: usize, value: V) -> Result<(), Error> {
    reserve(values, len.saturating_sub(values.len()))?;
    values.resize(len, value);
    Ok(())
}

/// Reserves room for exactly `more` entries.
pub(crate) fn reserve<V>(values: &mut Vec<V>, more: usize) -> Result<(), Error> {
    let bytes = (values.len() + more).saturating_mul(size_of::<V>());
    let before = values.capacity();
    values.try_reserve_exact(more).map_err(|_| Error::OutOfMemory { bytes })?;
    if values.capacity() != before {
        pages::make_huge(values);
    }
    Ok(())
}

/// Reserves room for `more` entries; the capacity grows by a factor.
pub(crate) fn grow<V>(values: &mut Vec<V>, more: usize) -> Result<(), Error> {
    if values.capacity() - values.len() >= more {
        return Ok(());
    }
    // If there is no memory for spare capacity, there may be for the entries.
    reserve(values, more.max(values.len())).or_else(|_| reserve(values, more))
}
