//! Lists of numbers.

/// Sorts a list, and leaves each value in it once.
pub(crate) fn once_each<T: Ord>(list: &mut Vec<T>) {
    list.sort_unstable();
    list.dedup();
}
