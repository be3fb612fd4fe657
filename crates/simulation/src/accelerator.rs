//! A device with a memory of its own that computes phases of a step, such as a graphics processor: the values
//! that it takes, and those that it returns.
//!
//! [`Simulation::put_on`](crate::Simulation::put_on) hands a run over. All columns are plain lists in the
//! order of the numbers of nodes, elements and joints.

mod couples;
mod device_sum;

use std::error::Error;
use std::fmt;

pub use crate::accelerator::couples::{CoupleColumns, CoupleStates, FlatContact, FlatGrip, Press, PressSums};
pub use crate::accelerator::device_sum::{DeviceSum, SUM_PARTS};

/// A result of a device, or the reason why it has failed. After a failure a run cannot continue.
pub type FromDevice<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// A number that stands for none, in lists of numbers of nodes, elements, corners and boundaries.
pub const NO_NUMBER: u32 = u32::MAX;

/// A number in place of [`SolidColumns::places`] of a node that the host moves: one of a rigid body.
pub const BY_HOST: u32 = u32::MAX - 1;

/// Nodes and elements, as far as phases do not change them. Elements have N corners in D dimensions.
#[derive(Clone, Debug)]
pub struct SolidColumns<const D: usize, const N: usize> {
    /// Origin of all positions, in the coordinates of the model, m.
    pub origin: [f64; D],
    /// Mass of each node in its motion, kg.
    pub masses: Vec<f64>,
    /// Mass of each node in its weight, kg; empty where that is its mass in motion.
    pub true_masses: Vec<f64>,
    /// Place of each node in `held`, or [`NO_NUMBER`], or [`BY_HOST`].
    pub places: Vec<u32>,
    /// The nodes that boundaries hold or move, ascending.
    pub held: Vec<HeldNode<D>>,
    /// Nodes of the corners of each element. Corner `N e + k` is the `k`-th of element `e`.
    pub elements: Vec<[u32; N]>,
    /// The corners of all nodes, ascending for each, and where those of each node begin and end among them.
    pub corners: Vec<u32>,
    /// See `corners`.
    pub ranges: Vec<[u32; 2]>,
    /// Inverse of the matrix whose columns are the edges of the undeformed element from corner 0, 1/m.
    pub gradients: Vec<[[f64; D]; D]>,
    /// Volumes of the undeformed elements, m³; 0 for those of rigid bodies, which have no stress and no
    /// forces.
    pub volumes: Vec<f64>,
    /// Moduli of shear and bulk of each material, Pa, of the neo-Hookean law or of its share in that of a
    /// material with bedding.
    pub moduli: Vec<[f64; 2]>,
    /// Bedding of each material; empty if none has any.
    pub beddings: Vec<FlatBedding<D>>,
    /// Material of each element.
    pub materials: Vec<u32>,
    /// Viscosity of each element, Pa s; empty without viscosity.
    pub viscosities: Vec<f64>,
    /// Initial stress of each element (second Piola-Kirchhoff), Pa; empty without initial stress.
    pub initial: Vec<[[f64; D]; D]>,
    /// Energy that the initial stress has stored, J/m³; empty without initial stress.
    pub stored: Vec<f64>,
}

/// The bedding of a material, whose law is the neo-Hookean one and this.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatBedding<const D: usize> {
    /// The rest of the stiffness, Pa: λ, µ, α, κ and β of half of `λ (tr E)² + 2 µ E:E + 2 α (tr E)(n·E n) +
    /// 2 κ |E n|² + β (n·E n)²`, the energy of a strain `E`.
    pub rest: [f64; 5],
    /// Its normal `n` in the undeformed body, of unit length; 0 for a material without bedding.
    pub normal: [f64; D],
}

/// A node that boundaries hold or move, by axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldNode<const D: usize> {
    /// The node.
    pub node: u32,
    /// The ways in which it is held.
    pub kinds: [HoldKind; D],
    /// The boundary that holds it, or [`NO_NUMBER`].
    pub boundaries: [u32; D],
    /// Velocity, m/s, or displacement, m, that the factor of the boundary in time multiplies.
    pub values: [f64; D],
    /// Position at the beginning, m.
    pub start: [f64; D],
}

/// A way in which a node is held along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum HoldKind {
    /// It is free.
    #[default]
    Free = 0,
    /// By a velocity.
    Velocity = 1,
    /// By a displacement.
    Displacement = 2,
    /// By a rotation of its boundary.
    Rotation = 3,
}

/// Values of nodes and elements that phases change.
#[derive(Clone, Debug, Default)]
pub struct SolidState<const D: usize, const N: usize> {
    /// Positions of the nodes relative to the origin, m, and velocities half a step before, m/s.
    pub positions: Vec<[f64; D]>,
    /// See `positions`.
    pub velocities: Vec<[f64; D]>,
    /// Forces on the corners of each element, N.
    pub forces: Vec<[[f64; D]; N]>,
    /// Cauchy stress of each element in the last deformation, Pa. Entries below the diagonal are not used.
    pub stresses: Vec<[[f64; D]; D]>,
    /// Strain energy of each element in the last deformation, J.
    pub energies: Vec<f64>,
    /// Viscous stress of each element (first Piola-Kirchhoff), Pa; empty without viscosity.
    pub viscous: Vec<[[f64; D]; D]>,
    /// Energy that viscosity has dissipated in each element so far, J; empty without viscosity.
    pub dissipated: Vec<f64>,
    /// Present normal of the bedding of each element, of unit length; empty if no material has any.
    pub normals: Vec<[f64; D]>,
}

/// Joints, as far as a device does not change them.
#[derive(Clone, Debug)]
pub struct JointColumns<const D: usize> {
    /// The ways in which joints are computed.
    pub kinds: Vec<JointKind>,
    /// Whether the work of each counts.
    pub counted: Vec<bool>,
    /// Whether each is broken.
    pub broken: Vec<bool>,
    /// Whether each end has two nodes.
    pub open: Vec<[bool; D]>,
    /// Nodes of each end, on side 0 and on side 1.
    pub nodes: Vec<[[u32; 2]; D]>,
    /// The law of each.
    pub laws: Vec<FlatLaw<D>>,
    /// Open ends of joints at each corner, as 2 D × joint + 2 × end + side, or [`NO_NUMBER`]. The force of
    /// the joint counts there after the force of the element, on side 1 with the other sign.
    pub at_corner: Vec<[u32; D]>,
}

/// A way in which a joint is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum JointKind {
    /// Not at all.
    Idle = 0,
    /// By the law of whole joints, as long as it stays whole.
    Whole = 1,
    /// By the law of softening, until it breaks, detaches, fades or leaves.
    Softening = 2,
    /// By the host.
    Alone = 3,
}

/// The law of a joint. Components of vectors are across the joint, then along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatLaw<const D: usize> {
    /// Unit normal of the plane that the joint represents.
    pub normal: [f64; D],
    /// Stiffness, Pa/m.
    pub penalty: f64,
    /// Tensile strength and cohesion, Pa.
    pub tensile: f64,
    /// See `tensile`.
    pub cohesion: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Opening and sliding beyond the elastic range at which it is broken, m.
    pub critical: [f64; 2],
    /// Area of each end, m².
    pub share: f64,
    /// Length, m.
    pub length: f64,
    /// Share that has been handed over to contact.
    pub faded: f64,
}

/// Values of joints that phases change.
#[derive(Clone, Debug, Default)]
pub struct JointMemories<const D: usize> {
    /// The histories of the ends of each.
    pub ends: Vec<[EndMemory<D>; D]>,
    /// Force on side 0 at each end, N.
    pub forces: Vec<[[f64; D]; D]>,
}

/// The history of an end of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndMemory<const D: usize> {
    /// Damage by opening and by sliding.
    pub damages: [f64; 2],
    /// Stiffness over that of a whole joint.
    pub stiffness: f64,
    /// Opening and sliding without traction, m.
    pub origin: [f64; D],
    /// Sliding without friction, m.
    pub rubbed: [f64; D],
}

/// The state of an element in which its facets were checked, and how far it may be from it before they may
/// fail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotedState<const D: usize> {
    /// Cauchy stress, Pa. Entries below the diagonal are not used.
    pub stress: [[f32; D]; D],
    /// Matrix whose columns are the edges from corner 0, m.
    pub edges: [[f32; D]; D],
    /// Square of the change of the edges from which on the facets may fail, m².
    pub shift: f64,
    /// Change of the stress from which on they may fail, Pa.
    pub reach: f64,
}

/// Present values of some elements.
#[derive(Clone, Debug, Default)]
pub struct ElementValues<const D: usize, const N: usize> {
    /// See [`SolidState`].
    pub stresses: Vec<[[f64; D]; D]>,
    /// See [`SolidState`].
    pub forces: Vec<[[f64; D]; N]>,
    /// Square of the change of the stress from the noted one in the last deformation, Pa²; infinite if the
    /// edges have changed by more than they may.
    pub moved: Vec<f64>,
    /// See [`SolidState`]; empty without bedding.
    pub normals: Vec<[f64; D]>,
}

/// Changes of nodes and elements where bodies part. All other values stay.
#[derive(Clone, Debug)]
pub struct SolidPatch<const D: usize, const N: usize> {
    /// Number of nodes from now on.
    pub node_count: usize,
    /// The nodes that change, ascending. All nodes that are new are among them.
    pub nodes: Vec<u32>,
    /// The columns of these nodes: see [`SolidColumns`]. A new node that is held has one of the new places.
    pub masses: Vec<f64>,
    /// See `masses`.
    pub true_masses: Vec<f64>,
    /// See `masses`.
    pub places: Vec<u32>,
    /// See `masses`.
    pub ranges: Vec<[u32; 2]>,
    /// The corners in these ranges, one range after the other.
    pub corners: Vec<u32>,
    /// The state of these nodes: see [`SolidState`].
    pub positions: Vec<[f64; D]>,
    /// See `positions`.
    pub velocities: Vec<[f64; D]>,
    /// New nodes that are held, whose places follow those before.
    pub held: Vec<HeldNode<D>>,
    /// The elements whose nodes change, ascending, and their nodes.
    pub elements: Vec<u32>,
    /// See `elements`.
    pub of_elements: Vec<[u32; N]>,
}

/// Changes of joints. All other values stay.
#[derive(Clone, Debug)]
pub struct JointPatch<const D: usize> {
    /// Number of joints from now on.
    pub count: usize,
    /// The joints that change, ascending. All joints that are new are among them.
    pub joints: Vec<u32>,
    /// The columns of these joints. The open ends are those at `corners`.
    pub columns: JointColumns<D>,
    /// The state of these joints.
    pub memories: JointMemories<D>,
    /// The corners at which ends of joints open.
    pub corners: Vec<u32>,
}

/// Results of a pass over all joints.
#[derive(Clone, Debug)]
pub struct Pulled {
    /// Work done against the joints that were computed and count, J, both parts of each rounded number.
    pub work: DeviceSum,
    /// Elastic energy of these joints, J, if it was asked for.
    pub elastic: Option<DeviceSum>,
    /// Joints that the host is to compute, ascending: all of the kind [`JointKind::Alone`], and those that do
    /// not stay of their kind. Nothing of them has changed.
    pub left: Vec<u32>,
}

/// The motion of a boundary in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Its factor in the middle of the step, and at its end.
    pub factors: [f64; 2],
    /// The rotation in the step, if it is one, about an axis through a point, in the coordinates of the
    /// model, m.
    pub turn: [[f64; 3]; 3],
    /// See `turn`.
    pub through: [f64; 3],
}

/// Everything that the motion of the nodes in a step depends on.
#[derive(Clone, Copy, Debug)]
pub struct NodeMotion<'a, const D: usize> {
    /// Time step, s.
    pub step: f64,
    /// m/s².
    pub gravity: [f64; D],
    /// Force against the motion of a node, as a share of the force on it.
    pub local_damping: f64,
    /// Damping of dynamic relaxation: force on a node over its mass and its velocity, 1/s.
    pub relaxation: f64,
    /// Speed of the fastest node at which the run continues, m/s.
    pub speed_limit: f64,
    /// Works are rounded before they are added up, `(x + g) - g` with the first of these numbers, and the
    /// rest with the second. Plain sums of both parts over 512 nodes are exact.
    pub grains: [f64; 2],
    /// Whether to compute the kinetic energy and the largest forces.
    pub energy: bool,
    /// Whether to sum up the works of forces in a step at the speeds after it, and those at the speeds before
    /// it with the momentum.
    pub taken: [bool; 2],
    /// The motion of each boundary.
    pub drives: &'a [Drive],
}

/// Sums over the motion of all nodes in a step, with both parts of each rounded number.
#[derive(Clone, Debug)]
pub struct NodeSums<const D: usize> {
    /// J: kinetic energy; external work in both halves of the step; energy dissipated by damping in both.
    /// Then for dynamic relaxation: the work, J, and mass times the square of the velocity, J.
    pub sums: [DeviceSum; 7],
    /// Square of the speed of the fastest node, (m/s)². No number counts as nothing.
    pub fastest: f64,
    /// Squares of the largest force on a node that is free, and of the largest on a corner, N².
    pub largest: [f64; 2],
    /// Whether a node is beyond the limit of the speed, or its speed is no number.
    pub runs_away: bool,
    /// For each of [`SolidColumns::held`] the force of the supports, N, and its position before the step, m.
    pub held: Vec<[[f64; D]; 2]>,
}

/// A device that computes phases of a step for one run, with the bits of the processor: the twins are listed
/// at the front page of `fdem-gpu`.
pub trait Accelerator<const D: usize, const N: usize>: fmt::Debug + Send {
    /// Takes over nodes and elements in place of all before.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn load(&mut self, solid: &SolidColumns<D, N>) -> FromDevice<()>;

    /// Takes over the present state of nodes and elements.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn write(&mut self, solid: &SolidState<D, N>) -> FromDevice<()>;

    /// Takes over joints in place of all before.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn load_joints(&mut self, joints: &JointColumns<D>) -> FromDevice<()>;

    /// Takes over the present state of joints.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn write_joints(&mut self, joints: &JointMemories<D>) -> FromDevice<()>;

    /// The present state.
    ///
    /// # Errors
    /// The device fails.
    fn read(&self) -> FromDevice<(SolidState<D, N>, JointMemories<D>)>;

    /// Computes the stresses of all elements, and sets the forces on their corners; 0 where an element has no
    /// volume any more. `step`: time step, s. Returns whether all elements have one.
    ///
    /// # Errors
    /// The device fails.
    fn deform(&mut self, step: f64) -> FromDevice<bool>;

    /// Computes the forces of all joints. `step`: time step, s; `grains`: those of [`NodeMotion::grains`];
    /// `energies`: whether to compute their elastic energy.
    ///
    /// # Errors
    /// The device fails.
    fn pull(&mut self, step: f64, grains: [f64; 2], energies: bool) -> FromDevice<Pulled>;

    /// Takes over couples of elements in place of all before, and their present state.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn load_couples(&mut self, couples: &CoupleColumns, states: &CoupleStates<D>) -> FromDevice<()>;

    /// The present state of the couples.
    ///
    /// # Errors
    /// The device fails.
    fn read_couples(&self) -> FromDevice<CoupleStates<D>>;

    /// Whether each couple touches.
    ///
    /// # Errors
    /// The device fails.
    fn read_touching(&self) -> FromDevice<Vec<bool>>;

    /// Computes the forces of all couples, and adds them to those on corners in the order of the couples.
    ///
    /// # Errors
    /// The device fails.
    fn press(&mut self, press: &Press) -> FromDevice<PressSums>;

    /// Adds forces, N, to those on corners, in this order.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn add_forces(&mut self, forces: &[(u32, [f64; D])]) -> FromDevice<()>;

    /// Gathers the forces of elements and joints on all nodes, and moves the nodes.
    ///
    /// # Errors
    /// The device fails.
    fn move_nodes(&mut self, motion: &NodeMotion<'_, D>) -> FromDevice<NodeSums<D>>;

    /// The present positions of some nodes, m, in this order.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn read_positions(&mut self, nodes: &[u32]) -> FromDevice<Vec<[f64; D]>>;

    /// The present positions of some nodes, m, and their velocities, m/s, in this order.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn read_nodes(&mut self, nodes: &[u32]) -> FromDevice<[Vec<[f64; D]>; 2]>;

    /// Sets the positions, m, and the velocities, m/s, of some nodes, each once.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn write_nodes(&mut self, nodes: &[u32], motion: &[Vec<[f64; D]>; 2]) -> FromDevice<()>;

    /// Takes over the noted states of some elements, each once. Those of all others stay. The first call
    /// after [`Accelerator::load`] is for all elements; without one no element is ever awake.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn note(&mut self, elements: &[u32], states: &[NotedState<D>]) -> FromDevice<()>;

    /// The elements, ascending, whose facets may fail by the last deformation: those whose state is not near
    /// the noted one.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn awake(&mut self) -> FromDevice<Vec<u32>>;

    /// The present values of some elements, in this order.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn read_elements(&mut self, elements: &[u32]) -> FromDevice<ElementValues<D, N>>;

    /// The present state of some joints, in this order.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn read_joints(&mut self, joints: &[u32]) -> FromDevice<JointMemories<D>>;

    /// Takes changes of nodes and elements over.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn patch(&mut self, patch: &SolidPatch<D, N>) -> FromDevice<()>;

    /// Takes changes of joints over.
    ///
    /// # Errors
    /// The device has too little memory, or fails.
    fn patch_joints(&mut self, patch: &JointPatch<D>) -> FromDevice<()>;

    /// Strain energy in the last deformation, and energy that viscosity has dissipated so far, J.
    ///
    /// # Errors
    /// The device fails.
    fn energies(&self) -> FromDevice<[DeviceSum; 2]>;
}
