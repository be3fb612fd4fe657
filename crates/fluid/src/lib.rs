//! Flow of a fluid in networks of cracks and in the pores of bodies: the cubic law, fluid lag, leak-off,
//! Darcy's law with Biot's coupling, in implicit steps that keep the mass.
//!
//! A [`Network`] consists of [`Cell`]s, the opened facets of a mesh: edges in the plane, triangles in space.
//! The caller gives their shapes and openings before each step; the network returns their pressures. It knows
//! nothing of the solid, of files and of threads. All numbers are in SI units: m, s, kg, Pa.
//!
//! # A coupled step
//!
//! 1. [`Network::renew`], only if joints were inserted or corners have split: all cells, old and new. Cells
//!    keep their mass by their keys. [`Network::drain`] before it, for cells that are to vanish with their
//!    fluid; [`Network::set_source_cells`] before it, for new cells at the wall of a hole.
//! 2. [`Network::update`]: the [`Shape`] of each cell, from the present positions of nodes. Where the solid
//!    is stiff against the fluid, with the compliance of its walls (below). [`Network::set_source_volume`]:
//!    the volume of holes.
//! 3. [`Network::advance`]: a step of the fluid, which may be as long as many steps of the solid. If it
//!    fails, the network is as before, and the error names a cell.
//! 4. [`Network::pressures`]: act until the next step of the fluid on both faces of each cell, along the
//!    present normals; `A p/D` at each of the `D` corners, with [`Network::areas`]. Their work on the solid
//!    is `Σ p dV`, positive where cells open. [`Network::injection`]: pressure and rate of each source,
//!    [`Network::balance`]: the mass.
//! 5. [`Network::state`] and [`Network::restore`], to save a run and to continue it with the same bits.
//!
//! ```
//! use fdem_fluid::*;
//!
//! // A crack of ten cells of 1 cm, 0.1 mm open, filled from its end at 1 cm²/s.
//! let cells: Vec<Cell<2>> = (0..10)
//!     .map(|k| Cell {
//!         key: u64::from(k),
//!         corners: [k, k + 1],
//!         law: ApertureLaw::default(),
//!         leak_off: 0.0,
//!         initial_pressure: None,
//!     })
//!     .collect();
//! let shape = |k: u32| Shape {
//!     corners: [[0.01 * f64::from(k), 0.0], [0.01 * f64::from(k + 1), 0.0]],
//!     opening: 1e-4,
//!     compression: 0.0,
//!     compliance: 0.0,
//!     is_wet: true,
//! };
//! let shapes: Vec<Shape<2>> = (0..10).map(shape).collect();
//! let pump = Source {
//!     key: 0,
//!     cells: vec![0],
//!     volume: 0.0,
//!     drive: Some(Drive::Rate(Schedule::constant(1e-4))),
//!     initial_pressure: None,
//! };
//! let mut network = Network::new(FlowModel::new(Fluid::WATER), vec![pump], &cells, &shapes)?;
//! for _ in 0..5 {
//!     network.update(&shapes)?;
//!     network.advance(0.01)?;
//! }
//! // 5e-6 m² of fluid fill five cells of 1e-6 m².
//! let full = network.saturations().into_iter().filter(|part| *part > 0.999).count();
//! assert!((4..=5).contains(&full));
//! assert!(network.balance().error().abs() < 1e-12 * network.balance().injected);
//! # Ok::<(), FluidError>(())
//! ```
//!
//! # Equations
//!
//! | quantity | equation | file |
//! |---|---|---|
//! | hydraulic aperture | `a = clamp(a0 + f w, a_res, a_max)`; closed under compression: `a0/(1 + 9 σ/σ_ref)` | `src/aperture.rs` |
//! | flow per width | `q = -a³/(12 μ) (∇p - ρ g)` (P. A. Witherspoon et al., Water Resour. Res. 16 (1980) 1016) | `src/network/balances.rs` |
//! | flow between cells | `Q_cd = G_c G_d/Σ G (p_c - p_d + ρ g·(x_d - x_c))`, `G_c = b K_c/l_c`, `K = a³/(12 μ)` | `src/network/balances.rs` |
//! | distances `l` | from centres of circumscribed circles to edges in space, half the length in the plane | `src/cell.rs` |
//! | liquid | `ρ = ρ0 exp((p - p0)/K)`, `m = ρ A a`; not full: `p = p_cavitation`, saturation `s = m/(ρ A a)` | `src/fluid.rs` |
//! | gas | `p = p0 (ρ/ρ0)^n` | `src/fluid.rs` |
//! | balance | `dm/dt = Σ ρ Q_in + source - leak` | `src/network/balances.rs` |
//! | leak-off (R. D. Carter 1957) | `4 A C_L (√(t1 - t_c) - √(t0 - t_c))` over a step, both faces, times the saturation | `src/network/balances.rs` |
//! | explicit bound | `min_c V_c/(K Σ b T)` | `src/network/explicit.rs` |
//!
//! **Junctions.** All cells at a corner in the plane, or at an edge in space, meet in a junction of zero
//! volume. Its pressure is the mean of those of its cells by their conductances `G`, because flows at it add
//! up to zero; it is eliminated by hand, which leaves a link with `G_c G_d/Σ G` between each two cells
//! (star-mesh transform). For two cells that is the harmonic mean: a closed cell blocks. The matrix stays
//! symmetric, with positive links only, and no unknown is without volume. A junction of `k` cells costs
//! `k(k-1)/2` links.
//!
//! **Unfilled cells.** A cell whose mass does not fill it has the pressure of cavitation, and passes on the
//! part `s` of the flow that leaves it, `s` at the end of the step. It is empty at most: no mass and no
//! pressure falls below its lowest value, by construction. A source with a negative rate takes out as much as
//! there is, and the rest is in [`Balance::missed`]. Fluid in an unfilled cell flows by gravity only.
//!
//! **A step** is one of backward Euler. Apertures of the last [`Network::update`] and densities at the
//! beginning of the step give the conductances. Pressures of full cells follow by Newton's method for the
//! complementarity of pressure and empty volume (`src/network/implicit.rs`). Masses are then moved along the
//! flows, so that no mass is lost however well pressures are known. A step in which many rows of cells fill
//! takes a linear system for each row.
//!
//! **Compliance.** The aperture grows by [`Shape::compliance`] for each Pa above the pressure at the last
//! [`Network::update`], as far as the storage is concerned: the fixed-stress split (J. Kim, H. A. Tchelepi
//! and R. Juanes, Comput. Methods Appl. Mech. Eng. 200 (2011) 1591-1606). Without it a staggered step
//! overshoots where the fluid is stiffer than the walls, `K/a > 1/compliance`; with it the result converges
//! to the same. The length of a crack over its plane-strain modulus is the order of a good value.
//!
//! **Sources.** The volume of a source and its wet cells have one pressure: a borehole with cracks at its
//! wall. With [`Connection::Cavities`] all cells that are connected have one pressure, too, and no
//! resistance: a gas in a blast hole and its cracks, `p(V)`, or the limit of low viscosity.
//!
//! # Pores
//!
//! A [`PorousMatrix`] has the liquid in the pores of triangles or tetrahedra, with a pressure at each vertex
//! of the undeformed mesh (tension of the body is positive, `ε` is the strain of its volume):
//!
//! | quantity | equation | file |
//! |---|---|---|
//! | total stress | `σ = σ' - α p 1`: the body has the effective stress `σ'` (M. A. Biot, J. Appl. Phys. 12 (1941) 155) | the caller |
//! | content | `ζ = α ε + p/M`, `1/M = φ/K_f + (α - φ)/K_s` | `src/matrix/material.rs` |
//! | flow | `q = -k/μ (∇p - ρ g)` | `src/matrix/assembly.rs` |
//! | balance | `dζ/dt = -∇·q + source` | `src/matrix.rs` |
//!
//! **A step.** [`PorousMatrix::deform`] takes the present volumes of elements, after each step of the solid:
//! the liquid stays, and pressures are those of its content in the new volumes, the undrained response.
//! [`PorousMatrix::pressure_in`] pushes the corners of an element: the force on a corner is `α p` times the
//! derivative of the volume of the element by the place of the corner, `-A/D` with the outward area vector
//! of the opposite facet. These forces are the gradient of `Σ S p²/2` at constant contents, so that without
//! flow the energy of body and liquid is constant. [`PorousMatrix::advance`] moves liquid by backward Euler,
//! while the body stays: this energy falls. Undrained and drained parts in turn are the undrained split (J.
//! Kim, H. A. Tchelepi and R. Juanes, Comput. Methods Appl. Mech. Eng. 200 (2011) 2094-2116).
//!
//! **Places of pressures.** They are linear in elements (Galerkin), with the storage of each element shared
//! equally by its vertices. A linear pressure is exact in any mesh, errors fall with the square of the size,
//! the matrix is symmetric and positive definite, and the forces above follow. One pressure for each element
//! with flow between neighbours (two-point flux) would not converge in meshes of triangles that are not
//! orthogonal. Flow goes from vertex to vertex, `T_ij (p_i - p_j + ρ g·(x_j - x_i))`, and one loses the
//! volume that the other gains: mass is kept to rounding.
//!
//! **Cracks** flow into pores, and pores into cracks, by [`exchange`], after each step of the network.
//!
//! **Strains are small**: storage and conductances are those of the undeformed mesh. The volumes of elements
//! are exact.
//!
//! **Fast loads.** Linear displacements with linear pressures are no stable pair for an incompressible
//! mixture (`M → ∞`, `k → 0`): pressures may alternate from vertex to vertex. A liquid in rock is
//! compressible, with `α² M` of the order of the bulk modulus of the frame, and shared storage damps the
//! alternation of the first step after a jump (P. A. Vermeer and A. Verruijt, Int. J. Numer. Anal. Methods
//! Geomech. 5 (1981) 1-14). No stabilisation is added; the tests of the coupling bound the error.
//!
//! # Bits
//!
//! Results depend on numbers and keys of cells, and not on their order, on saved states or on the processor:
//! sums are in the order of keys, functions come from `libm`, and the linear solver (`src/ldl.rs`) is our
//! own, 60 lines of a published method. `faer`, the well-kept crate, chooses vector instructions and fused
//! operations at run time (`pulp`) for supernodes and dense solutions, so that bits differ between
//! processors; its simplicial factorisation is free of that as its code is today, which is no promise.
//! `sprs-ldl` orders by reverse Cuthill-McKee, by which factors of cracks in space fill, or by a library in
//! C.
//!
//! # Limits
//!
//! - Gravity does not act inside a source with many cells, or inside a cavity.
//! - Carter's law has the density at the reference pressure, and its time begins when the first fluid is in a
//!   cell.
//! - Between triangles whose circumscribed centres are outside of them the flow is that of a smallest
//!   distance: less exact than in acute ones.
//! - A step that is far longer than fluid needs to run down the network may not converge, in 64 parts
//!   neither: 3 of 72,000 random ones. The error names the cell.
//! - A closed cell blocks: a front enters it as far as the solid, or its residual aperture, opens it.
//! - Pores have one pressure at each vertex of the undeformed mesh: a crack that blocks flow across it, with
//!   different pressures on its faces, is not represented.
//! - Opposite to obtuse angles flow between two vertices is negative: a pressure may overshoot there.
//! - The flow does not know inertia: Reynolds numbers `ρ q/μ` above some hundreds are outside of the cubic
//!   law.
//!
//! | to change | open |
//! |---|---|
//! | the fluid | `src/fluid.rs` |
//! | the aperture of a cell | `src/aperture.rs` |
//! | geometry of cells | `src/cell.rs` |
//! | sources, tables | `src/source.rs` |
//! | connections | `src/topology.rs` |
//! | a step | `src/network/balances.rs`, then `implicit.rs` or `explicit.rs` beside it |
//! | saved columns | `src/state.rs` |
//! | flow between cracks and pores | `src/exchange.rs`, `src/outlet.rs` |
//! | flow in pores | `src/matrix.rs` and the files in `src/matrix` |
//! | the linear solver | `src/ldl.rs`, its order: `src/ordering.rs` |
//!
//! Files import from those above them in this order: `error`, `fluid`, `aperture`, `source`, `cell`, `state`,
//! `storage`, `ordering`, `ldl`, `outlet`, `topology`, `network`, `network/balances`, `network/implicit`,
//! `network/explicit`, `matrix/material`, `matrix/state`, `matrix/assembly`, `matrix` and
//! `exchange`.

mod aperture;
mod cell;
mod error;
mod exchange;
mod fluid;
mod ldl;
mod matrix;
mod network;
mod ordering;
mod outlet;
mod source;
mod state;
mod storage;
mod topology;

pub use aperture::ApertureLaw;
pub use cell::{Cell, Shape};
pub use error::FluidError;
pub use exchange::exchange;
pub use fluid::{Fluid, StateEquation};
pub use matrix::{
    MatrixState, PoreBalance, PoreBoundary, PoreLiquid, PorousElement, PorousMaterial, PorousMatrix,
};
pub use network::{Connection, Flow, FlowModel, Injection, Network, Scheme, StepReport};
pub use source::{Drive, Schedule, Source};
pub use state::{Balance, NetworkState};
