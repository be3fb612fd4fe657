//! Arrays of 16-bit numbers, many of which are positions between two limits, and words of eight bytes.

use crate::fields::field::SCALES;
use crate::fields::range::{Scale, quantile};

/// Code of a value that is not finite, or is beyond the limits.
const NONE: u16 = u16::MAX;
const STEPS: f64 = 65_534.0;

/// Arrays of 16-bit numbers. Each array has all upper bytes first, because they differ little and are easy to
/// compress, then all lower bytes.
#[derive(Default)]
pub(crate) struct Packed {
    pub(crate) bytes: Vec<u8>,
}

impl Packed {
    /// Appends an array.
    pub(crate) fn numbers(&mut self, numbers: &[u16]) {
        self.bytes.extend(numbers.iter().map(|number| (number >> 8) as u8));
        self.bytes.extend(numbers.iter().map(|number| (number & 255) as u8));
    }

    /// Appends 32-bit numbers: the array of their upper halves, then that of their lower halves.
    pub(crate) fn halves(&mut self, numbers: &[u32]) {
        let upper: Vec<u16> = numbers.iter().map(|number| (number >> 16) as u16).collect();
        self.numbers(&upper);
        self.numbers(&low_halves(numbers));
    }

    /// Appends an array of positions between `low` and `high`.
    pub(crate) fn places(&mut self, values: &[f64], [low, high]: [f64; 2]) {
        let place = |&value: &f64| {
            if value.is_finite() && (low..=high).contains(&value) {
                // If the limits are equal, all values are at the start.
                let share = if high > low { (value - low) / (high - low) } else { 0.0 };
                (share * STEPS).round() as u16
            } else {
                NONE
            }
        };
        let numbers: Vec<u16> = values.iter().map(place).collect();
        self.numbers(&numbers);
    }
}

/// Returns the lower 16 bits of numbers.
pub(crate) fn low_halves(numbers: &[u32]) -> Vec<u16> {
    numbers.iter().map(|number| (number & 0xffff) as u16).collect()
}

/// Reader of arrays in the order in which they were packed.
pub(crate) struct Unpacked<'a> {
    bytes: &'a [u8],
}

impl<'a> Unpacked<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes }
    }

    /// Reads the next array; `None` if there are too few bytes.
    pub(crate) fn numbers(&mut self, count: usize) -> Option<Vec<u16>> {
        let (array, rest) = self.bytes.split_at_checked(count.checked_mul(2)?)?;
        self.bytes = rest;
        let (upper, lower) = array.split_at(count);
        Some(upper.iter().zip(lower).map(|(&upper, &lower)| u16::from_be_bytes([upper, lower])).collect())
    }

    /// Reads the next two arrays as the halves of 32-bit numbers.
    pub(crate) fn halves(&mut self, count: usize) -> Option<Vec<u32>> {
        let (upper, lower) = (self.numbers(count)?, self.numbers(count)?);
        Some(
            upper
                .iter()
                .zip(&lower)
                .map(|(&upper, &lower)| u32::from(upper) << 16 | u32::from(lower))
                .collect(),
        )
    }

    /// Reads the next array of positions between `low` and `high`. Values that were not finite or beyond the
    /// limits are NaN.
    pub(crate) fn places(&mut self, count: usize, [low, high]: [f64; 2]) -> Option<Vec<f64>> {
        let value = |place: u16| match place {
            NONE => f64::NAN,
            place => low + f64::from(place) / STEPS * (high - low),
        };
        Some(self.numbers(count)?.into_iter().map(value).collect())
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
}

/// Returns the least and the greatest coordinate of the elements that are drawn.
pub(crate) fn bounds(coordinates: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut finite: Vec<f64> = coordinates.filter(|x| x.is_finite()).collect();
    let Some(last) = finite.len().checked_sub(1) else { return [0.0; 2] };
    let [low, high] = [quantile(&mut finite, last / 100), quantile(&mut finite, last - last / 100)];
    let reach = if high > low { 4.0 * (high - low) } else { f64::INFINITY };
    let near = finite.iter().filter(|&&x| x >= low - reach && x <= high + reach);
    near.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}

/// Reader of numbers of eight bytes each.
pub(crate) struct Words<'a> {
    pub(crate) bytes: &'a [u8],
}

impl Words<'_> {
    pub(crate) fn u64(&mut self) -> Option<u64> {
        let (word, rest) = self.bytes.split_first_chunk()?;
        self.bytes = rest;
        Some(u64::from_le_bytes(*word))
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.u64().map(f64::from_bits)
    }

    pub(crate) fn pair(&mut self) -> Option<[f64; 2]> {
        Some([self.f64()?, self.f64()?])
    }

    pub(crate) fn scales(&mut self) -> Option<[Scale; SCALES.len()]> {
        let mut scales = [Scale { ends: [0.0; 2], usual: [0.0; 2] }; SCALES.len()];
        for scale in &mut scales {
            *scale = Scale { ends: self.pair()?, usual: self.pair()? };
        }
        Some(scales)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_come_back_within_half_a_step() {
        let values = [-3.0, 5.0, 0.1, f64::NAN, 7.0, f64::INFINITY];
        let mut packed = Packed::default();
        packed.places(&values, [-3.0, 5.0]);
        packed.numbers(&[513]);
        packed.places(&[2.5], [2.5, 2.5]);
        assert_eq!(packed.bytes[12..14], [2, 1], "upper bytes first");
        let mut unpacked = Unpacked::new(&packed.bytes);
        let back = unpacked.places(6, [-3.0, 5.0]).unwrap();
        assert_eq!(back[..2], [-3.0, 5.0]);
        assert!((back[2] - 0.1).abs() <= 4.0 / STEPS);
        assert!(back[3..].iter().all(|x| x.is_nan()), "values beyond the limits are NaN");
        assert_eq!(unpacked.numbers(1), Some(vec![513]));
        assert_eq!(unpacked.places(1, [2.5, 2.5]), Some(vec![2.5]));
        assert!(
            unpacked.is_empty() && unpacked.numbers(1).is_none() && unpacked.numbers(usize::MAX).is_none()
        );
    }
}
