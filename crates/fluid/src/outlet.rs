//! The way of fluid from a crack into pores.

/// A wet cell, as the pores at its corners see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outlet<const D: usize> {
    /// Place of the cell in the order of the keys.
    pub(crate) row: usize,
    pub(crate) vertices: [u32; D],
    /// Pressure, Pa.
    pub(crate) pressure: f64,
    /// Volume that it takes for each Pa, m³/Pa, at the reference density.
    pub(crate) capacity: f64,
    /// Volume of its fluid, and volume that is empty, m³ at the reference density.
    pub(crate) held: f64,
    pub(crate) empty: f64,
}

impl<const D: usize> Outlet<D> {
    /// Volume that leaves one of its `corners` for pores with this storage, m³/Pa, and pressure, Pa.
    pub(crate) fn volume(&self, storage: f64, pressure: f64, corners: f64) -> f64 {
        let drop = self.pressure - pressure;
        let capacity = self.capacity / corners;
        let level = drop * storage * (capacity / (capacity + storage));
        if drop > 0.0 {
            return level.min(0.5 * self.held / corners);
        }
        // An empty part fills at the lowest pressure.
        level + (drop * storage - level).max(-self.empty / corners)
    }
}
