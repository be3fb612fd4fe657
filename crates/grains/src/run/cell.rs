//! The box of a run at one time.

#![allow(clippy::inline_always, reason = "what is compiled for vector instructions must be inlined")]

use serde::{Deserialize, Serialize};

use crate::domain::{BoxServo, Domain, Outside};
use crate::vector::{Vector, plus};

/// The motion of the sides of a box by its servo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct BoxMotion {
    /// Logarithms of the lengths over those at the beginning.
    pub(crate) strains: Vector,
    /// 1/s.
    pub(crate) rates: Vector,
    /// Work on the spheres in the second half of the last step, J.
    pub(crate) later: f64,
}

/// A box whose sides grow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RunBox {
    domain: Domain,
    pub(crate) low: Vector,
    /// Lengths of the sides, m.
    pub(crate) lengths: Vector,
    /// The part of the motion of its sides that its servo causes.
    pub(crate) motion: BoxMotion,
    /// Whether the time has come from which its sides have strain rates.
    is_strained: bool,
}

/// The lengths of a box by which its spheres repeat, m: 0 along other axes, along which no half is too far.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Repeats {
    lengths: Vector,
    halves: Vector,
}

impl Repeats {
    /// No sphere repeats.
    pub(crate) const NONE: Self = Self { lengths: [0.0; 3], halves: [f64::INFINITY; 3] };

    /// A vector between two spheres, or the one between the first and the nearest image of the second.
    #[inline]
    pub(crate) fn shortest(&self, apart: Vector) -> Vector {
        let along = |axis: usize| {
            let [back, forth] = [apart[axis] > self.halves[axis], apart[axis] < -self.halves[axis]];
            let length = self.lengths[axis];
            apart[axis] - if back { length } else { 0.0 } + if forth { length } else { 0.0 }
        };
        [along(0), along(1), along(2)]
    }
}

impl RunBox {
    pub(crate) fn new(domain: Domain) -> Self {
        let mut cell = Self {
            domain,
            low: domain.low,
            lengths: [0.0; 3],
            motion: BoxMotion::default(),
            is_strained: false,
        };
        cell.grow(0.0);
        cell
    }

    /// The box at a time, s: its centre stays.
    pub(crate) fn grow(&mut self, time: f64) {
        let Domain { low, high, strain_rates, strain_from, .. } = self.domain;
        self.is_strained = time >= strain_from;
        let strained = (time - strain_from).max(0.0);
        for axis in 0..3 {
            let factor = libm::exp(strain_rates[axis] * strained + self.motion.strains[axis]);
            let (centre, half) = (0.5 * (low[axis] + high[axis]), 0.5 * (high[axis] - low[axis]) * factor);
            (self.low[axis], self.lengths[axis]) = (centre - half, 2.0 * half);
        }
    }

    pub(crate) fn periodic(&self) -> [bool; 3] {
        self.domain.periodic
    }

    pub(crate) fn is_periodic(&self) -> bool {
        self.domain.periodic != [false; 3]
    }

    /// Rates at which the sides grow, 1/s.
    pub(crate) fn rates(&self) -> Vector {
        plus(self.strain_rates(), self.motion.rates)
    }

    /// The rates that it has by itself at this time, 1/s.
    #[inline(always)]
    pub(crate) fn strain_rates(&self) -> Vector {
        if self.is_strained { self.domain.strain_rates } else { [0.0; 3] }
    }

    /// Whether its sides grow or shrink.
    #[inline(always)]
    pub(crate) fn grows(&self) -> bool {
        self.domain.grows()
    }

    pub(crate) fn servo(&self) -> Option<BoxServo> {
        self.domain.servo
    }

    /// The lengths by which spheres repeat.
    pub(crate) fn repeats(&self) -> Repeats {
        let of =
            |axis: usize, other: f64| if self.domain.periodic[axis] { self.lengths[axis] } else { other };
        let half = |axis: usize| 0.5 * of(axis, f64::INFINITY);
        Repeats { lengths: [0, 1, 2].map(|axis| of(axis, 0.0)), halves: [half(0), half(1), half(2)] }
    }

    /// A vector between two spheres, or the one between the first and the nearest image of the second.
    pub(crate) fn shortest(&self, apart: Vector) -> Vector {
        self.repeats().shortest(apart)
    }

    /// A point, moved by a length of the box along each axis that repeats and on which it is outside.
    #[inline(always)]
    pub(crate) fn wrapped(&self, point: Vector) -> Vector {
        let along = |axis: usize| {
            let out = point[axis] - self.low[axis];
            match self.domain.periodic[axis] {
                true if out >= self.lengths[axis] => point[axis] - self.lengths[axis],
                true if out < 0.0 => point[axis] + self.lengths[axis],
                _ => point[axis],
            }
        };
        [along(0), along(1), along(2)]
    }

    /// A point and its images by a length of the box along each axis that repeats.
    pub(crate) fn images(&self, point: Vector) -> impl Iterator<Item = Vector> + use<> {
        let (lengths, repeats) = (self.lengths, self.domain.periodic);
        (0..27).filter_map(move |number: u32| {
            // 0, 1 and 2 stand for none, one back and one forth along an axis.
            let by = [number % 3, number / 3 % 3, number / 9];
            let along = |axis: usize| match by[axis] {
                0 => point[axis],
                1 => point[axis] - lengths[axis],
                _ => point[axis] + lengths[axis],
            };
            let is_image = (0..3).all(|axis| by[axis] == 0 || repeats[axis]);
            is_image.then(|| [along(0), along(1), along(2)])
        })
    }

    /// Velocity with which the box moves a point along, m/s.
    #[inline(always)]
    pub(crate) fn drift(&self, point: Vector) -> Vector {
        let rates = self.rates();
        let along = |axis: usize| rates[axis] * (point[axis] - self.low[axis] - 0.5 * self.lengths[axis]);
        [along(0), along(1), along(2)]
    }

    /// The fate of a sphere at this point, if it is outside along an axis that does not repeat.
    #[inline(always)]
    pub(crate) fn outside(&self, point: Vector) -> Option<Outside> {
        let is_out = |axis: usize| {
            let out = point[axis] - self.low[axis];
            !self.domain.periodic[axis] && !(0.0..=self.lengths[axis]).contains(&out)
        };
        (is_out(0) || is_out(1) || is_out(2)).then_some(self.domain.outside)
    }
}
