//! The history of one end of a joint, and its traction. Twin of common laws: `crates/gpu/kernels/joints.h`.

use fdem_distributed::wire;

use crate::cohesive::curve::softening;
use crate::cohesive::law::JointLaw;
use crate::lanes::{either, larger, smaller};
use crate::vector::{along, at_most, dot, length, minus};

/// History of one end of a joint. Openings, slidings and tractions are vectors: first across the joint, then
/// along it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(bound(serialize = "[f64; D]: serde::Serialize", deserialize = "[f64; D]: serde::Deserialize<'de>"))]
pub(crate) struct Memory<const D: usize = 2> {
    /// Damage by opening and by sliding; the damage is their sum.
    pub(crate) damages: [f64; 2],
    /// Stiffness of the bond over the penalty: 1 while it is whole.
    pub(crate) stiffness: f64,
    /// Opening and sliding, m, at which the bond has no traction.
    pub(crate) origin: [f64; D],
    /// Sliding, m, at which friction has none.
    pub(crate) rubbed: [f64; D],
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
        let lost = self.lost(law);
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

    /// Traction of any joint.
    fn of_any(&mut self, law: &JointLaw<D>, gap: [f64; D]) -> [f64; D] {
        // Without tensile strength nothing holds while the joint is open.
        let opening = gap[0] - self.origin[0];
        if law.tensile == 0.0 && opening > 0.0 {
            let sliding_alone = law.in_direction([0.0, 1.0]);
            self.soften(law, true, opening / law.critical[0], [1.0, 0.0], sliding_alone);
            self.slide_to(gap);
            self.rubbed = gap;
            return [0.0; D];
        }
        // Without cohesion the bond slides freely.
        if law.cohesion == 0.0 {
            self.slide_to(gap);
        }
        let friction = law.friction_at(self.damage());
        let (begins, _) = self.load(law, gap, friction);
        let (traction, excess) = self.of_bond_and_friction(law, gap, friction, begins);
        if excess != 0.0 {
            let lost = self.lost(law);
            if law.dilation > 0.0 && self.origin[0] < law.dilated {
                let opening = self.origin[0] + law.dilation * excess / lost;
                self.origin[0] = opening.min(law.dilated);
            }
            if law.cohesion == 0.0 {
                let slip = excess / lost;
                let opening_alone = law.in_direction([1.0, 0.0]);
                self.soften(law, true, self.damage() + slip / law.critical[1], [0.0, 1.0], opening_alone);
            }
        }
        traction
    }

    /// Traction of a joint that is [common](JointLaw::is_common). There is no branch, so that many joints can
    /// be computed side by side. `rests`: whether [`rests`](Self::rests) has found that the bond does not
    /// soften; `left`: see there.
    #[inline(always)]
    pub(crate) fn of_common(
        &mut self,
        law: &JointLaw<D>,
        gap: [f64; D],
        rests: bool,
        left: &mut f64,
    ) -> [f64; D] {
        let (whole, holds) = law.of_whole(minus(gap, self.origin));
        let holds = (self.stiffness == 1.0) && holds;
        let rubbed = self.rubbed;
        let begins = if rests {
            false
        } else {
            let begins;
            (begins, *left) = self.load(law, gap, law.friction);
            begins
        };
        let (traction, _) = self.of_bond_and_friction(law, gap, law.friction, begins);
        self.rubbed = chosen(holds, rubbed, self.rubbed);
        chosen(holds, whole, traction)
    }

    /// Whether the bond of a [common](JointLaw::is_common) joint does not soften at this opening and sliding,
    /// m, found with little work; `false` may be wrong. `left`: share of the strength that is left at its
    /// damage, 0 if it is not known.
    ///
    /// A bond with the damage D and the stiffness s softens if its length exceeds `σ/p + D c`, or if `z(D)
    /// σ/(σ + p D c)` is less than s, with σ and c in its direction. Here these are multiplied out.
    #[inline(always)]
    pub(crate) fn rests(&self, law: &JointLaw<D>, gap: [f64; D], left: f64) -> bool {
        const MARGIN: f64 = 1e-9;
        let (bond, pressure) = self.bond(law, gap);
        let squared = dot(bond, bond);
        let whole = self.stiffness == 1.0;
        let elastic = law.penalty * law.penalty * squared;
        let least = law.least(law.friction * pressure);
        let idle = (squared == 0.0) || (self.stiffness == 0.0) || (whole && (elastic <= least * least));
        let [cosine, sine] = law.shares(bond, squared);
        let both = law.tensile * law.tensile * law.cohesion * law.cohesion;
        // (f c/σ)², and p D c/σ times (f c)².
        let over = cosine * law.cohesion * law.cohesion + sine * law.tensile * law.tensile;
        let slope = law.penalty * self.damage();
        let lengthened = slope * law.energy_towards([cosine, sine]) * over;
        let short = elastic * over * both * (1.0 + MARGIN) <= (both + lengthened) * (both + lengthened);
        let soft = left * (1.0 - MARGIN) * both >= self.stiffness * (both + lengthened);
        // In a pure mode the stiffness is usually that of the damage, to the last bit.
        let (opens, slides) = (sine == 0.0, cosine == 0.0);
        let strength = if opens { law.tensile } else { law.cohesion };
        let critical = if opens { law.critical[0] } else { law.critical[1] };
        let secant = strength * left / (strength + law.penalty * self.damage() * critical);
        let soft = soft || ((opens || slides) && (secant >= self.stiffness));
        idle || (!whole && (left > 0.0) && short && soft)
    }

    /// Stiffness of the spring of friction, Pa/m: that which the bond has lost.
    #[inline(always)]
    fn lost(&self, law: &JointLaw<D>) -> f64 {
        if law.cohesion == 0.0 { law.penalty } else { law.penalty - law.penalty * self.stiffness }
    }

    /// The part of opening and sliding that the bond holds, m, and the pressure, Pa.
    #[inline(always)]
    fn bond(&self, law: &JointLaw<D>, gap: [f64; D]) -> ([f64; D], f64) {
        let mut bond = minus(gap, self.origin);
        let opening = bond[0];
        bond[0] = larger(opening, 0.0);
        (bond, law.penalty * larger(-opening, 0.0))
    }

    /// Traction of the bond, of pressure and of the spring of friction, and how much longer the traction of
    /// this spring would be if the sides did not slip, Pa. `friction`: its coefficient; `begins`: whether the
    /// bond has begun to soften. There is no branch.
    #[inline(always)]
    fn of_bond_and_friction(
        &mut self,
        law: &JointLaw<D>,
        gap: [f64; D],
        friction: f64,
        begins: bool,
    ) -> ([f64; D], f64) {
        let (bond, pressure) = self.bond(law, gap);
        let friction = friction * pressure;
        let rubbed = chosen(begins, self.origin, self.rubbed);
        let stiffness = law.penalty * self.stiffness;
        let mut traction = bond.map(|length| stiffness * length);
        let lost = self.lost(law);
        let trial = along(minus(gap, rubbed)).map(|sliding| lost * sliding);
        let held = at_most(trial, friction);
        let mut slips = false;
        for axis in 1..D {
            slips |= held[axis] != trial[axis];
        }
        let (open, slips) = (pressure == 0.0, slips && pressure != 0.0);
        let slid = std::array::from_fn(|axis| gap[axis] - held[axis] / lost);
        self.rubbed = chosen(open, gap, chosen(slips, slid, rubbed));
        for axis in 1..D {
            traction[axis] = if open { traction[axis] } else { traction[axis] + held[axis] };
        }
        traction[0] = if open { traction[0] } else { -pressure };
        let excess = length(minus(trial, held));
        (traction, if slips { excess } else { 0.0 })
    }

    /// Moves the origin of sliding to where the sides of the joint are.
    fn slide_to(&mut self, gap: [f64; D]) {
        let opening = self.origin[0];
        self.origin = gap;
        self.origin[0] = opening;
    }

    /// Loads the bond. Returns whether it begins to soften, and `left` of [`rests`](Self::rests). `friction`:
    /// its coefficient, which adds to the shear strength of a whole joint under pressure. There is no branch.
    #[inline(always)]
    fn load(&mut self, law: &JointLaw<D>, gap: [f64; D], friction: f64) -> (bool, f64) {
        let (bond, pressure) = self.bond(law, gap);
        let friction = friction * pressure;
        let squared = dot(bond, bond);
        let whole = self.stiffness == 1.0;
        let elastic = law.penalty * law.penalty * squared;
        let least = law.least(friction);
        let squares = law.shares(bond, squared);
        let [strength, critical] = law.in_direction(squares);
        // Pressure adds friction to a whole joint, in whichever direction of its plane it slides.
        let held = strength + friction;
        let rests = (squared == 0.0)
            || (self.stiffness == 0.0)
            || (whole && (elastic <= least * least))
            || (whole && (friction > 0.0) && (elastic <= held * held));
        let damage = (squared.sqrt() - strength / law.penalty) / critical;
        let left = self.soften(law, !rests, damage, squares, [strength, critical]);
        (whole && (self.stiffness < 1.0), left)
    }

    /// Raises the damage to `damage`, with these shares of opening and of sliding, and lowers the stiffness
    /// to that of the damage in the direction in which the bond has this strength, Pa, and this critical
    /// length, m. A stiffness that fell more in another direction does not rise again. Nothing happens unless
    /// the bond `loads`. Returns `left` of [`rests`](Self::rests).
    #[inline(always)]
    fn soften(
        &mut self,
        law: &JointLaw<D>,
        loads: bool,
        damage: f64,
        shares: [f64; 2],
        [strength, critical]: [f64; 2],
    ) -> f64 {
        let (before, damage) = (self.damage(), smaller(damage, 1.0));
        let grows = loads && (damage > before);
        for (part, share) in self.damages.iter_mut().zip(shares) {
            *part += if grows { (damage - before) * share } else { 0.0 };
        }
        let damage = larger(damage, before);
        let left = softening(damage);
        let secant = strength * left / (strength + law.penalty * damage * critical);
        let secant = if loads && (damage > 0.0) { secant } else { 1.0 };
        self.stiffness = smaller(secant, self.stiffness);
        // The parts of the damage need not add up to it to the last bit.
        if self.damage() == damage { left } else { 0.0 }
    }
}

/// One vector or the other. By a mask: the compiler makes no vectors of a choice between two arrays.
#[inline(always)]
fn chosen<const D: usize>(first: bool, one: [f64; D], other: [f64; D]) -> [f64; D] {
    let mask = if first { u64::MAX } else { 0 };
    std::array::from_fn(|axis| either(mask, one[axis], other[axis]))
}
