//! Traction-separation law of the joint between two elements.
//!
//! Combined single and smeared crack model (book, ch. 7): elastic up to the strength, then softening by z(D)
//! (7.12). In the book opening and sliding soften separately. Then a joint at an angle to a crack, which
//! opens and slides together, holds more and costs more than one across it, and a crack along the edges of an
//! unstructured mesh costs up to half more than its fracture energy. Here a joint softens as a whole.
//!
//! # The bond
//! A joint that opens has a traction along the vector of its opening `g` and sliding `s`. With ω the angle
//! between that vector and the normal of the plane that the joint represents, its own or one near it
//! (`joints/plane.rs`), its strength and the energy of its unit of area are
//!
//! ```text
//! 1/S² = cos²ω/f_t² + sin²ω/c²,    G = G_I cos ω + G_II sin⁸ω,
//! ```
//! and its traction is S z(D), with D the length of the vector beyond the elastic range over the value at
//! which G is dissipated. For a vector at an angle to the joint the energy is that of the area across the
//! vector: such a joint is a piece of the staircase that represents a crack across the vector. The exponent
//! keeps this up to some 45°; beyond, sliding takes over. A bond unloads towards the origin, and its
//! stiffness only ever falls, so that it dissipates energy on every path.
//!
//! # Pressure
//! In compression only sliding loads the bond, and friction adds to it. A whole joint holds `c + σₙ tan φ`;
//! one that softens has the bond, `z(D) c`, and beside it a spring of friction, at most `σₙ tan φ`, with the
//! stiffness that the bond has lost. Sliding without opening therefore peaks at c + σₙ tan φ and ends at σₙ
//! tan φ. Compression does not break a joint, and a broken joint still transmits pressure and friction.
//!
//! # Joint sets
//! A joint of a set may have a shear stiffness `k_s` other than its normal stiffness `k_n`, and a residual
//! friction. With `r = √(k_s/k_n)`, the law above is that of the sliding `r s` and of the tangential traction
//! `τ/r`, whose product is the same work: with this change of variables the stiffness is `k_n` in all
//! directions, and strengths and energies are as given. The coefficient of friction falls from its peak to
//! the residual one by z(D).
//!
//! # Sources
//! A. Munjiza, The Combined Finite-Discrete Element Method (2004), ch. 7, for the softening; P. P. Camanho,
//! C. G. Dávila, M. F. de Moura, J. Compos. Mater. 37 (2003) 1415-1438, for one damage of a vector with a
//! strength and an energy for each of its directions; G. Alfano, E. Sacco, Int. J. Numer. Meth. Eng. 68
//! (2006) 542-582, for friction beside a bond.

use fdem_distributed::wire;

use crate::lanes::larger;
use crate::model::{CriticalOpening, JointSet, Strength};
use crate::vector::{along, at_most, dot, length, minus};

/// Parameters of the softening curve (7.12), which the book fits to experiments.
const A: f64 = 0.63;
const B: f64 = 1.8;

/// ∫ z dD from 0 to 1.
pub(crate) const AREA: f64 = 0.386_307_294_743_943;

/// Critical opening and sliding of a joint without strength, over its length.
const OPEN: f64 = 1e-6;

/// Share of the strength that is left at damage `d`: 1 at 0, 0 at 1.
pub(crate) fn softening(d: f64) -> f64 {
    // Most joints are whole.
    if d == 0.0 {
        return 1.0;
    }
    let rest = 1.0 - d;
    if rest <= 0.0 {
        return 0.0;
    }
    // (a + c b) / ((a + b)(1 - a - b)) with c = 6.
    let rate = (A + 6.0 * B) / ((A + B) * (1.0 - A - B));
    let factor = 1.0 - (A + B - 1.0) / (A + B) * libm::exp(d * rate);
    let sixth = (rest * rest * rest) * (rest * rest * rest);
    factor * (A * rest + B * sixth)
}

/// Share of the fracture energy that is dissipated at damage `d`: the work until then, less the energy that
/// the bond, which unloads towards its origin, gives back. The elastic range is left out.
pub(crate) fn dissipated_at(d: f64) -> f64 {
    if d <= 0.0 || d >= 1.0 {
        return d.clamp(0.0, 1.0);
    }
    // Simpson's rule: the curve is smooth, and the error below 1e-5.
    let (intervals, width) = (16, d / 16.0);
    let weight = |k: u32| if k == 0 || k == intervals { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
    let sum: f64 = (0..=intervals).map(|k| weight(k) * softening(f64::from(k) * width)).sum();
    (sum * width / 3.0 - 0.5 * d * softening(d)) / AREA
}

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
    fn friction_at(&self, damage: f64) -> f64 {
        // The curve takes an exponential, and most joints do not need it.
        if self.residual == self.friction {
            return self.friction;
        }
        self.residual + (self.friction - self.residual) * softening(damage)
    }

    /// A vector with its part along the joint multiplied by a factor.
    #[inline]
    fn scaled(mut vector: [f64; D], factor: f64) -> [f64; D] {
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
    fn least(&self, friction: f64) -> f64 {
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
    #[inline]
    fn shares(&self, bond: [f64; D], squared: f64) -> [f64; 2] {
        let across = dot(bond, self.normal);
        let aside = minus(bond, self.normal.map(|x| across * x));
        [across * across / squared, dot(aside, aside) / squared]
    }

    /// Strength, Pa, and length beyond the elastic range at which the joint is broken, m, of a vector of
    /// opening and sliding with the squares of the cosine and of the sine of its angle to the normal.
    fn in_direction(&self, [cosine, sine]: [f64; 2]) -> [f64; 2] {
        let ([tensile, cohesion], [opening, sliding]) = ([self.tensile, self.cohesion], self.critical);
        // Pure modes, exactly. A joint without one of its strengths has no other.
        if sine == 0.0 {
            return [tensile, opening];
        }
        if cosine == 0.0 {
            return [cohesion, sliding];
        }
        let fourth = sine * sine;
        let strength = tensile * cohesion / (cosine * cohesion * cohesion + sine * tensile * tensile).sqrt();
        let energy = tensile * opening * cosine.sqrt() + cohesion * sliding * (fourth * fourth);
        [strength, energy / strength]
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

/// History of one end of a joint. Openings, slidings and tractions are vectors: first across the joint, then
/// along it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(bound(serialize = "[f64; D]: serde::Serialize", deserialize = "[f64; D]: serde::Deserialize<'de>"))]
pub(crate) struct Memory<const D: usize = 2> {
    /// Damage by opening and by sliding; the damage is their sum.
    pub(crate) damages: [f64; 2],
    /// Stiffness of the bond over the penalty: 1 while it is whole.
    stiffness: f64,
    /// Opening and sliding, m, at which the bond has no traction.
    origin: [f64; D],
    /// Sliding, m, at which friction has none.
    rubbed: [f64; D],
}

wire!([const D: usize] Memory<D> { damages, stiffness, origin, rubbed });

impl<const D: usize> Default for Memory<D> {
    fn default() -> Self {
        Self { damages: [0.0; 2], stiffness: 1.0, origin: [0.0; D], rubbed: [0.0; D] }
    }
}

impl<const D: usize> Memory<D> {
    /// History of a joint that is inserted where this traction acts: the joint begins with this traction,
    /// limited by its strength.
    pub(crate) fn under(law: &JointLaw<D>, traction: [f64; D]) -> Self {
        let traction = JointLaw::scaled(traction, 1.0 / law.shear);
        let (normal, tangential) = (traction[0], along(traction));
        let mut held = if law.tensile == 0.0 && normal > 0.0 {
            [0.0; D]
        } else if law.cohesion == 0.0 && normal > 0.0 {
            let mut held = [0.0; D];
            held[0] = normal.min(law.tensile);
            held
        } else if normal > 0.0 {
            let squared = dot(traction, traction);
            let squares = law.shares(traction, squared);
            let [strength, _] = law.in_direction(squares);
            let share = (strength / squared.sqrt()).min(1.0);
            traction.map(|x| share * x)
        } else {
            let mut held = at_most(tangential, law.cohesion - law.friction * normal);
            held[0] = normal;
            held
        };
        held = held.map(|traction| -(traction / law.penalty));
        Self { origin: held, rubbed: held, ..Self::default() }
    }

    /// History of a broken joint.
    pub(crate) fn broken() -> Self {
        Self { damages: [1.0, 0.0], stiffness: 0.0, ..Self::default() }
    }

    /// Damage from 0 (whole) to 1 (broken).
    pub(crate) fn damage(&self) -> f64 {
        // The parts need not add up to 1 to the last bit.
        if self.stiffness == 0.0 { 1.0 } else { self.damages[0] + self.damages[1] }
    }

    /// Elastic energy, J/m², before any opening or sliding.
    pub(crate) fn stored(&self, law: &JointLaw<D>) -> f64 {
        0.5 * law.penalty * dot(self.origin, self.origin)
    }

    /// Elastic energy, J/m², at the opening and sliding of the last [`Memory::traction`]: of the bond, of
    /// pressure and of the spring of friction.
    pub(crate) fn elastic(&self, law: &JointLaw<D>, gap: [f64; D]) -> f64 {
        let gap = JointLaw::scaled(gap, law.shear);
        let mut bond = minus(gap, self.origin);
        let opening = bond[0];
        if self.is_whole(law) {
            return 0.5 * law.penalty * dot(bond, bond);
        }
        if law.tensile == 0.0 && opening > 0.0 {
            return 0.0;
        }
        bond[0] = opening.max(0.0);
        let stiffness = law.penalty * self.stiffness;
        let of_bond = 0.5 * stiffness * dot(bond, bond);
        if opening >= 0.0 {
            return of_bond;
        }
        let lost = if law.cohesion == 0.0 { law.penalty } else { law.penalty - stiffness };
        let rubbing = along(minus(gap, self.rubbed));
        of_bond + 0.5 * law.penalty * opening * opening + 0.5 * lost * dot(rubbing, rubbing)
    }

    /// Traction at this opening and sliding, Pa, tension positive. Updates the history.
    #[inline]
    pub(crate) fn traction(&mut self, law: &JointLaw<D>, gap: [f64; D]) -> [f64; D] {
        // Most joints have one stiffness.
        if law.shear != 1.0 {
            let gap = JointLaw::scaled(gap, law.shear);
            return JointLaw::scaled(
                self.of_whole(law, gap).unwrap_or_else(|| self.of_any(law, gap)),
                law.shear,
            );
        }
        self.of_whole(law, gap).unwrap_or_else(|| self.of_any(law, gap))
    }

    /// Traction of a joint that is whole and stays whole, `None` if it may soften. Its bond holds all of the
    /// sliding, so that it has no history: nothing is written.
    #[inline]
    fn of_whole(&self, law: &JointLaw<D>, gap: [f64; D]) -> Option<[f64; D]> {
        if !self.is_whole(law) {
            return None;
        }
        let (traction, holds) = law.of_whole(minus(gap, self.origin));
        holds.then_some(traction)
    }

    /// Whether it has not softened, and [`JointLaw::of_whole`] is its law until it does.
    #[inline]
    pub(crate) fn is_whole(&self, law: &JointLaw<D>) -> bool {
        self.stiffness == 1.0 && law.tensile != 0.0 && law.cohesion != 0.0
    }

    /// Opening and sliding, m, at which the bond has no traction.
    #[inline]
    pub(crate) fn origin(&self) -> [f64; D] {
        self.origin
    }

    /// Traction of any joint.
    fn of_any(&mut self, law: &JointLaw<D>, gap: [f64; D]) -> [f64; D] {
        let opening = gap[0] - self.origin[0];
        // Without tensile strength nothing holds while the joint is open.
        if law.tensile == 0.0 && opening > 0.0 {
            let sliding_alone = law.in_direction([0.0, 1.0]);
            self.soften(law, opening / law.critical[0], [1.0, 0.0], sliding_alone);
            self.slide_to(gap);
            self.rubbed = gap;
            return [0.0; D];
        }
        // Without cohesion the bond slides freely.
        if law.cohesion == 0.0 {
            self.slide_to(gap);
        }
        let pressure = law.penalty * (-opening).max(0.0);
        let friction = law.friction_at(self.damage()) * pressure;
        let mut bond = minus(gap, self.origin);
        bond[0] = opening.max(0.0);
        self.load(law, bond, friction);
        let stiffness = law.penalty * self.stiffness;
        let mut traction = bond.map(|length| stiffness * length);
        if pressure == 0.0 {
            self.rubbed = gap;
            return traction;
        }
        let lost = if law.cohesion == 0.0 { law.penalty } else { law.penalty - stiffness };
        let trial = along(minus(gap, self.rubbed)).map(|sliding| lost * sliding);
        let held = at_most(trial, friction);
        if held != trial {
            self.rubbed = std::array::from_fn(|axis| gap[axis] - held[axis] / lost);
            if law.dilation > 0.0 && self.origin[0] < law.dilated {
                let opening = self.origin[0] + law.dilation * length(minus(trial, held)) / lost;
                self.origin[0] = opening.min(law.dilated);
            }
            if law.cohesion == 0.0 {
                let slip = length(minus(trial, held)) / lost;
                let opening_alone = law.in_direction([1.0, 0.0]);
                self.soften(law, self.damage() + slip / law.critical[1], [0.0, 1.0], opening_alone);
            }
        }
        for axis in 1..D {
            traction[axis] += held[axis];
        }
        traction[0] = -pressure;
        traction
    }

    /// Moves the origin of sliding to where the sides of the joint are.
    fn slide_to(&mut self, gap: [f64; D]) {
        let opening = self.origin[0];
        self.origin = gap;
        self.origin[0] = opening;
    }

    /// Loads the bond by a vector of opening and sliding. `friction`: the part of the shear strength of a
    /// whole joint that pressure adds, Pa.
    #[inline]
    fn load(&mut self, law: &JointLaw<D>, bond: [f64; D], friction: f64) {
        let squared = dot(bond, bond);
        if squared == 0.0 || self.stiffness == 0.0 {
            return;
        }
        let whole = self.stiffness == 1.0;
        let least = law.least(friction);
        if whole && law.penalty * law.penalty * squared <= least * least {
            return;
        }
        let squares = law.shares(bond, squared);
        let [strength, critical] = law.in_direction(squares);
        // Pressure adds friction to a whole joint, in whichever direction of its plane it slides.
        let held = strength + friction;
        if whole && friction > 0.0 && law.penalty * law.penalty * squared <= held * held {
            return;
        }
        let damage = (squared.sqrt() - strength / law.penalty) / critical;
        self.soften(law, damage, squares, [strength, critical]);
        if whole && self.stiffness < 1.0 {
            self.rubbed = self.origin;
        }
    }

    /// Raises the damage to `damage`, with these shares of opening and of sliding, and lowers the stiffness
    /// to that of the damage in the direction in which the bond has this strength, Pa, and this critical
    /// length, m. A stiffness that fell more in another direction does not rise again.
    fn soften(&mut self, law: &JointLaw<D>, damage: f64, shares: [f64; 2], [strength, critical]: [f64; 2]) {
        let (before, damage) = (self.damage(), damage.min(1.0));
        if damage > before {
            for (part, share) in self.damages.iter_mut().zip(shares) {
                *part += (damage - before) * share;
            }
        }
        let damage = damage.max(before);
        if damage > 0.0 {
            let secant = strength * softening(damage) / (strength + law.penalty * damage * critical);
            self.stiffness = self.stiffness.min(secant);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) const ROCK: Strength = Strength {
        tensile: 1e6,
        cohesion: 3e6,
        friction: 0.3,
        energy_i: 10.0,
        energy_ii: 50.0,
        weibull_modulus: None,
        seed: 0,
    };

    fn law(elastic: bool, opening: CriticalOpening) -> JointLaw {
        JointLaw::<2>::new(&ROCK, 1e13, opening, elastic, 1.0).expect("the energies are enough")
    }

    /// Work on a path of openings (`axis` 0) or slidings (`axis` 1), with the other component constant.
    fn work(
        law: &JointLaw,
        memory: &mut Memory<2>,
        axis: usize,
        path: impl Iterator<Item = f64>,
        other: f64,
    ) -> f64 {
        let (mut sum, mut last) = (0.0, None);
        for value in path {
            let (opening, sliding) = if axis == 0 { (value, other) } else { (other, value) };
            let traction = memory.traction(law, [opening, sliding])[axis];
            if let Some((before, at)) = last {
                sum += 0.5 * (before + traction) * (value - at);
            }
            last = Some((traction, value));
        }
        sum
    }

    fn steps(from: f64, to: f64) -> impl Iterator<Item = f64> {
        (0..=100_000).map(move |k| from + (to - from) * f64::from(k) / 100_000.0)
    }

    #[test]
    fn the_curve_and_its_area() {
        assert!((softening(0.0) - 1.0).abs() < 1e-15);
        assert!((softening(0.1) - 0.878).abs() < 5e-4);
        assert!((softening(0.5) - 0.304).abs() < 5e-4);
        assert_eq!(softening(1.0), 0.0);
        let n = 1_000_000;
        let area: f64 = (0..n).map(|k| softening((f64::from(k) + 0.5) / f64::from(n)) / f64::from(n)).sum();
        assert!((area - AREA).abs() < 1e-12, "{area}");
        assert!((1..1000).all(|k| softening(f64::from(k) / 1000.0) < softening(f64::from(k - 1) / 1000.0)));
    }

    #[test]
    fn opening_dissipates_the_fracture_energy() {
        for elastic in [true, false] {
            let law = law(elastic, CriticalOpening::Exact);
            let mut memory =
                if elastic { Memory::<2>::default() } else { Memory::under(&law, [law.tensile, 0.0]) };
            let dissipated = work(&law, &mut memory, 0, steps(0.0, 4e-5), 0.0);
            assert!((dissipated / ROCK.energy_i - 1.0).abs() < 1e-5, "{elastic} {dissipated}");
            assert_eq!(memory.damage(), 1.0);
        }
        let law = law(false, CriticalOpening::Customary);
        let mut memory = Memory::under(&law, [law.tensile, 0.0]);
        let dissipated = work(&law, &mut memory, 0, steps(0.0, 4e-5), 0.0);
        assert!((dissipated / ROCK.energy_i - 3.0 * AREA).abs() < 1e-5);
    }

    #[test]
    fn sliding_peaks_at_cohesion_and_friction_and_ends_at_friction() {
        let law = law(true, CriticalOpening::Exact);
        let (pressure, mut memory) = (2e6, Memory::<2>::default());
        let closing = -pressure / law.penalty;
        let mut peak = 0.0_f64;
        for sliding in steps(0.0, 1e-4) {
            peak = peak.max(memory.traction(&law, [closing, sliding])[1]);
        }
        assert!((peak / (3e6 + 0.3 * pressure) - 1.0).abs() < 1e-3, "{peak}");
        let residual = memory.traction(&law, [closing, 1e-4])[1];
        assert!((residual / (0.3 * pressure) - 1.0).abs() < 1e-9, "{residual}");
        let mut memory = Memory::<2>::default();
        let all = work(&law, &mut memory, 1, steps(0.0, 1e-4), closing);
        // The work of friction and the energy stored at the end do not belong to the crack.
        let friction = 0.3 * pressure * (1e-4 - 0.5 * residual / law.penalty);
        assert!(((all - friction) / ROCK.energy_ii - 1.0).abs() < 5e-3, "{}", all - friction);
    }

    /// Work of a path of vectors of opening and sliding, J/m².
    fn work_along(law: &JointLaw, memory: &mut Memory<2>, path: impl Iterator<Item = [f64; 2]>) -> f64 {
        let (mut sum, mut last) = (0.0, None::<([f64; 2], [f64; 2])>);
        for at in path {
            let traction = memory.traction(law, at);
            if let Some((before, from)) = last {
                sum += (0..2).map(|k| 0.5 * (before[k] + traction[k]) * (at[k] - from[k])).sum::<f64>();
            }
            last = Some((traction, at));
        }
        sum
    }

    /// A joint aslant to a crack that opens straight dissipates the energy of its area across the opening. In
    /// every direction the strength is on the ellipse.
    #[test]
    fn a_vector_aslant_dissipates_the_energy_of_the_area_across_it() {
        let law = law(false, CriticalOpening::Exact);
        for degrees in [0.0_f64, 20.0, 40.0, 80.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let mut memory = Memory::<2>::default();
            let (mut peak, mut all) = (0.0_f64, Vec::new());
            for size in steps(0.0, 6e-5) {
                let [normal, tangential] = memory.traction(&law, [size * cos, size * sin]);
                peak = peak.max((normal / ROCK.tensile).hypot(tangential / ROCK.cohesion));
                all.push([normal, tangential]);
            }
            assert!((peak - 1.0).abs() < 1e-2, "{degrees} {peak}");
            assert!(all.iter().all(|[normal, tangential]| (normal * sin - tangential * cos).abs() < 1e-6));
            let path = steps(0.0, 6e-5).map(|size| [size * cos, size * sin]);
            let dissipated = work_along(&law, &mut Memory::<2>::default(), path);
            let expected = ROCK.energy_i * cos + ROCK.energy_ii * sin.powi(8);
            assert!((dissipated / expected - 1.0).abs() < 1e-2, "{degrees} {dissipated} {expected}");
            assert_eq!(memory.damage(), 1.0);
        }
    }

    /// A joint that represents a plane at 60° to it is loaded by a tension across that plane. It has the
    /// strength of its projection and takes the energy of that, and the whole of its damage is by opening,
    /// although its own sides slide more than they open.
    #[test]
    fn a_joint_of_a_plane_at_an_angle_has_the_law_of_its_projection() {
        let (sin, cos) = 60.0_f64.to_radians().sin_cos();
        let plane = JointPlane { excess: 1.0 / cos, area: cos, normal: [cos, sin] };
        let law = law(false, CriticalOpening::Exact).on(plane);
        let traction = [cos, sin].map(|part| cos * ROCK.tensile * part);
        let mut memory = Memory::under(&law, traction);
        let found = memory.traction(&law, [0.0; 2]);
        assert!((0..2).all(|axis| (found[axis] - traction[axis]).abs() < 1.0), "{found:?}");
        let path = steps(0.0, 6e-5).map(|size| [size * cos, size * sin]);
        let dissipated = work_along(&law, &mut memory, path);
        assert!((dissipated / (ROCK.energy_i * cos) - 1.0).abs() < 1e-3, "{dissipated}");
        let [opening, sliding] = memory.damages;
        assert!(memory.damage() == 1.0 && sliding < 1e-9 * opening, "{:?}", memory.damages);
    }

    /// Sliding under pressure, a whole joint of a plane at an angle holds at least its friction beside its
    /// bond, and softens only beyond.
    #[test]
    fn pressure_adds_friction_to_a_joint_of_any_plane() {
        let (sin, cos) = 50.0_f64.to_radians().sin_cos();
        let plane = JointPlane { excess: 1.0 / cos, area: cos, normal: [cos, sin] };
        let law = law(false, CriticalOpening::Exact).on(plane);
        let (pressure, mut memory) = (2e6, Memory::<2>::default());
        let [strength, _] = law.in_direction([sin * sin, cos * cos]);
        let mut peak = 0.0_f64;
        for sliding in steps(0.0, 1e-6) {
            peak = peak.max(memory.traction(&law, [-pressure / law.penalty, sliding])[1]);
        }
        assert!((peak / (strength + 0.3 * pressure) - 1.0).abs() < 1e-3, "{peak} {strength}");
        assert!(memory.damage() > 0.0);
    }

    /// No path gives energy back that was not put in: the work on any path from the origin and back to no
    /// traction is not negative.
    #[test]
    fn no_path_creates_energy() {
        for (seed, elastic) in (0..200).map(|k| (k, k % 2 == 0)) {
            let law = law(elastic, CriticalOpening::Exact);
            let (sin, cos) = (1.3 * crate::random::uniform(seed, 5000)).sin_cos();
            let aslant = JointPlane { excess: 1.0 / cos, area: cos, normal: [cos, sin] };
            let law = if seed % 3 == 0 { law.on(aslant) } else { law };
            let mut memory = Memory::<2>::default();
            let random = |k: u64| 2.0 * crate::random::uniform(seed, k) - 1.0;
            // From point to point, small and large, opening, closing and sliding both ways.
            let corners: Vec<[f64; 2]> = (0..60)
                .map(|k| {
                    let size = 1e-5 * (0.5 + 0.5 * random(1000 + k)).powi(4);
                    [size * random(2 * k).max(-0.01), size * random(2 * k + 1)]
                })
                .collect();
            let (mut sum, mut least) = (0.0, 0.0_f64);
            let mut from = [0.0; 2];
            for to in corners {
                let part = (0..=2000).map(|k| {
                    let t = f64::from(k) / 2000.0;
                    [0, 1].map(|axis| from[axis] + t * (to[axis] - from[axis]))
                });
                sum += work_along(&law, &mut memory, part);
                least = least.min(sum);
                from = to;
            }
            assert!(least > -1e-6 * ROCK.energy_i, "{seed} {least}");
            assert!(sum > 0.0);
        }
    }

    /// A joint that closed again keeps its cohesion, and the crack faces rub beside it.
    #[test]
    fn friction_acts_beside_what_is_left_of_the_bond() {
        let law = law(false, CriticalOpening::Exact);
        let mut memory = Memory::<2>::default();
        let far = law.tensile / law.penalty + 0.3 * law.critical[0];
        memory.traction(&law, [far, 0.0]);
        let left = softening(memory.damage());
        let (mut peak, closing) = (0.0_f64, -1e6 / law.penalty);
        for sliding in steps(0.0, 1e-4) {
            peak = peak.max(memory.traction(&law, [closing, sliding])[1]);
        }
        let bond = peak - 0.3e6;
        assert!(bond > 0.5 * left * law.cohesion && bond < left * law.cohesion, "{bond} {left}");
        assert_eq!(memory.damage(), 1.0);
        let residual = memory.traction(&law, [closing, 1e-4])[1];
        assert!((residual / 0.3e6 - 1.0).abs() < 1e-9, "{residual}");
    }

    #[test]
    fn the_dissipated_share_is_the_work_of_a_bond_that_opens_and_closes() {
        let law = law(false, CriticalOpening::Exact);
        let stored = 0.5 * law.tensile * law.tensile / law.penalty;
        for share in [0.05, 0.3, 0.7, 1.0] {
            let far = law.tensile / law.penalty + share * law.critical[0];
            let path = steps(0.0, far).chain(steps(far, 0.0)).map(|opening| [opening, 0.0]);
            let mut memory = Memory::<2>::default();
            let lost = work_along(&law, &mut memory, path);
            // Beside the work up to the strength, of which the bond gives back a share.
            let lost = lost - stored * (1.0 - softening(memory.damage()));
            let found = dissipated_at(memory.damage());
            assert!((lost / ROCK.energy_i - found).abs() < 1e-4, "{share}: {lost} {found}");
        }
        assert_eq!([0.0, 1.0].map(dissipated_at), [0.0, 1.0]);
    }

    #[test]
    fn unloading_goes_to_the_origin_and_back() {
        let law = law(true, CriticalOpening::Exact);
        let mut memory = Memory::<2>::default();
        let far = law.tensile / law.penalty + 0.3 * law.critical[0];
        let at_far = memory.traction(&law, [far, 0.0])[0];
        let damage = memory.damage();
        assert!((memory.traction(&law, [far / 2.0, 0.0])[0] / at_far - 0.5).abs() < 1e-12);
        assert_eq!(memory.traction(&law, [0.0, 0.0])[0], 0.0);
        assert_eq!(memory.traction(&law, [-1e-7, 0.0])[0], -1e-7 * law.penalty);
        assert_eq!(memory.traction(&law, [far, 0.0])[0], at_far);
        assert_eq!(memory.damage(), damage);
    }

    #[test]
    fn a_joint_put_in_under_load_begins_with_that_load() {
        let law = law(false, CriticalOpening::Exact);
        for traction in [[1e6, 0.0], [-4e6, 4.2e6], [0.5e6, -2.5e6]] {
            let found = Memory::under(&law, traction).traction(&law, [0.0, 0.0]);
            for axis in 0..2 {
                assert!((found[axis] - traction[axis]).abs() < 1.0, "{traction:?} {found:?}");
            }
        }
    }

    #[test]
    fn an_open_joint_has_friction_and_nothing_else() {
        let open = Strength { tensile: 0.0, cohesion: 0.0, energy_i: 0.0, energy_ii: 0.0, ..ROCK };
        let law =
            JointLaw::<2>::new(&open, 1e13, CriticalOpening::Exact, false, 0.1).expect("needs no energy");
        let mut memory = Memory::under(&law, [0.0; 2]);
        assert_eq!(memory.traction(&law, [1e-5, 1e-5]), [0.0; 2]);
        assert_eq!(memory.damage(), 1.0);
        let [pressure, shear] = memory.traction(&law, [-1e-6, 2e-5]);
        assert_eq!(pressure, -1e7);
        assert!((shear - 0.3e7).abs() < 1e-6, "{shear}");
    }

    /// A joint without tensile strength still has its cohesion, and the other way round. Breaking in one mode
    /// breaks it in both.
    #[test]
    fn one_strength_may_be_zero() {
        let cohesive = Strength { tensile: 0.0, energy_i: 0.0, ..ROCK };
        let law =
            JointLaw::<2>::new(&cohesive, 1e13, CriticalOpening::Exact, false, 0.1).expect("needs no energy");
        let mut memory = Memory::under(&law, [0.0; 2]);
        assert_eq!(memory.traction(&law, [0.0, 2e-7]), [0.0, 2e6]);
        assert_eq!(memory.traction(&law, [1e-7, 2e-7])[0], 0.0);
        assert!(memory.damage() > 0.0);
        memory.traction(&law, [1e-3, 0.0]);
        assert_eq!(memory.damage(), 1.0);
        let tensile = Strength { cohesion: 0.0, energy_ii: 0.0, ..ROCK };
        let law =
            JointLaw::<2>::new(&tensile, 1e13, CriticalOpening::Exact, true, 0.1).expect("needs no energy");
        let mut memory = Memory::<2>::default();
        assert_eq!(memory.traction(&law, [0.5e-7, 0.0]), [0.5e6, 0.0]);
        assert_eq!(memory.traction(&law, [0.5e-7, 1e-8])[1], 0.0);
    }

    #[test]
    fn too_little_fracture_energy_is_refused() {
        let brittle = Strength { energy_i: 0.04, ..ROCK };
        let refused = JointLaw::<2>::new(&brittle, 1e13, CriticalOpening::Exact, true, 1.0);
        assert_eq!(refused, Err(TooLittle { least: 0.05, sliding: false }));
        assert!(JointLaw::<2>::new(&brittle, 1e13, CriticalOpening::Exact, false, 1.0).is_ok());
        let brittle = Strength { energy_ii: 0.4, ..ROCK };
        let refused = JointLaw::<2>::new(&brittle, 1e13, CriticalOpening::Exact, true, 1.0);
        assert_eq!(refused, Err(TooLittle { least: 0.45, sliding: true }));
    }

    /// The mode without a strength has no energy, and is not the one to name.
    #[test]
    fn too_little_energy_is_that_of_the_mode_that_has_a_strength() {
        let of = |strength: Strength| JointLaw::<2>::new(&strength, 1e13, CriticalOpening::Exact, true, 1.0);
        let sliding = Strength { tensile: 0.0, energy_i: 0.0, energy_ii: 0.4, ..ROCK };
        assert_eq!(of(sliding), Err(TooLittle { least: 0.45, sliding: true }));
        let opening = Strength { cohesion: 0.0, energy_ii: 0.0, energy_i: 0.04, ..ROCK };
        assert_eq!(of(opening), Err(TooLittle { least: 0.05, sliding: false }));
    }
}
