//! Triangles.

mod elastic;
mod facet;
mod plane;
mod potential;

use crate::lanes::Available;
use crate::moduli::{Moduli, Plane};
use crate::simplex::{Interactions, Shapes, Simplex, Triangle};
use crate::vector::{Matrix, Point, cross, dot, length, minus, unit};

impl Simplex<2, 3> for Triangle {
    type Scratch = potential::TriangleScratch;

    const FACETS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];
    const AT_CORNER: [[usize; 2]; 3] = [[0, 2], [1, 0], [2, 1]];
    /// No strain needs a branch.
    const SMALL: f64 = f64::INFINITY;
    const FACETS_ARE: &'static str = "edges";

    #[inline]
    fn determinant([[a, b], [c, d]]: &Matrix) -> f64 {
        a * d - b * c
    }

    #[inline]
    fn cofactor(&[[a, b], [c, d]]: &Matrix) -> Matrix {
        [[d, -c], [-b, a]]
    }

    fn measure(&self) -> f64 {
        let [a, b, c] = *self;
        0.5 * cross(minus(b, a), minus(c, a))
    }

    fn height(&self, facet: usize) -> f64 {
        let [a, b, c] = [facet, (facet + 1) % 3, (facet + 2) % 3].map(|k| self[k]);
        let edge = minus(b, a);
        cross(edge, minus(c, a)) / length(edge)
    }

    #[inline(always)]
    fn coordinates(&self, point: Point) -> [f64; 3] {
        potential::AreaCoordinates::of(self).at(point)
    }

    fn facet_measure([a, b]: &[Point; 2]) -> f64 {
        length(minus(*b, *a))
    }

    #[inline(always)]
    fn facet_normal(facet: &[Point; 2]) -> Point {
        Self::axes(facet)[0]
    }

    fn facet_length(measure: f64) -> f64 {
        measure
    }

    #[inline(always)]
    fn axes([a, b]: &[Point; 2]) -> Matrix {
        let [x, y] = minus(*b, *a);
        [[y, -x], [x, y]]
    }

    #[inline(always)]
    fn unit_axes(facet: &[Point; 2]) -> Matrix {
        Self::axes(facet).map(|axis| {
            let long = 1.0 / dot(axis, axis).sqrt();
            axis.map(|x| x * long)
        })
    }

    #[inline(always)]
    fn axes_around(normal: Point) -> Matrix {
        [normal, [-normal[1], normal[0]]]
    }

    #[inline]
    fn contact_length(_: f64) -> f64 {
        1.0
    }

    fn common(one: &[Point; 2], other: &[Point; 2], touch: f64, least: f64) -> Vec<([[f64; 2]; 2], f64)> {
        facet::common(one, other, touch, least)
    }

    #[inline]
    fn turning(
        [a, b]: &[Point; 2],
        axes: &Matrix,
        gap: &[f64; 2],
        pressure: f64,
        traction: &[f64; 2],
        area: f64,
    ) -> [Point; 2] {
        let moment = (pressure * gap[1] + traction[1] * gap[0]) * area / length(minus(*b, *a));
        [axes[0].map(|n| moment * n), axes[0].map(|n| -moment * n)]
    }

    fn traction_on([a, b]: &[Point; 2], stress: &Matrix) -> [f64; 2] {
        plane::traction_along(minus(*b, *a), stress)
    }

    fn tractions_near(
        [a, b]: &[Point; 2],
        stress: &Matrix,
        friction: f64,
        reach: f64,
    ) -> [([f64; 2], f64); 3] {
        plane::tractions_near(minus(*b, *a), stress, friction, reach)
    }

    fn tension_across(_: &[Point; 2], _: &Matrix) -> Option<(f64, [f64; 2])> {
        None
    }

    fn cut_axes(facet: &[Point; 2], _: Point) -> Matrix {
        Self::axes(facet).map(unit)
    }

    fn projection(_: Point, _: Point) -> f64 {
        1.0
    }

    #[inline]
    fn in_tensor(&[[xx, xy], [_, yy]]: &Matrix, out_of_plane: f64) -> [f64; 6] {
        [xx, yy, out_of_plane, xy, 0.0, 0.0]
    }

    fn of_tensor(&[xx, yy, _, xy, ..]: &[f64; 6]) -> Matrix {
        [[xx, xy], [xy, yy]]
    }

    fn sliding([_, sliding]: &[f64; 2]) -> f64 {
        *sliding
    }

    #[inline(always)]
    fn circle([[xx, xy], [_, yy]]: &Matrix) -> [f64; 2] {
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        [mean, (half * half + xy * xy).sqrt()]
    }

    #[inline(always)]
    fn circle_close(stress: &Matrix) -> [f64; 2] {
        Self::circle(stress)
    }

    fn is_plate(plane: Plane) -> bool {
        plane == Plane::Stress
    }

    fn moduli(youngs_modulus: f64, poissons_ratio: f64, plane: Plane) -> Moduli {
        elastic::moduli(youngs_modulus, poissons_ratio, plane)
    }

    #[inline]
    fn stress(moduli: [f64; 2], f: &Matrix, j: f64) -> (Matrix, f64) {
        elastic::stress(moduli, f, j)
    }

    #[inline(always)]
    fn stress_of_small(moduli: [f64; 2], f: &Matrix, j: f64) -> (Matrix, f64, f64) {
        let (stress, energy) = elastic::stress(moduli, f, j);
        (stress, energy, 0.0)
    }

    fn stored(moduli: &Moduli, stress: &Matrix) -> f64 {
        elastic::stored(moduli, stress)
    }

    fn highest_square(&self, moduli: &Moduli, density: f64) -> f64 {
        let [a, b, c] = *self;
        let double = cross(minus(b, a), minus(c, a));
        // ∇N of each corner, and S = Σ ∇N ∇Nᵀ. In the axes in which S is diagonal, B Bᵀ is diag(s₁, s₂, s₁ +
        // s₂). D is the same in all axes.
        let gradients = [minus(c, b), minus(a, c), minus(b, a)].map(|[x, y]| [-y / double, x / double]);
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for [x, y] in gradients {
            xx += x * x;
            yy += y * y;
            xy += x * y;
        }
        let [middle, radius] = Self::circle(&[[xx, xy], [xy, yy]]);
        let (one, two) = (middle + radius, middle - radius);
        let (sum, product) = (one + two, (one * two).max(0.0));
        let Moduli { wave, shear, bulk, .. } = *moduli;
        let root = (wave * wave * sum * sum - 16.0 * bulk * shear * product).max(0.0).sqrt();
        let largest = (0.5 * (wave * sum + root)).max(shear * sum);
        3.0 / density * largest
    }

    #[inline(always)]
    fn parted(&self, other: &Self) -> f64 {
        potential::parted(self, other)
    }

    fn usual_interactions(
        available: Available,
        shapes: &[Shapes<2, 3>],
        scratch: &mut Self::Scratch,
        found: &mut [Interactions<2, 3>],
    ) {
        potential::usual_interactions(available, shapes, scratch, found);
    }

    fn distance(&self, _: &Self, known: f64) -> f64 {
        known
    }
}
