//! The result of the narrow phase.

/// How two bodies touch, or how far they are apart.
///
/// # Shapes
/// `D` is the dimension of the bodies.
///
/// # Units
/// `point` has the unit of the coordinates; `normal` has length 1, within 4 rounding steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<const D: usize> {
    /// The contact point. For a touch it is a point of the overlap; for a gap, the middle between the closest
    /// points. For planes and triangles of a wall, it is the point of the wall closest to the centre. Each
    /// function documents its choice.
    pub point: [f64; D],
    /// Unit vector from the first body to the second: moving the second body along it separates the two.
    pub normal: [f64; D],
    /// The size of the gap or of the overlap.
    pub measure: Measure,
}

impl<const D: usize> Contact<D> {
    /// Whether the bodies have a point in common. The variant of `measure` decides this, not its number.
    #[inline]
    pub fn touches(&self) -> bool {
        !matches!(self.measure, Measure::Gap(_))
    }
}

/// A gap, or the size of an overlap.
///
/// No number is negative, and each may be 0: a gap smaller than its rounding error, or an overlap that is a
/// point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// The bodies have no point in common. The number is the distance between them, in the unit of the
    /// coordinates.
    Gap(f64),
    /// The bodies touch. The number is the distance by which the second must be moved along the normal until
    /// they only just touch, in the unit of the coordinates.
    Depth(f64),
    /// The bodies touch in a segment or a point. The number is its length.
    Length(f64),
    /// The bodies touch in a piece of a plane. The number is its area.
    Area(f64),
    /// The bodies touch. The number is the volume that they have in common.
    Volume(f64),
}

impl Measure {
    /// The number, without its kind.
    #[inline]
    pub fn value(self) -> f64 {
        match self {
            Self::Gap(value)
            | Self::Depth(value)
            | Self::Length(value)
            | Self::Area(value)
            | Self::Volume(value) => value,
        }
    }
}
