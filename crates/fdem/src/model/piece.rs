//! One meshed body, numbered by itself.

use std::collections::BTreeMap;

use crate::model::mesher::{INSIDE, Meshed};
use crate::model::outline::{Point, bounds};
use crate::numbers::brief;

/// A meshed body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Piece {
    pub(crate) nodes: Vec<Point>,
    /// Counter-clockwise.
    pub(crate) elements: Vec<[u32; 3]>,
    /// Material of each triangle.
    pub(crate) materials: Vec<u32>,
    /// Grain of each triangle; empty if the body has no grains.
    pub(crate) grains: Vec<u32>,
    /// Edges of one triangle only, in its direction.
    pub(crate) outline: Vec<[u32; 2]>,
    /// Parts that boundaries may name.
    pub(crate) groups: BTreeMap<String, Group>,
    /// Groups of curves in its file, whether or not of this body.
    pub(crate) curves: Vec<String>,
}

/// A named part of a body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group {
    /// Elements of a surface.
    pub(crate) elements: Vec<u32>,
    /// Edges of a curve, in any direction.
    pub(crate) curve: Vec<[u32; 2]>,
}

impl Piece {
    /// A mesh that was made here, with the groups "outer", "holes", "hole-1", ….
    pub(crate) fn new(meshed: Meshed, materials: Vec<u32>) -> Result<Self, String> {
        let Meshed { nodes, elements, loops, .. } = meshed;
        let mut piece = Self { nodes, elements, materials, ..Self::default() };
        piece.find_outline()?;
        for edge in &piece.outline {
            let number = loops[edge[0] as usize];
            if number == INSIDE {
                continue;
            }
            let names = if number == 0 {
                vec!["outer".to_owned()]
            } else {
                vec!["holes".to_owned(), format!("hole-{number}")]
            };
            for name in names {
                piece.groups.entry(name).or_default().curve.push(*edge);
            }
        }
        Ok(piece)
    }

    /// Finds the edges of one triangle only.
    ///
    /// # Errors
    /// Messages about edges of more than two triangles, or of two on the same side.
    pub(crate) fn find_outline(&mut self) -> Result<(), String> {
        let mut edges: Vec<([u32; 2], bool)> = Vec::with_capacity(3 * self.elements.len());
        for &[a, b, c] in &self.elements {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                edges.push(if from < to { ([from, to], false) } else { ([to, from], true) });
            }
        }
        edges.sort_unstable();
        self.outline.clear();
        let mut place = 0;
        while place < edges.len() {
            let (edge, turned) = edges[place];
            let count = edges[place..].iter().take_while(|(other, _)| *other == edge).count();
            match count {
                1 => self.outline.push(if turned { [edge[1], edge[0]] } else { edge }),
                2 if edges[place + 1].1 != turned => {}
                _ => {
                    let [x, y] = self.nodes[edge[0] as usize].map(brief);
                    return Err(format!("elements lie on top of each other at an edge near [{x}, {y}]"));
                }
            }
            place += count;
        }
        Ok(())
    }

    /// Turns the body about the middle of its bounding box, degrees, then moves it.
    pub(crate) fn place(&mut self, angle: f64, by: Point) {
        let [low, high] = bounds(self.nodes.iter().copied());
        let middle = [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]));
        let (sine, cosine) = libm::sincos(angle.to_radians());
        for node in &mut self.nodes {
            if angle != 0.0 {
                let (x, y) = (node[0] - middle[0], node[1] - middle[1]);
                *node = [middle[0] + cosine * x - sine * y, middle[1] + sine * x + cosine * y];
            }
            *node = [node[0] + by[0], node[1] + by[1]];
        }
    }

    /// The nodes that a group has.
    pub(crate) fn nodes_of(&self, group: &Group) -> Vec<u32> {
        let surface = group.elements.iter().flat_map(|&element| self.elements[element as usize]);
        let mut nodes: Vec<u32> = surface.chain(group.curve.iter().flatten().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The edges of the outline that a group has.
    pub(crate) fn edges_of(&self, group: &Group) -> Vec<[u32; 2]> {
        let sorted = |[a, b]: [u32; 2]| if a < b { [a, b] } else { [b, a] };
        let surface = group.elements.iter().flat_map(|&element| {
            let [a, b, c] = self.elements[element as usize];
            [[a, b], [b, c], [c, a]]
        });
        let mut wanted: Vec<[u32; 2]> = surface.chain(group.curve.iter().copied()).map(sorted).collect();
        wanted.sort_unstable();
        self.outline.iter().copied().filter(|&edge| wanted.binary_search(&sorted(edge)).is_ok()).collect()
    }
}
