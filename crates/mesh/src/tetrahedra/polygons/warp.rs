//! Round faces: their nodes are moved, along the face, onto polygons that nearly pass them.

use super::error::SNAP;
use super::sheet::Sheet;
use crate::grading::Grading;
use crate::tetrahedra::skin::FlatFaces;
use crate::tetrahedra::surface::Surface;
use crate::tetrahedra::vector::{Point, cross, dot, length, minus, normal, plus, times, unit};

/// Sine of the smallest angle between a polygon and a round face at which nodes are moved.
const STEEP: f64 = 0.3;

/// How a node may move.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Not at all.
    Fixed,
    /// Across this normal of a round face.
    Face(Point),
    /// Along this direction: the rim of a round face.
    Rim(Point),
}

/// The nodes of a surface that are only on round faces and their rims.
pub(super) struct RoundNodes(Vec<Way>);

impl RoundNodes {
    pub(super) fn new(surface: &Surface, faces: &FlatFaces) -> Self {
        // For each node: the sum of the normals of the round facets, their faces, and the other flat faces
        // with their normals.
        let mut sums = vec![[0.0; 3]; surface.nodes.len()];
        let mut round: Vec<Vec<u32>> = vec![Vec::new(); surface.nodes.len()];
        let mut flat: Vec<Vec<(u32, Point)>> = vec![Vec::new(); surface.nodes.len()];
        for (facet, &of) in faces.of_facet.iter().enumerate() {
            let [a, b, c] = surface.corners(facet);
            let across = normal(a, b, c);
            for &node in &surface.facets[facet] {
                let node = node as usize;
                if faces.round[of as usize] {
                    sums[node] = plus(sums[node], across);
                    round[node].push(surface.faces[facet]);
                } else if flat[node].iter().all(|&(known, _)| known != of) {
                    flat[node].push((of, unit(across)));
                }
            }
        }
        let way = |node: usize| {
            let mantle = unit(sums[node]);
            let is_one = round[node].windows(2).all(|pair| pair[0] == pair[1]);
            match (&flat[node][..], round[node].is_empty() || !is_one) {
                (_, true) => Way::Fixed,
                ([], _) => Way::Face(mantle),
                ([(_, end)], _) if length(cross(*end, mantle)) > STEEP => Way::Rim(unit(cross(*end, mantle))),
                _ => Way::Fixed,
            }
        };
        Self((0..surface.nodes.len()).map(way).collect())
    }

    pub(super) fn is_fixed(&self, node: u32) -> bool {
        matches!(self.0[node as usize], Way::Fixed)
    }

    /// The surface with nodes of round faces moved onto polygons; `None` if none is.
    pub(super) fn warped(&self, surface: &Surface, polygons: &[Sheet], size: &Grading<3>) -> Option<Surface> {
        let mut nodes = surface.nodes.clone();
        let mut is_moved = false;
        for (node, &way) in nodes.iter_mut().zip(&self.0) {
            if matches!(way, Way::Fixed) {
                continue;
            }
            let reach = SNAP * size.at(*node);
            let mut best: Option<(f64, Point)> = None;
            for sheet in polygons.iter().filter(|sheet| !sheet.triangles.is_empty()) {
                let height = sheet.height(*node);
                let steepest = match way {
                    Way::Face(mantle) => minus(sheet.normal, times(mantle, dot(mantle, sheet.normal))),
                    Way::Rim(along) => times(along, dot(along, sheet.normal)),
                    Way::Fixed => [0.0; 3],
                };
                let slope = length(steepest);
                if slope < STEEP || height.abs() >= reach * slope || !sheet.contains(*node, reach) {
                    continue;
                }
                let by = -height / (slope * slope);
                if best.is_none_or(|(known, _)| (by * slope).abs() < known) {
                    best = Some(((by * slope).abs(), plus(*node, times(steepest, by))));
                }
            }
            if let Some((_, place)) = best {
                *node = place;
                is_moved = true;
            }
        }
        is_moved.then(|| Surface { nodes, ..surface.clone() })
    }
}
