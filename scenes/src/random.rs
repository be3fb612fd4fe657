//! The seeded random number generator of all scenes.
//!
//! ChaCha8 is a published stream cipher with test vectors, so its bits never change. The conversions from
//! bits to numbers are written here, because the distributions of `rand` may change between releases.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Stream of a seed from which centres are drawn.
pub(crate) const CENTRES: u64 = 0;
/// Stream of a seed from which radii are drawn.
pub(crate) const RADII: u64 = 1;
/// Stream of a seed from which the places of clusters are drawn.
pub(crate) const CLUSTERS: u64 = 2;

/// 2⁻⁵³, the distance between neighbouring values of [`Random::uniform`].
const STEP: f64 = 1.0 / (1_u64 << 53) as f64;

/// Seeded random numbers, the same on every platform.
///
/// # Source
/// D. J. Bernstein, "`ChaCha`, a variant of Salsa20" (2008), with 8 rounds; the key is the seed in
/// little-endian bytes followed by 24 zeros, the nonce is the stream.
///
/// # Example
/// ```
/// use fdem_scenes::random::Random;
///
/// let mut random = Random::new(7);
/// let x = random.uniform();
/// assert!((0.0..1.0).contains(&x));
/// assert_eq!(x, Random::new(7).uniform());
/// ```
#[derive(Debug, Clone)]
pub struct Random {
    source: ChaCha8Rng,
    /// The second of the latest pair of normal numbers, if it has not been used.
    spare: Option<f64>,
}

impl Random {
    /// The first stream of `seed`.
    pub fn new(seed: u64) -> Self {
        Self::with_stream(seed, 0)
    }

    /// One of the 2⁶⁴ independent streams of `seed`.
    pub fn with_stream(seed: u64, stream: u64) -> Self {
        let mut key = [0; 32];
        key[..8].copy_from_slice(&seed.to_le_bytes());
        let mut source = ChaCha8Rng::from_seed(key);
        source.set_stream(stream);
        Self { source, spare: None }
    }

    /// The next 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.source.next_u64()
    }

    /// A number drawn uniformly from the multiples of 2⁻⁵³ in `[0, 1)`.
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * STEP
    }

    /// `low + (high - low) u` with `u` from [`uniform`](Self::uniform); rounding may return `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// An integer drawn uniformly from `0..n`; zero if `n` is zero.
    ///
    /// # Source
    /// D. Lemire, "Fast random integer generation in an interval", ACM Trans. Model. Comput. Simul. 29
    /// (2019).
    pub fn below(&mut self, n: u64) -> u64 {
        if n == 0 {
            return 0;
        }
        // The 2^64 mod n lowest fractions would favour some results, so they are drawn again.
        let surplus = n.wrapping_neg() % n;
        loop {
            let product = u128::from(self.bits()) * u128::from(n);
            if product as u64 >= surplus {
                return (product >> 64) as u64;
            }
        }
    }

    /// A number from the normal distribution with mean 0 and standard deviation 1.
    ///
    /// # Source
    /// G. Marsaglia, T. A. Bray, "A convenient method for generating normal variables", SIAM Review 6 (1964):
    /// the polar method, which needs a logarithm and a square root but no sine.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let x = 2.0 * self.uniform() - 1.0;
            let y = 2.0 * self.uniform() - 1.0;
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                let factor = (-2.0 * libm::log(square) / square).sqrt();
                self.spare = Some(y * factor);
                return x * factor;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First bytes of the `ChaCha8` test vector for a zero key and a zero nonce
    /// (draft-strombergson-chacha-test-vectors, TC1): 3e00ef2f895f40d6 7f5bb8e81f09a5a1.
    #[test]
    fn bits_are_those_of_the_published_cipher() {
        let mut random = Random::new(0);
        assert_eq!(random.bits(), u64::from_le_bytes([0x3e, 0x00, 0xef, 0x2f, 0x89, 0x5f, 0x40, 0xd6]));
        assert_eq!(random.bits(), u64::from_le_bytes([0x7f, 0x5b, 0xb8, 0xe8, 0x1f, 0x09, 0xa5, 0xa1]));
    }

    #[test]
    fn seeds_and_streams_differ() {
        let first = Random::new(1).bits();
        assert_ne!(first, Random::new(2).bits());
        assert_ne!(first, Random::with_stream(1, 1).bits());
        assert_eq!(first, Random::with_stream(1, 0).bits());
    }

    #[test]
    fn uniform_fills_the_unit_interval() {
        let n = 100_000;
        let mut random = Random::new(3);
        let mut tenths = [0_u32; 10];
        for _ in 0..n {
            let u = random.uniform();
            assert!((0.0..1.0).contains(&u));
            tenths[(u * 10.0) as usize] += 1;
        }
        // Five standard deviations of a binomial count, sqrt(n/10 * 9/10) = 95.
        assert!(tenths.iter().all(|&count| count.abs_diff(n / 10) < 475), "{tenths:?}");
    }

    #[test]
    fn between_stays_between() {
        let mut random = Random::new(4);
        let drawn: Vec<f64> = (0..1_000).map(|_| random.between(-3.0, 5.0)).collect();
        assert!(drawn.iter().all(|x| (-3.0..=5.0).contains(x)));
        assert!(drawn.iter().any(|&x| x < -2.5) && drawn.iter().any(|&x| x > 4.5));
    }

    #[test]
    fn below_is_even_and_in_range() {
        let mut random = Random::new(5);
        let mut counts = [0_u32; 3];
        for _ in 0..30_000 {
            counts[random.below(3) as usize] += 1;
        }
        assert!(counts.iter().all(|count| count.abs_diff(10_000) < 410), "{counts:?}");
        assert_eq!((random.below(0), random.below(1)), (0, 0));
        // With three quarters of the 64-bit range, multiples of 3 would occur twice as often without the
        // second draw.
        let multiples = (0..9_000).filter(|_| random.below(3 << 62).is_multiple_of(3)).count();
        assert!(multiples.abs_diff(3_000) < 225, "{multiples}");
    }

    #[test]
    fn normal_has_the_moments_of_the_normal_distribution() {
        let n = 200_000;
        let mut random = Random::new(6);
        let drawn: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let moment = |k: i32| drawn.iter().map(|x| x.powi(k)).sum::<f64>() / f64::from(n);
        // Five standard errors each: sqrt(1/n), sqrt(2/n), sqrt(15/n), sqrt(96/n).
        assert!(moment(1).abs() < 0.0112, "{}", moment(1));
        assert!((moment(2) - 1.0).abs() < 0.0159, "{}", moment(2));
        assert!(moment(3).abs() < 0.0434, "{}", moment(3));
        assert!((moment(4) - 3.0).abs() < 0.110, "{}", moment(4));
        // The two numbers of a pair are independent: the mean product of neighbours is zero.
        let product = drawn.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / f64::from(n);
        assert!(product.abs() < 0.0112, "{product}");
    }
}
