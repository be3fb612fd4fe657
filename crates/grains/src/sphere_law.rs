//! Forces between spheres by a law of the caller.

/// The couples of spheres of a step, and the forces that a law of the caller gives them. Each list has one
/// entry for each couple, in ascending order of the numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpherePairs {
    /// Time of the positions, s.
    pub time: f64,
    /// Time step, s.
    pub step: f64,
    /// Numbers of the first and the second sphere; the first has the lower one.
    pub spheres: Vec<[u32; 2]>,
    /// Numbers of their materials.
    pub materials: Vec<[u32; 2]>,
    /// m.
    pub radii: Vec<[f64; 2]>,
    /// kg; of a sphere in a clump, that of the clump.
    pub masses: Vec<[f64; 2]>,
    /// From the second sphere to the first, of unit length.
    pub normals: Vec<[f64; 3]>,
    /// m; negative if the spheres are apart.
    pub overlaps: Vec<f64>,
    /// Velocity of the first over that of the second where they touch, m/s.
    pub velocities: Vec<[f64; 3]>,
    /// Angular velocities of both, rad/s.
    pub spins: Vec<[[f64; 3]; 2]>,
    /// The numbers that the law has left for each couple in the last step, one row after the other; 0 for a
    /// couple that is new.
    pub memory: Vec<f64>,
    /// Force on the first, N, in the middle of the overlap or of the gap; the opposite acts on the second. 0
    /// before the call.
    pub forces: Vec<[f64; 3]>,
    /// Moment on the first, N m, besides that of the force; the opposite acts on the second. 0 before the
    /// call.
    pub moments: Vec<[f64; 3]>,
}

/// A law of the caller: it sets the forces, the moments and the memory of all couples of a step, or says why
/// it cannot.
pub type SphereLaw = Box<dyn FnMut(&mut SpherePairs) -> Result<(), String> + Send + Sync>;

/// The reach of a law of the caller, its memory, and whether it replaces the law of the model.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SphereLawOptions {
    /// Gap up to which the law gets couples, m; 0 for those that touch.
    pub reach: f64,
    /// Numbers that it keeps for each couple.
    pub columns: usize,
    /// Whether it acts in place of the law of the model, and not besides it.
    pub replaces: bool,
}
