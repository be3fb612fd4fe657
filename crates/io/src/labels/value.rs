//! The types of labels.

use crate::labels::kind::LabelKind;
use crate::npy_header::Scalar;

mod sealed {
    use crate::npy_header::Scalar;

    pub trait Sealed: Sized {
        /// Appends the numbers in `bytes`, which contains only complete ones.
        #[allow(private_interfaces, reason = "sealed: nobody else calls it")]
        fn extend(into: &mut Vec<Self>, bytes: &[u8], scalar: &Scalar);
    }
}

/// A type that labels can be read as: `u8`, `u16`, `u32`, `u64`, `i32` or `i64`.
pub trait LabelValue: sealed::Sealed + Copy {
    /// The kind of labels.
    const KIND: LabelKind;
}

macro_rules! value {
    ($type:ty, $kind:ident, $($size:literal: $read:ty),*) => {
        impl LabelValue for $type {
            const KIND: LabelKind = LabelKind::$kind;
        }
        impl sealed::Sealed for $type {
            #[allow(private_interfaces, reason = "sealed: nobody else calls it")]
            fn extend(into: &mut Vec<Self>, bytes: &[u8], scalar: &Scalar) {
                match (scalar.size, scalar.big_endian) {
                    $(
                        ($size, false) => append(into, bytes, |bytes| <$read>::from_le_bytes(bytes).into()),
                        ($size, true) => append(into, bytes, |bytes| <$read>::from_be_bytes(bytes).into()),
                    )*
                    // `kind_of` returns no others.
                    _ => {}
                }
            }
        }
    };
}
value!(u8, U8, 1: u8);
value!(u16, U16, 2: u16);
value!(u32, U32, 4: u32);
value!(u64, U64, 8: u64);
value!(i32, I32, 1: i8, 2: i16, 4: i32);
value!(i64, I64, 8: i64);

fn append<L, const N: usize>(into: &mut Vec<L>, bytes: &[u8], number: impl Fn([u8; N]) -> L) {
    into.extend(bytes.as_chunks::<N>().0.iter().map(|bytes| number(*bytes)));
}
