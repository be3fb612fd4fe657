//! A cube of unstructured tetrahedra.

use fdem_mesh::shapes::cuboid;
use fdem_mesh::tetrahedra::{MeshError, tetrahedra};
use fdem_simulation::{Insertion, Mesh, Model};

use super::parts::of_rock;

/// Mean volume of an element over the cube of the requested length of edges.
const SHAPE: f64 = 0.107;

/// A cube of 1 m, meshed by the mesher of this project: its elements have many shapes, and its parts have
/// ragged surfaces, as in practice.
#[derive(Clone, Debug)]
pub struct MeshedCube {
    mesh: Mesh<3, 4>,
}

impl MeshedCube {
    /// Meshes the cube with approximately this number of elements.
    ///
    /// # Errors
    /// Options of the mesher.
    pub fn new(elements: usize) -> Result<Self, MeshError> {
        let size = (1.0 / (SHAPE * elements as f64)).cbrt();
        let cut = tetrahedra(&cuboid([0.0; 3], [1.0; 3])?, &|_| size, 1)?;
        let count = cut.elements.len();
        let mesh = Mesh {
            nodes: cut.nodes,
            elements: cut.elements,
            bodies: vec![0; count],
            materials: vec![0; count],
        };
        Ok(Self { mesh })
    }

    /// The cube, ringing: elastic, or with joints on all faces from the beginning.
    pub fn model(&self, joined: bool) -> Model<3, 4> {
        let speed = |[x, y, z]: [f64; 3]| [(3.0 * x).sin(), (2.0 * y).cos(), (2.5 * z).sin()];
        let velocities = self.mesh.nodes.iter().map(|&node| speed(node).map(|v| 0.01 * v)).collect();
        let insertion = if joined { Insertion::Intrinsic } else { Insertion::Adaptive };
        of_rock(self.mesh.clone(), velocities, joined, insertion)
    }
}
