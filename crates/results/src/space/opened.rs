//! Decompressed frames in three dimensions.

use crate::fields::quantity::Number;
use crate::run::frame::CrackKind;
use crate::space::facets::{FACETS, Marks, edge};

/// A decompressed frame. All arrays have an entry for each element that the frame has.
pub(crate) struct OpenedSpace {
    /// The first elements have facets that are seen; the others, if there are any, are inside.
    pub(crate) surface: usize,
    /// Whether all elements that can be drawn are in the frame: a cut can show the inside.
    pub(crate) solid: bool,
    /// Numbers of the elements in the mesh.
    pub(crate) numbers: Vec<u32>,
    /// Corners of the elements, m; all are finite.
    pub(crate) corners: Vec<[[f64; 3]; 4]>,
    /// Values of each field of [`crate::fields::field::SCALES`]; NaN if not finite.
    pub(crate) values: Vec<Vec<f64>>,
    pub(crate) bodies: Vec<u32>,
    pub(crate) materials: Vec<u32>,
    pub(crate) fragments: Vec<u32>,
    pub(crate) marks: Vec<Marks>,
    pub(crate) cracks: Vec<OpenedCrack>,
    /// Corners of the whole joints, m.
    pub(crate) intact: Vec<[[f64; 3]; 3]>,
    /// Corners of the joints that soften, m.
    pub(crate) softening: Vec<[[f64; 3]; 3]>,
}

/// A facet that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenedFacet {
    /// Place of its element in the frame.
    pub(crate) element: usize,
    /// Number of the facet in its element, as in [`FACETS`].
    pub(crate) facet: usize,
    /// Corners, counter-clockwise seen from outside.
    pub(crate) corners: [[f64; 3]; 3],
    /// Whether the surface has an angle at the edges between corners `k` and `k + 1`.
    pub(crate) angular: [bool; 3],
    /// Whether these edges are between grains or materials.
    pub(crate) between: [bool; 3],
}

/// A broken joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OpenedCrack {
    /// Places in the frame of the elements on its two sides, and the numbers of the facets in them.
    pub(crate) facets: [(usize, usize); 2],
    /// Corners of both sides, m. Corners with the same place were one.
    pub(crate) sides: [[[f64; 3]; 3]; 2],
    /// Whether the edges between corners `k` and `k + 1` are on the outside, for each side: there the crack
    /// is seen as a line.
    pub(crate) traces: [[bool; 3]; 2],
    pub(crate) kind: CrackKind,
    /// Mean opening, m; negative where it is closed.
    pub(crate) opening: f64,
}

impl OpenedSpace {
    /// Returns the numbers of the elements by which they are coloured.
    pub(crate) fn numbers_of(&self, number: Number) -> &[u32] {
        match number {
            Number::Body => &self.bodies,
            Number::Material => &self.materials,
        }
    }

    /// Returns the facets that are seen.
    pub(crate) fn facets(&self) -> impl Iterator<Item = OpenedFacet> + '_ {
        (0..self.surface).flat_map(move |element| {
            let marks = self.marks[element];
            (0..4).filter(move |&facet| marks.seen(facet)).map(move |facet| {
                let corners = FACETS[facet];
                let edges = [0, 1, 2].map(|k| edge(corners[k], corners[(k + 1) % 3]));
                OpenedFacet {
                    element,
                    facet,
                    corners: corners.map(|corner| self.corners[element][corner]),
                    angular: edges.map(|edge| marks.angular(edge)),
                    between: edges.map(|edge| marks.between(edge)),
                }
            })
        })
    }
}

impl OpenedCrack {
    /// Returns the corners half way between the two sides.
    pub(crate) fn middle(&self) -> [[f64; 3]; 3] {
        let [one, other] = self.sides;
        [0, 1, 2].map(|k| [0, 1, 2].map(|axis| one[k][axis].midpoint(other[k][axis])))
    }
}
