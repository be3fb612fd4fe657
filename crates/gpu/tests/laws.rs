//! The laws of the kernels are those of the simulation, to the bit.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]
#![allow(clippy::needless_range_loop, reason = "an axis is a place in several rows")]

use fdem_gpu::{ElementKind, Host, HostBuild, deform, exponentials, soften_ends};
use fdem_scenes::random::Random;
use fdem_simulation::{
    ElementForces, ElementState, EndMemory, FlatBedding, FlatLaw, JointEnd, deform_tetrahedra,
    deform_triangles,
};

/// Elements of each kind.
const COUNT: u64 = 250_000;

/// An element that is turned and strained: by 1e-9 up to a half, so that small and large strains are among
/// them, and some at the limit between the two.
fn element<const D: usize>(kind: u64, random: &mut Random) -> ElementState<D> {
    let mut any = |size: f64| -> [[f64; D]; D] {
        std::array::from_fn(|_| std::array::from_fn(|_| size * random.between(-1.0, 1.0)))
    };
    let strain = 0.5 * 10.0_f64.powi(-((kind % 28) as i32) / 3);
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
    let normal = any(1.0)[0];
    let size = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let rest = any(1e10).into_iter().chain(any(1e10)).flatten();
    let mut rest = rest.chain(any(1e10)[0]);
    ElementState {
        bedding: FlatBedding {
            rest: std::array::from_fn(|_| rest.next().unwrap()),
            normal: normal.map(|x| x / size),
        },
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
    tensors.into_iter().flatten().flatten().chain(rest).chain(of.bedding.rest).chain(of.bedding.normal)
}

/// The results of an element in the order of the kernels.
fn results<const D: usize, const N: usize>(of: &ElementForces<D, N>) -> Vec<f64> {
    let tensors = of.stress.into_iter().chain(of.viscous);
    let rows = of.forces.into_iter().chain(tensors).flatten();
    rows.chain([of.energy, of.ratio, of.power]).chain(of.normal).collect()
}

/// Number of elements with other bits on the device. The stress below the diagonal does not count.
fn unlike<const D: usize, const N: usize>(
    build: HostBuild,
    kind: ElementKind,
    is_bedded: bool,
    on_processor: fn(&[ElementState<D>], [bool; 3]) -> Vec<ElementForces<D, N>>,
) -> usize {
    let mut random = Random::new(5);
    let elements: Vec<ElementState<D>> = (0..COUNT).map(|kind| element(kind, &mut random)).collect();
    let states: Vec<f64> = elements.iter().flat_map(numbers).collect();
    let counts = |place: usize| {
        let (row, column) = ((place / D).wrapping_sub(N), place % D);
        row >= D || row <= column
    };
    let mut unlike = 0;
    for [has_initial, is_viscous] in [[false, false], [false, true], [true, false], [true, true]] {
        let kinds = [has_initial, is_viscous, is_bedded];
        let expected = on_processor(&elements, kinds);
        let found = deform(&Host(build), kind, &states, kinds).unwrap();
        for (expected, found) in expected.iter().zip(found.chunks(kind.numbers()[1])) {
            assert!(expected.forces[0][0] != 0.0 && expected.energy.is_finite(), "{expected:?}");
            assert_eq!(expected.normal != [0.0; D], is_bedded);
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
    assert_eq!(unlike(HostBuild::Ascending, ElementKind::Triangle, false, deform_triangles), 0);
}

#[test]
fn tetrahedra_have_the_bits_of_the_processor() {
    assert_eq!(unlike(HostBuild::Ascending, ElementKind::Tetrahedron, false, deform_tetrahedra), 0);
}

#[test]
fn triangles_with_bedding_have_the_bits_of_the_processor() {
    assert_eq!(unlike(HostBuild::Ascending, ElementKind::Triangle, true, deform_triangles), 0);
}

#[test]
fn tetrahedra_with_bedding_have_the_bits_of_the_processor() {
    assert_eq!(unlike(HostBuild::Ascending, ElementKind::Tetrahedron, true, deform_tetrahedra), 0);
}

#[test]
fn a_product_and_a_sum_that_round_once_have_other_bits() {
    let all = 4 * COUNT as usize;
    for is_bedded in [false, true] {
        let triangles = unlike(HostBuild::Contracted, ElementKind::Triangle, is_bedded, deform_triangles);
        assert!(triangles > all * 9 / 10, "{triangles} of {all}");
        let tetrahedra =
            unlike(HostBuild::Contracted, ElementKind::Tetrahedron, is_bedded, deform_tetrahedra);
        assert!(tetrahedra > all * 9 / 10, "{tetrahedra} of {all}");
    }
}

/// The exponential function over all of its range, by values and by exponents.
#[test]
fn the_exponential_has_the_bits_of_libm() {
    let mut random = Random::new(17);
    let some = (0..1_000_000).map(|k| match k % 2 {
        0 => random.between(-3.8, 0.0),
        _ => -libm::exp2(random.between(-40.0, 1.9)),
    });
    let numbers: Vec<f64> = some.chain([0.0, -0.0, -3.8, -f64::MIN_POSITIVE]).collect();
    let unlike = |build: HostBuild| {
        let mut found = numbers.clone();
        exponentials(&Host(build), &mut found).unwrap();
        numbers.iter().zip(&found).filter(|(x, found)| libm::exp(**x).to_bits() != found.to_bits()).count()
    };
    assert_eq!(unlike(HostBuild::Ascending), 0);
    let fused = unlike(HostBuild::Contracted);
    assert!(fused > 100, "{fused}");
}

/// An end of a joint: near its strength, softened, broken or pressed, and moved in any direction from there.
fn end<const D: usize>(kind: u64, random: &mut Random) -> JointEnd<D> {
    let mut vector = |size: f64| -> [f64; D] { std::array::from_fn(|_| size * random.between(-1.0, 1.0)) };
    let mut normal = vector(if kind.is_multiple_of(3) { 0.7 } else { 0.0 });
    normal[0] = 1.0;
    let long = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let normal = normal.map(|x| x / long);
    let (mut gap, origin, rubbed) = (vector(1.0), vector(1e-8), vector(1e-6));
    let (tensile, cohesion) = (random.between(0.3e6, 2e6), random.between(0.3e6, 6e6));
    let penalty = 1e12 * libm::exp2(random.between(0.0, 6.0));
    let critical = [random.between(2e-6, 3e-5), random.between(2e-6, 3e-5)];
    // The bond of the damage, which may be that of another direction.
    let damage = if kind.is_multiple_of(4) { 0.0 } else { random.uniform() };
    let share = random.uniform();
    let strength = tensile + share * (cohesion - tensile);
    let left = (1.0 - damage) * (1.0 - damage);
    let softened = strength * left / (strength + penalty * damage * critical[0]);
    let (damages, stiffness) = match kind % 4 {
        0 => ([0.0; 2], 1.0),
        1 => ([share, 1.0 - share], 0.0),
        _ => ([damage * (1.0 - share), damage * share], softened),
    };
    // To the strength, or through the softening range; closed in every third.
    let size = match kind % 5 {
        0 | 1 => strength / penalty * (1.0 + 1e-3 * random.between(-1.0, 1.0)),
        2 => strength / penalty * 2.0 * random.uniform(),
        _ => strength / penalty + 1.2 * damage.max(0.1) * critical[0] * random.uniform(),
    };
    let long = gap.iter().map(|x| x * x).sum::<f64>().sqrt();
    gap = gap.map(|x| size * x / long);
    match kind % 7 {
        0 => gap[0] = 0.0,
        1 => gap[1..].fill(0.0),
        2 => gap = origin,
        3 | 4 => gap[0] = -gap[0].abs(),
        _ => {}
    }
    let at_rest = kind.is_multiple_of(2);
    JointEnd {
        law: FlatLaw {
            normal,
            penalty,
            tensile,
            cohesion,
            friction: random.between(0.0, 0.8),
            critical,
            share: 0.0,
            length: 0.0,
            faded: 0.0,
        },
        memory: EndMemory {
            damages,
            stiffness,
            origin: if at_rest { [0.0; D] } else { origin },
            rubbed: if at_rest { [0.0; D] } else { rubbed },
        },
        gap,
        traction: [0.0; D],
    }
}

/// The numbers of an end in the order of the kernels.
fn numbers_of_end<const D: usize>(of: &JointEnd<D>) -> impl Iterator<Item = f64> + use<D> {
    let FlatLaw { normal, penalty, tensile, cohesion, friction, critical, .. } = of.law;
    let EndMemory { damages, stiffness, origin, rubbed } = of.memory;
    let law = normal.into_iter().chain([penalty, tensile, cohesion, friction]).chain(critical);
    let memory = damages.into_iter().chain([stiffness]).chain(origin).chain(rubbed);
    law.chain(memory).chain(of.gap).chain(of.traction)
}

/// Number of ends with other bits on the device. Ends of all kinds soften, rest, slip and stick.
fn unlike_ends<const D: usize>(build: HostBuild, count: u64) -> usize {
    let mut random = Random::new(23);
    let mut ends: Vec<JointEnd<D>> = (0..count).map(|kind| end(kind, &mut random)).collect();
    let mut numbers: Vec<f64> = ends.iter().flat_map(numbers_of_end).collect();
    let before: Vec<EndMemory<D>> = ends.iter().map(|end| end.memory).collect();
    fdem_simulation::soften_ends(&mut ends);
    soften_ends::<D>(&Host(build), &mut numbers).unwrap();
    let softened = ends.iter().zip(&before).filter(|(end, before)| end.memory.damages != before.damages);
    let slipped = ends.iter().zip(&before).filter(|(end, before)| end.memory.rubbed != before.rubbed);
    for count in [softened.count(), slipped.count(), ends.iter().filter(|end| end.traction[0] < 0.0).count()]
    {
        assert!((ends.len() / 10..ends.len() * 9 / 10).contains(&count), "{count} of {}", ends.len());
    }
    let rows = numbers.chunks(9 + 5 * D).zip(&ends);
    let bits = |number: f64| number.to_bits();
    rows.filter(|(found, end)| !numbers_of_end(end).map(bits).eq(found.iter().copied().map(bits))).count()
}

#[test]
fn joints_have_the_bits_of_the_processor() {
    assert_eq!(unlike_ends::<2>(HostBuild::Ascending, 4 * COUNT), 0);
    assert_eq!(unlike_ends::<3>(HostBuild::Ascending, 4 * COUNT), 0);
    for unlike in [unlike_ends::<2>, unlike_ends::<3>] {
        let fused = unlike(HostBuild::Contracted, 50_000);
        assert!(fused > 1000, "{fused}");
    }
}
