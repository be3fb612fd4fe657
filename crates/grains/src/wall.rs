//! Walls: surfaces that spheres touch, with a given motion.

use serde::{Deserialize, Serialize};

use crate::servo::{Servo, ServoMotion};
use crate::vector::{Vector, across, cross, dot, length, minus, plus, times};

/// A wall. It has no mass: it stays, or moves with a given velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Name, for messages and results; may be empty.
    pub name: String,
    /// The shape at the beginning.
    pub shape: WallShape,
    /// Number of its material.
    pub material: u32,
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Rotation besides that; `None` for none.
    pub rotation: Option<WallRotation>,
    /// Displacements besides that: times, s, ascending, each with a displacement, m. It is linear between
    /// them and constant outside; empty for none.
    pub path: Vec<(f64, [f64; 3])>,
    /// A force that the wall keeps up by its own motion; `None` for none.
    pub servo: Option<Servo>,
    /// Time from which velocity, rotation and path count, s. Before it the wall is at rest.
    pub from: f64,
}

/// Where a wall is at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    /// m.
    pub(crate) displacement: Vector,
    /// Velocity besides the rotation, m/s.
    velocity: Vector,
    /// A point on the axis of rotation at the beginning, m, and the direction of the axis.
    through: Vector,
    axis: Vector,
    /// Sine and cosine of the angle.
    turn: (f64, f64),
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// A cone that is cut off at two points of its axis, from both sides.
    Cone {
        /// Two different points on its axis, m.
        axis: [[f64; 3]; 2],
        /// The radii there, m; at least 0, one of them above it.
        radii: [f64; 2],
    },
    /// A flat disc, from both sides.
    Disc {
        /// m.
        centre: [f64; 3],
        /// Across the disc, of any length but 0.
        normal: [f64; 3],
        /// m.
        radius: f64,
    },
    /// Triangles, from both sides; in the plane segments, whose third corner is the second. Corners at the
    /// same place are one.
    Mesh {
        /// Corners of each, m.
        triangles: Vec<[[f64; 3]; 3]>,
    },
}

impl Wall {
    /// A plane at rest: a point on it, m, the direction towards the spheres, and the number of its material.
    pub fn plane(point: [f64; 3], normal: [f64; 3], material: u32) -> Self {
        Self {
            name: String::new(),
            shape: WallShape::Plane { point, normal },
            material,
            velocity: [0.0; 3],
            rotation: None,
            path: Vec::new(),
            servo: None,
            from: 0.0,
        }
    }

    /// Whether it ever moves.
    pub(crate) fn moves(&self) -> bool {
        self.velocity != [0.0; 3] || self.rotation.is_some() || !self.path.is_empty() || self.servo.is_some()
    }

    /// Where the wall is after a time, s, if its servo has moved it.
    pub(crate) fn placement(&self, time: f64, servo: &ServoMotion) -> Placement {
        let time = (time - self.from).max(0.0);
        let (along, slope) = self.along_path(time);
        let [moved, speed] = self
            .servo
            .map_or([[0.0; 3]; 2], |of| [servo.travel, servo.velocity].map(|size| times(size, of.unit())));
        let spin = self.rotation.map_or([0.0; 3], |of| of.spin);
        let rate = length(spin);
        Placement {
            displacement: plus(plus(times(time, self.velocity), along), moved),
            velocity: plus(plus(self.velocity, slope), speed),
            through: self.rotation.map_or([0.0; 3], |of| of.through),
            axis: if rate > 0.0 { times(1.0 / rate, spin) } else { [0.0; 3] },
            turn: libm::sincos(rate * time),
        }
    }

    /// The wall after a time, s, where its servo has moved it; a mesh without its triangles.
    pub(crate) fn at(&self, time: f64, servo: &ServoMotion) -> Self {
        let place = self.placement(time, servo);
        let unit = |vector: Vector| times(1.0 / length(vector), place.turned(vector));
        let shape = match &self.shape {
            WallShape::Plane { point, normal } => {
                WallShape::Plane { point: place.of(*point), normal: unit(*normal) }
            }
            WallShape::Tube { axis, radius } => {
                WallShape::Tube { axis: axis.map(|point| place.of(point)), radius: *radius }
            }
            WallShape::Cone { axis, radii } => {
                WallShape::Cone { axis: axis.map(|point| place.of(point)), radii: *radii }
            }
            WallShape::Disc { centre, normal, radius } => {
                WallShape::Disc { centre: place.of(*centre), normal: unit(*normal), radius: *radius }
            }
            WallShape::Mesh { .. } => WallShape::Mesh { triangles: Vec::new() },
        };
        let through = |of: WallRotation| plus(of.through, place.displacement);
        Self {
            name: self.name.clone(),
            shape,
            material: self.material,
            velocity: place.velocity,
            rotation: self.rotation.map(|of| WallRotation { through: through(of), ..of }),
            path: Vec::new(),
            servo: self.servo,
            from: 0.0,
        }
    }

    /// Displacement, m, and velocity, m/s, of the path at a time, s.
    fn along_path(&self, time: f64) -> (Vector, Vector) {
        let next = self.path.partition_point(|(at, _)| *at <= time);
        let Some(&(end, to)) = self.path.get(next) else {
            return (self.path.last().map_or([0.0; 3], |(_, last)| *last), [0.0; 3]);
        };
        if next == 0 {
            return (to, [0.0; 3]);
        }
        let (begin, from) = self.path[next - 1];
        let velocity = times(1.0 / (end - begin), minus(to, from));
        (plus(from, times(time - begin, velocity)), velocity)
    }

    /// The direction from a wall that is in its place to a point, of unit length, and the distance, m. A mesh
    /// is infinitely far away: its facets are searched.
    pub(crate) fn nearest(&self, point: Vector) -> (Vector, f64) {
        self.nearest_along(point, self.along())
    }

    /// The direction of the axis of a tube or a cone, of unit length.
    pub(crate) fn along(&self) -> Vector {
        match &self.shape {
            WallShape::Tube { axis: [from, to], .. } | WallShape::Cone { axis: [from, to], .. } => {
                let along = minus(*to, *from);
                times(1.0 / length(along), along)
            }
            _ => [0.0; 3],
        }
    }

    /// The same as [`Wall::nearest`] for many points, with the direction of the axis.
    #[inline]
    pub(crate) fn nearest_along(&self, point: Vector, along: Vector) -> (Vector, f64) {
        match &self.shape {
            WallShape::Plane { point: on, normal } => (*normal, dot(minus(point, *on), *normal)),
            WallShape::Tube { axis: [from, _], radius } => {
                let out = across(minus(point, *from), along);
                let size = length(out);
                // On the axis every direction is as good.
                let normal =
                    if size > 0.0 { times(-1.0 / size, out) } else { across([1.0, 0.0, 0.0], along) };
                (normal, radius - size)
            }
            WallShape::Cone { axis: [from, to], radii } => nearest_on_cone(point, [*from, *to], *radii),
            WallShape::Disc { centre, normal, radius } => {
                let from = minus(point, *centre);
                let out = across(from, *normal);
                let size = length(out);
                if size <= *radius {
                    let height = dot(from, *normal);
                    return (if height < 0.0 { times(-1.0, *normal) } else { *normal }, height.abs());
                }
                direction(minus(from, times(radius / size, out)), *normal)
            }
            WallShape::Mesh { .. } => ([0.0, 0.0, 1.0], f64::INFINITY),
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

/// The direction of a vector, or another one if it has no length, and its length, m.
fn direction(vector: Vector, other: Vector) -> (Vector, f64) {
    let size = length(vector);
    if size > 0.0 { (times(1.0 / size, vector), size) } else { (other, 0.0) }
}

/// The direction from a cone to a point and the distance, m: in the half plane through the axis and the
/// point the cone is a segment.
fn nearest_on_cone(point: Vector, [from, to]: [Vector; 2], radii: [f64; 2]) -> (Vector, f64) {
    let axis = minus(to, from);
    let height = length(axis);
    let along = times(1.0 / height, axis);
    let out = across(minus(point, from), along);
    let size = length(out);
    // On the axis every direction is as good.
    let least = if along[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let side = across(least, along);
    let out = if size > 0.0 { times(1.0 / size, out) } else { times(1.0 / length(side), side) };
    let [run, rise] = [radii[1] - radii[0], height];
    let [across_axis, along_axis] = [size - radii[0], dot(minus(point, from), along)];
    let share = ((across_axis * run + along_axis * rise) / (run * run + rise * rise)).clamp(0.0, 1.0);
    let [radial, axial] = [across_axis - share * run, along_axis - share * rise];
    let normal = times(1.0 / libm::hypot(run, rise), minus(times(rise, out), times(run, along)));
    direction(plus(times(radial, out), times(axial, along)), normal)
}

impl Placement {
    /// Where a point of the wall is.
    #[inline]
    pub(crate) fn of(&self, point: Vector) -> Vector {
        plus(plus(self.through, self.turned(minus(point, self.through))), self.displacement)
    }

    /// A vector that has turned with the wall (Rodrigues).
    #[inline]
    fn turned(&self, vector: Vector) -> Vector {
        let (sin, cos) = self.turn;
        if sin == 0.0 && cos == 1.0 {
            return vector;
        }
        let along = times(dot(self.axis, vector) * (1.0 - cos), self.axis);
        plus(plus(times(cos, vector), times(sin, cross(self.axis, vector))), along)
    }
}
