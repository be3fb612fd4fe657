//! Triangles and tetrahedra: this module and its parts hold all that differs between the two. The rest of the
//! crate is written once for both.
//!
//! A simplex of `D` dimensions has `N = D + 1` corners and `N` facets: the edges of a triangle, the faces of
//! a tetrahedron. A facet has `D` corners, and `D` facets meet in each corner.

pub(crate) mod interactions;
mod tetrahedron;
pub(crate) mod triangle;

use crate::lanes::{Available, LANES, Lanes, Rows, compiled_for_vectors, either, larger, smaller};
use crate::moduli::{Moduli, Plane};
use crate::vector::{Matrix, Point, dot};

/// A facet passes near the centroid if the smallest distance from it, over that of the boundary in the same
/// direction, is below this: see `interactions.rs`.
const NEAR: f64 = 1e-5;

/// The corners of an element: `[[f64; 2]; 3]` counter-clockwise, or `[[f64; 3]; 4]`, the first three
/// counter-clockwise seen from the last.
pub(crate) trait Simplex<const D: usize, const N: usize>: Copy + Send + Sync {
    /// Whether the element is a triangle.
    const IS_TRIANGLE: bool = D == 2;

    /// Memory for [`Simplex::interactions`].
    type Scratch: Default;

    /// Corners of each facet, in the order in which they go around it counter-clockwise, seen from outside.
    const FACETS: [[usize; D]; N];
    /// Facets that meet in each corner.
    const AT_CORNER: [[usize; D]; N];
    /// The measure of strain up to which [`Simplex::stress_of_small`] is the stress.
    const SMALL: f64;
    /// The name of facets in messages.
    const FACETS_ARE: &'static str;

    fn determinant(f: &Matrix<D>) -> f64;

    /// The matrix of cofactors: the determinant times the transposed inverse.
    fn cofactor(f: &Matrix<D>) -> Matrix<D>;

    /// Area or volume.
    fn measure(&self) -> f64;

    /// Height over a facet, m.
    fn height(&self, facet: usize) -> f64;

    /// Barycentric coordinates of a point: 1 at a corner and 0 on the facet opposite.
    fn coordinates(&self, point: Point<D>) -> [f64; N];

    /// Length of an edge, area of a face.
    fn facet_measure(facet: &[Point<D>; D]) -> f64;

    /// Outward normal of a facet, as long as its measure.
    fn facet_normal(facet: &[Point<D>; D]) -> Point<D>;

    /// Length of an edge of this length; length of the edges of an even face of this area.
    fn facet_length(measure: f64) -> f64;

    /// The outward normal of a facet, and directions along it, at right angles; not of unit length.
    fn axes(facet: &[Point<D>; D]) -> Matrix<D>;

    /// [`Simplex::axes`], of unit length.
    fn unit_axes(facet: &[Point<D>; D]) -> Matrix<D>;

    /// Unit vectors at right angles, of which this is the first.
    fn axes_around(normal: Point<D>) -> Matrix<D>;

    /// Length of an element of this measure, m, by which a penalty in Pa becomes a stiffness in N/m. It is 1
    /// in two dimensions, where the thickness does this.
    fn contact_length(measure: f64) -> f64;

    /// Points on the common part of two facets that face each other and are nearer than `touch`, m: the
    /// weights of the vertices of both at each point, and the length, m, or area, m², that it represents.
    /// They integrate products of linear functions exactly. None if the common part is not wider than
    /// `least`, m.
    fn common(
        one: &[Point<D>; D],
        other: &[Point<D>; D],
        touch: f64,
        least: f64,
    ) -> Vec<([[f64; D]; 2], f64)>;

    /// Forces on the vertices of a facet, N, because its axes turn with it: of a pressure along the gap, and
    /// of a traction against it, Pa, on an area, m². `gap`: components along the axes.
    fn turning(
        facet: &[Point<D>; D],
        axes: &Matrix<D>,
        gap: &[f64; D],
        pressure: f64,
        traction: &[f64; D],
        area: f64,
    ) -> [Point<D>; D];

    /// Traction across a facet, tension positive, and along it, in the directions of [`Simplex::axes`], Pa.
    fn traction_on(facet: &[Point<D>; D], stress: &Matrix<D>) -> [f64; D];

    /// Tractions on planes near a facet, Pa, each with the cosine of the angle to the facet: on the plane
    /// across the largest tension and on the two on which Mohr and Coulomb's strength with a tangent of the
    /// friction angle of `friction` is used most, or as near to them as planes within `reach`, in radians,
    /// are.
    fn tractions_near(
        facet: &[Point<D>; D],
        stress: &Matrix<D>,
        friction: f64,
        reach: f64,
    ) -> [([f64; D], f64); 3];

    /// The largest principal stress, Pa, and the unit normal of the plane across it: by components across the
    /// facet, positive, and along it. `None` for edges of triangles, which are seldom more than 30° from that
    /// plane, so that their joints need no other normal.
    fn tension_across(facet: &[Point<D>; D], stress: &Matrix<D>) -> Option<(f64, [f64; D])>;

    /// The unit normal of a cut through several facets, and directions along it. `facet`: one of them; `sum`:
    /// the sum of their normals, each times its area. In two dimensions the axes of the facet.
    fn cut_axes(facet: &[Point<D>; D], sum: Point<D>) -> Matrix<D>;

    /// Share of its area with which a facet with this unit normal holds a cut: its projection on the plane of
    /// the cut, and nothing if it faces backwards. In two dimensions 1.
    fn projection(facet: Point<D>, cut: Point<D>) -> f64;

    /// A stress as the components `[xx, yy, zz, xy, yz, xz]`, Pa. `out_of_plane`: zz in two dimensions.
    fn in_tensor(stress: &Matrix<D>, out_of_plane: f64) -> [f64; 6];

    /// The stress with these components; in two dimensions that in the plane.
    fn of_tensor(components: &[f64; 6]) -> Matrix<D>;

    /// The sliding of a gap, m, whose components are across a facet, then along it: with its sign in two
    /// dimensions, its magnitude in three.
    fn sliding(gap: &[f64; D]) -> f64;

    /// Middle and radius of Mohr's largest circle, Pa.
    fn circle(stress: &Matrix<D>) -> [f64; 2];

    /// Upper bounds of both that are faster to compute, larger by at most 2e-6 of the radius and 2e-9 of the
    /// mean stress.
    fn circle_close(stress: &Matrix<D>) -> [f64; 2];

    /// Whether the stress out of the plane vanishes, which it never does in space.
    fn is_plate(plane: Plane) -> bool;

    /// Moduli of an isotropic material with this Young's modulus, Pa, and Poisson's ratio; `plane` counts in
    /// two dimensions.
    fn moduli(youngs_modulus: f64, poissons_ratio: f64, plane: Plane) -> Moduli;

    /// First Piola-Kirchhoff stress, Pa, and energy per undeformed volume, J/m³, of a deformation gradient.
    /// `j` is its determinant; it must be positive. The moduli are those of shear and bulk, Pa.
    fn stress(moduli: [f64; 2], f: &Matrix<D>, j: f64) -> (Matrix<D>, f64);

    /// [`Simplex::stress`] without a branch, and a measure of the strain. Where the measure is below
    /// [`Simplex::SMALL`], the stress is the same to the last bit.
    fn stress_of_small(moduli: [f64; 2], f: &Matrix<D>, j: f64) -> (Matrix<D>, f64, f64);

    /// Energy density, J/m³, that a stress has stored by Hooke's law: `σ:C⁻¹:σ / 2`.
    fn stored(moduli: &Moduli, stress: &Matrix<D>) -> f64;

    /// Square of the highest angular frequency of the free element, 1/s²: the largest ratio of its stiffness
    /// to its lumped mass.
    fn highest_square(&self, moduli: &Moduli, density: f64) -> f64;

    /// The square of the distance, m², by which a facet of the other element parts it from this one: that of
    /// the facet that parts the two most. Negative if none does.
    fn parted(&self, other: &Self) -> f64;

    /// [`interactions`](interactions::interactions) without the energies of potentials where a facet passes
    /// near the centroid, and without the forces that follow from them.
    fn usual_interactions(
        available: Available,
        shapes: &[Shapes<D, N>],
        scratch: &mut Self::Scratch,
        found: &mut [Interactions<D, N>],
    );

    /// The distance of two elements that do not overlap, m, or a lower bound of it. `known`: the lower bound
    /// of [`apart`].
    fn distance(&self, other: &Self, known: f64) -> f64;

    /// The matrix whose columns are the edges from corner 0.
    #[inline]
    fn edges(corners: &[Point<D>; N]) -> Matrix<D> {
        crate::vector::matrix(|axis, k| corners[k + 1][axis] - corners[0][axis])
    }

    /// The inverse of that matrix, 1/m.
    fn inverse_edges(corners: &[Point<D>; N]) -> Matrix<D> {
        let edges = Self::edges(corners);
        let (determinant, cofactor) = (Self::determinant(&edges), Self::cofactor(&edges));
        crate::vector::matrix(|i, k| cofactor[k][i] / determinant)
    }

    /// The least height, m.
    fn least_height(&self) -> f64 {
        (0..N).map(|facet| self.height(facet)).fold(f64::INFINITY, f64::min)
    }
}

/// Corners of a triangle, counter-clockwise.
pub(crate) type Triangle = [Point; 3];

/// Corners of a tetrahedron: the first three are counter-clockwise, seen from the last.
pub(crate) type Tetrahedron = [Point<3>; 4];

/// The corners of a batch of couples of elements, m.
pub(crate) type Shapes<const D: usize, const N: usize> = [Rows<D, N>; 2];

/// Forces and energy of a batch of couples of elements.
#[derive(Clone, Debug)]
pub(crate) struct Interactions<const D: usize, const N: usize> {
    /// Forces on the corners of the first and of the second element.
    pub(crate) forces: [Rows<D, N>; 2],
    /// The integral over the overlap of the potential of the first and of the second element; 0 or, by
    /// rounding, less if the elements do not overlap.
    energies: [Lanes; 2],
    /// The facets of the other element, as the sum of their bits, that pass near the centroid of the first
    /// and of the second one.
    passing: [Lanes; 2],
    /// The point where the force acts: the mean of the boundary in contact, weighted by its pressure.
    pub(crate) point: [Lanes; D],
    /// 1 where one element reaches the centroid of the other, else 0: the potential does not grow with
    /// further penetration.
    pub(crate) deep: Lanes,
}

impl<const D: usize, const N: usize> Interactions<D, N> {
    pub(crate) const NONE: Self = Self {
        forces: [[[Lanes::ZERO; D]; N]; 2],
        energies: [Lanes::ZERO; 2],
        passing: [Lanes::ZERO; 2],
        point: [Lanes::ZERO; D],
        deep: Lanes::ZERO,
    };

    /// The integral of both potentials over the overlap; 0 or, by rounding, less if the elements do not
    /// overlap.
    #[inline(always)]
    pub(crate) fn energy(&self, lane: usize) -> f64 {
        self.energies[0].get(lane) + self.energies[1].get(lane)
    }

    /// Sets the energy of the potential of one element of a couple, and adds the forces on its corners
    /// because the potential moves with them. `gradients`: those of its barycentric coordinates.
    #[inline(always)]
    fn set_energy(&mut self, lane: usize, side: usize, gradients: &[Point<D>; N], energy: f64) {
        for corner in 0..N {
            for axis in 0..D {
                let force = &mut self.forces[side][corner][axis];
                force.set(lane, force.get(lane) - gradients[corner][axis] * energy);
            }
        }
        self.energies[side].set(lane, energy);
    }
}

compiled_for_vectors!(fn points = all_points<const D: usize>(
    weight: &Lanes,
    moment: &[Lanes; D],
    any: &[Lanes; D],
    point: &mut [Lanes; D]
));

/// The points where the forces of a batch act: pressure times position, over pressure. Without pressure there
/// is no friction, so `any` point will do.
#[inline(always)]
fn all_points<const D: usize>(weight: &Lanes, moment: &[Lanes; D], any: &[Lanes; D], point: &mut [Lanes; D]) {
    for lane in 0..LANES {
        let weight = weight.get(lane);
        let presses = if weight > 0.0 { !0 } else { 0 };
        for axis in 0..D {
            let mean = moment[axis].get(lane) / weight;
            point[axis].set(lane, either(presses, mean, any[axis].get(lane)));
        }
    }
}

/// A lower bound of the distance of two elements, m: the gap of their boxes, or the distance by which a facet
/// parts them. Negative if none does; then they overlap, or an edge of each is nearest to the other. Twin:
/// `crates/gpu/kernels/contact.h`.
#[inline(always)]
pub(crate) fn apart<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    larger(gap(a, b), larger(parted(a, b), parted(b, a)))
}

/// The distance, m, by which a facet of the second element parts it from the first; negative if none does.
#[inline(always)]
pub(crate) fn parted<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let squared = a.parted(b);
    if squared < 0.0 { -1.0 } else { squared.sqrt() }
}

/// Gap, m, between the boxes of two elements along the axis on which they are farthest apart; negative if the
/// boxes overlap.
#[inline(always)]
pub(crate) fn gap<const D: usize, const N: usize>(a: &[Point<D>; N], b: &[Point<D>; N]) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for axis in 0..D {
        let (mut low, mut high) = ([a[0][axis], b[0][axis]], [a[0][axis], b[0][axis]]);
        for corner in 1..N {
            let at = [a[corner][axis], b[corner][axis]];
            low = std::array::from_fn(|side| smaller(low[side], at[side]));
            high = std::array::from_fn(|side| larger(high[side], at[side]));
        }
        most = larger(most, larger(low[0] - high[1], low[1] - high[0]));
    }
    most
}

/// [`Simplex::parted`], from the gradients of the barycentric coordinates of one element, and those of the
/// corners of the other in it.
#[inline(always)]
fn furthest<const D: usize, const N: usize>(gradients: &[Point<D>; N], at: &[[f64; N]; N]) -> f64 {
    let mut furthest = -1.0;
    for k in 0..N {
        let mut most = at[0][k];
        for corner in 1..N {
            most = larger(most, at[corner][k]);
        }
        // The length of the gradient is one over the height.
        let squared = most * most / dot(gradients[k], gradients[k]);
        furthest = larger(furthest, if most <= 0.0 { squared } else { -1.0 });
    }
    furthest
}
