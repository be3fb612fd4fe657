use fdem_fluid::*;

use crate::common::*;

/// Length of a step after which all is steady, s.
const LONG: f64 = 1e9;

/// `Q = a³ b Δp/(12 μ L)` between the centres of the first and the last cell.
#[test]
fn steady_flow_follows_the_cubic_law() {
    let (count, length, opening, thickness) = (21, 0.02, 2e-4, 0.3);
    let mesh = chain(count, length, opening, [0.6, 0.8]);
    let between = length * f64::from(count - 1);
    let conductance = opening.powi(3) * thickness / (12.0 * 1e-3 * between);
    let model = |fluid| FlowModel { thickness, ..FlowModel::new(fluid) };
    let sources = || vec![held(1, &[0], 3e6), held(2, &[20], 1e6)];

    let mut network = mesh.network(model(stiff()), sources());
    network.advance(LONG).expect("a step");
    assert_close(network.injection(1).expect("a source").rate, conductance * 2e6, 1e-10);
    assert_close(network.injection(2).expect("a source").rate, -conductance * 2e6, 1e-10);
    for (k, pressure) in network.pressures().into_iter().enumerate() {
        assert_close(pressure, 3e6 - 1e5 * k as f64, 1e-10);
    }
    assert_eq!(network.flows().len(), 20);
    network.flows().iter().for_each(|flow| assert_close(flow.rate, conductance * 2e6, 1e-10));

    // In a soft fluid the mass flow is that of ∫ρ dp = K (ρ1 - ρ2).
    let fluid = liquid(1e8);
    let mut network = mesh.network(model(fluid), sources());
    // Densities of links are those before the step.
    advance(&mut network, 8, LONG);
    let [dense, light] = [3e6, 1e6].map(|pressure| fluid.state.density(pressure));
    let exact = conductance * 1e8 * (dense - light) / 1000.0;
    assert_close(network.injection(2).expect("a source").rate, -exact, 1e-10);
}

/// Cells in series: the resistances `l/K` of all halves add up.
#[test]
fn resistances_in_series_add_up() {
    let mut mesh = chain(10, 0.02, 2e-4, [1.0, 0.0]);
    mesh.shapes[5..].iter_mut().for_each(|shape| shape.opening = 5e-5);
    let permeance = |opening: f64| opening.powi(3) / (12.0 * 1e-3);
    let resistance = 0.09 / permeance(2e-4) + 0.09 / permeance(5e-5);
    let mut network = mesh.network(FlowModel::new(stiff()), vec![held(1, &[0], 2e6), held(2, &[9], 0.0)]);
    network.advance(LONG).expect("a step");
    assert_close(network.injection(1).expect("a source").rate, 2e6 / resistance, 1e-10);
}

/// Four cells at a corner: the corner has the mean pressure by conductances, and flows add up to zero.
#[test]
fn a_crossing_shares_flow_by_conductance() {
    let ends = [[1.0, 0.0], [0.0, 0.5], [-0.7, 0.0], [0.0, -0.9]];
    let lengths = [1.0, 0.5, 0.7, 0.9];
    let openings = [1e-4, 2e-4, 1.5e-4, 3e-4];
    let pressures = [4e6, 1e6, 2e6, 5e5];
    let mesh = Mesh {
        cells: (0..4).map(|k| cell(u64::from(k), [100, k])).collect(),
        shapes: (0..4).map(|k| shape([[0.0; 2], ends[k]], openings[k])).collect(),
    };
    let sources = (0..4).map(|k| held(k, &[k], pressures[k as usize])).collect();
    let mut network = mesh.network(FlowModel::new(stiff()), sources);
    network.advance(1.0).expect("a step");
    let conductance = |k: usize| openings[k].powi(3) / (12.0 * 1e-3 * 0.5 * lengths[k]);
    let sum = |value: &dyn Fn(usize) -> f64| (0..4).map(value).sum::<f64>();
    let corner = sum(&|k| conductance(k) * pressures[k]) / sum(&conductance);
    let mut total = 0.0;
    for k in 0..4 {
        let mut out = 0.0;
        for flow in network.flows() {
            let sign = f64::from(u8::from(flow.cells[0] == k)) - f64::from(u8::from(flow.cells[1] == k));
            out += sign * flow.rate;
        }
        let exact = conductance(k as usize) * (pressures[k as usize] - corner);
        assert_close(out, exact, 1e-10);
        total += out;
    }
    assert!(total.abs() < 1e-15 * conductance(3) * 4e6, "{total:e}");
}

/// The complementary error function, by its integral with Simpson's rule.
fn erfc(x: f64) -> f64 {
    let steps = 2000;
    let h = x / f64::from(steps);
    let value = |k: u32| (-(h * f64::from(k)).powi(2)).exp();
    let weight = |k: u32| if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    let integral = (0..=steps).map(|k| weight(k) * value(k)).sum::<f64>() * h / 3.0;
    1.0 - 2.0 / std::f64::consts::PI.sqrt() * integral
}

/// Largest error of the pressure after a step of it at one end, as a part of that step: `p0 erfc(x/(2 √(D
/// t)))`. Cells of 1/`cells` of a length of 1 m, in 1.6 m, up to a depth √(D t) of 0.2 m.
fn transient_error(cells: u32, steps: u32, scheme: Scheme) -> f64 {
    let (opening, modulus, pressure) = (1e-5, 2.2e9, 1e3);
    let diffusivity = modulus * opening * opening / (12.0 * 1e-3);
    let time = 0.2 * 0.2 / diffusivity;
    let h = 1.0 / f64::from(cells);
    let count = cells * 16 / 10;
    let mesh = chain(count, h, opening, [1.0, 0.0]).full(0.0);
    let model = FlowModel { scheme, ..FlowModel::new(liquid(modulus)) };
    let mut network = mesh.network(model, vec![held(1, &[0], pressure)]);
    for _ in 0..steps {
        network.advance(time / f64::from(steps)).expect("a step");
    }
    let error = |(k, found): (usize, f64)| {
        let exact = erfc(h * k as f64 / (2.0 * (diffusivity * time).sqrt()));
        (found / pressure - exact).abs()
    };
    network.pressures().into_iter().enumerate().map(error).fold(0.0, f64::max)
}

#[test]
fn a_step_of_the_pressure_spreads_by_diffusion() {
    let error = transient_error(100, 200, Scheme::Implicit);
    assert!(error < 0.01, "{error}");
    let error = transient_error(50, 1, Scheme::Explicit);
    assert!(error < 0.01, "{error}");
}

#[test]
fn errors_are_of_first_order_in_time_and_of_second_in_space() {
    let [coarse, fine] = [50, 100].map(|steps| transient_error(200, steps, Scheme::Implicit));
    let order = (coarse / fine).log2();
    assert!((0.8..1.2).contains(&order), "order {order} in time: {coarse} {fine}");
    // With steps as the square of the cells, the error of both falls by four.
    let [coarse, fine] = [(20, 40), (40, 160)].map(|(n, steps)| transient_error(n, steps, Scheme::Implicit));
    let order = (coarse / fine).log2();
    assert!((1.7..2.3).contains(&order), "order {order} in space: {coarse} {fine}");
    // So falls that of the explicit scheme, whose parts are bounded by the square of the cells.
    let [coarse, fine] = [20, 40].map(|n| transient_error(n, 1, Scheme::Explicit));
    let order = (coarse / fine).log2();
    assert!((1.7..2.3).contains(&order), "order {order} of the explicit scheme: {coarse} {fine}");
}

/// Triangles between circles whose radii grow by a factor, so that all are about equilateral. Vertices are
/// moved by a part of their distance at random.
fn disc(around: u32, rings: u32, moved: f64, opening: f64) -> Mesh<3> {
    let angle = 2.0 * std::f64::consts::PI / f64::from(around);
    let growth = 1.0 + 0.866 * angle;
    let place = |number: u32| {
        let [ring, k] = [number / around, number % around].map(f64::from);
        let by = |axis: u32| {
            let is_inside = number >= around && number < rings * around;
            if is_inside { moved * (random(2 * number + axis) - 0.5) } else { 0.0 }
        };
        let radius = 0.01 * growth.powf(ring + by(0));
        let at = angle * (k + 0.5 * ring + by(1));
        [radius * at.cos(), radius * at.sin(), 0.1]
    };
    let mut mesh = Mesh { cells: Vec::new(), shapes: Vec::new() };
    for (ring, k) in (0..rings).flat_map(|ring| (0..around).map(move |k| (ring, k))) {
        let vertex = |ring: u32, k: u32| ring * around + k % around;
        // The vertex of the next circle that is between `a` and `b`, and the one before.
        let [a, b] = [vertex(ring, k), vertex(ring, k + 1)];
        let [above, before] = [vertex(ring + 1, k), vertex(ring + 1, k + around - 1)];
        for corners in [[a, b, above], [a, above, before]] {
            mesh.cells.push(cell(mesh.cells.len() as u64, corners));
            mesh.shapes.push(shape(corners.map(place), opening));
        }
    }
    mesh
}

/// `p(r) - p(R) = 6 μ Q ln(R/r)/(π a³)`.
#[test]
fn radial_flow_falls_with_the_logarithm_of_the_radius() {
    let (around, rings, opening, rate) = (48, 24, 1e-4, 1e-6);
    for moved in [0.0, 0.4] {
        let mesh = disc(around, rings, moved, opening);
        let per_ring = u64::from(2 * around);
        let last = u64::from(rings - 1) * per_ring;
        let inner: Vec<u64> = (0..per_ring).collect();
        let outer: Vec<u64> = (last..last + per_ring).collect();
        let sources = vec![pumped(1, &inner, rate), held(2, &outer, 1e5)];
        let mut network = mesh.network(FlowModel::new(stiff()), sources);
        network.advance(LONG).expect("a step");
        let pressures = network.pressures();
        // Means over a ring: of the pressure, and of the logarithm of the radius.
        let means = |ring: usize| {
            let all = ring * per_ring as usize..(ring + 1) * per_ring as usize;
            let logarithm = |k: usize| {
                let centre =
                    |axis: usize| mesh.shapes[k].corners.iter().map(|at| at[axis]).sum::<f64>() / 3.0;
                centre(0).hypot(centre(1)).ln()
            };
            let count = per_ring as f64;
            [all.clone().map(|k| pressures[k]).sum::<f64>() / count, all.map(logarithm).sum::<f64>() / count]
        };
        let [[near, r], [far, outer_r]] = [4, 19].map(means);
        let exact = 6.0 * 1e-3 * rate * (outer_r - r) / (std::f64::consts::PI * opening.powi(3));
        assert_close(near - far, exact, 0.02);
    }
}

/// Squares that are cut in halves conduct alike in all directions (the front page of `cell`).
#[test]
fn cut_squares_conduct_alike_in_all_directions() {
    let mesh = sheet(20, 0.0, 1e-4);
    let is_at = |k: usize, side: usize| {
        let [x, y] = [0, 1].map(|axis| mesh.shapes[k].corners.map(|at| at[axis]));
        let is_all =
            |values: [f64; 3], at: f64| values.iter().filter(|value| (**value - at).abs() < 1e-9).count() > 1;
        match side {
            0 => is_all(x, 0.0),
            1 => is_all(x, 0.2),
            2 => is_all(y, 0.0),
            _ => is_all(y, 0.2),
        }
    };
    let side = |side: usize| -> Vec<u64> { (0..800).filter(|k| is_at(*k as usize, side)).collect() };
    for (from, to) in [(0, 1), (2, 3)] {
        let sources = vec![held(1, &side(from), 1e6), held(2, &side(to), 0.0)];
        let mut network = mesh.network(FlowModel::new(stiff()), sources);
        network.advance(LONG).expect("a step");
        // Between the centres of the outermost cells, half a square from the sides.
        let exact = 1e-12 / (12.0 * 1e-3) * 1e6 * 20.0 / 19.0;
        assert_close(network.injection(1).expect("a source").rate, exact, 0.02);
    }
}

/// At rest the pressure is hydrostatic: `ρ g` times the depth.
#[test]
fn fluid_at_rest_is_hydrostatic() {
    let mesh = chain(30, 0.5, 1e-4, [0.6, -0.8]).full(1e5);
    let model = FlowModel { gravity: [0.0, -9.81], ..FlowModel::new(stiff()) };
    let mut network = mesh.network(model, vec![held(1, &[0], 1e5)]);
    network.advance(LONG).expect("a step");
    for (k, pressure) in network.pressures().into_iter().enumerate() {
        assert_close(pressure, 1e5 + 1000.0 * 9.81 * 0.5 * 0.8 * k as f64, 1e-10);
    }
    network.flows().iter().for_each(|flow| assert!(flow.rate.abs() < 1e-16, "{flow:?}"));
}

/// Gravity alone drives `Q = a³ b ρ g/(12 μ)` down a chain with the same pressure at both ends.
#[test]
fn gravity_drives_flow_down() {
    let mesh = chain(10, 0.5, 1e-4, [0.0, -1.0]).full(1e5);
    let model = FlowModel { gravity: [0.0, -9.81], ..FlowModel::new(stiff()) };
    let mut network = mesh.network(model, vec![held(1, &[0], 1e5), held(2, &[9], 1e5)]);
    network.advance(LONG).expect("a step");
    assert_close(network.injection(1).expect("a source").rate, 1e-12 / 12e-3 * 9810.0, 1e-10);
}
