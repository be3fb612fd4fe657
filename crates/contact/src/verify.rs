//! Checks a couple list by brute force on a sample of elements, without using any engine.

use std::collections::BTreeSet;
use std::fmt;

use crate::couple::Couple;
use crate::elements::Elements;
use crate::real::Real;

/// An error in a couple list, with the first element affected.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mismatch {
    /// The elements touch, but the list lacks the couple.
    Missing(Couple),
    /// The list has the couple, but the elements do not touch.
    Extra(Couple),
    /// The list has the couple more than once.
    Repeated(Couple),
    /// The list has a couple with `i >= j`, or with an element that does not exist.
    Malformed(Couple),
}

impl fmt::Display for Mismatch {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(Couple { i, j }) => write!(out, "elements {i} and {j} touch but are not listed"),
            Self::Extra(Couple { i, j }) => write!(out, "elements {i} and {j} are listed but do not touch"),
            Self::Repeated(Couple { i, j }) => write!(out, "elements {i} and {j} are listed more than once"),
            Self::Malformed(Couple { i, j }) => {
                write!(out, "({i}, {j}) is not a couple of two elements, i < j")
            }
        }
    }
}

impl std::error::Error for Mismatch {}

/// Checks the couples of `sample` random elements against all others, by brute force.
///
/// Returns the number of elements checked: `sample`, or all of them if there are fewer. The same `seed` picks
/// the same elements. The order of `couples` does not matter.
///
/// # Cost
/// `sample * N` tests, and one pass over the couples.
///
/// # Errors
/// The first [`Mismatch`] found.
///
/// # Example
/// ```
/// use fdem_contact::{Couple, Elements, Mismatch, verify};
///
/// let centres = [[0.0], [1.0], [2.0]];
/// let elements = Elements::points(&centres, 1.0)?;
/// let couples = [Couple::new(0, 1), Couple::new(1, 2)];
/// assert_eq!(verify(&elements, &couples, 3, 0), Ok(3));
/// assert_eq!(verify(&elements, &couples[..1], 3, 0), Err(Mismatch::Missing(couples[1])));
/// # Ok::<(), fdem_contact::Error>(())
/// ```
pub fn verify<T: Real, const D: usize>(
    elements: &Elements<'_, T, D>,
    couples: &[Couple],
    sample: usize,
    seed: u64,
) -> Result<usize, Mismatch> {
    verify_with(elements.len(), couples, sample, seed, |i, j| elements.touch(i, j))
}

/// Verifies as [`verify`] does, for `n` elements with the contact test `touch`.
pub(crate) fn verify_with(
    n: usize,
    couples: &[Couple],
    sample: usize,
    seed: u64,
    touch: impl Fn(usize, usize) -> bool,
) -> Result<usize, Mismatch> {
    let picked = pick(n, sample, seed);

    // The listed partners of every picked element, in ascending order.
    let mut listed = Vec::new();
    for &couple in couples {
        if couple.i >= couple.j || couple.j as usize >= n {
            return Err(Mismatch::Malformed(couple));
        }
        for (element, partner) in [(couple.i, couple.j), (couple.j, couple.i)] {
            if picked.binary_search(&element).is_ok() {
                listed.push((element, partner));
            }
        }
    }
    listed.sort_unstable();
    if let Some(twice) = listed.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Mismatch::Repeated(Couple::new(twice[0].0, twice[0].1)));
    }

    let mut listed = listed.into_iter().peekable();
    for &element in &picked {
        for partner in (0..n as u32).filter(|&partner| partner != element) {
            let is_listed = listed.next_if_eq(&(element, partner)).is_some();
            let touches = touch(element as usize, partner as usize);
            match (touches, is_listed) {
                (true, false) => return Err(Mismatch::Missing(Couple::new(element, partner))),
                (false, true) => return Err(Mismatch::Extra(Couple::new(element, partner))),
                _ => {}
            }
        }
    }
    Ok(picked.len())
}

/// `sample` different numbers below `n`, ascending; all of them if `sample` is at least `n`.
pub(crate) fn pick(n: usize, sample: usize, seed: u64) -> Vec<u32> {
    if sample >= n {
        return (0..n as u32).collect();
    }
    // R. Floyd's sampling without replacement, J. Bentley, Commun. ACM 30 (1987) 754-757.
    let mut state = seed;
    let mut picked = BTreeSet::new();
    for last in n - sample..n {
        let candidate = ((u128::from(split_mix(&mut state)) * (last as u128 + 1)) >> 64) as u32;
        if !picked.insert(candidate) {
            picked.insert(last as u32);
        }
    }
    picked.into_iter().collect()
}

/// SplitMix64: G.L. Steele, D. Lea, C.H. Flood, OOPSLA 2014.
pub(crate) fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHAIN: [[f64; 1]; 4] = [[0.0], [1.0], [2.0], [3.0]];

    fn checked(couples: &[(u32, u32)], sample: usize) -> Result<usize, Mismatch> {
        let elements = Elements::points(&CHAIN, 1.0).unwrap();
        let couples: Vec<Couple> = couples.iter().map(|&(i, j)| Couple { i, j }).collect();
        verify(&elements, &couples, sample, 7)
    }

    #[test]
    fn every_kind_of_mistake_is_found() {
        let couple = |i, j| Couple { i, j };
        assert_eq!(checked(&[(2, 3), (0, 1), (1, 2)], 9), Ok(4));
        assert_eq!(checked(&[(0, 1), (2, 3)], 9), Err(Mismatch::Missing(couple(1, 2))));
        assert_eq!(checked(&[(0, 1), (1, 2), (2, 3), (0, 3)], 9), Err(Mismatch::Extra(couple(0, 3))));
        assert_eq!(checked(&[(0, 1), (1, 2), (2, 3), (1, 2)], 9), Err(Mismatch::Repeated(couple(1, 2))));
        assert_eq!(checked(&[(1, 0)], 9), Err(Mismatch::Malformed(couple(1, 0))));
        assert_eq!(checked(&[(0, 4)], 9), Err(Mismatch::Malformed(couple(0, 4))));
    }

    #[test]
    fn a_sample_is_of_the_size_asked_for_and_covers_everything_in_time() {
        let mut seen = BTreeSet::new();
        for seed in 0..200 {
            let picked = pick(50, 5, seed);
            assert_eq!(picked.len(), 5);
            assert!(picked.windows(2).all(|pair| pair[0] < pair[1]));
            seen.extend(picked);
        }
        assert_eq!(seen.len(), 50);
        assert_eq!(pick(3, 9, 1), [0, 1, 2]);
        assert_ne!(pick(1000, 5, 1), pick(1000, 5, 2));
    }
}
