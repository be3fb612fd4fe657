//! Small arrays, filled in loops.

/// The array with the value `f(k)` at each place `k`.
///
/// Like [`std::array::from_fn`], for code that runs for every couple or pixel: a crate that is compiled in
/// several units calls parts of the latter, where this is a loop that is unrolled.
#[inline]
pub(crate) fn each<T: Copy, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    const { assert!(N > 0, "the first value fills the array") };
    let mut values = [f(0); N];
    for (k, value) in values.iter_mut().enumerate().skip(1) {
        *value = f(k);
    }
    values
}

#[cfg(test)]
mod tests {
    #[test]
    fn each_place_has_its_value() {
        assert_eq!(super::each(|k| 2 * k), [0, 2, 4, 6]);
    }
}
