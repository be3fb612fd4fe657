//! The combined finite-discrete element method in two and three dimensions: bodies of triangles or of
//! tetrahedra that deform, collide and break.
//!
//! A [`Model`] goes in, [`Snapshot`]s and [`Energies`] come out. There is no file, no printing and no time of
//! day in this crate. One step reads from top to bottom in `simulation.rs`; each part is a file:
//!
//! ```text
//! solid (laws) ─> joints (cohesive) ─> contacts (detection, simplex) ─> actions (seams, loads, ground, ...) ─> motion ─> energy
//! ```
//!
//! Types have two parameters: `D` dimensions and `N = D + 1` corners of an element. The default is 2 and 3,
//! so that `Model` is one of triangles and `Model<3, 4>` one of tetrahedra. The differences between the two
//! are in `simplex.rs` and its parts.
//!
//! Results do not depend on the number of threads, nor on the number of ranks of a [`Distributed`] run:
//! forces of couples are added to those of their elements in the order of the couples, every node adds up the
//! forces of its elements and joints in a fixed order, and energies are exact sums (`src/sum.rs`). A run that
//! is saved and resumed continues bit for bit, on any number of ranks.
//!
//! # How it is built
//!
//! `Topology` never changes: vertices of the mesh, corners of elements, facets. `Solid` has the present
//! nodes, which become more as the mesh comes apart. It stores columns, each with a value of every node,
//! element or corner, which other files read and write by the functions in `src/solid/columns.rs`. Elements
//! and joints write their forces on corners; couples are computed in rounds, and the forces of each round are
//! added to those of their elements, couple by couple. Each node then adds the forces of its corners in a
//! fixed order (`force_on` in `src/motion/nodes.rs`), so that threads share no sum and change no bit. `Team`
//! cuts work into chunks of fixed size and adds their results in order.
//!
//! Elements, whole joints and contacts are computed in batches of 16, side by side (`src/lanes.rs`): one
//! function computes one of them, without a branch, and the compiler makes vectors of the loop over a batch,
//! for AVX2, AVX-512, and the basic instructions of every processor. The best set of instructions is chosen
//! at run time. All give the same bits; tests compare them. An element that is strained so much that its
//! stress needs a branch, and a joint that does not stay whole, are computed again, one by one. The parts of
//! faces that a contact of tetrahedra covers differ in how many lines cut them: each part is a task, and
//! tasks with the same number of cuts share batches (`src/simplex/tetrahedron/part.rs`).
//!
//! Data that each step reads are stored apart from data that are seldom read (positions and velocities from
//! `Constants`, `Link` from `Joint`). A step skips everything that cannot have changed: edges of elements
//! whose stress is far from the strength (`joints/demand.rs`), boxes of bodies that have moved less
//! than the slack of the buffer, and couples that have moved less than the distance between them
//! (`apart_until` in `contacts/pair.rs`).
//! Skipping changes no result. The mesher numbers nodes and elements along Hilbert's curve. Where every
//! element has its own nodes, nodes are numbered in the order of the elements. `bench/SIMULATION.md` compares
//! the speed with bounds and with other programs.
//!
//! Steps are compiled in this crate, once for each kind of element (`src/simulation/advance.rs`), and not in
//! the crates that call them. So are other functions that pass over all elements (`src/compiled.rs`).
//!
//! `State` is all that persists between steps. It is saved with postcard, and sufficient to continue a run.
//! It has nodes, joints and couples in the order of the model, and not of memory.
//!
//! Files import only from the layers below; a test reads the sources for it. `src/simulation/run.rs` has the
//! state of a run, and the files beside it the functions that change it. A step asks other ranks by the trait
//! `Peers` (`src/peers.rs`), which does nothing in one process.
//!
//! The phases of a step are functions of the trait `Machine` (`src/machine.rs`), which has the columns: nodes
//! and elements (`Solid`), `Joints`, and couples (`Contacts`). All other files reach the columns of a run
//! through the machine alone. The threads of the processor are one machine (`src/machine/threads.rs`). A
//! device with a memory of its own is another (`src/machine/on_device.rs`), by the trait `Accelerator`
//! (`src/accelerator.rs`), which fdem-gpu implements.
//!
//! A rank of a distributed run has a `Simulation` of its part of the model (`src/ranks.rs`). Its knowledge of
//! the rest is in three places: `Share` has the elements that it owns and counts, `Topology` the numbers of
//! the elements in the whole model, and `Part` the data for giving elements away.
//!
//! All forces besides those of elements, joints and contacts are actions: each kind is a file in
//! `src/actions` that implements the trait `Action` (`src/action.rs`), and `src/actions.rs` lists them. An
//! action sees the state, adds forces, and names its energies. It returns its memory as records that belong
//! to elements, so that checkpoints, stages and ranks do not depend on it.
//!
//! `Faces` lists the outer facets and the facets of broken joints, and is kept while joints break. Contact,
//! tips of cracks, seams and cavities read it.
//!
//! Bodies of a kind have numbered parts that can touch (`Bodies`, `src/bodies.rs`): elements are the first
//! kind. Couples of a pair of kinds are found, sleep, keep their histories and are computed by the same code
//! (`Couples`, `src/contacts/couples.rs`); the pair adds forces and works (`PairPass`,
//! `src/contacts/pair.rs`). Degrees of freedom move by kinds (`Freedoms`, `src/motion.rs`): nodes are the
//! first.
//!
//! Abstractions without a second use are left out, but for those of kinds of bodies: a test has spheres.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | the time step of a simulation | `src/simulation.rs`; insertion and splitting: `src/simulation/breaking.rs`; the beginning of a run: `src/simulation/run.rs` |
//! | a law of the material: stress, energy, memory | a file beside `src/laws/neo_hookean.rs`, and the list of all laws: `src/laws.rs`; the interface for elements: `src/laws/element_law.rs` |
//! | the forces of elements, and their batches | `src/solid.rs`, `src/solid/batch.rs`, `src/solid/by_law.rs` |
//! | where the phases of a step are computed | `src/machine.rs`, `src/machine/list.rs` and a file for each machine in `src/machine`; devices: `src/accelerator.rs`, `flat.rs` in `src/solid`, `src/joints` and `src/contacts`, `src/simulation/placed.rs` |
//! | columns of nodes and elements | `src/solid.rs`, `src/solid/columns.rs` |
//! | softening and breaking of a joint | `src/cohesive/law.rs`, `memory.rs` and `curve.rs` beside it; of many joints: `src/joints/batch.rs`, `src/joints/pass.rs`; insertion: `src/joints/insertion.rs`, `demand.rs`, `uses.rs`, `fan.rs`, `cut.rs` and `plane.rs` beside it |
//! | a set of joints with its own law | `src/joint_sets.rs`, `src/joints/start.rs` |
//! | the contact force | `potential.rs` in `src/simplex/triangle` and `tetrahedron`; facets near a centroid: `src/simplex/interactions.rs`; friction, damping and their histories: `src/contacts/elements/grips.rs`; in batches: `src/contacts/elements.rs` |
//! | couples: search, sleep, histories | `src/contacts/couples.rs`, `src/contacts/chunk.rs`; elements that can touch: `src/contacts/surface.rs`; saved ones: `src/contacts/saved.rs` |
//! | a kind of bodies | `src/bodies.rs`, `src/contacts/pair.rs`, `src/motion.rs`, and the walk-through in CONTRIBUTING.md |
//! | an action: forces from outside | `src/action.rs`, `src/actions.rs` and a file for each kind in `src/actions`; loads of boundaries in `src/model/load.rs` |
//! | loads, gravity, absorbing edges, prescribed motions | `loads.rs`, `gravity.rs`, `ground.rs` and `prescribed.rs` in `src/actions` |
//! | spheres and walls among bodies | `src/actions/spheres.rs`, the surface that they touch: `src/actions/spheres/surface.rs`; their own motion and contacts: the crate `fdem-grains` |
//! | outer facets and faces of cracks | `src/faces.rs` |
//! | how a run continues with another model: excavation, stages | `src/simulation/changed.rs`, and a part of a model: `src/subset.rs` |
//! | pressure in holes and cracks | `src/actions/cavity.rs` |
//! | flow in cracks | `src/actions/fluid.rs`, its model: `src/model/fluid.rs`, the flow itself: the crate `fdem-fluid` |
//! | liquid in the pores of elements | `src/actions/pores.rs`, its model: `src/model/pores.rs`, the flow itself: `PorousMatrix` of the crate `fdem-fluid` |
//! | changes by the caller between steps | `src/simulation/program.rs`, `src/actions/program.rs` |
//! | rigid bodies | `src/rigid.rs`, their nodes and supports: `src/rigid/nodes.rs`, their motion: `src/motion/rigid.rs` |
//! | the longest stable time step | `src/critical.rs` |
//! | dynamic relaxation | `src/simulation/relaxation.rs`, and its force: `src/motion/nodes.rs` |
//! | mass that is added for a longer time step | `src/mass.rs` |
//! | terms of the energy balance | `src/energy.rs`, and their sum: `src/simulation/audit.rs` |
//! | initial stress in contacts and at absorbing edges | `src/actions/seams.rs`, `src/actions/ground.rs` |
//! | contact forces and reactions of results | `src/forces.rs` |
//! | how near a stress is to its strength | `src/exposure.rs` |
//! | probes: means of stress, strain and velocity, gauges, forces between bodies, joint sets, fluid, pores, spheres, walls | `src/probe.rs` and the files in `src/probe` |
//! | forecast of a run on many ranks: shares, messages, memory | `src/ranks/forecast.rs` |
//! | many ranks: messages of a step, division of the work | `src/peers.rs` and `src/ranks/links.rs`, `src/ranks/spread.rs` |
//! | refused models | `src/checks.rs`, `src/error.rs` |
//! | differences between two and three dimensions | `src/simplex.rs`, `crates/model/src/bodies/dimensions.rs`, `crates/fdem/src/command/run/results.rs` |
//!
//! # Decisions, and departures from the book
//!
//! - The simulation is a separate crate and not a module of `fdem`: it must not depend on paths, and only a
//!   crate guarantees this; it is also compiled and tested without pictures and formats.
//! - Elements have a neo-Hookean energy instead of the book's stress (4.178) to (4.184), which is the same to
//!   the first order of the strain but follows from no energy (`src/laws/neo_hookean.rs`).
//! - The potential contact force is the exact gradient of its potential. The book's (2.25) lacks the share
//!   that the potential has because it moves with the nodes of a triangle that deforms; without it, impacts
//!   of deformable bodies gain or lose energy (`src/simplex/triangle/potential.rs`).
//! - Contact forces and energies follow from the potential along the edges of the two triangles alone, by the
//!   divergence theorem with a field of our own (`src/simplex/triangle/potential.rs`); the book clips
//!   triangles against the three parts of the other. It is the same integral, in half of the time.
//! - An overlap at the beginning that is ignored begins with the potential `U₀` that it has: the energy of
//!   the couple is `(√U - √U₀)²` above `U₀`, and 0 below, where `U₀` falls with `U`. So a spring acts that is
//!   compressed by the overlap less the initial one. `U₀` changes only where the energy is 0, so none is
//!   created; force and energy are continuous, other than with couples that are left out until they have
//!   parted. The function for elements at a joint that broke, `(U - U₀)²/U`, is too stiff for deep overlaps
//!   (`src/contacts/elements/grips.rs`).
//! - Joints are inserted where the strength is reached, and begin with the traction that acts there by an
//!   offset of their opening and sliding; the book has them on all edges (`insertion = "intrinsic"`), which
//!   makes bodies softer.
//! - Opening and sliding soften together, with one damage and one stiffness of their vector, and friction has
//!   a separate spring; in the book each softens on its axis. With that law a crack along the edges of an
//!   unstructured mesh dissipates 1.3 to 1.6 times its fracture energy (`src/cohesive.rs`; tables in
//!   `bench/NOTES.md`).
//! - In space the joint of a face represents the plane across the largest tension where tension governs, at
//!   any angle, and measures its mode from the normal of that plane (`src/joints/plane.rs`). An intrinsic
//!   joint takes that plane when it leaves its elastic range.
//! - An edge fails as soon as a plane within 15° of it does, and its joint represents that plane; in the book
//!   an edge fails by its own traction. Without this a block in compression is up to a quarter stronger than
//!   its material (`src/joints/plane.rs`).
//! - The critical opening is the one that dissipates the fracture energy, G/(0.3863 f); 3 G/f is an option.
//!
//! # Unsafe code
//! `src/lanes.rs` calls functions that are compiled for vector instructions, on processors that have them.
//! There is no other in this crate.
//!
//! # Sources
//! A. Munjiza, *The Combined Finite-Discrete Element Method* (Wiley, 2004); each module says where it departs
//! from the book and why.

#![allow(private_bounds, reason = "elements are triangles or tetrahedra; nobody else can make others")]
#![allow(
    clippy::inline_always,
    reason = "what a batch calls must be compiled for the same instructions: `lanes.rs`"
)]
#![allow(clippy::needless_range_loop, reason = "axes, ends and corners count through several arrays at once")]

mod compiled;
mod moduli;
mod strength;
mod model;
mod subset;
mod checks;
mod lists;
mod random;
mod share;
mod sum;
mod team;
mod timings;
mod vector;
mod rotation;
mod lanes;
mod simplex;
mod accelerator;
mod topology;
mod laws;
mod solid;
mod rigid;
mod cohesive;
mod joint_sets;
mod faces;
mod joints;
mod bodies;
mod contacts;
mod outer_side;
mod energy;
mod action;
mod actions;
mod motion;
mod critical;
mod mass;
mod machine;
mod forces;
mod exposure;
mod snapshot;
mod probe;
mod peers;
mod simulation;
mod ranks;
mod error;

pub use accelerator::{
    Accelerator, BY_HOST, CoupleColumns, CoupleStates, DeviceSum, Drive, ElementValues, EndMemory,
    FlatBedding, FlatContact, FlatGrip, FlatLaw, FromDevice, HeldNode, HoldKind, JointColumns, JointKind,
    JointMemories, JointPatch, NO_NUMBER, NodeMotion, NodeSums, NotedState, Press, PressSums, Pulled,
    SUM_PARTS, SolidColumns, SolidPatch, SolidState,
};
pub use actions::cavity::CavityState;
pub use actions::seams::InitialContacts;
#[doc(hidden)]
pub use contacts::{ContactCase, press_tetrahedra, press_triangles};
pub use critical::{Cause, CriticalStep};
pub use energy::{Energies, Term, TermKind};
pub use error::{ModelError, Stop};
pub use fdem_contact::Simd;
pub use fdem_fluid as fluid;
pub use fdem_grains as grains;
pub use fdem_mesh::Mesh;
pub use forces::{ContactForce, Forces};
#[doc(hidden)]
pub use joints::single::{JointEnd, soften_ends};
pub use laws::{Bedding, MaterialLaw};
pub use mass::MassScaling;
pub use model::{
    Boundary, ContactOptions, CriticalOpening, FluidOptions, FluidSource, FractureOptions, InitialOverlap,
    Insertion, Interface, JointSet, Load, LoadEffect, LoadSummary, Material, Model, Plane, PoreOptions,
    PoreSurface, STORED, Schedule, Strength, Target, TimeOptions, UntilOverloaded, WetFrom,
};
pub use probe::touching::TouchingSide;
pub use probe::{MaterialPoint, Probe};
pub use ranks::distributed::{Distributed, Traffic};
pub use ranks::forecast::{Forecast, Network, RankForecast, Sizes};
pub use ranks::gather::Gathered;
pub use ranks::leader::{Leader, dismiss, follow};
pub use simulation::advance::Element;
pub use simulation::changed::Change;
pub use simulation::run::{Counts, Simulation};
pub use simulation::saved::State;
pub use snapshot::{Crack, Mode, Snapshot, WetJoint, principal_stresses};
#[doc(hidden)]
pub use solid::single::{ElementForces, ElementState, deform_tetrahedra, deform_triangles};
pub use subset::Subset;
pub use timings::Timings;
