//! Numbers of the facets and edges of a tetrahedron, and the marks that they have in a frame.

/// Corners of the facets of a tetrahedron, counter-clockwise seen from outside.
pub(crate) const FACETS: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// The facet that has all corners but this one.
pub(crate) const WITHOUT: [usize; 4] = [2, 3, 1, 0];

/// Returns the edge between two different corners of a tetrahedron.
pub(crate) fn edge(a: usize, b: usize) -> usize {
    match (a.min(b), a.max(b)) {
        (0, b) => b - 1,
        (1, b) => b + 1,
        _ => 5,
    }
}

/// The visible parts of an element: its facets, and the lines on its edges. Bits: facets `k` that are seen in
/// `1 << k`; edges where the surface has an angle in `16 << k`; edges between grains or materials in
/// `1024 << k`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Marks(pub(crate) u16);

impl Marks {
    pub(crate) fn seen(self, facet: usize) -> bool {
        self.0 >> facet & 1 == 1
    }

    pub(crate) fn any_seen(self) -> bool {
        self.0 & 15 != 0
    }

    pub(crate) fn angular(self, edge: usize) -> bool {
        self.0 >> (4 + edge) & 1 == 1
    }

    pub(crate) fn between(self, edge: usize) -> bool {
        self.0 >> (10 + edge) & 1 == 1
    }

    pub(crate) fn see(&mut self, facet: usize) {
        self.0 |= 1 << facet;
    }

    pub(crate) fn mark(&mut self, edge: usize, angular: bool, between: bool) {
        self.0 |= u16::from(angular) << (4 + edge) | u16::from(between) << (10 + edge);
    }
}
