//! The state of a run at one instant, as results show it.

/// Positions, motion, stress and cracks at one instant. SI units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// Steps done.
    pub step: u64,
    /// Time, s.
    pub time: f64,
    /// Positions of the nodes, m. A node of the mesh becomes several nodes where the mesh has broken.
    pub positions: Vec<[f64; 2]>,
    /// Displacements of the nodes, m.
    pub displacements: Vec<[f64; 2]>,
    /// Velocities of the nodes, m/s.
    pub velocities: Vec<[f64; 2]>,
    /// Nodes of each element, counter-clockwise.
    pub elements: Vec<[u32; 3]>,
    /// Cauchy stress of each element, `[xx, yy, xy, zz]` in Pa, tension positive.
    pub stresses: Vec<[f64; 4]>,
    /// Largest damage of the joints of each element, from 0 to 1.
    pub damage: Vec<f64>,
    /// Body of each element.
    pub bodies: Vec<u32>,
    /// Material of each element.
    pub materials: Vec<u32>,
    /// Fragment of each element: elements that hang together by edges have one number. Numbers count from 0 in the order of the first element of each fragment.
    pub fragments: Vec<u32>,
    /// Joints that are softening or broken.
    pub cracks: Vec<Crack>,
}

/// A joint that has passed its strength, on an edge between two elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crack {
    /// Current positions of its ends, m, half way between the two elements.
    pub ends: [[f64; 2]; 2],
    /// Elements on its two sides.
    pub elements: [u32; 2],
    /// Damage from 0 (whole) to 1 (broken), the mean of its two ends.
    pub damage: f64,
    /// Mode of failure.
    pub mode: Mode,
    /// Mean opening, m; negative where it is closed.
    pub opening: f64,
    /// Mean sliding, m.
    pub sliding: f64,
    /// Time of failure, s; `None` while the joint holds.
    pub time: Option<f64>,
    /// Length of the undeformed edge, m.
    pub length: f64,
}

/// Mode of failure of a joint, by the shares of opening and sliding in its damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// At least three quarters by opening (mode I).
    Tension,
    /// At least three quarters by sliding (mode II).
    Shear,
    /// Neither has three quarters.
    Mixed,
}
