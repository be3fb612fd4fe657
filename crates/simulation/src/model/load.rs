//! The loads that boundaries exert. A new load needs a variant, and an arm of [`Load::summary`].

use serde::{Deserialize, Serialize};

/// Action of a [`Boundary`](crate::Boundary). Components that are `None` are free.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [Option<f64>; D]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [Option<f64>; D]: Deserialize<'de>"
))]
pub enum Load<const D: usize = 2> {
    /// Prescribes the velocity of nodes, m/s. Zero holds them.
    Velocity([Option<f64>; D]),
    /// Prescribes the displacement of nodes, m.
    Displacement([Option<f64>; D]),
    /// Turns nodes about a fixed axis: exactly along circles, in whichever steps. A rigid body turns as a
    /// whole. The schedule is that of the angular velocity.
    Rotation {
        /// Angular velocity, rad/s. In two dimensions only the third component counts.
        spin: [f64; 3],
        /// A point on the axis, m.
        through: [f64; D],
    },
    /// A total force, N, shared equally by the nodes.
    Force([f64; D]),
    /// A traction on facets, Pa, in a fixed direction, per measure of the undeformed facet.
    Traction([f64; D]),
    /// A pressure on facets, Pa, against the outward normal of the deformed facet.
    Pressure(f64),
    /// A pressure, Pa, on facets and on the faces of all broken joints that are connected with them, against
    /// their outward normals. Facets between elements stand for open joints with which the cavity begins.
    /// `gas`: ratio of the specific heats of a gas, above 1, which has this pressure at the beginning and
    /// then follows its volume instead of the schedule.
    Cavity {
        /// Pressure, Pa.
        pressure: f64,
        /// Ratio of the specific heats; `None` for a pressure that follows the schedule.
        gas: Option<f64>,
    },
    /// Facets that let waves out: dashpots of the material's impedances (Lysmer and Kuhlemeyer, 1969), the
    /// static force of the beginning, and springs as stiff as the ground beyond.
    Absorbing,
    /// Forces that are given node by node: [`Target::Held`](crate::Target::Held). They replace the support of
    /// an excavated part or of a boundary that has ended.
    Held,
}

/// Effect of a load on the nodes or facets of its boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadEffect {
    /// Nodes have a velocity, m/s.
    Velocity,
    /// Nodes have a displacement, m.
    Displacement,
    /// The nodes share a force, N.
    Force,
    /// Facets carry a stress, Pa.
    Stress,
    /// Facets are supported, by a ground or by forces of their own.
    Support,
}

/// The properties of a load that checks and advice need.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSummary {
    /// Key of the model file that has its size.
    pub key: &'static str,
    /// Effect on nodes or facets.
    pub effect: LoadEffect,
    /// Components that are not free, m/s, m, N or Pa; none for a support or a rotation.
    pub components: Vec<f64>,
    /// Whether it acts on facets; on nodes otherwise.
    pub on_facets: bool,
}

impl<const D: usize> Load<D> {
    /// The properties that checks and advice need.
    pub fn summary(&self) -> LoadSummary {
        let given = |components: &[Option<f64>; D]| components.iter().copied().flatten().collect();
        let (key, effect, components) = match self {
            Self::Velocity(velocity) => ("velocity", LoadEffect::Velocity, given(velocity)),
            Self::Displacement(goal) => ("displacement", LoadEffect::Displacement, given(goal)),
            Self::Rotation { .. } => ("rotation", LoadEffect::Velocity, Vec::new()),
            Self::Force(force) => ("force", LoadEffect::Force, force.to_vec()),
            Self::Traction(traction) => ("traction", LoadEffect::Stress, traction.to_vec()),
            Self::Pressure(pressure) | Self::Cavity { pressure, .. } => {
                ("pressure", LoadEffect::Stress, vec![*pressure])
            }
            Self::Absorbing => ("absorbing", LoadEffect::Support, Vec::new()),
            Self::Held => ("held", LoadEffect::Support, Vec::new()),
        };
        let on_facets = matches!(effect, LoadEffect::Stress | LoadEffect::Support);
        LoadSummary { key, effect, components, on_facets }
    }

    /// Whether it is a rotation about an axis.
    pub(crate) fn is_rotation(&self) -> bool {
        matches!(self, Self::Rotation { .. })
    }

    /// Whether it prescribes how nodes move.
    pub fn moves_nodes(&self) -> bool {
        matches!(self, Self::Velocity(_) | Self::Displacement(_) | Self::Rotation { .. })
    }
}

/// Key and name of each term of the energy balance in which loads store energy of their own. A run that has
/// no such load has no such term.
pub const STORED: [(&str, &str); 1] = [("gas", "gas")];

/// A place in [`STORED`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stored {
    Gas,
}
