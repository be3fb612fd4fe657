//! Walls: surfaces that spheres touch, with a given motion.

use serde::{Deserialize, Serialize};

use crate::vector::{Vector, across, cross, dot, length, minus, plus, times};

/// A wall. It has no mass: it stays, or moves with a given velocity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// The shape at the beginning.
    pub shape: WallShape,
    /// Number of its material.
    pub material: u32,
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Rotation besides that; `None` for none.
    pub rotation: Option<WallRotation>,
}

/// A rotation about an axis that moves with the velocity of the wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WallRotation {
    /// A point on the axis at the beginning, m.
    pub through: [f64; 3],
    /// Angular velocity, rad/s.
    pub spin: [f64; 3],
}

/// The shape of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum WallShape {
    /// A plane without ends.
    Plane {
        /// A point on it, m.
        point: [f64; 3],
        /// Towards the spheres; of any length but 0.
        normal: [f64; 3],
    },
    /// The inside of a tube without ends.
    Tube {
        /// Two different points on its axis, m.
        axis: [[f64; 3]; 2],
        /// m.
        radius: f64,
    },
}

impl Wall {
    /// A plane at rest: a point on it, m, the direction towards the spheres, and the number of its material.
    pub fn plane(point: [f64; 3], normal: [f64; 3], material: u32) -> Self {
        Self { shape: WallShape::Plane { point, normal }, material, velocity: [0.0; 3], rotation: None }
    }

    /// The wall after a time, s: where it is, and which way it looks.
    pub(crate) fn at(&self, time: f64) -> Self {
        let place = |point: Vector| {
            let turned = self.rotation.map_or(point, |rotation| {
                plus(rotation.through, turned(minus(point, rotation.through), rotation.spin, time))
            });
            plus(turned, times(time, self.velocity))
        };
        let direction = |vector: Vector| self.rotation.map_or(vector, |of| turned(vector, of.spin, time));
        let shape = match self.shape {
            WallShape::Plane { point, normal } => {
                let normal = direction(normal);
                WallShape::Plane { point: place(point), normal: times(1.0 / length(normal), normal) }
            }
            WallShape::Tube { axis, radius } => WallShape::Tube { axis: axis.map(place), radius },
        };
        let rotation = self
            .rotation
            .map(|of| WallRotation { through: plus(of.through, times(time, self.velocity)), ..of });
        Self { shape, rotation, ..*self }
    }

    /// The direction from a wall that is in its place to a point, of unit length, and the distance, m.
    #[inline]
    pub(crate) fn nearest(&self, point: Vector) -> (Vector, f64) {
        match self.shape {
            WallShape::Plane { point: on, normal } => (normal, dot(minus(point, on), normal)),
            WallShape::Tube { axis: [from, to], radius } => {
                let along = minus(to, from);
                let along = times(1.0 / length(along), along);
                let out = across(minus(point, from), along);
                let size = length(out);
                // On the axis every direction is as good.
                let normal =
                    if size > 0.0 { times(-1.0 / size, out) } else { across([1.0, 0.0, 0.0], along) };
                (normal, radius - size)
            }
        }
    }

    /// Velocity of the wall at a point, m/s, where it is in its place.
    #[inline]
    pub(crate) fn velocity_at(&self, point: Vector) -> Vector {
        self.rotation
            .map_or(self.velocity, |of| plus(self.velocity, cross(of.spin, minus(point, of.through))))
    }

    /// Angular velocity, rad/s.
    pub(crate) fn spin(&self) -> Vector {
        self.rotation.map_or([0.0; 3], |of| of.spin)
    }
}

/// A vector that has turned with an angular velocity, rad/s, for a time, s (Rodrigues).
fn turned(vector: Vector, spin: Vector, time: f64) -> Vector {
    let rate = length(spin);
    if rate == 0.0 {
        return vector;
    }
    let axis = times(1.0 / rate, spin);
    let (sin, cos) = libm::sincos(rate * time);
    let along = times(dot(axis, vector) * (1.0 - cos), axis);
    plus(plus(times(cos, vector), times(sin, cross(axis, vector))), along)
}
