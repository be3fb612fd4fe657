//! What the narrow phase answers.

/// How two bodies meet, or how far they are apart.
///
/// # Shapes
/// `D` is the dimension of the bodies.
///
/// # Units
/// `point` has that of the coordinates; `normal` has length 1, within 4 rounding steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact<const D: usize> {
    /// The contact point: of a touch, a point of the overlap; of a gap, the middle between the closest points. Against planes and
    /// triangles of a wall, the point of the wall closest to the centre. Each function says which.
    pub point: [f64; D],
    /// Unit vector from the first body to the second: moving the second along it takes it away.
    pub normal: [f64; D],
    /// The gap, or how much they overlap.
    pub measure: Measure,
}

impl<const D: usize> Contact<D> {
    /// Whether the bodies have a point in common: the variant of `measure` says so, not its number.
    #[inline]
    pub fn touches(&self) -> bool {
        !matches!(self.measure, Measure::Gap(_))
    }
}

/// A gap, or the size of an overlap.
///
/// No number is negative, and each may be 0: a gap that is smaller than its rounding error, an overlap that is a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// The bodies have no point in common; the distance between them, in the unit of the coordinates.
    Gap(f64),
    /// They touch; how far the second has to be moved along the normal until they only just touch, in the unit of the coordinates.
    Depth(f64),
    /// They touch in a segment or a point; its length.
    Length(f64),
    /// They touch in a piece of a plane; its area.
    Area(f64),
    /// They touch; the volume that they have in common.
    Volume(f64),
}

impl Measure {
    /// The number, whatever it measures.
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
