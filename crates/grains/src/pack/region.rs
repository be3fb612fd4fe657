//! The regions that spheres fill.

use std::f64::consts::PI;

use crate::pack::closed::ClosedSurface;
use crate::pack::sizes::measure;
use crate::vector::{Vector, cross, dot, length, minus, times};

/// A region that spheres fill. With discs it is in the plane z = 0.
#[derive(Clone, Debug)]
pub enum PackRegion {
    /// A box along the axes, or a rectangle.
    Box {
        /// The corner with the lowest coordinates, m.
        low: [f64; 3],
        /// The corner with the highest coordinates, m.
        high: [f64; 3],
    },
    /// A cylinder.
    Cylinder {
        /// Centre of one end, m.
        from: [f64; 3],
        /// Centre of the other end, m.
        to: [f64; 3],
        /// m.
        radius: f64,
    },
    /// A ball, or a disc.
    Ball {
        /// m.
        centre: [f64; 3],
        /// m.
        radius: f64,
    },
    /// The inside of a closed surface of triangles.
    Inside(Box<ClosedSurface>),
}

impl PackRegion {
    /// Volume, m³, or area, m².
    pub fn measure(&self, discs: bool) -> f64 {
        match self {
            Self::Box { low, high } => {
                (0..if discs { 2 } else { 3 }).map(|axis| high[axis] - low[axis]).product()
            }
            Self::Cylinder { from, to, radius } => PI * radius * radius * length(minus(*to, *from)),
            Self::Ball { radius, .. } => measure(*radius, discs),
            Self::Inside(surface) => surface.volume(),
        }
    }

    /// The lowest and the highest corner of a box around the region, m.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        match self {
            Self::Box { low, high } => [*low, *high],
            Self::Cylinder { from, to, radius } => {
                let along = minus(*to, *from);
                let unit = times(1.0 / length(along), along);
                let half = unit.map(|x| radius * (1.0 - x * x).max(0.0).sqrt());
                [
                    [0, 1, 2].map(|axis| from[axis].min(to[axis]) - half[axis]),
                    [0, 1, 2].map(|axis| from[axis].max(to[axis]) + half[axis]),
                ]
            }
            Self::Ball { centre, radius } => [centre.map(|x| x - radius), centre.map(|x| x + radius)],
            Self::Inside(surface) => surface.bounds(),
        }
    }

    /// Whether a sphere could be in the region at all, as far as its bounds say.
    pub(crate) fn has_room(&self, radius: f64, discs: bool) -> bool {
        let [low, high] = self.bounds();
        let is_wide = (0..if discs { 2 } else { 3 }).all(|axis| high[axis] - low[axis] >= 2.0 * radius);
        let fits = match self {
            Self::Cylinder { radius: of, .. } | Self::Ball { radius: of, .. } => *of >= radius,
            _ => true,
        };
        is_wide && fits
    }

    /// Whether a sphere at a point inside of the bounds is in the region.
    pub(crate) fn contains(&self, point: Vector, radius: f64, discs: bool) -> bool {
        if let Self::Inside(surface) = self
            && !surface.contains(point)
        {
            return false;
        }
        let mut is_inside = true;
        self.near_sides(point, radius, discs, &mut |distance, _| is_inside &= distance >= radius);
        is_inside
    }

    /// Visits the sides of the region that are nearer to a point than `reach`: with the distance, m, negative
    /// outside, and the direction inwards.
    pub(crate) fn near_sides(
        &self,
        point: Vector,
        reach: f64,
        discs: bool,
        visit: &mut dyn FnMut(f64, Vector),
    ) {
        let mut side = |distance: f64, inward: Vector| {
            if distance < reach {
                visit(distance, inward);
            }
        };
        match self {
            Self::Box { low, high } => {
                for axis in 0..if discs { 2 } else { 3 } {
                    let mut inward = [0.0; 3];
                    inward[axis] = 1.0;
                    side(point[axis] - low[axis], inward);
                    inward[axis] = -1.0;
                    side(high[axis] - point[axis], inward);
                }
            }
            Self::Cylinder { from, to, radius } => {
                let along = minus(*to, *from);
                let long = length(along);
                let unit = times(1.0 / long, along);
                let arm = minus(point, *from);
                let far = dot(arm, unit);
                side(far, unit);
                side(long - far, times(-1.0, unit));
                let out = minus(arm, times(far, unit));
                let size = length(out);
                let inward = if size > 0.0 { times(-1.0 / size, out) } else { any_across(unit) };
                side(radius - size, inward);
            }
            Self::Ball { centre, radius } => {
                let out = minus(point, *centre);
                let size = length(out);
                side(radius - size, if size > 0.0 { times(-1.0 / size, out) } else { [1.0, 0.0, 0.0] });
            }
            Self::Inside(surface) => surface.near(point, &mut |nearest| {
                let arm = minus(point, nearest);
                let size = length(arm);
                if size > 0.0 {
                    side(size, times(1.0 / size, arm));
                }
            }),
        }
    }

    /// Prepares the region for questions about sides within `reach`, m.
    pub(crate) fn prepared(&mut self, reach: f64) {
        if let Self::Inside(surface) = self {
            surface.prepare(reach);
        }
    }
}

/// A direction across another one.
fn any_across(unit: Vector) -> Vector {
    let axis = if unit[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let across = cross(unit, axis);
    times(1.0 / length(across), across)
}
