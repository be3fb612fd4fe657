//! How the facets of a surface hang together.

/// The ridges of a surface: edges of its triangles, and ends of its segments.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ridges {
    /// The ends of each ridge; twice the same if it is a point.
    pub(crate) ends: Vec<[u32; 2]>,
    /// The ridges of each facet; segments have `NONE` for the third.
    pub(crate) of_facet: Vec<[u32; 3]>,
}

/// The ridge that does not exist.
pub(crate) const NONE: u32 = u32::MAX;

impl Ridges {
    pub(crate) fn new(facets: &[[u32; 3]]) -> Self {
        let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * facets.len());
        for (number, &[a, b, c]) in facets.iter().enumerate() {
            if b == c {
                sides.extend([([a, a], number as u32, 0), ([b, b], number as u32, 1)]);
            } else {
                for (side, [p, q]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                    sides.push(([p.min(q), p.max(q)], number as u32, side as u8));
                }
            }
        }
        sides.sort_unstable();
        let (mut ends, mut of_facet) = (Vec::<[u32; 2]>::new(), vec![[NONE; 3]; facets.len()]);
        for (side, facet, place) in sides {
            if ends.last() != Some(&side) {
                ends.push(side);
            }
            of_facet[facet as usize][place as usize] = ends.len() as u32 - 1;
        }
        Self { ends, of_facet }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_share_edges_and_segments_share_points() {
        let of = Ridges::new(&[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(of.ends.len(), 5);
        assert_eq!(of.of_facet[0][1], of.of_facet[1][0]);
        let of = Ridges::new(&[[0, 1, 1], [1, 2, 2]]);
        assert_eq!(of.ends, [[0, 0], [1, 1], [2, 2]]);
        assert_eq!(of.of_facet, [[0, 1, NONE], [1, 2, NONE]]);
    }
}
