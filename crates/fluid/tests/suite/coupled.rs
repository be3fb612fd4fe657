use fdem_fluid::*;

use crate::common::*;

/// A chain between walls on springs: the opening is the pressure times a compliance, m/Pa, as in a crack of
/// constant height. The solid takes its step after that of the fluid.
struct Springs {
    mesh: Mesh<2>,
    compliance: f64,
    /// Opening without pressure, m.
    rest: f64,
}

impl Springs {
    /// The shapes at pressures; `split`: the part of the compliance that the fluid counts on.
    fn shapes(&self, pressures: &[f64], split: f64) -> Vec<Shape<2>> {
        let opening = |pressure: f64| self.rest + self.compliance * pressure;
        let shapes = self.mesh.shapes.iter().zip(pressures);
        shapes
            .map(|(of, pressure)| Shape {
                opening: opening(*pressure),
                compliance: split * self.compliance,
                ..*of
            })
            .collect()
    }
}

/// The crack of Perkins, Kern and Nordgren between the walls of [`Springs`]: the opening follows `∂w/∂t =
/// ∂/∂x (w³/(12 μ c) ∂w/∂x)` behind the front, with the flow `q` at the mouth. Ahead of it the crack is dry
/// and open by a part of `W`, because a cell that is closed blocks, and springs do not open it.
///
/// With `D = 1/(12 μ c)`, `W⁵ = q² t/D` and `L W = q t` the opening is `W f(x/L)`, where `(f³ f')' = f/5 - 4
/// ξ f'/5`, `f³ f' = -1` at the mouth, and `f² f' = -4 ξ/5` at the front, which moves with the fluid. Returns
/// the front, `f` at the mouth, and `f` at the front.
fn similarity() -> [f64; 3] {
    // One solution gives others by the stretching `X^(2/3) f(ξ/X)`. From the front at 1 to the mouth by the
    // rule of the midpoint: f, and g = -f³ f', whose derivative is 4 ξ f'/5 - f/5.
    let ahead = 0.3;
    let steps = 10_000;
    let h = 1.0 / f64::from(steps);
    let (mut f, mut g): (f64, f64) = (ahead, 0.8 * ahead);
    let rises = |from_front: f64, f: f64, g: f64| {
        let rise = g / (f * f * f);
        [rise, 0.2 * f + 0.8 * (1.0 - from_front) * rise]
    };
    for step in 0..steps {
        let at = h * f64::from(step);
        let [f1, g1] = rises(at, f, g);
        let [f2, g2] = rises(at + 0.5 * h, f + 0.5 * h * f1, g + 0.5 * h * g1);
        (f, g) = (f + h * f2, g + h * g2);
    }
    // The flow at the mouth is stretched by X^(5/3), to 1.
    let front = g.powf(-0.6);
    let part = front.powf(2.0 / 3.0);
    [front, f * part, ahead * part]
}

#[test]
fn a_crack_between_springs_grows_by_the_similarity_solution() {
    let (rate, compliance, viscosity) = (1e-4, 1e-10, 1e-3);
    let [front, mouth, ahead] = similarity();
    let diffusivity = 1.0 / (12.0 * viscosity * compliance);
    let width = |time: f64| (rate * rate * time / diffusivity).powf(0.2);
    let end = 20.0;
    let length = rate * end / width(end);
    let count = 120;
    let mesh = chain(count, 1.2 * front * length / f64::from(count), 1e-5, [1.0, 0.0]);
    let mut springs = Springs { mesh, compliance, rest: 1e-5 };
    let mut network = springs.mesh.network(FlowModel::new(liquid(2.2e9)), vec![pumped(1, &[0], rate)]);
    let steps = 1000;
    for step in 1..=steps {
        springs.rest = ahead * width(end * f64::from(step) / f64::from(steps));
        network.update(&springs.shapes(&network.pressures(), 1.0)).expect("shapes");
        network.advance(end / f64::from(steps)).expect("a step");
    }
    network.update(&springs.shapes(&network.pressures(), 1.0)).expect("shapes");
    let filled: f64 = network.saturations().iter().sum();
    let cell_length = 1.2 * front * length / f64::from(count);
    assert_close(filled * cell_length, front * length, 0.02);
    assert_close(network.apertures()[0], mouth * width(end), 0.02);
    let balance = network.balance();
    assert!(balance.error().abs() < 1e-12 * balance.injected, "{balance:?}");
}

/// Without the compliance of walls in the storage, a fluid that is stiffer than they are overshoots.
#[test]
fn the_split_keeps_a_stiff_fluid_stable() {
    let compliance = 1e-11;
    let springs = Springs { mesh: chain(1, 0.1, 1e-4, [1.0, 0.0]).full(0.0), compliance, rest: 1e-4 };
    // K c/a is 220: the storage of the walls is that many times the storage of the fluid.
    let run = |split: f64| {
        let mut network = springs.mesh.network(FlowModel::new(liquid(2.2e9)), vec![pumped(1, &[0], 1e-9)]);
        let mut worst: f64 = 0.0;
        for _ in 0..20 {
            let shapes = springs.shapes(&network.pressures(), split);
            network.update(&shapes).expect("shapes");
            network.advance(1.0).expect("a step");
            // All fluid that was injected has opened the walls, or is compressed.
            let exact = 1e-9 * network.time() / (0.1 * compliance + 0.1 * 1e-4 / 2.2e9);
            worst = worst.max((network.pressures()[0] / exact - 1.0).abs());
        }
        worst
    };
    assert!(run(1.0) < 0.01, "{}", run(1.0));
    assert!(run(0.0) > 1.0, "{}", run(0.0));
}
