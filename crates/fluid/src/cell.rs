//! Cells: opened facets, and their geometry.

use std::fmt;

use crate::aperture::ApertureLaw;
use crate::error::{FluidError, check};

/// A cell that fluid can fill: a facet, an edge in the plane (`D = 2`) or a triangle in space (`D = 3`). Both
/// faces belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell<const D: usize> {
    /// Identity of the cell: no other one has it, and it stays when cells are added. Results depend on the
    /// order of the keys, and not on that of the cells.
    pub key: u64,
    /// Numbers of its corners. Cells are connected over equal corners in the plane, over two equal corners in
    /// space. Numbers of the vertices of the undeformed mesh serve if nodes split where joints open.
    pub corners: [u32; D],
    /// Law of its hydraulic aperture.
    pub law: ApertureLaw,
    /// Carter's coefficient of leak-off through one face, m/√s.
    pub leak_off: f64,
    /// Pressure when it becomes wet, Pa; `None` if it is empty then.
    pub initial_pressure: Option<f64>,
}

/// Shape of a cell at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape<const D: usize> {
    /// Places of its corners, m: the middle between both faces.
    pub corners: [[f64; D]; D],
    /// Mechanical opening, m: the mean of the normal gaps at the corners, each at least zero.
    pub opening: f64,
    /// Effective normal compression of a closed joint, Pa: the total one less the pressure of the fluid,
    /// positive if the walls are pressed together.
    pub compression: f64,
    /// Growth of the aperture with the pressure, m/Pa, that a step may count on before the solid has moved;
    /// zero for rigid walls. A good value is the length of the crack over the plane-strain modulus.
    pub compliance: f64,
    /// Whether fluid can be in it.
    pub is_wet: bool,
}

/// A wet cell as the flow sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opened<const D: usize> {
    pub(crate) is_wet: bool,
    /// Area of one face, m².
    pub(crate) area: f64,
    /// Hydraulic aperture, m.
    pub(crate) aperture: f64,
    /// m/Pa
    pub(crate) compliance: f64,
    pub(crate) centre: [f64; D],
    /// Width of the door opposite to each corner over its distance from the centre.
    pub(crate) shapes: [f64; D],
}

impl<const D: usize> Opened<D> {
    pub(crate) const DRY: Self =
        Self { is_wet: false, area: 0.0, aperture: 0.0, compliance: 0.0, centre: [0.0; D], shapes: [0.0; D] };

    /// m³
    pub(crate) fn volume(&self) -> f64 {
        self.area * self.aperture
    }

    /// Conductance from the centre to a door, m³/(s Pa): `b a³/(12 μ l)`.
    pub(crate) fn conductance(&self, door: usize, viscosity: f64) -> f64 {
        self.shapes[door] * (self.aperture * self.aperture * self.aperture / (12.0 * viscosity))
    }
}

impl<const D: usize> Cell<D> {
    pub(crate) fn check(&self, lowest: f64) -> Result<(), FluidError> {
        let place = Place(self.key);
        self.law.check(place)?;
        check(self.leak_off >= 0.0, place, "leak-off coefficient", self.leak_off, "zero or positive")?;
        let pressure = self.initial_pressure.unwrap_or(lowest);
        let range = "at least the lowest one of the fluid";
        check(pressure >= lowest, place, "initial pressure", pressure, range)?;
        let twice = self.corners.iter().enumerate().find(|(k, corner)| self.corners[..*k].contains(corner));
        match twice {
            Some((_, &corner)) => Err(FluidError::Corners { cell: self.key, corner }),
            None => Ok(()),
        }
    }

    /// The corners of the door opposite to a corner, in order; one corner twice in the plane.
    pub(crate) fn door(&self, opposite: usize) -> [u32; 2] {
        let mut others = self.corners.iter().enumerate().filter(|(k, _)| *k != opposite).map(|(_, c)| *c);
        let first = others.next().unwrap_or_default();
        let second = others.next().unwrap_or(first);
        [first.min(second), first.max(second)]
    }

    /// The cell as the flow sees it. `thickness`: of a model in the plane, m.
    pub(crate) fn opened(&self, shape: &Shape<D>, thickness: f64) -> Result<Opened<D>, FluidError> {
        let Shape { corners, opening, compression, compliance, is_wet } = *shape;
        let place = Place(self.key);
        check(opening >= 0.0, place, "opening", opening, "zero or positive")?;
        check(true, place, "compression", compression, "finite")?;
        check(compliance >= 0.0, place, "compliance", compliance, "zero or positive")?;
        for coordinate in corners.iter().flatten() {
            check(true, place, "coordinate of a corner", *coordinate, "finite")?;
        }
        let (area, shapes) = measures(&corners, thickness);
        if !(area > 0.0 && area.is_finite() && shapes.iter().all(|shape| *shape > 0.0 && shape.is_finite())) {
            return Err(FluidError::Flat { cell: self.key });
        }
        let mut centre = [0.0; D];
        for (axis, at) in centre.iter_mut().enumerate() {
            *at = corners.iter().fold(0.0, |sum, corner| sum + corner[axis]) / D as f64;
        }
        let aperture = self.law.aperture(opening, compression);
        Ok(Opened { is_wet, area, aperture, compliance, centre, shapes })
    }
}

/// The owner of a number in a message. It is written only if there is one.
#[derive(Clone, Copy)]
pub(crate) struct Place(pub(crate) u64);

impl fmt::Display for Place {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "cell {}", self.0)
    }
}

/// Smallest distance between the centre of a triangle and an edge, as a part of that of its centroid.
const LEAST_DISTANCE: f64 = 0.01;

/// Area of one face, and the width of the door opposite to each corner over its distance from the centre.
///
/// In the plane the centre is the middle of the edge. In space it is the centre of the circumscribed circle,
/// because lines between such centres are normal to the edges, so that a uniform gradient of the pressure
/// gives the exact flow in a mesh of acute triangles. Between centroids it would not: in squares that are cut
/// in halves the conductivity would be 1.5 times too large along the cuts, and 0.75 times too small across.
/// Where that centre is outside of an obtuse triangle, or too near an edge, its distance is a hundredth of
/// the distance of the centroid.
fn measures<const D: usize>(corners: &[[f64; D]; D], thickness: f64) -> (f64, [f64; D]) {
    let between = |from: usize, to: usize| -> [f64; D] {
        std::array::from_fn(|axis| corners[to][axis] - corners[from][axis])
    };
    let dot = |a: &[f64; D], b: &[f64; D]| (0..D).fold(0.0, |sum, axis| sum + a[axis] * b[axis]);
    let next = |k: usize, more: usize| (k + more) % D;
    if D == 2 {
        let edge = between(0, 1);
        let length = dot(&edge, &edge).sqrt();
        return (length * thickness, [thickness / (0.5 * length); D]);
    }
    let (u, v) = (between(0, 1), between(0, 2 % D));
    let (uu, vv, uv) = (dot(&u, &u), dot(&v, &v), dot(&u, &v));
    let area = 0.5 * (uu * vv - uv * uv).max(0.0).sqrt();
    let shapes = std::array::from_fn(|k| {
        let (u, v) = (between(k, next(k, 1)), between(k, next(k, 2)));
        let edge = between(next(k, 1), next(k, 2));
        // Over the width: half the cotangent of the angle at the corner; a third of the height.
        let circumcentre = dot(&u, &v) / (4.0 * area);
        let centroid = 2.0 * area / (3.0 * dot(&edge, &edge));
        1.0 / circumcentre.max(LEAST_DISTANCE * centroid)
    });
    (area, shapes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_circumcentre() {
        let (area, shapes) = measures(&[[0.0, 0.0], [3.0, 4.0]], 2.0);
        assert_eq!((area, shapes), (10.0, [0.8; 2]));
        // An equilateral triangle of side 2: area √3, distance 1/√3, width 2.
        let root = 3.0_f64.sqrt();
        let (area, shapes) = measures(&[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [1.0, root, 1.0]], 1.0);
        assert!((area / root - 1.0).abs() < 1e-15);
        assert!(shapes.iter().all(|shape| (shape / (2.0 * root) - 1.0).abs() < 1e-14), "{shapes:?}");
        // A right one: the centre is on the hypotenuse, half a leg from each leg.
        let (_, [hypotenuse, a, b]) = measures(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 1.0);
        assert!((a - 2.0).abs() < 1e-14 && (b - 2.0).abs() < 1e-14);
        let centroid = 2.0_f64.sqrt() / (0.5_f64.sqrt() / 3.0);
        assert!((hypotenuse / (100.0 * centroid) - 1.0).abs() < 1e-13);
    }
}
