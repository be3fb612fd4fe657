//! The labels of an image, and which of its squares are neighbours.

pub(super) mod sealed {
    pub trait Sealed:
        Copy + Default + Ord + std::fmt::Debug + std::hash::Hash + Send + Sync + 'static
    {
        fn bits(self) -> u64;
    }
}

/// The integer types of labels: `u8`, `u16`, `u32`, `u64`, `i32` and `i64`.
pub trait Label: sealed::Sealed + Into<i128> {}

macro_rules! label {
    ($($number:ty)*) => {$(
        impl sealed::Sealed for $number {
            #[inline]
            #[allow(clippy::cast_lossless, reason = "the numbers with a sign wrap")]
            fn bits(self) -> u64 {
                self as u64
            }
        }
        impl Label for $number {}
    )*};
}
label!(u8 u16 u32 u64 i32 i64);

/// Rule by which grid squares are neighbours. Each rule includes the ones before it.
#[doc(alias = "connectivity")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Neighbourhood {
    /// Squares that share a face (a side in 2D): 4 neighbours in 2D, 6 in 3D.
    #[default]
    Face,
    /// Squares that share an edge, in 3D only: 18 neighbours. In 2D squares meet along sides or at corners
    /// only.
    Edge,
    /// Squares that share a vertex (a corner in 2D): 8 neighbours in 2D, 26 in 3D.
    Vertex,
}
