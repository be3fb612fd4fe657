//! Common parts of the legacy and the XML format of VTK: types of cells, and the data that distinguish
//! bodies.

use std::collections::{BTreeMap, BTreeSet};

use crate::excerpt;
use crate::mesh::build::{Draft, Raw, corners};
use crate::mesh::error::{Fault, MeshProblem, malformed};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::mesh::shape::{Shape, refused};
use crate::place::Place;

/// Names of cell data that distinguish bodies, in lower case; the first one that exists is used.
const BODIES: [&str; 8] =
    ["body", "body_id", "bodyid", "gmsh:physical", "cellentityids", "objectid", "partid", "regionid"];

/// Whether cell data of this name may distinguish bodies.
pub(crate) fn names_bodies(name: &str) -> bool {
    BODIES.contains(&name.to_ascii_lowercase().as_str())
}

/// Cells: all nodes, the end of each cell, and the types.
#[derive(Debug, Default)]
pub(crate) struct CellList {
    pub(crate) connectivity: Vec<i64>,
    pub(crate) ends: Vec<i64>,
    pub(crate) types: Vec<i64>,
}

/// The type of cells whose section in the file determines their kind.
const EMPTY: i64 = 0;
const VERTEX: i64 = 1;
pub(crate) const POLY_VERTEX: i64 = 2;
pub(crate) const POLY_LINE: i64 = 4;
pub(crate) const STRIP: i64 = 6;
pub(crate) const POLYGON: i64 = 7;
pub(crate) const QUADRILATERAL: i64 = 9;
pub(crate) const HEXAHEDRON: i64 = 12;

impl CellList {
    /// Whether there are cells other than vertices.
    pub(crate) fn has_cells(&self) -> bool {
        self.types.iter().any(|kind| ![EMPTY, VERTEX, POLY_VERTEX].contains(kind))
    }

    /// Adds the cells to the draft. They are numbered from `first` on; the points of their piece start at
    /// `base`.
    pub(crate) fn add(&self, draft: &mut Draft, first: u64, base: usize, place: Place) -> Result<(), Fault> {
        if self.types.len() != self.ends.len() {
            let problem = format!("{} types for {} cells", self.types.len(), self.ends.len());
            return Err((place, malformed(problem)));
        }
        let mut from = 0;
        for ((number, &end), &kind) in (first..).zip(&self.ends).zip(&self.types) {
            let end = usize::try_from(end).ok().filter(|&end| end >= from && end <= self.connectivity.len());
            let Some(end) = end else {
                return Err((
                    place,
                    malformed(format!("element {number} does not end among the nodes of the cells")),
                ));
            };
            add_cell(draft, kind, &self.connectivity[from..end], (number, base, place))?;
            from = end;
        }
        if from != self.connectivity.len() {
            let problem = format!("the cells have {} nodes, found {}", from, self.connectivity.len());
            return Err((place, malformed(problem)));
        }
        Ok(())
    }
}

fn add_cell(
    draft: &mut Draft,
    kind: i64,
    nodes: &[i64],
    (number, base, place): (u64, usize, Place),
) -> Result<(), Fault> {
    let points = (draft.points.len() - base) as i64;
    let known = |shape: Shape, found: &[i64]| match found.iter().find(|node| !(0..points).contains(*node)) {
        Some(&node) => Err((place, MeshProblem::UnknownNode { element: number, kind: shape.name(), node })),
        None => Ok(found.iter().map(|node| node + base as i64).collect::<Vec<i64>>()),
    };
    let mut push = |shape: Shape, found: &[i64]| {
        if found.len() != shape.nodes() {
            let problem = format!("element {number} is a {} of {} nodes", shape.name(), found.len());
            return Err((place, malformed(problem)));
        }
        let nodes = corners(&known(shape, found)?);
        draft.elements.push(Raw { shape, place, number, body: 0, nodes });
        Ok(())
    };
    match (kind, nodes) {
        // A set of points is one element, whatever their number.
        (1 | POLY_VERTEX, [first, ..]) => push(Shape::Point, &[*first]),
        (3, _) => push(Shape::Segment, nodes),
        (POLY_LINE, [_, _, ..]) => nodes.windows(2).try_for_each(|pair| push(Shape::Segment, pair)),
        (5, _) => push(Shape::Triangle, nodes),
        (POLYGON, _) => {
            let nodes = known(Shape::Polygon, nodes)?;
            draft.push_polygon(nodes, (number, place, 0)).map_err(|problem| (place, problem))
        }
        // A pixel lists its corners row by row, not around its outline.
        (8, &[a, b, c, d]) => push(Shape::Quadrilateral, &[a, b, d, c]),
        (8 | 9, _) => push(Shape::Quadrilateral, nodes),
        (10, _) => push(Shape::Tetrahedron, nodes),
        // A voxel too lists its corners row by row.
        (11, &[a, b, c, d, e, f, g, h]) => push(Shape::Hexahedron, &[a, b, d, c, e, f, h, g]),
        (11 | 12, _) => push(Shape::Hexahedron, nodes),
        // The first face of a wedge is seen from outside here, from inside in other formats.
        (13, &[a, b, c, d, e, f]) => push(Shape::Wedge, &[a, c, b, d, f, e]),
        (13, _) => push(Shape::Wedge, nodes),
        (14, _) => push(Shape::Pyramid, nodes),
        (1 | POLY_VERTEX | POLY_LINE, _) => Err((
            place,
            malformed(format!("element {number} has {}", excerpt::count(nodes.len() as u64, "node"))),
        )),
        _ => {
            if let Some(&(_, first, count)) = SECOND_ORDER.iter().find(|(second, ..)| *second == kind) {
                if nodes.len() != count {
                    let problem = format!("element {number} (VTK's type {kind}) has {} nodes", nodes.len());
                    return Err((place, malformed(problem)));
                }
                draft.second_order += 1;
                let corners = corners_of(first);
                return add_cell(draft, first, &nodes[..corners], (number, base, place));
            }
            let what = match kind {
                STRIP => "a triangle strip".into(),
                42 => "a polyhedron".into(),
                _ => format!("of VTK's type {kind}"),
            };
            Err((place, refused(number, &what)))
        }
    }
}

/// Types of second order, the types of first order with the same corners, and their numbers of nodes.
const SECOND_ORDER: [(i64, i64, usize); 10] = [
    (21, 3, 3),
    (22, 5, 6),
    (34, 5, 7),
    (23, 9, 8),
    (28, 9, 9),
    (24, 10, 10),
    (27, 14, 13),
    (26, 13, 15),
    (25, 12, 20),
    (29, 12, 27),
];

/// Number of corners of a type of first order.
fn corners_of(kind: i64) -> usize {
    match kind {
        3 => 2,
        5 => 3,
        9 | 10 => 4,
        14 => 5,
        13 => 6,
        _ => 8,
    }
}

/// Cell data that distinguish bodies, and the names of others.
#[derive(Debug, Default)]
pub(crate) struct BodyData {
    bodies: Vec<(String, Place, Vec<i64>)>,
    others: BTreeSet<String>,
}

impl BodyData {
    /// Appends the values of some cells to those of the same name.
    pub(crate) fn push(&mut self, name: &str, place: Place, values: &[i64]) {
        match self.bodies.iter_mut().find(|(known, ..)| known == name) {
            Some((.., known)) => known.extend_from_slice(values),
            None => self.bodies.push((name.to_owned(), place, values.to_vec())),
        }
    }

    /// Notes the name of cell data that are not read.
    pub(crate) fn skip(&mut self, name: &str) {
        self.others.insert(name.to_owned());
    }

    /// The cell data that are not used, in words.
    fn unused(&self, used: Option<&str>) -> Option<String> {
        let spare = self.bodies.iter().map(|(name, ..)| name).filter(|name| Some(name.as_str()) != used);
        let names: Vec<&str> = spare.chain(&self.others).map(String::as_str).collect();
        let help = if used.is_none() {
            "; bodies are the values of body, gmsh:physical, CellEntityIds, ObjectId, PartId or RegionId"
        } else {
            ""
        };
        (!names.is_empty()).then(|| format!("cell data not used: {}{help}", names.join(", ")))
    }

    /// Sets the body of each element to that of its cell.
    pub(crate) fn apply(self, draft: &mut Draft, cells: u64) -> Result<(), Fault> {
        let rank = |name: &str| BODIES.iter().position(|known| *known == name.to_ascii_lowercase());
        let used = self.bodies.iter().min_by_key(|(name, ..)| rank(name));
        draft.unused.extend(self.unused(used.map(|(name, ..)| name.as_str())));
        let Some((name, place, values)) = used.cloned() else { return Ok(()) };
        if values.len() as u64 != cells {
            let problem = format!("cell data {name} has {} values for {cells} cells", values.len());
            return Err((place, malformed(problem)));
        }
        let mut known: BTreeMap<i64, u32> = BTreeMap::new();
        draft.bodies.clear();
        for raw in &mut draft.elements {
            // Cells and values are numbered from 0.
            let value = values[raw.number as usize];
            raw.body = *known.entry(value).or_insert_with(|| {
                draft.bodies.push(MeshBody { number: Some(value), name: None });
                draft.bodies.len() as u32 - 1
            });
        }
        draft.bodies_from = BodiesFrom::CellData(name);
        Ok(())
    }
}

/// Converts floats to integers, because bodies are sometimes written as floats.
pub(crate) fn whole(values: &[f64], name: &str) -> Result<Vec<i64>, MeshProblem> {
    /// 2^53: up to here every integer is a float.
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    let convert = |&value: &f64| (value.fract() == 0.0 && value.abs() <= LARGEST).then_some(value as i64);
    let converted: Option<Vec<i64>> = values.iter().map(convert).collect();
    converted.ok_or_else(|| malformed(format!("cell data {name} are bodies, but not whole numbers")))
}
