//! The servo of a periodic box: its sides grow or shrink so that the spheres keep up a pressure.

use rayon::prelude::*;

use crate::domain::BoxServo;
use crate::run::balls::Balls;
use crate::run::cell::{BoxMotion, RunBox};
use crate::run::contacts::{CHUNK, Contacts};
use crate::run::laws::Laws;
use crate::vector::{Vector, dot, minus, plus};

/// Share of an error of the pressure that the box removes in a step, if spheres move along with it.
const GAIN: f64 = 0.5;

/// Sums over the contacts of the spheres with each other, along each axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Virial {
    /// Force times distance of the centres, J: pressure times volume.
    pub(crate) work: Vector,
    /// Stiffness times the square of the distance along the axis, as the normal shares it, N m.
    stiffness: Vector,
    /// The same of the dashpots, N m s.
    damping: Vector,
}

impl Virial {
    /// The same with the forces of a law of the caller, J.
    pub(crate) fn and_work(self, work: Vector) -> Self {
        Self { work: plus(self.work, work), ..self }
    }

    fn and(self, other: Self) -> Self {
        Self {
            work: plus(self.work, other.work),
            stiffness: plus(self.stiffness, other.stiffness),
            damping: plus(self.damping, other.damping),
        }
    }
}

/// The virial of the last contacts, added up in the order of the spheres' numbers.
pub(crate) fn virial(balls: &Balls, of: &Contacts, laws: &Laws, cell: &RunBox) -> Virial {
    let of_places: Vec<Virial> = (0..balls.list.len())
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|place| of_sphere(place, balls, of, (laws, cell)))
        .collect();
    let in_order = balls.places.iter().map(|&place| of_places[place as usize]);
    in_order.fold(Virial::default(), Virial::and)
}

/// The part of the contacts of which a sphere is the first.
fn of_sphere(place: usize, balls: &Balls, of: &Contacts, (laws, cell): (&Laws, &RunBox)) -> Virial {
    let mut sum = Virial::default();
    let one = &balls.list[place];
    for entry in of.of(place) {
        let contact = entry.contact();
        let history = of.history(contact);
        if entry.is_second() || history.contact <= 0.0 {
            continue;
        }
        let two = &balls.list[of.couples[contact].places[1] as usize];
        let Ok(law) = laws.of([one.material, two.material]) else { continue };
        let answer = law.answer(&history, one.mass * two.mass / (one.mass + two.mass));
        let apart = cell.shortest(minus(one.position, two.position));
        let square = dot(apart, apart).max(f64::MIN_POSITIVE);
        let force = of.acting[contact].force();
        for axis in 0..3 {
            let arm = apart[axis] * apart[axis];
            let share = arm * arm / square;
            sum.work[axis] += force[axis] * apart[axis];
            sum.stiffness[axis] += answer.stiffness * share;
            sum.damping[axis] += answer.damping * share;
        }
    }
    sum
}

impl BoxServo {
    /// Sets the rates at which the sides of a box grow in the next step, s. `rates`: those of the last step.
    ///
    /// A rate is the one for which springs and dashpots of the contacts change the pressure by the wanted
    /// amount, as that of the servo of a wall: `GAIN V (found - wanted) = K u dt + C (u - u before)`. Without
    /// contacts it is the largest. A side with a rate of its own, 1/s, has no other.
    pub(crate) fn follow(
        &self,
        (motion, own): (&mut BoxMotion, Vector),
        virial: &Virial,
        volume: f64,
        step: f64,
    ) {
        for (axis, own) in own.into_iter().enumerate() {
            let Some(pressure) = self.pressures[axis] else { continue };
            if own != 0.0 {
                motion.rates[axis] = 0.0;
                continue;
            }
            let excess = virial.work[axis] - pressure * volume;
            let change = GAIN * excess + virial.damping[axis] * motion.rates[axis];
            let answer = virial.stiffness[axis] * step + virial.damping[axis];
            let wanted = if change == 0.0 { 0.0 } else { change / answer };
            motion.rates[axis] = wanted.clamp(-self.largest_rate, self.largest_rate);
            motion.strains[axis] += step * motion.rates[axis];
        }
    }
}
