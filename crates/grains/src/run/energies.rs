//! The energies of a run.

use crate::run::balls::{ALONE, Balls};
use crate::run::clumps::Clumps;
use crate::run::contacts::Contacts;
use crate::run::laws::Laws;
use crate::run::on_walls::OnWalls;
use crate::vector::{Vector, dot, minus, times};
use crate::wall::Wall;

/// Energies of a run, J. `kinetic + rotational + elastic + weight + dissipated + on_bodies - external` is
/// constant up to the error of the time step.
///
/// They are those at the positions of the last step, of which its contacts are computed; before the first
/// step, those at the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GrainEnergies {
    /// Kinetic energy.
    pub kinetic: f64,
    /// Kinetic energy of the rotations.
    pub rotational: f64,
    /// Stored in contacts, along and across their normals.
    pub elastic: f64,
    /// Potential energy of the weight; 0 at the origin.
    pub weight: f64,
    /// Dissipated since the beginning: by dashpots, friction, rolling and twisting.
    pub dissipated: f64,
    /// Work from outside since the beginning: of walls that move, held spheres, boxes that grow, gravity that
    /// changes, a law of the caller; and the energy of spheres that came in less that of those that were
    /// removed.
    pub external: f64,
    /// Work of the spheres on bodies since the beginning, which is left out of `external`.
    pub on_bodies: f64,
}

/// Sums of spheres that the run has no more, and works of the whole run, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Gone {
    pub(crate) dissipated: f64,
    pub(crate) external: f64,
    pub(crate) on_bodies: f64,
}

/// All parts of a run that have energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnergyOf<'a> {
    pub(crate) balls: &'a Balls,
    pub(crate) contacts: &'a Contacts,
    /// Laws of contacts with walls, and of two spheres with each other.
    pub(crate) laws: &'a Laws,
    pub(crate) between: &'a Laws,
    pub(crate) on_walls: &'a OnWalls,
    pub(crate) clumps: &'a Clumps,
    /// Elastic energy of the contacts with triangles, J.
    pub(crate) on_facets: f64,
    /// Work against the motion of these contacts in the last step, and that of walls on them in it, J.
    pub(crate) in_step: [f64; 2],
    /// Work of a law of the caller in the last step, J.
    pub(crate) by_program: f64,
    pub(crate) walls: &'a [Wall],
    pub(crate) gone: Gone,
    /// m/s².
    pub(crate) gravity: Vector,
    /// Time step, s; 0 before the first step.
    pub(crate) step: f64,
}

/// All energies, added up in the order of the spheres' numbers.
pub(crate) fn energies(of: EnergyOf<'_>) -> GrainEnergies {
    let mut energies = GrainEnergies {
        dissipated: of.gone.dissipated,
        external: of.gone.external + of.gone.on_bodies,
        on_bodies: of.gone.on_bodies,
        ..GrainEnergies::default()
    };
    for &place in &of.balls.places {
        let (ball, drive) = (&of.balls.list[place as usize], &of.balls.drives[place as usize]);
        energies.dissipated += drive.dissipated;
        energies.external += drive.external;
        if of.balls.kinds[place as usize].clump != ALONE {
            continue;
        }
        // Half a step back, and a step back.
        let velocity = minus(times(2.0, drive.velocity), ball.velocity);
        let spin = minus(times(2.0, drive.spin), ball.spin);
        let position = minus(ball.position, times(of.step, drive.velocity));
        energies.kinetic += 0.5 * ball.mass * dot(velocity, velocity);
        energies.rotational += 0.5 * of.balls.inertia(place as usize) * dot(spin, spin);
        energies.weight -= ball.mass * dot(of.gravity, position);
    }
    let [kinetic, rotational, weight, external] = of.clumps.energies((of.gravity, of.step));
    energies.kinetic += kinetic;
    energies.rotational += rotational;
    energies.weight += weight;
    energies.external += external;
    let (elastic, [dissipated, external]) = of_contacts(of);
    energies.elastic = elastic;
    // Of the last step, only the first half is before the positions.
    energies.dissipated -= 0.5 * dissipated;
    energies.external -= 0.5 * external;
    energies
}

/// Elastic energy of all contacts, the energy that they have dissipated in the last step, and the work of
/// walls on them in it, J.
fn of_contacts(of: EnergyOf<'_>) -> (f64, [f64; 2]) {
    let (list, contacts) = (&of.balls.list, of.contacts);
    let mut sum = of.on_facets;
    let [mut dissipated, external] = of.in_step;
    let mut external = external + of.by_program;
    let number = |place: u32| list[place as usize].number;
    for &place in &of.balls.places {
        let ball = &list[place as usize];
        for entry in contacts.of(place as usize) {
            let contact = entry.contact();
            if entry.is_second() || contacts.memories[contact].contact() <= 0.0 {
                continue;
            }
            let other = contacts.couples[contact].places[1];
            debug_assert!(number(other) > ball.number, "the first has the lower number");
            let other = &list[other as usize];
            let radius = ball.radius * other.radius / (ball.radius + other.radius);
            if let Ok(law) = of.between.of([ball.material, other.material]) {
                let acting = &contacts.acting[contact];
                sum += law.energy(acting.overlap(), radius, &contacts.history(contact));
                dissipated += acting.dissipated();
            }
        }
    }
    for touch in &of.on_walls.touches {
        let ball = &list[touch.outer.place as usize];
        if let Ok(law) = of.laws.of([ball.material, of.walls[touch.wall as usize].material]) {
            sum += law.energy(touch.overlap, ball.radius, &touch.history);
            dissipated += touch.outer.dissipated;
            external += touch.outer.external;
        }
    }
    (sum, [dissipated, external])
}
