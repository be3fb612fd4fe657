//! The laws of contacts in the kernels are those of the simulation, to the bit.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]
#![allow(clippy::needless_range_loop, reason = "an axis is a place in several rows")]

use fdem_gpu::{Host, HostBuild, contact_numbers, press_cases};
use fdem_scenes::random::Random;
use fdem_simulation::{ContactCase, FlatContact, FlatGrip, press_tetrahedra, press_triangles};

/// Time step, s, and ignored energy of an overlap that relaxes over that before the step.
const STEP: f64 = 1e-6;
const STILL_IGNORED: f64 = 0.97;

/// The sum of some numbers in their order, and their mean.
fn mean<const D: usize>(points: &[[f64; D]]) -> [f64; D] {
    std::array::from_fn(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64)
}

/// Area or volume, times 2 or 6.
fn size<const D: usize, const N: usize>(shape: &[[f64; D]; N]) -> f64 {
    let edge = |k: usize| -> [f64; 3] {
        std::array::from_fn(|axis| if axis < D { shape[k][axis] - shape[0][axis] } else { 0.0 })
    };
    let (one, two) = (edge(1), edge(2));
    let three = if D == 3 { edge(3) } else { [0.0, 0.0, 1.0] };
    let normal = [
        one[1] * two[2] - one[2] * two[1],
        one[2] * two[0] - one[0] * two[2],
        one[0] * two[1] - one[1] * two[0],
    ];
    (0..3).map(|axis| normal[axis] * three[axis]).sum()
}

/// An element of about unit size. Every fourth has corners whose coordinates are multiples of a quarter, so
/// that facets and corners of two lie in one plane.
fn shape<const D: usize, const N: usize>(kind: u64, random: &mut Random) -> [[f64; D]; N] {
    loop {
        let mut shape: [[f64; D]; N] = std::array::from_fn(|_| {
            std::array::from_fn(|_| {
                let place = random.between(0.0, 2.0);
                if kind.is_multiple_of(4) { (4.0 * place).round() / 4.0 } else { place }
            })
        });
        if size(&shape) < 0.0 {
            shape.swap(0, 1);
        }
        if size(&shape) > 0.3 {
            return shape;
        }
    }
}

/// Two elements that overlap in many ways: by a corner, deeply, with a facet through the centroid of the
/// other or near it; or that are apart.
fn case<const D: usize, const N: usize>(kind: u64, random: &mut Random) -> ContactCase<D, N> {
    let (one, mut other) = (shape::<D, N>(kind, random), shape::<D, N>(kind, random));
    let move_by = |shape: &mut [[f64; D]; N], by: [f64; D]| {
        for corner in shape {
            for axis in 0..D {
                corner[axis] += by[axis];
            }
        }
    };
    match kind % 7 {
        // A facet, an edge or a corner of one near the centroid of the other.
        0 | 1 => {
            let (centroid, corners) = (mean(&one), 1 + kind as usize / 7 % D);
            let place = mean(&other[..corners]);
            let off = if kind.is_multiple_of(2) { 0.0 } else { 10.0_f64.powi(-4 - (kind % 5) as i32) };
            move_by(&mut other, std::array::from_fn(|axis| centroid[axis] - place[axis] + off));
        }
        // Two of one shape, and two that share a facet.
        2 if kind.is_multiple_of(5) => other = one,
        2 if kind % 5 == 1 => {
            other[..D].copy_from_slice(&one[..D]);
            if size(&other) < 0.0 {
                other.swap(0, 1);
            }
        }
        3 | 4 => {
            let by = random.between(0.0, 1.0);
            move_by(&mut other, [by; D]);
        }
        5 => move_by(&mut other, std::array::from_fn(|axis| if axis == 0 { 1.2 } else { 0.1 })),
        _ => {}
    }
    let mut vector = |size: f64| -> [f64; D] { std::array::from_fn(|_| size * random.between(-1.0, 1.0)) };
    let velocities = [0, 1].map(|_| std::array::from_fn(|_| vector(3.0)));
    let is_new = kind.is_multiple_of(3);
    let some = if is_new { 0.0 } else { 1.0 };
    let grip = FlatGrip {
        friction: vector(1e7 * some),
        damping: vector(1e6 * some),
        shares: [vector(0.3 * some), vector(0.3 * some)],
        credited_energy: some * 10.0_f64.powi(4 + (kind % 5) as i32) * vector(1.0)[0].abs(),
        way: if is_new { 0 } else { (kind / 3 % 4) as u8 },
        push: vector(1e7 * some),
    };
    let law = FlatContact {
        penalty: 1e9 * random.between(0.5, 2.0),
        friction: if kind.is_multiple_of(11) { 0.0 } else { random.between(0.0, 0.9) },
        tangential: 1e9 * random.between(0.1, 1.0),
        damping: if kind.is_multiple_of(5) { 0.0 } else { random.between(0.0, 1.0) },
        masses: [random.between(10.0, 100.0), random.between(10.0, 100.0)],
        length: if D == 2 { 1.0 } else { random.between(0.3, 1.0) },
        weight: if kind.is_multiple_of(2) { 1.0 } else { random.uniform() },
        fading: if kind.is_multiple_of(2) { 0.0 } else { 0.1 * random.uniform() },
    };
    ContactCase {
        shapes: [one, other],
        velocities,
        law,
        overlap: if kind.is_multiple_of(6) { (kind / 6 % 4) as u8 } else { 0 },
        grip,
        forces: [[[0.0; D]; N]; 2],
        energy: [0.0; 2],
        works: [0.0; 5],
        distances: [0.0; 2],
    }
}

/// The numbers of a couple in the order of the kernels.
fn numbers<const D: usize, const N: usize>(of: &ContactCase<D, N>) -> Vec<f64> {
    let corners = |of: &[[[f64; D]; N]; 2]| of.as_flattened().as_flattened().to_vec();
    let FlatContact { penalty, friction, tangential, damping, masses, length, weight, fading } = of.law;
    let law = [penalty, friction, tangential, damping, masses[0], masses[1], length, weight, fading];
    let grip = &of.grip;
    [
        corners(&of.shapes),
        corners(&of.velocities),
        law.to_vec(),
        vec![f64::from(of.overlap)],
        [grip.friction, grip.damping, grip.shares[0], grip.shares[1]].concat(),
        vec![grip.credited_energy, f64::from(grip.way)],
        grip.push.to_vec(),
        corners(&of.forces),
        of.energy.to_vec(),
        of.works.to_vec(),
        of.distances.to_vec(),
    ]
    .concat()
}

/// Number of couples with other bits on the device. Couples of all kinds overlap, are deep, slip and stick.
fn unlike<const D: usize, const N: usize>(
    build: HostBuild,
    count: u64,
    on_processor: fn(&mut [ContactCase<D, N>], f64, f64),
) -> usize {
    let mut random = Random::new(31);
    let mut cases: Vec<ContactCase<D, N>> = (0..count).map(|kind| case(kind, &mut random)).collect();
    let mut found: Vec<f64> = cases.iter().flat_map(numbers).collect();
    on_processor(&mut cases, STEP, STILL_IGNORED);
    press_cases::<D>(&Host(build), &mut found, STEP, STILL_IGNORED).unwrap();
    let [overlap, deep, rub, apart, between] = [
        cases.iter().filter(|case| case.energy[0] > 0.0).count(),
        cases.iter().filter(|case| case.energy[1] > 0.0).count(),
        cases.iter().filter(|case| case.grip.friction != [0.0; D]).count(),
        cases.iter().filter(|case| case.distances[0] > 0.0).count(),
        cases.iter().filter(|case| case.distances[0] < 0.0 && case.energy[0] <= 0.0).count(),
    ];
    for some in [overlap, deep, rub, apart] {
        assert!((cases.len() / 50..cases.len() * 49 / 50).contains(&some), "{some} of {count}");
    }
    // In space edges may be nearest to each other, so that no facet parts two elements.
    assert!(D == 2 || between > cases.len() / 500, "{between} of {count}");
    let rows = found.chunks(contact_numbers(D)).zip(&cases);
    let bits = |number: f64| if number.is_nan() { f64::NAN.to_bits() } else { number.to_bits() };
    rows.filter(|(found, case)| !numbers(case).into_iter().map(bits).eq(found.iter().copied().map(bits)))
        .count()
}

#[test]
fn contacts_of_triangles_have_the_bits_of_the_processor() {
    assert_eq!(unlike::<2, 3>(HostBuild::Ascending, 200_000, press_triangles), 0);
    let fused = unlike(HostBuild::Contracted, 10_000, press_triangles);
    assert!(fused > 5_000, "{fused}");
}

#[test]
fn contacts_of_tetrahedra_have_the_bits_of_the_processor() {
    assert_eq!(unlike::<3, 4>(HostBuild::Ascending, 30_000, press_tetrahedra), 0);
    let fused = unlike(HostBuild::Contracted, 10_000, press_tetrahedra);
    assert!(fused > 5_000, "{fused}");
}
