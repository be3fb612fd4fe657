//! Tetrahedra of one or several regions that can be replaced a few at a time.

use super::quality::quality;
use crate::tetrahedra::delaunay::{Delaunay, FACETS, NONE};
use crate::tetrahedra::recover::Hits;
use crate::tetrahedra::skin::Skin;
use crate::tetrahedra::surface::{INNER, OUTSIDE};
use crate::tetrahedra::vector::Point;

/// Beyond a facet of the outer surface there is this plus the number of its patch, instead of a neighbour.
pub(crate) const BORDER: u32 = 1 << 31;

/// Longest ring of neighbours around a vertex or an edge that is looked at.
pub(crate) const MOST_AROUND: usize = 120;

/// Tetrahedra with neighbours.
pub(crate) struct Body {
    pub(crate) points: Vec<Point>,
    /// For each point: [`NONE`] if it may move freely, [`FIXED`], or the patch in whose plane it may move.
    pub(crate) bound: Vec<u32>,
    /// Directions of each patch.
    pub(crate) axes: Vec<[Point; 2]>,
    pub(crate) corners: Vec<[u32; 4]>,
    /// Beyond the facet opposite each corner: four times the neighbour plus the place of its opposite corner,
    /// or [`BORDER`].
    pub(crate) across: Vec<[u32; 4]>,
    pub(crate) regions: Vec<u32>,
    /// Bit `k` is set if the facet opposite corner `k` is one of the skin inside of a region: it stays.
    pub(crate) walls: Vec<u8>,
    /// A tetrahedron at each point, or [`NONE`].
    pub(crate) at: Vec<u32>,
    free: Vec<u32>,
}

/// A point that must not move.
pub(crate) const FIXED: u32 = NONE - 1;

/// Tetrahedra around an edge.
pub(crate) struct Ring {
    /// Tetrahedra, in order around the edge.
    pub(crate) around: Vec<u32>,
    /// Their other corners: one more than tetrahedra if the ring is open.
    pub(crate) nodes: Vec<u32>,
    /// Patches at both ends of an open ring.
    pub(crate) ends: Option<[u32; 2]>,
}

impl Body {
    /// The tetrahedra of a triangulation that are not outside.
    pub(crate) fn new(mesh: &Delaunay, skin: &Skin, hits: &Hits, points: Vec<Point>) -> Self {
        let mut between = vec![false; skin.points.len()];
        for (triangle, &patch) in skin.triangles.iter().zip(&skin.of) {
            if !skin.patches[patch as usize].sides.contains(&OUTSIDE) {
                for &node in triangle {
                    between[node as usize] = true;
                }
            }
        }
        let bound = |node: usize| match skin.inside.get(node) {
            None => NONE,
            Some(&patch) if patch == NONE || between[node] => FIXED,
            Some(&patch) => patch,
        };
        let mut numbers = vec![NONE; mesh.corners.len()];
        let mut kept = Vec::new();
        for t in (0..mesh.corners.len()).filter(|&t| mesh.is_used(t) && mesh.regions[t] != OUTSIDE) {
            numbers[t] = kept.len() as u32;
            kept.push(t);
        }
        let mut new = Self {
            bound: (0..points.len()).map(bound).collect(),
            at: vec![NONE; points.len()],
            points,
            axes: skin.patches.iter().map(|patch| patch.axes).collect(),
            corners: kept.iter().map(|&t| mesh.corners[t]).collect(),
            across: Vec::with_capacity(kept.len()),
            regions: kept.iter().map(|&t| mesh.regions[t]).collect(),
            walls: vec![0; kept.len()],
            free: Vec::new(),
        };
        for (number, &t) in (0..).zip(&kept) {
            let across = mesh.across[t].map(|code| match numbers[(code / 4) as usize] {
                NONE => BORDER,
                other => 4 * other + code % 4,
            });
            new.across.push(across);
            new.corners[number as usize].iter().for_each(|&corner| new.at[corner as usize] = number);
        }
        for &(facet, triangle) in hits {
            let t = numbers[(facet / 4) as usize];
            if t != NONE && skin.patches[skin.of[triangle as usize] as usize].sides[0] == INNER {
                new.walls[t as usize] |= 1 << (facet % 4);
            }
            if t != NONE && new.across[t as usize][(facet % 4) as usize] >= BORDER {
                new.across[t as usize][(facet % 4) as usize] = BORDER + skin.of[triangle as usize];
            }
        }
        new
    }

    #[inline]
    pub(crate) fn is_used(&self, t: usize) -> bool {
        self.corners[t][0] != NONE
    }

    #[inline]
    pub(crate) fn quality(&self, t: usize) -> f64 {
        self.quality_of(self.corners[t])
    }

    #[inline]
    pub(crate) fn quality_of(&self, corners: [u32; 4]) -> f64 {
        let [a, b, c, d] = corners.map(|corner| self.points[corner as usize]);
        quality(a, b, c, d)
    }

    /// Whether a facet stays because it is one of the skin.
    #[inline]
    fn is_wall(&self, t: usize, place: usize) -> bool {
        self.walls[t] >> place & 1 == 1
    }

    /// The neighbour beyond a facet, if it is in the same region, and the facet may go.
    #[inline]
    pub(crate) fn beyond(&self, t: usize, place: usize) -> Option<(usize, usize)> {
        let code = self.across[t][place];
        let (u, opposite) = ((code / 4) as usize, (code % 4) as usize);
        (code < BORDER && self.regions[u] == self.regions[t] && !self.is_wall(t, place))
            .then_some((u, opposite))
    }

    /// All tetrahedra at a point, of any region.
    pub(crate) fn star(&self, node: u32, star: &mut Vec<u32>) {
        star.clear();
        star.push(self.at[node as usize]);
        let mut next = 0;
        while let Some(&t) = star.get(next) {
            next += 1;
            for place in 0..4 {
                let code = self.across[t as usize][place];
                if self.corners[t as usize][place] != node && code < BORDER && !star.contains(&(code / 4)) {
                    star.push(code / 4);
                }
            }
            if star.len() > MOST_AROUND {
                return;
            }
        }
    }

    /// The tetrahedra around the edge between two corners of a tetrahedron, such that each of them has
    /// positive volume as (a, b, one node, the next node). `None` if they are of several regions, or on both
    /// sides of a facet that stays.
    pub(crate) fn ring(&self, t: usize, a: u32, b: u32) -> Option<Ring> {
        let mut others = self.corners[t].iter().copied().filter(|&corner| corner != a && corner != b);
        let (mut c, mut d) = (others.next()?, others.next()?);
        let place = |t: usize, node: u32| self.corners[t].iter().position(|&corner| corner == node);
        if !is_even([a, b, c, d], self.corners[t]) {
            std::mem::swap(&mut c, &mut d);
        }
        let mut ring = Ring { around: vec![t as u32], nodes: vec![c, d], ends: None };
        let region = self.regions[t];
        // Beyond the facet opposite the earlier node, the next node follows.
        let (mut at, mut last) = (t, c);
        let mut end = BORDER;
        while ring.around.len() < MOST_AROUND {
            let leave = place(at, last)?;
            let code = self.across[at][leave];
            if code >= BORDER {
                end = code;
                break;
            }
            if self.is_wall(at, leave) {
                return None;
            }
            let (next, opposite) = ((code / 4) as usize, (code % 4) as usize);
            if next == t {
                ring.nodes.pop();
                return Some(ring);
            }
            if self.regions[next] != region {
                return None;
            }
            last = *ring.nodes.last()?;
            at = next;
            ring.around.push(next as u32);
            ring.nodes.push(self.corners[next][opposite]);
        }
        // Open: the other way round from the start, and then in order.
        let mut before = Vec::new();
        let (mut at, mut last, mut far) = (t, d, c);
        while before.len() < MOST_AROUND {
            let leave = place(at, last)?;
            let code = self.across[at][leave];
            if code >= BORDER {
                let nodes = before.iter().rev().map(|&(_, node)| node).chain(ring.nodes).collect();
                let around = before.iter().rev().map(|&(t, _)| t).chain(ring.around).collect();
                return Some(Ring { around, nodes, ends: Some([code - BORDER, end - BORDER]) });
            }
            let (next, opposite) = ((code / 4) as usize, (code % 4) as usize);
            if self.regions[next] != region || self.is_wall(at, leave) {
                return None;
            }
            last = far;
            at = next;
            far = self.corners[next][opposite];
            before.push((next as u32, far));
        }
        None
    }

    /// Puts tetrahedra in the place of others that fill the same space. Facets of the new ones that are
    /// neither facets of the old ones nor of two new ones get `border`. Returns the places of the new ones.
    pub(crate) fn replace(&mut self, old: &[u32], new: &[[u32; 4]], border: u32) -> Vec<u32> {
        let region = self.regions[old[0] as usize];
        let key = |corners: [u32; 4], place: usize| {
            let mut key = FACETS[place].map(|k| corners[k]);
            key.sort_unstable();
            key
        };
        // Facets with the neighbour beyond them, and whether they are walls, then facets with their own code.
        let mut facets: Vec<([u32; 3], bool, u32, bool)> = Vec::new();
        for &t in old {
            for place in 0..4 {
                let code = self.across[t as usize][place];
                if code >= BORDER || !old.contains(&(code / 4)) {
                    let wall = self.is_wall(t as usize, place);
                    facets.push((key(self.corners[t as usize], place), false, code, wall));
                }
            }
        }
        for &t in old {
            self.corners[t as usize] = [NONE; 4];
            self.free.push(t);
        }
        let mut places = Vec::with_capacity(new.len());
        for &corners in new {
            let t = self.free.pop().unwrap_or_else(|| {
                self.corners.push([NONE; 4]);
                self.across.push([border; 4]);
                self.regions.push(region);
                self.walls.push(0);
                self.corners.len() as u32 - 1
            });
            self.corners[t as usize] = corners;
            self.across[t as usize] = [border; 4];
            self.regions[t as usize] = region;
            self.walls[t as usize] = 0;
            places.push(t);
            for (place, &corner) in corners.iter().enumerate() {
                self.at[corner as usize] = t;
                facets.push((key(corners, place), true, 4 * t + place as u32, false));
            }
        }
        facets.sort_unstable();
        for pair in facets.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let (one, other) = (pair[0].2, pair[1].2);
            if pair[0].3 {
                self.walls[(other / 4) as usize] |= 1 << (other % 4);
            }
            for (code, to) in [(one, other), (other, one)] {
                if code < BORDER {
                    self.across[(code / 4) as usize][(code % 4) as usize] = to;
                }
            }
        }
        places
    }

    /// Removes a point from the mesh that no tetrahedron has any more.
    pub(crate) fn forget(&mut self, node: u32) {
        self.at[node as usize] = NONE;
    }
}

/// Whether one order of four corners is an even permutation of the other.
fn is_even(one: [u32; 4], other: [u32; 4]) -> bool {
    let mut places = one.map(|corner| other.iter().position(|&known| known == corner).unwrap_or(0));
    let mut even = true;
    for k in 0..4 {
        while places[k] != k {
            let target = places[k];
            if places[target] == target {
                return false;
            }
            places.swap(k, target);
            even = !even;
        }
    }
    even
}
