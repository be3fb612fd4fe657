//! Areas and outlines of flat bodies before they are cut.

use std::f64::consts::{PI, TAU};

use fdem_mesh::bounds;

use crate::shapes::outline::{self, Point, area};
use crate::shapes::packing::Room;
use crate::text::file::{Body, Hole, Packing};

/// Area and outline of a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    /// m².
    area: f64,
    /// Length of all outlines, m.
    length: f64,
    /// Number of corners of all outlines.
    corners: f64,
    /// Least and largest coordinates.
    pub(crate) bounds: [Point; 2],
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
    pub(crate) fn elements(&self, size: f64) -> f64 {
        self.area / size / size / (3.0_f64.sqrt() / 4.0) + self.length / size + self.corners
    }
}

/// The extent of a body whose shape is in the model file.
pub(crate) fn extent(body: &Body) -> Option<Extent> {
    let rectangle = |of: &crate::text::file::Rectangle| {
        Some(Extent::polygon(&outline::rectangle(of)?).less_holes(&of.holes))
    };
    if let Some(of) = &body.rectangle {
        return rectangle(of);
    }
    if let Some(of) = &body.disc {
        return Some(Extent::disc(of.centre, of.radius));
    }
    if let Some(of) = &body.ring {
        let hole = crate::text::file::Disc { centre: of.centre, radius: of.inner_radius };
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

/// The extent of a flat packing at random places: radii are as likely anywhere between the smallest and the
/// largest.
fn packing(body: &Body, packing: &Packing) -> Option<Extent> {
    let copied = packing.copies_of.as_ref().map(|of| of.body(body));
    let reach = copied.as_ref().and_then(outline::reach).map(|(_, radius)| [radius; 2]);
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
