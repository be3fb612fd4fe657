//! The packing fraction.

use std::f64::consts::PI;

use fdem_io::numbers::brief;
use serde::Serialize;

use crate::analysis::domain_frame::DomainFrame;
use crate::analysis::error::AnalysisError;
use crate::analysis::parts::Team;
use crate::analysis::placed::Placed;
use crate::analysis::volumes::{disc_in_rectangle, sphere_in_box};
use crate::arrays::each;
use crate::network::Network;

/// Filled fraction of a region: of its area in 2D, of its volume in 3D.
///
/// The parts of elements inside the region are computed in closed form
/// ([`sphere_in_box`](crate::analysis::sphere_in_box)) and summed, with all images in a periodic box. Space
/// shared by two elements is in this sum twice. `overlap` is the space shared by the couples, the lenses of
/// two discs or spheres, and `fraction_without_overlap` counts it once. Space shared by three elements is
/// then subtracted too often: if there is any, the covered fraction lies between the two fractions. If
/// overlaps are small, as in packings of hard grains, the covered fraction is `fraction_without_overlap`.
///
/// A lens at the border of the region is counted in proportion to the part of its bounding ball that is
/// inside. `overlap_error` bounds the error of this.
///
/// # Units
/// The length unit of the centres, squared in 2D, cubed in 3D.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PackingFraction {
    /// Limits `[min, max]` along each axis. In a sheared box they are distances at right angles to its faces,
    /// from the face with the origin.
    pub region: Vec<[f64; 2]>,
    /// Area or volume of the region.
    pub measure: f64,
    /// Area or volume of the parts of elements in the region, summed.
    pub solid: f64,
    /// `solid / measure`.
    pub fraction: f64,
    /// Area or volume of the lenses of the couples in the region, summed.
    pub overlap: f64,
    /// Upper bound of the error of `overlap`.
    pub overlap_error: f64,
    /// `(solid - overlap) / measure`, at least 0. It is a lower bound of the covered fraction, and equal to
    /// it if no three elements overlap in one place.
    pub fraction_without_overlap: f64,
}

/// The region in which the packing fraction is measured, and the axes along which it is the whole periodic
/// box.
pub(crate) struct Region<'a, const D: usize> {
    network: &'a Network<'a, D>,
    frame: &'a DomainFrame<D>,
    limits: [[f64; 2]; D],
    whole: [bool; D],
}

/// Area or volume of lenses, and a bound of its error, for a part of the couples.
#[derive(Clone, Copy, Default)]
pub(crate) struct LensSum {
    overlap: f64,
    overlap_error: f64,
}

impl<'a, const D: usize> Region<'a, D> {
    /// The region `inner`, or the default one, or the reason why there is none.
    pub(crate) fn of(
        placed: &'a Placed<'a, D>,
        inner: Option<[[f64; 2]; D]>,
    ) -> Result<Result<Self, String>, AnalysisError> {
        let (network, frame) = (placed.network, &placed.frame);
        let wrong = |axis: &usize| inner.is_some_and(|limits| !is_region(limits[*axis]));
        if let Some(axis) = (0..D).find(wrong) {
            return Err(AnalysisError::Region {
                axis,
                limits: inner.map_or([0.0; 2], |limits| limits[axis]),
            });
        }
        if network.sizes.are_points() {
            return Ok(Err("points fill no space".to_owned()));
        }
        if network.space.centres.is_empty() {
            return Ok(Err("there are no elements".to_owned()));
        }
        if inner.is_some() && !frame.along_axes {
            return Err(AnalysisError::ShearedBox);
        }
        let margin = 2.0 * frame.largest_radius;
        let region = inner.unwrap_or_else(|| {
            each(|axis| {
                let [low, high] = frame.domain[axis];
                if frame.periods[axis].is_some() { [low, high] } else { [low + margin, high - margin] }
            })
        });
        if let Some(axis) = (0..D).find(|&axis| !is_region(region[axis])) {
            let name = ["x", "y", "z"][axis];
            return Ok(Err(format!(
                "nothing is left along {name} when the domain is shrunk by the largest diameter on both sides"
            )));
        }
        let misses = |axis: &usize| {
            let ([low, high], [first, last]) = (region[*axis], frame.domain[*axis]);
            frame.periods[*axis].is_none() && (low >= last || high <= first)
        };
        if let Some(axis) = (0..D).find(misses) {
            let ([first, last], name) = (frame.domain[axis], ["x", "y", "z"][axis]);
            return Ok(Err(format!(
                "the inner region holds no element: along {name} they are from {} to {}",
                brief(first),
                brief(last)
            )));
        }
        // Along axes where the region is the whole periodic box, its border cuts no element.
        let whole: [bool; D] = each(|axis| inner.is_none() && frame.periods[axis].is_some());
        if !frame.along_axes && whole.iter().filter(|whole| !**whole).count() > 1 {
            return Ok(Err("the box is sheared and has more than one edge that is not periodic".to_owned()));
        }
        Ok(Ok(Self { network, frame, limits: region, whole }))
    }

    /// The point of the region at these parts of its sides.
    pub(crate) fn point(&self, parts: [f64; D]) -> [f64; D] {
        let at: [f64; D] = each(|axis| {
            let [low, high] = self.limits[axis];
            low + parts[axis] * (high - low)
        });
        match &self.network.space.cell {
            Some(cell) if !self.frame.along_axes => {
                let (origin, edges, heights) = (cell.origin(), cell.edges(), cell.heights());
                each(|axis| {
                    let along = (0..D).map(|edge| at[edge] / heights[edge] * edges[edge][axis]);
                    origin[axis] + along.sum::<f64>()
                })
            }
            _ => at,
        }
    }

    /// Adds the part inside the region of the lens of a couple, by its centres and their distance.
    pub(crate) fn add(&self, sum: &mut LensSum, radii: [f64; 2], [a, b]: [[f64; D]; 2], distance: f64) {
        let Some(lens) = Lens::<D>::of(radii, distance) else { return };
        let middle = each(|axis| a[axis] + lens.at * (b[axis] - a[axis]));
        let around = ball::<D>(lens.radius);
        self.for_each_part(self.frame.transformed(self.network, middle), lens.radius, |part| {
            let part = (part / around).min(1.0);
            sum.overlap += lens.measure * part;
            if part > 0.0 && part < 1.0 {
                sum.overlap_error += lens.measure * part.max(1.0 - part);
            }
        });
    }

    /// The packing fraction, with the lenses of all couples, or the reason why it cannot be given.
    pub(crate) fn fraction(
        &self,
        team: &Team<'_>,
        lenses: impl Iterator<Item = LensSum>,
    ) -> Result<PackingFraction, String> {
        let network = self.network;
        let solids = team.parts(network.space.centres.len(), |range| {
            let mut solid = 0.0;
            for element in range {
                let (centre, radius) =
                    (self.frame.coordinates(network, element), network.sizes.radius(element));
                self.for_each_part(centre, radius, |part| solid += part);
            }
            solid
        });
        let solid: f64 = solids.into_iter().sum();
        let (mut overlap, mut overlap_error) = (0.0, 0.0);
        for part in lenses {
            overlap += part.overlap;
            overlap_error += part.overlap_error;
        }
        let measure = self.frame.measure(&self.limits);
        if ![measure, solid, overlap, overlap_error].iter().all(|sum| sum.is_finite()) {
            return Err(
                "lengths are too large or too small for areas and volumes to be finite numbers".to_owned()
            );
        }
        Ok(PackingFraction {
            region: self.limits.to_vec(),
            measure,
            solid,
            fraction: solid / measure,
            overlap,
            overlap_error,
            fraction_without_overlap: ((solid - overlap) / measure).max(0.0),
        })
    }

    /// Visits the area or volume inside the region of a disc or sphere and of each of its images.
    fn for_each_part(&self, centre: [f64; D], radius: f64, mut visit: impl FnMut(f64)) {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let limits: [[f64; 2]; D] =
            each(|axis| if self.whole[axis] { everywhere } else { self.limits[axis] });
        let mut images = [[0.0; 2]; D];
        for axis in 0..D {
            if let (Some(period), false) = (self.frame.periods[axis], self.whole[axis]) {
                let [low, high] = limits[axis];
                images[axis] = [
                    ((low - radius - centre[axis]) / period).ceil(),
                    ((high + radius - centre[axis]) / period).floor(),
                ];
                if images[axis][0] > images[axis][1] {
                    return;
                }
            }
        }
        let mut shift: [f64; D] = each(|axis| images[axis][0]);
        loop {
            let at = each(|axis| centre[axis] + shift[axis] * self.frame.periods[axis].unwrap_or(0.0));
            visit(ball_in_box(at, radius, limits));
            // The next shift, counted like an odometer.
            let Some(axis) = (0..D).find(|&axis| shift[axis] < images[axis][1]) else { return };
            shift[axis] += 1.0;
            for before in 0..axis {
                shift[before] = images[before][0];
            }
        }
    }
}

fn is_region([low, high]: [f64; 2]) -> bool {
    low < high && (high - low).is_finite()
}

fn ball_in_box<const D: usize>(centre: [f64; D], radius: f64, limits: [[f64; 2]; D]) -> f64 {
    let [x, y] = [0, 1].map(|axis| (centre[axis], limits[axis]));
    if D == 2 {
        disc_in_rectangle([x.0, y.0], radius, [x.1, y.1])
    } else {
        sphere_in_box([x.0, y.0, centre[D - 1]], radius, [x.1, y.1, limits[D - 1]])
    }
}

/// Area of a disc or volume of a sphere, rounded in the same way as in [`disc_in_rectangle`] and
/// [`sphere_in_box`].
pub(crate) fn ball<const D: usize>(radius: f64) -> f64 {
    if D == 2 { PI * radius * radius } else { 4.0 * PI / 3.0 * radius.powi(3) }
}

/// Intersection of two discs or spheres.
struct Lens<const D: usize> {
    measure: f64,
    /// Position of its middle on the line of the centres: 0 at the first centre, 1 at the second.
    at: f64,
    /// Radius of a ball around its middle that contains the lens.
    radius: f64,
}

impl<const D: usize> Lens<D> {
    fn of([a, b]: [f64; 2], distance: f64) -> Option<Self> {
        let smaller = a.min(b);
        if distance >= a + b || smaller <= 0.0 {
            return None;
        }
        if distance <= (a - b).abs() {
            // The smaller one is inside the other.
            let measure = ball::<D>(smaller);
            return Some(Self { measure, at: if a < b { 0.0 } else { 1.0 }, radius: smaller });
        }
        let d = distance;
        // Distance of the plane of the rim from the first centre, and radius of the rim by Heron's formula,
        // whose factors lose no digits.
        let to_plane = (d * d + (a - b) * (a + b)) / (2.0 * d);
        let rim = ((a + b + d) * (a + b - d) * (d + a - b) * (d - a + b)).max(0.0).sqrt() / (2.0 * d);
        let measure = if D == 2 {
            let segment = |r: f64, x: f64| r * r * rim.atan2(x) - x * rim;
            segment(a, to_plane) + segment(b, d - to_plane)
        } else {
            let depth = a + b - d;
            PI * depth * depth * (d * d + 2.0 * d * (a + b) - 3.0 * (a - b) * (a - b)) / (12.0 * d)
        };
        let radius = rim.max(a - to_plane).max(b - (d - to_plane));
        Some(Self { measure, at: to_plane / d, radius })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area or volume of a lens by numerical integration.
    fn by_slices(d_is_3: bool, a: f64, b: f64, distance: f64) -> f64 {
        const SLICES: usize = 1_000_000;
        let low = (-a).max(distance - b);
        let high = a.min(distance + b);
        let width = (high - low) / SLICES as f64;
        (0..SLICES)
            .map(|slice| {
                let x = low + (slice as f64 + 0.5) * width;
                let squared = (a * a - x * x).min(b * b - (distance - x) * (distance - x)).max(0.0);
                width * if d_is_3 { PI * squared } else { 2.0 * squared.sqrt() }
            })
            .sum()
    }

    #[test]
    fn lenses_are_what_discs_and_spheres_have_in_common() {
        for (a, b, distance) in [
            (1.0, 1.0, 1.9),
            (1.0, 0.5, 1.4),
            (1.0, 0.5, 0.7),
            (0.3, 2.0, 2.1),
            (1.0, 0.4, 0.2),
            (1.0, 1.0, 1e-3),
        ] {
            let (flat, solid) =
                (Lens::<2>::of([a, b], distance).unwrap(), Lens::<3>::of([a, b], distance).unwrap());
            assert!(
                (flat.measure / by_slices(false, a, b, distance) - 1.0).abs() < 1e-5,
                "{a} {b} {distance}"
            );
            assert!(
                (solid.measure / by_slices(true, a, b, distance) - 1.0).abs() < 1e-5,
                "{a} {b} {distance}"
            );
        }
        assert!(Lens::<3>::of([1.0, 1.0], 2.0).is_none());
        assert!(Lens::<2>::of([1.0, 0.0], 0.5).is_none());
    }
}
