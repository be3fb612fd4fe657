//! The stage that a run is in, and the displacements from which its results count.

use fdem_simulation::{Boundary, Element, Simulation, Snapshot};
use serde::{Deserialize, Serialize};

/// The stage that a run is in, and the data that it has kept of the earlier ones.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "Boundary<D>: Serialize, [f64; D]: Serialize",
    deserialize = "Boundary<D>: Deserialize<'de>, [f64; D]: Deserialize<'de>"
))]
pub struct Entered<const D: usize = 2> {
    /// Step at which each stage so far has begun; the last of them is the present one.
    pub begun: Vec<u64>,
    /// Forces of removed parts, on nodes of the whole model.
    pub held: Vec<Boundary<D>>,
    /// Displacements at the last stage that has set them back.
    pub origin: Option<Origin<D>>,
}

/// Displacements, m, from which those of results count.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; D]: Serialize", deserialize = "[f64; D]: Deserialize<'de>"))]
pub struct Origin<const D: usize = 2> {
    /// One displacement for each corner of each element, in the order of the elements. Corners at one node of
    /// the mesh differ where the mesh has broken.
    pub corners: Vec<[f64; D]>,
    /// One displacement for each node of the mesh.
    pub nodes: Vec<[f64; D]>,
}

impl<const D: usize> Origin<D> {
    /// The displacements of a run now. `elements`, `nodes`: numbers of its elements and of the nodes of its
    /// mesh in the whole model; `counts`: numbers of elements and nodes of the whole model.
    pub fn of<const N: usize>(
        run: &Simulation<D, N>,
        (elements, nodes): (&[u32], &[u32]),
        counts: [usize; 2],
    ) -> Self
    where
        [[f64; D]; N]: Element<D, N>,
    {
        let mut corners = vec![[0.0; D]; N * counts[0]];
        let snapshot = run.snapshot();
        for (&element, its_nodes) in elements.iter().zip(&snapshot.elements) {
            let of_element = &mut corners[N * element as usize..][..N];
            of_element.copy_from_slice(&its_nodes.map(|node| snapshot.displacements[node as usize]));
        }
        let mut of_nodes = vec![[0.0; D]; counts[1]];
        let own: Vec<u32> = (0..nodes.len() as u32).collect();
        for (&node, found) in nodes.iter().zip(run.nodes(&own)) {
            of_nodes[node as usize] = found.map_or([0.0; D], |(moved, _)| moved);
        }
        Self { corners, nodes: of_nodes }
    }

    /// The part of these elements and nodes, numbered in their order.
    #[must_use]
    pub fn part<const N: usize>(&self, elements: &[u32], nodes: &[u32]) -> Self {
        let of_element = |&element: &u32| self.corners[N * element as usize..][..N].iter().copied();
        Self {
            corners: elements.iter().flat_map(of_element).collect(),
            nodes: nodes.iter().map(|&node| self.nodes[node as usize]).collect(),
        }
    }

    /// Lets the displacements of a snapshot of all of these elements count from here.
    pub fn subtract_from<const N: usize>(&self, snapshot: &mut Snapshot<D, N>) {
        let all = snapshot.displacements.clone();
        for (its_nodes, origins) in snapshot.elements.iter().zip(self.corners.chunks_exact(N)) {
            for (&node, origin) in its_nodes.iter().zip(origins) {
                let node = node as usize;
                snapshot.displacements[node] = std::array::from_fn(|axis| all[node][axis] - origin[axis]);
            }
        }
    }
}

impl<const D: usize> Entered<D> {
    /// A run that begins.
    pub fn first() -> Self {
        Self::alone(0)
    }

    /// A run that has reached the stage of this number without any time in the earlier ones.
    pub fn alone(stage: usize) -> Self {
        Self { begun: vec![0; stage + 1], held: Vec::new(), origin: None }
    }

    /// Number of the present stage.
    pub fn stage(&self) -> usize {
        self.begun.len().saturating_sub(1)
    }
}
