//! Liquid in pores: known solutions of poroelasticity, stability, mass, bits, refusals.

use std::f64::consts::PI;

use crate::common::*;
use fdem_simulation::fluid::{
    ApertureLaw, Drive, FlowModel, Fluid, PoreLiquid, PorousMaterial, Schedule as FluidSchedule,
};
use fdem_simulation::*;

/// The frame: Young's modulus, Pa, Poisson's ratio, the moduli of shear, of Lamé, of compression without
/// strain across, and of bulk, Pa.
const YOUNG: f64 = 10e9;
const POISSON: f64 = 0.2;
const SHEAR: f64 = YOUNG / (2.0 * (1.0 + POISSON));
const LAME: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
const DRAINED: f64 = LAME + 2.0 * SHEAR;
const BULK: f64 = LAME + 2.0 * SHEAR / 3.0;

/// Viscosity, Pa s.
const VISCOSITY: f64 = 1e-3;

/// Pores: Biot's coefficient and Biot's modulus, Pa.
#[derive(Clone, Copy)]
struct Pores {
    biot: f64,
    modulus: f64,
}

/// Rock, and soil with water, whose grains are rigid.
const ROCK: Pores = Pores { biot: 0.8, modulus: 8e9 };
const SOIL: Pores = Pores { biot: 1.0, modulus: 40e9 };

impl Pores {
    /// Modulus of compression without strain across and without flow, Pa.
    fn undrained(self) -> f64 {
        DRAINED + self.biot * self.biot * self.modulus
    }

    /// Storage without strain across, 1/Pa.
    fn storage(self) -> f64 {
        1.0 / self.modulus + self.biot * self.biot / DRAINED
    }

    /// Bulk modulus without flow, Pa; Poisson's ratio without flow; Skempton's coefficient.
    fn without_flow(self) -> [f64; 3] {
        let bulk = BULK + self.biot * self.biot * self.modulus;
        let poisson = (3.0 * bulk - 2.0 * SHEAR) / (2.0 * (3.0 * bulk + SHEAR));
        [bulk, poisson, self.biot * self.modulus / bulk]
    }

    /// The pores with this coefficient of consolidation, m²/s.
    fn options<const D: usize>(self, consolidation: f64) -> PoreOptions<D> {
        let permeability = consolidation * self.storage() * VISCOSITY;
        let material = PorousMaterial::isotropic(permeability, self.biot, 1.0 / self.modulus);
        PoreOptions::new(PoreLiquid { viscosity: VISCOSITY, ..PoreLiquid::WATER }, vec![Some(material)])
    }
}

fn frame() -> Material {
    Material { youngs_modulus: YOUNG, poissons_ratio: POISSON, density: 2500.0, damping: 0.1, ..granite() }
}

fn drained<const D: usize>(name: &str, nodes: Vec<u32>, pressure: f64) -> PoreSurface<D> {
    let drive = Drive::Pressure(FluidSchedule::constant(pressure));
    PoreSurface { name: name.to_owned(), target: Target::Nodes(nodes), drive }
}

/// Edges of elements both of whose nodes are there, around their elements.
fn edges_where(mesh: &Mesh, at: impl Fn([f64; 2]) -> bool) -> Vec<[u32; 2]> {
    let edges = mesh.elements.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.filter(|edge| edge.iter().all(|&node| at(mesh.nodes[node as usize]))).collect()
}

fn pressed<const D: usize>(name: &str, facets: Vec<[u32; D]>, pressure: f64, ramp: f64) -> Boundary<D> {
    Boundary {
        name: name.to_owned(),
        target: Target::Facets(facets),
        load: Load::Pressure(pressure),
        schedule: Schedule::Ramp(ramp),
    }
}

/// The body with these pores, held along x at x = 0 and along y at y = 0, in plane strain.
fn quarter(mesh: Mesh, pores: PoreOptions, others: Vec<Boundary>) -> Model {
    let mut boundaries = vec![
        held("left", nodes_where(&mesh, |[x, _]| x.abs() < 1e-9), [Some(0.0), None], Schedule::Constant),
        held("bottom", nodes_where(&mesh, |[_, y]| y.abs() < 1e-9), [None, Some(0.0)], Schedule::Constant),
    ];
    boundaries.extend(others);
    Model {
        boundaries,
        mesh,
        materials: vec![frame()],
        plane: Plane::Strain,
        pores: Some(pores),
        // Nothing touches, and soft contacts allow long steps. Local damping resists no slow motion.
        contact: ContactOptions { penalty: 0.02, ..ContactOptions::default() },
        time: TimeOptions { local_damping: 0.3, ..TimeOptions::default() },
        ..Model::default()
    }
}

/// Advances to a time, s.
fn advance_to<const D: usize, const N: usize>(run: &mut Simulation<D, N>, time: f64)
where
    [[f64; D]; N]: Element<D, N>,
{
    let steps = ((time - run.time()) / run.time_step()).round() as u64;
    run.advance(steps).expect("steps");
}

fn mass_error(run: &Simulation) -> f64 {
    let balance = run.pores().expect("pores").balance();
    assert!(balance.moved > 0.0, "{balance:?}");
    balance.error().abs() / balance.moved
}

/// The largest difference of the pressures from a function of the place, Pa.
fn pressure_error(run: &Simulation, exact: impl Fn([f64; 2]) -> f64) -> f64 {
    let found = run.pores().expect("pores").pressures();
    let all = run.model().mesh.nodes.iter().zip(found);
    all.fold(0.0, |most: f64, (node, found)| most.max((found - exact(*node)).abs()))
}

/// Time in which the load of the column comes, s.
const RAMP: f64 = 2.4e-3;

/// A column of 1 m, drained and loaded at its top by 1e6 Pa, that consolidates in 0.04 s.
fn column(cells: usize) -> Model {
    let width = 1.0 / cells as f64;
    let mesh = rectangle([0.0; 2], [width, 1.0], 1, cells);
    let top = |[_, y]: [f64; 2]| y == 1.0;
    let mut pores = ROCK.options(25.0);
    pores.surfaces.push(drained("top", nodes_where(&mesh, top), 0.0));
    let right = nodes_where(&mesh, |[x, _]| x == width);
    let others = vec![
        held("right", right, [Some(0.0), None], Schedule::Constant),
        // One and a half periods of the column leave it without vibrations.
        pressed("top", edges_where(&mesh, top), 1e6, RAMP),
    ];
    quarter(mesh, pores, others)
}

/// Terzaghi's consolidation: the pressure `p0 Σ 2/m sin(m z/h) exp(-m² c t/h²)` at the depth z, `m = (k +
/// 1/2) π`, `p0 = α σ/(K_v S)`, and the settlement, which goes from the undrained to the drained one (K.
/// Terzaghi 1923; A. H.-D. Cheng, Poroelasticity, 2016, section 7.2).
#[test]
fn a_column_consolidates_as_terzaghi_says() {
    let mut run = Simulation::new(column(16), 1).expect("a model");
    let first = ROCK.biot / (DRAINED * ROCK.storage()) * 1e6;
    for time in [0.1, 0.3, 0.6] {
        // Half of the load is there after half of its time.
        advance_to(&mut run, time * 0.04 + 0.5 * RAMP);
        let sum = |of: &dyn Fn(f64) -> f64| (0..60).map(|k| of((f64::from(k) + 0.5) * PI)).sum::<f64>();
        let exact = |z: f64| first * sum(&|m: f64| 2.0 / m * (m * z).sin() * (-m * m * time).exp());
        let error = pressure_error(&run, |[_, y]| exact(1.0 - y)) / first;
        let rest = sum(&|m: f64| 2.0 / (m * m) * (-m * m * time).exp());
        let settlement = 1e6 * (1.0 / DRAINED - (1.0 / DRAINED - 1.0 / ROCK.undrained()) * rest);
        let moved = run.snapshot().displacements;
        let top = -moved[moved.len() - 1][1] / settlement;
        assert!(error < 0.02, "{time}: {error}");
        assert!((top - 1.0).abs() < 0.02, "{time}: {top}");
    }
    assert!(mass_error(&run) < 1e-12, "{}", mass_error(&run));
    assert!(run.energies().error().abs() < 0.01, "{}", run.energies().error());
}

/// Mandel's body between rigid plates, drained at x = ±1 m, under a mean stress of 1 Pa: pressure over its
/// first value at x, and the strain across, times the shear modulus, at `T = c t/a²`.
struct Mandel {
    roots: Vec<f64>,
    undrained: f64,
    first: f64,
}

impl Mandel {
    fn new(pores: Pores) -> Self {
        let [_, undrained, skempton] = pores.without_flow();
        let of = |a: f64| a.sin() * (undrained - POISSON) - a * a.cos() * (1.0 - POISSON);
        let root = |k: u32| {
            let (mut low, mut high) = (f64::from(k) * PI + 1e-9, (f64::from(k) + 0.5) * PI);
            for _ in 0..80 {
                let middle = f64::midpoint(low, high);
                let ends = if of(middle) * of(high) > 0.0 { (low, middle) } else { (middle, high) };
                (low, high) = ends;
            }
            low
        };
        Self { roots: (0..60).map(root).collect(), undrained, first: skempton * (1.0 + undrained) / 3.0 }
    }

    fn sum(&self, time: f64, of: impl Fn(f64, f64) -> f64) -> f64 {
        let term = |&a: &f64| of(a, a - a.sin() * a.cos()) * (-a * a * time).exp();
        self.roots.iter().map(term).sum()
    }

    fn pressure(&self, x: f64, time: f64) -> f64 {
        2.0 * self.sum(time, |a, part| a.sin() / part * ((a * x).cos() - a.cos()))
    }

    fn strain(&self, time: f64) -> f64 {
        let sum = self.sum(time, |a, part| a.sin() * a.cos() / part);
        -0.5 * (1.0 - POISSON) + (1.0 - self.undrained) * sum
    }
}

/// J. Mandel, Géotechnique 3 (1953) 287-299; A. H.-D. Cheng and E. Detournay, Int. J. Numer. Anal. Methods
/// Geomech. 12 (1988) 449-462. The plate moves as it does in the solution, and its force is found.
#[test]
fn pressure_rises_and_falls_as_mandel_says() {
    let (ramp, whole, height) = (4.8e-3, 0.16, 2.0 / 12.0);
    let mandel = Mandel::new(SOIL);
    let mesh = rectangle([0.0; 2], [1.0, height], 12, 2);
    let mut pores = SOIL.options(1.0 / whole);
    pores.surfaces.push(drained("side", nodes_where(&mesh, |[x, _]| x == 1.0), 0.0));
    let stress = 1e6;
    // Times are counted from the middle of the ramp.
    let table = (0..1000).map(|k| {
        let time = f64::from(k) * 1e-3 * whole;
        let share = if time < ramp { 0.5 - 0.5 * (PI * time / ramp).cos() } else { 1.0 };
        [time, share * mandel.strain((time - 0.5 * ramp).max(0.0) / whole) * height * stress / SHEAR]
    });
    let plate = Boundary {
        name: "plate".to_owned(),
        target: Target::Nodes(nodes_where(&mesh, |[_, y]| y == height)),
        load: Load::Displacement([None, Some(1.0)]),
        schedule: Schedule::Table(table.collect()),
    };
    let mut run = Simulation::new(quarter(mesh, pores, vec![plate]), 1).expect("a model");
    let first = mandel.first * stress;
    let mut highest = 0.0_f64;
    for time in [0.05, 0.1, 0.2] {
        advance_to(&mut run, time * whole + 0.5 * ramp);
        let error = pressure_error(&run, |[x, _]| first * mandel.pressure(x, time)) / first;
        let force = run.force(2).expect("a plate")[1].abs() / stress;
        highest = highest.max(run.pores().expect("pores").pressures()[0] / first);
        assert!(error < 0.02, "{time}: {error}");
        assert!((force - 1.0).abs() < 0.02, "{time}: {force}");
    }
    // Mandel's rise is 8.3 % here.
    assert!(highest > 1.06, "{highest}");
    assert!(mass_error(&run) < 1e-12, "{}", mass_error(&run));
}

/// The unit cube of `k³` cubes, each of six tetrahedra.
fn cube(k: u32) -> Mesh<3, 4> {
    let number = |[x, y, z]: [u32; 3]| (z * (k + 1) + y) * (k + 1) + x;
    let all = || (0..=k).flat_map(move |z| (0..=k).flat_map(move |y| (0..=k).map(move |x| [x, y, z])));
    let mut elements = Vec::new();
    for at in all().filter(|at| at.iter().all(|&at| at < k)) {
        for (axes, is_even) in [
            ([0, 1, 2], true),
            ([0, 2, 1], false),
            ([1, 0, 2], false),
            ([1, 2, 0], true),
            ([2, 0, 1], true),
            ([2, 1, 0], false),
        ] {
            let mut corner = at;
            let mut nodes = [number(at); 4];
            for (node, axis) in nodes[1..].iter_mut().zip(axes) {
                corner[axis] += 1;
                *node = number(corner);
            }
            if !is_even {
                nodes.swap(2, 3);
            }
            elements.push(nodes);
        }
    }
    let count = elements.len();
    Mesh {
        nodes: all().map(|at| at.map(|at| f64::from(at) / f64::from(k))).collect(),
        elements,
        bodies: vec![0; count],
        materials: vec![0; count],
    }
}

/// `Δp = B P`, and the bulk modulus `K + α² M`.
#[test]
fn a_sealed_cube_has_skemptons_coefficient() {
    let mesh = cube(2);
    let faces = mesh.elements.iter().flat_map(|&[a, b, c, d]| [[a, c, b], [a, b, d], [b, c, d], [a, d, c]]);
    let of = |face: &[u32; 3], axis: usize, at: f64| {
        face.iter().all(|node| mesh.nodes[*node as usize][axis] == at)
    };
    let pressed_faces: Vec<[u32; 3]> = faces.filter(|face| (0..3).any(|axis| of(face, axis, 1.0))).collect();
    assert_eq!(pressed_faces.len(), 24);
    let mut boundaries = vec![pressed("all", pressed_faces, 1e6, 2e-3)];
    for axis in 0..3 {
        let nodes =
            (0..mesh.nodes.len() as u32).filter(|node| mesh.nodes[*node as usize][axis] == 0.0).collect();
        let hold = std::array::from_fn(|k| (k == axis).then_some(0.0));
        boundaries.push(held(["x", "y", "z"][axis], nodes, hold, Schedule::Constant));
    }
    let model = Model {
        boundaries,
        mesh,
        materials: vec![frame()],
        pores: Some(ROCK.options(1.0)),
        contact: ContactOptions { penalty: 0.02, ..ContactOptions::default() },
        time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
        ..Model::default()
    };
    let mut run = Simulation::<3, 4>::new(model, 1).expect("a model");
    advance_to(&mut run, 8e-3);
    let [bulk, _, skempton] = ROCK.without_flow();
    let pressures = run.pores().expect("pores").pressures();
    assert!(pressures.iter().all(|p| (p / (skempton * 1e6) - 1.0).abs() < 0.01));
    let moved = run.snapshot().displacements;
    let corner = -moved[moved.len() - 1][0] / (1e6 / (3.0 * bulk));
    assert!((corner - 1.0).abs() < 0.01, "{corner}");
    let balance = run.pores().expect("pores").balance();
    assert_eq!(balance.inflow, 0.0);
    assert!(balance.stored.abs() < 1e-20, "{balance:?}");
}

/// A tunnel of the radius 0.2 m that is drained, in a ring of 1 m: steady flow towards it, with the pressure
/// `p = p_b ln(r/a)/ln(b/a)`, and the displacement `u = α/(K_v r) ∫ p r dr + C1 r + C2/r`, by the analogy
/// with heat (A. H.-D. Cheng, Poroelasticity, 2016).
#[test]
fn a_drained_tunnel_has_the_stress_of_the_closed_form() {
    let (inner, outer, rows, columns) = (0.2_f64, 1.0_f64, 24, 16);
    let even = rectangle([0.0; 2], [1.0, 1.0], rows, columns);
    let nodes = even.nodes.iter().map(|[i, j]| {
        let (radius, angle) = (inner * (outer / inner).powf(*i), 0.5 * PI * j);
        [radius * angle.cos(), radius * angle.sin()]
    });
    let mesh = Mesh { nodes: nodes.collect(), ..even };
    let radius = |[x, y]: [f64; 2]| x.hypot(y);
    let at_outside = |place: [f64; 2]| radius(place) > 0.9999 * outer;
    let (load, far) = (2e6, 1e6);
    let mut pores = ROCK.options(500.0);
    let wall = nodes_where(&mesh, |place| radius(place) < 1.0001 * inner);
    pores.surfaces.push(drained("wall", wall, 0.0));
    pores.surfaces.push(drained("far", nodes_where(&mesh, at_outside), far));
    let outside = pressed("outside", edges_where(&mesh, at_outside), load, 1e-3);
    let model = Model {
        time: TimeOptions { dynamic_relaxation: true, ..TimeOptions::default() },
        ..quarter(mesh, pores, vec![outside])
    };
    let mut run = Simulation::new(model, 1).expect("a model");
    advance_to(&mut run, 1e-2);
    let slope = far / (outer / inner).ln();
    let exact = |r: f64| slope * (r / inner).ln();
    let error = pressure_error(&run, |place| exact(radius(place))) / far;
    assert!(error < 0.02, "{error}");
    // Stress without constants, and constants by the stress at both ends.
    let part = ROCK.biot / DRAINED;
    let integral = |r: f64| slope * (0.5 * r * r * (r / inner).ln() - 0.25 * (r * r - inner * inner));
    let stress_of = |r: f64, [c1, c2]: [f64; 2]| {
        2.0 * SHEAR * (-part * integral(r) / (r * r) - c2 / (r * r)) + 2.0 * (LAME + SHEAR) * c1
    };
    let ends = |r: f64| [stress_of(r, [0.0; 2]), 2.0 * (LAME + SHEAR), -2.0 * SHEAR / (r * r)];
    let ([s, p, q], [t, _, v]) = (ends(inner), ends(outer));
    let c2 = ((-load - t) + s) / (v - q);
    let c1 = (-s - q * c2) / p;
    let (snapshot, matrix) = (run.snapshot(), run.pores().expect("pores"));
    let places = &run.model().mesh;
    let mut worst = 0.0_f64;
    // The mean of the two triangles of each square.
    for pair in 0..rows * columns {
        let (mut centre, mut total) = ([0.0; 2], [0.0; 3]);
        for element in [2 * pair, 2 * pair + 1] {
            for node in places.elements[element] {
                centre = [0, 1].map(|axis| centre[axis] + places.nodes[node as usize][axis] / 6.0);
            }
            let push = ROCK.biot * matrix.pressure_in(element);
            let [xx, yy, _, xy, ..] = snapshot.stresses[element];
            total = [total[0] + 0.5 * (xx - push), total[1] + 0.5 * (yy - push), total[2] + 0.5 * xy];
        }
        let r = radius(centre);
        let [x, y] = centre.map(|x| x / r);
        let found = x * x * total[0] + y * y * total[1] + 2.0 * x * y * total[2];
        worst = worst.max((found - stress_of(r, [c1, c2])).abs() / load);
    }
    assert!(worst < 0.03, "{worst}");
    assert!(mass_error(&run) < 1e-12, "{}", mass_error(&run));
}

/// A body that swings near the limit of the step, with a flow that takes most of the pressure away: energy
/// falls. With the pressure after the flow alone in its step, modes near the limit would grow.
#[test]
fn flow_feeds_no_vibrations() {
    for steps in [1, 2, 4] {
        let mesh = rectangle([0.0; 2], [1.0; 2], 6, 6);
        let mut pores = SOIL.options(3e4);
        pores.steps = steps;
        let speed = |k: usize| [1e-3 * (k as f64 * 1.3).sin(), 1e-3 * (k as f64 * 2.9).cos()];
        let model = Model {
            velocities: (0..mesh.nodes.len()).map(speed).collect(),
            materials: vec![Material { damping: 0.0, ..frame() }],
            time: TimeOptions { safety: 0.999, energy_bound: 1e9, ..TimeOptions::default() },
            ..quarter(mesh, pores, Vec::new())
        };
        let mut run = Simulation::new(model, 1).expect("a model");
        run.advance(4000).expect("steps");
        let last = run.energies();
        assert!(last.kinetic + last.strain < last.initial, "{steps}: {last:?}");
    }
}

/// A liquid that is nearly incompressible makes the stable step shorter, by its bound.
#[test]
fn the_critical_step_counts_the_liquid() {
    let with = column(8);
    let without = Model { pores: None, ..with.clone() };
    let [with, without] = [with, without].map(|model| CriticalStep::of(&model).expect("a step").step);
    let bound = (DRAINED / ROCK.undrained()).sqrt();
    assert!(with < 0.95 * without && with > 0.9 * bound * without, "{with} {without} {bound}");
}

/// Pressure and effective stress of the beginning hold each other in equilibrium, across joints, too.
#[test]
fn a_pressure_at_the_beginning_is_in_equilibrium() {
    let mesh = rectangle([0.0; 2], [1.0; 2], 4, 4);
    let pressure = 1e6;
    let mut pores = ROCK.options(1.0);
    pores.initial_pressures = vec![pressure; mesh.nodes.len()];
    let push = ROCK.biot * pressure;
    let plane = edges_where(&mesh, |[x, _]| x == 0.5);
    let set = JointSet {
        name: "plane".to_owned(),
        strength: Strength { tensile: 10e6, ..rock() },
        residual_friction: 0.0,
        dilation: 0.0,
        dilation_slip: None,
        normal_stiffness: None,
        shear_stiffness: None,
        open: false,
    };
    let mut model = Model {
        stresses: vec![[[push, 0.0], [0.0, push]]; mesh.elements.len()],
        joint_sets: vec![set],
        boundaries: Vec::new(),
        ..quarter(mesh, pores, Vec::new())
    };
    model.joint_sets[0].strength.energy_i = 1000.0;
    model.joint_sets[0].strength.energy_ii = 1000.0;
    model.add_joints(0, &plane);
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(200).expect("steps");
    let most = run.snapshot().displacements.as_flattened().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    assert!(run.counts().joints == 4 && most < 1e-9 * push / DRAINED, "{:?} {most}", run.counts());
    let pressures = run.pores().expect("pores").pressures();
    assert!(pressures.iter().all(|found| (found / pressure - 1.0).abs() < 1e-6));
}

/// A block that is pulled apart, with drained ends and a well in it.
fn breaking() -> Model {
    let mesh = rectangle([0.0; 2], [0.2, 0.1], 12, 6);
    let mut pores = ROCK.options(1.0);
    pores.steps = 3;
    pores.initial_pressures = mesh.nodes.iter().map(|[x, _]| 1e6 * x).collect();
    pores.surfaces.push(drained("left", nodes_where(&mesh, |[x, _]| x == 0.0), 1e5));
    pores.surfaces.push(PoreSurface {
        name: "well".to_owned(),
        target: Target::Facets(edges_where(&mesh, |[x, _]| x > 0.199)),
        drive: Drive::Rate(FluidSchedule::constant(1e-4)),
    });
    let right = nodes_where(&mesh, |[x, _]| x > 0.199);
    let strength = Some(Strength { energy_i: 1.0, energy_ii: 5.0, ..rock() });
    let pull = held("right", right, [Some(0.5), None], Schedule::Ramp(1e-5));
    let model = quarter(mesh, pores, vec![pull]);
    let (contact, time) = (ContactOptions::default(), TimeOptions::default());
    Model { contact, time, materials: vec![Material { strength, ..frame() }], ..model }
}

#[test]
fn threads_and_a_resumed_run_change_no_bit() {
    let mut whole = Simulation::new(breaking(), 1).expect("a model");
    whole.advance(202).expect("steps");
    let state = whole.state();
    whole.advance(198).expect("steps");
    let mut other = Simulation::new(breaking(), 2).expect("a model");
    other.advance(400).expect("steps");
    let mut resumed = Simulation::resume(breaking(), state, 2).expect("the state");
    resumed.advance(198).expect("steps");
    assert!(whole.counts().joints + whole.counts().broken > 5, "{:?}", whole.counts());
    for run in [&other, &resumed] {
        assert!(run.pores().expect("pores").state() == whole.pores().expect("pores").state());
        assert_eq!(run.energies(), whole.energies());
        assert!(run.snapshot() == whole.snapshot());
    }
    assert!(mass_error(&whole) < 1e-12, "{}", mass_error(&whole));
    assert!(whole.energies().error().abs() < 0.01, "{}", whole.energies().error());
}

/// Snapshots have the pressures at all nodes, those of split ones too; probes those at points and the volumes
/// of surfaces. Neither has a pressure where there are no pores.
#[test]
fn snapshots_and_probes_have_the_pressures_of_pores() {
    let mut model = breaking();
    model.materials.push(Material { name: "tight".to_owned(), ..model.materials[0].clone() });
    let is_right = |mesh: &Mesh, element: usize| {
        mesh.elements[element].iter().all(|node| mesh.nodes[*node as usize][0] > 0.099)
    };
    let tight: Vec<usize> = (0..model.mesh.elements.len()).filter(|k| is_right(&model.mesh, *k)).collect();
    for &element in &tight {
        model.mesh.materials[element] = 1;
    }
    let pores = model.pores.as_mut().expect("pores");
    pores.materials.push(None);
    pores.surfaces.pop();
    let mut run = Simulation::new(model, 1).expect("a model");
    run.advance(400).expect("steps");
    assert!(run.counts().broken > 0 && run.snapshot().positions.len() > run.model().mesh.nodes.len());
    let (snapshot, matrix) = (run.snapshot(), run.pores().expect("pores"));
    let found = snapshot.pore_pressures.as_ref().expect("pores");
    assert_eq!(found.len(), snapshot.positions.len());
    for (nodes, vertices) in snapshot.elements.iter().zip(&run.model().mesh.elements) {
        for (node, vertex) in nodes.iter().zip(vertices) {
            let vertex = *vertex as usize;
            let expected = (matrix.storages()[vertex] > 0.0).then(|| matrix.pressures()[vertex]);
            assert_eq!(found[*node as usize], expected);
        }
    }
    assert!(found.contains(&None) && found.iter().flatten().any(|pressure| *pressure > 1e3));
    let at =
        |element: usize, weights| Probe::PorePressure(MaterialPoint { element: element as u32, weights });
    let surface = |name: &str| Probe::PoreSurface(name.to_owned());
    let probes = [at(3, [0.25, 0.25, 0.5]), at(tight[0], [1.0, 0.0, 0.0]), surface("left"), surface("well")];
    let measured = run.measure(&probes);
    let [a, b, c] = run.model().mesh.elements[3].map(|vertex| matrix.pressures()[vertex as usize]);
    assert!((measured[0][0] / (0.25 * a + 0.25 * b + 0.5 * c) - 1.0).abs() < 1e-12, "{measured:?}");
    assert!(measured[1][0].is_nan() && measured[3][0].is_nan());
    assert_eq!(measured[2], [matrix.inflow(0).expect("a surface")]);
    let balance = matrix.balance();
    let whole = [balance.initial, balance.inflow, balance.exchanged, balance.stored, balance.error()];
    assert_eq!(run.measure(&[Probe::Pores])[0], whole);
    assert!(balance.inflow == measured[2][0] && balance.inflow != 0.0);
}

/// A stage without the right half: pressures stay where elements do.
#[test]
fn pressures_stay_in_the_next_stage() {
    let model = breaking();
    let mut run = Simulation::new(model.clone(), 1).expect("a model");
    run.advance(100).expect("steps");
    let before = run.pores().expect("pores").pressures().to_vec();
    let inside = |node: &u32| model.mesh.nodes[*node as usize][0] < 0.101;
    let keep: Vec<bool> = model.mesh.elements.iter().map(|nodes| nodes.iter().all(inside)).collect();
    let change = Change::excavating(&model, &keep, None).expect("a part");
    let (part, state) = run.state().changed(&model, change, 1).expect("a changed run");
    let mut run = Simulation::resume(part, state, 1).expect("a run");
    let left: Vec<f64> = (0..before.len() as u32).filter(inside).map(|node| before[node as usize]).collect();
    assert_eq!(run.pores().expect("pores").pressures(), left);
    let balance = run.pores().expect("pores").balance();
    assert!(balance.error().abs() < 1e-12 * balance.stored.abs(), "{balance:?}");
    run.advance(50).expect("steps");
    let balance = run.pores().expect("pores").balance();
    assert!(balance.error().abs() < 1e-12 * balance.stored.abs(), "{balance:?}");
}

#[test]
fn bad_pores_are_refused() {
    let refused = |change: &dyn Fn(&mut Model)| {
        let mut model = breaking();
        change(&mut model);
        Simulation::new(model, 1).map(|_| ()).expect_err("bad").to_string()
    };
    let with = |change: &dyn Fn(&mut PoreOptions)| {
        refused(&|model: &mut Model| change(model.pores.as_mut().expect("pores")))
    };
    assert!(with(&|pores| pores.steps = 0).contains("at least 1"));
    assert!(with(&|pores| pores.materials.clear()).contains("materials with pores"));
    assert!(with(&|pores| pores.initial_pressures.truncate(3)).contains("initial pressures"));
    assert!(with(&|pores| pores.liquid.viscosity = 0.0).contains("viscosity"));
    let storage = |pores: &mut PoreOptions| pores.materials[0].as_mut().expect("pores").storage = 0.0;
    assert!(with(&storage).contains("storage"));
    assert!(with(&|pores| pores.surfaces[0].target = Target::Nodes(Vec::new())).contains("left"));
    assert!(with(&|pores| pores.surfaces[0].target = Target::Nodes(vec![1000])).contains("node 1000"));
    assert!(with(&|pores| pores.surfaces.push(pores.surfaces[0].clone())).contains("left"));
    assert!(refused(&|model| model.plane = Plane::Stress).contains("plane strain"));
}

#[test]
fn ranks_refuse_pores() {
    fdem_distributed::threads::run(2, |communicator| {
        let run = (communicator.rank() == 0).then(|| Simulation::new(breaking(), 1).expect("a model"));
        let error = Distributed::new(communicator, run, 1).map(|_| ()).expect_err("pores");
        assert_eq!(error, ModelError::Pores("the run is on many ranks"));
    });
}

/// A block with an open crack from its top to its middle, which is pumped, in pores that are drained at the
/// sides.
fn cracked() -> Model {
    let mesh = rectangle([0.0; 2], [0.2, 0.1], 8, 4);
    let mut pores = ROCK.options(0.5);
    pores.steps = 4;
    for (name, at) in [("left", 0.0), ("right", 0.2)] {
        pores.surfaces.push(drained(name, nodes_where(&mesh, |[x, _]| (x - at).abs() < 1e-9), 0.0));
    }
    let mut crack = edges_where(&mesh, |[x, y]| (x - 0.1).abs() < 1e-9 && y > 0.049);
    for edge in &mut crack {
        edge.sort_unstable();
    }
    crack.sort_unstable();
    crack.dedup();
    let none =
        Strength { tensile: 0.0, cohesion: 0.0, friction: 0.0, energy_i: 0.0, energy_ii: 0.0, ..rock() };
    let set = JointSet {
        name: "crack".to_owned(),
        strength: none,
        residual_friction: 0.0,
        dilation: 0.0,
        dilation_slip: None,
        normal_stiffness: None,
        shear_stiffness: None,
        open: true,
    };
    let pump = FluidSource {
        name: "pump".to_owned(),
        facets: vec![crack[crack.len() - 1]],
        drive: Some(Drive::Pressure(FluidSchedule::constant(1e6))),
        initial_pressure: None,
    };
    let aperture = ApertureLaw { residual: 1e-5, ..ApertureLaw::default() };
    let fluid = FluidOptions { aperture, ..FluidOptions::new(FlowModel::new(Fluid::WATER), vec![pump]) };
    let sides = nodes_where(&mesh, |[x, _]| x > 0.199);
    let right = held("right", sides, [Some(0.0), None], Schedule::Constant);
    let mut model = Model {
        joint_sets: vec![set],
        fluid: Some(fluid),
        contact: ContactOptions::default(),
        time: TimeOptions::default(),
        ..quarter(mesh, pores, vec![right])
    };
    model.add_joints(0, &crack);
    model
}

/// A closed joint between pores: the total compression, of which elements have the effective part, less the
/// pressure in the joint closes it.
#[test]
fn the_total_compression_less_the_pressure_closes_a_joint_in_pores() {
    let (mut model, pressure, initial) = (cracked(), 1e6, 5e-5);
    model.joint_sets[0].open = false;
    model.stresses = vec![[[-3e6, 0.0], [0.0, 0.0]]; model.mesh.elements.len()];
    let pores = model.pores.as_mut().expect("pores");
    (pores.initial_pressures, pores.surfaces) = (vec![pressure; model.mesh.nodes.len()], Vec::new());
    let fluid = model.fluid.as_mut().expect("a fluid");
    let law = ApertureLaw { initial, reference_stress: Some(1e7), residual: 1e-7, ..ApertureLaw::default() };
    (fluid.set_apertures, fluid.initial_pressure) = (vec![law], Some(pressure));
    let mut run = Simulation::new(model, 1).expect("a model");
    let effective = 3e6 + (ROCK.biot - 1.0) * pressure;
    for _ in 0..3 {
        run.advance(1).expect("a step");
        let apertures = run.fluid().expect("a fluid").apertures();
        let expected = initial / (1.0 + 9.0 * effective / 1e7);
        assert!(apertures.iter().all(|a| (a / expected - 1.0).abs() < 0.02), "{expected}: {apertures:?}");
    }
}

/// Cracks give fluid to pores: each side has the volume of the other, in any number of threads and after a
/// pause.
#[test]
fn a_crack_fills_the_pores_beside_it() {
    let mut whole = Simulation::new(cracked(), 1).expect("a model");
    whole.advance(150).expect("steps");
    let state = whole.state();
    whole.advance(150).expect("steps");
    let (cracks, pores) =
        (whole.fluid().expect("a fluid").balance(), whole.pores().expect("pores").balance());
    assert!(pores.exchanged > 0.0 && cracks.leaked > 0.1 * cracks.injected, "{cracks:?} {pores:?}");
    assert!((cracks.leaked / (998.0 * pores.exchanged) - 1.0).abs() < 1e-12, "{cracks:?} {pores:?}");
    assert!(cracks.error().abs() < 1e-12 * cracks.injected, "{cracks:?}");
    assert!(mass_error(&whole) < 1e-12, "{}", mass_error(&whole));
    assert!(whole.energies().error().abs() < 0.01, "{}", whole.energies().error());
    let at_crack = nodes_where(&whole.model().mesh, |[x, y]| (x - 0.1).abs() < 1e-9 && y > 0.074);
    let found = whole.pores().expect("pores").pressures();
    assert!(at_crack.iter().all(|node| (0.3..1.05).contains(&(found[*node as usize] / 1e6))), "{found:?}");
    let mut other = Simulation::new(cracked(), 2).expect("a model");
    other.advance(300).expect("steps");
    let mut resumed = Simulation::resume(cracked(), state, 2).expect("the state");
    resumed.advance(150).expect("steps");
    for run in [&other, &resumed] {
        assert!(run.pores().expect("pores").state() == whole.pores().expect("pores").state());
        assert!(run.fluid().expect("a fluid").state() == whole.fluid().expect("a fluid").state());
        assert!(run.snapshot() == whole.snapshot());
    }
    let mut leaking = cracked();
    leaking.fluid.as_mut().expect("a fluid").leak_off = 1e-6;
    assert!(Simulation::new(leaking, 1).map(|_| ()).expect_err("leak-off").to_string().contains("leak-off"));
}
