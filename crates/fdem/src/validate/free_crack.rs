//! A crack in tension that chooses its path along the edges of an unstructured mesh, and the same crack on a straight line.

use fdem_simulation::{Insertion, Interface, Material, Model, Schedule};

use super::models::{advance, mean_load, moved, nodes_where, rectangle, slit, start, worse};
use super::rocks::prepared;
use super::{Outcome, Size};

/// Width and half of the height of the plate, and length of its notch, m.
const WIDTH: f64 = 0.06;
const HALF: f64 = 0.05;
const NOTCH: f64 = 0.018;
/// Pa.
const MODULUS: f64 = 30e9;
const TENSILE: f64 = 2.5e6;
/// Length of the process zone, E G/f², m.
const ZONE: f64 = 0.012;
/// Fracture energy of opening, J/m².
const ENERGY: f64 = ZONE * TENSILE * TENSILE / MODULUS;
/// Speed of each end, m/s, and the time in which it is reached, s.
const SPEED: f64 = 5e-3;
const RAMP: f64 = 1e-4;

/// Bounds for a number of elements in the process zone.
struct Bounds {
    elements: u32,
    /// Largest errors that pass: of the mean toughness, of the toughness of each mesh, and of the mean energy.
    bounds: [f64; 3],
}

const COARSE: Bounds = Bounds { elements: 3, bounds: [0.1, 0.25, 0.1] };
const USUAL: Bounds = Bounds { elements: 6, bounds: [0.04, 0.08, 0.05] };
const FINE: Bounds = Bounds { elements: 12, bounds: [0.04, 0.08, 0.05] };

pub(super) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let seeds = size.choose(1..=2, 1..=8);
    let groups: &[(Insertion, &[Bounds])] = size.choose(
        &[(Insertion::Adaptive, &[USUAL])],
        &[(Insertion::Adaptive, &[COARSE, USUAL, FINE]), (Insertion::Intrinsic, &[COARSE, USUAL])],
    );
    let mut outcomes = Vec::new();
    for &(insertion, sizes) in groups {
        let straight = pull_apart(straight(insertion)?)?;
        let name = match insertion {
            Insertion::Adaptive => "adaptive",
            Insertion::Intrinsic => "intrinsic",
        };
        outcomes.push(Outcome::absolute(
            format!("energy of the straight crack over G, {name}"),
            1.0,
            straight.energy,
            0.01,
            "",
        ));
        for Bounds { elements, bounds: [mean_bound, each_bound, energy_bound] } in sizes {
            let crack = |seed| pull_apart(free(insertion, *elements, seed)?);
            let cracks = seeds.clone().map(crack).collect::<Result<Vec<Pulled>, String>>()?;
            let count = cracks.len();
            let mean = |of: fn(&Pulled) -> f64| cracks.iter().map(of).sum::<f64>() / count as f64;
            let farthest = cracks.iter().map(|crack| crack.load / straight.load - 1.0).fold(0.0, worse);
            let case = |what: &str| format!("{what}, {elements} elements in the process zone, {name}");
            outcomes.extend([
                Outcome::absolute(
                    case("K over that of the straight crack, mean"),
                    1.0,
                    mean(|crack| crack.load) / straight.load,
                    *mean_bound,
                    "",
                ),
                Outcome::absolute(case("the farthest from it"), 1.0, farthest, *each_bound, ""),
                Outcome::absolute(
                    case("energy over G and projected area, mean"),
                    1.0,
                    mean(|crack| crack.energy),
                    *energy_bound,
                    "",
                ),
                Outcome::absolute(
                    case("length of the path over its projection, mean"),
                    1.0,
                    mean(|crack| crack.path),
                    0.12,
                    "",
                ),
                Outcome::absolute(
                    case("damage beside the path, mean"),
                    0.0,
                    mean(|crack| crack.beside),
                    0.12,
                    "",
                ),
            ]);
        }
    }
    Ok(outcomes)
}

/// Results of pulling a plate apart.
struct Pulled {
    /// Largest load, N for a thickness of 1 m. The stress intensity at growth is proportional to it.
    load: f64,
    /// Work done against the joints over the fracture energy of the ligament.
    energy: f64,
    /// Length of the broken joints over the ligament.
    path: f64,
    /// Sum of damage times length of the joints that hold, over the ligament.
    beside: f64,
}

/// Pulls a plate apart by its first two boundaries.
fn pull_apart(model: Model) -> Result<Pulled, String> {
    let mut run = start(model)?;
    let (mut peak, mut at) = (0.0_f64, 0.0);
    loop {
        let now = mean_load(&mut run)?;
        if now > peak {
            (peak, at) = (now, run.time());
        }
        if now < 0.1 * peak && run.time() > at + RAMP {
            break;
        }
        if run.time() > 50.0 * RAMP {
            return Err("the plate does not come apart".to_owned());
        }
    }
    // What is left of the last ligament breaks.
    advance(&mut run, 1500)?;
    let ligament = WIDTH - NOTCH;
    let broken: f64 = run.crack_lengths().iter().sum();
    let held = run.snapshot().cracks.into_iter().filter(|crack| crack.time.is_none());
    Ok(Pulled {
        load: peak,
        energy: run.energies().cohesive / (ENERGY * ligament),
        path: broken / ligament,
        beside: held.map(|crack| crack.damage * crack.length).sum::<f64>() / ligament,
    })
}

/// A plate with a sharp notch, whose crack is free.
fn free(insertion: Insertion, elements: u32, seed: u32) -> Result<Model, String> {
    let mesh_size = ZONE / f64::from(elements);
    let mouth = 0.3 * mesh_size;
    let mut model = prepared(&format!(
        r#"
[model]
plane = "stress"
gravity = "none"
end_time = 1
[[body]]
name = "plate"
material = "rock"
polygon = {{ points = [[0, -{HALF}], [{WIDTH}, -{HALF}], [{WIDTH}, {HALF}], [0, {HALF}], [0, {mouth}], [{NOTCH}, 0], [0, -{mouth}]] }}
mesh_size = {mesh_size}
seed = {seed}
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
fracture_energy_i = {ENERGY}
fracture_energy_ii = {sliding}
[[boundary]]
name = "lower end"
body = "plate"
side = "bottom"
velocity = [0, -{SPEED}]
ramp = {RAMP}
[[boundary]]
name = "upper end"
body = "plate"
side = "top"
velocity = [0, {SPEED}]
ramp = {RAMP}
"#,
        cohesion = 3.0 * TENSILE,
        sliding = 5.0 * ENERGY,
    ))?;
    model.fracture.insertion = insertion;
    Ok(model)
}

/// The same plate of a structured mesh, with a slit, that can break along the line of the slit only. Six elements are enough: it is the same with twelve.
fn straight(insertion: Insertion) -> Result<Model, String> {
    let plate = free(insertion, COARSE.elements, 1)?;
    let cells = |length: f64| (length / ZONE * f64::from(USUAL.elements)).round() as usize;
    let whole = rectangle([0.0, -HALF], [WIDTH, HALF], [cells(WIDTH), 2 * cells(HALF)]);
    let mesh = slit(&whole, NOTCH);
    let rock = &plate.materials[0];
    let strength = rock.strength;
    let half = Material { strength: None, ..rock.clone() };
    let end = |name: &str, sign: f64| {
        let nodes = nodes_where(&mesh, |[_, y]| sign * y > HALF - 1e-9);
        moved(name, nodes, [Some(0.0), Some(sign * SPEED)], Schedule::Ramp(RAMP))
    };
    let boundaries = vec![end("lower end", -1.0), end("upper end", 1.0)];
    Ok(Model {
        boundaries,
        mesh,
        materials: vec![half.clone(), half],
        interfaces: vec![Interface { materials: [0, 1], friction: rock.friction, penalty: None, strength }],
        ..plate
    })
}
