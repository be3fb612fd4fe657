//! Strengths, energies and critical lengths of a joint, in every direction. Twin of the functions without a
//! branch: `crates/gpu/kernels/joints.h`.

use fdem_distributed::wire;

use crate::cohesive::curve::{AREA, softening};
use crate::lanes::larger;
use crate::model::{CriticalOpening, JointSet, Strength};
use crate::vector::{along, dot, length, minus};

/// Critical opening and sliding of a joint without strength, over its length.
const OPEN: f64 = 1e-6;
/// Default of the slip over the length of a joint up to which it dilates.
const DILATES: f64 = 0.05;

/// Parameters of one joint. Parameters of sliding are in the variables that the head of this file explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointLaw<const D: usize = 2> {
    /// Unit normal of the plane that the joint represents, across the joint and along it. The mode of an
    /// opening is measured from it.
    pub(crate) normal: [f64; D],
    /// Penalty stiffness, Pa/m.
    pub(crate) penalty: f64,
    pub(crate) tensile: f64,
    pub(crate) cohesion: f64,
    /// Tangent of the friction angle.
    pub(crate) friction: f64,
    /// Tangent of the friction angle of a broken joint.
    pub(crate) residual: f64,
    /// Square root of the ratio of shear to normal stiffness.
    pub(crate) shear: f64,
    /// Opening and sliding beyond the elastic range at which the joint is broken, m.
    pub(crate) critical: [f64; 2],
    /// Opening for each length that the sides slip under friction.
    pub(crate) dilation: f64,
    /// The opening, m, up to which they dilate.
    pub(crate) dilated: f64,
}

/// Fracture energies that are less than the energy that a joint stores before it softens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TooLittle {
    /// Least energy, J/m².
    pub(crate) least: f64,
    pub(crate) sliding: bool,
}

impl<const D: usize> JointLaw<D> {
    /// `elastic`: the work up to the strength counts as dissipated, as for intrinsic joints. Fails if this
    /// work alone exceeds a fracture energy. `length`: length of the joint, m.
    ///
    /// A strength of 0 gives no critical length, so the joint takes that of the other strength. If both
    /// strengths are 0, the joint is open, with friction only: its critical length is a small share of its
    /// length.
    pub(crate) fn new(
        strength: &Strength,
        penalty: f64,
        opening: CriticalOpening,
        elastic: bool,
        length: f64,
    ) -> Result<Self, TooLittle> {
        let strengths = [strength.tensile, strength.cohesion];
        let energies = [strength.energy_i, strength.energy_ii];
        let both: [f64; 2] = std::array::from_fn(|mode| {
            let stored = if elastic { 0.5 * strengths[mode] * strengths[mode] / penalty } else { 0.0 };
            match opening {
                CriticalOpening::Exact => (energies[mode] - stored) / (AREA * strengths[mode]),
                CriticalOpening::Customary => 3.0 * energies[mode] / strengths[mode],
            }
        });
        let critical = match strengths.map(|strength| strength > 0.0) {
            [true, true] => both,
            [true, false] => [both[0]; 2],
            [false, true] => [both[1]; 2],
            [false, false] => [OPEN * length; 2],
        };
        match critical.iter().position(|&length| length <= 0.0 || length.is_nan()) {
            Some(place) => {
                // Without a strength of its own, a mode takes the length of the other one.
                let mode = if strengths[place] > 0.0 { place } else { 1 - place };
                let least = 0.5 * strengths[mode] * strengths[mode] / penalty;
                Err(TooLittle { least, sliding: mode == 1 })
            }
            None => Ok(Self {
                normal: across(),
                penalty,
                tensile: strength.tensile,
                cohesion: strength.cohesion,
                friction: strength.friction,
                residual: strength.friction,
                shear: 1.0,
                critical,
                dilation: 0.0,
                dilated: 0.0,
            }),
        }
    }

    /// The law of a joint of a set, with normal stiffness `penalty`, Pa/m. `shear`: square root of the ratio
    /// of shear to normal stiffness. Other parameters: as for [`JointLaw::new`].
    pub(crate) fn of_set(
        set: &JointSet,
        [penalty, shear]: [f64; 2],
        opening: CriticalOpening,
        length: f64,
    ) -> Result<Self, TooLittle> {
        let (cohesion, friction) = (set.strength.cohesion / shear, set.strength.friction / shear);
        let law =
            Self::new(&Strength { cohesion, friction, ..set.strength }, penalty, opening, true, length)?;
        let dilated = set.dilation * set.dilation_slip.unwrap_or(DILATES * length);
        Ok(Self {
            residual: set.residual_friction / shear,
            shear,
            dilation: set.dilation / shear,
            dilated,
            ..law
        })
    }

    /// The strengths of a whole joint, without energies.
    pub(crate) fn strength(&self) -> Strength {
        let Self { tensile, cohesion, friction, .. } = *self;
        Strength {
            tensile,
            cohesion,
            friction,
            energy_i: 0.0,
            energy_ii: 0.0,
            weibull_modulus: None,
            seed: 0,
        }
    }

    /// Elastic traction of a whole bond over its strength in its direction. A bond that closes has no part
    /// across the joint.
    pub(crate) fn use_of_bond(&self, mut bond: [f64; D]) -> f64 {
        bond[0] = bond[0].max(0.0);
        let squared = dot(bond, bond);
        let [strength, _] = self.in_direction(self.shares(bond, squared));
        self.penalty * squared.sqrt() / strength
    }

    /// Coefficient of friction at this damage.
    pub(super) fn friction_at(&self, damage: f64) -> f64 {
        // The curve takes an exponential, and most joints do not need it.
        if self.residual == self.friction {
            return self.friction;
        }
        self.residual + (self.friction - self.residual) * softening(damage)
    }

    /// A vector with its part along the joint multiplied by a factor.
    #[inline]
    pub(super) fn scaled(mut vector: [f64; D], factor: f64) -> [f64; D] {
        vector[1..].iter_mut().for_each(|component| *component *= factor);
        vector
    }

    /// The law of a joint that represents a plane at an angle to it: the strengths are those at which that
    /// plane fails, the energies those of its area.
    pub(crate) fn on(&self, JointPlane { excess, area, normal }: JointPlane<D>) -> Self {
        Self {
            normal,
            tensile: self.tensile / excess,
            cohesion: self.cohesion / excess,
            critical: self.critical.map(|length| length * excess * area),
            ..*self
        }
    }

    /// A traction, Pa, below which a whole joint does not soften in any direction. `friction`: the part of
    /// its shear strength that pressure adds, Pa.
    #[inline(always)]
    pub(super) fn least(&self, friction: f64) -> f64 {
        let lower = if self.tensile < self.cohesion { self.tensile } else { self.cohesion };
        if friction > 0.0 { self.least_pressed() + friction } else { lower }
    }

    /// A traction, Pa, that the bond of a whole joint holds in any sliding.
    #[inline(always)]
    pub(crate) fn least_pressed(&self) -> f64 {
        // Sliding along a joint may open a plane at an angle to it.
        let opens = self.normal[0] != 1.0 && self.tensile < self.cohesion;
        if opens { self.tensile } else { self.cohesion }
    }

    /// Traction, Pa, of a whole joint at an opening and sliding from where it has none, m, and whether it
    /// stays whole. There is no branch, so that many joints can be computed side by side.
    #[inline(always)]
    pub(crate) fn of_whole(&self, mut bond: [f64; D]) -> ([f64; D], bool) {
        let opening = bond[0];
        let pressure = self.penalty * if opening < 0.0 { -opening } else { 0.0 };
        bond[0] = if opening > 0.0 { opening } else { 0.0 };
        let least = self.least(self.friction * pressure);
        let holds = self.penalty * self.penalty * dot(bond, bond) <= least * least;
        let mut traction = bond.map(|length| self.penalty * length);
        traction[0] = if pressure == 0.0 { traction[0] } else { -pressure };
        (traction, holds)
    }

    /// Squares of the cosine and of the sine of the angle of a vector to the normal of the plane. `squared`:
    /// the square of its length.
    #[inline(always)]
    pub(super) fn shares(&self, bond: [f64; D], squared: f64) -> [f64; 2] {
        let across = dot(bond, self.normal);
        let aside = minus(bond, self.normal.map(|x| across * x));
        [across * across / squared, dot(aside, aside) / squared]
    }

    /// Strength, Pa, and length beyond the elastic range at which the joint is broken, m, of a vector of
    /// opening and sliding with the squares of the cosine and of the sine of its angle to the normal. There
    /// is no branch.
    #[inline(always)]
    pub(super) fn in_direction(&self, [cosine, sine]: [f64; 2]) -> [f64; 2] {
        let ([tensile, cohesion], [opening, sliding]) = ([self.tensile, self.cohesion], self.critical);
        let strength = tensile * cohesion / (cosine * cohesion * cohesion + sine * tensile * tensile).sqrt();
        let energy = self.energy_towards([cosine, sine]);
        // Pure modes, exactly. A joint without one of its strengths has no other.
        let of = |mixed: f64, opens: f64, slides: f64| {
            let other = if cosine == 0.0 { slides } else { mixed };
            if sine == 0.0 { opens } else { other }
        };
        [of(strength, tensile, cohesion), of(energy / strength, opening, sliding)]
    }

    /// Strength times critical length, N/m, in the same direction.
    #[inline(always)]
    pub(super) fn energy_towards(&self, [cosine, sine]: [f64; 2]) -> f64 {
        let fourth = sine * sine;
        self.tensile * self.critical[0] * cosine.sqrt() + self.cohesion * self.critical[1] * (fourth * fourth)
    }

    /// Whether [`Memory::of_common`](super::Memory::of_common) is its law: it has both strengths, one
    /// stiffness and one friction, and does not dilate.
    pub(crate) fn is_common(&self) -> bool {
        self.tensile > 0.0
            && self.cohesion > 0.0
            && self.shear == 1.0
            && self.residual == self.friction
            && self.dilation == 0.0
    }
}

/// Use of a strength by a traction across a facet and along it: 1 where it fails, and proportional to the
/// traction.
pub(crate) fn use_of<const D: usize>(strength: &Strength, traction: [f64; D]) -> f64 {
    let (normal, tangential) = (traction[0], length(along(traction)));
    if strength.tensile > 0.0 && strength.cohesion > 0.0 {
        return use_of_both([strength.tensile, strength.cohesion], strength.friction, [normal, tangential]);
    }
    // A joint without strength fails without traction as well.
    let share = |traction: f64, strength: f64| match traction {
        traction if strength > 0.0 => traction / strength,
        traction if traction < 0.0 => 0.0,
        _ => f64::INFINITY,
    };
    if normal > 0.0 {
        length([share(normal, strength.tensile), share(tangential, strength.cohesion)])
    } else {
        share(tangential + strength.friction * normal, strength.cohesion).max(0.0)
    }
}

/// The same for a tensile strength and a cohesion above 0 and the magnitude of the traction along the facet.
/// There is no branch, so that many facets can be computed side by side.
#[inline(always)]
pub(crate) fn use_of_both([tensile, cohesion]: [f64; 2], friction: f64, [across, along]: [f64; 2]) -> f64 {
    let tension = length([across / tensile, along / cohesion]);
    let shear = larger((along + friction * across) / cohesion, 0.0);
    if across > 0.0 { tension } else { shear }
}

/// The plane that a joint represents.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(bound(serialize = "[f64; D]: serde::Serialize", deserialize = "[f64; D]: serde::Deserialize<'de>"))]
pub(crate) struct JointPlane<const D: usize = 2> {
    /// Factor by which the strengths of the joint's own plane exceed those of the joint.
    pub(crate) excess: f64,
    /// Area of the projection of the joint on the plane over that of the joint.
    pub(crate) area: f64,
    /// The normal of the plane, of unit length: across the joint and along it.
    pub(crate) normal: [f64; D],
}

wire!([const D: usize] JointPlane<D> { excess, area, normal });

/// The normal of a joint, by its components across the joint and along it.
pub(crate) fn across<const D: usize>() -> [f64; D] {
    std::array::from_fn(|axis| if axis == 0 { 1.0 } else { 0.0 })
}

impl<const D: usize> JointPlane<D> {
    /// The plane of the joint itself.
    pub(crate) fn own() -> Self {
        Self { excess: 1.0, area: 1.0, normal: across() }
    }
}
