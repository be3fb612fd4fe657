//! Checks the shape of a body before it is meshed.

use fdem_io::numbers::brief;

use crate::shapes::outline::{self, Point, area, twice_area};
use crate::shapes::{coincident, packing};
use crate::text::fault::Problem;
use crate::text::file::{Block, Body, Hole, Outline, Packing, PieceShape, Region, SHAPES, Voronoi};

/// The shapes that a body has.
pub(crate) fn given(body: &Body) -> Vec<&'static str> {
    let has = [
        body.mesh.is_some(),
        body.rectangle.is_some(),
        body.disc.is_some(),
        body.ring.is_some(),
        body.polygon.is_some(),
        body.block.is_some(),
        body.cylinder.is_some(),
        body.tube.is_some(),
        body.sphere.is_some(),
        body.polyhedron.is_some(),
        body.surface.is_some(),
        body.extrusion.is_some(),
        body.voronoi.is_some(),
        body.packing.is_some(),
    ];
    SHAPES.into_iter().zip(has).filter(|(_, has)| *has).map(|((shape, _), _)| shape).collect()
}

/// The dimensions that the shape of a body determines; `None` for a mesh from a file, and without a shape.
pub(crate) fn dimensions(body: &Body) -> Option<u8> {
    if let Some(voronoi) = &body.voronoi {
        return voronoi.outline.given().first().map(|(_, dimensions)| *dimensions);
    }
    if let Some(packing) = &body.packing {
        return packing::dimensions(packing);
    }
    let of = |shape: &str| SHAPES.iter().find(|(known, _)| *known == shape).map(|(_, of)| *of);
    match of(given(body).first()?)? {
        [only] => Some(*only),
        _ => None,
    }
}

/// Corners of an outline up to which all pairs of its edges are compared; the mesher finds the crossings of
/// larger ones.
const COMPARED: usize = 3000;

const INVERTED: &str = "the rectangle has no area: max has to be above and to the right of min";

/// Describes the fault of a body's shape, if it has one.
pub(crate) fn problem(body: &Body, dimensions: u8) -> Option<Problem> {
    find(body, dimensions).map(|problem| Problem {
        message: format!("[[body]] \"{}\": {}", body.name, problem.message),
        ..problem
    })
}

fn find(body: &Body, dimensions: u8) -> Option<Problem> {
    if let Some(rectangle) = &body.rectangle {
        if outline::rectangle(rectangle).is_none() {
            return Some(Problem::new("rectangle", INVERTED));
        }
        return holes("rectangle", &rectangle.holes);
    }
    if let Some(ring) = &body.ring
        && ring.inner_radius >= ring.radius
    {
        let message = "the ring has no area: its inner radius is not below its radius";
        return Some(Problem::new("ring.inner_radius", message));
    }
    if let Some(polygon) = &body.polygon {
        return corners("polygon.points", &polygon.points).or_else(|| holes("polygon", &polygon.holes));
    }
    if let Some(Voronoi { outline, .. }) = &body.voronoi {
        return grains(outline, dimensions);
    }
    if let Some(extrusion) = &body.extrusion {
        if extrusion.from >= extrusion.to {
            let message = format!(
                "the extrusion has no height: its \"to\" of {} is not above its \"from\" of {}",
                brief(extrusion.to),
                brief(extrusion.from)
            );
            return Some(Problem::new("extrusion.to", message));
        }
        return flat("extrusion.outline", &extrusion.outline);
    }
    solid(body).or_else(|| body.packing.as_ref().and_then(|packing| in_packing(body, packing, dimensions)))
}

/// A cylinder or tube without length.
fn ends(key: &str, from: [f64; 3], to: [f64; 3]) -> Option<Problem> {
    (from == to).then(|| Problem::new(key, "it has no length: \"from\" and \"to\" are the same point"))
}

/// Shapes in space that have no volume.
fn solid(body: &Body) -> Option<Problem> {
    if let Some(block) = &body.block {
        return flat_box("box", block);
    }
    if let Some(cylinder) = &body.cylinder {
        return ends("cylinder.to", cylinder.from, cylinder.to);
    }
    if let Some(tube) = &body.tube {
        if tube.inner_radius >= tube.radius {
            let message = "the tube has no wall: its inner radius is not below its radius";
            return Some(Problem::new("tube.inner_radius", message));
        }
        return ends("tube.to", tube.from, tube.to);
    }
    None
}

fn flat_box(key: &str, block: &Block) -> Option<Problem> {
    let flat = (0..3).find(|&axis| block.min[axis] >= block.max[axis])?;
    Some(Problem::new(
        key,
        format!(
            "the box has no volume: along {} its max of {} is not above its min of {}",
            ["x", "y", "z"][flat],
            brief(block.max[flat]),
            brief(block.min[flat])
        ),
    ))
}

/// The problem of a table that has two shapes, where one is allowed.
fn second(key: &str, what: &str, given: &[(&str, u8)]) -> Option<Problem> {
    let [(first, _), (second, _), ..] = given else { return None };
    let message = format!("{what} is one shape, and this has two, {first} and {second}");
    Some(Problem {
        help: Some("take one of them out".to_owned()),
        ..Problem::new(format!("{key}.{second}"), message)
    })
}

/// An outline that is drawn out along z.
fn flat(key: &str, of: &Outline) -> Option<Problem> {
    if let Some(problem) = second(key, "an outline", &of.given()) {
        return Some(problem);
    }
    match of.given()[..] {
        [(_, 2)] => outline_of(key, of),
        _ => Some(Problem::new(key, "an outline to draw out is one of rectangle, disc, polygon")),
    }
}

fn grains(of: &Outline, dimensions: u8) -> Option<Problem> {
    if let Some(problem) = second("voronoi.outline", "an outline", &of.given()) {
        return Some(problem);
    }
    match of.given()[..] {
        [(_, found)] if found == dimensions => {}
        _ if dimensions == 3 => {
            let message =
                "an outline of grains in three dimensions is one of box, polyhedron, cylinder, sphere";
            return Some(Problem::new("voronoi.outline", message));
        }
        _ => return Some(Problem::new("voronoi.outline", "an outline is one of rectangle, disc, polygon")),
    }
    if let Some(block) = &of.block {
        return flat_box("voronoi.outline.box", block);
    }
    if let Some(cylinder) = &of.cylinder {
        return ends("voronoi.outline.cylinder.to", cylinder.from, cylinder.to);
    }
    outline_of("voronoi.outline", of)
}

/// The error of a flat outline, whose key is given.
fn outline_of(key: &str, of: &Outline) -> Option<Problem> {
    if let Some(rectangle) = &of.rectangle {
        let key = format!("{key}.rectangle");
        if outline::rectangle(rectangle).is_none() {
            return Some(Problem::new(key, INVERTED));
        }
        return holes(&key, &rectangle.holes);
    }
    let polygon = of.polygon.as_ref()?;
    corners(&format!("{key}.polygon.points"), &polygon.points)
        .or_else(|| holes(&format!("{key}.polygon"), &polygon.holes))
}

fn holes(key: &str, holes: &[Hole]) -> Option<Problem> {
    holes.iter().enumerate().find_map(|(number, hole)| {
        let Hole::Points(points) = hole else { return None };
        let problem = corners(&format!("{key}.holes"), points)?;
        Some(Problem { message: format!("hole {}: {}", number + 1, problem.message), ..problem })
    })
}

/// Describes the fault of an outline's corners, if they have one.
fn corners(key: &str, points: &[Point]) -> Option<Problem> {
    let problem = |message: String, help: &str| {
        Some(Problem { help: Some(help.to_owned()), ..Problem::new(key, message) })
    };
    let (first, last) = (points.first()?, points.last()?);
    if points.len() > 1 && first == last {
        return problem(
            format!("the last point is the first again, {first:?}"),
            "outlines close by themselves: take the last point out",
        );
    }
    if let Some(place) = points.windows(2).position(|pair| pair[0] == pair[1]) {
        return problem(
            format!("points {} and {} are the same, {:?}", place + 1, place + 2, points[place]),
            "take one of them out",
        );
    }
    let edges = (0..points.len()).map(|k| [k, (k + 1) % points.len()]);
    if let Some(problem) = coincident::problem(key, "the points", points, edges) {
        return Some(problem);
    }
    if let Some([a, b, c, d]) = crossing(points) {
        return problem(
            format!(
                "the outline crosses itself: the line from {a:?} to {b:?} cuts the one from {c:?} to {d:?}"
            ),
            "give the corners in their order around the outline; a bowtie is two bodies",
        );
    }
    if area(points) == 0.0 {
        return problem("the polygon has no area".to_owned(), "its points lie on a line");
    }
    None
}

/// The ends of two edges that cut each other.
fn crossing(points: &[Point]) -> Option<[Point; 4]> {
    let count = points.len();
    if count > COMPARED {
        return None;
    }
    let edge = |k: usize| [points[k], points[(k + 1) % count]];
    for i in 0..count {
        let [a, b] = edge(i);
        for j in i + 2..count {
            // The last edge ends where the first begins.
            if i == 0 && j == count - 1 {
                continue;
            }
            let [c, d] = edge(j);
            let opposite = |one: f64, other: f64| one > 0.0 && other < 0.0 || one < 0.0 && other > 0.0;
            if opposite(twice_area(a, b, c), twice_area(a, b, d))
                && opposite(twice_area(c, d, a), twice_area(c, d, b))
            {
                return Some([a, b, c, d]);
            }
        }
    }
    None
}

fn in_packing(body: &Body, packing: &Packing, dimensions: u8) -> Option<Problem> {
    let problem = |key: &str, what: &str| Some(Problem::new(key, what));
    let shape = packing.shape.map(|shape| match shape {
        PieceShape::Disc => ("discs", 2),
        PieceShape::Polygon => ("polygons", 2),
        PieceShape::Sphere => ("spheres", 3),
        PieceShape::Polyhedron => ("polyhedra", 3),
    });
    if let Some((name, of)) = shape {
        if packing.copies_of.is_some() {
            return problem("packing.shape", "a packing has a shape or copies_of, not both");
        }
        if of != dimensions {
            let help = if dimensions == 3 {
                "flat bodies are for two dimensions; in three take \"sphere\" or \"polyhedron\""
            } else {
                "in two dimensions take \"disc\" or \"polygon\""
            };
            let what = format!("a packing of {name} is not for {dimensions} dimensions");
            return Some(Problem { help: Some(help.to_owned()), ..Problem::new("packing.shape", what) });
        }
    }
    if let Some(of) = &packing.copies_of {
        if let Some(problem) = second("packing.copies_of", "what is copied", &of.given()) {
            return Some(problem);
        }
        let shapes = if dimensions == 2 {
            "rectangle, ring, polygon"
        } else {
            "box, cylinder, tube, polyhedron, surface, extrusion"
        };
        if !matches!(of.given()[..], [(_, found)] if found == dimensions) {
            return problem("packing.copies_of", &format!("copies are those of one of {shapes}"));
        }
        if let Some(problem) = find(&of.body(body), dimensions) {
            return Some(Problem { key: format!("packing.copies_of.{}", problem.key), ..problem });
        }
    }
    // Copies have a radius already.
    let has_radius = packing.radius.is_some() || packing.copies_of.is_some();
    match (&packing.file, [packing.count.is_some(), has_radius, packing.within.is_some()]) {
        (None, [true, true, true]) => {}
        (None, _) => return problem("packing", "a packing has a file, or count, radius and within"),
        (Some(_), [false, _, false]) if packing.radius.is_none() => {}
        (Some(_), _) => {
            return problem("packing.file", "a packing from a file has no count, radius or within");
        }
    }
    if packing.radius.is_some_and(|[least, _]| least <= 0.0) {
        return problem("packing.radius", "the smallest radius is not above 0");
    }
    if packing.radius.is_some_and(|[least, most]| least > most) {
        return problem("packing.radius", "the smallest radius is above the largest");
    }
    let [least, most] = packing::corners(packing, usize::from(dimensions));
    if least > most {
        return problem("packing.corners", "the least number of corners is above the largest");
    }
    if packing.shape == Some(PieceShape::Polyhedron) && least < 4 {
        return problem("packing.corners", "a polyhedron has 4 corners or more");
    }
    packing.within.as_ref().and_then(|within| region(within, dimensions))
}

/// The error of the region of a packing. Corners with another number of coordinates are reported elsewhere.
fn region(of: &Region, dimensions: u8) -> Option<Problem> {
    let problem = |key: &str, what: &str| Some(Problem::new(key, what));
    match (&of.min, &of.max, &of.cylinder) {
        (None, None, Some(_)) if dimensions == 2 => {
            problem("packing.within.cylinder", "a cylinder is no region in two dimensions")
        }
        (None, None, Some(cylinder)) => {
            let is_flat = cylinder.from == cylinder.to;
            let what = "it has no length: \"from\" and \"to\" are the same point";
            is_flat.then(|| Problem::new("packing.within.cylinder", what))
        }
        (Some(min), Some(max), None) => {
            let inverted = min.0.iter().zip(&max.0).any(|(min, max)| min >= max);
            let what = if dimensions == 2 {
                INVERTED
            } else {
                "the box has no volume: max has to be above min along x, y and z"
            };
            inverted.then(|| Problem::new("packing.within", what))
        }
        _ if dimensions == 2 => problem("packing.within", "the region of a packing has min and max"),
        _ => problem("packing.within", "the region of a packing has min and max, or a cylinder"),
    }
}
