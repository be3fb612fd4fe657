//! Flow in the pores of triangles and tetrahedra.

use std::f64::consts::PI;

use crate::common::{assert_close, random};
use fdem_fluid::*;

/// A body with pores.
pub(crate) struct Body<const D: usize, const N: usize> {
    pub(crate) places: Vec<[f64; D]>,
    elements: Vec<PorousElement<N>>,
    material: PorousMaterial<D>,
    liquid: PoreLiquid<D>,
}

impl<const D: usize, const N: usize> Body<D, N> {
    pub(crate) fn matrix(&self, boundaries: Vec<PoreBoundary>, initial: &[f64]) -> PorousMatrix<D, N> {
        let materials = vec![self.material];
        let elements = self.elements.clone();
        PorousMatrix::new(&self.liquid, 1.0, &self.places, elements, materials, boundaries, initial)
            .expect("pores")
    }

    fn vertices(&self, is_of: impl Fn(&[f64; D]) -> bool) -> Vec<u32> {
        (0..self.places.len() as u32).filter(|k| is_of(&self.places[*k as usize])).collect()
    }

    /// A boundary whose pressure is this function of the place.
    fn held(&self, key: u64, vertices: Vec<u32>, pressure: impl Fn(&[f64; D]) -> f64) -> PoreBoundary {
        let factors = vertices.iter().map(|k| pressure(&self.places[*k as usize])).collect();
        PoreBoundary { key, vertices, factors, drive: Drive::Pressure(Schedule::constant(1.0)) }
    }
}

/// A permeability of 1e-14 m² in water of 1 mPa s, and a storage of 1e-10 1/Pa: a diffusivity of 0.1 m²/s.
fn sandstone<const D: usize>() -> PorousMaterial<D> {
    PorousMaterial::isotropic(1e-14, 0.8, 1e-10)
}

/// The unit square of `k` by `k` squares, each of two triangles; vertices inside are moved by a part of them.
pub(crate) fn square(k: u32, moved: f64) -> Body<2, 3> {
    let size = f64::from(k);
    let place = |number: u32| {
        let at = [number % (k + 1), number / (k + 1)];
        let is_inside = at.iter().all(|&at| 0 < at && at < k);
        let by = |axis: u32| if is_inside { moved * (random(2 * number + axis) - 0.5) } else { 0.0 };
        [(f64::from(at[0]) + by(0)) / size, (f64::from(at[1]) + by(1)) / size]
    };
    let mut elements = Vec::new();
    for (j, i) in (0..k).flat_map(|j| (0..k).map(move |i| (j, i))) {
        let a = j * (k + 1) + i;
        let [b, c, d] = [a + 1, a + k + 2, a + k + 1];
        elements.extend([[a, b, c], [a, c, d]].map(|vertices| PorousElement { vertices, material: 0 }));
    }
    let places = (0..(k + 1) * (k + 1)).map(place).collect();
    Body { places, elements, material: sandstone(), liquid: PoreLiquid::WATER }
}

/// The unit cube of `k³` cubes, each of six tetrahedra; vertices inside are moved by a part of them.
fn cube(k: u32, moved: f64) -> Body<3, 4> {
    let number = |[x, y, z]: [u32; 3]| (z * (k + 1) + y) * (k + 1) + x;
    let all = || (0..=k).flat_map(move |z| (0..=k).flat_map(move |y| (0..=k).map(move |x| [x, y, z])));
    let place = |at: [u32; 3]| {
        let is_inside = at.iter().all(|&at| 0 < at && at < k);
        let by = |axis: u32| moved * (random(3 * number(at) + axis) - 0.5);
        [0, 1, 2].map(|axis| {
            let moved = if is_inside { by(axis as u32) } else { 0.0 };
            (f64::from(at[axis]) + moved) / f64::from(k)
        })
    };
    let mut elements = Vec::new();
    for at in all().filter(|at| at.iter().all(|&at| at < k)) {
        // From corner to corner along the three axes in each order.
        for axes in [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            let mut corner = at;
            let mut vertices = [number(at); 4];
            for (vertex, axis) in vertices[1..].iter_mut().zip(axes) {
                corner[axis] += 1;
                *vertex = number(corner);
            }
            elements.push(PorousElement { vertices, material: 0 });
        }
    }
    Body { places: all().map(place).collect(), elements, material: sandstone(), liquid: PoreLiquid::WATER }
}

/// A quarter of a ring of `k` rows from the radius 0.1 to 1.
fn ring(k: u32) -> Body<2, 3> {
    let place = |number: u32| {
        let [i, j] = [number % (k + 1), number / (k + 1)].map(|at| f64::from(at) / f64::from(k));
        let (radius, angle) = (0.1 * 10.0_f64.powf(i), 0.5 * PI * j);
        [radius * angle.cos(), radius * angle.sin()]
    };
    Body { places: (0..(k + 1) * (k + 1)).map(place).collect(), ..square(k, 0.0) }
}

fn is_outer<const D: usize>(place: &[f64; D]) -> bool {
    place.iter().any(|x| *x == 0.0 || *x == 1.0)
}

fn largest_error(found: &[f64], exact: impl Iterator<Item = f64>) -> f64 {
    found.iter().zip(exact).fold(0.0, |most: f64, (found, exact)| most.max((found - exact).abs()))
}

/// A linear pressure, with a permeability that depends on the direction, is steady in any mesh.
fn a_linear_pressure_is_exact<const D: usize, const N: usize>(mut body: Body<D, N>) {
    let slope: [f64; D] = std::array::from_fn(|axis| 1e5 * (3.0 - 2.0 * axis as f64));
    for row in 0..D {
        body.material.permeability[row][row] = 1e-14 / (1.0 + row as f64);
    }
    (body.material.permeability[0][1], body.material.permeability[1][0]) = (3e-15, 3e-15);
    let linear = |place: &[f64; D]| 1e6 + (0..D).map(|axis| slope[axis] * place[axis]).sum::<f64>();
    let surface = body.held(0, body.vertices(is_outer), linear);
    let mut matrix = body.matrix(vec![surface], &[]);
    for _ in 0..12 {
        matrix.advance(100.0).expect("a step");
    }
    let error = largest_error(matrix.pressures(), body.places.iter().map(linear));
    assert!(error < 1e-10 * 1e6, "{error}");
    let k = &body.material.permeability;
    for flow in matrix.flows() {
        for axis in 0..D {
            let exact = -(0..D).map(|of| k[axis][of] * slope[of]).sum::<f64>() / 1e-3;
            assert!((flow[axis] - exact).abs() < 1e-9 * 1e-6, "{} {exact}", flow[axis]);
        }
    }
    let balance = matrix.balance();
    assert!(balance.error().abs() < 1e-12 * balance.moved, "{balance:?}");
}

#[test]
fn a_linear_pressure_is_exact_in_the_plane_and_in_space() {
    a_linear_pressure_is_exact(square(9, 0.9));
    a_linear_pressure_is_exact(cube(4, 0.5));
}

/// The volume through a bar, between two pressures and no flow at its sides.
#[test]
fn a_bar_has_the_flow_of_darcy() {
    let body = cube(3, 0.4);
    let ends = [(0, 0.0, 2e6), (1, 1.0, 5e5)];
    let boundaries =
        ends.map(|(key, end, pressure)| body.held(key, body.vertices(|place| place[0] == end), |_| pressure));
    let mut matrix = body.matrix(boundaries.to_vec(), &[]);
    for _ in 0..20 {
        matrix.advance(10.0).expect("a step");
    }
    let before = matrix.inflow(0).expect("a boundary");
    matrix.advance(10.0).expect("a step");
    let rate = (matrix.inflow(0).expect("a boundary") - before) / 10.0;
    assert_close(rate, 1e-14 / 1e-3 * 1.5e6, 1e-10);
}

#[test]
fn a_liquid_at_rest_has_its_weight() {
    let mut body = square(6, 0.8);
    body.liquid.gravity = [0.0, -10.0];
    let mut matrix = body.matrix(Vec::new(), &vec![1e6; body.places.len()]);
    for _ in 0..20 {
        matrix.advance(1e3).expect("a step");
    }
    let error = largest_error(matrix.pressures(), body.places.iter().map(|[_, y]| 1e6 + 9980.0 * (0.5 - y)));
    // The mean by the storage is that of the undeformed mesh, which is not symmetric.
    let shift = matrix.pressures()[0] - (1e6 + 4990.0);
    let rest = body.places.iter().map(|[_, y]| 1e6 + 9980.0 * (0.5 - y) + shift);
    assert!(largest_error(matrix.pressures(), rest) < 1e-9 * 1e6);
    assert!(error < 200.0, "{error}");
    let balance = matrix.balance();
    assert!(balance.error().abs() < 1e-12 * balance.moved, "{balance:?}");
}

/// A column that is drained at x = 0: the largest error of the pressure after a time, and the root of the
/// mean of its square, over the first pressure.
fn column(
    cells: u32,
    initial: impl Fn(f64) -> f64,
    [step, end]: [f64; 2],
    exact: impl Fn(f64) -> f64,
) -> [f64; 2] {
    let body = square(cells, 0.0);
    let outlet = body.held(0, body.vertices(|[x, _]| *x == 0.0), |_| 0.0);
    let pressures: Vec<f64> = body.places.iter().map(|[x, _]| initial(*x)).collect();
    let mut matrix = body.matrix(vec![outlet], &pressures);
    for _ in 0..(end / step).round() as u32 {
        matrix.advance(step).expect("a step");
    }
    let balance = matrix.balance();
    assert!(balance.error().abs() < 1e-12 * balance.moved, "{balance:?}");
    let largest = largest_error(matrix.pressures(), body.places.iter().map(|[x, _]| exact(*x)));
    let square =
        |(([x, _], found), storage): ((&[f64; 2], &f64), &f64)| storage * (found - exact(*x)).powi(2);
    let all = body.places.iter().zip(matrix.pressures()).zip(matrix.storages());
    let mean = all.map(square).sum::<f64>() / matrix.storages().iter().sum::<f64>();
    [largest / 1e6, mean.sqrt() / 1e6]
}

/// `p = p0 Σ 2/m sin(m x) exp(-m² c t)`, `m = (k + 1/2) π` (H. S. Carslaw and J. C. Jaeger, Conduction of
/// Heat in Solids, 1959, section 3.3).
#[test]
fn a_column_drains_as_the_series_says() {
    for time in [0.5, 2.0] {
        let series = |x: f64| {
            let term = |k: u32| {
                let m = (f64::from(k) + 0.5) * PI;
                2.0 / m * (m * x).sin() * (-m * m * 0.1 * time).exp()
            };
            1e6 * (0..40).map(term).sum::<f64>()
        };
        let [error, _] = column(20, |_| 1e6, [2e-3, time], series);
        assert!(error < 0.01, "{time}: {error}");
    }
}

/// The first mode, over that with the same steps of backward Euler: only the error of the mesh is left.
#[test]
fn the_error_falls_with_the_square_of_the_size() {
    let mode = |x: f64| 1e6 * (0.5 * PI * x).sin();
    let decay = (1.0 + 0.25 * PI * PI * 0.1 * 0.1).powi(-20);
    let errors = [8, 16, 32].map(|cells| column(cells, mode, [0.1, 2.0], |x| decay * mode(x))[1]);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "{errors:?}");
    }
}

/// `p = Q μ/(2 π k) ln(R/r)` around a well, a quarter of it here.
#[test]
fn pressure_around_a_well_is_a_logarithm() {
    let body = ring(16);
    let radius = |[x, y]: &[f64; 2]| x.hypot(*y);
    let outer = body.held(0, body.vertices(|place| radius(place) > 0.999), |_| 0.0);
    let at_well = body.vertices(|place| radius(place) < 0.1001);
    let share = |[x, y]: [f64; 2]| if x < 1e-9 || y < 1e-9 { 0.5 / 16.0 } else { 1.0 / 16.0 };
    let factors = at_well.iter().map(|k| share(body.places[*k as usize])).collect();
    let rate = 1e-6;
    let drive = Drive::Rate(Schedule::constant(rate));
    let well = PoreBoundary { key: 1, vertices: at_well, factors, drive };
    let mut matrix = body.matrix(vec![outer, well], &[]);
    for _ in 0..100 {
        matrix.advance(10.0).expect("a step");
    }
    let scale = 4.0 * rate * 1e-3 / (2.0 * PI * 1e-14);
    let exact = body.places.iter().map(|place| -scale * radius(place).ln());
    let error = largest_error(matrix.pressures(), exact) / (scale * 10.0_f64.ln());
    assert!(error < 0.02, "{error}");
    assert_close(matrix.inflow(1).expect("a well"), rate * 1000.0, 1e-12);
    let balance = matrix.balance();
    assert!(balance.error().abs() < 1e-12 * balance.moved, "{balance:?}");
}

/// Without flow the pressure falls by `α M` times the strain of the volume.
#[test]
fn pores_without_flow_follow_the_volume() {
    let mut body = cube(2, 0.5);
    body.material.permeability = [[0.0; 3]; 3];
    let mut matrix = body.matrix(Vec::new(), &vec![1e6; body.places.len()]);
    let volumes: Vec<f64> = body.elements.iter().map(|element| volume_of(&body.places, element)).collect();
    assert_close(volumes.iter().sum(), 1.0, 1e-12);
    let growth: Vec<f64> = volumes.iter().map(|volume| -1e-4 * volume).collect();
    matrix.deform(&growth).expect("growth");
    matrix.advance(1.0).expect("a step");
    let expected = 1e6 + 0.8 * 1e10 * 1e-4;
    assert!(matrix.pressures().iter().all(|found| (found / expected - 1.0).abs() < 1e-12));
    assert!((0..8).all(|element| (matrix.pressure_in(element) / expected - 1.0).abs() < 1e-12));
    matrix.deform(&vec![0.0; growth.len()]).expect("growth");
    assert!(matrix.pressures().iter().all(|found| (found / 1e6 - 1.0).abs() < 1e-12));
}

fn volume_of(places: &[[f64; 3]], element: &PorousElement<4>) -> f64 {
    let [a, b, c, d] = element.vertices.map(|vertex| places[vertex as usize]);
    let edge = |to: [f64; 3]| [0, 1, 2].map(|axis| to[axis] - a[axis]);
    let [u, v, w] = [edge(b), edge(c), edge(d)];
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    (cross[0] * w[0] + cross[1] * w[1] + cross[2] * w[2]).abs() / 6.0
}

/// A body that is pumped, drained and squeezed: its mass, its bits from a saved state and in another order of
/// elements, and its numbers with other numbers of vertices.
#[test]
fn mass_and_bits_are_kept() {
    let body = square(7, 0.9);
    let count = body.places.len() as u32;
    let run = |shuffle: &dyn Fn(u32) -> u32, is_reversed: bool, is_saved: bool| {
        let mut places = body.places.clone();
        (0..count).for_each(|k| places[shuffle(k) as usize] = body.places[k as usize]);
        let mut elements: Vec<PorousElement<3>> = body
            .elements
            .iter()
            .map(|of| PorousElement { vertices: of.vertices.map(shuffle), ..*of })
            .collect();
        let mut growth: Vec<f64> = (0..elements.len() as u32).map(|k| 1e-6 * random(k)).collect();
        if is_reversed {
            elements.reverse();
            growth.reverse();
        }
        let outlet = body.held(4, body.vertices(|[x, _]| *x == 0.0), |[_, y]| 1e5 * y);
        let drive = Drive::Rate(Schedule::table(vec![0.0, 1.0], vec![0.0, 2e-6]));
        let pump = PoreBoundary { key: 2, vertices: vec![30, 31], factors: vec![0.25, 0.75], drive };
        let boundaries: Vec<PoreBoundary> = [outlet, pump]
            .into_iter()
            .map(|of| PoreBoundary { vertices: of.vertices.iter().map(|k| shuffle(*k)).collect(), ..of })
            .collect();
        let make = || {
            PorousMatrix::new(
                &body.liquid,
                1.0,
                &places,
                elements.clone(),
                vec![body.material],
                boundaries.clone(),
                &[],
            )
            .expect("pores")
        };
        let mut matrix = make();
        for step in 0..20 {
            if is_saved && step == 11 {
                let state = matrix.state().clone();
                matrix = make();
                matrix.restore(&state).expect("the state");
            }
            let of_step: Vec<f64> = growth.iter().map(|growth| growth * random(step)).collect();
            matrix.deform(&of_step).expect("growth");
            matrix.advance(if step < 9 { 0.05 } else { 0.1 }).expect("a step");
        }
        let balance = matrix.balance();
        assert!(balance.inflow.abs() > 1e-7 && balance.error().abs() < 1e-12 * balance.moved, "{balance:?}");
        let pressures = matrix.pressures();
        (0..count).map(|k| pressures[shuffle(k) as usize]).collect::<Vec<f64>>()
    };
    let same = |k: u32| k;
    let first = run(&same, false, false);
    assert_eq!(first, run(&same, false, true));
    assert_eq!(first, run(&same, true, false));
    let other = run(&|k| (k * 29 + 5) % count, false, false);
    let most = first.iter().fold(0.0_f64, |most, p| most.max(p.abs()));
    assert!(largest_error(&other, first.iter().copied()) < 1e-11 * most);
    assert!(other != first);
}

#[test]
fn bad_pores_are_refused() {
    let body = square(2, 0.0);
    let refused = |change: &dyn Fn(&mut Body<2, 3>, &mut Vec<PoreBoundary>)| {
        let mut other = square(2, 0.0);
        let mut boundaries = vec![body.held(3, vec![0, 1], |_| 0.0)];
        change(&mut other, &mut boundaries);
        let materials = vec![other.material];
        PorousMatrix::new(&other.liquid, 1.0, &other.places, other.elements, materials, boundaries, &[])
            .map(|_| ())
            .expect_err("bad")
            .to_string()
    };
    assert!(refused(&|body, _| body.material.storage = 0.0).contains("porous material 0: storage"));
    assert!(refused(&|body, _| body.material.biot = 1.5).contains("Biot"));
    assert!(refused(&|body, _| body.material.permeability[0][1] = 1e-15).contains("symmetric"));
    assert!(refused(&|body, _| body.material.permeability = [[1.0, 2.0], [2.0, 1.0]]).contains("symmetric"));
    assert!(refused(&|body, _| body.elements[3].material = 7).contains("element 3"));
    assert!(refused(&|body, _| body.elements[2].vertices[1] = 99).contains("element 2"));
    assert!(refused(&|body, _| body.places[4] = body.places[0]).contains("volume"));
    assert!(refused(&|body, _| body.liquid.viscosity = 0.0).contains("viscosity"));
    assert!(refused(&|_, boundaries| boundaries[0].vertices[0] = 99).contains("boundary 3"));
    assert!(refused(&|_, boundaries| boundaries.push(boundaries[0].clone())).contains("two of boundary 3"));
    // The same pressure in two boundaries is no contradiction.
    let equal = body.held(3, vec![0, 1], |_| 0.0);
    body.matrix(vec![equal.clone(), PoreBoundary { key: 4, ..equal }], &[]);
    let shared = |_: &mut Body<2, 3>, boundaries: &mut Vec<PoreBoundary>| {
        boundaries.push(PoreBoundary { key: 4, factors: vec![1.0; 2], ..boundaries[0].clone() });
    };
    assert!(refused(&shared).contains("boundaries 3 and 4"));
    let mut matrix = body.matrix(Vec::new(), &[]);
    assert!(matrix.advance(0.0).is_err() && matrix.deform(&[0.0]).is_err());
    assert!(matrix.restore(&MatrixState::default()).is_err());
}

#[test]
fn storage_is_that_of_liquid_and_grains() {
    // 0.2/2e9 + 0.5/40e9
    assert_close(PorousMaterial::<2>::storage_of(0.2, 0.7, 2e9, 40e9), 1.125e-10, 1e-12);
    assert_close(PorousMaterial::<2>::isotropic(1e-14, 0.5, 1e-10).undrained_modulus(), 2.5e9, 1e-12);
}
