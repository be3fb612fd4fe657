//! Contact detection and simulations on graphics processors, with the bits of the processor.
//!
//! A search on a device finds exactly the couples of [`Rows`](fdem_contact::Rows), in the same order: the
//! order is defined by the input alone ([`RowsInput`](fdem_contact::RowsInput)), arithmetic rounds after each
//! operation on both, and no result depends on the order in which threads run. The same holds for periodic
//! boxes, two sets, filters, and lists of neighbours with distances, in `f64` and in `f32`.
//!
//! - [`Device`] is the door to a device: memory, copies, kernels. `Cuda` is a graphics processor of NVIDIA
//!   (feature `cuda`). Nothing is linked: libraries are loaded when they are used. `Host` runs the same
//!   text of the kernels on the processor (feature `host`), for tests.
//! - `kernels/*.h` are the kernels. They hold no atomic operation on floats, and nothing that only one maker
//!   of devices has.
//! - [`DeviceRows`] is the search in one set: couples, counts, lists of neighbours, and elements that are on
//!   the device already ([`PlacedElements`]). [`DeviceIndex`] searches in two sets. Images of periodic boxes
//!   are made on the processor, and [`PeriodicSearch`](fdem_contact::PeriodicSearch::couples_by) searches
//!   them by any search. Both sort by one part of the crate, `sorted.rs`.
//! - [`deform`] computes single elements.
//! - [`DeviceSolid`] computes phases of a step for a simulation of fdem-simulation, which
//!   [`put_on`](fdem_simulation::Simulation::put_on) hands over to it: elements with initial stress,
//!   viscosity and bedding, joints that are whole or soften, contacts between elements, forces on corners,
//!   supports and prescribed motions, gravity, damping, and all sums of energies and works. It finds the
//!   elements whose facets may fail. The processor computes the rest of such a run: loads, the search of
//!   couples that may touch, rigid bodies, insertion and splitting, and joints in the step in which they
//!   begin to soften, break, or are handed over to contact. The device sends the rows of its arrays that
//!   these need, and takes changed rows over (`patch.rs`). The run can go back at any step.
//! - [`memory_of`] counts the memory of such a run, by a device that only counts.
//!
//! # Sums
//!
//! Works are rounded to grains (`Grains` in `sum.rs` of fdem-simulation), so that plain sums over the nodes
//! of a block are exact. Sums of these and of energies are whole numbers, the parts of a `Sum` there: exact
//! in any order. The host adds the parts of blocks.
//!
//! # Twins
//!
//! A law is written twice, in C++ and in Rust. A test compares the two to the bit, so that neither changes
//! alone, and fails where a product and a sum round once.
//!
//! | kernels | fdem-contact, fdem-simulation | test |
//! |---|---|---|
//! | `rows.h`: cells, order | `search/rows/input.rs`, `grid.rs` | `kernels.rs` |
//! | `pairs.h`: `touch`, `admits` | `geometry.rs`, `filter.rs` | `kernels.rs` |
//! | `pairs.h`: two sets | `index/input.rs`, `grid.rs` | `two_sets.rs` |
//! | `lists.h`: `distance` | `elements.rs`, `csr.rs` | `kernels.rs` |
//! | `extremes.h`: extremes, refused numbers | `elements.rs` | `placed.rs` |
//! | `laws.h`: vectors and tensors | `vector.rs` | `laws.rs` |
//! | `laws.h`: `stress`, `cube_root` | `simplex/triangle/elastic.rs`, `simplex/tetrahedron/elastic.rs` | `laws.rs` |
//! | `laws.h`: `stress_of_rest`, `add_bedding` | `laws/transversely_isotropic.rs` | `laws.rs` |
//! | `laws.h`: `viscous_stress` | `solid/viscous.rs` | `laws.rs` |
//! | `laws.h`: `deform`, `forces_of` | `solid/batch.rs` | `laws.rs` |
//! | `watch.h`: `find_moved` | `solid/watch.rs` | `steps.rs` |
//! | `step.h`: `solid_deform` | `solid.rs`, `Solid::deform` | `steps.rs` |
//! | `step.h`: `add_forces` | `machine/threads.rs` | `steps.rs` |
//! | `step.h`: `move_node`, `damping`, `local_damping` | `motion/nodes.rs` | `steps.rs` |
//! | `step.h`: `held_velocity` | `actions/prescribed.rs` | `steps.rs` |
//! | `joints.h`: `exp_down`, `softening` | `cohesive/curve.rs` | `laws.rs` |
//! | `joints.h`: laws and memories | `cohesive/law.rs`, `cohesive/memory.rs` | `laws.rs` |
//! | `joints.h`: `elastic_of` | `cohesive/memory.rs`, `Memory::elastic` | `steps.rs` |
//! | `joints.h`: `unit_axes`, `pull_joint` | `simplex/triangle.rs`, `simplex/tetrahedron.rs`, `joints/batch.rs` | `steps.rs` |
//! | `contact.h`: `gap`, `parted`, `apart` | `simplex.rs` | `contact.rs` |
//! | `contact.h`: potentials of triangles | `simplex/triangle/potential.rs` | `contact.rs` |
//! | `contact.h`: potentials and distance of tetrahedra | `simplex/tetrahedron/potential.rs`, `part.rs`, `distance.rs` | `contact.rs` |
//! | `contact.h`: `interactions`, `energy_of` | `simplex/interactions.rs` | `contact.rs` |
//! | `contact.h`: `grip_one`, `axes_around` | `contacts/elements/grips.rs`, `simplex/tetrahedron/plane.rs` | `contact.rs` |
//! | `contact.h`: `press_couple`, `gather_couples` | `contacts/chunk.rs`, `contacts/couples.rs` | `steps.rs` |
//! | `step.h`: `add_parts`, `sums.h`: `part_of` | `sum.rs` | `steps.rs` |
//!
//! The cube root in Rust is that of `libm`, which rounds it correctly. The kernels have one of their own that
//! does, too: by Newton's method, and then by whole numbers.

mod array;
mod contacts;
#[cfg(feature = "cuda")]
mod cuda;
mod device;
mod elements;
mod error;
#[cfg(feature = "host")]
mod host;
mod index;
mod joints;
pub mod kernels;
mod patch;
mod primitives;
mod rows;
mod solid;
mod sorted;
mod tally;
mod watch;

pub use contacts::{contact_numbers, press_cases};
#[cfg(feature = "cuda")]
pub use cuda::{
    Cuda, CudaMemory, DeviceInfo, compile, compile_to_ship, devices, has_shipped_kernels, opened,
};
pub use device::Device;
pub use elements::{ElementKind, deform};
pub use error::GpuError;
#[cfg(feature = "host")]
pub use host::{Host, HostBuild};
pub use index::DeviceIndex;
pub use joints::{exponentials, soften_ends};
pub use rows::DeviceRows;
pub use rows::placed::{PlacedCouples, PlacedElements, PlacedRadii};
pub use solid::DeviceSolid;
pub use tally::{Tally, TallyMemory, memory_of};
