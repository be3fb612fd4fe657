//! Fluid in the cracks of a model: its constants, the joints that it enters, and its sources.

use fdem_fluid::{ApertureLaw, Drive, FlowModel};
use serde::{Deserialize, Serialize};

/// Fluid in the cracks of a model. Its pressure acts on both faces of joints, and on the walls of holes. On
/// many ranks each computes all of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; D]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; D]: Deserialize<'de>"
))]
pub struct FluidOptions<const D: usize = 2> {
    /// The fluid, its gravity and how its steps are taken. Its thickness is that of the model.
    pub flow: FlowModel<D>,
    /// The joints that fluid can enter.
    pub wet_from: WetFrom,
    /// Number of steps of the solid in each step of the fluid, at least 1. Pressures are constant between
    /// steps of the fluid. Fluid in thin cracks becomes softer with its square: see the front page of
    /// the crate.
    pub steps: u32,
    /// Law of the aperture of joints that belong to no set, such as new cracks.
    pub aperture: ApertureLaw,
    /// The same for each joint set; empty if all sets have that of new cracks. Fluid can enter a set with an
    /// initial aperture from the beginning.
    pub set_apertures: Vec<ApertureLaw>,
    /// Carter's coefficient of leak-off through one face of a joint, m/√s.
    pub leak_off: f64,
    /// Pressure of the fluid with which joints are filled when fluid can enter them, Pa; `None` if they are
    /// empty then.
    pub initial_pressure: Option<f64>,
    /// Sources.
    pub sources: Vec<FluidSource<D>>,
}

impl<const D: usize> FluidOptions<D> {
    /// Fluid in all joints from their insertion on, a step of the fluid in each step, and no leak-off.
    pub fn new(flow: FlowModel<D>, sources: Vec<FluidSource<D>>) -> Self {
        Self {
            flow,
            wet_from: WetFrom::default(),
            steps: 1,
            aperture: ApertureLaw::default(),
            set_apertures: Vec::new(),
            leak_off: 0.0,
            initial_pressure: None,
            sources,
        }
    }

    /// A stress that closes joints, Pa: the first of all laws of the aperture; `None` if there is none.
    pub(crate) fn closing_stress(&self) -> Option<f64> {
        std::iter::once(&self.aperture).chain(&self.set_apertures).find_map(|law| law.reference_stress)
    }

    /// The fluid in a part of a model: sources have the facets that are left, and those without any are left
    /// out. `nodes`: the number in the part of each node.
    pub(crate) fn on_part(mut self, nodes: &[Option<u32>]) -> Self {
        let number = |node: u32| nodes.get(node as usize).copied().flatten();
        for source in &mut self.sources {
            source.facets.retain(|facet| facet.iter().all(|node| number(*node).is_some()));
            for node in source.facets.as_flattened_mut() {
                *node = number(*node).unwrap_or(*node);
            }
        }
        self.sources.retain(|source| !source.facets.is_empty());
        self
    }
}

/// The joints that fluid can enter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum WetFrom {
    /// New cracks from their insertion on. Joints of sets, and those of a mesh with joints everywhere, from
    /// the moment on in which they soften.
    #[default]
    Insertion,
    /// Broken joints.
    Break,
}

/// A place where fluid enters a model: a hole, or open joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[u32; D]: Serialize", deserialize = "[u32; D]: Deserialize<'de>"))]
pub struct FluidSource<const D: usize = 2> {
    /// Name, for messages; no other source has it.
    pub name: String,
    /// Facets by their nodes: the outline of a hole, around the elements as in a
    /// [`Target`](crate::Target), or facets with open joints. The pressure acts on the wall of the hole,
    /// too, whose volume is part of that of the fluid.
    pub facets: Vec<[u32; D]>,
    /// Rate or pressure; `None` for a hole that is only connected with cracks. Times are those of the run.
    pub drive: Option<Drive>,
    /// Pressure of the fluid in the hole at the beginning, Pa; `None` if it is empty.
    pub initial_pressure: Option<f64>,
}
