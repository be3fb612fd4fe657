//! Transversely isotropic elasticity: a material with bedding, foliation or fibres that is alike in all
//! directions of a plane, and different across it.
//!
//! With the strain `E = (FᵀF − 1)/2` and the normal `n` of the bedding in the undeformed body, the energy per
//! undeformed area or volume is
//!
//! ```text
//! W = s W₀(F) + Q(E),    2 Q = λ (tr E)² + 2 µ E:E + 2 α (tr E)(n·E n) + 2 κ |E n|² + β (n·E n)².
//! ```
//! `W₀` is the neo-Hookean energy (`laws/neo_hookean.rs`) of the isotropic stiffness that is nearest to that
//! of the material: Voigt's mean. The factor `s` is the largest for which the quadratic form `Q` is not
//! negative for any strain. To first order in the strains, the stress is that of the five constants; an
//! isotropic material has `s = 1` and no `Q`. As `W` depends on `FᵀF` alone, it does not change in a
//! rotation; the stress `P = ∂W/∂F = s ∂W₀/∂F + F ∂Q/∂E` is its gradient. `W₀` resists being flattened to
//! nothing, and `Q`, which as the energy of Saint-Venant and Kirchhoff does not, never makes it softer than
//! its share.
//!
//! The same invariants describe plane strain. In plane stress the constants follow from the compliance in the
//! plane.
//!
//! An element keeps the present normal of its bedding, from which the stress out of the plane follows.
//!
//! # Sources
//! S.G. Lekhnitskii, *Theory of Elasticity of an Anisotropic Body* (1963): the five constants. A.J.M.
//! Spencer, *Continuum Theory of the Mechanics of Fibre-Reinforced Composites* (1984): the quadratic form in
//! invariants. A. Lisjak, G. Grasselli, T. Vietor, "Continuum-discontinuum analysis of failure mechanisms
//! around unsupported circular excavations in anisotropic clay shales", Int. J. Rock Mech. Min. Sci. 65
//! (2014) 96–115: strengths that grow linearly with the angle.

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use crate::accelerator::FlatBedding;
use crate::lanes::{Lanes, row, set_row};
use crate::laws::element_law::{ElementLaw, Refusal, Response};
use crate::simplex::Simplex;
use crate::strength::Strength;
use crate::vector::{
    Matrix, Point, applied, cholesky, contraction, dot, matrix, product, product_transposed, symmetric,
    transposed, unit,
};

/// The bedding of a transversely isotropic material: its normal, the constants across it, and the strength on
/// it. The Young's modulus and Poisson's ratio of the material are those in the plane of the bedding, and its
/// strength is that across.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bedding {
    /// Normal of the bedding in the undeformed body, of any length; in two dimensions the last component is
    /// 0.
    pub normal: [f64; 3],
    /// Young's modulus across the bedding, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio of a stress across the bedding: minus the strain along it over the strain across.
    pub poissons_ratio: f64,
    /// Shear modulus of planes that contain the normal, Pa.
    pub shear_modulus: f64,
    /// Strength of the bedding, whose angle of friction and scatter do not count; `None` for a strength that
    /// is the same in all directions.
    pub strength: Option<Strength>,
}

impl Bedding {
    /// A number that has to be positive, or some deformation would have a negative energy: `1 − ν − 2 ν'²
    /// E/E'`, where E and ν are `youngs_modulus` and `poissons_ratio`, those in the plane of the bedding.
    pub fn stability(&self, youngs_modulus: f64, poissons_ratio: f64) -> f64 {
        let across = self.poissons_ratio;
        1.0 - poissons_ratio - 2.0 * across * across * youngs_modulus / self.youngs_modulus
    }

    /// Checks the constants, with those in the plane of the bedding.
    pub(super) fn check(&self, dimensions: usize, e: f64, nu: f64) -> Result<(), Refusal> {
        let refuse = |what, value, range| Err(Refusal { what, value, range });
        let positive = |what, value: f64| {
            if value > 0.0 && value.is_finite() { Ok(()) } else { refuse(what, value, "positive") }
        };
        positive("Young's modulus across the bedding", self.youngs_modulus)?;
        positive("shear modulus across the bedding", self.shear_modulus)?;
        positive("length of the normal of the bedding", dot(self.normal, self.normal).sqrt())?;
        if let Some(&out) = self.normal[dimensions..].iter().find(|&&component| component != 0.0) {
            return refuse("component of the normal of the bedding out of the plane", out, "0");
        }
        if !(nu > -1.0 && nu < 1.0) {
            return refuse("Poisson's ratio", nu, "above -1 and below 1");
        }
        positive("1 - ν - 2 ν'² E/E' of the bedding", self.stability(e, nu))?;
        if let Some(strength) = self.strength {
            positive("tensile strength on the bedding", strength.tensile)?;
            positive("cohesion on the bedding", strength.cohesion)?;
            positive("fracture energy of opening on the bedding", strength.energy_i)?;
            positive("fracture energy of sliding on the bedding", strength.energy_ii)?;
        }
        Ok(())
    }

    /// The strength of a facet: linear in its angle to the bedding, from that on the bedding to `across`,
    /// that of the material.
    pub(super) fn strength_on<const D: usize>(&self, across: Strength, facet: Point<D>) -> Strength {
        let Some(on) = self.strength else { return across };
        let cos = dot(self.direction(), facet).abs().min(1.0);
        let share = libm::acos(cos) / std::f64::consts::FRAC_PI_2;
        let between = |on: f64, across: f64| on + share * (across - on);
        Strength {
            tensile: between(on.tensile, across.tensile),
            cohesion: between(on.cohesion, across.cohesion),
            energy_i: between(on.energy_i, across.energy_i),
            energy_ii: between(on.energy_ii, across.energy_ii),
            ..across
        }
    }

    /// The normal, of unit length.
    fn direction<const D: usize>(&self) -> Point<D> {
        unit(std::array::from_fn(|axis| self.normal[axis]))
    }

    /// Poisson's ratio of Voigt's mean over all directions. `e`, `nu`: the constants in the plane of the
    /// bedding.
    pub(super) fn mean_poissons_ratio(&self, e: f64, nu: f64) -> f64 {
        let [lame, shear] = self.in_elements::<3>(e, nu, false).whole.isotropic_mean(3.0);
        0.5 * lame / (lame + shear)
    }

    /// The law in elements. `e`, `nu`: the constants in the plane of the bedding; `plate`: whether the stress
    /// out of the plane vanishes.
    pub(super) fn in_elements<const D: usize>(&self, e: f64, nu: f64, plate: bool) -> Bedded<D> {
        let Self { youngs_modulus: across, poissons_ratio, shear_modulus: shear, .. } = *self;
        let stiffness = if plate {
            // The inverse of the compliance in the plane, of which one axis is the normal and the other lies
            // in the bedding.
            let [along, coupling, normal] = [1.0 / e, -poissons_ratio / across, 1.0 / across];
            let determinant = along * normal - coupling * coupling;
            let (c11, c13, c33) = (normal / determinant, -coupling / determinant, along / determinant);
            Stiffness::of(c11, c11 - 2.0 * shear, c13, c33, shear)
        } else {
            let over = 1.0 / self.stability(e, nu);
            let (sum, difference) = (e * over, e / (1.0 + nu));
            let (c13, c33) = (e * poissons_ratio * over, across * (1.0 - nu) * over);
            Stiffness::of(0.5 * (sum + difference), 0.5 * (sum - difference), c13, c33, shear)
        };
        let [lame, shear] = stiffness.isotropic_mean(D as f64);
        let share = stiffness.share_of([lame, shear], (D - 1) as f64);
        let isotropic = [share * shear, share * (lame + 2.0 * shear / D as f64)];
        let rest = Stiffness {
            lame: stiffness.lame - share * lame,
            shear: stiffness.shear - share * shear,
            ..stiffness
        };
        let out_of_plane = if plate { [0.0; 2] } else { [nu, poissons_ratio * e / across] };
        Bedded { isotropic, rest, whole: stiffness, normal: self.direction(), out_of_plane }
    }
}

/// A stiffness that is alike in all directions at right angles to a normal `n`, Pa: half of `λ (tr E)² + 2 µ
/// E:E + 2 α (tr E)(n·E n) + 2 κ |E n|² + β (n·E n)²` is the energy of a strain.
#[derive(Clone, Copy, Debug)]
struct Stiffness {
    /// λ, and µ: the shear modulus of the plane.
    lame: f64,
    shear: f64,
    /// α.
    coupling: f64,
    /// κ: twice the difference of the two shear moduli.
    excess: f64,
    /// β.
    along: f64,
}

impl Stiffness {
    /// The stiffness with these components, of which the last axis is the normal.
    fn of(c11: f64, c12: f64, c13: f64, c33: f64, c44: f64) -> Self {
        let (lame, shear, coupling) = (c12, 0.5 * (c11 - c12), c13 - c12);
        let excess = 2.0 * (c44 - shear);
        Self { lame, shear, coupling, excess, along: c33 - lame - 2.0 * (shear + coupling + excess) }
    }

    /// Shear modulus of planes that contain the normal.
    fn shear_across(&self) -> f64 {
        self.shear + 0.5 * self.excess
    }

    /// Stiffness of two strains and their coupling: the change of size of the plane, as a tensor of unit
    /// magnitude, and the strain along the normal. `axes`: those of the plane.
    fn sizes(&self, axes: f64) -> [f64; 3] {
        let Self { lame, shear, coupling, excess, along } = *self;
        let normal = lame + 2.0 * (shear + coupling + excess) + along;
        [axes * lame + 2.0 * shear, axes.sqrt() * (lame + coupling), normal]
    }

    /// Lamé's constants of Voigt's mean over all directions of the normal.
    fn isotropic_mean(&self, dimensions: f64) -> [f64; 2] {
        let Self { lame, shear, coupling, excess, along } = *self;
        let d = dimensions;
        let bulk = d * d * lame + 2.0 * d * (shear + coupling) + 2.0 * excess + along;
        let all = d * lame + (d * d + d) * shear + 2.0 * coupling + (d + 1.0) * excess + along;
        let mean = (all - bulk / d) / (d * d + d - 2.0);
        [(bulk - 2.0 * d * mean) / (d * d), mean]
    }

    /// The largest share of an isotropic stiffness that is nowhere stiffer than this one.
    fn share_of(&self, [lame, shear]: [f64; 2], axes: f64) -> f64 {
        let isotropic = Self { lame, shear, coupling: 0.0, excess: 0.0, along: 0.0 };
        let ([a, b, c], [p, q, r]) = (self.sizes(axes), isotropic.sizes(axes));
        // The smaller root of det(A - s P) = 0.
        let (square, linear, constant) = (p * r - q * q, a * r + c * p - 2.0 * b * q, a * c - b * b);
        let root = (linear * linear - 4.0 * square * constant).max(0.0).sqrt();
        let of_sizes = 2.0 * constant / (linear + root);
        of_sizes.min(self.shear / shear).min(self.shear_across() / shear)
    }

    /// Stress of a strain, and its energy, J/m³. Twin: `stress_of_rest` in `crates/gpu/kernels/laws.h`.
    #[inline(always)]
    fn stress<const D: usize>(&self, normal: Point<D>, strain: &Matrix<D>) -> (Matrix<D>, f64) {
        let Self { lame, shear, coupling, excess, along } = *self;
        let across = applied(strain, normal);
        let (mut sum, stretch) = (strain[0][0], dot(normal, across));
        for axis in 1..D {
            sum += strain[axis][axis];
        }
        let (mean, own) = (lame * sum + coupling * stretch, coupling * sum + along * stretch);
        let stress = matrix(|i, k| {
            let both = normal[i] * across[k] + across[i] * normal[k];
            let part = 2.0 * shear * strain[i][k] + excess * both + own * (normal[i] * normal[k]);
            if i == k { part + mean } else { part }
        });
        (stress, 0.5 * contraction(&stress, strain))
    }
}

/// The law of a material with [`Bedding`] in the plane or in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bedded<const D: usize> {
    /// Moduli of shear and bulk of the share of the neo-Hookean energy, Pa.
    isotropic: [f64; 2],
    /// The rest of the stiffness.
    rest: Stiffness,
    /// The whole stiffness.
    whole: Stiffness,
    /// Normal of the bedding in the undeformed body, of unit length.
    normal: Point<D>,
    /// Stress out of the plane over the stress along the bedding and over that across.
    out_of_plane: [f64; 2],
}

/// Constants of a batch.
#[derive(Clone, Debug)]
pub(crate) struct BatchConstants<const D: usize> {
    isotropic: [Lanes; 2],
    rest: [Lanes; 5],
    normal: [Lanes; D],
}

impl<const D: usize> Bedded<D> {
    /// The law as plain numbers, with the moduli of shear and bulk of its share of the neo-Hookean energy,
    /// Pa.
    pub(crate) fn flat(&self) -> ([f64; 2], FlatBedding<D>) {
        (self.isotropic, FlatBedding { rest: self.rest(), normal: self.normal })
    }

    /// The law with these numbers, as far as stresses depend on it.
    pub(crate) fn of_flat(isotropic: [f64; 2], bedding: &FlatBedding<D>) -> Self {
        let [lame, shear, coupling, excess, along] = bedding.rest;
        let rest = Stiffness { lame, shear, coupling, excess, along };
        Self { isotropic, rest, whole: rest, normal: bedding.normal, out_of_plane: [0.0; 2] }
    }

    fn rest(&self) -> [f64; 5] {
        let Stiffness { lame, shear, coupling, excess, along } = self.rest;
        [lame, shear, coupling, excess, along]
    }

    /// A stress or strain as its part along the normal, the sum of its parts in the plane, and the squares of
    /// the rest: across, and in the plane.
    fn parts(&self, stress: &Matrix<D>) -> [f64; 4] {
        let across = applied(stress, self.normal);
        let normal = dot(self.normal, across);
        let sum = (1..D).fold(stress[0][0], |sum, axis| sum + stress[axis][axis]) - normal;
        let shear = dot(across, across) - normal * normal;
        let rest = contraction(stress, stress) - normal * normal - 2.0 * shear - sum * sum / (D - 1) as f64;
        [normal, sum, shear, rest]
    }
}

impl<const D: usize, const N: usize> ElementLaw<D, N> for Bedded<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    type Constants = BatchConstants<D>;

    /// The present normal of the bedding.
    const MEMORY: usize = D;
    const SMALL: f64 = <[[f64; D]; N] as Simplex<D, N>>::SMALL;

    #[inline(always)]
    fn constants(&self) -> BatchConstants<D> {
        BatchConstants {
            isotropic: self.isotropic.map(Lanes::all),
            rest: self.rest().map(Lanes::all),
            normal: self.normal.map(Lanes::all),
        }
    }

    fn set(&self, constants: &mut BatchConstants<D>, lane: usize) {
        set_row(&mut constants.isotropic, lane, &self.isotropic);
        set_row(&mut constants.rest, lane, &self.rest());
        set_row(&mut constants.normal, lane, &self.normal);
    }

    #[inline(always)]
    fn stress_of_small(
        constants: &BatchConstants<D>,
        memory: &mut [Lanes],
        lane: usize,
        f: &Matrix<D>,
        j: f64,
    ) -> Response<D> {
        let (stress, energy, strain) =
            <[[f64; D]; N]>::stress_of_small(row(&constants.isotropic, lane), f, j);
        with_bedding::<D, N>(constants, memory, lane, f, Response { stress, energy, dissipated: 0.0, strain })
    }

    #[inline]
    fn stress(
        constants: &BatchConstants<D>,
        memory: &mut [Lanes],
        lane: usize,
        f: &Matrix<D>,
        j: f64,
    ) -> Response<D> {
        let (stress, energy) = <[[f64; D]; N]>::stress(row(&constants.isotropic, lane), f, j);
        let isotropic = Response { stress, energy, dissipated: 0.0, strain: 0.0 };
        with_bedding::<D, N>(constants, memory, lane, f, isotropic)
    }

    fn begin(&self, memory: &mut [f64]) {
        memory[..D].copy_from_slice(&self.normal);
    }

    fn stored(&self, stress: &Matrix<D>) -> f64 {
        let [normal, sum, shear, rest] = self.parts(stress);
        let axes = (D - 1) as f64;
        let [plane, coupling, along] = self.whole.sizes(axes);
        let sum = sum / axes.sqrt();
        let sizes = (along * sum * sum - 2.0 * coupling * sum * normal + plane * normal * normal)
            / (plane * along - coupling * coupling);
        0.5 * (sizes + shear / self.whole.shear_across() + rest / (2.0 * self.whole.shear))
    }

    fn out_of_plane(&self, stress: &Matrix<D>, memory: &[f64]) -> f64 {
        let normal: Point<D> = std::array::from_fn(|axis| memory[axis]);
        let across = dot(normal, applied(stress, normal));
        let sum = (1..D).fold(stress[0][0], |sum, axis| sum + stress[axis][axis]);
        let [of_along, of_across] = self.out_of_plane;
        of_along * (sum - across) + of_across * across
    }

    /// The largest eigenvalue of the stiffness of the element. In a basis of symmetric tensors, with the
    /// stiffness `C = L Lᵀ` and the sums `G` over the corners of products of strains, it is that of `Lᵀ G L`.
    fn highest_square(&self, shape: &[Point<D>; N], density: f64) -> f64 {
        let inverse = <[[f64; D]; N]>::inverse_edges(shape);
        let first = std::array::from_fn(|axis| -(0..D).map(|k| inverse[k][axis]).sum::<f64>());
        let (basis, size) = basis::<D>();
        let stresses = basis.map(|strain| self.whole.stress(self.normal, &strain).0);
        // Beyond the size of the basis, strains are 0, and have any stiffness.
        let padding = |i: usize, k: usize| if i == k && i >= size { self.whole.shear } else { 0.0 };
        let stiffness = matrix(|i, k| contraction(&basis[i], &stresses[k]) + padding(i, k));
        let sums: Matrix<MOST> = matrix(|i, k| {
            let both = |gradient: Point<D>| dot(applied(&basis[i], gradient), applied(&basis[k], gradient));
            inverse.iter().map(|&gradient| both(gradient)).sum::<f64>() + both(first)
        });
        let root = transposed(&cholesky(&stiffness));
        // Lᵀ G L, from the rows of Lᵀ.
        let reduced = product_transposed(&product_transposed(&root, &sums), &root);
        N as f64 / density * largest_eigenvalue(reduced)
    }

    /// Exact along the bedding and across it in two dimensions. In space, shear waves along the bedding have
    /// two speeds, of which this is a mean; aslant to the bedding, waves are not quite compressional or
    /// shear.
    fn wave_moduli(&self, direction: Point<D>) -> [f64; 2] {
        let traction = |moved: Point<D>| {
            let strain = symmetric(&matrix(|i, k| moved[i] * direction[k]));
            dot(moved, applied(&self.whole.stress(self.normal, &strain).0, direction))
        };
        let axis = |axis: usize| std::array::from_fn(|k| f64::from(u8::from(k == axis)));
        let (all, along): (f64, f64) = ((0..D).map(|k| traction(axis(k))).sum(), traction(direction));
        [along, (all - along) / (D - 1) as f64]
    }
}

/// Adds the part of the bedding to the response of the isotropic part, and keeps the present normal. Twin:
/// `add_bedding` in `crates/gpu/kernels/laws.h`.
#[inline(always)]
fn with_bedding<const D: usize, const N: usize>(
    constants: &BatchConstants<D>,
    memory: &mut [Lanes],
    lane: usize,
    f: &Matrix<D>,
    isotropic: Response<D>,
) -> Response<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let normal = row(&constants.normal, lane);
    let turned = transposed(f);
    let squared = product_transposed(&turned, &turned);
    let strain = matrix(|i, k| 0.5 * if i == k { squared[i][k] - 1.0 } else { squared[i][k] });
    let [lame, shear, coupling, excess, along] = row(&constants.rest, lane);
    let (second, energy) = Stiffness { lame, shear, coupling, excess, along }.stress(normal, &strain);
    let first = product(f, &second);
    let now = applied(&<[[f64; D]; N]>::cofactor(f), normal);
    let over = 1.0 / dot(now, now).sqrt();
    for (value, component) in memory.iter_mut().zip(now) {
        value.set(lane, over * component);
    }
    Response {
        stress: matrix(|i, k| isotropic.stress[i][k] + first[i][k]),
        energy: isotropic.energy + energy,
        ..isotropic
    }
}

/// Number of components of a symmetric tensor in space.
const MOST: usize = 6;

/// Symmetric tensors of unit magnitude at right angles, which span all others, and their number. The
/// remaining ones are 0.
fn basis<const D: usize>() -> ([Matrix<D>; MOST], usize) {
    let (mut basis, mut size) = ([[[0.0; D]; D]; MOST], 0);
    for axis in 0..D {
        for other in axis..D {
            let entry = if other == axis { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
            (basis[size][axis][other], basis[size][other][axis]) = (entry, entry);
            size += 1;
        }
    }
    (basis, size)
}

/// The largest eigenvalue of a symmetric matrix, by Jacobi's rotations.
fn largest_eigenvalue(mut a: Matrix<MOST>) -> f64 {
    // Convergence is quadratic: this leaves nothing that a double can hold.
    for _ in 0..8 {
        for p in 0..MOST {
            for q in p + 1..MOST {
                if a[p][q] == 0.0 {
                    continue;
                }
                let cotangent = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let tangent = cotangent.signum() / (cotangent.abs() + (1.0 + cotangent * cotangent).sqrt());
                let cos = 1.0 / (1.0 + tangent * tangent).sqrt();
                let sin = tangent * cos;
                for k in 0..MOST {
                    let (one, two) = (a[k][p], a[k][q]);
                    (a[k][p], a[k][q]) = (cos * one - sin * two, sin * one + cos * two);
                }
                for k in 0..MOST {
                    let (one, two) = (a[p][k], a[q][k]);
                    (a[p][k], a[q][k]) = (cos * one - sin * two, sin * one + cos * two);
                }
            }
        }
    }
    (0..MOST).map(|k| a[k][k]).fold(0.0, f64::max)
}
