//! The depth of contacts.

use serde::{Deserialize, Serialize};

use crate::run::balls::Ball;

/// An overlap over the radius of a sphere, and that sphere. Of two spheres the smaller one has the larger
/// share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Depth {
    pub(crate) share: f64,
    pub(crate) sphere: u32,
}

impl Depth {
    /// An overlap of a sphere, m.
    #[inline]
    pub(crate) fn of(overlap: f64, ball: &Ball) -> Self {
        Self { share: overlap / ball.radius, sphere: ball.number }
    }

    /// The deeper of two overlaps; of equal ones that of the lower number.
    #[inline]
    pub(crate) fn or(self, other: Self) -> Self {
        let is_other = (other.share, self.sphere) > (self.share, other.sphere);
        if is_other { other } else { self }
    }
}
