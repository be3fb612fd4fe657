//! The input of the values of fields: a snapshot of either dimension, and the forces at its instant.

use std::sync::OnceLock;

use fdem_simulation::grains::SphereColumns;
use fdem_simulation::{ContactForce, Crack, Element, Forces, Mode, Snapshot, WetJoint};

use crate::arrays::each;
use crate::fields::liquid::LiquidIn;
use crate::fields::place::Place;
use crate::fields::sphere_counts::coordination;

/// A snapshot, as the table of fields reads it. Vectors of the plane have a third component of 0. Numbers of
/// nodes, elements and so on are below [`State::count`].
pub(crate) trait State {
    /// Number of nodes, elements, joints and so on.
    fn count(&self, place: Place) -> usize;

    /// Displacement of a node, m.
    fn displacement(&self, node: usize) -> [f64; 3];
    /// Velocity of a node, m/s.
    fn velocity(&self, node: usize) -> [f64; 3];
    /// Force of all boundaries on a node, N.
    fn reaction(&self, node: usize) -> [f64; 3];
    /// Pressure of the liquid in pores at a node, Pa; not a number without pores there.
    fn pore_pressure(&self, node: usize) -> f64;

    /// Nodes of an element.
    fn corners(&self, element: usize) -> &[u32];
    /// Cauchy stress of an element, `[xx, yy, zz, xy, yz, xz]` in Pa, tension positive.
    fn stress(&self, element: usize) -> &[f64; 6];
    /// Largest and smallest principal stress of an element, Pa: of those in the plane, in two dimensions.
    fn principal_stresses(&self, element: usize) -> [f64; 2];
    /// Exposure of an element: 1 where its stress reaches the strength of its material; `None` if that has
    /// none.
    fn exposure(&self, element: usize) -> Option<f64>;
    /// Largest damage of the joints of an element.
    fn damage(&self, element: usize) -> f64;
    /// Body of an element.
    fn body(&self, element: usize) -> u32;
    /// Material of an element.
    fn material(&self, element: usize) -> u32;
    /// Fragment of an element.
    fn fragment(&self, element: usize) -> u32;

    /// A joint.
    fn joint(&self, joint: usize) -> JointValues;

    /// Largest pressure of the fluid in the joints of an element, Pa; not a number without fluid there.
    fn fluid_pressure(&self, element: usize) -> f64;
    /// Whether the model has a liquid.
    fn has_liquid(&self, liquid: LiquidIn) -> bool;
    /// The fluid in a joint; `None` if fluid cannot enter it.
    fn wet_joint(&self, joint: usize) -> Option<&WetJoint>;

    /// Elements on both sides of a contact.
    fn contact_elements(&self, contact: usize) -> [u32; 2];
    /// Force of a contact on its first element, N.
    fn contact_force(&self, contact: usize) -> [f64; 3];
    /// Magnitudes of the normal and of the tangential part of that force, N.
    fn contact_sizes(&self, contact: usize) -> [f64; 2];

    /// The spheres and the walls.
    fn spheres(&self) -> &SphereColumns;
    /// Number of contacts of a sphere.
    fn coordination(&self, sphere: usize) -> u32;
}

/// A joint that softens or is broken: a [`Crack`] without its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointValues {
    pub(crate) elements: [u32; 2],
    pub(crate) damage: f64,
    pub(crate) mode: Mode,
    /// Mean opening, m.
    pub(crate) opening: f64,
    /// Mean sliding, m.
    pub(crate) sliding: f64,
    /// Time of failure, s; `None` while the joint holds.
    pub(crate) time: Option<f64>,
    /// Length, m, or area, m².
    pub(crate) measure: f64,
    /// Whether it is of a joint set that is open from the start.
    pub(crate) open_from_start: bool,
}

/// The joints that a file has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointState {
    /// They are broken, or open from the start.
    Broken,
    /// They soften and hold.
    Damaged,
    /// They are whole.
    Intact,
}

/// A snapshot and the forces at its instant.
pub(crate) struct Instant<'a, const D: usize, const N: usize> {
    snapshot: &'a Snapshot<D, N>,
    joints: Vec<&'a Crack<D>>,
    contacts: &'a [ContactForce<D>],
    /// Forces of boundaries on nodes; empty where all are 0.
    reactions: &'a [[f64; D]],
    /// Pressure of the fluid at each element, once it is needed.
    fluid_pressures: OnceLock<Vec<f64>>,
    /// Numbers of contacts of the spheres, once they are needed.
    coordination: OnceLock<Vec<u32>>,
}

impl<'a, const D: usize, const N: usize> Instant<'a, D, N> {
    /// A snapshot without forces.
    pub(crate) fn of(snapshot: &'a Snapshot<D, N>) -> Self {
        Self {
            snapshot,
            joints: snapshot.cracks.iter().collect(),
            contacts: &[],
            reactions: &[],
            fluid_pressures: OnceLock::new(),
            coordination: OnceLock::new(),
        }
    }

    /// The same with the forces at its instant.
    pub(crate) fn with_forces(self, forces: &'a Forces<D>) -> Self {
        Self { contacts: &forces.contacts, reactions: &forces.reactions, ..self }
    }

    /// The same with the joints in this state alone.
    pub(crate) fn with_joints(self, state: JointState) -> Self {
        let cracks = &self.snapshot.cracks;
        let joints = match state {
            JointState::Broken => cracks.iter().filter(|crack| crack.time.is_some()).collect(),
            JointState::Damaged => cracks.iter().filter(|crack| crack.time.is_none()).collect(),
            JointState::Intact => self.snapshot.intact.iter().flatten().collect(),
        };
        Self { joints, ..self }
    }

    /// Returns its joints.
    pub(crate) fn joints(&self) -> &[&'a Crack<D>] {
        &self.joints
    }
}

impl<const D: usize, const N: usize> State for Instant<'_, D, N>
where
    [[f64; D]; N]: Element<D, N>,
{
    fn count(&self, place: Place) -> usize {
        match place {
            Place::Node => self.snapshot.positions.len(),
            Place::Element => self.snapshot.elements.len(),
            Place::Joint => self.joints.len(),
            Place::Contact => self.contacts.len(),
            Place::Sphere => self.snapshot.spheres.positions.len(),
            Place::SphereContact => self.snapshot.spheres.contacts.len(),
            Place::Wall => self.snapshot.spheres.walls.len(),
        }
    }

    fn displacement(&self, node: usize) -> [f64; 3] {
        in_space(self.snapshot.displacements[node])
    }

    fn velocity(&self, node: usize) -> [f64; 3] {
        in_space(self.snapshot.velocities[node])
    }

    fn reaction(&self, node: usize) -> [f64; 3] {
        self.reactions.get(node).map_or([0.0; 3], |&force| in_space(force))
    }

    fn pore_pressure(&self, node: usize) -> f64 {
        let all = self.snapshot.pore_pressures.as_ref();
        all.and_then(|all| *all.get(node)?).unwrap_or(f64::NAN)
    }

    fn corners(&self, element: usize) -> &[u32] {
        &self.snapshot.elements[element]
    }

    fn stress(&self, element: usize) -> &[f64; 6] {
        &self.snapshot.stresses[element]
    }

    fn principal_stresses(&self, element: usize) -> [f64; 2] {
        self.snapshot.principal_stresses(element)
    }

    fn exposure(&self, element: usize) -> Option<f64> {
        self.snapshot.exposure(element)
    }

    fn damage(&self, element: usize) -> f64 {
        self.snapshot.damage[element]
    }

    fn body(&self, element: usize) -> u32 {
        self.snapshot.bodies[element]
    }

    fn material(&self, element: usize) -> u32 {
        self.snapshot.materials[element]
    }

    fn fragment(&self, element: usize) -> u32 {
        self.snapshot.fragments[element]
    }

    fn joint(&self, joint: usize) -> JointValues {
        let &Crack { elements, damage, mode, opening, sliding, time, measure, open_from_start, .. } =
            self.joints[joint];
        JointValues { elements, damage, mode, opening, sliding, time, measure, open_from_start }
    }

    fn fluid_pressure(&self, element: usize) -> f64 {
        let pressures = self.fluid_pressures.get_or_init(|| fluid_pressures(self.snapshot));
        pressures.get(element).copied().unwrap_or(f64::NAN)
    }

    fn has_liquid(&self, liquid: LiquidIn) -> bool {
        match liquid {
            LiquidIn::Cracks => self.snapshot.fluid.is_some(),
            LiquidIn::Pores => self.snapshot.pore_pressures.is_some(),
        }
    }

    fn wet_joint(&self, joint: usize) -> Option<&WetJoint> {
        self.snapshot.wet_joint(self.joints[joint].elements)
    }

    fn contact_elements(&self, contact: usize) -> [u32; 2] {
        self.contacts[contact].elements
    }

    fn contact_force(&self, contact: usize) -> [f64; 3] {
        in_space(self.contacts[contact].force())
    }

    fn contact_sizes(&self, contact: usize) -> [f64; 2] {
        let ContactForce { normal, tangential, .. } = self.contacts[contact];
        [size(normal), size(tangential)]
    }

    fn spheres(&self) -> &SphereColumns {
        &self.snapshot.spheres
    }

    fn coordination(&self, sphere: usize) -> u32 {
        self.coordination.get_or_init(|| coordination(&self.snapshot.spheres))[sphere]
    }
}

/// Returns the largest pressure of the fluid at each element, Pa; not a number where there is none. Empty
/// without a fluid.
fn fluid_pressures<const D: usize, const N: usize>(snapshot: &Snapshot<D, N>) -> Vec<f64> {
    let Some(fluid) = &snapshot.fluid else { return Vec::new() };
    let mut pressures = vec![f64::NAN; snapshot.elements.len()];
    for wet in fluid.iter().filter(|wet| wet.saturation > 0.0) {
        for element in wet.elements {
            if let Some(pressure) = pressures.get_mut(element as usize) {
                // The greater of a number and not a number is the number.
                *pressure = pressure.max(wet.pressure);
            }
        }
    }
    pressures
}

/// Returns a vector of the plane or of space with three components.
pub(crate) fn in_space<const D: usize>(vector: [f64; D]) -> [f64; 3] {
    each(|axis| vector.get(axis).copied().unwrap_or(0.0))
}

/// Returns the magnitude of a vector.
fn size<const D: usize>(vector: [f64; D]) -> f64 {
    match vector[..] {
        [x, y] => x.hypot(y),
        _ => vector.iter().map(|x| x * x).sum::<f64>().sqrt(),
    }
}
