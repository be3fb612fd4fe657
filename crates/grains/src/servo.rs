//! Walls that keep up a force.

use serde::{Deserialize, Serialize};

use crate::vector::{Vector, dot, length, times};

/// A wall that moves along a direction so that it presses on the spheres with a force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Servo {
    /// Direction in which the wall presses, of any length but 0.
    pub direction: [f64; 3],
    /// The force with which it presses, N.
    pub force: f64,
    /// The largest speed of the wall, m/s.
    pub speed: f64,
}

/// How a servo has moved its wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ServoMotion {
    /// m, along its direction.
    pub(crate) travel: f64,
    /// m/s.
    pub(crate) velocity: f64,
}

/// Share of an error of the force that the wall removes in a step, if the spheres stay where they are.
const GAIN: f64 = 0.5;

/// How the force on a wall answers to its motion: contacts along the direction of the servo.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Answer {
    /// N/m.
    pub(crate) stiffness: f64,
    /// Of the dashpots, N s/m.
    pub(crate) damping: f64,
}

impl Answer {
    /// Adds a contact whose normal has a cosine with the direction of the servo.
    pub(crate) fn add(&mut self, other: Self, cosine: f64) {
        self.stiffness += cosine * cosine * other.stiffness;
        self.damping += cosine * cosine * other.damping;
    }
}

impl Servo {
    pub(crate) fn unit(&self) -> Vector {
        times(1.0 / length(self.direction), self.direction)
    }

    /// Moves for a step, s, after one with a force of the spheres on the wall, N.
    ///
    /// The velocity `u` is that for which springs and dashpots of the contacts change the force by the wanted
    /// amount: `GAIN (wanted - found) = K u dt + C (u - u before)`. So it is stable for stiff and for loose
    /// spheres, and for strong dashpots.
    pub(crate) fn follow(&self, motion: &mut ServoMotion, force: Vector, of: Answer, step: f64) {
        let missing = self.force + dot(force, self.unit());
        let change = GAIN * missing + of.damping * motion.velocity;
        // Without contacts it is infinite.
        let wanted = if change == 0.0 { 0.0 } else { change / (of.stiffness * step + of.damping) };
        motion.velocity = wanted.clamp(-self.speed, self.speed);
        motion.travel += step * motion.velocity;
    }
}
