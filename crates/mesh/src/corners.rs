//! Triangles and tetrahedra by their corners.

use std::any::Any;

/// The corners of a triangle, `[[f64; 2]; 3]`, or of a tetrahedron, `[[f64; 3]; 4]`, in the order of
/// [`Mesh::elements`](crate::Mesh).
pub trait Corners<const D: usize, const N: usize> {
    /// Corners of each facet: an edge in the direction in which the triangle has it, a face counter-clockwise
    /// seen from outside.
    const FACETS: [[usize; D]; N];

    /// Area or volume; negative if the corners have the other order.
    fn measure(&self) -> f64;

    /// Length of an edge, area of a face.
    fn facet_measure(facet: &[[f64; D]; D]) -> f64;

    /// Angles in degrees: those of a triangle; those between the faces of a tetrahedron, at its edges.
    fn angles(&self) -> Vec<f64>;

    /// The least height over a facet.
    fn least_height(&self) -> f64
    where
        Self: AsRef<[[f64; D]]>,
    {
        let corners = self.as_ref();
        let facets = Self::FACETS.map(|facet| Self::facet_measure(&facet.map(|corner| corners[corner])));
        D as f64 * self.measure() / facets.into_iter().fold(0.0, f64::max)
    }
}

impl Corners<2, 3> for [[f64; 2]; 3] {
    const FACETS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

    fn measure(&self) -> f64 {
        let [a, b, c] = *self;
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    }

    fn facet_measure([a, b]: &[[f64; 2]; 2]) -> f64 {
        (b[0] - a[0]).hypot(b[1] - a[1])
    }

    fn angles(&self) -> Vec<f64> {
        let [ab, bc, ca] = Self::FACETS.map(|facet| Self::facet_measure(&facet.map(|corner| self[corner])));
        let angle = |a: f64, b: f64, c: f64| {
            ((b * b + c * c - a * a) / (2.0 * b * c)).clamp(-1.0, 1.0).acos().to_degrees()
        };
        vec![angle(bc, ca, ab), angle(ca, ab, bc), angle(ab, bc, ca)]
    }
}

impl Corners<3, 4> for [[f64; 3]; 4] {
    const FACETS: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    fn measure(&self) -> f64 {
        let [a, b, c, d] = *self;
        dot(minus(b, a), cross(minus(c, a), minus(d, a))) / 6.0
    }

    fn facet_measure(facet: &[[f64; 3]; 3]) -> f64 {
        let normal = normal(facet);
        0.5 * dot(normal, normal).sqrt()
    }

    fn angles(&self) -> Vec<f64> {
        let normals = Self::FACETS.map(|facet| normal(&facet.map(|corner| self[corner])));
        let mut angles = Vec::with_capacity(6);
        for (k, one) in normals.iter().enumerate() {
            for other in &normals[k + 1..] {
                let cosine = dot(*one, *other) / (dot(*one, *one) * dot(*other, *other)).sqrt();
                angles.push(180.0 - cosine.clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
        angles
    }
}

/// The facets of an element by their nodes.
pub fn facets_of<const D: usize, const N: usize>(element: &[u32; N]) -> [[u32; D]; N]
where
    [[f64; D]; N]: Corners<D, N>,
{
    <[[f64; D]; N]>::FACETS.map(|facet| facet.map(|corner| element[corner]))
}

/// The nodes of a facet, ascending.
pub fn sorted<const D: usize>(mut facet: [u32; D]) -> [u32; D] {
    facet.sort_unstable();
    facet
}

/// The facets of all elements by their nodes, ascending, each with the number of its element. The list is in
/// ascending order, so that the facets of neighbours follow each other.
pub fn sorted_facets<const D: usize, const N: usize>(elements: &[[u32; N]]) -> Vec<([u32; D], u32)>
where
    [[f64; D]; N]: Corners<D, N>,
{
    // Compiled in this crate, which is optimised, and not in those that call it.
    fn plane(elements: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
        all_sorted(elements)
    }

    fn space(elements: &[[u32; 4]]) -> Vec<([u32; 3], u32)> {
        all_sorted(elements)
    }

    fn same<const D: usize, const E: usize>(facets: Vec<([u32; E], u32)>) -> Vec<([u32; D], u32)> {
        let mut facets = Some(facets);
        let same = (&mut facets as &mut dyn Any).downcast_mut::<Option<Vec<([u32; D], u32)>>>();
        same.and_then(Option::take).expect("the dimensions are equal")
    }

    if const { D == 2 } {
        same(plane(elements.as_flattened().as_chunks().0))
    } else {
        same(space(elements.as_flattened().as_chunks().0))
    }
}

/// [`sorted_facets`], compiled where it is called.
fn all_sorted<const D: usize, const N: usize>(elements: &[[u32; N]]) -> Vec<([u32; D], u32)>
where
    [[f64; D]; N]: Corners<D, N>,
{
    let mut facets = Vec::with_capacity(N * elements.len());
    for (number, element) in (0..).zip(elements) {
        facets.extend(facets_of(element).map(|facet| (sorted(facet), number)));
    }
    facets.sort_unstable();
    facets
}

/// Normal of a face, twice as long as its area.
fn normal([a, b, c]: &[[f64; 3]; 3]) -> [f64; 3] {
    cross(minus(*b, *a), minus(*c, *a))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_tetrahedron_has_known_measures() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!((corners.measure() - 1.0 / 6.0).abs() < 1e-15);
        assert!((corners.least_height() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-15);
        let mut angles = corners.angles();
        angles.sort_by(f64::total_cmp);
        let slant = (1.0 / 3.0_f64.sqrt()).acos().to_degrees();
        for (found, expected) in angles.iter().zip([slant, slant, slant, 90.0, 90.0, 90.0]) {
            assert!((found - expected).abs() < 1e-12, "{angles:?}");
        }
    }

    #[test]
    fn a_right_triangle_has_known_measures() {
        let corners = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]];
        assert_eq!(corners.measure(), 6.0);
        assert!((corners.least_height() - 2.4).abs() < 1e-15);
        assert!((corners.angles()[0] - 90.0).abs() < 1e-12);
    }

    /// Every facet of a simplex looks away from the corner opposite.
    #[test]
    fn facets_look_outwards() {
        let corners = [[0.1, 0.2, -0.3], [1.0, 0.0, 0.3], [0.0, 1.2, 0.1], [0.2, 0.1, 0.9]];
        assert!(corners.measure() > 0.0);
        for facet in <[[f64; 3]; 4] as Corners<3, 4>>::FACETS {
            let opposite =
                (0..4).find(|corner| !facet.contains(corner)).map(|corner| corners[corner]).unwrap();
            let facet = facet.map(|corner| corners[corner]);
            assert!(dot(normal(&facet), minus(opposite, facet[0])) < 0.0);
        }
    }
}
