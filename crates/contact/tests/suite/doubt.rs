//! Cases that coordinates of 32 bits cannot decide: the kernels estimate with them and must notice.

use fdem_contact::{Couple, Direct, Elements, Filter, Real, Rows, Search, Simd};
use fdem_scenes::{Sizes, gas, lattice};

use crate::ascending;

/// Every set of instructions finds the couples of all-against-all, in one order; returns the number of
/// couples.
fn every_level_is_exact<T: Real, const D: usize>(elements: &Elements<'_, T, D>) -> usize {
    let expected = ascending(Direct, elements);
    let mut order: Option<Vec<Couple>> = None;
    for simd in Simd::available() {
        let mut rows = Rows::new().with_simd(simd).unwrap();
        let mut couples = Vec::new();
        rows.couples(elements, &mut couples).unwrap();
        assert_eq!(order.get_or_insert_with(|| couples.clone()), &couples, "{simd}: the order");
        assert_eq!(rows.count(elements).unwrap(), expected.len() as u64, "{simd}");
        couples.sort_unstable();
        assert_eq!(couples, expected, "{simd}");
    }
    expected.len()
}

/// A gas in which every other element has a partner at the limit times `1 + delta`; `reach` gives the contact
/// distance.
fn nearly_touching<const D: usize>(
    n: usize,
    scale: f64,
    far: f64,
    delta: impl Fn(usize) -> f64,
    reach: impl Fn(usize) -> f64,
) -> Vec<[f64; D]> {
    let mut centres = gas::<D>(n, 5, 12.0, Sizes::Equal { radius: 0.5 }).unwrap().centres;
    for k in (1..n).step_by(2) {
        let steps: [f64; D] = std::array::from_fn(|axis| ((k * (7 + 4 * axis)) as f64).sin());
        let length = steps.iter().map(|x| x * x).sum::<f64>().sqrt();
        let distance = (reach(k - 1) + reach(k)) * (1.0 + delta(k)) / length;
        centres[k] = std::array::from_fn(|axis| centres[k - 1][axis] + distance * steps[axis]);
    }
    centres.iter().map(|centre| centre.map(|x| x * scale + far)).collect()
}

/// `10^-4` to `10^-16`, with either sign.
fn tiny(k: usize) -> f64 {
    let magnitude = 0.1_f64.powf((4 + k / 4 % 13) as f64);
    if (k / 2).is_multiple_of(2) { magnitude } else { -magnitude }
}

fn near_the_limit<const D: usize>() {
    const N: usize = 3000;
    for (scale, far) in [(1.0, 0.0), (1e-9, 0.0), (1e140, 0.0), (1.0, 1e6), (0.37, -1e9)] {
        let equal = nearly_touching::<D>(N, scale, far, tiny, |_| 0.5);
        let elements = Elements::points(&equal, scale).unwrap();
        let found = every_level_is_exact(&elements);
        assert!(found > 4 * N, "{found} couples");
        let bodies: Vec<u32> = (0..N as u32).map(|k| k % 3).collect();
        every_level_is_exact(&elements.with_filter(Filter::bodies(&bodies)).unwrap());

        let radius = |k: usize| 0.5 / (1 + k % 40) as f64;
        let unlike = nearly_touching::<D>(N, scale, far, tiny, radius);
        let radii: Vec<f64> = (0..N).map(|k| radius(k) * scale).collect();
        let elements = Elements::spheres_with_radii(&unlike, &radii).unwrap();
        every_level_is_exact(&elements);
        every_level_is_exact(&elements.with_tolerance(0.3 * scale).unwrap());
    }
}

fn near_the_limit_in_f32<const D: usize>() {
    for far in [0.0, 100.0, 1e5] {
        let centres = nearly_touching::<D>(2000, 1.0, far, tiny, |_| 0.5);
        let centres: Vec<[f32; D]> = centres.iter().map(|centre| centre.map(|x| x as f32)).collect();
        every_level_is_exact(&Elements::points(&centres, 1.0).unwrap());
        let radii: Vec<f32> = (0..2000).map(|k| 0.5 / (1 + k % 7) as f32).collect();
        every_level_is_exact(&Elements::spheres_with_radii(&centres, &radii).unwrap());
    }
}

#[test]
fn distances_beside_the_limit_2d() {
    near_the_limit::<2>();
    near_the_limit_in_f32::<2>();
}

#[test]
fn distances_beside_the_limit_3d() {
    near_the_limit::<3>();
    near_the_limit_in_f32::<3>();
}

/// Shows that the scenes above are useful: without the exact comparison these couples would be decided
/// wrongly.
#[test]
fn many_distances_are_nearer_to_the_limit_than_32_bits_tell() {
    let centres = nearly_touching::<3>(3000, 1.0, 0.0, tiny, |_| 0.5);
    let wrong = |k: &usize| {
        let squared = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let short = |x: [f64; 3]| x.map(|x| x as f32);
        let (a, b) = (short(centres[k - 1]), short(centres[*k]));
        let estimate = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
        (squared(centres[k - 1], centres[*k]) <= 1.0) != (estimate <= 1.0)
    };
    let wrong = (1..3000).step_by(2).filter(wrong).count();
    assert!(wrong > 100, "{wrong}");
}

/// All contacts of a lattice are in doubt, whichever neighbours count.
#[test]
fn lattices() {
    for spacing in [1.0, 0.5, 1.0 / 3.0] {
        let cloud = lattice::<3>(4096, spacing, 0.5).unwrap();
        let found = every_level_is_exact(&Elements::points(&cloud.centres, 1.0).unwrap());
        assert!(found > 10_000);
    }
    let cloud = lattice::<2>(4096, 0.25, 0.5).unwrap();
    every_level_is_exact(&Elements::points(&cloud.centres, 1.0).unwrap());
}

/// Windows of more vectors than are kept, and rows longer than are copied, next to short ones.
#[test]
fn crowds() {
    for crowd in [200, 1000, 3000] {
        let mut cloud = gas::<2>(2000, 9, 12.0, Sizes::Equal { radius: 0.5 }).unwrap();
        let middle = cloud.centres[0];
        let point = |k: usize| [0.3 * (k as f64).sin(), 0.3 * (k as f64 * 1.7).cos()];
        cloud.centres.extend((0..crowd).map(point).map(|[x, y]| [middle[0] + x, middle[1] + y]));
        let found = every_level_is_exact(&Elements::points(&cloud.centres, 1.0).unwrap());
        assert!(found > crowd * (crowd - 1) / 2);
    }
}
