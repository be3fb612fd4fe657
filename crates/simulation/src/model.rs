//! What is simulated: a mesh, materials, what acts on it. Numbers only; files are read elsewhere.

use serde::{Deserialize, Serialize};

/// A two-dimensional model, complete. SI units: m, kg, s, Pa.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// Bodies, meshed.
    pub mesh: Mesh,
    /// What the elements are made of.
    pub materials: Vec<Material>,
    /// Pairs of materials whose contacts and joints are not the lesser of what the two materials say.
    pub interfaces: Vec<Interface>,
    /// What holds, moves and loads the bodies.
    pub boundaries: Vec<Boundary>,
    /// Stress or strain that vanishes out of the plane.
    pub plane: Plane,
    /// Out of the plane, m.
    pub thickness: f64,
    /// Acceleration, m/s².
    pub gravity: [f64; 2],
    /// Velocity of each node at the beginning, m/s; empty for none.
    pub velocities: Vec<[f64; 2]>,
    /// Stress of each element at the beginning, `[xx, yy, xy]` in Pa, tension positive; empty for none.
    pub stresses: Vec<[f64; 3]>,
    /// How bodies touch.
    pub contact: ContactOptions,
    /// How they break.
    pub fracture: FractureOptions,
    /// Steps in time.
    pub time: TimeOptions,
}

impl Model {
    /// What is said of the contacts and joints of two materials, if anything is.
    pub(crate) fn interface(&self, a: u32, b: u32) -> Option<&Interface> {
        self.interfaces
            .iter()
            .find(|interface| interface.materials == [a, b] || interface.materials == [b, a])
    }
}

impl Default for Model {
    /// Nothing yet, 1 m thick, without gravity.
    fn default() -> Self {
        Self {
            mesh: Mesh::default(),
            materials: Vec::new(),
            interfaces: Vec::new(),
            boundaries: Vec::new(),
            plane: Plane::default(),
            thickness: 1.0,
            gravity: [0.0; 2],
            velocities: Vec::new(),
            stresses: Vec::new(),
            contact: ContactOptions::default(),
            fracture: FractureOptions::default(),
            time: TimeOptions::default(),
        }
    }
}

/// Triangles, which share nodes where their bodies are whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Coordinates of the nodes, m. No two triangles of different bodies share one.
    pub nodes: Vec<[f64; 2]>,
    /// Nodes of each element, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Body of each element.
    pub bodies: Vec<u32>,
    /// Material of each element.
    pub materials: Vec<u32>,
}

/// What vanishes out of the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Plane {
    /// The stress: a thin plate.
    #[default]
    Stress,
    /// The strain: a slice of a long body.
    Strain,
}

/// An elastic material that may break.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// For people.
    pub name: String,
    /// kg/m³.
    pub density: f64,
    /// Pa.
    pub youngs_modulus: f64,
    /// From above -1 to 0.5; in plane strain below 0.5.
    pub poissons_ratio: f64,
    /// Share of critical damping of an element's fastest mode by its viscosity; 0 for none.
    pub damping: f64,
    /// `None`: it does not break.
    pub strength: Option<Strength>,
    /// Coefficient of friction where it touches, unless an [`Interface`] says otherwise.
    pub friction: f64,
}

/// When and how a material breaks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// Pa.
    pub tensile: f64,
    /// Pa.
    pub cohesion: f64,
    /// Tangent of the angle of internal friction.
    pub friction: f64,
    /// Fracture energy of opening, J/m².
    pub energy_i: f64,
    /// Fracture energy of sliding, beyond friction, J/m².
    pub energy_ii: f64,
    /// Weibull modulus of tensile strength and cohesion, edge by edge, with a mean of 1; `None` for no scatter.
    pub weibull_modulus: Option<f64>,
    /// Seed of that scatter.
    pub seed: u64,
}

/// Contacts between two materials, and the joint between two elements of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interface {
    /// The two materials; they may be the same.
    pub materials: [u32; 2],
    /// Coefficient of friction of contacts.
    pub friction: f64,
    /// Penalty of contacts, Pa; `None`: as [`ContactOptions::penalty`] says.
    pub penalty: Option<f64>,
    /// Strength of the joints between the two; `None`: the lesser of the two materials.
    pub strength: Option<Strength>,
}

/// What acts on nodes or edges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// For people.
    pub name: String,
    /// Where.
    pub target: Target,
    /// What.
    pub load: Load,
    /// When.
    pub schedule: Schedule,
}

/// Where a [`Boundary`] acts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    /// On nodes of the mesh.
    Nodes(Vec<u32>),
    /// On edges of elements: nodes of the mesh in the direction in which their element has them.
    Edges(Vec<[u32; 2]>),
}

/// What a [`Boundary`] does. Components that are `None` are free.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Load {
    /// Moves nodes with this velocity times the schedule, m/s. Zero holds them.
    Velocity([Option<f64>; 2]),
    /// Moves nodes from where they were by this times the schedule, m.
    Displacement([Option<f64>; 2]),
    /// In all, N, on the nodes in equal parts.
    Force([f64; 2]),
    /// On edges, Pa, in fixed directions; per length of the undeformed edge.
    Traction([f64; 2]),
    /// On edges, Pa, against the outward normal of the deformed edge.
    Pressure(f64),
    /// Edges that let waves out: dashpots of the material's impedances (Lysmer and Kuhlemeyer, 1969).
    Absorbing,
}

/// The factor of a [`Load`] in time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Schedule {
    /// 1.
    #[default]
    Constant,
    /// From 0 to 1 as half a cosine within this time, s; 1 afterwards.
    Ramp(f64),
    /// Times, s, ascending, with factors: linear between them, constant outside.
    Table(Vec<[f64; 2]>),
}

/// How bodies touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactOptions {
    /// Penalty of the potential over Young's modulus (of the softer of two).
    pub penalty: f64,
    /// Stiffness of friction before it slips over that of the contact.
    pub tangential_stiffness: f64,
    /// Share of critical damping of normal contact motion; 0 for none.
    pub damping: f64,
    /// Gap up to which couples are kept between detections over the mean edge.
    pub buffer: f64,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self { penalty: 2.0, tangential_stiffness: 0.5, damping: 0.0, buffer: 0.2 }
    }
}

/// Which joints there are between elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Insertion {
    /// Where the traction across an edge has reached the strength: no compliance before.
    #[default]
    Adaptive,
    /// Everywhere from the beginning.
    Intrinsic,
}

/// How bodies break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FractureOptions {
    /// Which joints there are.
    pub insertion: Insertion,
    /// Penalty of joints, α of α E/h, with h the mean height of the two elements over the edge.
    pub joint_penalty: f64,
    /// How the critical opening follows from the fracture energy.
    pub critical_opening: CriticalOpening,
}

impl Default for FractureOptions {
    fn default() -> Self {
        Self { insertion: Insertion::Adaptive, joint_penalty: 50.0, critical_opening: CriticalOpening::Exact }
    }
}

/// How the critical opening follows from the fracture energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CriticalOpening {
    /// A joint dissipates the fracture energy.
    #[default]
    Exact,
    /// 3 G/f, as is customary: a joint dissipates 1.16 G.
    Customary,
}

/// Steps in time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeOptions {
    /// s; `None`: the critical one times `safety`.
    pub step: Option<f64>,
    /// Of the critical time step, from above 0 to 1.
    pub safety: f64,
    /// Damping of nodes against their motion, share of the force (Cundall); 0 for none.
    pub local_damping: f64,
    /// Energy that may appear or vanish, as a share of what has been in the system, before a run stops.
    pub energy_bound: f64,
}

impl Default for TimeOptions {
    fn default() -> Self {
        Self { step: None, safety: 0.8, local_damping: 0.0, energy_bound: 0.05 }
    }
}
