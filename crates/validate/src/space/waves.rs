//! Waves that leave through absorbing faces, stress that stays, and a bar that spalls.

use std::f64::consts::PI;

use fdem_simulation::{Load, Material, Model, Schedule, Strength};

use super::bodies::{Body, Point, advance, advance_to, cuboid, faces_where, jittered, loaded, on_box, start};
use crate::models::{DENSITY, granite, moved, nodes_where, rock};
use crate::{Outcome, Size};

/// A column of cells along z.
fn column(width: f64, long: f64, cells: [usize; 2], seed: u64) -> Body {
    let max = [width, width, long];
    let mesh = cuboid([0.0; 3], max, [cells[0], cells[0], cells[1]]);
    jittered(&mesh, 0.1 * width / cells[0] as f64, seed, on_box([0.0; 3], max))
}

/// A plane wave, of pressure or of shear, meets an absorbing face straight on and leaves: dashpots of the
/// impedances `ρ c` act like a column that continues (Lysmer and Kuhlemeyer, J. Eng. Mech. Div. 95 (1969)
/// 859-877). A block under initial stress whose sides all absorb stays at rest.
pub(crate) fn absorbing(size: Size) -> Result<Vec<Outcome>, String> {
    let mut outcomes = Vec::new();
    let across = size.choose(2, 3);
    let (width, long) = (0.02, 0.4);
    for (name, axis) in [("pressure", 2), ("shear", 0)] {
        let mesh = column(width, long, [across, 20 * across], 1);
        let all = nodes_where(&mesh, |_: Point| true);
        let end = faces_where(&mesh, |p| p[2] > long - 1e-9);
        let front = nodes_where(&mesh, |p: Point| p[2] < 1e-9);
        let inside: Vec<u32> = all.iter().copied().filter(|node| !front.contains(node)).collect();
        // A pulse half as long as the column. The springs of the ground reflect longer ones.
        let rock = Material { poissons_ratio: 0.25, ..granite() };
        let modulus = rock.youngs_modulus / 1.25 * if axis == 2 { 1.5 } else { 0.5 };
        let speed = f64::sqrt(modulus / rock.density);
        let pulse = 0.5 * long / speed;
        // Only motion along one axis: a plane wave.
        let others = std::array::from_fn(|k| (k != axis).then_some(0.0));
        let along = std::array::from_fn(|k| if k == axis { Some(1.0) } else { Some(0.0) });
        let bump = (0..=40).map(|k| {
            let share = f64::from(k) / 40.0;
            let turn = std::f64::consts::TAU * share;
            // Without displacement in the end, which the springs of the ground would push back.
            [pulse * share, 0.5 * (1.0 - turn.cos()) * turn.sin()]
        });
        let model = Model {
            boundaries: vec![
                moved("front", front, along, Schedule::Table(bump.collect())),
                moved("others", inside, others, Schedule::Constant),
                loaded("end", end, Load::Absorbing, Schedule::Constant),
            ],
            mesh,
            materials: vec![rock],
            ..Model::default()
        };
        let mut run = start(model)?;
        let mut most = 0.0_f64;
        while run.time() < pulse {
            advance(&mut run, 5)?;
            most = most.max(run.energies().kinetic);
        }
        advance_to(&mut run, 1.15 * long / speed + pulse)?;
        let energies = run.energies();
        let left = (energies.kinetic / most).sqrt();
        outcomes.push(Outcome::absolute(
            format!("{name} wave: amplitude that is reflected"),
            0.0,
            left,
            0.06,
            "",
        ));
        let name = format!("{name} wave: error of the energy balance");
        outcomes.push(Outcome::absolute(name, 0.0, energies.error(), 1e-4, ""));
    }
    let stress = [[-2e6, 0.3e6, 0.4e6], [0.3e6, -3e6, 0.5e6], [0.4e6, 0.5e6, -5e6]];
    let mesh = column(0.1, 0.1, [size.choose(3, 6); 2], 2);
    let faces = faces_where(&mesh, |_| true);
    // Outer faces are those that only one element has.
    let mut keys: Vec<[u32; 3]> = faces
        .iter()
        .map(|face| {
            let mut key = *face;
            key.sort_unstable();
            key
        })
        .collect();
    keys.sort_unstable();
    let outer = |face: &[u32; 3]| {
        let mut key = *face;
        key.sort_unstable();
        let first = keys.partition_point(|other| *other < key);
        keys.get(first + 1) != Some(&key)
    };
    let outside = faces.iter().copied().filter(outer).collect();
    let model = Model {
        stresses: vec![stress; mesh.elements.len()],
        boundaries: vec![loaded("ground", outside, Load::Absorbing, Schedule::Constant)],
        mesh,
        materials: vec![Material { poissons_ratio: 0.25, ..granite() }],
        ..Model::default()
    };
    let mut run = start(model)?;
    advance(&mut run, 2000)?;
    let energies = run.energies();
    outcomes.push(Outcome::absolute(
        "block under initial stress: kinetic over strain energy",
        0.0,
        energies.kinetic / energies.strain,
        1e-18,
        "",
    ));
    Ok(outcomes)
}

/// A bar whose free end reflects a pulse of pressure that rises to `s` and falls linearly over the length
/// `λ`. The tension of the reflected crest less the pressure that still comes is `2 s x/λ` at the distance
/// `x` from the end: it first reaches the strength `f` at `x = λ f/(2 s)` (Rinehart 1952).
///
/// The mesh slows short waves down: behind a sharp bend of the pulse the stress swings, and the bar would
/// break there too early. The pulse therefore rises as a cosine over the length `r`. The tension is then
/// greatest a little before the crest, where the rise is as steep as the fall: `w = (r/π) asin(2 r/(π λ))`
/// before it, where the pressure is `s (1 + cos(π w/r))/2`. With both, the bar spalls at
/// `x = (λ/2) (f/s + w/λ + (1 - cos(π w/r))/2)`.
pub(crate) fn spall(size: Size) -> Result<Vec<Outcome>, String> {
    let (across, along) = size.choose((1, 120), (2, 240));
    let (long, peak, strength) = (0.6, 20e6, 8e6);
    let width = long / 120.0;
    let c = f64::sqrt(granite().youngs_modulus / DENSITY);
    let (rise, fall) = (16.0 * width / c, 0.2 / c);
    let mesh = column(width, long, [across, along], 3);
    let faces = faces_where(&mesh, |p| p[2] < 1e-9);
    let mut pulse: Vec<[f64; 2]> = (0..=40)
        .map(|k| f64::from(k) / 40.0)
        .map(|share| [rise * share, 0.5 - 0.5 * (PI * share).cos()])
        .collect();
    pulse.push([rise + fall, 0.0]);
    let breaks =
        Strength { tensile: strength, cohesion: 5.0 * strength, energy_i: 2.0, energy_ii: 200.0, ..rock() };
    let model = Model {
        boundaries: vec![loaded("blast", faces, Load::Pressure(peak), Schedule::Table(pulse))],
        mesh,
        materials: vec![Material { strength: Some(breaks), ..granite() }],
        ..Model::default()
    };
    let mut run = start(model)?;
    while run.counts().joints == 0 {
        advance(&mut run, 1)?;
        if run.time() > 3.0 * long / c {
            return Err("the bar does not spall".to_owned());
        }
    }
    // The first joints, once they have begun to open.
    let first = run.time();
    advance_to(&mut run, first + 0.25 * long / along as f64 / c)?;
    let middle = |corners: [Point; 3]| corners.iter().map(|corner| corner[2]).sum::<f64>() / 3.0;
    let places: Vec<f64> = run.snapshot().cracks.iter().map(|crack| middle(crack.corners)).collect();
    let place = places.iter().sum::<f64>() / places.len() as f64;
    let before = (2.0 * rise / (PI * fall)).asin() * rise / PI;
    let lower = 0.5 - 0.5 * (PI * before / rise).cos();
    let expected = 0.5 * fall * c * (strength / peak + before / fall + lower);
    advance_to(&mut run, 1.6 * long / c)?;
    Ok(vec![
        Outcome::absolute(
            "place of the first spall from the free end, in cells",
            expected / (long / along as f64),
            (long - place) / (long / along as f64),
            1.0,
            "",
        ),
        Outcome::absolute("error of the energy balance", 0.0, run.energies().error(), 1e-3, ""),
    ])
}
