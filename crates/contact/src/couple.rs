//! A couple: two elements that touch.

/// Two elements that touch, by their numbers, `i < j`.
///
/// Ordered by `i`, then by `j`. The layout is two `u32` in this order.
#[doc(alias = "pair")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C)]
pub struct Couple {
    /// The smaller number.
    pub i: u32,
    /// The larger number.
    pub j: u32,
}

impl Couple {
    /// The couple of two different elements, in either order.
    #[inline]
    pub fn new(a: u32, b: u32) -> Self {
        debug_assert_ne!(a, b, "an element does not touch itself");
        if a < b { Self { i: a, j: b } } else { Self { i: b, j: a } }
    }
}

/// Two touching elements of two sets, each by its number in its own set.
///
/// Ordered by `i`, then by `j`. The layout is two `u32` in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(C)]
pub struct CrossCouple {
    /// The element of the querying set.
    pub i: u32,
    /// The element of the set in the [`Index`](crate::Index).
    pub j: u32,
}
