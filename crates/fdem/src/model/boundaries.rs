//! Boundaries: finds the nodes and edges of the mesh that they act on.

use std::collections::BTreeSet;

use fdem_simulation::{Boundary, Load, Mesh, Schedule, Target};

use crate::model::bodies::{self, Placed};
use crate::model::document::{Document, Table};
use crate::model::fault::{Fault, suggestion};
use crate::model::file::{self, Component, Fixed, ModelFile, Side};
use crate::model::outline::{Point, bounds};
use crate::model::settings::is_piece;

/// Largest distance of nodes of one side from its outermost node, over the extent of the bodies.
const SIDE: f64 = 1e-6;

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
                        "give it one of fixed, velocity, displacement, force, traction, pressure, absorbing",
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
                .help("take one of side, box and group"),
            );
        }
        if boundary.ramp.is_some() && boundary.table.is_some() {
            faults.push(
                Fault::at(document.key(table, "table"), format!("{title} has both ramp and table"))
                    .label("a second schedule"),
            );
        }
        let ascending = |times: &[[f64; 2]]| times.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        if boundary.table.as_deref().is_some_and(|times| !ascending(times)) {
            faults.push(
                Fault::at(
                    document.value(table, "table"),
                    format!("{title}: the times of its table do not ascend"),
                )
                .label("out of order"),
            );
        }
        if boundary.limits.is_some_and(|[left, bottom, right, top]| right < left || top < bottom) {
            faults.push(
                Fault::at(document.value(table, "box"), format!("{title}: its box is turned inside out"))
                    .help("a box is [xmin, ymin, xmax, ymax]"),
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
        ("box", boundary.limits.is_some()),
        ("group", boundary.group.is_some()),
    ]
    .into_iter()
    .filter(|(_, given)| *given)
    .map(|(key, _)| key)
    .collect()
}

/// The boundaries with the nodes and edges that they act on. Those of bodies that are missing, by their tables, are left out, and
/// those that have faults already.
pub(crate) fn resolve(
    file: &ModelFile,
    document: &Document<'_>,
    mesh: &Mesh,
    placed: &[Placed],
    (missing, wrong): (&BTreeSet<usize>, &[bool]),
    faults: &mut Vec<Fault>,
) -> Vec<Boundary> {
    let mut boundaries = Vec::with_capacity(file.boundary.len());
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        let Some(load) = load(boundary) else { continue };
        let mut lacking = missing.iter().map(|&table| &file.body[table].name);
        let lacks = match &boundary.body {
            None => !missing.is_empty(),
            Some(name) => lacking.any(|body| body == name || is_piece(body, name)),
        };
        if lacks || wrong[index] {
            continue;
        }
        let bodies = match &boundary.body {
            None => (0..placed.len()).collect(),
            Some(name) => bodies::named(placed, file, name),
        };
        if let (Some(name), []) = (&boundary.body, &bodies[..]) {
            faults.push(
                Fault::at(document.value(table, "body"), format!("there is no body \"{name}\""))
                    .label("unknown body")
                    .maybe_help(bodies::suggestion(file, name)),
            );
            continue;
        }
        let place = Place { boundary, mesh, placed, bodies: &bodies };
        if let Err(help) = place.check_group() {
            let group = boundary.group.as_deref().unwrap_or("");
            faults.push(
                Fault::at(document.value(table, "group"), format!("no body here has a group \"{group}\""))
                    .label("unknown group")
                    .maybe_help(help),
            );
            continue;
        }
        let on_edges = matches!(load, Load::Traction(_) | Load::Pressure(_) | Load::Absorbing);
        let (target, count, what) = if on_edges {
            let edges = place.edges();
            let count = edges.len();
            (Target::Facets(edges), count, "edge of an outline")
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
                .label("nothing there"),
            );
            continue;
        }
        boundaries.push(Boundary { name: boundary.name.clone(), target, load, schedule: schedule(boundary) });
    }
    boundaries
}

/// The place where a boundary acts.
struct Place<'a> {
    boundary: &'a file::Boundary,
    mesh: &'a Mesh,
    placed: &'a [Placed],
    /// Numbers of the bodies that it may act on.
    bodies: &'a [usize],
}

impl Place<'_> {
    /// Whether some body has the group, else what to write instead.
    fn check_group(&self) -> Result<(), Option<String>> {
        let Some(group) = &self.boundary.group else { return Ok(()) };
        let mut names: Vec<&str> = Vec::new();
        for &body in self.bodies {
            let piece = &self.placed[body].piece;
            names.extend(piece.groups.keys().map(String::as_str));
        }
        names.sort_unstable();
        names.dedup();
        if names.contains(&group.as_str()) { Ok(()) } else { Err(suggestion(group, &names, "group")) }
    }

    fn nodes(&self) -> Vec<u32> {
        let mut nodes = Vec::new();
        for &body in self.bodies {
            let Placed { piece, first, .. } = &self.placed[body];
            match &self.boundary.group {
                None => nodes.extend((0..piece.nodes.len() as u32).map(|node| node + first[0])),
                Some(name) => {
                    let found = piece.groups.get(name).map(|group| piece.nodes_of(group)).unwrap_or_default();
                    nodes.extend(found.into_iter().map(|node| node + first[0]));
                }
            }
        }
        let limits = self.limits();
        nodes.retain(|&node| within(self.mesh.nodes[node as usize], limits));
        nodes
    }

    fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::new();
        for &body in self.bodies {
            let Placed { piece, first, .. } = &self.placed[body];
            let found = match &self.boundary.group {
                None => piece.outline.clone(),
                Some(name) => piece.groups.get(name).map(|group| piece.edges_of(group)).unwrap_or_default(),
            };
            edges.extend(found.into_iter().map(|edge| edge.map(|node| node + first[0])));
        }
        let limits = self.limits();
        edges.retain(|edge| edge.iter().all(|&node| within(self.mesh.nodes[node as usize], limits)));
        edges
    }

    /// The box that nodes have to be in.
    fn limits(&self) -> [Point; 2] {
        let everywhere = [[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]];
        if let Some([left, bottom, right, top]) = self.boundary.limits {
            return [[left, bottom], [right, top]];
        }
        let Some(side) = self.boundary.side else { return everywhere };
        let points = self.bodies.iter().flat_map(|&body| self.placed[body].piece.nodes.iter().copied());
        let [low, high] = bounds(points);
        let reach = SIDE * (high[0] - low[0]).max(high[1] - low[1]);
        let mut limits = everywhere;
        match side {
            Side::Left => limits[1][0] = low[0] + reach,
            Side::Right => limits[0][0] = high[0] - reach,
            Side::Bottom => limits[1][1] = low[1] + reach,
            Side::Top => limits[0][1] = high[1] - reach,
        }
        limits
    }
}

fn within(point: Point, [low, high]: [Point; 2]) -> bool {
    (0..2).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
}

fn load(boundary: &file::Boundary) -> Option<Load> {
    let prescribed = |components: [Component; 2]| components.map(Component::prescribed);
    if let Some(fixed) = boundary.fixed {
        return Some(Load::Velocity(match fixed {
            Fixed::X => [Some(0.0), None],
            Fixed::Y => [None, Some(0.0)],
            Fixed::Xy => [Some(0.0), Some(0.0)],
        }));
    }
    let velocity = boundary.velocity.map(|velocity| Load::Velocity(prescribed(velocity)));
    velocity
        .or_else(|| boundary.displacement.map(|by| Load::Displacement(prescribed(by))))
        .or_else(|| boundary.force.map(Load::Force))
        .or_else(|| boundary.traction.map(Load::Traction))
        .or_else(|| boundary.pressure.map(Load::Pressure))
        .or_else(|| boundary.absorbing.then_some(Load::Absorbing))
}

fn schedule(boundary: &file::Boundary) -> Schedule {
    match (boundary.ramp, &boundary.table) {
        (Some(ramp), _) => Schedule::Ramp(ramp),
        (None, Some(table)) => Schedule::Table(table.clone()),
        (None, None) => Schedule::Constant,
    }
}
