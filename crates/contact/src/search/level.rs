//! Elements of similar size.

/// Elements of similar size that are searched on their own cells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Level {
    /// Number of elements.
    pub elements: usize,
    /// The smallest diameter (largest edge of a box) of the elements.
    pub smallest: f64,
    /// The largest diameter (largest edge of a box) of the elements.
    pub largest: f64,
    /// Edge of the cells.
    pub cell_size: f64,
}
