//! Properties of any elements in any box (proptest).

use fdem_contact::{Elements, Engine, PeriodicBox, PeriodicCouple, PeriodicSearch};
use proptest::prelude::*;

use super::{ENGINES, Radii, brute, displaced, found};

/// Right-handed edges of small integers, so that all arithmetic below is exact.
fn edges() -> impl Strategy<Value = [[f64; 3]; 3]> {
    prop::array::uniform3(prop::array::uniform3(-6..7_i32)).prop_filter_map("no volume", |rows| {
        let [a, b, c] = rows;
        let determinant = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]);
        (determinant >= 8).then(|| rows.map(|row| row.map(f64::from)))
    })
}

/// Multiples of 2^-6, so that squares and sums are exact.
fn spheres() -> impl Strategy<Value = (Vec<[f64; 3]>, Vec<f64>)> {
    let coordinate = || (-2000..2000_i32).prop_map(|k| f64::from(k) / 64.0);
    let radius = (0..96_i32).prop_map(|k| f64::from(k) / 64.0);
    prop::collection::vec(([coordinate(), coordinate(), coordinate()], radius), 0..24)
        .prop_map(|spheres| spheres.into_iter().unzip())
}

fn of_spheres(centres: &[[f64; 3]], radii: &[f64], cell: &PeriodicBox<f64, 3>) -> Vec<PeriodicCouple<3>> {
    found(Engine::Rows, &Elements::spheres_with_radii(centres, radii).unwrap(), cell)
}

/// The canonical form, sorted.
fn canonical(mut couples: Vec<PeriodicCouple<3>>) -> Vec<PeriodicCouple<3>> {
    for couple in &mut couples {
        if couple.i > couple.j || (couple.i == couple.j && couple.shift < [0; 3]) {
            *couple = PeriodicCouple { i: couple.j, j: couple.i, shift: couple.shift.map(|s| -s) };
        }
    }
    couples.sort_unstable();
    couples
}

proptest! {
    #![proptest_config(crate::cases(128))]

    #[test]
    fn equals_brute_force(edges in edges(), (centres, radii) in spheres(), periodic in prop::array::uniform3(any::<bool>())) {
        let cell = PeriodicBox::triclinic([0.5; 3], edges, periodic).unwrap();
        let expected = brute(&centres, Radii::Each(&radii), 0.0, &cell);
        for engine in ENGINES {
            let found = found(engine, &Elements::spheres_with_radii(&centres, &radii).unwrap(), &cell);
            prop_assert_eq!(&found, &expected);
        }
    }

    /// Each element moved by whole edges: the shifts change by these, and nothing else changes. All moved
    /// alike: nothing changes.
    #[test]
    fn moving_by_whole_edges(
        edges in edges(),
        (centres, radii) in spheres(),
        steps in prop::collection::vec(prop::array::uniform3(-50..50_i32), 24),
    ) {
        let cell = PeriodicBox::triclinic([0.25; 3], edges, [true; 3]).unwrap();
        let couples = of_spheres(&centres, &radii, &cell);
        let alike: Vec<_> = centres.iter().map(|centre| displaced(centre, &steps[0], &edges)).collect();
        prop_assert_eq!(&of_spheres(&alike, &radii, &cell), &couples);

        let apart: Vec<_> = centres.iter().zip(&steps).map(|(centre, step)| displaced(centre, step, &edges)).collect();
        let expected = couples.iter().map(|couple| {
            let (i, j) = (couple.i as usize, couple.j as usize);
            let shift = std::array::from_fn(|a| couple.shift[a] + steps[i][a] - steps[j][a]);
            PeriodicCouple { shift, ..*couple }
        });
        prop_assert_eq!(of_spheres(&apart, &radii, &cell), canonical(expected.collect()));
    }

    /// Elements that the caller wraps give the same couples as elements that the search wraps; the shifts
    /// differ by the periods.
    #[test]
    fn wrapping_beforehand(edges in edges(), (centres, radii) in spheres()) {
        let cell = PeriodicBox::triclinic([0.0; 3], edges, [true, true, false]).unwrap();
        let (wrapped, periods): (Vec<_>, Vec<_>) = centres.iter().map(|centre| cell.wrap(*centre).unwrap()).unzip();
        let expected = of_spheres(&wrapped, &radii, &cell).into_iter().map(|couple| {
            let (i, j) = (couple.i as usize, couple.j as usize);
            let shift = std::array::from_fn(|a| couple.shift[a] + periods[i][a] - periods[j][a]);
            PeriodicCouple { shift, ..couple }
        });
        prop_assert_eq!(of_spheres(&centres, &radii, &cell), canonical(expected.collect()));
    }

    /// Another basis of the same lattice, with the first edge added to the second: the same contacts with
    /// other shifts.
    #[test]
    fn another_basis(edges in edges(), (centres, radii) in spheres(), times in -3..4_i32) {
        let cell = PeriodicBox::triclinic([0.0; 3], edges, [true; 3]).unwrap();
        let mut other = edges;
        for axis in 0..3 {
            other[1][axis] += f64::from(times) * edges[0][axis];
        }
        let other = PeriodicBox::triclinic([0.0; 3], other, [true; 3]).unwrap();
        let expected = of_spheres(&centres, &radii, &other).into_iter().map(|couple| {
            let [a, b, c] = couple.shift;
            PeriodicCouple { shift: [a + times * b, b, c], ..couple }
        });
        prop_assert_eq!(of_spheres(&centres, &radii, &cell), canonical(expected.collect()));
    }

    /// Arbitrary floats: all engines give the same couples or a typed error.
    #[test]
    fn any_floats_give_couples_or_an_error(
        edges in prop::array::uniform2(prop::array::uniform2(any::<f32>())),
        centres in prop::collection::vec(prop::array::uniform2(any::<f32>()), 0..6),
        radius in any::<f32>(),
    ) {
        let Ok(cell) = PeriodicBox::triclinic([0.0; 2], edges, [true; 2]) else { return Ok(()) };
        let Ok(elements) = Elements::spheres(&centres, radius) else { return Ok(()) };
        let mut search = PeriodicSearch::new().with_max_images(1000);
        if let Ok(count) = search.count(&elements, &cell) {
            prop_assert_eq!(search.count(&elements, &cell), Ok(count));
            let told = search.explain(&elements, &cell).unwrap();
            prop_assert_eq!((told.couples, told.couples_error), (count as f64, 0.0));
        }
    }
}
