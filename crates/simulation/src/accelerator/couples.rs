//! Couples of elements on a device, and their contacts.

use crate::accelerator::device_sum::DeviceSum;

/// Couples of elements that may touch, as far as a device does not change them.
#[derive(Clone, Debug, Default)]
pub struct CoupleColumns {
    /// The elements of each, the lower number first; ascending.
    pub elements: Vec<[u32; 2]>,
    /// The law of each.
    pub laws: Vec<FlatContact>,
    /// Whether each may begin to touch.
    pub may_begin: Vec<bool>,
    /// Whether forces begin at zero with the present overlap of each, because a joint between its elements
    /// has lost its hold without pressing them apart.
    pub credits: Vec<bool>,
}

/// The law of a contact between two elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatContact {
    /// Penalty times thickness: N/m in two dimensions, Pa in three.
    pub penalty: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Tangential stiffness, in the unit of the penalty.
    pub tangential: f64,
    /// Share of critical damping.
    pub damping: f64,
    /// Mean masses of the nodes of the elements, kg.
    pub masses: [f64; 2],
    /// Length by which a penalty becomes a stiffness, m; 1 in two dimensions.
    pub length: f64,
    /// Share of the forces that acts, while a joint between the two elements carries the rest.
    pub weight: f64,
    /// Increase of this share in the last step.
    pub fading: f64,
}

/// Values of couples that phases change.
#[derive(Clone, Debug, Default)]
pub struct CoupleStates<const D: usize> {
    /// Whether the elements of each overlap.
    pub touches: Vec<bool>,
    /// The way in which each begins to touch: 0 if all of its overlap counts; otherwise forces begin at zero
    /// with the present overlap, because a joint has broken (1) or bodies overlap at the beginning (2, and 3
    /// where less of that overlap is ignored in each step).
    pub overlaps: Vec<u8>,
    /// Distance, m, that nodes must have travelled since the beginning before each that does not touch can
    /// begin to.
    pub apart_until: Vec<f64>,
    /// The histories of those that touch. All others count nothing.
    pub grips: Vec<FlatGrip<D>>,
}

/// The history of a contact between two elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatGrip<const D: usize> {
    /// Friction on the first element, N.
    pub friction: [f64; D],
    /// Damping on the first element, N.
    pub damping: [f64; D],
    /// Barycentric coordinates, in both elements, of the point where the force acted, without the first.
    pub shares: [[f64; D]; 2],
    /// Initial potential energy, J, that is not counted.
    pub credited_energy: f64,
    /// The way in which it has begun: see [`CoupleStates::overlaps`].
    pub way: u8,
    /// Force on the first element, N.
    pub push: [f64; D],
}

/// Everything that the forces of contacts in a step depend on, besides the couples.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Time step, s.
    pub step: f64,
    /// Upper bound of the distance that nodes have travelled since the beginning, m.
    pub travel: f64,
    /// Ignored energy of an overlap that relaxes over that before the step.
    pub still_ignored: f64,
    /// See [`NodeMotion::grains`](crate::NodeMotion::grains).
    pub grains: [f64; 2],
    /// Whether to sum up the energy.
    pub energy: bool,
}

/// Sums over all couples in a step.
#[derive(Clone, Debug)]
pub struct PressSums {
    /// Works since the last pass, J, with both parts of each rounded number: against friction, and against
    /// damping; energy that appeared because joints handed over to contact, and because less of an overlap is
    /// ignored.
    pub works: [DeviceSum; 4],
    /// The number of couples that touch.
    pub touching: DeviceSum,
    /// Energy stored in the contacts, J, if it was asked for.
    pub energy: Option<DeviceSum>,
    /// The place of the first couple in which one element has sunk too deep into the other.
    pub deep: Option<usize>,
}
