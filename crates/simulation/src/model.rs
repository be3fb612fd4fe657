//! The model: a mesh, materials, and the actions on it. This module holds numbers only; files are read
//! elsewhere.

mod fluid;
mod load;
mod pores;
mod target;

use std::collections::BTreeSet;

use fdem_grains::GrainModel;
use fdem_mesh::Mesh;
use serde::{Deserialize, Serialize};

use crate::laws::{AnyLaw, MaterialLaw};
pub use crate::model::fluid::{FluidOptions, FluidSource, WetFrom};
pub(crate) use crate::model::load::Stored;
pub use crate::model::load::{Load, LoadEffect, LoadSummary, STORED};
pub use crate::model::pores::{PoreOptions, PoreSurface};
pub use crate::model::target::Target;
pub use crate::moduli::Plane;
use crate::simplex::Simplex;
pub use crate::strength::Strength;
use crate::vector::Point;

/// A run stops when a node is faster than this multiple of the highest wave speed √(E/ρ) of the materials.
const RUNAWAY: f64 = 10.0;

/// A model, complete: of triangles in the plane (`D` = 2, `N` = 3) or of tetrahedra (`D` = 3, `N` = 4). SI
/// units: m, kg, s, Pa.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; D]: Serialize, [u32; N]: Serialize, [Option<f64>; D]: Serialize, [[f64; D]; D]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; D]: Deserialize<'de>, [u32; N]: Deserialize<'de>, [Option<f64>; D]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>"
))]
pub struct Model<const D: usize = 2, const N: usize = 3> {
    /// Bodies, meshed.
    pub mesh: Mesh<D, N>,
    /// Materials of the elements.
    pub materials: Vec<Material>,
    /// Pairs of materials with separate properties for contacts and joints. Other pairs take the lesser
    /// values of their two materials.
    pub interfaces: Vec<Interface>,
    /// Sets of joints, each with a common law.
    pub joint_sets: Vec<JointSet>,
    /// For each element the joint set of each of its facets, `u32::MAX` for none; empty without joint sets.
    /// [`Model::add_joints`] fills it.
    pub joint_facets: Vec<[u32; N]>,
    /// Boundary conditions that hold, move and load the bodies.
    pub boundaries: Vec<Boundary<D>>,
    /// Whether the stress or the strain out of the plane vanishes, in two dimensions.
    pub plane: Plane,
    /// Thickness out of the plane, m, in two dimensions. In three it has to be 1, as it multiplies volumes
    /// and areas.
    pub thickness: f64,
    /// Acceleration of gravity, m/s².
    pub gravity: [f64; D],
    /// Factor of gravity in time. Gravity without a ramp swings the stress to twice its static value.
    pub gravity_schedule: Schedule,
    /// Velocity of each node at the beginning, m/s; empty for none.
    pub velocities: Vec<[f64; D]>,
    /// Stress of each element at the beginning, a symmetric tensor in Pa, tension positive; empty for none.
    /// Surfaces that touch, joints and absorbing edges begin with its tractions.
    pub stresses: Vec<[[f64; D]; D]>,
    /// Factor, at least 1, of the mass of each element in its motion; empty for none. Its weight stays that
    /// of its density. See [`MassScaling`](crate::MassScaling).
    pub mass_factors: Vec<f64>,
    /// Numbers of the bodies that are rigid, ascending: see [`Mesh::bodies`]. Their elements have no stress,
    /// no joints, and give them mass and shape alone. A boundary that holds or moves nodes of such a body
    /// holds or moves the body.
    pub rigid: Vec<u32>,
    /// The rigid bodies that deform and break from the step on in which they are overloaded, in ascending
    /// order.
    pub until_overloaded: Vec<UntilOverloaded>,
    /// Spheres and walls, whose materials are those of this model, number by number; `None` without.
    pub grains: Option<GrainModel>,
    /// Fluid in holes and cracks; `None` without.
    pub fluid: Option<FluidOptions<D>>,
    /// Liquid in the pores of elements; `None` without.
    pub pores: Option<PoreOptions<D>>,
    /// Options of contacts.
    pub contact: ContactOptions,
    /// How they break.
    pub fracture: FractureOptions,
    /// Options of the integration in time.
    pub time: TimeOptions,
}

/// A body that is rigid until it is overloaded.
///
/// In each step, its mean stress under the forces on its surface and its rotation (Love and Weber) is
/// compared with the strength of its material, and the largest of these forces over the area of its facet
/// with the strength in compression. Half of the difference of the principal stresses counts as tension: that
/// in the middle of a disc or a ball between two forces. When one of the ratios reaches `share`, the body
/// gets the static stress of these forces, at most that at `share`, and deforms and breaks as others do. It
/// then stays so.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UntilOverloaded {
    /// Number of the body, one of [`Model::rigid`].
    pub body: u32,
    /// Share of the strength, above 0 and at most 1.
    pub share: f64,
}

impl<const D: usize, const N: usize> Model<D, N> {
    /// The model without the rigid bodies of these elements: they deform.
    pub(crate) fn releasing(mut self, elements: impl Iterator<Item = u32>) -> Self {
        let bodies: BTreeSet<u32> =
            elements.filter_map(|element| self.mesh.bodies.get(element as usize).copied()).collect();
        self.rigid.retain(|body| !bodies.contains(body));
        self
    }

    /// The interface of two materials, if there is one.
    pub(crate) fn interface(&self, a: u32, b: u32) -> Option<&Interface> {
        self.interfaces
            .iter()
            .find(|interface| interface.materials == [a, b] || interface.materials == [b, a])
    }

    /// The entry of a body that is rigid until it is overloaded.
    pub(crate) fn until_overloaded(&self, body: u32) -> Option<&UntilOverloaded> {
        let place = self.until_overloaded.binary_search_by_key(&body, |of| of.body).ok()?;
        self.until_overloaded.get(place)
    }

    /// Whether a body, by its number, is rigid for the whole run.
    pub fn stays_rigid(&self, body: u32) -> bool {
        self.rigid.binary_search(&body).is_ok() && self.until_overloaded(body).is_none()
    }

    /// Whether an element belongs to a rigid body.
    pub fn is_rigid(&self, element: u32) -> bool {
        !self.rigid.is_empty() && self.rigid.binary_search(&self.mesh.bodies[element as usize]).is_ok()
    }

    /// Speed of a node beyond which a run stops, m/s: a multiple of the highest wave speed √(E/ρ) of the
    /// materials.
    pub fn speed_limit(&self) -> f64 {
        RUNAWAY * self.materials.iter().map(Material::bar_speed).fold(0.0, f64::max)
    }

    /// Factor of the mass of an element in its motion.
    pub(crate) fn mass_factor(&self, element: usize) -> f64 {
        self.mass_factors.get(element).copied().unwrap_or(1.0)
    }
}

impl<const D: usize, const N: usize> Default for Model<D, N> {
    /// An empty model, 1 m thick, without gravity.
    fn default() -> Self {
        Self {
            mesh: Mesh::default(),
            materials: Vec::new(),
            interfaces: Vec::new(),
            joint_sets: Vec::new(),
            joint_facets: Vec::new(),
            boundaries: Vec::new(),
            plane: Plane::default(),
            thickness: 1.0,
            gravity: [0.0; D],
            gravity_schedule: Schedule::Constant,
            velocities: Vec::new(),
            stresses: Vec::new(),
            mass_factors: Vec::new(),
            rigid: Vec::new(),
            until_overloaded: Vec::new(),
            grains: None,
            fluid: None,
            pores: None,
            contact: ContactOptions::default(),
            fracture: FractureOptions::default(),
            time: TimeOptions::default(),
        }
    }
}

/// An elastic material that may break.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name, for messages.
    pub name: String,
    /// Density, kg/m³.
    pub density: f64,
    /// Young's modulus, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio, above -1 and at most 0.5; in plane strain below 0.5.
    pub poissons_ratio: f64,
    /// How its stress follows from its deformation.
    pub law: MaterialLaw,
    /// Viscosity as a share of the critical damping of the fastest mode of an element; 0 for none.
    pub damping: f64,
    /// Strength; `None` for a material that does not break.
    pub strength: Option<Strength>,
    /// Coefficient of friction where it touches, unless an [`Interface`] says otherwise.
    pub friction: f64,
}

impl Material {
    /// Young's modulus in the direction in which the material is stiffest, Pa: that of penalties, of
    /// viscosity, and of the speed of waves in bars.
    pub fn stiffest_modulus(&self) -> f64 {
        self.law.stiffest_modulus(self.youngs_modulus)
    }

    /// Poisson's ratio of the isotropic material that is nearest to this one: it says whether this one is
    /// nearly incompressible.
    pub fn mean_poissons_ratio(&self) -> f64 {
        self.law.mean_poissons_ratio(self.youngs_modulus, self.poissons_ratio)
    }

    /// Speed of a wave along a bar, m/s, in the stiffest direction.
    pub fn bar_speed(&self) -> f64 {
        (self.stiffest_modulus() / self.density).sqrt()
    }

    /// Speed of the slowest shear wave, m/s.
    pub fn shear_speed(&self) -> f64 {
        let modulus = self.law.least_shear_modulus(self.youngs_modulus, self.poissons_ratio);
        (modulus / self.density).sqrt()
    }

    /// Speeds of the compressional and of the shear wave along a direction of unit length, m/s. `plane`
    /// counts in two dimensions.
    pub fn wave_speeds<const D: usize, const N: usize>(&self, plane: Plane, direction: [f64; D]) -> [f64; 2]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.in_elements::<D, N>(plane)
            .wave_moduli::<N>(direction)
            .map(|modulus| (modulus / self.density).sqrt())
    }

    /// The law in elements.
    pub(crate) fn in_elements<const D: usize, const N: usize>(&self, plane: Plane) -> AnyLaw<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.law.in_elements::<D, N>(self.youngs_modulus, self.poissons_ratio, plane)
    }

    /// Strength on a facet with this normal of unit length in the undeformed body.
    pub(crate) fn strength_on<const D: usize>(&self, normal: Point<D>) -> Option<Strength> {
        self.strength.map(|strength| self.law.strength_on(strength, normal))
    }
}

/// A set of joints. They are in the mesh from the beginning, whatever the option for the insertion of others
/// is.
///
/// A joint is elastic up to its strength, softens, and then has its residual friction. Under initial stress
/// it begins with the traction of that stress.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSet {
    /// Name, for messages.
    pub name: String,
    /// Strength and fracture energies. Tensile strength and cohesion may be 0. The fracture energy contains
    /// the elastic work up to the strength.
    pub strength: Strength,
    /// Tangent of the friction angle of broken joints. The friction falls to it from that of the strength as
    /// the joint softens. It is also the coefficient of friction of the contacts between elements on the two
    /// sides of the set, after joints have handed over to contact.
    pub residual_friction: f64,
    /// Normal stiffness, Pa/m; `None` for the joint penalty of [`FractureOptions`](crate::FractureOptions).
    pub normal_stiffness: Option<f64>,
    /// Shear stiffness, Pa/m; `None` for the normal stiffness.
    pub shear_stiffness: Option<f64>,
    /// Tangent of the dilation angle: how far the sides of a joint move apart for each length that they slip
    /// under friction. At most the residual friction. 0 for none.
    pub dilation: f64,
    /// Slip, m, up to which joints dilate; `None` for 5 % of the length of each.
    pub dilation_slip: Option<f64>,
    /// Whether the joints are broken from the beginning: they have no strength, carry no initial stress, and
    /// leave pressure and friction to contacts.
    pub open: bool,
}

/// Properties of the contacts and joints between two materials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// The two materials; they may be the same.
    pub materials: [u32; 2],
    /// Coefficient of friction of contacts.
    pub friction: f64,
    /// Penalty of contacts, Pa; `None`: as [`ContactOptions::penalty`] says.
    pub penalty: Option<f64>,
    /// Strength of the joints between the two, inside bodies; `None`: the lesser of the two materials.
    /// Tensile strength and cohesion may be 0.
    pub strength: Option<Strength>,
}

/// A boundary condition on nodes or facets: edges of triangles, faces of tetrahedra.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; D]: Serialize, [Option<f64>; D]: Serialize, [[f64; D]; D]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; D]: Deserialize<'de>, [Option<f64>; D]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>"
))]
pub struct Boundary<const D: usize = 2> {
    /// Name, for messages.
    pub name: String,
    /// Nodes or facets on which it acts.
    pub target: Target<D>,
    /// Kind and size of the action.
    pub load: Load<D>,
    /// Factor of the action in time.
    pub schedule: Schedule,
}

/// The factor of a [`Load`] in time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Schedule {
    /// The factor is 1 at all times.
    #[default]
    Constant,
    /// The factor grows from 0 to 1 as half a cosine within this time, s, and stays 1.
    Ramp(f64),
    /// Pairs of a time, s, ascending, and a factor, which is linear between them and constant outside.
    Table(Vec<[f64; 2]>),
    /// Another factor, whose time begins at this time, s; before it, the factor is that of its beginning.
    From(f64, Box<Schedule>),
}

/// Numbers of the contact law.
// The table [contact] of a model file: the first paragraphs are its reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct ContactOptions {
    /// Penalty of the contact potential over Young's modulus of the softer body. Default: 2.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1")))]
    pub penalty: f64,
    /// Tangential stiffness of contacts before they slip over their normal stiffness. Default: 0.5.
    #[cfg_attr(feature = "schema", schemars(extend("minimum" = 0, "x-unit" = "1")))]
    pub tangential_stiffness: f64,
    /// Share of critical damping of the normal motion of two elements in contact, with the masses of the two.
    /// It calms contacts that rattle. It is no coefficient of restitution: the finer the mesh, the less of
    /// the energy of an impact it takes, as the bodies are compressed themselves and the stiff contact
    /// between them stores ever less. Default: 0.
    #[cfg_attr(feature = "schema", schemars(extend("minimum" = 0, "maximum" = 1, "x-unit" = "1")))]
    pub damping: f64,
    /// Buffer of contact detection: couples with a gap up to this are kept between detections. In shares of
    /// the mean edge. Default: 0.2.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1")))]
    pub buffer: f64,
    /// How bodies that overlap at the beginning act on each other: "push", the overlap presses them apart at
    /// once; "ignore", the overlap that is there gives no force, and only an increase counts; "relax", it
    /// begins without force too, and presses the bodies apart slowly; "error", the model is refused. Bodies
    /// that a stage adds begin in the same way. Default: "push".
    pub initial_overlap: InitialOverlap,
    /// With `initial_overlap = "relax"`: time in which the part of the overlap that gives no force falls to
    /// 1/e, s. Default: 1000 time steps.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "x-unit" = "s")))]
    pub overlap_time: Option<f64>,
}

/// The action of bodies on each other that overlap at the beginning of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum InitialOverlap {
    /// It presses the bodies apart at once.
    #[default]
    Push,
    /// Forces begin at zero with this overlap, and follow its increase. Where the bodies move apart, less
    /// of it remains; after they have parted, their contact is like any other.
    Ignore,
    /// The same, but the overlap that gives no force decreases: that of each couple falls to 1/e in a time,
    /// [`ContactOptions::overlap_time`]. Forces grow slowly, and press the bodies apart. The work that
    /// this brings into the model is in that of loads and boundaries.
    Relax,
    /// `fdem-model` refuses the model. A [`Simulation`](crate::Simulation) does not look for overlaps.
    Error,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self {
            penalty: 2.0,
            tangential_stiffness: 0.5,
            damping: 0.0,
            buffer: 0.2,
            initial_overlap: InitialOverlap::Push,
            overlap_time: None,
        }
    }
}

impl ContactOptions {
    /// Time in which the part of an initial overlap that gives no force falls to 1/e, s. `step`: time step,
    /// s.
    pub fn relaxing_time(&self, step: f64) -> f64 {
        self.overlap_time.unwrap_or(1000.0 * step)
    }
}

/// When joints are inserted between elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Insertion {
    /// When the traction across an edge, or a face, reaches the strength. There is no artificial compliance
    /// before.
    #[default]
    Adaptive,
    /// On all edges or faces, from the beginning.
    Intrinsic,
}

/// Numbers of fracture. Only materials with a strength break.
// The table [fracture] of a model file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct FractureOptions {
    /// Where joints are: "adaptive" (the default) inserts one where the traction across an edge, or a face,
    /// reaches the strength; "intrinsic" has them everywhere from the start.
    pub insertion: Insertion,
    /// Penalty of joints, the α of α E/h, where h is the mean height of the two elements over the edge.
    /// Default: 50.
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0, "x-unit" = "1")))]
    pub joint_penalty: f64,
    /// Critical opening of joints: "exact" (the default), with which a joint dissipates the fracture energy
    /// G, or "customary" (3 G/f), with which it dissipates 1.16 G.
    pub critical_opening: CriticalOpening,
}

impl Default for FractureOptions {
    fn default() -> Self {
        Self { insertion: Insertion::Adaptive, joint_penalty: 50.0, critical_opening: CriticalOpening::Exact }
    }
}

/// Critical opening of a joint as a function of its fracture energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CriticalOpening {
    /// The opening with which a joint dissipates the fracture energy.
    #[default]
    Exact,
    /// The customary 3 G/f, with which a joint dissipates 1.16 G.
    Customary,
}

/// Options of the integration in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeOptions {
    /// Time step, s; `None` for the critical one times `safety`.
    pub step: Option<f64>,
    /// Share of the critical time step, above 0 and at most 1.
    pub safety: f64,
    /// Local damping of nodes (Cundall): a force against their motion, as a share of the force on them; 0 for
    /// none.
    pub local_damping: f64,
    /// Whether the run goes to a state of rest by dynamic relaxation: a force against the velocity of each
    /// node, whose factor follows the slowest motion (Underwood 1983).
    pub dynamic_relaxation: bool,
    /// Error of the energy balance at which a run stops, as a share of the energy exchanged.
    pub energy_bound: f64,
}

impl Default for TimeOptions {
    fn default() -> Self {
        Self { step: None, safety: 0.8, local_damping: 0.0, dynamic_relaxation: false, energy_bound: 0.05 }
    }
}
