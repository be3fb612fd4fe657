//! Sums that a device returns.

/// The number of parts of a [`DeviceSum`].
pub const SUM_PARTS: usize = crate::sum::LIMBS + 1;

/// The exact sum of some finite numbers. Part `k` counts 2^(32 k - 1074), the last one numbers that are
/// infinite or none. A number adds less than 2^32 to each of three parts, with its sign; sums are added part
/// by part, in any order. At most 2^30 numbers.
pub type DeviceSum = [i64; SUM_PARTS];
