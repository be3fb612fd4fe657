//! Prisms that replace cylinders: convex, with flat sides, so that they can be cut into grains.

use std::f64::consts::TAU;

use super::round::Axis;
use crate::tetrahedra::vector::{Point, dot, length, minus, plus, times};
use crate::tetrahedra::{MeshError, OUTSIDE, Surface, Tetrahedra, positive};

/// Number of sides. With fewer, moved elements are too oblique; with more, sides are narrow, and grains meet
/// their edges at small angles. In 24 bodies of 12 grains the least angle between facets was 2.4° with 8
/// sides, 5.8° with 12, 8.1° with 14, 8.7° with 16, and 6.7° with 18.
const SIDES: u32 = 16;

/// The angle under which the axis sees a side.
const WIDTH: f64 = TAU / SIDES as f64;

/// A prism whose edges are on a cylinder.
#[derive(Clone, Copy, Debug)]
pub struct Prism {
    axis: Axis,
    radius: f64,
}

impl Prism {
    /// The prism of the cylinder between the centres of its two ends.
    ///
    /// # Errors
    /// [`MeshError::NotFinite`], [`MeshError::Length`].
    pub fn of_cylinder(from: [f64; 3], to: [f64; 3], radius: f64) -> Result<Self, MeshError> {
        positive(radius)?;
        Ok(Self { axis: Axis::new(from, to)?, radius })
    }

    /// Its surface. Faces: `bottom` (around `from`), `top`, `mantle`.
    pub fn surface(&self) -> Surface {
        let names = ["bottom", "top", "mantle"].map(str::to_owned).to_vec();
        let mut surface = Surface { names, ..Surface::default() };
        for part in [0.0, 1.0] {
            let corner = |k: u32| self.axis.place(self.radius, WIDTH * f64::from(k), part);
            surface.nodes.extend((0..SIDES).map(corner));
        }
        let mut push = |facet: [u32; 3], face: u32| {
            surface.facets.push(facet);
            surface.faces.push(face);
            surface.sides.push([0, OUTSIDE]);
        };
        for k in 1..SIDES - 1 {
            push([0, k + 1, k], 0);
            push([SIDES, SIDES + k, SIDES + k + 1], 1);
        }
        for k in 0..SIDES {
            let next = (k + 1) % SIDES;
            push([k, next, SIDES + next], 2);
            push([k, SIDES + next, SIDES + k], 2);
        }
        surface
    }

    /// Makes a mesh of the prism one of the cylinder.
    pub fn round(&self, mesh: &mut Tetrahedra) {
        for node in &mut mesh.nodes {
            *node = self.rounded(*node);
        }
    }

    /// Where a point of the prism is in the cylinder: farther from the axis, so that the sides are on the
    /// mantle.
    fn rounded(&self, point: Point) -> Point {
        let along = minus(self.axis.to, self.axis.from);
        let off = minus(point, self.axis.from);
        let part = dot(off, along) / dot(along, along);
        let away = minus(off, times(along, part));
        if length(away) == 0.0 {
            return point;
        }
        // The angle from the middle of the side.
        let angle = self.axis.angle(point) % WIDTH - 0.5 * WIDTH;
        let factor = libm::cos(angle) / libm::cos(0.5 * WIDTH);
        plus(point, times(away, factor - 1.0))
    }
}
