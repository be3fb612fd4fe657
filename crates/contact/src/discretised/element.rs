//! The elements of meshes, given by their vertices.

use crate::narrow::{
    Contact, Tetrahedron, Triangle, tetrahedron_tetrahedron, triangle_triangle, triangle_triangle_2d,
};

/// The vertices of an element: three in 2D for a triangle, three in 3D for a triangle of a surface, four in
/// 3D for a tetrahedron.
///
/// An element without area or volume is the piece that its vertices span; a tetrahedron that names its last
/// node twice is a triangle.
pub trait MeshElement<const D: usize>: sealed::Sealed<D> {}

impl MeshElement<2> for [[f64; 2]; 3] {}
impl MeshElement<3> for [[f64; 3]; 3] {}
impl MeshElement<3> for [[f64; 3]; 4] {}

pub(super) mod sealed {
    use super::Contact;

    /// The mesh has checked the coordinates as the constructors of shapes do.
    pub trait Sealed<const D: usize>: Copy + Send + Sync {
        /// For each facet along which elements of one mesh are neighbours, the local numbers of its nodes,
        /// then of the opposite node. A surface has none.
        const FACETS: &'static [([usize; D], usize)];

        fn touch(&self, other: &Self) -> bool;

        /// The contact of two elements; `scratch` is working memory.
        fn contact(&self, other: &Self, scratch: &mut Vec<[f64; 2]>) -> Contact<D>;

        fn vertex(&self, k: usize) -> [f64; D];

        /// A vector perpendicular to a facet, in either direction, whose length is the size of the facet.
        fn across(facet: &[[f64; D]; D]) -> [f64; D];
    }

    impl Sealed<2> for [[f64; 2]; 3] {
        const FACETS: &'static [([usize; 2], usize)] = &[([0, 1], 2), ([1, 2], 0), ([2, 0], 1)];

        fn touch(&self, other: &Self) -> bool {
            super::Triangle { vertices: *self }.touches(&super::Triangle { vertices: *other })
        }

        fn contact(&self, other: &Self, scratch: &mut Vec<[f64; 2]>) -> Contact<2> {
            let [a, b] = [self, other].map(|&vertices| super::Triangle { vertices });
            super::triangle_triangle_2d(&a, &b, scratch)
        }

        fn vertex(&self, k: usize) -> [f64; 2] {
            self[k]
        }

        fn across(&[a, b]: &[[f64; 2]; 2]) -> [f64; 2] {
            [b[1] - a[1], a[0] - b[0]]
        }
    }

    fn half_cross([a, b, c]: &[[f64; 3]; 3]) -> [f64; 3] {
        let u: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
        let v: [f64; 3] = std::array::from_fn(|k| c[k] - a[k]);
        [
            0.5 * (u[1] * v[2] - u[2] * v[1]),
            0.5 * (u[2] * v[0] - u[0] * v[2]),
            0.5 * (u[0] * v[1] - u[1] * v[0]),
        ]
    }

    impl Sealed<3> for [[f64; 3]; 3] {
        const FACETS: &'static [([usize; 3], usize)] = &[];

        fn touch(&self, other: &Self) -> bool {
            super::Triangle { vertices: *self }.touches(&super::Triangle { vertices: *other })
        }

        fn contact(&self, other: &Self, _: &mut Vec<[f64; 2]>) -> Contact<3> {
            let [a, b] = [self, other].map(|&vertices| super::Triangle { vertices });
            super::triangle_triangle(&a, &b)
        }

        fn vertex(&self, k: usize) -> [f64; 3] {
            self[k]
        }

        fn across(facet: &[[f64; 3]; 3]) -> [f64; 3] {
            half_cross(facet)
        }
    }

    impl Sealed<3> for [[f64; 3]; 4] {
        const FACETS: &'static [([usize; 3], usize)] =
            &[([1, 2, 3], 0), ([0, 2, 3], 1), ([0, 1, 3], 2), ([0, 1, 2], 3)];

        fn touch(&self, other: &Self) -> bool {
            super::Tetrahedron { vertices: *self }.touches(&super::Tetrahedron { vertices: *other })
        }

        fn contact(&self, other: &Self, _: &mut Vec<[f64; 2]>) -> Contact<3> {
            let [a, b] = [self, other].map(|&vertices| super::Tetrahedron { vertices });
            super::tetrahedron_tetrahedron(&a, &b)
        }

        fn vertex(&self, k: usize) -> [f64; 3] {
            self[k]
        }

        fn across(facet: &[[f64; 3]; 3]) -> [f64; 3] {
            half_cross(facet)
        }
    }
}
