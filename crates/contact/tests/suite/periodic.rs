//! Periodic boxes: every contact and every image of it, against all shifts one by one.
//!
//! - `buffered`: elements that move.
//! - `lattices`: numbers of contacts that are known without a search.
//! - `laws`: properties of any elements in any box (proptest).

mod buffered;
mod lattices;
mod laws;

use fdem_contact::{
    Couple, Elements, Engine, Error, PeriodicBox, PeriodicCouple, PeriodicSearch, Real, Rows, Simd,
};
use fdem_scenes::random::Random;

use crate::ENGINES;
use crate::oracle::FromF64;

/// One radius for all, or one each.
#[derive(Clone, Copy)]
enum Radii<'a, T> {
    Equal(T),
    Each(&'a [T]),
}

impl<T: Real> Radii<'_, T> {
    fn of(&self, k: usize) -> T {
        match self {
            Self::Equal(radius) => *radius,
            Self::Each(radii) => radii[k],
        }
    }

    fn elements<'a, const D: usize>(&'a self, centres: &'a [[T; D]], tolerance: T) -> Elements<'a, T, D> {
        let elements = match self {
            Self::Equal(radius) => Elements::spheres(centres, *radius),
            Self::Each(radii) => Elements::spheres_with_radii(centres, radii),
        };
        elements.unwrap().with_tolerance(tolerance).unwrap()
    }
}

/// The documented displacement, written out independently.
fn displaced<T: FromF64, const D: usize>(x: &[T; D], shift: &[i32; D], edges: &[[T; D]; D]) -> [T; D] {
    let mut moved = *x;
    for axis in 0..D {
        let mut offset = f64::from(shift[0]) * edges[0][axis].to_f64();
        for edge in 1..D {
            offset += f64::from(shift[edge]) * edges[edge][axis].to_f64();
        }
        moved[axis] = T::from_f64(x[axis].to_f64() + offset);
    }
    moved
}

/// The range of shifts to try along each edge. The volume of the box divided by the area of a face is a
/// height; here it comes from the Gram matrix of the edges, so that no code is shared with the library. One
/// more shift than needed on either side.
fn ranges<T: Real, const D: usize>(cell: &PeriodicBox<T, D>, wrapped: &[[T; D]], reach: f64) -> [i32; D] {
    let edges = cell.edges().map(|edge| edge.map(T::to_f64));
    std::array::from_fn(|a| {
        if !cell.periodic()[a] || wrapped.is_empty() {
            return 0;
        }
        // The part of edge a that is orthogonal to all others.
        let mut basis: Vec<[f64; D]> = Vec::new();
        for b in (0..D).filter(|&b| b != a).chain([a]) {
            let mut rest = edges[b];
            for _ in 0..2 {
                for other in &basis {
                    let along: f64 = (0..D).map(|k| rest[k] * other[k]).sum();
                    (0..D).for_each(|k| rest[k] -= along * other[k]);
                }
            }
            let length = rest.iter().map(|x| x * x).sum::<f64>().sqrt();
            basis.push(rest.map(|x| x / length));
        }
        let normal = basis[D - 1];
        let dot = |x: &[f64; D]| (0..D).map(|k| x[k] * normal[k]).sum::<f64>();
        let height = dot(&edges[a]).abs();
        let heights: Vec<f64> = wrapped.iter().map(|x| dot(&x.map(T::to_f64)) / height).collect();
        let spread =
            heights.iter().fold(f64::MIN, |m, x| m.max(*x)) - heights.iter().fold(f64::MAX, |m, x| m.min(*x));
        assert!(spread < 1.001, "wrapped into the box");
        (reach / height + spread + 1.0).ceil() as i32
    })
}

/// All elements against all images that are near along the first axis, one by one. Images are compared as
/// documented.
fn brute<T: FromF64, const D: usize>(
    centres: &[[T; D]],
    radii: Radii<'_, T>,
    tolerance: T,
    cell: &PeriodicBox<T, D>,
) -> Vec<PeriodicCouple<D>> {
    let mut wrapped = Vec::new();
    let mut periods = Vec::new();
    for centre in centres {
        let (point, n) = cell.wrap(*centre).unwrap();
        let expected = if n == [0; D] { *centre } else { displaced(centre, &n.map(|n| -n), &cell.edges()) };
        assert_eq!(point, expected);
        wrapped.push(point);
        periods.push(n);
    }
    let reach =
        (0..centres.len()).map(|k| 2.0 * radii.of(k).to_f64()).fold(0.0, f64::max) + tolerance.to_f64();
    let range = ranges(cell, &wrapped, reach);
    // Elements further apart than this along the first axis are skipped; the bound is generous, so that
    // rounding is left to the comparison.
    let near = 1.001 * reach + 1e-3;
    let mut order: Vec<usize> = (0..centres.len()).collect();
    order.sort_by(|&a, &b| wrapped[a][0].to_f64().total_cmp(&wrapped[b][0].to_f64()));
    let sorted: Vec<f64> = order.iter().map(|&k| wrapped[k][0].to_f64()).collect();

    let mut couples = Vec::new();
    let mut shift = range.map(|most| -most);
    'shifts: loop {
        for j in 0..centres.len() {
            let image =
                if shift == [0; D] { wrapped[j] } else { displaced(&wrapped[j], &shift, &cell.edges()) };
            let first = sorted.partition_point(|&x| x < image[0].to_f64() - near);
            for &i in &order[first..] {
                if wrapped[i][0].to_f64() > image[0].to_f64() + near {
                    break;
                }
                if i > j || i == j && shift <= [0; D] {
                    continue;
                }
                let mut squares = T::from_f64(0.0);
                for axis in 0..D {
                    let difference = wrapped[i][axis] - image[axis];
                    squares = squares + difference * difference;
                }
                let sum = (radii.of(i) + radii.of(j)) + tolerance;
                if squares <= sum * sum {
                    let shift = std::array::from_fn(|a| shift[a] + periods[i][a] - periods[j][a]);
                    couples.push(PeriodicCouple { i: i as u32, j: j as u32, shift });
                }
            }
        }
        for edge in (0..D).rev() {
            if shift[edge] < range[edge] {
                shift[edge] += 1;
                continue 'shifts;
            }
            shift[edge] = -range[edge];
        }
        break;
    }
    couples.sort_unstable();
    couples
}

fn found<T: Real, const D: usize>(
    engine: impl Into<Option<Engine>>,
    elements: &Elements<'_, T, D>,
    cell: &PeriodicBox<T, D>,
) -> Vec<PeriodicCouple<D>> {
    let engine = engine.into();
    let mut search = PeriodicSearch::new().with_engine(engine);
    let (mut couples, mut again) = (Vec::new(), Vec::new());
    search.couples(elements, cell, &mut couples).unwrap();
    assert_eq!(search.count(elements, cell).unwrap(), couples.len() as u64);
    search.for_each(elements, cell, |couple| again.push(couple)).unwrap();
    assert_eq!(couples, again, "the order is a function of the input");
    if engine == Some(Engine::Rows) {
        PeriodicSearch::new().couples_by(&mut Rows::new(), elements, cell, &mut again).unwrap();
        assert_eq!(couples, again, "another search gives its order");
    }

    let (mut unshifted, mut shifted) = (vec![Couple::new(7, 8)], couples.clone());
    search.couples_by_shift(elements, cell, &mut unshifted, &mut shifted).unwrap();
    let (none, some): (Vec<PeriodicCouple<D>>, Vec<PeriodicCouple<D>>) =
        couples.iter().partition(|couple| couple.shift == [0; D]);
    assert!(none.iter().map(|couple| (couple.i, couple.j)).eq(unshifted.iter().map(|c| (c.i, c.j))));
    assert_eq!(shifted, some);
    let parts = search.fold(elements, cell, Vec::new, Vec::push).unwrap();
    assert_eq!(parts.concat(), couples, "the parts are in order");

    couples.sort_unstable();
    couples
}

/// Compares all engines with brute force; returns the number of couples.
fn compare<T: FromF64, const D: usize>(
    what: &str,
    centres: &[[f64; D]],
    radii: &[f64],
    tolerance: f64,
    cell: &PeriodicBox<T, D>,
) -> usize {
    let centres: Vec<[T; D]> = centres.iter().map(|centre| centre.map(T::from_f64)).collect();
    let radii: Vec<T> = radii.iter().copied().map(T::from_f64).collect();
    let tolerance = T::from_f64(tolerance);
    let first = radii.first().copied().unwrap_or(T::from_f64(0.5));
    let mut n = 0;
    for radii in [Radii::Equal(first), Radii::Each(&radii)] {
        let expected = brute(&centres, radii, tolerance, cell);
        assert!(expected.windows(2).all(|pair| pair[0] < pair[1]), "each contact has one form");
        let elements = radii.elements(&centres, tolerance);
        for engine in ENGINES {
            let found = found(engine, &elements, cell);
            let context = || format!("{what}: {engine:?}, {} elements, {cell:?}", centres.len());
            if found != expected {
                let missing = expected.iter().find(|couple| !found.contains(couple));
                let extra = found.iter().find(|couple| !expected.contains(couple));
                panic!("{}: {missing:?} is missing, {extra:?} is too much", context());
            }
        }
        n += expected.len();
    }
    n
}

/// A rotation in the plane of two axes.
fn rotated<const D: usize>(mut edges: [[f64; D]; D], angle: f64, axes: [usize; 2]) -> [[f64; D]; D] {
    let ([a, b], (sine, cosine)) = (axes, angle.sin_cos());
    for edge in &mut edges {
        (edge[a], edge[b]) = (cosine * edge[a] - sine * edge[b], sine * edge[a] + cosine * edge[b]);
    }
    edges
}

/// Edges of about unit size: cubic, unlike, slightly sheared, sheared by more than an edge, rotated, flat.
fn shapes<const D: usize>() -> Vec<(&'static str, [[f64; D]; D])> {
    let diagonal = |length: fn(usize) -> f64| -> [[f64; D]; D] {
        std::array::from_fn(|a| std::array::from_fn(|b| if a == b { length(a) } else { 0.0 }))
    };
    let sheared = |tilt: f64| -> [[f64; D]; D] {
        std::array::from_fn(|a| {
            std::array::from_fn(|b| match a.cmp(&b) {
                std::cmp::Ordering::Equal => 1.0,
                std::cmp::Ordering::Greater => tilt * if (a + b) % 2 == 0 { -0.7 } else { 1.0 },
                std::cmp::Ordering::Less => 0.0,
            })
        })
    };
    if D == 1 {
        return vec![("a line", diagonal(|_| 1.0))];
    }
    let swapped = |mut edges: [[f64; D]; D]| {
        edges.swap(0, D - 1);
        edges
    };
    let last = [0, D - 1];
    vec![
        ("cubic", diagonal(|_| 1.0)),
        ("unlike", diagonal(|a| [1.0, 0.6, 1.7][a])),
        ("sheared", sheared(0.4)),
        ("left-handed", swapped(diagonal(|a| [1.0, 0.6, 1.7][a]))),
        ("left-handed and sheared", swapped(sheared(0.4))),
        ("reversed", sheared(0.5).map(|edge| edge.map(|x| -x))),
        ("half a tilt", sheared(0.5)),
        ("tilt of 1.5", sheared(1.5)),
        ("tilt of -3.2", sheared(-3.2)),
        ("rotated", rotated(rotated(diagonal(|_| 1.0), 0.7, [0, 1]), -0.4, last)),
        ("rotated and sheared", rotated(rotated(sheared(1.2), 2.5, [0, 1]), 1.1, last)),
        ("a rhombus", {
            let mut edges = diagonal(|_| 1.0);
            edges[1][0] = -0.5;
            edges[1][1] = 0.75_f64.sqrt();
            edges
        }),
    ]
}

fn periodicities<const D: usize>() -> Vec<[bool; D]> {
    (0..1_u32 << D).map(|bits| std::array::from_fn(|axis| bits >> axis & 1 == 1)).collect()
}

fn scaled<T: FromF64, const D: usize>(edges: [[f64; D]; D], scale: f64) -> [[T; D]; D] {
    edges.map(|edge| edge.map(|x| T::from_f64(x * scale)))
}

/// The point with these fractions of the edges.
fn at<T: Real, const D: usize>(edges: &[[T; D]; D], origin: f64, fractions: [f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| origin + (0..D).map(|a| fractions[a] * edges[a][axis].to_f64()).sum::<f64>())
}

fn all_boxes<T: FromF64, const D: usize>() {
    let mut random = Random::new(7);
    let mut couples = 0;
    // A box has all of the sizes on a line or if the test is thorough, otherwise some of them, in turn.
    let step = if crate::thorough() { 1 } else { [1, 2, 4][D.min(3) - 1] };
    for (s, (shape, edges)) in shapes::<D>().into_iter().enumerate() {
        for (p, periodic) in periodicities::<D>().into_iter().enumerate() {
            // In units of the cut-off of the larger elements, which is 1.
            for size in [4.0, 1.7, 0.9, 0.45].into_iter().skip((s + p) % step).step_by(step) {
                let edges = scaled::<T, D>(edges, size);
                for (n, origin, outside) in
                    [(0, 0.0, 1.0), (1, 0.0, 1.0), (2, -3.3, 3.0), (10, 5.5, 1.0), (20, -2.0, 40.0)]
                {
                    // With thousands of images per element, a few elements suffice.
                    if n == 20 && size < 0.9 {
                        continue;
                    }
                    let cell = PeriodicBox::triclinic([T::from_f64(origin); D], edges, periodic).unwrap();
                    let centres: Vec<[f64; D]> = (0..n)
                        .map(|_| {
                            let from = 0.5 - outside / 2.0;
                            at(&edges, origin, std::array::from_fn(|_| random.between(from, from + outside)))
                        })
                        .collect();
                    let radii: Vec<f64> =
                        (0..n).map(|k| if k == 0 { 0.5 } else { random.between(0.0, 0.5) }).collect();
                    couples += compare(shape, &centres, &radii, 0.0, &cell);
                }
            }
        }
    }
    assert!(couples > 1000, "the boxes have couples to lose: {couples}");
}

/// Elements on corners, edges and faces, and on either side of them, where rounding matters; all in one
/// place; with a tolerance.
fn on_the_faces<T: FromF64, const D: usize>() {
    let mut random = Random::new(11);
    let mut turns = 0..;
    for (shape, edges) in shapes::<D>() {
        for (size, periodic) in
            [(3.0, [true; D]), (1.0, [true; D]), (0.7, std::array::from_fn(|axis| axis != 0))]
        {
            let edges = scaled::<T, D>(edges, size);
            // A box in space has one of the origins, in turn, if the test is not thorough.
            let step = if D < 3 || crate::thorough() { 1 } else { 3 };
            for origin in [0.0, 0.1, -1000.7].into_iter().skip(turns.next().unwrap() % step).step_by(step) {
                let cell = PeriodicBox::triclinic([T::from_f64(origin); D], edges, periodic).unwrap();
                let fraction = |random: &mut Random| {
                    [0.0, 1.0, 0.5, -1.0, 2.0, 1.0 - 1e-16, -1e-17, 1e-9, -1e-9, 3e-8]
                        [random.below(10) as usize]
                };
                let centres: Vec<[f64; D]> = (0..20)
                    .map(|_| at(&edges, origin, std::array::from_fn(|_| fraction(&mut random))))
                    .collect();
                compare(shape, &centres, &[0.5; 20], 0.0, &cell);
                compare(shape, &centres, &[0.25; 20], 0.5, &cell);
                compare(shape, &centres, &[0.0; 20], 0.0, &cell);
                let n = compare(shape, &[centres[0]; 12], &[0.5; 12], 0.0, &cell);
                assert!(n >= 2 * 66, "all in one place");
            }
        }
    }
}

/// Elements thousands of periods apart, with faces of the box between them.
fn far_outside<T: FromF64, const D: usize>() {
    let mut random = Random::new(13);
    for (shape, edges) in shapes::<D>() {
        let edges = scaled::<T, D>(edges, 3.0);
        let cell = PeriodicBox::triclinic([T::from_f64(0.3); D], edges, [true; D]).unwrap();
        let centres: Vec<[f64; D]> = (0..60)
            .map(|_| at(&edges, 0.3, std::array::from_fn(|_| random.between(-9000.0, 9000.0))))
            .collect();
        assert!(compare(shape, &centres, &[0.5; 60], 0.0, &cell) > 0);
    }
}

fn three_hundred<T: FromF64, const D: usize>() {
    let mut random = Random::new(17);
    for (shape, edges) in shapes::<D>() {
        let edges = scaled::<T, D>(edges, 6.0);
        for periodic in [[true; D], std::array::from_fn(|axis| axis + 1 != D), [false; D]] {
            let cell = PeriodicBox::triclinic([T::from_f64(-17.0); D], edges, periodic).unwrap();
            let centres: Vec<[f64; D]> =
                (0..300).map(|_| at(&edges, -17.0, std::array::from_fn(|_| random.uniform()))).collect();
            let radii: Vec<f64> = (0..300).map(|_| random.between(0.1, 0.5)).collect();
            assert!(compare(shape, &centres, &radii, 0.0, &cell) > 100);
        }
    }
}

/// Boxes so large that most elements are far from all faces, and those near a face are searched separately.
fn large_boxes<T: FromF64, const D: usize>() {
    let mut random = Random::new(19);
    let (n, size, kinds) = [(60, 20.0, 1), (500, 24.0, 9), (700, 30.0, 4)][D - 1];
    let mut apart = 0;
    for (shape, edges) in shapes::<D>().into_iter().take(kinds) {
        let edges = scaled::<T, D>(edges, size);
        let some: [bool; D] = std::array::from_fn(|axis| axis != 0);
        for (periodic, outside) in [([true; D], 1.0), ([true; D], 1.0 + 1e-9), (some, 3.0)] {
            let cell = PeriodicBox::triclinic([T::from_f64(-1.5); D], edges, periodic).unwrap();
            let centres: Vec<[f64; D]> = (0..n)
                .map(|_| {
                    let from = 0.5 - outside / 2.0;
                    at(&edges, -1.5, std::array::from_fn(|_| random.between(from, from + outside)))
                })
                .collect();
            let radii: Vec<f64> =
                (0..n).map(|k| if k == 0 { 0.5 } else { random.between(0.1, 0.5) }).collect();
            compare(shape, &centres, &radii, 0.0, &cell);
            let centres: Vec<[T; D]> = centres.iter().map(|centre| centre.map(T::from_f64)).collect();
            let mut search = PeriodicSearch::new();
            search.count(&Elements::spheres(&centres, T::HALF).unwrap(), &cell).unwrap();
            apart += usize::from(search.images() > 0 && 4 * search.images() <= n);
        }
    }
    assert!(apart >= 2, "{apart} boxes are large");
}

/// Axis-aligned boxes against all images of boxes; both corners are displaced, as documented.
fn aligned_boxes<T: FromF64, const D: usize>() {
    let mut random = Random::new(29);
    let mut couples = 0;
    let sizes: &[f64] = if D < 3 { &[0.7, 3.0, 25.0] } else { &[0.7, 3.0] };
    for (shape, edges) in shapes::<D>() {
        for (&size, periodic) in sizes
            .iter()
            .flat_map(|size| periodicities::<D>().into_iter().map(move |periodic| (size, periodic)))
        {
            let edges = scaled::<T, D>(edges, size);
            let cell = PeriodicBox::triclinic([T::from_f64(0.3); D], edges, periodic).unwrap();
            let n = if size < 1.0 {
                4
            } else if size < 10.0 {
                12
            } else {
                150
            };
            let outside = if random.below(2) == 0 { 1.0 } else { 5.0 };
            let (mut min, mut max) = (Vec::new(), Vec::new());
            for _ in 0..n {
                let from = 0.5 - outside / 2.0;
                let corner = at(&edges, 0.3, std::array::from_fn(|_| random.between(from, from + outside)));
                let corner: [T; D] = corner.map(T::from_f64);
                min.push(corner);
                max.push(corner.map(|x| T::from_f64(x.to_f64() + random.between(0.0, 1.0))));
            }
            for tolerance in [0.0, 0.25].map(T::from_f64) {
                let expected = brute_boxes(&min, &max, tolerance, &cell);
                couples += expected.len();
                let elements = Elements::boxes(&min, &max).unwrap().with_tolerance(tolerance).unwrap();
                for engine in ENGINES {
                    assert!(
                        found(engine, &elements, &cell) == expected,
                        "{shape}, {engine:?}, {n} boxes, {cell:?}"
                    );
                }
            }
        }
    }
    assert!(couples > 100, "there are couples to lose: {couples}");
}

fn brute_boxes<T: FromF64, const D: usize>(
    min: &[[T; D]],
    max: &[[T; D]],
    tolerance: T,
    cell: &PeriodicBox<T, D>,
) -> Vec<PeriodicCouple<D>> {
    let edges = cell.edges();
    let moved = |point: &[T; D], shift: [i32; D]| {
        if shift == [0; D] { *point } else { displaced(point, &shift, &edges) }
    };
    let periods: Vec<[i32; D]> = min.iter().map(|corner| cell.wrap(*corner).unwrap().1).collect();
    let wrap = |corners: &[[T; D]]| -> Vec<[T; D]> {
        corners.iter().zip(&periods).map(|(corner, n)| moved(corner, n.map(|n| -n))).collect()
    };
    let (min, max) = (wrap(min), wrap(max));
    let longest =
        min.iter().zip(&max).flat_map(|(min, max)| (0..D).map(|k| max[k].to_f64() - min[k].to_f64()));
    let reach = longest.fold(0.0, f64::max) + tolerance.to_f64();
    let range = ranges(cell, &min, reach * (D as f64).sqrt());
    let mut couples = Vec::new();
    for k in 0..range.iter().map(|most| 2 * most + 1).product::<i32>() {
        let mut rest = k;
        let shift = range.map(|most| {
            let digit = rest % (2 * most + 1) - most;
            rest /= 2 * most + 1;
            digit
        });
        for j in 0..min.len() {
            let (low, high) = (moved(&min[j], shift), moved(&max[j], shift));
            for i in (0..=j).filter(|&i| i < j || shift > [0; D]) {
                if (0..D).all(|k| min[i][k] <= high[k] + tolerance && low[k] <= max[i][k] + tolerance) {
                    let shift = std::array::from_fn(|a| shift[a] + periods[i][a] - periods[j][a]);
                    couples.push(PeriodicCouple { i: i as u32, j: j as u32, shift });
                }
            }
        }
    }
    couples.sort_unstable();
    couples
}

macro_rules! hazards {
    ($($name:ident: $type:ty, $dimensions:literal;)*) => {
        $(
            mod $name {
                #[test]
                fn all_boxes() {
                    super::all_boxes::<$type, $dimensions>();
                }

                #[test]
                fn on_the_faces() {
                    super::on_the_faces::<$type, $dimensions>();
                }

                #[test]
                fn far_outside() {
                    super::far_outside::<$type, $dimensions>();
                }

                #[test]
                fn large_boxes() {
                    super::large_boxes::<$type, $dimensions>();
                }

                #[test]
                fn aligned_boxes() {
                    super::aligned_boxes::<$type, $dimensions>();
                }

                #[test]
                fn three_hundred() {
                    super::three_hundred::<$type, $dimensions>();
                }
            }
        )*
    };
}

hazards! { f64_1d: f64, 1; f64_2d: f64, 2; f64_3d: f64, 3; f32_2d: f32, 2; f32_3d: f32, 3; }

#[test]
fn elements_outside_are_refused_if_asked_for() {
    let cell = PeriodicBox::orthogonal([0.0, 0.0], [3.0, 3.0], [true, false]).unwrap();
    let count = |centres: &[[f64; 2]]| {
        let elements = Elements::spheres(centres, 0.5).unwrap();
        PeriodicSearch::new().refuse_outside().count(&elements, &cell)
    };
    assert_eq!(count(&[[0.0, 0.0], [3.0, 0.5]]), Ok(1), "faces belong to the box");
    assert_eq!(count(&[[1.0, -70.0], [1.0, 70.0]]), Ok(0), "nothing is outside where nothing repeats");
    let error = count(&[[1.0, 1.0], [1.0, 2.0], [3.5, 1.0]]).unwrap_err();
    assert_eq!(error.element(), Some(2));
    assert!(matches!(error, Error::OutsideBox { edge: 0, .. }), "{error}");
}

#[test]
fn what_cannot_be_searched_is_refused_with_the_reason() {
    let cell = |edge: f64| PeriodicBox::orthogonal([0.0; 3], [edge; 3], [true; 3]).unwrap();
    let count = |centres: &[[f64; 3]], cell| {
        PeriodicSearch::new().count(&Elements::spheres(centres, 0.5).unwrap(), &cell)
    };
    let Err(Error::TooManyImages { images, .. }) = count(&[[0.0; 3]], cell(1e-4)) else {
        panic!("too many images")
    };
    assert!((8e12..8.1e12).contains(&images), "{images}");
    let elements = [[0.0; 3]];
    let mut few = PeriodicSearch::new().with_max_images(25);
    let elements = Elements::spheres(&elements, 0.5).unwrap();
    assert_eq!(few.count(&elements, &cell(1.0)), Err(Error::TooManyImages { images: 26.0, limit: 25 }));
    assert_eq!(few.with_max_images(26).count(&elements, &cell(1.0)), Ok(3));

    let error = count(&[[0.0; 3], [1e12, 0.0, 0.0]], cell(5.0)).unwrap_err();
    assert!(matches!(error, Error::TooFarFromBox { index: 1, edge: 0, .. }), "{error}");
    let leaning = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 1.0]];
    let leaning = PeriodicBox::triclinic([0.0; 3], leaning, [false, true, false]).unwrap();
    assert_eq!(count(&[[0.0; 3], [0.5, 1e6, 0.5]], leaning), Ok(3));
    let leaning = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let leaning = PeriodicBox::triclinic([0.0; 3], leaning, [true, false, false]).unwrap();
    let error = count(&[[0.0; 3], [1e17, 1e17, 0.0]], leaning).unwrap_err();
    assert!(matches!(error, Error::UnresolvedBox { edge: 0, .. }), "{error}");
}

/// One order for any number of threads and any vector instructions, in a large box and in one with many
/// images; some elements are outside.
#[test]
fn threads_and_vectors_change_nothing() {
    let mut random = Random::new(31);
    for (n, width) in [(30_000, 60.0), (3000, 10.0)] {
        let centres: Vec<[f64; 3]> =
            (0..n).map(|_| std::array::from_fn(|_| random.between(-0.5, width))).collect();
        let cell = PeriodicBox::orthogonal([0.0; 3], [width; 3], [true; 3]).unwrap();
        let elements = Elements::points(&centres, 1.0).unwrap();
        let all_ways = |simd, threads| {
            let search = PeriodicSearch::new().with_engine(Engine::Rows).with_threads(threads).unwrap();
            let mut search = search.with_simd(simd).unwrap();
            let (mut list, mut visited) = (Vec::new(), Vec::new());
            search.couples(&elements, &cell, &mut list).unwrap();
            search.for_each(&elements, &cell, |couple| visited.push(couple)).unwrap();
            assert!(list == visited, "{simd}, {threads} threads");
            assert_eq!(search.count(&elements, &cell).unwrap(), list.len() as u64);
            let parts = search.fold(&elements, &cell, Vec::new, Vec::push).unwrap();
            assert!(parts.concat() == list, "{simd}, {threads} threads");
            (list, parts.len(), search.images())
        };
        let expected = all_ways(Simd::Portable, 1);
        assert!(expected.0.iter().any(|couple| couple.shift != [0; 3]) && expected.1 > 1);
        assert_eq!(4 * expected.2 <= n, width > 30.0);
        for simd in Simd::available() {
            for threads in [1, 2, 3] {
                if cfg!(feature = "rayon") || threads == 1 {
                    assert!(all_ways(simd, threads) == expected, "{simd}, {threads} threads");
                }
            }
        }
    }
}

/// Without periodic edges the search equals one without a box.
#[test]
fn a_box_without_periodic_edges_is_no_box() {
    let mut random = Random::new(3);
    let centres: Vec<[f32; 2]> =
        (0..500).map(|_| std::array::from_fn(|_| random.between(-10.0, 10.0) as f32)).collect();
    let cell = PeriodicBox::orthogonal([0.0; 2], [1.0; 2], [false; 2]).unwrap();
    let open = fdem_contact::couples_within(&centres, 1.0).unwrap();
    let found = found(None, &Elements::points(&centres, 1.0).unwrap(), &cell);
    let expected: Vec<_> =
        open.iter().map(|couple| PeriodicCouple { i: couple.i, j: couple.j, shift: [0, 0] }).collect();
    assert_eq!(found, expected);
}
