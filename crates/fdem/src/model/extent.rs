//! Sizes of bodies before anything is cut: what their meshes would take, and how much they lie in each other.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::MOST_ELEMENTS;
pub(crate) use fdem_mesh::bounds;

use crate::model::document::{Document, Table};
use crate::model::fault::Fault;
use crate::model::file::{Body, Hole, ModelFile, Packing, Vector};
use crate::model::outline::{self, Point, area};
use crate::model::packing::Room;
use crate::model::{plane, refine, space};

/// Elements above which a model is refused.
pub(crate) const MOST: f64 = MOST_ELEMENTS as f64;

/// Memory that the mesher needs for each element, bytes.
const BYTES: f64 = 600.0;

/// Memory of the program itself, bytes.
const PROGRAM: f64 = 5e7;

/// Couples of elements of bodies that lie in each other: so many are always allowed, and so many more for each element.
const COUPLES: [f64; 2] = [2e7, 20.0];

/// Area and outline of a body.
#[derive(Debug, Clone, Copy)]
struct Extent {
    /// m².
    area: f64,
    /// Length of all outlines, m.
    length: f64,
    /// Number of corners of all outlines.
    corners: f64,
    /// Least and largest coordinates.
    bounds: [Point; 2],
}

impl Extent {
    /// Extent of discs at unknown places, from the means of their radii and of the squares of their radii.
    fn of_discs(count: f64, [mean, square]: [f64; 2], bounds: [Point; 2]) -> Self {
        Self { area: count * PI * square, length: count * TAU * mean, corners: 8.0 * count, bounds }
    }

    fn disc(centre: Point, radius: f64) -> Self {
        let bounds = [-radius, radius].map(|by| [centre[0] + by, centre[1] + by]);
        Self::of_discs(1.0, [radius, radius * radius], bounds)
    }

    fn polygon(points: &[Point]) -> Self {
        Self {
            area: area(points).abs(),
            length: outline::length(points),
            corners: points.len() as f64,
            bounds: bounds(points.iter().copied()),
        }
    }

    fn less_holes(mut self, holes: &[Hole]) -> Self {
        for hole in holes {
            let hole = match hole {
                Hole::Points(points) => Self::polygon(points),
                Hole::Disc(disc) => Self::disc(disc.centre, disc.radius),
            };
            // A hole larger than the body is refused later; it does not make the body smaller than nothing.
            self.area = if hole.area <= self.area { self.area - hole.area } else { self.area + hole.area };
            self.length += hole.length;
            self.corners += hole.corners;
        }
        self
    }

    /// The number of elements with edges of `size`, about.
    fn elements(&self, size: f64) -> f64 {
        self.area / size / size / (3.0_f64.sqrt() / 4.0) + self.length / size + self.corners
    }
}

/// The extent of a body whose shape is in the model file.
fn extent(body: &Body) -> Option<Extent> {
    let rectangle = |of: &crate::model::file::Rectangle| {
        Some(Extent::polygon(&outline::rectangle(of)?).less_holes(&of.holes))
    };
    if let Some(of) = &body.rectangle {
        return rectangle(of);
    }
    if let Some(of) = &body.disc {
        return Some(Extent::disc(of.centre, of.radius));
    }
    if let Some(of) = &body.ring {
        let hole = crate::model::file::Disc { centre: of.centre, radius: of.inner_radius };
        return Some(Extent::disc(of.centre, of.radius).less_holes(&[Hole::Disc(hole)]));
    }
    if let Some(of) = &body.polygon {
        return Some(Extent::polygon(&of.points).less_holes(&of.holes));
    }
    if let Some(voronoi) = &body.voronoi {
        let of = &voronoi.outline;
        if let Some(of) = &of.rectangle {
            return rectangle(of);
        }
        if let Some(of) = &of.disc {
            return Some(Extent::disc(of.centre, of.radius));
        }
        return of.polygon.as_ref().map(|of| Extent::polygon(&of.points).less_holes(&of.holes));
    }
    body.packing.as_ref().and_then(|of| packing(body, of))
}

/// The extent of a flat packing at random places: radii are as likely anywhere between the smallest and the largest.
fn packing(body: &Body, packing: &Packing) -> Option<Extent> {
    let copied = packing.copies_of.as_ref().map(|of| of.body(body));
    let reach = copied.as_ref().and_then(plane::reach).map(|(_, radius)| [radius; 2]);
    let (count, [a, b]) = (packing.count? as f64, packing.radius.or(reach)?);
    let within = packing.within.as_ref()?;
    if within.min.as_ref()?.0.len() != 2 {
        return None;
    }
    let means = [f64::midpoint(a, b), (a * a + a * b + b * b) / 3.0];
    Some(Extent::of_discs(count, means, Room::<2>::new(within)?.bounds))
}

/// The number of elements of discs with edges of `size`, about.
pub(crate) fn elements_of_discs(radii: impl Iterator<Item = f64>, size: f64) -> f64 {
    let bounds = [[0.0; 2]; 2];
    radii.map(|radius| Extent::of_discs(1.0, [radius, radius * radius], bounds).elements(size)).sum()
}

/// A bounding box that is full of elements.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Filled<const D: usize = 2> {
    /// Least and largest coordinates.
    pub(crate) bounds: [[f64; D]; 2],
    /// Number of elements.
    pub(crate) elements: f64,
    /// Mean extent of the elements along each axis, m.
    pub(crate) size: [f64; D],
}

/// Number of elements of all bodies that are cut here, about. Refuses sizes that give too many, or more than `memory` (bytes) has room for, and bodies that lie in each other
/// so much that their contacts have no room.
pub(crate) fn check(
    file: &ModelFile,
    document: &Document<'_>,
    memory: Option<f64>,
    faults: &mut Vec<Fault>,
) -> f64 {
    let mut all = 0.0;
    let mut boxes = Vec::new();
    let mut tables = Vec::new();
    for (index, body) in file.body.iter().enumerate() {
        let Some(size) = body.mesh_size else { continue };
        let flat = extent(body);
        let refined = match &flat {
            Some(extent) => refine::elements(body, extent.bounds),
            None => space::bounds(body).map_or(Ok(0.0), |bounds| refine::elements(body, bounds)),
        };
        let refined = match refined {
            Ok(elements) => elements,
            Err(problem) => {
                let span = document.value(Table::of("body", index), &problem.key);
                faults.push(Fault::at(span, problem.message).label("too small").maybe_help(problem.help));
                return all;
            }
        };
        let Some(elements) = flat.map(|extent| extent.elements(size)).or_else(|| space::elements(body, size))
        else {
            continue;
        };
        let elements = elements + refined;
        let before = all;
        all += elements;
        if let Some(message) = too_many(before, elements, size, memory) {
            let span = document.value(Table::of("body", index), "mesh_size");
            let message = format!("[[body]] \"{}\": {message}", body.name);
            faults.push(Fault::at(span, message).label("too small").help("take a larger mesh_size"));
            return all;
        }
        if let Some(extent) = flat {
            boxes.push(Filled { bounds: placed(extent.bounds, body), elements, size: [size; 2] });
            tables.push(index);
        }
    }
    if let Some(([a, b], couples)) = crowded(&boxes) {
        let [a, b] = [tables[a.min(b)], tables[a.max(b)]];
        let [first, second] = [a, b].map(|index| &file.body[index].name);
        faults.push(crowd(document.value(Table::of("body", b), "name"), first, second, couples));
    }
    all
}

/// The fault of bodies that lie in each other.
pub(crate) fn crowd(span: Range<usize>, first: &str, second: &str, couples: f64) -> Fault {
    let message = format!(
        "bodies lie in each other: more than {} couples of elements would touch, most of them of \"{first}\" and \"{second}\"",
        grouped(couples as u64)
    );
    Fault::at(span, message)
        .label("lies in another")
        .help("bodies may touch, but not overlap: look for copies in the same place")
}

/// Number of elements in a square or a cube of their size, about.
pub(crate) fn per_cube<const D: usize>() -> f64 {
    if D == 2 { 4.0 / 3.0_f64.sqrt() } else { 1.0 / space::VOLUME }
}

/// Why a body with so many elements is refused, if it is. `before`: elements of the bodies before it.
pub(crate) fn too_many(before: f64, elements: f64, size: f64, memory: Option<f64>) -> Option<String> {
    let all = before + elements;
    if !(all.is_finite() && all <= MOST) {
        let gives = if all.is_finite() {
            format!("gives about {} elements", brief(elements))
        } else {
            "gives more elements than can be counted".to_owned()
        };
        let others = if elements > MOST || !all.is_finite() {
            String::new()
        } else {
            format!(", {} with the bodies before", brief(all))
        };
        return Some(format!(
            "a mesh size of {} m {gives}{others}; the most are {}",
            brief(size),
            grouped(MOST as u64)
        ));
    }
    let memory = memory?;
    let needs = PROGRAM + BYTES * all;
    (needs > memory).then(|| {
        format!(
            "a mesh size of {} m gives about {} elements: the mesh needs about {} MB of memory, and {} MB are free",
            brief(size),
            brief(all),
            grouped((needs / 1e6).ceil() as u64),
            grouped((memory / 1e6) as u64)
        )
    })
}

/// The bounding box of a body that is turned and moved.
fn placed([low, high]: [Point; 2], body: &Body) -> [Point; 2] {
    let (sine, cosine) = libm::sincos(body.angle.to_radians());
    let [x, y] = [0, 1].map(|axis| 0.5 * (high[axis] - low[axis]));
    let half = [x * cosine.abs() + y * sine.abs(), x * sine.abs() + y * cosine.abs()];
    let by = body.translate.as_ref().map_or([0.0; 2], Vector::components);
    let middle = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]) + by[axis]);
    [-1.0, 1.0].map(|sign| [0, 1].map(|axis| middle[axis] + sign * half[axis]))
}

/// The two bodies that lie in each other most, and how many couples there are at least, where these are too many to be kept: about, from the bounding boxes.
pub(crate) fn crowded<const D: usize>(boxes: &[Filled<D>]) -> Option<([usize; 2], f64)> {
    let limit = COUPLES[0] + COUPLES[1] * boxes.iter().map(|body| body.elements).sum::<f64>();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].bounds[0][0].total_cmp(&boxes[b].bounds[0][0]));
    let mut open: Vec<usize> = Vec::new();
    let (mut sum, mut most, mut worst) = (0.0, 0.0, [0; 2]);
    for &body in &order {
        let start = boxes[body].bounds[0][0];
        open.retain(|&other| boxes[other].bounds[1][0] > start);
        for &other in &open {
            let couples = couples(&boxes[body], &boxes[other]);
            sum += couples;
            if couples > most {
                (most, worst) = (couples, [other, body]);
            }
        }
        if sum > limit {
            return Some((worst, sum));
        }
        open.push(body);
    }
    None
}

/// Couples of elements that two boxes have, if each is filled evenly.
fn couples<const D: usize>(one: &Filled<D>, other: &Filled<D>) -> f64 {
    let size = |of: &Filled<D>| (0..D).map(|axis| of.bounds[1][axis] - of.bounds[0][axis]).product::<f64>();
    let mut found = one.elements / size(one) * other.elements / size(other);
    for axis in 0..D {
        let low = one.bounds[0][axis].max(other.bounds[0][axis]);
        found *= (one.bounds[1][axis].min(other.bounds[1][axis]) - low).max(0.0);
        found *= one.size[axis] + other.size[axis];
    }
    // Boxes without area or volume, or beyond what can be computed, say nothing.
    if found.is_finite() { found } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(x: f64, elements: f64) -> Filled {
        Filled { bounds: [[x, 0.0], [x + 1.0, 1.0]], elements, size: [(2.3 / elements).sqrt(); 2] }
    }

    #[test]
    fn copies_in_one_place_are_too_many_and_bodies_side_by_side_are_not() {
        let side_by_side: Vec<Filled> = (0..2000).map(|k| filled(0.9 * f64::from(k), 100.0)).collect();
        assert!(crowded(&side_by_side).is_none());
        let copies = vec![filled(0.0, 100.0); 1000];
        assert!(crowded(&copies).is_some());
        assert!(crowded(&copies[..20]).is_none());
    }
}
