//! The model of spheres and walls, put together.

use std::f64::consts::PI;

use fdem_mesh::Corners;
use fdem_simulation::Material;
use fdem_simulation::grains::{BoxServo, Clump, ClumpShape, Domain, ForceLaw, GrainModel, Outside, Wall};

use crate::grains::overlaps::Beginning;
use crate::grains::spheres::{self, Balls, PlacedSpheres, in_space};
use crate::grains::{clumps, coming, surfaces, walls};
use crate::prepared::{PreparedSpheres, SphereGroup};
use crate::shapes::placed::Placed;
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, Problem};
use crate::text::file::{self, DomainAxis, Gravity, ModelFile, OutsideWord, SphereLaw, TimeStep};
use crate::text::included::Load;

/// Stiffness across the normal over that along it, of Hooke's law.
const TANGENTIAL: f64 = 2.0 / 7.0;

/// Spheres, with the groups that are shown before a run, and notes on their files.
pub(crate) struct Assembled {
    pub(crate) model: GrainModel,
    pub(crate) prepared: PreparedSpheres,
    pub(crate) notes: Vec<String>,
}

/// The spheres and walls of a file whose tables have been checked; `None` without spheres, or with faults.
pub(crate) fn assemble<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    (materials, placed): (&[Material], &[Placed<D, N>]),
    load: &mut Load<'_>,
    faults: &mut Vec<Fault>,
) -> Option<Assembled>
where
    [[f64; D]; N]: Corners<D, N>,
{
    if !file.has_spheres() {
        return None;
    }
    let known = faults.len();
    let discs = D == 2;
    let shapes: Vec<Option<ClumpShape>> = file
        .grains
        .iter()
        .map(|grains| clumps::shape(grains, discs.then_some(file.model.thickness)))
        .collect();
    let groups = groups(file, document, (discs, &shapes), load, faults);
    let all = walls_of(file, document, discs, load, faults);
    let surfaces = surfaces::surfaces(file, document, faults);
    if faults.len() > known {
        return None;
    }
    let mut notes = surfaces::without_effect(file, &surfaces);
    let mut prepared = PreparedSpheres {
        walls: file.wall.iter().map(|wall| wall.name.clone()).collect(),
        discs,
        ..PreparedSpheres::default()
    };
    let number = |name: &str| file.material.iter().position(|of| of.name == name).unwrap_or(0);
    let mut model = GrainModel::default();
    for (index, (table, group)) in file.grains.iter().zip(groups.into_iter().flatten()).enumerate() {
        let material = number(&table.material);
        let density = materials[material].density;
        let begin = model.clumps.len();
        let numbers = [material as u32, index as u32];
        add(&mut model, table, &group, (shapes[index].as_ref(), density), numbers);
        prepared.groups.push(summary(file, table, (&group, &model.clumps[begin..]), density, discs));
        notes.extend(group.notes);
    }
    for (index, table) in file.insertion.iter().enumerate() {
        let material = number(&table.material);
        let numbers = [material as u32, (file.grains.len() + index) as u32];
        match coming::insertion(file, table, discs, (materials[material].density, numbers)) {
            Ok((insertion, coming)) => {
                model.insertions.push(insertion);
                prepared.insertions.push(coming);
            }
            Err(problem) => faults.push(fault(document, Table::of("insertion", index), problem)),
        }
    }
    (model.removals, prepared.removals) = file.delete.iter().map(coming::removal).unzip();
    notes.extend(coming::without_effect(file));
    notes.extend(coming::without_room(file, &model.insertions, discs));
    notes.extend(clumps::in_pieces(file, &shapes));
    let (spheres, clumps, insertions) = (&model.spheres, &model.clumps, &model.insertions);
    let boxed = |of: &file::Domain| domain(of, file.model.thickness);
    let beginning = Beginning { spheres, clumps, insertions, groups: &prepared.groups, discs, document };
    beginning.among_spheres(faults);
    beginning.on_walls(&all, faults);
    beginning.outside(file.domain.as_ref().map(boxed), faults);
    beginning.in_bodies(placed, faults);
    beginning.without_room(&all, faults);
    let model = GrainModel {
        walls: all,
        materials: surfaces::materials(materials),
        surfaces,
        law: law(file),
        gravity: match &file.model.gravity {
            Gravity::Vector(gravity) => in_space(gravity),
            Gravity::None(_) => [0.0; 3],
        },
        groups: file.groups_of_spheres().map(str::to_owned).collect(),
        discs: discs.then_some(file.model.thickness),
        domain: file.domain.as_ref().map(boxed),
        step: match file.model.time_step {
            TimeStep::Seconds(step) => Some(step),
            TimeStep::Auto(_) => None,
        },
        ..model
    };
    if faults.len() == known
        && let Err(error) = model.check()
    {
        let table = if file.grains.is_empty() { "insertion" } else { "grains" };
        let span = document.value(Table::of(table, 0), "name");
        faults.push(Fault::at(span, format!("the spheres cannot be simulated: {error}")));
    }
    Some(Assembled { model, prepared, notes })
}

/// The walls of all tables without faults.
fn walls_of(
    file: &ModelFile,
    document: &Document<'_>,
    discs: bool,
    load: &mut Load<'_>,
    faults: &mut Vec<Fault>,
) -> Vec<Wall> {
    let mut all = Vec::new();
    for (index, wall) in file.wall.iter().enumerate() {
        match walls::wall(file, wall, discs, load) {
            Ok(wall) => all.push(wall),
            Err(problem) => faults.push(fault(document, Table::of("wall", index), problem)),
        }
    }
    all
}

/// The spheres of all tables; `None` for those with faults. Packings leave room for all others.
fn groups(
    file: &ModelFile,
    document: &Document<'_>,
    (discs, shapes): (bool, &[Option<ClumpShape>]),
    load: &mut Load<'_>,
    faults: &mut Vec<Fault>,
) -> Vec<Option<PlacedSpheres>> {
    let mut groups = Vec::new();
    let mut others: Balls = Vec::new();
    for (index, grains) in file.grains.iter().enumerate() {
        let group = spheres::given(grains, (discs, shapes[index].as_ref()), load).unwrap_or_else(|problem| {
            faults.push(fault(document, Table::of("grains", index), problem));
            None
        });
        others.extend(group.iter().flat_map(|group| group.balls.iter().copied()));
        groups.push(group);
    }
    for (index, grains) in file.grains.iter().enumerate() {
        if groups[index].is_some() || grains.within.is_none() {
            continue;
        }
        match spheres::packed(grains, (discs, shapes[index].as_ref()), &others, load) {
            Ok(group) => {
                others.extend_from_slice(&group.balls);
                groups[index] = Some(group);
            }
            Err(problem) => faults.push(fault(document, Table::of("grains", index), problem)),
        }
    }
    groups
}

fn fault(document: &Document<'_>, table: Table, problem: Problem) -> Fault {
    Fault::at(document.value(table, &problem.key), problem.message).maybe_help(problem.help)
}

/// Adds the spheres and clumps of a table. `[material, group]`: their numbers; `shape`: of clumps.
fn add(
    model: &mut GrainModel,
    table: &file::Grains,
    placed: &PlacedSpheres,
    (shape, density): (Option<&ClumpShape>, f64),
    [material, group]: [u32; 2],
) {
    let own = table.velocity.as_ref().map_or([0.0; 3], in_space);
    let own_spin = table.spin.map_or([0.0; 3], file::Spin::vector);
    // The spheres of a clump have its motion.
    let (velocity, spin) = if shape.is_some() { ([0.0; 3], [0.0; 3]) } else { (own, own_spin) };
    let GrainModel { spheres, clumps, .. } = model;
    let first = spheres.positions.len() as u32;
    if let Some(shape) = shape {
        let count = shape.count() as u32;
        for (number, of) in (0..).zip(&placed.clumps) {
            let begin = first + number * count;
            clumps.push(Clump {
                spheres: (begin..begin + count).collect(),
                velocity: own,
                spin: own_spin,
                inertia: Some(shape.inertia(of.at, of.turn, of.scale, density)),
            });
        }
    }
    for &(centre, radius) in &placed.balls {
        spheres.positions.push(centre);
        spheres.radii.push(radius);
        spheres.velocities.push(velocity);
        spheres.spins.push(spin);
        spheres.materials.push(material);
        spheres.held.push(table.fixed);
        spheres.groups.push(group);
    }
}

/// The group of a table for messages.
fn summary(
    file: &ModelFile,
    table: &file::Grains,
    (placed, clumps): (&PlacedSpheres, &[Clump]),
    density: f64,
    discs: bool,
) -> SphereGroup {
    let radii = || placed.balls.iter().map(|ball| ball.1);
    let volume = |radius: f64| {
        if discs {
            PI * radius * radius * file.model.thickness
        } else {
            4.0 / 3.0 * PI * radius * radius * radius
        }
    };
    SphereGroup {
        name: table.name.clone(),
        count: placed.balls.len(),
        clumps: clumps.len(),
        radii: [radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max)],
        mass: if clumps.is_empty() {
            density * radii().map(volume).sum::<f64>()
        } else {
            clumps.iter().filter_map(|clump| clump.inertia).map(|of| of.mass).sum()
        },
        fraction: placed.fraction,
    }
}

fn law(file: &ModelFile) -> ForceLaw {
    match (file.spheres.law, file.spheres.stiffness) {
        (SphereLaw::Hooke, Some(normal)) => {
            ForceLaw::Hooke { normal, tangential: file.spheres.tangential_ratio.unwrap_or(TANGENTIAL) }
        }
        _ => ForceLaw::HertzMindlin,
    }
}

/// The domain. Along the third axis of discs it has their thickness, m.
fn domain(of: &file::Domain, thickness: f64) -> Domain {
    let (low, high) = of.limits.split_at(of.limits.len() / 2);
    let component = |list: &[f64], axis: usize, without: f64| list.get(axis).copied().unwrap_or(without);
    let axes = [(0, DomainAxis::X), (1, DomainAxis::Y), (2, DomainAxis::Z)];
    Domain {
        low: axes.map(|(axis, _)| component(low, axis, -0.5 * thickness)),
        high: axes.map(|(axis, _)| component(high, axis, 0.5 * thickness)),
        periodic: axes.map(|(_, axis)| of.periodic.contains(&axis)),
        strain_rates: of.strain_rate.as_ref().map_or([0.0; 3], in_space),
        strain_from: of.strain_from,
        servo: of.servo.map(|servo| BoxServo { pressures: servo.pressures(), largest_rate: servo.rate }),
        outside: match of.outside {
            OutsideWord::Stop => Outside::Stop,
            OutsideWord::Delete => Outside::Delete,
        },
    }
}
