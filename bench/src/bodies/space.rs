//! Bodies of tetrahedra.

use fdem_simulation::{Insertion, Mesh, Model};

use super::failing::Failing;
use super::parts::{CELL, calm, of_rock, pressed};

/// Cells along each edge of a fragment of the debris, and of one among fewer elements than [`FEW`]: there is
/// about one contact for each element, or more.
const DEBRIS: [usize; 2] = [10, 4];

/// With fewer elements the debris has smaller fragments: of the larger ones there would be so few that most
/// of their surface would be at the walls.
const FEW: usize = 50_000;

/// The body of tetrahedra that is simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// A cube that vibrates.
    Cube,
    /// The same cube, which could break: every face is checked, but no joint is inserted.
    CubeAdaptive,
    /// The same cube with joints on all faces from the beginning.
    CubeJoined,
    /// Cubes of 6,000 elements, or of 384 if there are few elements, which press each other on all sides in a
    /// box that shrinks.
    Debris,
    /// A cube at 0.9 of its strength.
    CubeNear,
    /// A cube with joints on all faces, a tenth of which soften.
    CubeSoftening,
    /// A cube that comes to pieces while it is timed.
    CubeBreaking,
    /// A cube that a blast has broken to pieces, which collide.
    CubeBlown,
}

impl Space {
    /// All bodies.
    pub const ALL: [Self; 8] = [
        Self::Cube,
        Self::CubeAdaptive,
        Self::CubeJoined,
        Self::Debris,
        Self::CubeNear,
        Self::CubeSoftening,
        Self::CubeBreaking,
        Self::CubeBlown,
    ];

    /// The name, without spaces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cube => "cube",
            Self::CubeAdaptive => "cube-adaptive",
            Self::CubeJoined => "cube-joined",
            Self::Debris => "debris",
            Self::CubeNear => "cube-near",
            Self::CubeSoftening => "cube-softening",
            Self::CubeBreaking => "cube-breaking",
            Self::CubeBlown => "cube-blown",
        }
    }

    /// A short description.
    pub fn what(self) -> &'static str {
        match self {
            Self::Cube => "3D: elastic cube, ringing",
            Self::CubeAdaptive => "3D: cube that may break anywhere, and does not yet",
            Self::CubeJoined => "3D: cube, ringing, joints on every face",
            Self::Debris => "3D: elastic fragments that press each other in a box that shrinks",
            Self::CubeNear => "3D: cube at 0.9 of its strength",
            Self::CubeSoftening => "3D: cube, joints on every face, a tenth of them soften",
            Self::CubeBreaking => "3D: cube that comes to pieces",
            Self::CubeBlown => "3D: debris after a blast: elements that collide, no joint holds",
        }
    }

    /// The state of a cube near its strength; `None` for other bodies.
    fn failing(self) -> Option<Failing> {
        match self {
            Self::CubeNear => Some(Failing::Near),
            Self::CubeSoftening => Some(Failing::Softening),
            Self::CubeBreaking => Some(Failing::Breaking),
            Self::CubeBlown => Some(Failing::Blown),
            Self::Cube | Self::CubeAdaptive | Self::CubeJoined | Self::Debris => None,
        }
    }

    /// The model, with approximately this number of elements.
    pub fn model(self, elements: usize) -> Model<3, 4> {
        let count = |x: f64| (x.round() as usize).max(1);
        if self == Self::Debris {
            let odd = |number: usize, shift: f64| if number.is_multiple_of(2) { 0.0 } else { shift };
            let shift =
                |[_, row, layer]: [usize; 3]| [odd(row, 0.45) + odd(layer, 0.23), odd(layer, 0.37), 0.0];
            let cells = DEBRIS[usize::from(elements < FEW)];
            let along = count((elements as f64 / 6.0).cbrt() / cells as f64).max(2);
            let (mesh, velocities, boundaries) = pressed(&cubes(cells), along, shift);
            return calm(Model { boundaries, ..of_rock(mesh, velocities, false, Insertion::Adaptive) });
        }
        let mesh = cubes(count((elements as f64 / 6.0).cbrt()));
        if let Some(failing) = self.failing() {
            return failing.model(mesh);
        }
        let speed = |[x, y, z]: [f64; 3]| [(300.0 * x).sin(), (200.0 * y).cos(), (250.0 * z).sin()];
        let velocities = mesh.nodes.iter().map(|&node| speed(node).map(|v| 0.01 * v)).collect();
        let insertion = if self == Self::CubeJoined { Insertion::Intrinsic } else { Insertion::Adaptive };
        of_rock(mesh, velocities, self != Self::Cube, insertion)
    }
}

/// A cube of `side`³ cubes of six tetrahedra each.
fn cubes(side: usize) -> Mesh<3, 4> {
    let along = side + 1;
    let node = |[i, j, k]: [usize; 3]| ((k * along + j) * along + i) as u32;
    let place = |number: usize| {
        [number % along, number / along % along, number / (along * along)].map(|x| x as f64 * CELL)
    };
    let nodes = (0..along.pow(3)).map(place).collect();
    // From the lowest corner of a cube to the highest, along the axes in all orders. Odd orders are mirrored.
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]];
    let mut elements = Vec::with_capacity(6 * side.pow(3));
    for cell in 0..side.pow(3) {
        let lowest = [cell % side, cell / side % side, cell / (side * side)];
        for (number, order) in orders.into_iter().enumerate() {
            let mut at = lowest;
            let mut corners = [node(at); 4];
            for (corner, axis) in corners[1..].iter_mut().zip(order) {
                at[axis] += 1;
                *corner = node(at);
            }
            if number >= 3 {
                corners.swap(1, 2);
            }
            elements.push(corners);
        }
    }
    let count = elements.len();
    Mesh { nodes, elements, bodies: vec![0; count], materials: vec![0; count] }
}
