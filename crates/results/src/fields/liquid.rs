//! Liquids that a model may have, and fields that it then has.

/// The place of a liquid that a model may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiquidIn {
    /// A fluid in cracks and holes.
    Cracks,
    /// A liquid in the pores of elements.
    Pores,
}
