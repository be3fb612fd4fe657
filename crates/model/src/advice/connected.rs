//! Whether the mesh of a body holds together: its pieces, parts that share only nodes, nodes that were not
//! merged, and nodes that hang on edges.

use std::collections::BTreeMap;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::{Corners, bounds};

use crate::advice::parts::{join, parts};
use crate::shapes::outline::{Point, distance};
use crate::shapes::piece::Piece;

/// Distance over the extent of a body below which two points are in one place.
const SAME: f64 = 1e-9;

/// Distance over the length of an edge below which a node lies on it.
const ON: f64 = 1e-6;

/// Pieces of a mesh, and nodes that should connect them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Found {
    /// Parts that have no node in common.
    pieces: usize,
    /// Parts that have no facet in common, and a node that two of them share.
    parts: (usize, Option<u32>),
    /// Nodes in the place of another, and one of them.
    unmerged: (usize, Option<u32>),
    /// Nodes on the edge of an element that does not have them, and one of them.
    hanging: (usize, Option<u32>),
}

/// Warns of a mesh that falls into pieces.
pub(crate) fn warnings(name: &str, piece: &Piece, warnings: &mut Vec<String>) {
    tell(name, piece, look(piece), warnings);
}

/// Warns of a mesh of tetrahedra that falls into pieces. Nodes on faces of other elements are not looked for.
pub(crate) fn warnings_in_space(name: &str, piece: &Piece<3, 4>, warnings: &mut Vec<String>) {
    let nodes = outer_nodes(piece);
    let found = Found {
        pieces: pieces(piece),
        parts: hinged(piece),
        unmerged: unmerged(piece, &nodes),
        hanging: (0, None),
    };
    tell(name, piece, found, warnings);
}

fn tell<const D: usize, const N: usize>(
    name: &str,
    piece: &Piece<D, N>,
    found: Found,
    warnings: &mut Vec<String>,
) {
    let at = |node: Option<u32>| {
        let at = node.map_or([0.0; D], |node| piece.nodes[node as usize]).map(brief);
        format!("[{}]", at.join(", "))
    };
    let falls = if found.pieces > 1 {
        format!("[[body]] \"{name}\": its mesh falls into {} pieces", grouped(found.pieces as u64))
    } else {
        format!("[[body]] \"{name}\": its mesh is open inside")
    };
    if found.unmerged.0 > 0 {
        warnings.push(format!(
            "{falls}; nodes in the place of another: {}, as at {}: they do not hold together; merge them in the program that made the mesh (in Gmsh \"Coherence Mesh\", or Coherence for the geometry; in Abaqus/CAE Edit Mesh, Node, Merge)",
            grouped(found.unmerged.0 as u64),
            at(found.unmerged.1)
        ));
    }
    if found.hanging.0 > 0 {
        warnings.push(format!(
            "{falls}; nodes on edges of other elements: {}, as at {}: they do not hold together; give both sides the same nodes",
            grouped(found.hanging.0 as u64),
            at(found.hanging.1)
        ));
    }
    if found.pieces > 1 && found.unmerged.0 == 0 && found.hanging.0 == 0 {
        warnings.push(format!("{falls} that have no node in common: nothing holds them to each other, and they touch as bodies do"));
    }
    // Nodes that are not merged, or hang, already explain why parts share no more than others.
    if let ((count, Some(node)), (0, _), (0, _)) = (found.parts, found.unmerged, found.hanging) {
        let (shared, facets) = if D == 2 { ("nodes", "edges") } else { ("nodes or edges", "faces") };
        warnings.push(format!(
            "[[body]] \"{name}\": its mesh has {} parts of which some share only {shared}, as at {}: elements hold together at common {facets} only, so that these parts touch as bodies do",
            grouped(count as u64),
            at(Some(node))
        ));
    }
}

fn look(piece: &Piece) -> Found {
    let nodes = outer_nodes(piece);
    Found {
        pieces: pieces(piece),
        parts: hinged(piece),
        unmerged: unmerged(piece, &nodes),
        hanging: hanging(piece, &nodes),
    }
}

/// The nodes of the outline, ascending.
fn outer_nodes<const D: usize, const N: usize>(piece: &Piece<D, N>) -> Vec<u32> {
    let mut nodes: Vec<u32> = piece.outline.iter().flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The number of parts that have no node in common.
fn pieces<const D: usize, const N: usize>(piece: &Piece<D, N>) -> usize {
    let mut parent: Vec<u32> = (0..piece.nodes.len() as u32).collect();
    let mut count = parent.len();
    for element in &piece.elements {
        for &other in &element[1..] {
            count -= usize::from(join(&mut parent, element[0], other));
        }
    }
    count
}

/// The number of parts that have no facet in common, and the first node that two of them share.
fn hinged<const D: usize, const N: usize>(piece: &Piece<D, N>) -> (usize, Option<u32>)
where
    [[f64; D]; N]: Corners<D, N>,
{
    let parts = parts(&piece.elements);
    let count = (0..).zip(&parts).filter(|(element, part)| element == *part).count();
    let mut first: Vec<Option<u32>> = vec![None; piece.nodes.len()];
    let mut shared: Option<u32> = None;
    for (element, &part) in piece.elements.iter().zip(&parts) {
        for &node in element {
            if *first[node as usize].get_or_insert(part) != part {
                shared = Some(shared.map_or(node, |known| known.min(node)));
            }
        }
    }
    (count, shared)
}

/// Nodes of the outline in the place of one with a smaller number.
fn unmerged<const D: usize, const N: usize>(piece: &Piece<D, N>, nodes: &[u32]) -> (usize, Option<u32>) {
    let [low, high] = bounds(piece.nodes.iter().copied());
    let same = SAME * (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    // Cells much wider than the distance: two nodes in one place are in one cell or in some that touch.
    let cell = |x: f64| ((x / (8.0 * same)).floor() + 0.0).to_bits();
    let mut first: BTreeMap<[u64; D], Vec<u32>> = BTreeMap::new();
    let mut found = (0, None);
    for &node in nodes {
        let point = piece.nodes[node as usize];
        let mut places: Vec<[u64; D]> = Vec::with_capacity(1 << D);
        for corner in 0..1_usize << D {
            let place = std::array::from_fn(|axis| {
                cell(if corner >> axis & 1 == 0 { point[axis] - same } else { point[axis] + same })
            });
            if !places.contains(&place) {
                places.push(place);
            }
        }
        let near = |&other: &u32| {
            let other = piece.nodes[other as usize];
            let squared: f64 = (0..D).map(|axis| (other[axis] - point[axis]).powi(2)).sum();
            squared.sqrt() <= same
        };
        if places.iter().any(|place| first.get(place).is_some_and(|others| others.iter().any(near))) {
            found = (found.0 + 1, found.1.or(Some(node)));
            continue;
        }
        for place in places {
            first.entry(place).or_default().push(node);
        }
    }
    found
}

/// Nodes of the outline inside of its edges.
fn hanging(piece: &Piece, nodes: &[u32]) -> (usize, Option<u32>) {
    // Along a direction that is perpendicular to no edge of a usual mesh.
    let along = |[x, y]: Point| 0.540_302 * x + 0.841_471 * y;
    let mut order: Vec<(f64, u32)> =
        nodes.iter().map(|&node| (along(piece.nodes[node as usize]), node)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut hangs = Vec::new();
    for edge in &piece.outline {
        let [a, b] = edge.map(|node| piece.nodes[node as usize]);
        let length = distance(a, b);
        let (from, to) = (along(a).min(along(b)), along(a).max(along(b)));
        let start = order.partition_point(|(place, _)| *place < from);
        for &(_, node) in order[start..].iter().take_while(|(place, _)| *place <= to) {
            let point = piece.nodes[node as usize];
            let [near, far] = [distance(point, a), distance(point, b)];
            // Nodes on the way from end to end, and at neither.
            if near.min(far) > ON * length && near + far - length <= 0.5 * ON * ON * length {
                hangs.push(node);
            }
        }
    }
    hangs.sort_unstable();
    hangs.dedup();
    (hangs.len(), hangs.first().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(nodes: &[Point], elements: &[[u32; 3]]) -> Piece {
        let mut piece = Piece { nodes: nodes.to_vec(), elements: elements.to_vec(), ..Piece::default() };
        piece.find_outline().expect("a mesh");
        piece
    }

    #[test]
    fn pieces_unmerged_and_hanging_nodes_are_counted() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let whole = piece(&corners, &[[0, 1, 2], [0, 2, 3]]);
        assert_eq!(
            look(&whole),
            Found { pieces: 1, parts: (1, None), unmerged: (0, None), hanging: (0, None) }
        );

        let mut nodes = corners.to_vec();
        nodes.extend([[0.0, 0.0], [1.0, 1.0 + 1e-12]]);
        let parted = piece(&nodes, &[[0, 1, 2], [4, 5, 3]]);
        assert_eq!(
            look(&parted),
            Found { pieces: 2, parts: (2, None), unmerged: (2, Some(4)), hanging: (0, None) }
        );

        // The upper half has a node in the middle of the diagonal, the lower one has not.
        let mut nodes = corners.to_vec();
        nodes.push([0.5, 0.5]);
        let hanging = piece(&nodes, &[[0, 1, 2], [0, 4, 3], [4, 2, 3]]);
        assert_eq!(
            look(&hanging),
            Found { pieces: 1, parts: (2, Some(0)), unmerged: (0, None), hanging: (1, Some(4)) }
        );

        let apart = piece(
            &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [5.0, 0.0], [6.0, 0.0], [5.0, 1.0]],
            &[[0, 1, 2], [3, 4, 5]],
        );
        assert_eq!(look(&apart).pieces, 2);
    }
}
