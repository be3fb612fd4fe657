//! Shapes of the model file as polygons.

use fdem_mesh::Grading;
pub(crate) use fdem_mesh::triangles::outline::{Domain, Point, area, circle, distance, length, twice_area};

use crate::text::file::{Body, Disc, Hole, Rectangle};

/// Corners of a rectangle; `None` if it is turned inside out or has no area.
pub(crate) fn rectangle(rectangle: &Rectangle) -> Option<Vec<Point>> {
    let Rectangle { min: [left, bottom], max: [right, top], .. } = *rectangle;
    (right > left && top > bottom).then(|| vec![[left, bottom], [right, bottom], [right, top], [left, top]])
}

pub(crate) fn disc(disc: &Disc, size: &Grading<2>) -> Vec<Point> {
    circle(disc.centre, disc.radius, size)
}

pub(crate) fn hole(hole: &Hole, size: &Grading<2>) -> Vec<Point> {
    match hole {
        Hole::Points(points) => points.clone(),
        Hole::Disc(disc) => circle(disc.centre, disc.radius, size),
    }
}

/// The middle of a shape that may be copied, and the radius of the circle around it; `None` for other bodies.
pub(crate) fn reach(body: &Body) -> Option<(Point, f64)> {
    if let Some(ring) = &body.ring {
        return Some((ring.centre, ring.radius));
    }
    let corners = match (&body.rectangle, &body.polygon) {
        (Some(rectangle), _) => self::rectangle(rectangle)?,
        (None, polygon) => polygon.as_ref()?.points.clone(),
    };
    let [low, high] = fdem_mesh::bounds(corners.iter().copied());
    let middle = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]));
    Some((middle, corners.iter().map(|&corner| distance(corner, middle)).fold(0.0, f64::max)))
}
