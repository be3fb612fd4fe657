//! Spheres against spheres, planes and triangles.

use super::contact::{Contact, Measure};
use super::exact::{along, inner_side};
use super::shapes::{Plane, Sphere, Triangle};
use super::vector::{
    add, before, between, cross, distance_squared, dot, neg, perpendicular, scale, sub, unit, x_axis,
};

/// The part of a triangle where a contact is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Feature {
    /// The interior, off all edges.
    Face,
    /// The edge from this vertex (0 to 2) to the next, off its ends.
    Edge(u8),
    /// This vertex, 0 to 2.
    Vertex(u8),
}

/// Two spheres: gap or depth.
///
/// They touch if `d · d <= (r_1 + r_2)²`, with the operations of [`Elements`](crate::Elements), so that both
/// phases agree to the last bit. The point is the middle of the overlap or gap, on the line of the centres.
/// For centres that coincide the normal is x and the depth is `r_1 + r_2`. The errors of point and measure
/// are 8 rounding steps of the largest coordinate or radius.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, Sphere, sphere_sphere};
///
/// let contact = sphere_sphere(&Sphere::new([0.0, 0.0], 2.0)?, &Sphere::new([3.0, 0.0], 2.0)?);
/// assert_eq!(contact.measure, Measure::Depth(1.0));
/// assert_eq!(contact.point, [1.5, 0.0]);
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn sphere_sphere<const D: usize>(a: &Sphere<D>, b: &Sphere<D>) -> Contact<D> {
    let reach = a.radius + b.radius;
    let squared = distance_squared(a.centre, b.centre);
    let depth = reach - squared.sqrt();
    let normal = unit(sub(b.centre, a.centre)).unwrap_or_else(x_axis);
    Contact {
        point: add(a.centre, scale(normal, a.radius - 0.5 * depth)),
        normal,
        measure: depth_or_gap(squared <= reach * reach, depth),
    }
}

/// A sphere and a plane without thickness: gap or depth.
///
/// They touch if `|n · (c - p)| <= r`, evaluated in this order. The point is the projection of the centre
/// onto the plane; the normal leads from the centre to it. For a centre in the plane, the normal is opposite
/// to that of the plane. The errors are 8 rounding steps of the largest coordinate.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Measure, Plane, Sphere, sphere_plane};
///
/// let floor = Plane::new([0.0, 0.0, 0.0], [0.0, 0.0, 1.0])?;
/// let contact = sphere_plane(&Sphere::new([7.0, 5.0, 0.75], 1.0)?, &floor);
/// assert_eq!((contact.measure, contact.point), (Measure::Depth(0.25), [7.0, 5.0, 0.0]));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn sphere_plane<const D: usize>(sphere: &Sphere<D>, plane: &Plane<D>) -> Contact<D> {
    let height = dot(plane.normal, sub(sphere.centre, plane.point));
    let depth = sphere.radius - height.abs();
    Contact {
        point: sub(sphere.centre, scale(plane.normal, height)),
        normal: if height < 0.0 { plane.normal } else { neg(plane.normal) },
        measure: depth_or_gap(depth >= 0.0, depth),
    }
}

/// A sphere and a triangle without thickness: gap or depth, and the feature of the triangle.
///
/// They touch if `d² <= r · r`, where `d²` is the rounded squared distance between the centre and the closest
/// point of the triangle. Its error is 32 rounding steps of the square of the largest coordinate difference.
/// Exact signs decide whether the closest point is on the face, an edge or a vertex; a centre exactly above
/// an edge belongs to the edge. The contact point is that closest point, and the normal leads from the centre
/// to it. For a centre on the triangle, the normal is opposite to that of the triangle by the right-hand
/// rule, or perpendicular to a triangle without area. An edge gives the same bits in every triangle that has
/// it.
///
/// # Source
/// The regions are those of C. Ericson, "Real-Time Collision Detection" (2005), 5.1.5.
///
/// # Example
/// ```
/// use fdem_contact::narrow::{Feature, Measure, Sphere, Triangle, sphere_triangle};
///
/// let wall = Triangle::new([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]])?;
/// let (contact, feature) = sphere_triangle(&Sphere::new([2.0, -3.0, 4.0], 6.0)?, &wall);
/// assert_eq!((contact.measure, feature), (Measure::Depth(1.0), Feature::Edge(0)));
/// # Ok::<(), fdem_contact::narrow::ShapeError>(())
/// ```
pub fn sphere_triangle(sphere: &Sphere<3>, triangle: &Triangle<3>) -> (Contact<3>, Feature) {
    let foot = foot(sphere.centre, &triangle.vertices);
    let normal = foot
        .normal
        .or_else(|| unit(sub(foot.point, sphere.centre)))
        .unwrap_or_else(|| normal_on(&triangle.vertices));
    let depth = sphere.radius - foot.squared.sqrt();
    let touch = foot.squared <= sphere.radius * sphere.radius;
    (Contact { point: foot.point, normal, measure: depth_or_gap(touch, depth) }, foot.feature)
}

/// The measure of round bodies. Rounding may give the depth the wrong sign by one step; the decision `touch`
/// takes precedence.
pub(super) fn depth_or_gap(touch: bool, depth: f64) -> Measure {
    if touch { Measure::Depth(depth.max(0.0)) } else { Measure::Gap((-depth).max(0.0)) }
}

/// The closest point of a triangle to a given point.
pub(super) struct Foot {
    pub(super) point: [f64; 3],
    /// The square of the distance.
    pub(super) squared: f64,
    pub(super) feature: Feature,
    /// The direction from the point to the triangle, if the point is above the face.
    normal: Option<[f64; 3]>,
}

pub(super) fn foot(p: [f64; 3], vertices: &[[f64; 3]; 3]) -> Foot {
    let [a, b, c] = *vertices;
    if inner_side(a, b, c, p) > 0.0
        && inner_side(b, c, a, p) > 0.0
        && inner_side(c, a, b, p) > 0.0
        && let Some(normal) = unit(cross(sub(b, a), sub(c, a)))
    {
        let height = dot(normal, sub(p, a));
        return Foot {
            point: sub(p, scale(normal, height)),
            squared: height * height,
            feature: Feature::Face,
            normal: Some(if height < 0.0 { normal } else { neg(normal) }),
        };
    }
    let mut closest = foot_on_edge(p, vertices, 0);
    for edge in 1..3 {
        let other = foot_on_edge(p, vertices, edge);
        if other.squared < closest.squared {
            closest = other;
        }
    }
    closest
}

fn foot_on_edge(p: [f64; 3], vertices: &[[f64; 3]; 3], edge: u8) -> Foot {
    let next = (edge + 1) % 3;
    let (a, b) = (vertices[usize::from(edge)], vertices[usize::from(next)]);
    let (point, feature) = if along(a, b, p) <= 0.0 {
        (a, Feature::Vertex(edge))
    } else if along(b, a, p) <= 0.0 {
        (b, Feature::Vertex(next))
    } else {
        // Computed from the same end in every triangle that has this edge.
        let (low, high) = if before(a, b) { (a, b) } else { (b, a) };
        let u = sub(high, low);
        let t = (dot(u, sub(p, low)) / dot(u, u)).clamp(0.0, 1.0);
        (between(low, high, t), Feature::Edge(edge))
    };
    Foot { point, squared: distance_squared(p, point), feature, normal: None }
}

/// The normal if the centre is on the triangle.
fn normal_on(&[a, b, c]: &[[f64; 3]; 3]) -> [f64; 3] {
    let edges = [sub(b, a), sub(c, b), sub(a, c)];
    let mut longest = edges[0];
    for edge in edges {
        if dot(edge, edge) > dot(longest, longest) {
            longest = edge;
        }
    }
    unit(cross(edges[0], sub(c, a))).map_or_else(|| perpendicular(longest), neg)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(centre: [f64; 3], radius: f64) -> Sphere<3> {
        Sphere::new(centre, radius).unwrap()
    }

    #[test]
    fn coincident_centres_and_points_have_an_answer() {
        let contact = sphere_sphere(&ball([1.0; 3], 0.5), &ball([1.0; 3], 0.25));
        assert_eq!(
            contact,
            Contact { point: [1.125, 1.0, 1.0], normal: [1.0, 0.0, 0.0], measure: Measure::Depth(0.75) }
        );
        assert!(sphere_sphere(&ball([1.0; 3], 0.0), &ball([1.0; 3], 0.0)).touches());
    }

    #[test]
    fn touching_spheres_count_and_one_step_apart_do_not() {
        assert_eq!(
            sphere_sphere(&ball([0.0; 3], 1.0), &ball([3.0, 4.0, 0.0], 4.0)).measure,
            Measure::Depth(0.0)
        );
        let apart = sphere_sphere(&ball([0.0; 3], 1.0), &ball([5.0_f64.next_up(), 0.0, 0.0], 4.0));
        assert!(!apart.touches());
    }

    #[test]
    fn a_plane_is_the_same_from_both_sides() {
        let plane = Plane::new([0.0, 0.0, 1.0], [0.0, 0.0, 3.0]).unwrap();
        for (z, normal) in [(1.5, -1.0), (0.5, 1.0), (1.0, -1.0)] {
            let contact = sphere_plane(&ball([0.0, 0.0, z], 0.5), &plane);
            assert!(contact.touches());
            assert_eq!((contact.normal, contact.point), ([0.0, 0.0, normal], [0.0, 0.0, 1.0]));
        }
        assert_eq!(sphere_plane(&ball([0.0, 0.0, 3.0], 0.5), &plane).measure, Measure::Gap(1.5));
    }

    #[test]
    fn regions_of_a_triangle() {
        let triangle = Triangle::new([[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]).unwrap();
        for (x, y, feature) in [
            (1.0, 1.0, Feature::Face),
            (2.0, 0.0, Feature::Edge(0)),
            (2.0, -1.0, Feature::Edge(0)),
            (3.0, 3.0, Feature::Edge(1)),
            (-1.0, 1.0, Feature::Edge(2)),
            (-1.0, -1.0, Feature::Vertex(0)),
            (0.0, 0.0, Feature::Vertex(0)),
            (9.0, 1.0, Feature::Vertex(1)),
            (0.0, 7.0, Feature::Vertex(2)),
        ] {
            assert_eq!(sphere_triangle(&ball([x, y, 1.0], 1.0), &triangle).1, feature, "above {x} {y}");
        }
    }

    #[test]
    fn a_centre_on_a_triangle_has_a_normal() {
        let flat = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let line = [[0.0; 3], [4.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let point = [[1.0; 3]; 3];
        for (vertices, centre) in [(flat, [1.0, 1.0, 0.0]), (flat, [2.0, 0.0, 0.0]), (flat, [0.0; 3])] {
            let (contact, _) = sphere_triangle(&ball(centre, 1.0), &Triangle::new(vertices).unwrap());
            assert_eq!((contact.normal, contact.measure), ([0.0, 0.0, -1.0], Measure::Depth(1.0)));
        }
        for (vertices, centre) in [(line, [1.0, 0.0, 0.0]), (point, [1.0; 3])] {
            let (contact, _) = sphere_triangle(&ball(centre, 1.0), &Triangle::new(vertices).unwrap());
            assert_eq!(contact.measure, Measure::Depth(1.0));
            assert_eq!(dot(contact.normal, contact.normal), 1.0);
            assert_eq!(dot(contact.normal, sub(vertices[1], vertices[0])), 0.0);
        }
    }
}
