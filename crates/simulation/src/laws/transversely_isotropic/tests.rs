//! Tests of the law: gradient of its energy, turns, moduli, refusals.

use super::*;
use crate::laws::tests::{any, one, rotation};
use crate::moduli::Plane;
use crate::vector::add;

/// A shale: E, ν and the bedding, whose normal is aslant to all axes.
const SHALE: (f64, f64, Bedding) = (
    40e9,
    0.2,
    Bedding {
        normal: [3.0, -2.0, 1.5],
        youngs_modulus: 18e9,
        poissons_ratio: 0.15,
        shear_modulus: 7e9,
        strength: None,
    },
);

fn bedded<const D: usize>(plate: bool) -> Bedded<D> {
    let (e, nu, bedding) = SHALE;
    bedding.in_elements(e, nu, plate)
}

fn respond<const D: usize, const N: usize, L: ElementLaw<D, N>>(law: &L, f: &Matrix<D>) -> Response<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut memory = vec![Lanes::ZERO; L::MEMORY];
    L::stress(&law.constants(), &mut memory, 0, f, <[[f64; D]; N]>::determinant(f))
}

fn near<const D: usize>(seed: u64, size: f64) -> Matrix<D> {
    let noise = any::<D>(seed);
    matrix(|i, k| one::<D>()[i][k] + size * noise[i][k])
}

/// All states of plane strain, plane stress and space.
macro_rules! in_two_and_three_dimensions {
    ($check:ident) => {
        $check::<2, 3>(false);
        $check::<2, 3>(true);
        $check::<3, 4>(false);
    };
}

/// The strain of a stress in space by the five constants, in axes of which the last is the normal.
fn compliant(s: &Matrix<3>) -> Matrix<3> {
    let (e, nu, bedding) = SHALE;
    let Bedding { youngs_modulus: across, poissons_ratio, shear_modulus, .. } = bedding;
    let coupling = poissons_ratio / across;
    let mut strain = [[0.0; 3]; 3];
    strain[0][0] = s[0][0] / e - nu * s[1][1] / e - coupling * s[2][2];
    strain[1][1] = s[1][1] / e - nu * s[0][0] / e - coupling * s[2][2];
    strain[2][2] = s[2][2] / across - coupling * (s[0][0] + s[1][1]);
    let shears = [(0, 1, e / (2.0 * (1.0 + nu))), (0, 2, shear_modulus), (1, 2, shear_modulus)];
    for (i, k, shear) in shears {
        (strain[i][k], strain[k][i]) = (0.5 * s[i][k] / shear, 0.5 * s[i][k] / shear);
    }
    strain
}

/// Axes of which the last is the normal in space: rows.
fn axes(normal: Point<3>) -> Matrix<3> {
    let [x, y, z] = unit(normal);
    let one = unit([-y, x, 0.0]);
    let other = [y * one[2] - z * one[1], z * one[0] - x * one[2], x * one[1] - y * one[0]];
    [one, other, [x, y, z]]
}

#[test]
fn small_strains_have_the_stress_of_the_five_constants_in_space() {
    let law = bedded::<3>(false);
    let axes = axes(SHALE.2.normal);
    for seed in 0..50 {
        let stress = symmetric(&any::<3>(seed)).map(|row| row.map(|x| 1e3 * x));
        let strain = compliant(&stress);
        let turned = |a: &Matrix<3>| product(&product(&transposed(&axes), a), &axes);
        let (stress, strain) = (turned(&stress), turned(&strain));
        let f = matrix(|i, k| one::<3>()[i][k] + strain[i][k]);
        let response = respond::<3, 4, _>(&law, &f);
        let expected = 0.5 * contraction(&stress, &strain);
        for i in 0..3 {
            for k in 0..3 {
                assert!(
                    (response.stress[i][k] - stress[i][k]).abs() < 0.01,
                    "{seed} {stress:?} {response:?}"
                );
            }
        }
        assert!((response.energy / expected - 1.0).abs() < 1e-5, "{} {expected}", response.energy);
        let stored = ElementLaw::<3, 4>::stored(&law, &stress);
        assert!((stored / expected - 1.0).abs() < 1e-12, "{stored} {expected}");
    }
}

/// In plane strain and in plane stress, with the bedding aslant in the plane.
#[test]
fn small_strains_have_the_stress_of_the_five_constants_in_the_plane() {
    let (e, nu, bedding) = SHALE;
    let [x, y] = unit([bedding.normal[0], bedding.normal[1]]);
    let turn = [[y, -x, 0.0], [0.0, 0.0, 1.0], [x, y, 0.0]];
    for (plate, seed) in (0..40).map(|seed| (seed % 2 == 0, seed)) {
        let law = bedded::<2>(plate);
        let mut stress = symmetric(&any::<3>(seed)).map(|row| row.map(|x| 1e3 * x));
        (stress[0][1], stress[1][0], stress[1][2], stress[2][1]) = (0.0, 0.0, 0.0, 0.0);
        // The middle axis is the one out of the plane.
        let ratio = bedding.poissons_ratio * e / bedding.youngs_modulus;
        stress[1][1] = if plate { 0.0 } else { nu * stress[0][0] + ratio * stress[2][2] };
        let strain = compliant(&stress);
        let turned = |a: &Matrix<3>| product(&product(&transposed(&turn), a), &turn);
        let (stress, strain) = (turned(&stress), turned(&strain));
        let f = matrix(|i, k| one::<2>()[i][k] + strain[i][k]);
        let response = respond::<2, 3, _>(&law, &f);
        let in_plane: Matrix<2> = matrix(|i, k| stress[i][k]);
        for i in 0..2 {
            for k in 0..2 {
                assert!(
                    (response.stress[i][k] - stress[i][k]).abs() < 0.01,
                    "{seed} {stress:?} {response:?}"
                );
            }
        }
        let out = ElementLaw::<2, 3>::out_of_plane(&law, &in_plane, &law.normal);
        assert!((out - stress[2][2]).abs() < 1e-9, "{out} {stress:?}");
        let expected = 0.5 * contraction(&stress, &strain);
        let stored = ElementLaw::<2, 3>::stored(&law, &in_plane);
        assert!((stored / expected - 1.0).abs() < 1e-12, "{stored} {expected}");
    }
}

#[test]
fn a_rotation_changes_no_energy_and_turns_the_stress_to_ten_digits() {
    fn check<const D: usize, const N: usize>(plate: bool)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let law = bedded::<D>(plate);
        for seed in 0..200 {
            let (f, turn) = (near::<D>(seed, 0.2), rotation::<D>(1000 + seed));
            let (one, other) = (respond::<D, N, _>(&law, &f), respond::<D, N, _>(&law, &product(&turn, &f)));
            assert!((other.energy / one.energy - 1.0).abs() < 1e-10, "{seed} {one:?} {other:?}");
            let expected = product(&turn, &one.stress);
            let off: Matrix<D> = matrix(|i, k| other.stress[i][k] - expected[i][k]);
            let size = contraction(&expected, &expected);
            assert!(contraction(&off, &off) < 1e-20 * size, "{seed} {off:?}");
            // Without any strain there is no stress beyond rounding.
            let rigid = respond::<D, N, _>(&law, &turn);
            assert!(rigid.stress.iter().flatten().all(|s| s.abs() < 40e9 * 5e-15), "{rigid:?}");
        }
    }
    in_two_and_three_dimensions!(check);
}

#[test]
fn the_stress_is_the_gradient_of_the_energy() {
    fn check<const D: usize, const N: usize>(plate: bool)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let law = bedded::<D>(plate);
        for seed in 0..50 {
            let f = near::<D>(seed, 0.4);
            if <[[f64; D]; N]>::determinant(&f) < 0.2 {
                continue;
            }
            let response = respond::<D, N, _>(&law, &f);
            for i in 0..D {
                for k in 0..D {
                    let h = 1e-6;
                    let [before, after] = [-h, h].map(|step| {
                        let mut moved = f;
                        moved[i][k] += step;
                        respond::<D, N, _>(&law, &moved).energy
                    });
                    let slope = (after - before) / (2.0 * h);
                    let error = (response.stress[i][k] - slope).abs();
                    assert!(error < 1e-8 * 40e9, "{seed} {i} {k}: {response:?} {slope}");
                }
            }
        }
    }
    in_two_and_three_dimensions!(check);
}

/// The part that is added to the neo-Hookean energy is nowhere negative, and the share of that is no less
/// than it can be.
#[test]
fn the_neo_hookean_share_is_the_largest_that_leaves_a_positive_rest() {
    fn check<const D: usize, const N: usize>(plate: bool)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let law = bedded::<D>(plate);
        let mut least = f64::INFINITY;
        for seed in 0..20_000 {
            let strain = symmetric(&any::<D>(seed));
            let (_, energy) = law.rest.stress(law.normal, &strain);
            let (_, whole) = law.whole.stress(law.normal, &strain);
            least = least.min(energy / whole);
        }
        assert!((-1e-12..0.02).contains(&least), "{least}");
    }
    in_two_and_three_dimensions!(check);
}

#[test]
fn an_isotropic_material_with_bedding_is_neo_hookean() {
    fn check<const D: usize, const N: usize>(plate: bool)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (e, nu) = (40e9, 0.2);
        let shear_modulus = e / (2.0 * (1.0 + nu));
        let bedding = Bedding { youngs_modulus: e, poissons_ratio: nu, shear_modulus, ..SHALE.2 };
        let law = bedding.in_elements::<D>(e, nu, plate);
        let moduli = <[[f64; D]; N]>::moduli(e, nu, if plate { Plane::Stress } else { Plane::Strain });
        for seed in 0..50 {
            let f = near::<D>(seed, 0.2);
            let (one, other) = (respond::<D, N, _>(&law, &f), respond::<D, N, _>(&moduli, &f));
            assert!((one.energy / other.energy - 1.0).abs() < 1e-6, "{one:?} {other:?}");
        }
        let [wave, shear] = ElementLaw::<D, N>::wave_moduli(&law, law.normal);
        assert!((wave / moduli.wave - 1.0).abs() < 1e-12 && (shear / moduli.shear - 1.0).abs() < 1e-12);
        let mut shape = [[0.0; D]; N];
        for (corner, row) in any::<D>(3).into_iter().enumerate() {
            shape[corner + 1] = std::array::from_fn(|axis| row[axis] + one::<D>()[corner][axis]);
        }
        let [one, other] = [
            ElementLaw::<D, N>::highest_square(&law, &shape, 2700.0),
            ElementLaw::<D, N>::highest_square(&moduli, &shape, 2700.0),
        ];
        assert!((one / other - 1.0).abs() < 1e-9, "{one} {other}");
    }
    in_two_and_three_dimensions!(check);
}

/// The highest frequency is that of the power method on the forces of an element.
#[test]
fn the_highest_frequency_is_that_of_the_element() {
    fn check<const D: usize, const N: usize>(plate: bool)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let law = bedded::<D>(plate);
        let mut shape = [[0.0; D]; N];
        for (corner, row) in any::<D>(5).into_iter().enumerate() {
            shape[corner + 1] = std::array::from_fn(|axis| row[axis] + one::<D>()[corner][axis]);
        }
        let inverse = <[[f64; D]; N]>::inverse_edges(&shape);
        let mut moved: [Point<D>; N] = std::array::from_fn(|corner| any::<D>(corner as u64)[0]);
        let mut value = 0.0;
        for _ in 0..2000 {
            let gradient = product(&<[[f64; D]; N]>::edges(&moved), &inverse);
            let (stress, _) = law.whole.stress(law.normal, &symmetric(&gradient));
            // Forces of a volume of 1, over the mass of a corner for a density of 1.
            let mut forces = [[0.0; D]; N];
            for k in 0..D {
                let force = applied(&stress, inverse[k]).map(|x| x * N as f64);
                add(&mut forces[k + 1], force, 1.0);
                add(&mut forces[0], force, -1.0);
            }
            value = forces.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
            moved = forces.map(|force| force.map(|x| x / value));
        }
        let found = ElementLaw::<D, N>::highest_square(&law, &shape, 1.0);
        assert!((found / value - 1.0).abs() < 1e-9, "{found} {value}");
    }
    in_two_and_three_dimensions!(check);
}

#[test]
fn waves_along_and_across_the_bedding() {
    let (e, nu, bedding) = SHALE;
    let law = bedded::<3>(false);
    let [one, _, normal] = axes(bedding.normal);
    let stability = bedding.stability(e, nu);
    let [p, s] = ElementLaw::<3, 4>::wave_moduli(&law, normal);
    assert!((p / (bedding.youngs_modulus * (1.0 - nu) / stability) - 1.0).abs() < 1e-12);
    assert!((s / bedding.shear_modulus - 1.0).abs() < 1e-12);
    let ratio = bedding.poissons_ratio.powi(2) * e / bedding.youngs_modulus;
    let [p, s] = ElementLaw::<3, 4>::wave_moduli(&law, one);
    assert!((p / (e * (1.0 - ratio) / ((1.0 + nu) * stability)) - 1.0).abs() < 1e-12);
    let mean = 0.5 * (bedding.shear_modulus + e / (2.0 * (1.0 + nu)));
    assert!((s / mean - 1.0).abs() < 1e-12);
}

#[test]
fn strengths_grow_linearly_from_the_bedding_to_the_direction_across() {
    let across = Strength {
        tensile: 9.0,
        cohesion: 30.0,
        friction: 0.5,
        energy_i: 90.0,
        energy_ii: 300.0,
        weibull_modulus: None,
        seed: 1,
    };
    let on = Strength { tensile: 3.0, cohesion: 6.0, energy_i: 30.0, energy_ii: 60.0, ..across };
    let bedding = Bedding { normal: [0.0, 2.0, 0.0], strength: Some(on), ..SHALE.2 };
    for (degrees, tensile, cohesion, energy_i, energy_ii) in
        [(0.0_f64, 3.0, 6.0, 30.0, 60.0), (30.0, 5.0, 14.0, 50.0, 140.0), (90.0, 9.0, 30.0, 90.0, 300.0)]
    {
        let (sin, cos) = degrees.to_radians().sin_cos();
        for normal in [[sin, cos], [-sin, -cos], [sin, -cos]] {
            let found = bedding.strength_on(across, normal);
            let found = [found.tensile, found.cohesion, found.energy_i, found.energy_ii];
            for (found, expected) in found.into_iter().zip([tensile, cohesion, energy_i, energy_ii]) {
                assert!((found / expected - 1.0).abs() < 1e-12, "{degrees} {found} {expected}");
            }
        }
    }
    let same = Bedding { strength: None, ..bedding };
    assert_eq!(same.strength_on(across, [0.6, 0.8]), across);
}

#[test]
fn constants_without_a_positive_energy_are_refused() {
    let (e, nu, bedding) = SHALE;
    assert!(bedding.check(3, e, nu).is_ok());
    let refusal = |bedding: Bedding, dimensions: usize, nu: f64| {
        bedding.check(dimensions, e, nu).expect_err("it is refused").what
    };
    assert!(refusal(Bedding { youngs_modulus: 0.0, ..bedding }, 3, nu).contains("Young's modulus"));
    assert!(refusal(Bedding { shear_modulus: f64::NAN, ..bedding }, 3, nu).contains("shear modulus"));
    assert!(refusal(Bedding { normal: [0.0; 3], ..bedding }, 3, nu).contains("length of the normal"));
    assert!(refusal(bedding, 2, nu).contains("out of the plane"));
    assert!(refusal(bedding, 3, 1.0).contains("Poisson's ratio"));
    assert!(refusal(Bedding { poissons_ratio: 0.5, ..bedding }, 3, nu).contains("1 - ν - 2 ν'² E/E'"));
}

#[test]
fn the_mean_of_isotropic_constants_is_theirs() {
    let (e, nu) = (30e9, 0.49);
    let bedding = Bedding {
        normal: [1.0, 0.0, 2.0],
        youngs_modulus: e,
        poissons_ratio: nu,
        shear_modulus: e / (2.0 + 2.0 * nu),
        strength: None,
    };
    assert!((bedding.mean_poissons_ratio(e, nu) - nu).abs() < 1e-12);
    let softer = Bedding { youngs_modulus: 0.5 * e, poissons_ratio: 0.2, ..bedding };
    assert!((0.1..0.49).contains(&softer.mean_poissons_ratio(e, 0.3)));
}
