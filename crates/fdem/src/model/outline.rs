//! Shapes of the model file as polygons.

use fdem_mesh::Grading;
pub(crate) use fdem_mesh::triangles::outline::{Domain, Point, area, circle, distance, length, twice_area};

use crate::model::file::{Disc, Hole, Rectangle};

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
