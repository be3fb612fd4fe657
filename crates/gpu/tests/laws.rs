//! The laws of the kernels are those of the simulation, to the bit.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]
#![allow(clippy::needless_range_loop, reason = "an axis is a place in several rows")]

use fdem_gpu::{ElementKind, Host, HostBuild, deform};
use fdem_scenes::random::Random;
use fdem_simulation::{ElementForces, ElementState, deform_tetrahedra, deform_triangles};

/// Elements of each kind.
const COUNT: u64 = 250_000;

/// An element that is turned and strained: by 1e-9 up to a half, so that small and large strains are among
/// them, and some at the limit between the two.
fn element<const D: usize>(seed: u64) -> ElementState<D> {
    let mut random = Random::new(seed);
    let mut any = |size: f64| -> [[f64; D]; D] {
        std::array::from_fn(|_| std::array::from_fn(|_| size * random.between(-1.0, 1.0)))
    };
    let strain = 0.5 * 10.0_f64.powi(-((seed % 28) as i32) / 3);
    let (mut edges, mut gradients, off) = (any(0.2), any(0.0), any(strain));
    for axis in 0..D {
        edges[axis][axis] += 1.0;
    }
    // Edges of the undeformed element E, its inverse, and F E with F near a rotation about the last axis.
    let inverse = inverse(&edges);
    gradients.copy_from_slice(&inverse);
    let angle = 3.0 * any(1.0)[0][0];
    let mut f = off;
    for axis in 0..D {
        f[axis][axis] += 1.0;
    }
    let (sine, cosine) = angle.sin_cos();
    let mut turned = f;
    turned[0] = std::array::from_fn(|k| cosine * f[0][k] - sine * f[1][k]);
    turned[1] = std::array::from_fn(|k| sine * f[0][k] + cosine * f[1][k]);
    let deformed = std::array::from_fn(|i| {
        std::array::from_fn(|k| (0..D).map(|m| turned[i][m] * edges[m][k]).sum::<f64>())
    });
    ElementState {
        gradients,
        edges: deformed,
        rates: any(3.0),
        initial: any(1e7),
        viscous: any(1e6),
        volume: 0.2 + any(0.1)[0][0].abs(),
        viscosity: 1e5 * any(1.0)[0][0].abs(),
        stored: 1e3 * any(1.0)[0][0].abs(),
        shear: 2e10,
        bulk: 3e10,
    }
}

/// By elimination, without a choice of rows: the diagonal is large.
fn inverse<const D: usize>(of: &[[f64; D]; D]) -> [[f64; D]; D] {
    let (mut left, mut right) = (*of, [[0.0; D]; D]);
    for axis in 0..D {
        right[axis][axis] = 1.0;
    }
    for k in 0..D {
        let over = 1.0 / left[k][k];
        left[k] = left[k].map(|x| x * over);
        right[k] = right[k].map(|x| x * over);
        for i in (0..D).filter(|&i| i != k) {
            let factor = left[i][k];
            for m in 0..D {
                left[i][m] -= factor * left[k][m];
                right[i][m] -= factor * right[k][m];
            }
        }
    }
    right
}

/// The numbers of an element in the order of the kernels.
fn numbers<const D: usize>(of: &ElementState<D>) -> impl Iterator<Item = f64> + use<D> {
    let tensors = [of.gradients, of.edges, of.rates, of.initial, of.viscous];
    let rest = [of.volume, of.viscosity, of.stored, of.shear, of.bulk];
    tensors.into_iter().flatten().flatten().chain(rest)
}

/// The results of an element in the order of the kernels.
fn results<const D: usize, const N: usize>(of: &ElementForces<D, N>) -> Vec<f64> {
    let tensors = of.stress.into_iter().chain(of.viscous);
    let rows = of.forces.into_iter().chain(tensors).flatten();
    rows.chain([of.energy, of.ratio, of.power]).collect()
}

/// Number of elements with other bits on the device. The stress below the diagonal does not count.
fn unlike<const D: usize, const N: usize>(
    build: HostBuild,
    kind: ElementKind,
    on_processor: fn(&[ElementState<D>], [bool; 2]) -> Vec<ElementForces<D, N>>,
) -> usize {
    let elements: Vec<ElementState<D>> = (0..COUNT).map(element).collect();
    let states: Vec<f64> = elements.iter().flat_map(numbers).collect();
    let counts = |place: usize| {
        let (row, column) = ((place / D).wrapping_sub(N), place % D);
        row >= D || row <= column
    };
    let mut unlike = 0;
    for kinds in [[false, false], [false, true], [true, false], [true, true]] {
        let expected = on_processor(&elements, kinds);
        let found = deform(&Host(build), kind, &states, kinds).unwrap();
        for (expected, found) in expected.iter().zip(found.chunks(kind.numbers()[1])) {
            assert!(expected.forces[0][0] != 0.0 && expected.energy.is_finite(), "{expected:?}");
            let expected = results(expected);
            assert_eq!(expected.len(), found.len());
            let mut pairs = expected.iter().zip(found).enumerate();
            unlike += usize::from(pairs.any(|(k, (one, two))| counts(k) && one.to_bits() != two.to_bits()));
        }
    }
    unlike
}

#[test]
fn triangles_have_the_bits_of_the_processor() {
    assert_eq!(unlike(HostBuild::Ascending, ElementKind::Triangle, deform_triangles), 0);
}

#[test]
fn tetrahedra_have_the_bits_of_the_processor() {
    assert_eq!(unlike(HostBuild::Ascending, ElementKind::Tetrahedron, deform_tetrahedra), 0);
}

#[test]
fn a_product_and_a_sum_that_round_once_have_other_bits() {
    let all = 4 * COUNT as usize;
    let triangles = unlike(HostBuild::Contracted, ElementKind::Triangle, deform_triangles);
    assert!(triangles > all * 9 / 10, "{triangles} of {all}");
    let tetrahedra = unlike(HostBuild::Contracted, ElementKind::Tetrahedron, deform_tetrahedra);
    assert!(tetrahedra > all * 9 / 10, "{tetrahedra} of {all}");
}
