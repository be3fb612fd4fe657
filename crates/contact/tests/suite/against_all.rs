//! Shared parts of the tests of the index: positions of elements, searches, and the distance that decides.

use fdem_contact::{Index, Real, Simd};
use fdem_scenes::{Cloud, Sizes, clusters, gas, lattice};
use proptest::prelude::*;

pub(crate) const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

/// Positions that are difficult in different ways.
pub(crate) struct Scenes<const D: usize> {
    pub(crate) gas: Cloud<D>,
    /// A lattice with many ties; neighbours touch exactly.
    pub(crate) lattice: Cloud<D>,
    pub(crate) clusters: Cloud<D>,
    /// A gas with two elements far away on either side.
    pub(crate) outliers: Cloud<D>,
    pub(crate) one_place: Cloud<D>,
    pub(crate) nothing: Cloud<D>,
}

impl<const D: usize> Scenes<D> {
    pub(crate) fn new() -> Self {
        let gas = gas::<D>(400, 1, 8.0, EQUAL).unwrap();
        let mut outliers = gas.clone();
        (outliers.centres[3], outliers.centres[4]) = ([-1e7; D], [1e7; D]);
        Self {
            gas,
            lattice: lattice(200, 1.0, 0.5).unwrap(),
            clusters: clusters(300, 5, 30, 1000.0, 6.0, EQUAL).unwrap(),
            outliers,
            one_place: Cloud { centres: vec![[0.25; D]; 50], radii: vec![0.5; 50] },
            nothing: Cloud { centres: Vec::new(), radii: Vec::new() },
        }
    }
}

/// An index for every level of vector instructions on one thread, and for the best one on two and three.
pub(crate) fn indices<T: Real, const D: usize>() -> Vec<(Simd, usize, Index<T, D>)> {
    let levels = Simd::available().into_iter().map(|simd| (simd, 1));
    let all = levels.chain([(Simd::best(), 2), (Simd::best(), 3)]);
    all.map(|(simd, threads)| {
        (simd, threads, Index::new().with_simd(simd).unwrap().with_threads(threads).unwrap())
    })
    .collect()
}

/// The sum that the documentation of `Elements` gives, with its order of operations.
pub(crate) fn squared<T: Real, const D: usize>(a: &[T; D], b: &[T; D]) -> T {
    let mut sum = T::ZERO;
    for axis in 0..D {
        let difference = a[axis] - b[axis];
        sum = sum + difference * difference;
    }
    sum
}

/// Multiples of one half, among which ties are common; numbers whose differences are exact; arbitrary floats;
/// powers of two.
pub(crate) fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-12..12_i32).prop_map(|k| f64::from(k) / 2.0),
        (-8 * 1024..8 * 1024_i32).prop_map(|k| f64::from(k) / 1024.0),
        any::<f32>().prop_map(|x| if x.is_finite() { f64::from(x) } else { 0.0 }),
        (-500..490_i32).prop_map(|exponent| 2.0_f64.powi(exponent)),
    ]
}

/// Makes a test of `$all::<float, dimensions>` for each float type and dimension.
macro_rules! in_all_dimensions {
    ($all:ident) => {
        $crate::against_all::in_all_dimensions! {
            $all:
            f64_1d: f64, 1; f64_2d: f64, 2; f64_3d: f64, 3; f64_4d: f64, 4;
            f32_2d: f32, 2; f32_3d: f32, 3;
        }
    };
    ($all:ident: $($name:ident: $type:ty, $dimensions:literal;)*) => {
        $(
            #[test]
            fn $name() {
                $all::<$type, $dimensions>();
            }
        )*
    };
}

pub(crate) use in_all_dimensions;
