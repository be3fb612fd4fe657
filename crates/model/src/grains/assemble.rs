//! The model of spheres and walls, put together.

use std::f64::consts::PI;

use fdem_mesh::Corners;
use fdem_simulation::Material;
use fdem_simulation::grains::{Domain, ForceLaw, GrainModel, Outside, Spheres};

use crate::grains::overlaps::Beginning;
use crate::grains::spheres::{self, Balls, in_space};
use crate::grains::{surfaces, walls};
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
    if file.grains.is_empty() {
        return None;
    }
    let known = faults.len();
    let discs = D == 2;
    let groups = groups(file, document, discs, load, faults);
    let mut all = Vec::new();
    for (index, wall) in file.wall.iter().enumerate() {
        match walls::wall(file, wall, discs, load) {
            Ok(wall) => all.push(wall),
            Err(problem) => faults.push(fault(document, Table::of("wall", index), problem)),
        }
    }
    let surfaces = surfaces::surfaces(file, document, faults);
    if faults.len() > known {
        return None;
    }
    let mut notes = surfaces::without_effect(file, &surfaces);
    let mut prepared = PreparedSpheres {
        groups: Vec::new(),
        walls: file.wall.iter().map(|wall| wall.name.clone()).collect(),
        discs,
    };
    let mut spheres = Spheres::default();
    for (index, (table, group)) in file.grains.iter().zip(groups.into_iter().flatten()).enumerate() {
        let material = file.material.iter().position(|of| of.name == table.material).unwrap_or(0);
        let density = materials[material].density;
        prepared.groups.push(summary(file, table, (&group.balls, group.fraction), density, discs));
        notes.extend(group.notes);
        add(&mut spheres, table, &group.balls, [material as u32, index as u32]);
    }
    let beginning = Beginning { spheres: &spheres, groups: &prepared.groups, discs, document };
    beginning.among_spheres(faults);
    beginning.on_walls(&all, faults);
    beginning.in_bodies(placed, faults);
    let model = GrainModel {
        spheres,
        walls: all,
        materials: surfaces::materials(materials),
        surfaces,
        law: law(file),
        gravity: match &file.model.gravity {
            Gravity::Vector(gravity) => in_space(gravity),
            Gravity::None(_) => [0.0; 3],
        },
        groups: file.grains.iter().map(|grains| grains.name.clone()).collect(),
        discs: discs.then_some(file.model.thickness),
        domain: file.domain.as_ref().map(domain),
        step: match file.model.time_step {
            TimeStep::Seconds(step) => Some(step),
            TimeStep::Auto(_) => None,
        },
        ..GrainModel::default()
    };
    if faults.len() == known
        && let Err(error) = model.check()
    {
        let span = document.value(Table::of("grains", 0), "name");
        faults.push(Fault::at(span, format!("the spheres cannot be simulated: {error}")));
    }
    Some(Assembled { model, prepared, notes })
}

/// The spheres of all tables; `None` for those with faults. Packings leave room for all others.
fn groups(
    file: &ModelFile,
    document: &Document<'_>,
    discs: bool,
    load: &mut Load<'_>,
    faults: &mut Vec<Fault>,
) -> Vec<Option<spheres::PlacedSpheres>> {
    let mut groups = Vec::new();
    let mut others: Balls = Vec::new();
    for (index, grains) in file.grains.iter().enumerate() {
        let group = spheres::given(grains, discs, load).unwrap_or_else(|problem| {
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
        match spheres::packed(grains, discs, &others, load) {
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

/// Adds the spheres of a table. `[material, group]`: their numbers.
fn add(spheres: &mut Spheres, table: &file::Grains, balls: &Balls, [material, group]: [u32; 2]) {
    let velocity = table.velocity.as_ref().map_or([0.0; 3], in_space);
    let spin = table.spin.map_or([0.0; 3], file::Spin::vector);
    for &(centre, radius) in balls {
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
    (balls, fraction): (&Balls, Option<f64>),
    density: f64,
    discs: bool,
) -> SphereGroup {
    let radii = || balls.iter().map(|ball| ball.1);
    let volume = |radius: f64| {
        if discs {
            PI * radius * radius * file.model.thickness
        } else {
            4.0 / 3.0 * PI * radius * radius * radius
        }
    };
    SphereGroup {
        name: table.name.clone(),
        count: balls.len(),
        radii: [radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max)],
        mass: density * radii().map(volume).sum::<f64>(),
        fraction,
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

/// The domain. Along axes that the model has not it is infinite.
fn domain(of: &file::Domain) -> Domain {
    let (low, high) = of.limits.split_at(of.limits.len() / 2);
    let component = |list: &[f64], axis: usize, without: f64| list.get(axis).copied().unwrap_or(without);
    let axes = [(0, DomainAxis::X), (1, DomainAxis::Y), (2, DomainAxis::Z)];
    Domain {
        low: axes.map(|(axis, _)| component(low, axis, f64::NEG_INFINITY)),
        high: axes.map(|(axis, _)| component(high, axis, f64::INFINITY)),
        periodic: axes.map(|(_, axis)| of.periodic.contains(&axis)),
        strain_rates: of.strain_rate.as_ref().map_or([0.0; 3], in_space),
        outside: match of.outside {
            OutsideWord::Stop => Outside::Stop,
            OutsideWord::Delete => Outside::Delete,
        },
    }
}
