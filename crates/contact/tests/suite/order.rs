//! The order that `RowsInput` and `CrossInput` state, by sorting and comparing everything with everything.

use fdem_contact::{
    Couple, CrossCouple, Elements, Error, Filter, Index, IndexInput, Real, RowCells, Rows, Search,
};
use fdem_scenes::random::Random;

/// The cells of a point along all axes but the first of the cells, the last one first.
fn row_of<T: Real, const D: usize>(cells: &RowCells<D>, point: &[T; D]) -> Vec<i64> {
    let cell = |&axis: &usize| {
        let quotient = (point[axis].to_f64() - cells.origin[axis]) * cells.inverse;
        quotient.round_ties_even() as i64
    };
    cells.axes[1..].iter().rev().map(cell).collect()
}

/// The numbers of points in the order of the cells.
fn sorted<T: Real, const D: usize>(cells: &RowCells<D>, points: &[[T; D]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let along = cells.axes[0];
    order.sort_by(|&a, &b| {
        let rows = row_of(cells, &points[a]).cmp(&row_of(cells, &points[b]));
        rows.then(points[a][along].partial_cmp(&points[b][along]).unwrap()).then(a.cmp(&b))
    });
    order
}

/// The offsets before zero, in lexicographic order, preceded by zero.
fn offsets(axes: usize) -> Vec<Vec<i64>> {
    let mut all = vec![vec![]];
    for _ in 0..axes {
        all = all
            .iter()
            .flat_map(|one: &Vec<i64>| [-1, 0, 1].map(|step| [&one[..], &[step]].concat()))
            .collect();
    }
    let zero = vec![0; axes];
    all.retain(|offset| *offset < zero);
    [vec![zero], all].concat()
}

fn one_set<T: Real, const D: usize>(elements: &Elements<'_, T, D>) -> usize {
    let input = Rows::new().input(elements).unwrap();
    let order = sorted(&input.cells, input.points);
    let rows: Vec<Vec<i64>> = order.iter().map(|&i| row_of(&input.cells, &input.points[i])).collect();
    let mut expected = Vec::new();
    for (p, &i) in order.iter().enumerate() {
        for offset in offsets(D - 1) {
            let row: Vec<i64> = rows[p].iter().zip(&offset).map(|(cell, step)| cell + step).collect();
            let is_own = offset.iter().all(|&step| step == 0);
            for (q, &j) in order.iter().enumerate() {
                if rows[q] == row && (!is_own || q > p) && elements.touch(i, j) {
                    expected.push(Couple::new(i.min(j) as u32, i.max(j) as u32));
                }
            }
        }
    }
    let mut couples = Vec::new();
    Rows::new().couples(elements, &mut couples).unwrap();
    assert_eq!(couples, expected);
    couples.len()
}

fn two_sets<T: Real, const D: usize>(fixed: &Elements<'_, T, D>, moving: &Elements<'_, T, D>) -> usize {
    let mut index_order = Vec::new();
    let input = IndexInput::new(fixed, |cells, points, _| {
        index_order = sorted(&cells, points);
        let along = cells.axes[0];
        let cell = |&i: &usize| {
            let quotient = (points[i][along].to_f64() - cells.origin[along]) * cells.inverse;
            (row_of(&cells, &points[i]), quotient.round_ties_even() as i64)
        };
        let occupied = index_order.chunk_by(|a, b| cell(a) == cell(b)).count();
        Ok::<_, Error>(points.len() as f64 / occupied as f64)
    });
    let input = input.unwrap().unwrap().with(moving).unwrap().unwrap();
    let mut index = Index::new();
    index.build(fixed).unwrap();
    let mut couples = Vec::new();
    index.couples_with(moving, &mut couples).unwrap();
    // Which couples there are is the subject of other tests.
    let mut expected = Vec::new();
    for i in sorted(&input.cells, input.points) {
        let of = |&j: &usize| CrossCouple { i: i as u32, j: j as u32 };
        expected.extend(index_order.iter().map(of).filter(|couple| couples.contains(couple)));
    }
    assert_eq!(couples, expected);
    couples.len()
}

fn orders<T: Real, const D: usize>() {
    let mut random = Random::new(31);
    let of = T::nearest;
    let mut couples = 0;
    for (n, density) in [(1, 1.0), (150, 9.0), (250, 1.0), (250, 0.03)] {
        let width = (f64::from(n) / density).powf(1.0 / D as f64);
        // Half of the coordinates are on a lattice, so that many are equal.
        let mut points = || -> Vec<[T; D]> {
            let mut x = |k: i32| {
                of(if k % 2 == 0 { random.between(0.0, width) } else { random.below(9) as f64 * 0.5 })
            };
            (0..n).map(|k| std::array::from_fn(|_| x(k))).collect()
        };
        let (points, others) = (points(), points());
        let radii: Vec<T> = (0..n).map(|_| of(random.between(0.1, 0.5))).collect();
        let bodies: Vec<u32> = (0..n).map(|k| k as u32 % 4).collect();
        let elements = Elements::points(&points, of(1.0)).unwrap();
        let spheres = Elements::spheres_with_radii(&points, &radii).unwrap();
        couples += one_set(&elements) + one_set(&spheres.with_tolerance(of(0.1)).unwrap());
        couples += one_set(&elements.with_filter(Filter::bodies(&bodies)).unwrap());
        let moving = Elements::points(&others, of(0.7)).unwrap();
        couples += two_sets(&elements, &moving) + two_sets(&spheres, &moving);
        couples += two_sets(&Elements::points(&points, of(0.0)).unwrap(), &moving);
    }
    assert!(couples > 1000, "{couples}");
}

for_all_types! { orders;
    f64_2d: f64, 2; f64_3d: f64, 3; f32_2d: f32, 2; f32_3d: f32, 3;
}
