//! Joint sets in space: the polygons that statistics give, and bodies with joints.

use std::collections::BTreeMap;

use fdem_mesh::Grading;
use fdem_mesh::tetrahedra::{PolygonError, Surface, Tetrahedra, add_polygons};
use fdem_scenes::random::Random;

use crate::joints::lines::{JointLines, has_joints, joints_of};
use crate::joints::polygons::SpacePolygon;
use crate::shapes::piece::{JointFacet, PolygonsInBody};
use crate::text::fault::Problem;
use crate::text::file::{Body, JointSet, Vector};

type Point = [f64; 3];

/// Polygons of a statistical set in one body, at most.
const MOST: f64 = 3000.0;

/// Area of a regular octagon over the square of its width.
const OCTAGON: f64 = 2.0 * (std::f64::consts::SQRT_2 - 1.0);

/// Largest share of a plane that joints with ends cover.
pub(crate) const PERSISTENT: f64 = 0.8;

/// The joints of a body, in the order of their faces.
pub(crate) struct BodyJoints {
    /// Face of the first joint in the surface.
    first: u32,
    /// Set of each joint.
    sets: Vec<u32>,
    /// Whether the middle of each joint is inside of the body.
    inside: Vec<bool>,
}

impl BodyJoints {
    /// The facets of a mesh that are on joints.
    pub(crate) fn facets(&self, mesh: &Tetrahedra) -> Vec<JointFacet<3>> {
        let facets = mesh.inner.iter().zip(&mesh.inner_faces);
        let joint = facets.filter_map(|(&facet, &face)| {
            let trace = face.checked_sub(self.first)?;
            Some(JointFacet { facet, set: *self.sets.get(trace as usize)?, trace })
        });
        joint.collect()
    }

    /// The polygons of each set in the body: those that the mesh has, and those whose middle is inside and
    /// that it does not have. `facets`: those of [`Self::facets`].
    pub(crate) fn polygons(&self, facets: &[JointFacet<3>]) -> Vec<PolygonsInBody> {
        let mut meshed = vec![false; self.sets.len()];
        for facet in facets {
            meshed[facet.trace as usize] = true;
        }
        let mut all: BTreeMap<u32, PolygonsInBody> = BTreeMap::new();
        for ((&set, &meshed), &inside) in self.sets.iter().zip(&meshed).zip(&self.inside) {
            let of_set = all.entry(set).or_insert(PolygonsInBody { set, count: 0, left_out: 0 });
            of_set.count += usize::from(meshed || inside);
            of_set.left_out += usize::from(inside && !meshed);
        }
        all.into_values().collect()
    }
}

impl JointLines<'_> {
    /// Puts the joints of a body into its surface, before it is meshed. `turn`: the rotation of the body
    /// after that.
    pub(crate) fn put_into(
        &self,
        (body, turn): (&Body, [Point; 3]),
        surface: &mut Surface,
        size: &Grading<3>,
    ) -> Result<BodyJoints, Problem> {
        let mut sets = Vec::new();
        let mut polygons: Vec<SpacePolygon> = Vec::new();
        let placing = SpacePlacing::of(body, turn, surface);
        for (number, (set, given)) in (0..).zip(&self.polygons) {
            if !has_joints(set, body) {
                continue;
            }
            let found = joints_of((set, body), given, MOST, |dip, spacing| {
                statistical(set, dip, spacing, placing.bounds)
            })?;
            let [low, high] = placing.bounds;
            for polygon in found {
                let [least, most] = fdem_mesh::bounds(polygon.iter().copied());
                if (0..3).all(|axis| least[axis] <= high[axis] && most[axis] >= low[axis]) {
                    sets.push(number);
                    polygons.push(polygon.into_iter().map(|corner| placing.back(corner)).collect());
                }
            }
        }
        if polygons.is_empty() {
            return Ok(BodyJoints { first: 0, sets, inside: Vec::new() });
        }
        let inside = polygons.iter().map(|polygon| is_inside(surface, middle(polygon))).collect();
        let first =
            add_polygons(surface, &polygons, size).map_err(|error| self.refused(body, &sets, &error))?;
        Ok(BodyJoints { first, sets, inside })
    }

    /// An error of the mesher as a problem of a body.
    fn refused(&self, body: &Body, sets: &[u32], error: &PolygonError) -> Problem {
        let name = |joint: usize| {
            let set = sets.get(joint).and_then(|&set| self.polygons.get(set as usize));
            set.map_or("", |(set, _)| set.name.as_str())
        };
        let both = |[a, b]: [usize; 2]| {
            if a == b {
                format!("a joint of \"{}\" and the surface of the body", name(a))
            } else {
                format!("joints of \"{}\" and \"{}\"", name(a), name(b))
            }
        };
        let (message, help) = match error {
            PolygonError::Close { polygons, place } => (
                format!("{} are too close to each other for the mesh size near {place:?}", both(*polygons)),
                "take a smaller mesh_size, or move one of them",
            ),
            PolygonError::Sharp { polygons, angle, place } => (
                format!(
                    "{} meet at {angle:.1} degrees near {place:?}, too small an angle for elements",
                    both(*polygons)
                ),
                "turn or move one of them",
            ),
            PolygonError::NotFlat { polygon, distance } => (
                format!(
                    "a joint of \"{}\" is not flat: a corner is {distance:.2e} m beside the plane of the others",
                    name(*polygon)
                ),
                "give its triangles one by one",
            ),
            PolygonError::NoArea { polygon } | PolygonError::Crossed { polygon } => (
                format!("a joint of \"{}\" has no area, or crosses itself", name(*polygon)),
                "give its corners in order",
            ),
            _ => return Problem::new("mesh_size", format!("[[body]] \"{}\": {error}", body.name)),
        };
        let message = format!("[[body]] \"{}\": {message}", body.name);
        Problem { help: Some(help.to_owned()), ..Problem::new("mesh_size", message) }
    }
}

/// Rotation and translation of a body after it is meshed.
struct SpacePlacing {
    middle: Point,
    turn: [Point; 3],
    by: Point,
    /// Lower and upper corner of the bounding box of the body in the model, m.
    bounds: [Point; 2],
}

impl SpacePlacing {
    fn of(body: &Body, turn: [Point; 3], surface: &Surface) -> Self {
        let [low, high] = fdem_mesh::bounds(surface.nodes.iter().copied());
        let middle = [0, 1, 2].map(|axis| f64::midpoint(low[axis], high[axis]));
        let by = body.translate.as_ref().map_or([0.0; 3], Vector::components);
        let mut placing = Self { middle, turn, by, bounds: [low, high] };
        placing.bounds = fdem_mesh::bounds(surface.nodes.iter().map(|&node| placing.forth(node)));
        placing
    }

    fn is_turned(&self) -> bool {
        self.turn[0][0] != 1.0 || self.turn[1][1] != 1.0
    }

    /// From the mesh to the model.
    fn forth(&self, point: Point) -> Point {
        if !self.is_turned() {
            return [0, 1, 2].map(|axis| point[axis] + self.by[axis]);
        }
        let off = [0, 1, 2].map(|axis| point[axis] - self.middle[axis]);
        [0, 1, 2].map(|axis| self.middle[axis] + dot(self.turn[axis], off) + self.by[axis])
    }

    /// From the model to the mesh.
    fn back(&self, point: Point) -> Point {
        // Points of bodies that are neither turned nor moved stay unchanged.
        if !self.is_turned() {
            return [0, 1, 2].map(|axis| point[axis] - self.by[axis]);
        }
        let off = [0, 1, 2].map(|axis| point[axis] - self.by[axis] - self.middle[axis]);
        [0, 1, 2].map(|axis| self.middle[axis] + (0..3).map(|k| self.turn[k][axis] * off[k]).sum::<f64>())
    }
}

/// The mean of the corners of a polygon.
fn middle(polygon: &[Point]) -> Point {
    [0, 1, 2].map(|axis| polygon.iter().map(|corner| corner[axis]).sum::<f64>() / polygon.len() as f64)
}

/// Whether a point is inside of a body: facets are seen from it under the angle of the whole sphere. A point
/// on the surface is not.
///
/// # Source
/// A. Van Oosterom, J. Strackee, The solid angle of a plane triangle, IEEE Trans. Biomed. Eng. 30 (1983)
/// 125-126.
fn is_inside(surface: &Surface, point: Point) -> bool {
    let angle = |facet: &[u32; 3]| {
        let [a, b, c] =
            facet.map(|node| [0, 1, 2].map(|axis| surface.nodes[node as usize][axis] - point[axis]));
        let [r, s, t] = [a, b, c].map(|corner| dot(corner, corner).sqrt());
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        // In the plane of a facet, the point may be on it.
        let volume = dot(a, cross);
        if volume.abs() <= 1e-9 * r * s * t {
            return 0.0;
        }
        2.0 * libm::atan2(volume, r * s * t + dot(a, b) * t + dot(b, c) * r + dot(c, a) * s)
    };
    let seen: f64 = surface.facets.iter().map(angle).sum();
    seen.abs() > 3.0 * std::f64::consts::PI
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The orientation of a joint: its upward normal, the direction of its strike, and the direction in which it
/// dips.
///
/// # Source
/// The convention of the ISRM suggested methods for the description of discontinuities (1978): the dip below
/// the horizontal, and its direction clockwise from north.
fn orientation(dip: f64, direction: f64) -> [Point; 3] {
    // Sine and cosine of right angles are 0 and 1.
    let exact = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
    let [dip, direction] = [dip, direction].map(|angle| {
        let (sine, cosine) = libm::sincos(angle.to_radians());
        [exact(sine), exact(cosine)]
    });
    [
        [direction[0] * dip[0], direction[1] * dip[0], dip[1]],
        [direction[1], -direction[0], 0.0],
        [direction[0] * dip[1], direction[1] * dip[1], -dip[0]],
    ]
}

/// The number of a pair of whole numbers, each with its own.
fn paired(one: i64, other: i64) -> u64 {
    let [a, b] = [one, other].map(|x| if x < 0 { 2 * x.unsigned_abs() - 1 } else { 2 * x as u64 });
    (a + b) * (a + b + 1) / 2 + b + 1
}

/// The polygons of a statistical set within a box, and some beyond it; `None` if they are too many.
///
/// Joints lie on parallel planes, which are numbered from the origin. Joints with an end are octagons in
/// squares of each plane, which are numbered from the origin too. Each joint number has separate random
/// numbers, so that the joints do not depend on the place of the box, and the joints of neighbouring bodies
/// continue each other.
fn statistical(set: &JointSet, dip: f64, spacing: f64, [low, high]: [Point; 2]) -> Option<Vec<SpacePolygon>> {
    let direction = set.dip_direction.unwrap_or(0.0);
    let origin: Point = set.origin.as_ref().map_or([0.0; 3], Vector::components);
    let persistence = set.persistence.unwrap_or(1.0);
    let [tilted, turned, shifted, longer] =
        [set.dip_deviation, set.dip_direction_deviation, set.spacing_deviation, set.trace_deviation]
            .map(Option::unwrap_or_default);
    let [normal, strike, down] = orientation(dip, direction);
    let corners = (0..8).map(|k| {
        let corner =
            [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] } - origin[axis]);
        [dot(corner, strike), dot(corner, down), dot(corner, normal)]
    });
    let [least, most] = fdem_mesh::bounds(corners);
    let width = set.trace_length.filter(|_| persistence < 1.0);
    // A joint reaches this far from where it is turned, and so far across.
    let far = |axis: usize| least[axis].abs().max(most[axis].abs());
    let reach = width.map_or(far(0).hypot(far(1)), |width| 0.6 * (width + longer));
    let angle = (tilted + turned * libm::sin(dip.to_radians())).min(85.0);
    let across = shifted + reach * libm::tan(angle.to_radians());
    let rows = [((least[2] - across) / spacing).floor(), ((most[2] + across) / spacing).ceil()];
    // The mean square of the widths counts for the area.
    let cell = width.map(|width| ((width * width + longer * longer / 3.0) * OCTAGON / persistence).sqrt());
    let steps = cell.map_or([[0.0; 2]; 2], |cell| {
        [0, 1]
            .map(|axis| [((least[axis] - reach) / cell).floor() - 1.0, ((most[axis] + reach) / cell).ceil()])
    });
    let places: f64 = steps.iter().map(|[first, last]| last - first + 1.0).product();
    let all = (rows[1] - rows[0] + 1.0) * places;
    // An origin or a length beyond the range of numbers gives a number that is none.
    if all.is_nan() || all > MOST {
        return None;
    }
    let half = 1.5 * (0..3).map(|axis| (high[axis] - low[axis]).powi(2)).sum::<f64>().sqrt();
    let middle = [0, 1].map(|axis| f64::midpoint(least[axis], most[axis]));
    let mut polygons = Vec::new();
    for row in rows[0] as i64..=rows[1] as i64 {
        let own = set.seed.unwrap_or(1).wrapping_add((row as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut random = Random::with_stream(own, 0);
        let phase = [random.uniform(), random.uniform()];
        let oriented = |random: &mut Random| {
            let height = row as f64 * spacing + shifted * random.between(-1.0, 1.0);
            let dip = dip + tilted * random.between(-1.0, 1.0);
            (height, orientation(dip, direction + turned * random.between(-1.0, 1.0)))
        };
        let at = |along: [f64; 2], height: f64| {
            [0, 1, 2].map(|k| origin[k] + strike[k] * along[0] + down[k] * along[1] + normal[k] * height)
        };
        let (Some(width), Some(cell)) = (width, cell) else {
            // A square around the foot of the middle of the box.
            let (height, [n, u, v]) = oriented(&mut random);
            let through = at([0.0; 2], height);
            let centre = at(middle, 0.5 * (least[2] + most[2]));
            let off = dot(n, [0, 1, 2].map(|k| centre[k] - through[k]));
            let foot = [0, 1, 2].map(|k| centre[k] - off * n[k]);
            let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            polygons.push(square.map(|[a, b]| corner(foot, [u, v], [a * half, b * half])).to_vec());
            continue;
        };
        for i in steps[0][0] as i64..=steps[0][1] as i64 {
            for j in steps[1][0] as i64..=steps[1][1] as i64 {
                let mut random = Random::with_stream(own, paired(i, j));
                let wide = width + longer * random.between(-1.0, 1.0);
                // Within its square, so that no two of a plane overlap.
                let room = (cell - wide).max(0.0);
                let along = [i, j]
                    .map(|number| (number as f64 + 0.5) * cell + 0.5 * room * random.between(-1.0, 1.0));
                let along = [0, 1].map(|axis| along[axis] + phase[axis] * cell);
                let (height, [_, u, v]) = oriented(&mut random);
                let (a, b) = (0.5 * wide, 0.5 * wide * (std::f64::consts::SQRT_2 - 1.0));
                let octagon = [[a, -b], [a, b], [b, a], [-b, a], [-a, b], [-a, -b], [-b, -a], [b, -a]];
                polygons.push(octagon.map(|place| corner(at(along, height), [u, v], place)).to_vec());
            }
        }
    }
    Some(polygons)
}

/// A point of a plane.
fn corner(centre: Point, [u, v]: [Point; 2], [a, b]: [f64; 2]) -> Point {
    [0, 1, 2].map(|k| centre[k] + a * u[k] + b * v[k])
}
