//! The state of a run at one instant, as results show it.

/// Positions, motion, stress and cracks at one instant. SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Steps done.
    pub step: u64,
    /// s.
    pub time: f64,
    /// Where the nodes are, m. Nodes of a mesh that has broken there come several times.
    pub positions: Vec<[f64; 2]>,
    /// How far each has moved, m.
    pub displacements: Vec<[f64; 2]>,
    /// m/s.
    pub velocities: Vec<[f64; 2]>,
    /// Nodes of each element, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Cauchy stress of each element, `[xx, yy, xy, zz]` in Pa, tension positive.
    pub stresses: Vec<[f64; 4]>,
    /// Of each element: the largest damage of its joints, 0 to 1.
    pub damage: Vec<f64>,
    /// Of each element.
    pub bodies: Vec<u32>,
    /// Of each element.
    pub materials: Vec<u32>,
    /// Joints that soften or are broken.
    pub cracks: Vec<Crack>,
}

/// A joint beyond its strength: an edge that was common to two elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crack {
    /// Its ends now, m: half way between the two elements.
    pub ends: [[f64; 2]; 2],
    /// On either side.
    pub elements: [u32; 2],
    /// 0 whole, 1 broken: the mean of its two ends.
    pub damage: f64,
    /// How it broke, or breaks.
    pub mode: Mode,
    /// Mean opening, m; negative where it is closed.
    pub opening: f64,
    /// Mean sliding, m.
    pub sliding: f64,
    /// When it broke, s; `None` if it still holds.
    pub time: Option<f64>,
    /// Of the undeformed edge, m.
    pub length: f64,
}

/// How a joint breaks: by what its damage is of, when it broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// At least three quarters by opening (mode I).
    Tension,
    /// At least three quarters by sliding (mode II).
    Shear,
    /// Between.
    Mixed,
}
