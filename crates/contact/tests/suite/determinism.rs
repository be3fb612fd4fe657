//! The couples and their order do not depend on threads or vector instructions, bit for bit.

use fdem_contact::{Couple, Elements, Rows, Search, Simd};
use fdem_scenes::{Cloud, Sizes, clusters, gas};

/// Couples in the order of the engine, from a list and a visitor; their number from a count.
fn found<const D: usize>(cloud: &Cloud<D>, with_radii: bool, simd: Simd, threads: usize) -> Vec<Couple> {
    let elements = if with_radii {
        Elements::spheres_with_radii(&cloud.centres, &cloud.radii)
    } else {
        Elements::points(&cloud.centres, 1.0)
    };
    let elements = elements.unwrap();
    let mut rows = Rows::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
    let (mut list, mut visited) = (Vec::new(), Vec::new());
    rows.couples(&elements, &mut list).unwrap();
    rows.for_each(&elements, |couple| visited.push(couple)).unwrap();
    assert!(list == visited, "a visitor sees the order of the list: {simd}, {threads} threads");
    assert_eq!(rows.count(&elements).unwrap(), list.len() as u64, "{simd}, {threads} threads");
    list
}

/// A sum of floats over all couples: its last bits depend on the order of the additions.
fn sum<const D: usize>(cloud: &Cloud<D>, threads: usize) -> f64 {
    let elements = Elements::spheres_with_radii(&cloud.centres, &cloud.radii).unwrap();
    let mut rows = Rows::new().with_threads(threads).unwrap();
    let add = |sum: &mut f64, couple: Couple| {
        let [a, b] = [couple.i, couple.j].map(|k| cloud.centres[k as usize][0]);
        *sum += (a - b) * (a + b);
    };
    rows.fold(&elements, || 0.0, add).unwrap().into_iter().sum()
}

fn is_the_same_for_all<const D: usize>(scene: &str, cloud: &Cloud<D>) {
    for with_radii in [false, true] {
        let expected = found(cloud, with_radii, Simd::Portable, 1);
        assert!(expected.len() > cloud.len() / 4, "{scene} has couples to lose");
        for simd in Simd::available() {
            assert!(found(cloud, with_radii, simd, 1) == expected, "{scene}: {simd}");
        }
        for threads in [2, 3, 8, 16] {
            assert_eq!(sum(cloud, threads).to_bits(), sum(cloud, 1).to_bits(), "{scene}: {threads} threads");
            assert!(
                found(cloud, with_radii, Simd::best(), threads) == expected,
                "{scene}: {threads} threads"
            );
        }
    }
}

const SIZES: Sizes = Sizes::Lognormal { median: 0.5, sigma: 0.2 };

#[test]
fn a_gas_in_3d() {
    is_the_same_for_all("gas in 3D", &gas::<3>(60_000, 1, 8.0, SIZES).unwrap());
}

#[test]
fn a_gas_in_2d() {
    is_the_same_for_all("gas in 2D", &gas::<2>(60_000, 2, 8.0, SIZES).unwrap());
}

/// One row with all elements, which the threads share.
#[test]
fn a_single_row() {
    let mut cloud = gas::<2>(60_000, 3, 8.0, SIZES).unwrap();
    cloud.centres.iter_mut().for_each(|centre| *centre = [centre[0] * 100.0, centre[1] * 1e-3]);
    is_the_same_for_all("a single row", &cloud);
}

/// More rows than elements: sorted in buckets.
#[test]
fn clusters_in_a_wide_domain() {
    is_the_same_for_all("clusters", &clusters::<3>(60_000, 4, 500, 1e6, 4.0, SIZES).unwrap());
}
