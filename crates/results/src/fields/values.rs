//! The values of a quantity in a snapshot, for programs.

use fdem_simulation::{Element, Forces, Snapshot};

use crate::fields::quantity::{Quantity, QuantityValues};
use crate::fields::state::Instant;
use crate::run::snapshot::{SnapshotError, checked, checked_contacts, checked_reactions};

impl Quantity {
    /// Returns the values of all nodes, elements, joints or contacts of a snapshot.
    ///
    /// # Shapes
    /// [`Quantity::width`] numbers for each of them, in the order of the snapshot or of the forces. Without
    /// reactions in `forces`, those of all nodes are 0.
    ///
    /// # Errors
    /// [`SnapshotError`] if the snapshot or the forces contradict themselves.
    ///
    /// # Example
    /// ```
    /// use fdem_results::{Field, QuantityValues};
    /// use fdem_simulation::{Forces, Snapshot};
    ///
    /// let snapshot = Snapshot {
    ///     positions: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
    ///     displacements: vec![[0.0; 2]; 3],
    ///     velocities: vec![[0.0; 2]; 3],
    ///     elements: vec![[0, 1, 2]],
    ///     stresses: vec![[-7e6, 0.0, 0.0, 0.0, 0.0, 0.0]],
    ///     damage: vec![0.0],
    ///     bodies: vec![0],
    ///     materials: vec![0],
    ///     fragments: vec![0],
    ///     ..Snapshot::default()
    /// };
    /// let values = Field::VON_MISES.quantity().values_of(&snapshot, &Forces::default())?;
    /// assert_eq!(values, QuantityValues::Real(vec![7e6]));
    /// # Ok::<(), fdem_results::SnapshotError>(())
    /// ```
    pub fn values_of<const D: usize, const N: usize>(
        &self,
        snapshot: &Snapshot<D, N>,
        forces: &Forces<D>,
    ) -> Result<QuantityValues, SnapshotError>
    where
        [[f64; D]; N]: Element<D, N>,
    {
        checked(snapshot)?;
        checked_reactions(snapshot, forces)?;
        checked_contacts(snapshot, forces)?;
        Ok(self.values(&Instant::of(snapshot).with_forces(forces)))
    }
}
