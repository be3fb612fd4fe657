//! The types of labels.

use crate::npy_header::Scalar;

/// The type of the labels of an image: the [`LabelValue`](crate::LabelValue) to read them as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabelKind {
    /// `u8`.
    U8,
    /// `u16`.
    U16,
    /// `u32`.
    U32,
    /// `u64`.
    U64,
    /// `i32`; shorter signed numbers are widened to it.
    I32,
    /// `i64`.
    I64,
}

/// The type of labels for numbers of this dtype, if they can be labels.
pub(super) fn kind_of(scalar: &Scalar) -> Option<LabelKind> {
    Some(match (scalar.kind, scalar.size) {
        ('u', 1) => LabelKind::U8,
        ('u', 2) => LabelKind::U16,
        ('u', 4) => LabelKind::U32,
        ('u', 8) => LabelKind::U64,
        ('i', 1 | 2 | 4) => LabelKind::I32,
        ('i', 8) => LabelKind::I64,
        _ => return None,
    })
}
