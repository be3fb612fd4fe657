//! Minkowski norms, and distances along one axis.

/// A Minkowski norm. Distances are compared in a form that takes no root: the sum of the powers, or the
/// largest.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Norm {
    /// The sum of the distances along the axes.
    One,
    /// Euclid's.
    Two,
    /// The largest distance along an axis.
    Max,
    /// The root of this order of the sum of the powers.
    Power(f64),
}

impl Norm {
    /// The norm of order `p`, at least 1.
    pub(crate) fn of(p: f64) -> Option<Self> {
        match p {
            1.0 => Some(Self::One),
            2.0 => Some(Self::Two),
            f64::INFINITY => Some(Self::Max),
            _ if p > 1.0 => Some(Self::Power(p)),
            _ => None,
        }
    }

    /// Distances along the axes, in the form that is compared.
    #[inline]
    pub(crate) fn sum(self, axes: impl Iterator<Item = f64>) -> f64 {
        match self {
            Self::One => axes.fold(0.0, |sum, x| sum + x),
            Self::Two => axes.fold(0.0, |sum, x| sum + x * x),
            Self::Max => axes.fold(0.0, f64::max),
            Self::Power(p) => axes.fold(0.0, |sum, x| sum + x.powf(p)),
        }
    }

    /// A distance, in the form that is compared.
    pub(crate) fn limit(self, distance: f64) -> f64 {
        match self {
            Self::One | Self::Max => distance,
            Self::Two => distance * distance,
            Self::Power(p) => distance.powf(p),
        }
    }

    /// The distance of which `compared` is the form that is compared.
    pub(crate) fn distance(self, compared: f64) -> f64 {
        match self {
            Self::One | Self::Max => compared,
            Self::Two => compared.sqrt(),
            Self::Power(p) => compared.powf(1.0 / p),
        }
    }
}

/// The distance of two coordinates that differ by `difference`, on an axis that repeats after `side`; 0 is an
/// axis that does not.
#[inline]
pub(crate) fn along(difference: f64, side: f64) -> f64 {
    let distance = difference.abs();
    if side > 0.0 && distance > 0.5 * side { side - distance } else { distance }
}

/// The least distance along an axis, for differences `from` one value `to` another.
pub(crate) struct NearSide {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) side: f64,
}

impl NearSide {
    /// Differences are smaller than the side, so that the distance is least at 0 or at an end.
    #[inline]
    pub(crate) fn value(&self) -> f64 {
        if self.from <= 0.0 && 0.0 <= self.to {
            return 0.0;
        }
        along(self.from, self.side).min(along(self.to, self.side))
    }
}

/// The greatest distance along an axis, for differences `from` one value `to` another.
pub(crate) struct Far {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) side: f64,
}

impl Far {
    /// On an axis that repeats the distance is greatest half a side away, or at an end.
    #[inline]
    pub(crate) fn value(&self) -> f64 {
        let half = 0.5 * self.side;
        let spans = |x: f64| self.from <= x && x <= self.to;
        if self.side > 0.0 && (spans(half) || spans(-half)) {
            return half;
        }
        along(self.from, self.side).max(along(self.to, self.side))
    }
}
