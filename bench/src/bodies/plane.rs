//! Bodies of triangles.

use fdem_simulation::{Insertion, Mesh, Model};

use super::failing::Failing;
use super::parts::{CELL, calm, moved, of_rock, pressed, together};

/// The body of triangles that is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Plane {
    /// A bar, 50 times as long as high, whose left half collides with its right half: waves.
    Bar,
    /// A disc that vibrates.
    Disc,
    /// The same disc with joints on all edges from the beginning.
    Joined,
    /// A square that vibrates and could break: every edge is checked, but no joint is inserted.
    Adaptive,
    /// Two colliding squares with joints on all edges from the beginning.
    Intrinsic,
    /// Fragments of 18 elements with joints on all edges, which press each other on all sides in a box that
    /// shrinks.
    Heap,
    /// A square at 0.9 of its strength.
    Near,
    /// A square with joints on all edges, a tenth of which soften.
    Softening,
    /// A square that comes to pieces while it is timed.
    Breaking,
    /// A square that a blast has broken to pieces, which collide.
    Blown,
}

impl Plane {
    /// All bodies.
    pub const ALL: [Self; 10] = [
        Self::Bar,
        Self::Disc,
        Self::Joined,
        Self::Adaptive,
        Self::Intrinsic,
        Self::Heap,
        Self::Near,
        Self::Softening,
        Self::Breaking,
        Self::Blown,
    ];

    /// The name in one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bar => "bar",
            Self::Disc => "disc",
            Self::Joined => "joined",
            Self::Adaptive => "adaptive",
            Self::Intrinsic => "intrinsic",
            Self::Heap => "heap",
            Self::Near => "near",
            Self::Softening => "softening",
            Self::Breaking => "breaking",
            Self::Blown => "blown",
        }
    }

    /// A short description.
    pub fn what(self) -> &'static str {
        match self {
            Self::Bar => "elastic bar, 50 : 1, waves",
            Self::Disc => "elastic disc, ringing",
            Self::Joined => "disc, ringing, joints on every edge",
            Self::Adaptive => "square that may break anywhere, and does not yet",
            Self::Intrinsic => "two squares that collide, joints on every edge",
            Self::Heap => "fragments of 18 elements that press each other, joints on every edge",
            Self::Near => "square at 0.9 of its strength",
            Self::Softening => "square, joints on every edge, a tenth of them soften",
            Self::Breaking => "square that comes to pieces",
            Self::Blown => "debris after a blast: elements that collide, no joint holds",
        }
    }

    /// Whether it has joints on all edges from the beginning.
    pub fn has_joints(self) -> bool {
        matches!(self, Self::Joined | Self::Intrinsic | Self::Heap | Self::Softening)
    }

    /// The model, with approximately this number of elements.
    pub fn model(self, elements: usize) -> Model {
        let cells = elements as f64 / 2.0;
        let side = cells.sqrt();
        let count = |x: f64| (x.round() as usize).max(1);
        let square = |side: f64| grid(count(side), count(side));
        let mut boundaries = Vec::new();
        let (mesh, velocities) = match self {
            Self::Bar => {
                let mesh = grid(count((cells * 50.0).sqrt()), count((cells / 50.0).sqrt()));
                let middle = 0.5 * mesh.nodes.iter().map(|node| node[0]).fold(0.0, f64::max);
                let velocities = mesh.nodes.iter().map(|&[x, _]| [if x < middle { 1.0 } else { 0.0 }, 0.0]);
                (mesh.clone(), velocities.collect())
            }
            Self::Disc | Self::Joined => {
                let mesh = round(square(side));
                let velocities = ringing(&mesh);
                (mesh, velocities)
            }
            Self::Adaptive => {
                let mesh = square(side);
                let velocities = ringing(&mesh);
                (mesh, velocities)
            }
            Self::Intrinsic => {
                let lower = square((cells / 2.0).sqrt());
                let height = lower.nodes.iter().map(|node| node[1]).fold(0.0, f64::max);
                // Shifted, so that nodes do not meet nodes.
                let upper = moved(&lower, [0.37 * CELL, height]);
                let mesh = together(&[lower, upper]);
                let velocities = mesh
                    .nodes
                    .iter()
                    .zip(owners(&mesh))
                    .map(|(_, body)| [0.0, [0.2, -0.2][body as usize]])
                    .collect();
                (mesh, velocities)
            }
            Self::Near => return Failing::Near.model(square(side)),
            Self::Softening => return Failing::Softening.model(square(side)),
            Self::Breaking => return Failing::Breaking.model(square(side)),
            Self::Blown => return Failing::Blown.model(square(side)),
            Self::Heap => {
                let shift = |[_, row]: [usize; 2]| [if row % 2 == 0 { 0.0 } else { 0.45 }, 0.0];
                let (mesh, velocities, walls) =
                    pressed(&grid(3, 3), count((elements as f64 / 18.0).sqrt()), shift);
                boundaries = walls;
                (mesh, velocities)
            }
        };
        let breaks = !matches!(self, Self::Bar | Self::Disc);
        let insertion = if self.has_joints() { Insertion::Intrinsic } else { Insertion::Adaptive };
        let model = Model { boundaries, ..of_rock(mesh, velocities, breaks, insertion) };
        if self == Self::Heap { calm(model) } else { model }
    }
}

/// A grid of squares of two triangles each.
fn grid(columns: usize, rows: usize) -> Mesh {
    let node = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    let nodes =
        (0..=rows).flat_map(|j| (0..=columns).map(move |i| [i as f64 * CELL, j as f64 * CELL])).collect();
    let mut elements = Vec::with_capacity(2 * columns * rows);
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            elements.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}

/// Maps a square to a disc: squares around its middle become circles.
fn round(mesh: Mesh) -> Mesh {
    let half = 0.5 * mesh.nodes.iter().map(|node| node[0]).fold(0.0, f64::max);
    let nodes = mesh.nodes.iter().map(|node| {
        let [x, y] = node.map(|x| x / half - 1.0);
        [half * x * (1.0 - 0.5 * y * y).sqrt(), half * y * (1.0 - 0.5 * x * x).sqrt()]
    });
    Mesh { nodes: nodes.collect(), ..mesh }
}

fn ringing(mesh: &Mesh) -> Vec<[f64; 2]> {
    mesh.nodes.iter().map(|&[x, y]| [0.01 * (300.0 * x).sin(), 0.01 * (200.0 * y).cos()]).collect()
}

/// The body of each node.
fn owners(mesh: &Mesh) -> Vec<u32> {
    let mut owners = vec![0; mesh.nodes.len()];
    for (nodes, &body) in mesh.elements.iter().zip(&mesh.bodies) {
        for &node in nodes {
            owners[node as usize] = body;
        }
    }
    owners
}
