//! Materials of spheres and walls, and the surfaces of two of them.

use serde::{Deserialize, Serialize};

/// A material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrainMaterial {
    /// kg/m³; not read for walls.
    pub density: f64,
    /// Pa; infinite for a rigid wall.
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poissons_ratio: f64,
}

/// Properties of the surfaces of two materials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surfaces {
    /// The materials, by their numbers.
    pub materials: [u32; 2],
    /// Coefficient of restitution, above 0 and at most 1: speed after an impact along the normal over that
    /// before.
    pub restitution: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of rolling friction: largest moment against rolling over the reduced radius and the force.
    pub rolling_friction: f64,
    /// Damping of rolling that has not reached that moment, over the critical one.
    pub rolling_damping: f64,
    /// Coefficient of twisting friction: the same for spinning about the normal.
    pub twisting_friction: f64,
    /// Work of adhesion, J/m²: the energy of both surfaces less that of their contact. Only with Hertz's law,
    /// which then is that of Johnson, Kendall and Roberts.
    pub adhesion: f64,
}

impl Surfaces {
    /// Surfaces of two materials without friction, damping and adhesion.
    pub const fn smooth(materials: [u32; 2]) -> Self {
        Self {
            materials,
            restitution: 1.0,
            friction: 0.0,
            rolling_friction: 0.0,
            rolling_damping: 0.0,
            twisting_friction: 0.0,
            adhesion: 0.0,
        }
    }
}

/// The law of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum ForceLaw {
    /// Hertz along the normal, Mindlin across it, from the moduli of the materials.
    #[default]
    HertzMindlin,
    /// Linear springs.
    Hooke {
        /// Stiffness along the normal, N/m.
        normal: f64,
        /// Stiffness across it over that along it.
        tangential: f64,
    },
}
