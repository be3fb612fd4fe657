//! The box in which spheres are.

use serde::{Deserialize, Serialize};

/// A box, periodic along some axes, with a rule for spheres that leave it along the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Domain {
    /// Its corner with the lowest coordinates at the beginning, m.
    pub low: [f64; 3],
    /// Its corner with the highest coordinates at the beginning, m.
    pub high: [f64; 3],
    /// Along which axes it repeats.
    pub periodic: [bool; 3],
    /// Rates at which its sides grow about its centre, 1/s, relative to their present lengths. The spheres
    /// move along with it.
    pub strain_rates: [f64; 3],
    /// Time from which they grow at these rates, s.
    pub strain_from: f64,
    /// Pressures that it keeps up by growing and shrinking along axes that repeat.
    pub servo: Option<BoxServo>,
    /// The fate of a sphere whose centre leaves the box along an axis that does not repeat.
    pub outside: Outside,
}

impl Domain {
    /// Whether its sides grow or shrink.
    #[inline]
    pub(crate) fn grows(&self) -> bool {
        self.strain_rates != [0.0; 3] || self.servo.is_some()
    }
}

/// Pressures that a periodic box keeps up.
///
/// The pressure along an axis is the sum of force times distance of the centres along it, over all contacts
/// of spheres with each other, over the volume of the box (Love and Weber); motion of the spheres has no part
/// in it. The spheres move along with the box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxServo {
    /// Pa, along the axes that have one; they repeat. Where a side has a strain rate, too, its pressure is
    /// kept up until [`Domain::strain_from`].
    pub pressures: [Option<f64>; 3],
    /// The largest rate at which a side grows or shrinks, 1/s, relative to its length.
    pub largest_rate: f64,
}

/// The fate of a sphere that leaves the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outside {
    /// The run stops with an error that names the sphere.
    #[default]
    Stop,
    /// The sphere is removed.
    Delete,
}
