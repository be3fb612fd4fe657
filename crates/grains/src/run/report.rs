//! The spheres and their contacts as results show them.

use crate::columns::{GrainContact, GrainPartner, SphereColumns};
use crate::run::balls::Balls;
use crate::run::cell::RunBox;
use crate::run::contacts::Contacts;
use crate::run::on_walls::OnWalls;
use crate::vector::{dot, length, minus, plus, times};

/// Contacts of two spheres in the last step, in ascending order; spheres by their ranks among all.
pub(crate) fn between(balls: &Balls, of: &Contacts, cell: Option<&RunBox>, step: f64) -> Vec<GrainContact> {
    let mut ranks = vec![0_u32; balls.list.len()];
    for (rank, &place) in (0..).zip(&balls.places) {
        ranks[place as usize] = rank;
    }
    let mut contacts = Vec::new();
    for &place in &balls.places {
        for entry in of.of(place as usize) {
            let contact = entry.contact();
            if entry.is_second() || of.memories[contact].contact() <= 0.0 {
                continue;
            }
            let acting = &of.acting[contact];
            let other = of.couples[contact].places[1] as usize;
            // Where the spheres were in that step.
            let position =
                |place: usize| minus(balls.list[place].position, times(step, balls.drives[place].velocity));
            let centre = position(place as usize);
            let apart = minus(centre, position(other));
            let apart = cell.map_or(apart, |cell| cell.shortest(apart));
            let normal = times(1.0 / length(apart).max(f64::MIN_POSITIVE), apart);
            let arm = balls.list[place as usize].radius - 0.5 * acting.overlap();
            contacts.push(GrainContact {
                sphere: ranks[place as usize],
                other: GrainPartner::Sphere(ranks[other]),
                place: minus(centre, times(arm, normal)),
                force: acting.force(),
                normal: dot(acting.force(), normal),
                overlap: acting.overlap(),
            });
        }
    }
    contacts
}

/// Numbers of all spheres, ascending.
pub(crate) fn numbers(balls: &Balls) -> Vec<u32> {
    balls.places.iter().map(|&place| balls.list[place as usize].number).collect()
}

/// Contacts with walls in the last step, in ascending order of their spheres.
pub(crate) fn on_walls(balls: &Balls, walls: &OnWalls) -> Vec<GrainContact> {
    let numbers = numbers(balls);
    let contact = |touch: &crate::run::on_walls::WallTouch| {
        let rank = numbers.binary_search(&touch.number).ok()?;
        Some(GrainContact {
            sphere: rank as u32,
            other: GrainPartner::Wall(touch.wall),
            place: touch.at,
            force: touch.outer.force,
            normal: dot(touch.outer.force, touch.normal),
            overlap: touch.overlap,
        })
    };
    let mut contacts: Vec<GrainContact> = walls.touches.iter().filter_map(contact).collect();
    contacts.sort_by_key(|contact| contact.sphere);
    contacts
}

/// Contacts with triangles in ascending order of their spheres, which have their numbers so far.
pub(crate) fn on_facets(balls: &Balls, of: impl Iterator<Item = GrainContact>) -> Vec<GrainContact> {
    let numbers = numbers(balls);
    let contact = |of: GrainContact| {
        let rank = numbers.binary_search(&of.sphere).ok()?;
        Some(GrainContact { sphere: rank as u32, ..of })
    };
    of.filter_map(contact).collect()
}

/// The spheres with these contacts.
pub(crate) fn columns(balls: &Balls, contacts: Vec<GrainContact>) -> SphereColumns {
    let mut forces = vec![[0.0; 3]; balls.list.len()];
    for contact in &contacts {
        let force = &mut forces[contact.sphere as usize];
        *force = plus(*force, contact.force);
        if let GrainPartner::Sphere(other) = contact.other {
            forces[other as usize] = minus(forces[other as usize], contact.force);
        }
    }
    let places = || balls.places.iter().map(|&place| place as usize);
    SphereColumns {
        numbers: places().map(|place| balls.list[place].number).collect(),
        positions: places().map(|place| balls.list[place].position).collect(),
        radii: places().map(|place| balls.list[place].radius).collect(),
        velocities: places().map(|place| balls.drives[place].velocity).collect(),
        spins: places().map(|place| balls.drives[place].spin).collect(),
        forces,
        masses: places().map(|place| balls.share_of_mass(place)).collect(),
        materials: places().map(|place| balls.list[place].material).collect(),
        groups: places().map(|place| balls.kinds[place].group).collect(),
        contacts,
        ..SphereColumns::default()
    }
}
