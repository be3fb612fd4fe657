//! The kernels on the processor: the couples of `Rows`, in its order, whatever the order of threads.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use bytemuck::Pod;
use fdem_contact::{Couple, Csr, Elements, Filter, GroupMatrix, Real, Rows, Search};
use fdem_gpu::kernels::{Kernel, source};
use fdem_gpu::{DeviceRows, Host, HostBuild};
use fdem_scenes::random::Random;

/// Points from 0 to `width` on each axis.
fn gas<const D: usize>(random: &mut Random, n: usize, width: f64) -> Vec<[f64; D]> {
    (0..n).map(|_| std::array::from_fn(|_| random.between(0.0, width))).collect()
}

/// The couples on the device, which are compared with those of `Rows`.
fn same<T: Real + Pod, const D: usize>(what: &str, elements: &Elements<'_, T, D>) -> usize {
    let mut expected = Vec::new();
    Rows::new().couples(elements, &mut expected).unwrap();
    for build in [HostBuild::Ascending, HostBuild::Descending] {
        let host = Host(build);
        let mut search = DeviceRows::new(&host);
        // Twice, because the second search finds the memory of the first one.
        for round in 0..2 {
            assert_eq!(search.count(elements), Ok(expected.len() as u64), "{what}: {build:?}");
            let mut found = Vec::new();
            search.couples(elements, &mut found).unwrap();
            assert!(found == expected, "{what}: {build:?}, {} couples", expected.len());
            if round == 1 {
                same_lists(what, elements, &expected, &mut search);
            }
        }
    }
    expected.len()
}

/// Neighbour lists and distances, to the bit.
fn same_lists<T: Real + Pod, const D: usize>(
    what: &str,
    elements: &Elements<'_, T, D>,
    couples: &[Couple],
    search: &mut DeviceRows<'_, Host, T, D>,
) {
    let distance = |i, j| T::nearest(elements.distance_squared(i, j).to_f64().sqrt());
    let mut expected = Csr::new();
    expected.fill_half_with(elements.len(), couples, distance).unwrap();
    assert_same_rows(what, &search.find_half(elements).unwrap(), &expected);
    expected.fill_full_with(elements.len(), couples, distance).unwrap();
    assert_same_rows(what, &search.find_full(elements).unwrap(), &expected);
}

fn assert_same_rows<T: Real + Pod>(what: &str, found: &Csr<T>, expected: &Csr<T>) {
    assert!(found.offsets() == expected.offsets(), "{what}: offsets");
    assert!(found.neighbours() == expected.neighbours(), "{what}: neighbours");
    let bytes = |csr: &Csr<T>| bytemuck::cast_slice::<T, u8>(csr.values()).to_vec();
    assert!(bytes(found) == bytes(expected), "{what}: distances");
}

fn gases<T: Real + Pod, const D: usize>() {
    let mut random = Random::new(1);
    let mut couples = 0;
    let of = T::nearest;
    for n in [1, 2, 3, 17, 255, 256, 257, 4_097, 20_000] {
        // From crowded to sparse.
        for density in [8.0, 1.0, 0.1, 0.001] {
            let width = (n as f64 / density).powf(1.0 / D as f64);
            let points: Vec<[T; D]> = gas(&mut random, n, width).into_iter().map(|x| x.map(of)).collect();
            couples += same(&format!("{n} points, {density}"), &Elements::points(&points, of(1.0)).unwrap());
            let radii: Vec<T> = (0..n).map(|_| of(0.2 + 0.3 * random.uniform())).collect();
            let spheres = Elements::spheres_with_radii(&points, &radii).unwrap();
            couples += same(&format!("{n} spheres, {density}"), &spheres);
            couples += same(&format!("{n} apart, {density}"), &spheres.with_tolerance(of(0.05)).unwrap());
        }
    }
    assert!(couples > 500_000, "{couples}");
}

#[test]
fn gases_in_the_plane() {
    gases::<f64, 2>();
}

#[test]
fn gases_in_space() {
    gases::<f64, 3>();
}

#[test]
fn gases_in_single_precision() {
    gases::<f32, 2>();
    gases::<f32, 3>();
}

/// Points on a lattice, in lines, in one place, on both sides of zero: many have one coordinate or one key.
#[test]
fn elements_in_one_place_and_on_lattices() {
    let lattice: Vec<[f64; 3]> =
        (0..8000).map(|k| [k % 20, k / 20 % 20, k / 400].map(|i| f64::from(i) * 0.1 - 1.0)).collect();
    // Not all of the 22,800: their coordinates are rounded.
    let couples = same("a lattice", &Elements::points(&lattice, 0.1).unwrap());
    assert!((5_000..22_800).contains(&couples), "{couples}");
    assert!(same("a lattice, wider", &Elements::points(&lattice, 0.25).unwrap()) > 100_000);
    let one = vec![[0.5, -0.0, 0.0]; 700];
    assert_eq!(same("one place", &Elements::points(&one, 0.0).unwrap()), 700 * 699 / 2);
    let mut signs = one.clone();
    signs.iter_mut().step_by(2).for_each(|point| *point = [0.5, 0.0, -0.0]);
    assert_eq!(same("zeros of both signs", &Elements::points(&signs, 1e-3).unwrap()), 700 * 699 / 2);
    let line: Vec<[f64; 2]> = (0..5000).map(|k| [f64::from(k * 7 % 5000), 0.0]).collect();
    assert_eq!(same("a line", &Elements::points(&line, 1.0).unwrap()), 4999);
    let crowd: Vec<[f64; 2]> = (0..3000).map(|k| [f64::from(k * 7 % 3000) * 1e-6, 1e3]).collect();
    let crowd: Vec<[f64; 2]> = crowd.into_iter().chain([[1e3, 0.0]]).collect();
    assert!(same("a crowd in one cell", &Elements::points(&crowd, 1e-5).unwrap()) > 20_000);
    assert!(same("a crowd in a wide cell", &Elements::points(&crowd, 1.0).unwrap()) > 4_000_000);
}

/// Keys of row and place do not fit into one number.
#[test]
fn domains_that_are_far_wider_than_the_elements() {
    let mut random = Random::new(3);
    for width in [1e6, 1e9, 1e12] {
        let mut points = gas::<3>(&mut random, 3000, 14.0);
        for k in 0..20 {
            points[k * 100] = std::array::from_fn(|_| (random.uniform() - 0.5) * width);
        }
        assert!(same(&format!("{width} wide"), &Elements::points(&points, 1.0).unwrap()) > 1000);
        let mut plane = gas::<2>(&mut random, 3000, 50.0);
        plane[77] = [-width, 3.0 * width];
        assert!(same(&format!("{width} wide plane"), &Elements::points(&plane, 1.0).unwrap()) > 1000);
    }
}

/// Distances at the cut-off and next to it.
fn at_the_limit() -> Vec<[f64; 3]> {
    let mut random = Random::new(5);
    let mut points = Vec::new();
    for k in 0..4000_u32 {
        let centre = [k % 16, k / 16 % 16, k / 256].map(|i| f64::from(i) + 0.1 * random.uniform());
        let direction: [f64; 3] = std::array::from_fn(|_| random.uniform() - 0.5);
        let size = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        points.push(centre);
        points.push(std::array::from_fn(|axis| centre[axis] + 0.3 * direction[axis] / size));
    }
    points
}

#[test]
fn a_product_and_a_sum_that_round_once_are_found() {
    let points = at_the_limit();
    let elements = Elements::points(&points, 0.3).unwrap();
    let couples = same("at the limit", &elements);
    assert!((1000..3000).contains(&couples), "{couples} of 4000");
    let (mut found, mut expected): (Vec<Couple>, Vec<Couple>) = Default::default();
    DeviceRows::new(&Host(HostBuild::Contracted)).couples(&elements, &mut found).unwrap();
    Rows::new().couples(&elements, &mut expected).unwrap();
    assert!(found != expected, "contraction changes the couples");
    let mut distances = Csr::new();
    let distance = |i, j| elements.distance_squared(i, j).sqrt();
    distances.fill_half_with(points.len(), &found, distance).unwrap();
    let contracted = DeviceRows::new(&Host(HostBuild::Contracted)).find_half(&elements).unwrap();
    assert_eq!(contracted.neighbours(), distances.neighbours());
    assert!(contracted.values() != distances.values(), "contraction changes distances");
}

#[test]
fn distances_at_the_limit_in_single_precision() {
    let points: Vec<[f32; 3]> = at_the_limit().into_iter().map(|x| x.map(|x| x as f32)).collect();
    let couples = same("at the limit", &Elements::points(&points, 0.3_f32).unwrap());
    assert!((1000..3000).contains(&couples), "{couples} of 4000");
    let radii: Vec<f32> = (0..points.len()).map(|k| [0.1, 0.2][k % 2]).collect();
    let couples = same("of two radii", &Elements::spheres_with_radii(&points, &radii).unwrap());
    assert!((1000..3000).contains(&couples), "{couples} of 4000");
}

/// Bodies, masks, few groups and many, and bodies with them: lists and counts.
#[test]
fn filters() {
    let mut random = Random::new(7);
    let points = gas::<3>(&mut random, 3000, 12.0);
    let mut numbers = |below: u64| -> Vec<u32> { (0..3000).map(|_| random.below(below) as u32).collect() };
    let (bodies, categories, masks) = (numbers(4), numbers(1 << 20), numbers(64));
    let mut matrices = [GroupMatrix::none(5).unwrap(), GroupMatrix::none(70).unwrap()];
    for matrix in &mut matrices {
        let groups = matrix.groups() as u32;
        (0..groups).for_each(|k| matrix.set(k, k * 3 % groups, true).unwrap());
    }
    let [few, many] = [numbers(5), numbers(70)];
    let all = same("no filter", &Elements::points(&points, 1.0).unwrap());
    for (what, filter) in [
        ("bodies", Filter::bodies(&bodies)),
        ("masks", Filter::masks(&categories, &masks)),
        ("masks and bodies", Filter::masks(&categories, &masks).with_bodies(&bodies)),
        ("few groups", Filter::groups(&few, &matrices[0])),
        ("many groups", Filter::groups(&many, &matrices[1])),
        ("groups and bodies", Filter::groups(&few, &matrices[0]).with_bodies(&bodies)),
    ] {
        let couples = same(what, &Elements::points(&points, 1.0).unwrap().with_filter(filter).unwrap());
        assert!(couples > 50 && couples < all, "{what}: {couples} of {all}");
    }
}

#[test]
fn what_a_device_does_not_search_is_refused() {
    let host = Host(HostBuild::Ascending);
    let boxes = Elements::boxes(&[[0.0; 3]], &[[1.0; 3]]).unwrap();
    let error = DeviceRows::new(&host).count(&boxes).unwrap_err();
    assert_eq!(error.to_string(), "a device does not search boxes");
    let wide = [[0.0; 4]; 2];
    let error = DeviceRows::new(&host).count(&Elements::points(&wide, 1.0).unwrap()).unwrap_err();
    assert_eq!(error.to_string(), "a device does not search other than two or three dimensions");
    assert_eq!(DeviceRows::new(&host).count(&Elements::<f64, 3>::points(&[], 1.0).unwrap()), Ok(0));
}

/// The text for a device is whole, and has nothing that only one maker's devices have.
#[test]
fn the_text_of_the_kernels_is_whole() {
    let text = source();
    for kernel in Kernel::ALL {
        assert!(text.contains(&format!("KERNEL({},", kernel.name())), "{}", kernel.name());
    }
    assert!(!text.contains("#include \""));
    for word in ["__shfl", "__ballot", "__syncwarp", "atomicAdd", "warpSize"] {
        assert!(!text.contains(word), "{word}");
    }
    assert_eq!(text.matches("float").count(), 1, "the type f32");
}
