//! Things that can touch each other.
//!
//! Bodies of one kind have numbered *parts*, between which contacts act: the elements of bodies that deform
//! are one kind (`bodies/elements.rs`). A kind implements [`Bodies`]. The parts of two kinds that touch, and
//! their forces, are a pair of kinds: `contacts/pair.rs`. The motion of a kind is `motion.rs`.

pub(crate) mod elements;

use crate::vector::Point;

/// The bodies of one kind.
pub(crate) trait Bodies<const D: usize>: Sync {
    /// A place on a part, which moves with it: barycentric coordinates in an element.
    type Place;

    /// The box around a part: its least and its largest coordinates, m.
    fn bounds(&self, part: u32) -> [Point<D>; 2];

    /// Velocity of a part at a place on it, m/s.
    fn velocity_on(&self, part: u32, place: &Self::Place) -> Point<D>;

    /// Properties of a part that its contacts depend on.
    fn properties(&self, part: u32) -> PartProperties;

    /// Whether this rank computes the forces on a part: it moves all of the part, or some of it.
    fn acts(&self, part: u32) -> bool;

    /// Whether this rank counts a part, and the couples of which it is the first part.
    fn counts(&self, part: u32) -> bool;
}

/// Properties of a part that its contacts depend on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartProperties {
    /// Its material: the law of a contact, with its penalty in Pa, is that of two materials.
    pub(crate) material: u32,
    /// Length by which a penalty becomes a stiffness, m: 1 in two dimensions, where the penalty is in N/m.
    pub(crate) length: f64,
    /// Mass that a force on it accelerates, kg.
    pub(crate) mass: f64,
}
