//! Tetrahedra.

mod distance;
mod eigen;
mod elastic;
mod facet;
mod numbering;
mod part;
mod piece;
mod plane;
mod potential;

use crate::lanes::Available;
use crate::moduli::{Moduli, Plane};
use crate::simplex::tetrahedron::numbering::FACES;
use crate::simplex::{Interactions, Shapes, Simplex, Tetrahedron};
use crate::vector::{Matrix, Point, cross3, dot, length, minus, unit};

impl Simplex<3, 4> for Tetrahedron {
    type Scratch = potential::Scratch;

    const FACETS: [[usize; 3]; 4] = FACES;
    const AT_CORNER: [[usize; 3]; 4] = [[0, 1, 3], [0, 1, 2], [0, 2, 3], [1, 2, 3]];
    const SMALL: f64 = elastic::SMALL;
    const FACETS_ARE: &'static str = "faces";

    #[inline]
    fn determinant([one, two, three]: &Matrix<3>) -> f64 {
        dot(*one, cross3(*two, *three))
    }

    #[inline(always)]
    fn cofactor([one, two, three]: &Matrix<3>) -> Matrix<3> {
        [cross3(*two, *three), cross3(*three, *one), cross3(*one, *two)]
    }

    fn measure(&self) -> f64 {
        let [a, b, c, d] = *self;
        dot(minus(b, a), cross3(minus(c, a), minus(d, a))) / 6.0
    }

    fn height(&self, facet: usize) -> f64 {
        let [p, q, r] = FACES[facet].map(|corner| self[corner]);
        // Twice the area of the face.
        let double = length(cross3(minus(q, p), minus(r, p)));
        6.0 * self.measure() / double
    }

    #[inline(always)]
    fn coordinates(&self, point: Point<3>) -> [f64; 4] {
        potential::VolumeCoordinates::of(self).at(point)
    }

    fn facet_measure([a, b, c]: &[Point<3>; 3]) -> f64 {
        0.5 * length(cross3(minus(*b, *a), minus(*c, *a)))
    }

    #[inline(always)]
    fn facet_normal(facet: &[Point<3>; 3]) -> Point<3> {
        Self::axes(facet)[0].map(|x| 0.5 * x)
    }

    fn facet_length(measure: f64) -> f64 {
        // The area of an even triangle is √3/4 of the square of its edge.
        (4.0 / 3.0_f64.sqrt() * measure).sqrt()
    }

    #[inline(always)]
    fn axes([a, b, c]: &[Point<3>; 3]) -> Matrix<3> {
        let along = minus(*b, *a);
        let normal = cross3(along, minus(*c, *a));
        [normal, along, cross3(normal, along)]
    }

    #[inline(always)]
    fn unit_axes([a, b, c]: &[Point<3>; 3]) -> Matrix<3> {
        let along = minus(*b, *a);
        let normal = cross3(along, minus(*c, *a));
        let [normal, along] = [normal, along].map(|axis| {
            let long = 1.0 / dot(axis, axis).sqrt();
            axis.map(|x| x * long)
        });
        [normal, along, cross3(normal, along)]
    }

    #[inline(always)]
    fn axes_around(normal: Point<3>) -> Matrix<3> {
        plane::axes_around(normal)
    }

    fn contact_length(measure: f64) -> f64 {
        libm::cbrt(measure)
    }

    fn common(
        one: &[Point<3>; 3],
        other: &[Point<3>; 3],
        touch: f64,
        least: f64,
    ) -> Vec<([[f64; 3]; 2], f64)> {
        facet::common(one, other, touch, least)
    }

    fn turning(
        facet: &[Point<3>; 3],
        axes: &Matrix<3>,
        gap: &[f64; 3],
        pressure: f64,
        traction: &[f64; 3],
        area: f64,
    ) -> [Point<3>; 3] {
        facet::turning(facet, axes, gap, pressure, traction, area)
    }

    fn traction_on(facet: &[Point<3>; 3], stress: &Matrix<3>) -> [f64; 3] {
        let axes = Self::axes(facet).map(unit);
        plane::traction_in(&axes, stress)
    }

    fn tractions_near(
        facet: &[Point<3>; 3],
        stress: &Matrix<3>,
        friction: f64,
        reach: f64,
    ) -> [([f64; 3], f64); 3] {
        plane::tractions_near(&Self::axes(facet).map(unit), stress, friction, reach)
    }

    fn tension_across(facet: &[Point<3>; 3], stress: &Matrix<3>) -> Option<(f64, [f64; 3])> {
        let axes = Self::axes(facet).map(unit);
        let (values, vectors) = eigen::values_and_vectors(*stress);
        let most = (1..3).fold(0, |best, k| if values[k] > values[best] { k } else { best });
        let normal = axes.map(|axis| dot(vectors[most], axis));
        Some((values[most], if normal[0] < 0.0 { normal.map(|x| -x) } else { normal }))
    }

    fn cut_axes(_: &[Point<3>; 3], sum: Point<3>) -> Matrix<3> {
        plane::axes_around(unit(sum))
    }

    fn projection(facet: Point<3>, cut: Point<3>) -> f64 {
        dot(facet, cut).max(0.0)
    }

    fn in_tensor(&[[xx, xy, xz], [_, yy, yz], [.., zz]]: &Matrix<3>, _: f64) -> [f64; 6] {
        [xx, yy, zz, xy, yz, xz]
    }

    fn of_tensor(&[xx, yy, zz, xy, yz, xz]: &[f64; 6]) -> Matrix<3> {
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }

    fn sliding([_, one, other]: &[f64; 3]) -> f64 {
        length([*one, *other])
    }

    fn circle(stress: &Matrix<3>) -> [f64; 2] {
        let values = eigen::values(*stress);
        let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let least = values.into_iter().fold(f64::INFINITY, f64::min);
        [0.5 * (most + least), 0.5 * (most - least)]
    }

    #[inline(always)]
    fn circle_close(stress: &Matrix<3>) -> [f64; 2] {
        eigen::circle_close(stress)
    }

    fn is_plate(_: Plane) -> bool {
        false
    }

    fn moduli(youngs_modulus: f64, poissons_ratio: f64, _: Plane) -> Moduli {
        elastic::moduli(youngs_modulus, poissons_ratio)
    }

    #[inline]
    fn stress(moduli: [f64; 2], f: &Matrix<3>, j: f64) -> (Matrix<3>, f64) {
        elastic::stress(moduli, f, j, &Self::cofactor(f), elastic::cube_root)
    }

    #[inline(always)]
    fn stress_of_small(moduli: [f64; 2], f: &Matrix<3>, j: f64) -> (Matrix<3>, f64, f64) {
        let mut strain = 0.0;
        let (stress, energy) = elastic::stress(moduli, f, j, &Self::cofactor(f), |z| {
            strain = z.abs();
            elastic::cube_root_of_small(z)
        });
        (stress, energy, strain)
    }

    fn stored(moduli: &Moduli, stress: &Matrix<3>) -> f64 {
        elastic::stored(moduli, stress)
    }

    fn highest_square(&self, moduli: &Moduli, density: f64) -> f64 {
        let gradients = potential::VolumeCoordinates::of(self).gradients;
        let mut sum = [[0.0; 3]; 3];
        for gradient in gradients {
            for (row, g) in sum.iter_mut().zip(gradient) {
                crate::vector::add(row, gradient, g);
            }
        }
        // In the axes in which S = Σ ∇N ∇Nᵀ is diagonal, B Bᵀ is diagonal too: s₁, s₂, s₃ and their sums in
        // pairs. The stiffness has the eigenvalues of D B Bᵀ: the eigenvalues of the shears, and of √sᵢ Dᵢₖ
        // √sₖ.
        let squares = eigen::values(sum).map(|square| square.max(0.0));
        let roots = squares.map(f64::sqrt);
        let lame = moduli.wave - 2.0 * moduli.shear;
        let normal =
            crate::vector::matrix(|i, k| roots[i] * roots[k] * if i == k { moduli.wave } else { lame });
        let most = |values: [f64; 3]| values.into_iter().fold(0.0, f64::max);
        let shear =
            moduli.shear * (squares.iter().sum::<f64>() - squares.into_iter().fold(f64::INFINITY, f64::min));
        4.0 / density * most(eigen::values(normal)).max(shear)
    }

    #[inline(always)]
    fn parted(&self, other: &Self) -> f64 {
        potential::parted(self, other)
    }

    fn usual_interactions(
        available: Available,
        shapes: &[Shapes<3, 4>],
        scratch: &mut Self::Scratch,
        found: &mut [Interactions<3, 4>],
    ) {
        potential::usual_interactions(available, shapes, scratch, found);
    }

    fn distance(&self, other: &Self, known: f64) -> f64 {
        distance::between(self, other).max(known)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::uniform;
    use crate::vector::matrix;

    /// The batch computes the stress to the last bit, up to the measure that it returns.
    #[test]
    fn the_stress_of_small_strains_is_the_stress() {
        let (mut small, mut large) = (0, 0);
        for seed in 0..2000 {
            let size = 10_f64.powf(-4.0 * uniform(seed, 0));
            let noise: Matrix<3> = matrix(|i, k| uniform(seed, 1 + (3 * i + k) as u64) - 0.5);
            let f = matrix(|i, k| f64::from(u8::from(i == k)) + size * noise[i][k]);
            let j = Tetrahedron::determinant(&f);
            if j <= 0.1 {
                continue;
            }
            let (stress, energy, strain) = Tetrahedron::stress_of_small([2e9, 3e9], &f, j);
            if strain < Tetrahedron::SMALL {
                assert_eq!((stress, energy), Tetrahedron::stress([2e9, 3e9], &f, j));
                small += 1;
            } else {
                large += 1;
            }
        }
        assert!(small > 500 && large > 100, "{small} {large}");
    }
}
