//! A convex cell around the origin, cut by planes.

/// A convex polyhedron, by its faces; empty once nothing is left of it.
pub(crate) struct Polytope {
    faces: Vec<Face>,
}

/// The part of a plane that bounds a polyhedron; `offset` is the distance of the plane from the origin,
/// negative if the origin is beyond it.
struct Face {
    offset: f64,
    /// Whether it is a wall, of those that the polyhedron began with.
    wall: bool,
    /// In the order of a walk around it.
    corners: Vec<[f64; 3]>,
}

impl Polytope {
    /// The box between limits along each axis; `walls`: whether its faces across an axis are walls.
    pub(crate) fn new(limits: [[f64; 2]; 3], walls: [bool; 3]) -> Self {
        let mut faces = Vec::with_capacity(16);
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in 0..2 {
                let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[along_u, along_v]| {
                    let mut corner = [0.0; 3];
                    (corner[axis], corner[u], corner[v]) =
                        (limits[axis][side], limits[u][along_u], limits[v][along_v]);
                    corner
                });
                let offset = [-1.0, 1.0][side] * limits[axis][side];
                faces.push(Face { offset, wall: walls[axis], corners: corners.to_vec() });
            }
        }
        Self { faces }
    }

    /// Distance of the farthest corner from the origin; 0 if the polyhedron is empty.
    pub(crate) fn reach(&self) -> f64 {
        let corners = self.faces.iter().flat_map(|face| &face.corners);
        corners.fold(0.0_f64, |reach, corner| reach.max(dot(corner, corner))).sqrt()
    }

    /// Cuts off the part beyond the plane `normal · x = offset`, where `normal` has unit length.
    ///
    /// A corner that rounding puts beyond the plane counts as one on the plane, so that planes that meet
    /// corners and edges, as in lattices, cut nothing off.
    pub(crate) fn cut(&mut self, normal: [f64; 3], offset: f64) {
        /// Rounding of corners, over the size of the polyhedron.
        const ROUNDING: f64 = 1e-12;
        let rounding = ROUNDING * (self.reach() + offset.abs());
        let beyond = |corner: &[f64; 3]| dot(&normal, corner) - offset;
        if self.faces.iter().flat_map(|face| &face.corners).all(|corner| beyond(corner) <= rounding) {
            return;
        }
        let mut rim: Vec<[f64; 3]> = Vec::new();
        for face in &mut self.faces {
            let corners = std::mem::take(&mut face.corners);
            for (k, a) in corners.iter().enumerate() {
                let b = &corners[(k + 1) % corners.len()];
                let (of_a, of_b) = (beyond(a), beyond(b));
                if of_a <= rounding {
                    face.corners.push(*a);
                    if of_a >= -rounding {
                        rim.push(*a);
                    }
                }
                if (of_a < -rounding && of_b > rounding) || (of_a > rounding && of_b < -rounding) {
                    let part = of_a / (of_a - of_b);
                    let mut crossing = *a;
                    for axis in 0..3 {
                        crossing[axis] += part * (b[axis] - a[axis]);
                    }
                    face.corners.push(crossing);
                    rim.push(crossing);
                }
            }
        }
        self.faces.retain(|face| face.corners.len() >= 3);
        if self.faces.is_empty() {
            return;
        }
        let corners = around(rim, normal, rounding);
        if corners.len() >= 3 {
            self.faces.push(Face { offset, wall: false, corners });
        }
    }

    /// The volume.
    pub(crate) fn volume(&self) -> f64 {
        self.faces.iter().map(|face| face.offset * face.area()).sum::<f64>() / 3.0
    }

    /// Whether a wall is left.
    pub(crate) fn has_wall(&self) -> bool {
        self.faces.iter().any(|face| face.wall)
    }
}

impl Face {
    fn area(&self) -> f64 {
        let first = self.corners[0];
        let mut twice = [0.0; 3];
        for pair in self.corners[1..].windows(2) {
            let part = cross(&minus(&pair[0], &first), &minus(&pair[1], &first));
            for axis in 0..3 {
                twice[axis] += part[axis];
            }
        }
        0.5 * dot(&twice, &twice).sqrt()
    }
}

/// Corners of a convex polygon with this normal in the order of a walk around it, each once.
fn around(mut corners: Vec<[f64; 3]>, normal: [f64; 3], rounding: f64) -> Vec<[f64; 3]> {
    let count = corners.len() as f64;
    let mut middle = [0.0; 3];
    for corner in &corners {
        for axis in 0..3 {
            middle[axis] += corner[axis] / count;
        }
    }
    // Two directions in the plane: the axis that is farthest from the normal is not along it.
    let least = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = cross(&normal, &axis);
    let v = cross(&normal, &u);
    let angle = |corner: &[f64; 3]| {
        let from = minus(corner, &middle);
        dot(&from, &v).atan2(dot(&from, &u))
    };
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        let apart = minus(a, b);
        dot(&apart, &apart) <= rounding * rounding
    };
    corners.dedup_by(|a, b| near(a, b));
    if corners.len() > 1 && near(&corners[0], &corners[corners.len() - 1]) {
        corners.pop();
    }
    corners
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_cut() {
        let mut cube = Polytope::new([[-1.0, 1.0]; 3], [true, false, false]);
        assert!((cube.volume() - 8.0).abs() < 1e-14 && (cube.reach() - 3.0_f64.sqrt()).abs() < 1e-15);
        let normal = [1.0 / 3.0_f64.sqrt(); 3];
        // A plane through a corner cuts nothing; one through three corners cuts a sixth of the cube off.
        cube.cut(normal, 3.0 / 3.0_f64.sqrt());
        assert!((cube.volume() - 8.0).abs() < 1e-14);
        cube.cut(normal, 1.0 / 3.0_f64.sqrt());
        assert!((cube.volume() - (8.0 - 8.0 / 6.0)).abs() < 1e-13, "{}", cube.volume());
        assert!(cube.has_wall());
        // The planes of a smaller cube; the origin may be outside.
        for axis in 0..3 {
            for (sign, offset) in [(1.0, -0.25), (-1.0, 0.75)] {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                cube.cut(normal, offset);
            }
        }
        assert!((cube.volume() - 0.125).abs() < 1e-14 && !cube.has_wall());
        cube.cut([0.0, 0.0, 1.0], -2.0);
        assert_eq!((cube.volume(), cube.reach()), (0.0, 0.0));
    }
}
