//! Boundaries: finds the nodes and edges of the mesh that they act on.

use std::collections::BTreeSet;

use fdem_mesh::Mesh;
use fdem_simulation::{Boundary, Load, Target};

use crate::bodies::dimensions::Dimensions;
use crate::shapes::placed::{self, Placed, is_piece};
use crate::stages::cavities;
use crate::stages::places::{Place, PlaceKeys};
use crate::stages::schedules::Factor;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, Component, ModelFile};
use crate::text::included;

/// Checks boundaries before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        match loads(boundary)[..] {
            [_] => {}
            [] => faults.push(
                Fault::at(document.key(table, "name"), format!("{title} does nothing"))
                    .label("this boundary")
                    .help(
                        "give it one of fixed, velocity, displacement, rotation, force, traction, pressure, absorbing",
                    ),
            ),
            [first, second, ..] => faults.push(
                Fault::at(
                    document.key(table, second),
                    format!("{title} has two loads, {first} and {second}"),
                )
                .label("a second load")
                .help("a boundary has one load; write a second [[boundary]]"),
            ),
        }
        if let [first, second, ..] = places(boundary)[..] {
            faults.push(
                Fault::at(
                    document.key(table, second),
                    format!("{title} is in two places, {first} and {second}"),
                )
                .label("a second place")
                .help("take one of side, sides, box, group and at"),
            );
        }
        let inverted = |limits: &Vec<f64>| {
            let (least, most) = limits.split_at(limits.len() / 2);
            least.iter().zip(most).any(|(least, most)| most < least)
        };
        if boundary.limits.as_ref().is_some_and(inverted) {
            faults.push(
                Fault::at(document.value(table, "box"), format!("{title}: its box is turned inside out"))
                    .help("a box is [xmin, ymin, xmax, ymax], in three dimensions [xmin, ymin, zmin, xmax, ymax, zmax]"),
            );
        }
    }
}

/// The keys of loads that are given.
fn loads(boundary: &file::Boundary) -> Vec<&'static str> {
    [
        ("fixed", boundary.fixed.is_some()),
        ("velocity", boundary.velocity.is_some()),
        ("displacement", boundary.displacement.is_some()),
        ("rotation", boundary.rotation.is_some()),
        ("force", boundary.force.is_some()),
        ("traction", boundary.traction.is_some()),
        ("pressure", boundary.pressure.is_some()),
        ("absorbing", boundary.absorbing),
    ]
    .into_iter()
    .filter(|(_, given)| *given)
    .map(|(key, _)| key)
    .collect()
}

/// The keys of places that are given.
fn places(boundary: &file::Boundary) -> Vec<&'static str> {
    [
        ("side", boundary.side.is_some()),
        ("sides", boundary.sides.is_some()),
        ("box", boundary.limits.is_some()),
        ("group", boundary.group.is_some()),
        ("at", boundary.at.is_some()),
    ]
    .into_iter()
    .filter(|(_, given)| *given)
    .map(|(key, _)| key)
    .collect()
}

/// The help for a boundary in whose place there is nothing.
fn help_in_empty_place(file: &ModelFile, boundary: &file::Boundary) -> Option<String> {
    let is_turned =
        |body: &file::Body| body.angle != 0.0 && boundary.body.as_ref().is_none_or(|name| *name == body.name);
    let is_side = places(boundary).first().is_some_and(|key| key.starts_with("side"));
    let help = if boundary.at.is_some() {
        "a cavity is in a hole or on an open joint"
    } else if is_side && file.body.iter().any(is_turned) {
        "a side is where the box around the turned body ends; take a box around the edges, or a group"
    } else {
        return None;
    };
    Some(help.to_owned())
}

/// The boundaries with the nodes and edges that they act on. Boundaries of missing bodies, by their tables,
/// and boundaries with known errors are left out.
pub(crate) fn resolve<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    mesh: &Mesh<D, N>,
    placed: &[Placed<D, N>],
    (missing, wrong): (&BTreeSet<usize>, &[bool]),
    read: &mut included::Load<'_>,
    faults: &mut Vec<Fault>,
) -> Vec<Boundary<D>>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mut boundaries = Vec::with_capacity(file.boundary.len());
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        let Some(load) = load(boundary) else { continue };
        let mut lacking = missing.iter().map(|&table| &file.body[table].name);
        let lacks = match &boundary.body {
            // A file with no body that can be read has no place for boundaries.
            None => !missing.is_empty() || file.body.is_empty(),
            Some(name) => lacking.any(|body| body == name || is_piece(body, name)),
        };
        if lacks || wrong[index] {
            continue;
        }
        let bodies = match &boundary.body {
            None => (0..placed.len()).collect(),
            Some(name) => placed::named(placed, file, name),
        };
        if let (Some(name), []) = (&boundary.body, &bodies[..]) {
            faults.push(
                Fault::at(document.value(table, "body"), format!("there is no body \"{name}\""))
                    .label("unknown body")
                    .help(placed::suggestion(file, name)),
            );
            continue;
        }
        let keys = PlaceKeys {
            sides: boundary.all_sides().collect(),
            limits: boundary.limits.as_deref(),
            group: boundary.group.as_deref(),
        };
        let place = Place { keys, mesh, placed, bodies: &bodies };
        if let Err(help) = place.check_group() {
            let group = boundary.group.as_deref().unwrap_or("");
            faults.push(
                Fault::at(document.value(table, "group"), format!("no body here has a group \"{group}\""))
                    .label("unknown group")
                    .help(help),
            );
            continue;
        }
        let (target, count, what) = if load.summary().on_facets {
            let mut facets = place.facets();
            if let Some(point) = &boundary.at {
                facets = cavities::at(point.components(), &facets, mesh, file, placed);
            }
            let count = facets.len();
            (Target::Facets(facets), count, <[[f64; D]; N]>::OUTER_FACET)
        } else {
            let nodes = place.nodes();
            let count = nodes.len();
            (Target::Nodes(nodes), count, "node")
        };
        if count == 0 {
            let key = places(boundary).first().copied().unwrap_or("body");
            faults.push(
                Fault::at(
                    document.value(table, key),
                    format!("[[boundary]] \"{}\" is in a place where there is no {what}", boundary.name),
                )
                .label("nothing there")
                .maybe_help(help_in_empty_place(file, boundary)),
            );
            continue;
        }
        // Boundaries that act in different stages do not meet.
        let meets = |other: &&Boundary<D>| {
            let other = file.boundary.iter().find(|of_file| of_file.name == other.name);
            other.is_none_or(|other| act_together(boundary.stages.as_deref(), other.stages.as_deref()))
        };
        if let Some((other, node, axis)) = prescribed_twice(&boundaries.iter().filter(meets), load, &target) {
            let axis = ["x", "y", "z"][axis];
            faults.push(
                Fault::at(
                    document.value(table, "name"),
                    format!(
                        "\"{}\" and \"{other}\" both prescribe how node {node} moves along {axis}",
                        boundary.name
                    ),
                )
                .label("the second of the two")
                .help(
                    "leave that component \"free\" in one of them, or take two places without common nodes",
                ),
            );
            continue;
        }
        let schedule =
            Factor::of_boundary(boundary, index).schedule(file.model.end_time, document, read, faults);
        let boundary = Boundary { name: boundary.name.clone(), target, load, schedule };
        cavities::check_gas(&boundary, (document, table), faults);
        boundaries.push(boundary);
    }
    boundaries
}

/// Whether there is a stage in which both act, by the names of the stages in which each does.
pub(crate) fn act_together(one: Option<&[String]>, other: Option<&[String]>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => one.iter().any(|stage| other.contains(stage)),
        _ => true,
    }
}

/// The name of a boundary that moves a node along the same axis as this load does. Two may both hold a node
/// still.
fn prescribed_twice<'a, const D: usize>(
    boundaries: &(impl Iterator<Item = &'a Boundary<D>> + Clone),
    load: Load<D>,
    target: &Target<D>,
) -> Option<(String, u32, usize)> {
    let components = |load: Load<D>| match load {
        Load::Velocity(components) | Load::Displacement(components) => components,
        // It moves nodes along all axes.
        Load::Rotation { .. } => [Some(1.0); D],
        _ => [None; D],
    };
    let still = |load: Load<D>, axis: usize| matches!(load, Load::Velocity(of) if of[axis] == Some(0.0));
    let Target::Nodes(nodes) = target else { return None };
    for axis in (0..D).filter(|&axis| components(load)[axis].is_some()) {
        for other in boundaries.clone().filter(|other| components(other.load)[axis].is_some()) {
            let Target::Nodes(own) = &other.target else { continue };
            if still(load, axis) && still(other.load, axis) {
                continue;
            }
            let own: BTreeSet<u32> = own.iter().copied().collect();
            if let Some(&node) = nodes.iter().find(|node| own.contains(node)) {
                return Some((other.name.clone(), node, axis));
            }
        }
    }
    None
}

fn load<const D: usize>(boundary: &file::Boundary) -> Option<Load<D>> {
    let prescribed = |components: &Vec<Component>| {
        std::array::from_fn(|axis| components.get(axis).and_then(|component| component.prescribed()))
    };
    if let Some(fixed) = boundary.fixed {
        let held = fixed.axes();
        return Some(Load::Velocity(std::array::from_fn(|axis| held[axis].then_some(0.0))));
    }
    let velocity = boundary.velocity.as_ref().map(|velocity| Load::Velocity(prescribed(velocity)));
    velocity
        .or_else(|| boundary.displacement.as_ref().map(|by| Load::Displacement(prescribed(by))))
        .or_else(|| {
            let rotation = boundary.rotation.as_ref()?;
            Some(Load::Rotation { spin: rotation.spin(), through: rotation.through.components() })
        })
        .or_else(|| boundary.force.as_ref().map(|force| Load::Force(force.components())))
        .or_else(|| boundary.traction.as_ref().map(|traction| Load::Traction(traction.components())))
        .or_else(|| cavities::load(boundary).or_else(|| boundary.pressure.map(Load::Pressure)))
        .or_else(|| boundary.absorbing.then_some(Load::Absorbing))
}
