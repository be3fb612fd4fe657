//! Checks the shape of a body before it is meshed.

use fdem_io::numbers::brief;

use crate::model::file::{Block, Body, Hole, Outline, Packing, Piece, Voronoi};
use crate::model::mesh_file::Problem;
use crate::model::outline::{self, Point, area, twice_area};

/// Corners of an outline up to which all pairs of its edges are compared; the mesher finds the crossings of larger ones.
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
    solid(body).or_else(|| body.packing.as_ref().and_then(packing))
}

/// Shapes in space that have no volume.
fn solid(body: &Body) -> Option<Problem> {
    let ends = |key: &str, from: [f64; 3], to: [f64; 3]| {
        (from == to).then(|| Problem::new(key, "it has no length: \"from\" and \"to\" are the same point"))
    };
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

/// An outline that is drawn out along z.
fn flat(key: &str, of: &Outline) -> Option<Problem> {
    match of.given()[..] {
        [(_, 2)] => outline_of(key, of),
        _ => Some(Problem::new(key, "an outline to draw out is one of rectangle, disc, polygon")),
    }
}

fn grains(of: &Outline, dimensions: u8) -> Option<Problem> {
    match of.given()[..] {
        [(_, found)] if found == dimensions => {}
        _ if dimensions == 3 => {
            let message = "an outline of grains in three dimensions is one of box, polyhedron";
            return Some(Problem::new("voronoi.outline", message));
        }
        _ => return Some(Problem::new("voronoi.outline", "an outline is one of rectangle, disc, polygon")),
    }
    if let Some(block) = &of.block {
        return flat_box("voronoi.outline.box", block);
    }
    outline_of("voronoi.outline", of)
}

/// What is wrong with a flat outline, whose key is given.
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

fn packing(packing: &Packing) -> Option<Problem> {
    let problem = |key: &str, what: &str| Some(Problem::new(key, what));
    let random = [packing.count.is_some(), packing.radius.is_some(), packing.within.is_some()];
    match (&packing.file, random) {
        (None, [true, true, true]) => {}
        (None, _) => return problem("packing", "a packing has a file, or count, radius and within"),
        (Some(_), [false, false, false]) => return None,
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
    if packing.shape == Piece::Polygon && packing.corners[0] > packing.corners[1] {
        return problem("packing.corners", "the least number of corners is above the largest");
    }
    if packing.within.as_ref().is_some_and(|within| outline::rectangle(within).is_none()) {
        return problem("packing.within", INVERTED);
    }
    None
}
