//! Spheres at one instant, for results.

use serde::{Deserialize, Serialize};

use crate::wall::Wall;

/// Spheres, their contacts and the walls at one instant. SI units. All lists of spheres are in the order of
/// the spheres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SphereColumns {
    /// Number of each sphere, ascending: a sphere keeps it for the whole run.
    pub numbers: Vec<u32>,
    /// Centres, m.
    pub positions: Vec<[f64; 3]>,
    /// m.
    pub radii: Vec<f64>,
    /// m/s.
    pub velocities: Vec<[f64; 3]>,
    /// Angular velocities, rad/s.
    pub spins: Vec<[f64; 3]>,
    /// Forces of all contacts, N.
    pub forces: Vec<[f64; 3]>,
    /// kg.
    pub masses: Vec<f64>,
    /// Numbers of the materials.
    pub materials: Vec<u32>,
    /// Numbers of the groups.
    pub groups: Vec<u32>,
    /// Names of the groups; may be empty.
    pub group_names: Vec<String>,
    /// Contacts in ascending order of their spheres; those of two spheres first, then those with walls, then
    /// those with bodies. Spheres and partners by their places in these lists.
    pub contacts: Vec<GrainContact>,
    /// The walls where they are.
    pub walls: Vec<Wall>,
    /// Force of the spheres on each wall, N.
    pub wall_forces: Vec<[f64; 3]>,
    /// Thickness of discs, m; `None` for spheres.
    pub discs: Option<f64>,
    /// The periodic box: its lowest corner and its lengths, m, infinite along axes that do not repeat; `None`
    /// without one.
    pub period: Option<[[f64; 3]; 2]>,
}

/// A contact of a sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrainContact {
    /// The sphere.
    pub sphere: u32,
    /// The other body of the contact.
    pub other: GrainPartner,
    /// Where they touch, m.
    pub place: [f64; 3],
    /// Force on the sphere, N.
    pub force: [f64; 3],
    /// Part of the force along the normal, N; positive for pressure.
    pub normal: f64,
    /// Depth by which the two overlap, m.
    pub overlap: f64,
}

impl SphereColumns {
    /// A vector between two places, m, or to the nearest image of the second in a box that repeats.
    pub fn shortest(&self, apart: [f64; 3]) -> [f64; 3] {
        let Some([_, lengths]) = self.period else { return apart };
        let along = |axis: usize| {
            let periods = (apart[axis] / lengths[axis]).round();
            // Along an axis that does not repeat the length is infinite.
            if periods == 0.0 { apart[axis] } else { apart[axis] - periods * lengths[axis] }
        };
        [along(0), along(1), along(2)]
    }
}

/// A thing that a sphere touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum GrainPartner {
    /// A sphere with a higher number.
    Sphere(u32),
    /// A wall.
    Wall(u32),
    /// A body, at a facet of its [`Surface`](crate::Surface).
    Facet(u32),
}
