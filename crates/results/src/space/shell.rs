//! The facets of a mesh of tetrahedra that are seen.

use fdem_simulation::{Crack, Mesh, Snapshot};

use crate::run::snapshot::SnapshotError;
use crate::space::facets::{FACETS, Marks, WITHOUT, edge};

/// Stands for no facet.
const NONE: u32 = u32::MAX;

/// Cosine of the angle between two facets, 30°, above which the edge between them is drawn.
const EVEN: f64 = 0.866_025_403_784_438_6;

/// More elements do not meet at an edge of a mesh. The limit ends the walk around an edge of a mesh that
/// contradicts itself.
const MOST_AROUND: usize = 10_000;

/// Which facets of a mesh two elements share, and which are on the outside. It is made once for a mesh; with
/// the cracks of a [`Snapshot`] it gives the visible facets: those outside, and both sides of those whose
/// joint has broken.
///
/// # Example
/// ```
/// use fdem_results::Shell;
/// use fdem_simulation::Mesh;
///
/// let mesh = Mesh {
///     nodes: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]],
///     elements: vec![[0, 1, 2, 3], [1, 2, 3, 4]],
///     bodies: vec![0, 0],
///     materials: vec![0, 0],
/// };
/// assert_eq!(Shell::new(&mesh, &[]).outside(), 6);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shell {
    /// Vertices of each element.
    elements: Vec<[u32; 4]>,
    /// Grain and material of each element.
    parts: Vec<[u32; 2]>,
    /// The facet on the other side of each facet, `4 e + k` for facet `k` of element `e`; [`NONE`] outside.
    across: Vec<[u32; 4]>,
}

/// The visible parts of a snapshot.
pub(crate) struct VisibleParts {
    /// Facets that are seen, and lines on edges, of each element.
    pub(crate) marks: Vec<Marks>,
    /// Broken joints between elements that are drawn.
    pub(crate) cracks: Vec<SeenCrack>,
}

/// A broken joint: its two facets, which are both seen.
pub(crate) struct SeenCrack {
    /// Place among the cracks of the snapshot.
    pub(crate) place: usize,
    /// Facets `4 e + k`.
    pub(crate) facets: [u32; 2],
    /// Corners of both facets in their elements. Equal places are the same vertex.
    pub(crate) corners: [[usize; 3]; 2],
    /// Edges at which the crack ends on the outside: `1 << k` for the edge between places `k` and `k + 1` of
    /// side 0, `8 << k` of side 1.
    pub(crate) traces: u16,
}

impl Shell {
    /// Sorts the facets of a mesh.
    ///
    /// # Shapes
    /// `grains`: a number for each element, different for two grains that have a facet in common; empty if
    /// there are no grains. Edges of the surface between grains and between materials are drawn.
    ///
    /// # Cost
    /// About 0.5 µs and 40 bytes an element.
    pub fn new(mesh: &Mesh<3, 4>, grains: &[u32]) -> Self {
        let mut facets: Vec<([u32; 3], u32)> = Vec::with_capacity(4 * mesh.elements.len());
        for (element, nodes) in (0_u32..).zip(&mesh.elements) {
            for (k, corners) in (0_u32..).zip(FACETS) {
                let mut key = corners.map(|corner| nodes[corner]);
                key.sort_unstable();
                facets.push((key, 4 * element + k));
            }
        }
        facets.sort_unstable();
        let mut across = vec![[NONE; 4]; mesh.elements.len()];
        for alike in facets.chunk_by(|a, b| a.0 == b.0) {
            // More than two elements cannot share a facet of a good mesh: all are then outside.
            if let [(_, one), (_, other)] = *alike
                && one / 4 != other / 4
            {
                across[one as usize / 4][one as usize % 4] = other;
                across[other as usize / 4][other as usize % 4] = one;
            }
        }
        let part = |element: usize| {
            let number = |of: &[u32]| of.get(element).copied().unwrap_or(0);
            [number(grains), number(&mesh.materials)]
        };
        Self { elements: mesh.elements.clone(), parts: (0..mesh.elements.len()).map(part).collect(), across }
    }

    /// Returns the number of elements.
    pub fn elements(&self) -> usize {
        self.elements.len()
    }

    /// Returns the number of facets of the mesh that belong to one element only.
    pub fn outside(&self) -> usize {
        self.across.iter().flatten().filter(|&&facet| facet == NONE).count()
    }

    /// Finds the visible parts of a snapshot of this mesh: facets outside, facets beside elements that are
    /// not drawn, and both sides of broken joints. Nothing is seen of elements that are not drawn.
    pub(crate) fn seen(
        &self,
        snapshot: &Snapshot<3, 4>,
        drawn: &[bool],
    ) -> Result<VisibleParts, SnapshotError> {
        let mut marks = vec![Marks::default(); self.elements.len()];
        for (element, across) in self.across.iter().enumerate() {
            if !drawn[element] {
                continue;
            }
            for (k, &other) in across.iter().enumerate() {
                if other == NONE || !drawn[other as usize / 4] {
                    marks[element].see(k);
                }
            }
        }
        let mut broken = vec![Marks::default(); if snapshot.cracks.is_empty() { 0 } else { marks.len() }];
        let mut cracks = Vec::new();
        for (place, crack) in snapshot.cracks.iter().enumerate().filter(|(_, crack)| crack.time.is_some()) {
            let facets = self.between(crack)?;
            if !facets.iter().all(|&facet| drawn[facet as usize / 4]) {
                continue;
            }
            for facet in facets {
                let (element, k) = (facet as usize / 4, facet as usize % 4);
                marks[element].see(k);
                broken[element].see(k);
            }
            let one = FACETS[facets[0] as usize % 4];
            let other =
                one.map(|corner| self.corner(facets[1], self.elements[facets[0] as usize / 4][corner]));
            cracks.push(SeenCrack { place, facets, corners: [one, other], traces: 0 });
        }
        self.lines(snapshot, &mut marks);
        for crack in &mut cracks {
            for side in 0..2 {
                for k in 0..3 {
                    let [a, b] = [crack.corners[side][k], crack.corners[side][(k + 1) % 3]];
                    let next = self.around(&marks, crack.facets[side], [a, b]);
                    let ends =
                        next.is_none_or(|(facet, _)| !broken[facet as usize / 4].seen(facet as usize % 4));
                    crack.traces |= u16::from(ends) << (3 * side + k);
                }
            }
        }
        Ok(VisibleParts { marks, cracks })
    }

    /// Marks the edges of facets that are seen at which the surface has an angle, or the grain or the
    /// material changes.
    fn lines(&self, snapshot: &Snapshot<3, 4>, marks: &mut [Marks]) {
        for element in 0..marks.len() {
            for k in (0..4).filter(|&k| marks[element].seen(k)).collect::<Vec<_>>() {
                let facet = (4 * element + k) as u32;
                for j in 0..3 {
                    let ends = [FACETS[k][j], FACETS[k][(j + 1) % 3]];
                    let Some((next, others)) = self.around(marks, facet, ends) else {
                        marks[element].mark(edge(ends[0], ends[1]), true, false);
                        continue;
                    };
                    if next < facet {
                        continue;
                    }
                    let beside = next as usize / 4;
                    let [one, other] = [facet, next].map(|facet| normal(snapshot, facet));
                    let angular = dot(one, other) < EVEN * (dot(one, one) * dot(other, other)).sqrt();
                    let between = self.parts[element] != self.parts[beside];
                    marks[element].mark(edge(ends[0], ends[1]), angular, between);
                    marks[beside].mark(edge(others[0], others[1]), angular, between);
                }
            }
        }
    }

    /// Goes around an edge from a facet that is seen, through the body, to the next facet that is seen.
    /// Returns it with the corners of the edge in its element; `None` if it does not exist, which happens
    /// only in an inconsistent mesh.
    fn around(&self, marks: &[Marks], facet: u32, ends: [usize; 2]) -> Option<(u32, [usize; 2])> {
        let (mut facet, mut ends) = (facet, ends);
        for _ in 0..MOST_AROUND {
            let (element, k) = (facet as usize / 4, facet as usize % 4);
            let third = FACETS[k].into_iter().find(|corner| !ends.contains(corner))?;
            let next = WITHOUT[third];
            if marks[element].seen(next) {
                return Some(((4 * element + next) as u32, ends));
            }
            let other = self.across[element][next];
            ends = ends.map(|corner| self.corner(other, self.elements[element][corner]));
            facet = other;
        }
        None
    }

    /// Returns the corner at a vertex, in the element of a facet.
    fn corner(&self, facet: u32, vertex: u32) -> usize {
        self.elements[facet as usize / 4].iter().position(|&other| other == vertex).unwrap_or(0)
    }

    /// Returns the facets on both sides of a crack.
    fn between(&self, crack: &Crack<3>) -> Result<[u32; 2], SnapshotError> {
        let [one, other] = crack.elements;
        let shared = self.across.get(one as usize).and_then(|across| {
            let k = across.iter().position(|&facet| facet != NONE && facet / 4 == other)?;
            Some([4 * one + k as u32, across[k]])
        });
        shared.ok_or(SnapshotError::Crack { elements: crack.elements })
    }
}

/// Normal of a facet, twice as long as its area.
fn normal(snapshot: &Snapshot<3, 4>, facet: u32) -> [f64; 3] {
    let nodes = snapshot.elements[facet as usize / 4];
    let [a, b, c] = FACETS[facet as usize % 4].map(|corner| snapshot.positions[nodes[corner] as usize]);
    let [u, v] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
