//! Checks that the arrays of a snapshot agree with each other.

use std::fmt;
use std::io;

use fdem_simulation::{Forces, Snapshot};

/// A snapshot that contradicts itself.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SnapshotError {
    /// The number of entries of an array is not that of the nodes or elements.
    Length {
        /// Name of the array.
        name: &'static str,
        /// Number of its entries.
        found: usize,
        /// Number of entries that it should have.
        expected: usize,
    },
    /// An element has a node that does not exist.
    Node {
        /// The element.
        element: usize,
        /// The node.
        node: u32,
        /// Number of nodes.
        nodes: usize,
    },
    /// An element has a material that does not exist.
    Material {
        /// The element.
        element: usize,
        /// The material.
        material: u32,
        /// Number of materials.
        materials: usize,
    },
    /// A contact has an element that does not exist.
    Contact {
        /// The element.
        element: u32,
        /// Number of elements.
        elements: usize,
    },
    /// A contact of spheres has a sphere or a wall that does not exist.
    Grain {
        /// `sphere` or `wall`.
        what: &'static str,
        /// Number of that sphere or wall.
        number: u32,
        /// Number of spheres or walls.
        most: usize,
    },
    /// A crack is between elements that have no facet in common.
    Crack {
        /// The elements.
        elements: [u32; 2],
    },
}

impl fmt::Display for SnapshotError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { name, found, expected } => {
                write!(out, "the snapshot has {found} {name}, where {expected} are needed")
            }
            Self::Node { element, node, nodes } => {
                write!(out, "element {element} of the snapshot has node {node}, but there are {nodes}")
            }
            Self::Material { element, material, materials } => {
                write!(out, "element {element} has material {material}, but there are {materials}")
            }
            Self::Contact { element, elements } => {
                write!(out, "a contact has element {element}, but there are {elements}")
            }
            Self::Grain { what, number, most } => {
                write!(out, "a contact has {what} {number}, but there are {most}")
            }
            Self::Crack { elements: [one, other] } => {
                write!(out, "a crack is between elements {one} and {other}, which have no facet in common")
            }
        }
    }
}

impl std::error::Error for SnapshotError {}

impl From<SnapshotError> for io::Error {
    fn from(error: SnapshotError) -> Self {
        Self::new(io::ErrorKind::InvalidInput, error)
    }
}

/// Checks that every array has its length and that every node exists.
pub(crate) fn checked<const D: usize, const N: usize>(
    snapshot: &Snapshot<D, N>,
) -> Result<(), SnapshotError> {
    let (nodes, elements) = (snapshot.positions.len(), snapshot.elements.len());
    for (name, found, expected) in [
        ("displacements", snapshot.displacements.len(), nodes),
        ("velocities", snapshot.velocities.len(), nodes),
        ("stresses", snapshot.stresses.len(), elements),
        ("values of damage", snapshot.damage.len(), elements),
        ("bodies", snapshot.bodies.len(), elements),
        ("materials", snapshot.materials.len(), elements),
        ("fragments", snapshot.fragments.len(), elements),
        ("pressures in pores", snapshot.pore_pressures.as_ref().map_or(nodes, Vec::len), nodes),
    ] {
        if found != expected {
            return Err(SnapshotError::Length { name, found, expected });
        }
    }
    for (element, corners) in snapshot.elements.iter().enumerate() {
        if let Some(&node) = corners.iter().find(|&&node| node as usize >= nodes) {
            return Err(SnapshotError::Node { element, node, nodes });
        }
    }
    Ok(())
}

/// Checks that there is a reaction for each node, or none at all.
pub(crate) fn checked_reactions<const D: usize, const N: usize>(
    snapshot: &Snapshot<D, N>,
    forces: &Forces<D>,
) -> Result<(), SnapshotError> {
    let (found, expected) = (forces.reactions.len(), snapshot.positions.len());
    if found != 0 && found != expected {
        return Err(SnapshotError::Length { name: "reactions", found, expected });
    }
    Ok(())
}

/// Checks that the elements of every contact exist.
pub(crate) fn checked_contacts<const D: usize, const N: usize>(
    snapshot: &Snapshot<D, N>,
    forces: &Forces<D>,
) -> Result<(), SnapshotError> {
    let elements = snapshot.elements.len();
    let mut named = forces.contacts.iter().flat_map(|contact| contact.elements);
    match named.find(|&element| element as usize >= elements) {
        Some(element) => Err(SnapshotError::Contact { element, elements }),
        None => Ok(()),
    }
}
