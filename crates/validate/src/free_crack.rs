//! A crack in tension that chooses its path along the edges of an unstructured mesh, and the same crack on a
//! straight line.
//!
//! The specimen is a plate with a sharp notch. Its ends are pulled apart, or it is bent on three points.

use std::fmt::{self, Display};

use fdem_simulation::{Insertion, Material, Model, Schedule, Simulation};
use rayon::prelude::*;

use super::models::{
    advance_to, along_slit, centroid, mean_load, moved, nodes_where, rectangle, slit, start, worse,
};
use super::rocks::prepared;
use super::{Outcome, Size};

/// Width and half of the length of the specimen, and length of its notch, m. The crack grows along y = 0.
const WIDTH: f64 = 0.048;
const HALF: f64 = 0.064;
const NOTCH: f64 = 0.016;
/// Half of the distance of the supports of a beam, m.
const SUPPORT: f64 = 0.06;
/// Distance from the line of the notch within which the specimen can break, m.
const BREAKABLE: f64 = 0.025;
/// Pa.
const MODULUS: f64 = 30e9;
const TENSILE: f64 = 2.5e6;
/// Length of the process zone, E G/f², m.
const ZONE: f64 = 0.012;
/// Elements in the process zone of the straight crack: it is the same with twelve.
const STRAIGHT: u32 = 6;
/// Time in which the loading speed is reached, s. A beam swings if it is shorter.
const RAMP: f64 = 2.5e-4;
/// Time at which the work against the joints of a beam is compared, s. The crack has grown through three
/// quarters of it.
const BENT: f64 = 1.15e-3;

/// The load on the specimen.
#[derive(Clone, Copy)]
enum Loading {
    Tension,
    Bending,
}

/// The mesher of the specimen with a free crack.
#[derive(Clone, Copy)]
enum Mesher {
    /// The mesher of this crate, with a seed.
    Own(u32),
    Delaunay,
    Frontal,
}

impl Display for Mesher {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Own(_) => write!(f, "meshes of fdem"),
            Self::Delaunay => write!(f, "Gmsh Delaunay"),
            Self::Frontal => write!(f, "Gmsh Frontal-Delaunay"),
        }
    }
}

/// Largest errors that pass with a number of elements in the process zone.
struct Bounds {
    elements: u32,
    /// Error of the mean toughness over the meshes.
    toughness: f64,
    /// Error of the toughness of each mesh.
    each: f64,
    /// Error of the mean energy.
    energy: f64,
}

const COARSE: Bounds = Bounds { elements: 3, toughness: 0.12, each: 0.25, energy: 0.12 };
const USUAL: Bounds = Bounds { elements: 6, toughness: 0.04, each: 0.08, energy: 0.05 };
const FINE: Bounds = Bounds { elements: 12, toughness: 0.04, each: 0.1, energy: 0.05 };

pub(super) fn tension(size: Size) -> Result<Vec<Outcome>, String> {
    compared(Loading::Tension, size)
}

pub(super) fn bending(size: Size) -> Result<Vec<Outcome>, String> {
    compared(Loading::Bending, size)
}

fn compared(loading: Loading, size: Size) -> Result<Vec<Outcome>, String> {
    let seeds = size.choose(if let Loading::Tension = loading { 1..=2 } else { 1..=1 }, 1..=8);
    let own: Vec<Mesher> = seeds.map(Mesher::Own).collect();
    let meshers: Vec<Vec<Mesher>> =
        size.choose(vec![own.clone()], vec![own, vec![Mesher::Delaunay], vec![Mesher::Frontal]]);
    let insertions: &[(Insertion, &str)] = size.choose(
        &[(Insertion::Adaptive, "adaptive")],
        &[(Insertion::Adaptive, "adaptive"), (Insertion::Intrinsic, "intrinsic")],
    );
    let mut outcomes = Vec::new();
    if size == Size::Full {
        outcomes.push(against_theory(loading)?);
    }
    for &(insertion, joints) in insertions {
        let specimen = Specimen { loading, insertion, zone: ZONE, speed: loading.speed() };
        let straight = specimen.broken(specimen.straight()?)?;
        if matches!(loading, Loading::Tension) {
            let name = format!("energy of the straight crack over G, {joints}");
            outcomes.push(Outcome::absolute(name, 1.0, straight.energy, 0.01, ""));
        }
        let sizes: &[Bounds] = size.choose(&[USUAL], &[COARSE, USUAL, FINE]);
        for bounds in sizes {
            let crack = |mesher: &Mesher| specimen.broken(specimen.free(bounds.elements, *mesher)?);
            // All together, so that no thread waits.
            let cracks = meshers.par_iter().flatten().map(crack).collect::<Result<Vec<Crack>, String>>()?;
            let mut rest = &cracks[..];
            for meshers in &meshers {
                let (cracks, others) = rest.split_at(meshers.len());
                rest = others;
                let case = format!("{} elements, {joints}, {}", bounds.elements, meshers[0]);
                outcomes.extend(of_cracks(cracks, &straight, bounds, &case));
            }
        }
    }
    Ok(outcomes)
}

/// Cracks of one or more meshes over the straight one.
fn of_cracks(cracks: &[Crack], straight: &Crack, bounds: &Bounds, case: &str) -> Vec<Outcome> {
    let mean = |of: fn(&Crack) -> f64| cracks.iter().map(of).sum::<f64>() / cracks.len() as f64;
    let farthest = cracks.iter().map(|crack| crack.load / straight.load - 1.0).fold(0.0, worse);
    let size = ZONE / f64::from(bounds.elements);
    let quantity = |what: &str, expected: f64, found: f64, bound: f64| {
        Outcome::absolute(format!("{what}, {case}"), expected, found, bound, "")
    };
    let mut outcomes = Vec::new();
    if cracks.len() > 1 {
        let load = mean(|crack| crack.load) / straight.load;
        outcomes.push(quantity("mean of K over that of the straight crack", 1.0, load, bounds.toughness));
        outcomes.push(quantity("the farthest from it", 1.0, 1.0 + farthest, bounds.each));
    } else {
        outcomes.push(quantity("K over that of the straight crack", 1.0, 1.0 + farthest, bounds.each));
    }
    let energy = mean(|crack| crack.energy) / straight.energy;
    // One mesh scatters more than the mean of several.
    let bound = bounds.energy + if cracks.len() > 1 { 0.0 } else { 0.05 };
    outcomes.extend([
        quantity("energy over that of the straight crack", 1.0, energy, bound),
        quantity("length of the path over its projection", 1.0, mean(|crack| crack.path), 0.12),
        quantity("damage beside the path", 0.0, mean(|crack| crack.beside), 0.12),
        quantity(
            "joints beside the path for each element of its length",
            0.0,
            mean(|crack| crack.count) * size,
            8.0,
        ),
    ]);
    outcomes
}

/// K of a load of 1 N, m^−1.5, for cracks of 16, 18.4 and 20.8 mm: by quadratic finite elements, from the
/// energy that they release.
const TOUGHNESSES: [(f64, [f64; 2]); 3] =
    [(0.016, [6.059, 18.005]), (0.0184, [6.716, 20.579]), (0.0208, [7.360, 23.565])];

/// A cohesive crack in a large body, whose joints soften as those here: K over √(E G), and the length in E
/// G/f² by which it acts longer than its notch, as the process zone develops. From the integral equations of
/// J. Planas and M. Elices, Int. J. Fracture 51 (1991), which for linear softening give their 0.419.
const DEVELOPED: [[f64; 2]; 8] = [
    [0.8096, 0.1418],
    [0.8756, 0.2047],
    [0.9208, 0.2742],
    [0.9528, 0.3489],
    [0.9753, 0.4287],
    [0.9900, 0.5140],
    [0.9980, 0.6056],
    [1.0000, 0.6878],
];

/// The largest load of the straight crack, pulled slowly, over that of linear elastic fracture mechanics. The
/// process zone is shorter than in the other cracks, because the theory is for one that is short beside the
/// body.
fn against_theory(loading: Loading) -> Result<Outcome, String> {
    let zone = 0.009;
    let specimen = Specimen { loading, insertion: Insertion::Adaptive, zone, speed: 2.5e-3 };
    let toughness = (MODULUS * specimen.energy()).sqrt();
    // Lagrange's polynomial through the three lengths.
    let of_load = |crack: f64| -> f64 {
        let term = |&(at, values): &(f64, [f64; 2])| {
            let others = TOUGHNESSES.iter().filter(|(other, _)| *other != at);
            values[loading as usize]
                * others.map(|(other, _)| (crack - other) / (at - other)).product::<f64>()
        };
        TOUGHNESSES.iter().map(term).sum()
    };
    let load = |[share, longer]: &[f64; 2]| share * toughness / of_load(NOTCH + longer * zone);
    let expected = DEVELOPED.iter().map(load).fold(0.0, f64::max);
    let found = specimen.broken(specimen.straight()?)?.load;
    Ok(Outcome::relative("load of the straight crack, E G/f² = 9 mm", expected, found, 0.05, "N"))
}

impl Loading {
    /// Speed of each end or of the roller, m/s.
    fn speed(self) -> f64 {
        match self {
            Self::Tension => 5e-3,
            Self::Bending => 1e-2,
        }
    }

    /// Mean load over the next steps, N.
    fn mean_load(self, run: &mut Simulation) -> Result<f64, String> {
        Ok(match self {
            Self::Tension => mean_load(run, 1)?,
            Self::Bending => -mean_load(run, 0)?,
        })
    }
}

/// The notched plate and how it is loaded.
#[derive(Clone, Copy)]
struct Specimen {
    loading: Loading,
    insertion: Insertion,
    /// E G/f², m.
    zone: f64,
    /// m/s.
    speed: f64,
}

/// Results of breaking a specimen.
struct Crack {
    /// Largest load, N for a thickness of 1 m. The stress intensity at growth is proportional to it.
    load: f64,
    /// Work done against the joints over the fracture energy of the ligament, when a plate is in two or when
    /// a beam is bent so far.
    energy: f64,
    /// Length of the broken joints over that of their projection.
    path: f64,
    /// Joints behind the tip that hold and are damaged, over the projection of the crack: sum of damage times
    /// length, and number, 1/m.
    beside: f64,
    count: f64,
}

impl Specimen {
    /// Fracture energy of opening, J/m².
    fn energy(&self) -> f64 {
        self.zone * TENSILE * TENSILE / MODULUS
    }

    /// Breaks the specimen.
    fn broken(&self, model: Model) -> Result<Crack, String> {
        let mut run = start(model)?;
        let (mut peak, mut at) = (0.0_f64, 0.0);
        loop {
            let now = self.loading.mean_load(&mut run)?;
            if now > peak {
                (peak, at) = (now, run.time());
            }
            if now < 0.5 * peak && run.time() > at + 0.1 * RAMP {
                break;
            }
            if run.time() > 20.0 * RAMP {
                return Err("the specimen does not break".to_owned());
            }
        }
        match self.loading {
            // Until it is in two.
            Loading::Tension => advance_to(&mut run, at + RAMP)?,
            Loading::Bending => advance_to(&mut run, BENT)?,
        }
        let cracks = run.snapshot().cracks;
        let tip = cracks.iter().filter(|crack| crack.time.is_some()).flat_map(|crack| crack.corners);
        let tip = tip.map(|[x, _]| x).fold(NOTCH, f64::max);
        let projection = tip - NOTCH;
        let behind = |[x, _]: [f64; 2]| x < tip;
        let held = cracks.iter().filter(|crack| crack.time.is_none() && crack.damage > 0.0);
        let beside: Vec<_> = held.filter(|crack| crack.corners.into_iter().all(behind)).collect();
        Ok(Crack {
            load: peak,
            energy: run.energies().cohesive / (self.energy() * (WIDTH - NOTCH)),
            path: run.crack_lengths().iter().sum::<f64>() / projection,
            beside: beside.iter().map(|crack| crack.damage * crack.measure).sum::<f64>() / projection,
            count: beside.len() as f64 / projection,
        })
    }

    /// The specimen of an unstructured mesh, whose crack is free.
    fn free(&self, elements: u32, mesher: Mesher) -> Result<Model, String> {
        let mesh_size = ZONE / f64::from(elements);
        let mouth = 0.3 * mesh_size;
        let body = match mesher {
            Mesher::Own(seed) => format!(
                "polygon = {{ points = [[0, -{HALF}], [{WIDTH}, -{HALF}], [{WIDTH}, 0], [{WIDTH}, {HALF}], [0, {HALF}], [0, {SUPPORT}], [0, {mouth}], [{NOTCH}, 0], [0, -{mouth}], [0, -{SUPPORT}]] }}
                 mesh_size = {mesh_size}
                 seed = {seed}"
            ),
            Mesher::Delaunay => format!("mesh = \"delaunay-{elements}.msh\""),
            Mesher::Frontal => format!("mesh = \"frontal-{elements}.msh\""),
        };
        let mut model = prepared(&self.model_file(&body))?;
        model.fracture.insertion = self.insertion;
        // Far from the crack nothing breaks, and elements without joints cost less.
        model.materials.push(Material { strength: None, ..model.materials[0].clone() });
        for element in 0..model.mesh.elements.len() {
            if centroid(&model.mesh, element)[1].abs() > BREAKABLE {
                model.mesh.materials[element] = 1;
            }
        }
        self.load(&mut model);
        Ok(model)
    }

    /// The specimen of a structured mesh, with a slit, that can break along the line of the slit only.
    fn straight(&self) -> Result<Model, String> {
        let cells = |length: f64| (length / ZONE * f64::from(STRAIGHT)).round() as usize;
        let whole = rectangle([0.0, -HALF], [WIDTH, HALF], [cells(WIDTH), 2 * cells(HALF)]);
        let any = prepared(&self.model_file("rectangle = { min = [0, 0], max = [1, 1] }\nmesh_size = 0.5"))?;
        let mut model = along_slit(any, slit(&whole, NOTCH));
        model.fracture.insertion = self.insertion;
        self.load(&mut model);
        Ok(model)
    }

    fn model_file(&self, body: &str) -> String {
        format!(
            r#"
[model]
plane = "stress"
gravity = "none"
end_time = 1
[[body]]
name = "specimen"
material = "rock"
{body}
[[material]]
name = "rock"
density = 2700
youngs_modulus = {MODULUS}
poissons_ratio = 0.2
damping = 0.1
friction = 0.5
tensile_strength = {TENSILE}
cohesion = {cohesion}
friction_angle = 30
fracture_energy_i = {energy}
fracture_energy_ii = {sliding}
"#,
            cohesion = 3.0 * TENSILE,
            energy = self.energy(),
            sliding = 5.0 * self.energy(),
        )
    }

    fn load(&self, model: &mut Model) {
        let mesh = &model.mesh;
        let schedule = Schedule::Ramp(RAMP);
        let nodes_at = |u: f64, v: f64| nodes_where(mesh, |[x, y]| (x - u).hypot(y - v) < 1e-6);
        let boundaries = match self.loading {
            Loading::Tension => [("lower end", -1.0), ("upper end", 1.0)].map(|(name, sign)| {
                let nodes = nodes_where(mesh, |[_, y]| sign * y > HALF - 1e-6);
                moved(name, nodes, [Some(0.0), Some(sign * self.speed)], schedule.clone())
            }),
            Loading::Bending => {
                let supports = [nodes_at(0.0, -SUPPORT), nodes_at(0.0, SUPPORT)].concat();
                [
                    moved("supports", supports, [Some(0.0), None], schedule.clone()),
                    moved("roller", nodes_at(WIDTH, 0.0), [Some(-self.speed), Some(0.0)], schedule),
                ]
            }
        };
        model.boundaries = boundaries.to_vec();
    }
}
