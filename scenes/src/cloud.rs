//! The type that most generators return.

/// Discs (`D = 2`) or spheres (`D = 3`) as two plain arrays.
///
/// # Shapes
/// `centres` `[n][D]`, `radii` `[n]`: one entry per element, same order.
///
/// # Units
/// Centres and radii have the same length unit, that of the given radii.
///
/// # Example
/// ```
/// let cloud = fdem_scenes::lattice::<2>(9, 1.0, 0.5)?;
/// assert_eq!((cloud.len(), cloud.centres[8], cloud.radii[8]), (9, [2.0, 2.0], 0.5));
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cloud<const D: usize> {
    /// Centre of each element.
    pub centres: Vec<[f64; D]>,
    /// Radius of each element, positive and finite.
    pub radii: Vec<f64>,
}

impl<const D: usize> Cloud<D> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.radii.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }
}

/// Refuses points without coordinates while compiling.
pub(crate) const fn require_axes<const D: usize>() {
    const { assert!(D > 0, "a scene needs at least one axis") }
}

#[cfg(test)]
mod tests {
    use super::Cloud;

    #[test]
    fn len_counts_elements() {
        assert!(Cloud::<3>::default().is_empty());
        let cloud = Cloud { centres: vec![[0.0, 1.0]; 4], radii: vec![1.0; 4] };
        assert_eq!(cloud.len(), 4);
        assert!(!cloud.is_empty());
    }
}
