//! Packings have no overlap, the fraction and the sizes that were asked for, and the same bits everywhere.

use fdem_grains::*;

fn request(region: PackRegion, sizes: SphereSizes, fraction: f64) -> PackRequest<'static> {
    PackRequest {
        discs: false,
        region,
        sizes,
        amount: PackAmount::Fraction(fraction),
        gap: 0.0,
        seed: 1,
        others: &[],
    }
}

fn unit_box() -> PackRegion {
    PackRegion::Box { low: [0.0; 3], high: [1.0; 3] }
}

/// Least distance of two spheres from each other, and of spheres from the sides of the unit box.
fn least_gap(packed: &Packed, axes: usize) -> f64 {
    let mut least = f64::INFINITY;
    for (i, (a, r)) in packed.positions.iter().zip(&packed.radii).enumerate() {
        for (b, s) in packed.positions[..i].iter().zip(&packed.radii) {
            let distance = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
            least = least.min(distance - r - s);
        }
        for x in &a[..axes] {
            least = least.min(x - r).min(1.0 - x - r);
        }
    }
    least
}

#[test]
fn spheres_do_not_overlap_up_to_a_fraction_of_0_6() {
    for fraction in [0.2, 0.4, 0.59, 0.6] {
        let packed = pack(request(unit_box(), SphereSizes::Uniform([0.03, 0.04]), fraction), 1).unwrap();
        assert!((packed.fraction / fraction - 1.0).abs() < 0.01, "{fraction} {}", packed.fraction);
        assert!(least_gap(&packed, 3) >= 0.0, "{fraction} {}", least_gap(&packed, 3));
    }
}

#[test]
fn discs_do_not_overlap_up_to_a_fraction_of_0_8() {
    for fraction in [0.3, 0.6, 0.8] {
        let region = PackRegion::Box { low: [0.0; 3], high: [1.0, 1.0, 0.0] };
        let sizes = SphereSizes::Uniform([0.008, 0.014]);
        let packed = pack(PackRequest { discs: true, ..request(region, sizes, fraction) }, 1).unwrap();
        assert!((packed.fraction / fraction - 1.0).abs() < 0.01, "{fraction} {}", packed.fraction);
        assert!(packed.positions.iter().all(|at| at[2] == 0.0));
        assert!(least_gap(&packed, 2) >= 0.0, "{fraction} {}", least_gap(&packed, 2));
    }
}

#[test]
fn the_gap_is_kept() {
    let wanted = PackRequest { gap: 0.004, ..request(unit_box(), SphereSizes::Equal(0.04), 0.45) };
    let packed = pack(wanted, 1).unwrap();
    assert!(least_gap(&packed, 3) >= 0.003_999_9, "{}", least_gap(&packed, 3));
}

#[test]
fn threads_change_no_bit_and_seeds_do() {
    let of = |threads, seed| {
        pack(PackRequest { seed, ..request(unit_box(), SphereSizes::Uniform([0.02, 0.04]), 0.55) }, threads)
            .unwrap()
    };
    let first = of(1, 1);
    assert_eq!(first, of(2, 1));
    assert_eq!(first, of(3, 1));
    assert_ne!(first.positions, of(1, 2).positions);
}

#[test]
fn a_grading_curve_holds_in_a_dense_packing() {
    let curve = vec![[0.01, 0.0], [0.02, 0.3], [0.03, 0.6], [0.05, 1.0]];
    let packed = pack(request(unit_box(), SphereSizes::Grading(curve.clone()), 0.58), 1).unwrap();
    assert!(least_gap(&packed, 3) >= 0.0);
    let mass = |most: f64| -> f64 {
        packed.radii.iter().filter(|radius| **radius <= most).map(|radius| radius.powi(3)).sum()
    };
    for [radius, share] in curve {
        let found = mass(radius) / mass(1.0);
        assert!((found - share).abs() < 0.02, "{radius} {share} {found}");
    }
}

#[test]
fn regions_of_all_kinds_keep_their_spheres() {
    let corner = |k: usize| [k & 1, (k >> 1) & 1, (k >> 2) & 1].map(|bit| bit as f64);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let triangles = triangles.map(|triangle| triangle.map(corner)).collect();
    let cylinder = PackRegion::Cylinder { from: [0.5, 0.5, 0.0], to: [0.5, 0.5, 1.0], radius: 0.5 };
    let ball = PackRegion::Ball { centre: [0.5; 3], radius: 0.5 };
    for (region, measure) in [
        (PackRegion::Inside(Box::new(ClosedSurface::new(triangles))), 1.0),
        (cylinder, std::f64::consts::PI / 4.0),
        (ball, std::f64::consts::PI / 6.0),
    ] {
        assert!((region.measure(false) - measure).abs() < 1e-12);
        for fraction in [0.2, 0.5] {
            let packed = pack(request(region.clone(), SphereSizes::Equal(0.04), fraction), 2).unwrap();
            assert!((packed.fraction / fraction - 1.0).abs() < 0.01);
            assert!(least_gap(&packed, 3) >= 0.0, "{region:?} {fraction}");
            for (at, radius) in packed.positions.iter().zip(&packed.radii) {
                let [x, y, z] = at.map(|x| x - 0.5);
                let far = match region {
                    PackRegion::Cylinder { .. } => x.hypot(y),
                    PackRegion::Ball { .. } => (x * x + y * y + z * z).sqrt(),
                    _ => continue,
                };
                assert!(far + radius <= 0.5 + 1e-12, "{at:?}");
            }
        }
    }
}

#[test]
fn spheres_that_are_there_have_their_room() {
    let others = [([0.5; 3], 0.2)];
    let wanted = PackRequest { others: &others, ..request(unit_box(), SphereSizes::Equal(0.03), 0.5) };
    let mut packed = pack(wanted, 1).unwrap();
    packed.positions.push(others[0].0);
    packed.radii.push(others[0].1);
    assert!(least_gap(&packed, 3) >= 0.0);
    assert_eq!(worst_overlap(&packed.positions, &packed.radii, &[], 1), Ok(None));
    packed.positions[3] = [0.4, 0.5, 0.5];
    let (pair, share) = worst_overlap(&packed.positions, &packed.radii, &[], 1).unwrap().unwrap();
    let clump = Clump { spheres: pair.to_vec(), ..Clump::default() };
    assert_eq!(worst_overlap(&packed.positions, &packed.radii, &[clump], 1), Ok(None));
    assert_eq!(pair, [3, packed.radii.len() as u32 - 1]);
    assert!((share - 0.13 / 0.03).abs() < 1e-9, "{share}");
}

#[test]
fn a_fraction_that_cannot_be_reached_is_refused_with_the_one_that_was() {
    let refused = pack(request(unit_box(), SphereSizes::Equal(0.04), 0.7), 1).unwrap_err();
    let PackError::TooDense { fraction, reached } = refused else { panic!("{refused}") };
    assert!((fraction - 0.7).abs() < 0.01);
    assert!(reached > 0.5 && reached < 0.66, "{reached}");
    assert!(refused.to_string().contains("was reached"), "{refused}");
    let error = |sizes, fraction| pack(request(unit_box(), sizes, fraction), 1).unwrap_err();
    assert!(matches!(error(SphereSizes::Equal(0.04), 0.9), PackError::TooDense { reached: 0.0, .. }));
    assert!(matches!(error(SphereSizes::Equal(1.0), 0.5), PackError::Empty));
    assert!(matches!(error(SphereSizes::Equal(0.51), 0.6), PackError::TooLarge { .. }));
    assert!(matches!(error(SphereSizes::Equal(-1.0), 0.5), PackError::Sizes(_)));
    assert!(matches!(error(SphereSizes::Equal(1e-9), 0.5), PackError::TooMany { .. }));
}
