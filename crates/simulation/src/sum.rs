//! Sums that do not depend on the order of their numbers.
//!
//! The energies of a run are sums over all its elements, nodes, joints and couples. Rounded one by one they
//! would depend on their order, and therefore on other contents of a run: couples that do not touch, or parts
//! on other ranks. A [`Sum`] is exact. It is rounded once, when it is read.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Number of limbs: all finite numbers, and 2^31 times as much.
pub(crate) const LIMBS: usize = 67;

/// Number of additions until limbs must be carried: each adds less than 2^32 to a limb.
const MOST: u32 = 1 << 30;

/// The exact sum of any finite numbers: a fixed-point number, in limbs of 32 bits that are carried later (U.
/// W. Kulisch and W. L. Miranker, *Computer Arithmetic in Theory and Practice*, Academic Press, 1981; R. M.
/// Neal, arXiv:1505.05571).
#[derive(Clone)]
pub(crate) struct Sum {
    /// Limb `k` counts 2^(32 k - 1074).
    limbs: [i64; LIMBS],
    /// Additions since limbs were carried.
    added: u32,
    /// Number of numbers that were infinite or none.
    unfit: i64,
}

impl Default for Sum {
    fn default() -> Self {
        Self { limbs: [0; LIMBS], added: 0, unfit: 0 }
    }
}

impl From<f64> for Sum {
    fn from(value: f64) -> Self {
        let mut sum = Self::default();
        sum.add(value);
        sum
    }
}

impl FromIterator<f64> for Sum {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut sum = Self::default();
        values.into_iter().for_each(|value| sum.add(value));
        sum
    }
}

impl Sum {
    /// Adds a number.
    #[inline]
    pub(crate) fn add(&mut self, value: f64) {
        if value == 0.0 {
            return;
        }
        let bits = value.to_bits();
        let (exponent, fraction) = ((bits >> 52 & 0x7ff) as usize, bits & ((1 << 52) - 1));
        if exponent == 0x7ff {
            self.unfit += 1;
            return;
        }
        let (place, mantissa) =
            if exponent == 0 { (0, fraction) } else { (exponent - 1, fraction | 1 << 52) };
        let wide = u128::from(mantissa) << (place % 32);
        let limbs = &mut self.limbs[place / 32..place / 32 + 3];
        let sign = if value < 0.0 { -1 } else { 1 };
        for (k, limb) in limbs.iter_mut().enumerate() {
            *limb += sign * i64::from((wide >> (32 * k)) as u32);
        }
        self.added += 1;
        if self.added == MOST {
            self.carry();
        }
    }

    /// Adds up lists of sums, place by place.
    pub(crate) fn all<const K: usize>(lists: impl IntoIterator<Item = [Self; K]>) -> [Self; K] {
        let mut all = std::array::from_fn(|_| Self::default());
        for list in lists {
            for (sum, more) in all.iter_mut().zip(&list) {
                sum.add_sum(more);
            }
        }
        all
    }

    /// Adds the numbers of a pile.
    pub(crate) fn add_pile(&mut self, pile: Pile) {
        pile.0.into_iter().for_each(|part| self.add(part));
    }

    /// Adds the numbers of another sum.
    pub(crate) fn add_sum(&mut self, other: &Self) {
        self.carry();
        let mut other = other.clone();
        other.carry();
        for (limb, more) in self.limbs.iter_mut().zip(other.limbs) {
            *limb += more;
        }
        self.added = 2;
        self.unfit += other.unfit;
    }

    /// Takes the numbers of another sum away.
    pub(crate) fn subtract(&mut self, other: &Self) {
        let mut other = other.clone();
        other.limbs.iter_mut().for_each(|limb| *limb = -*limb);
        self.add_sum(&other);
    }

    /// Carries the parts of limbs beyond 32 bits. Afterwards all are in 0 to 2^32 - 1 but the last, which has
    /// the sign: equal sums have equal limbs.
    fn carry(&mut self) {
        let mut more = 0;
        let [limbs @ .., last] = &mut self.limbs;
        for limb in limbs {
            let sum = *limb + more;
            *limb = sum & 0xffff_ffff;
            more = sum >> 32;
        }
        *last += more;
        self.added = 1;
    }

    /// The sum, rounded to the nearest number; no number if one of its numbers was infinite or none.
    pub(crate) fn value(&self) -> f64 {
        if self.unfit > 0 {
            return f64::NAN;
        }
        let mut magnitude = self.clone();
        magnitude.carry();
        let negative = magnitude.limbs[LIMBS - 1] < 0;
        if negative {
            magnitude.limbs.iter_mut().for_each(|limb| *limb = -*limb);
            magnitude.carry();
        }
        let limbs = &magnitude.limbs;
        let Some(top) = limbs.iter().rposition(|&limb| limb != 0) else { return 0.0 };
        // Three limbs and a bit for all below are enough to round once; only the last limb may have more than
        // 32 bits.
        let first = top.saturating_sub(3);
        let mut wide =
            limbs[first..=top].iter().rev().fold(0_u128, |wide, &limb| (wide << 32) | limb as u128);
        if limbs[..first].iter().any(|&limb| limb != 0) {
            wide |= 1;
        }
        let place = i32::try_from(32 * first).unwrap_or_default();
        let value = libm::ldexp(wide as f64, place - 1074);
        if negative { -value } else { value }
    }

    /// Numbers that represent the sum: the numbers of two sums, added one by one, represent the sum of both.
    pub(crate) fn parts(&self) -> [i64; LIMBS + 1] {
        let mut carried = self.clone();
        carried.carry();
        std::array::from_fn(|k| carried.limbs.get(k).copied().unwrap_or(carried.unfit))
    }

    /// The sum with these [`parts`](Self::parts).
    pub(crate) fn of_parts(parts: &[i64]) -> Self {
        let mut sum = Self::default();
        for (limb, part) in sum.limbs.iter_mut().zip(parts) {
            *limb = *part;
        }
        sum.unfit = parts.get(LIMBS).copied().unwrap_or_default();
        sum.carry();
        sum
    }
}

/// Rounds numbers of about one size to grains, so that plain additions of them are exact: the two parts of
/// each number are multiples of the two grains, and so are their sums (J. Demmel and H. D. Nguyen, *Parallel
/// Reproducible Summation*, IEEE Trans. Comput. 64 (2015) 2060-2070). Parts smaller than the small grain are
/// dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grains {
    /// 1.5 × 2^52 times the large and the small grain: a number added to these is rounded to a grain.
    large: f64,
    small: f64,
}

impl Grains {
    /// Grains for numbers up to a hundred times `size`, with 88 bits below it. Plain sums of 512 parts are
    /// exact up to that size.
    pub(crate) fn of(size: f64) -> Self {
        let exponent = if size > 0.0 && size.is_finite() { libm::ilogb(size) } else { 0 };
        let grain = |below: i32| 1.5 * libm::ldexp(1.0, (exponent - below).max(-1000) + 52);
        Self { large: grain(44), small: grain(88) }
    }

    /// The numbers that are added to a number and taken away again, to round it to the large grain, and the
    /// rest to the small one.
    pub(crate) fn shifts(self) -> [f64; 2] {
        [self.large, self.small]
    }

    /// The two parts of a number.
    #[inline(always)]
    pub(crate) fn parts(self, number: f64) -> [f64; 2] {
        let large = (number + self.large) - self.large;
        [large, ((number - large) + self.small) - self.small]
    }
}

/// A plain sum of a chunk of numbers, in the parts of [`Grains`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pile([f64; 2]);

impl Pile {
    /// The pile of two sums of parts.
    pub(crate) fn of(parts: [f64; 2]) -> Self {
        Self(parts)
    }

    /// Adds the numbers of another pile of the same chunk.
    pub(crate) fn add_pile(&mut self, other: Self) {
        self.0[0] += other.0[0];
        self.0[1] += other.0[1];
    }

    /// Adds a number.
    #[inline(always)]
    pub(crate) fn add(&mut self, number: f64, grains: Grains) {
        let [large, small] = grains.parts(number);
        self.0[0] += large;
        self.0[1] += small;
    }
}

impl fmt::Debug for Sum {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{:e}", self.value())
    }
}

impl PartialEq for Sum {
    fn eq(&self, other: &Self) -> bool {
        self.parts() == other.parts()
    }
}

impl Serialize for Sum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let parts = self.parts();
        let first = parts.iter().position(|&part| part != 0).unwrap_or(parts.len());
        (first as u32, &parts[first..]).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Sum {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (first, some): (u32, Vec<i64>) = Deserialize::deserialize(deserializer)?;
        if (first as usize).saturating_add(some.len()) != LIMBS + 1 {
            return Err(serde::de::Error::custom("a sum has another number of parts"));
        }
        let parts = [vec![0; first as usize], some].concat();
        Ok(Self::of_parts(&parts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    /// Numbers of all sizes and both signs.
    fn numbers(count: u64) -> Vec<f64> {
        let number = |k: u64| {
            let [sign, exponent, mantissa] = [0, 1, 2].map(|way| random::uniform(way, k));
            (sign - 0.5).signum() * (1.0 + mantissa) * libm::exp2(60.0 * (exponent - 0.5))
        };
        (0..count).map(number).collect()
    }

    #[test]
    fn the_order_changes_nothing() {
        let numbers = numbers(10_000);
        let forth: Sum = numbers.iter().copied().collect();
        let back: Sum = numbers.iter().rev().copied().collect();
        assert_eq!(forth, back);
        let mut parts = Sum::default();
        for part in numbers.chunks(777).rev() {
            parts.add_sum(&part.iter().copied().collect());
        }
        assert_eq!(parts, forth);
        let mut limbs = [0; LIMBS + 1];
        for part in numbers.chunks(777) {
            let part: Sum = part.iter().copied().collect();
            limbs.iter_mut().zip(part.parts()).for_each(|(sum, part)| *sum += part);
        }
        assert_eq!(Sum::of_parts(&limbs), forth);
        assert!(numbers.iter().sum::<f64>() != forth.value(), "numbers of all sizes are rounded one by one");
    }

    /// Plain sums of parts do not depend on the order either.
    #[test]
    fn grains_add_up_in_any_order() {
        let numbers: Vec<f64> = numbers(500).into_iter().map(|number| 1e-9 * number).collect();
        let grains = Grains::of(10.0);
        let sum = |numbers: &mut dyn Iterator<Item = &f64>| {
            numbers.fold([0.0; 2], |sum, &number| {
                let parts = grains.parts(number);
                [sum[0] + parts[0], sum[1] + parts[1]]
            })
        };
        let [forth, back] = [sum(&mut numbers.iter()), sum(&mut numbers.iter().rev())];
        assert_eq!(forth, back);
        let exact: Sum = numbers.iter().copied().collect();
        let rounded: Sum = forth.into_iter().collect();
        assert!((rounded.value() - exact.value()).abs() <= 500.0 * 10.0 * libm::exp2(-88.0));
        for size in [0.0, f64::NAN, 1e-320, 1e300] {
            let [large, small] = Grains::of(size).parts(0.0);
            assert_eq!([large, small], [0.0; 2], "{size}");
        }
    }

    #[test]
    fn a_sum_is_rounded_once_to_the_nearest() {
        let of = |numbers: &[f64]| numbers.iter().copied().collect::<Sum>().value();
        assert_eq!(of(&[]), 0.0);
        assert_eq!(of(&[1e300, 1.0, -1e300]), 1.0);
        assert_eq!(of(&[-1e300, -1.0, 1e300]), -1.0);
        assert_eq!(of(&[1.0, f64::EPSILON / 2.0]), 1.0);
        assert_eq!(of(&[1.0, f64::EPSILON / 2.0, 1e-300]), 1.0 + f64::EPSILON);
        assert_eq!(of(&[-1.0, -f64::EPSILON / 2.0, -1e-300]), -1.0 - f64::EPSILON);
        for number in [5e-324, f64::MIN_POSITIVE, f64::MAX, -f64::MAX, -0.1, 3.0e-310] {
            assert_eq!(of(&[number]), number);
        }
        assert_eq!(of(&[f64::MAX, f64::MAX]), f64::INFINITY);
        assert!(of(&[1.0, f64::NAN]).is_nan());
        assert!(of(&[1.0, f64::INFINITY]).is_nan());
        let mut sum = Sum::from(0.1);
        sum.subtract(&Sum::from(0.3));
        assert_eq!(sum.value(), 0.1 - 0.3 + (0.1 - (0.1 - 0.3) - 0.3));
    }

    #[test]
    fn a_saved_sum_goes_on() {
        let mut whole = Sum::default();
        for (k, &number) in numbers(300).iter().enumerate() {
            whole.add(number);
            if k % 100 == 0 {
                let bytes = postcard::to_allocvec(&whole).expect("bytes");
                let read: Sum = postcard::from_bytes(&bytes).expect("a sum");
                assert_eq!(read, whole);
                whole = read;
            }
        }
        let bytes = postcard::to_allocvec(&(3_u32, vec![1_i64; 4])).expect("bytes");
        assert!(postcard::from_bytes::<Sum>(&bytes).is_err());
    }
}
