//! Parts of bodies on which boundaries and surfaces of pores are: sides, boxes and groups.

use fdem_mesh::{Mesh, bounds};

use crate::bodies::dimensions::Dimensions;
use crate::shapes::placed::Placed;
use crate::text::fault::suggestion;
use crate::text::file::Side;

/// Largest distance of nodes of one side from its outermost node, over the extent of the bodies.
const SIDE: f64 = 1e-6;

/// The keys of a part of bodies: at most one of them is given.
pub(crate) struct PlaceKeys<'a> {
    pub(crate) sides: Vec<Side>,
    pub(crate) limits: Option<&'a [f64]>,
    pub(crate) group: Option<&'a str>,
}

/// A part of bodies.
pub(crate) struct Place<'a, const D: usize, const N: usize> {
    pub(crate) keys: PlaceKeys<'a>,
    pub(crate) mesh: &'a Mesh<D, N>,
    pub(crate) placed: &'a [Placed<D, N>],
    /// Numbers of the bodies of which it may be.
    pub(crate) bodies: &'a [usize],
}

impl<const D: usize, const N: usize> Place<'_, D, N>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    /// Checks that a body has the group; the error is advice.
    pub(crate) fn check_group(&self) -> Result<(), String> {
        let Some(group) = self.keys.group else { return Ok(()) };
        let mut names: Vec<&str> = Vec::new();
        for &body in self.bodies {
            let piece = &self.placed[body].piece;
            names.extend(piece.groups.keys().map(String::as_str));
        }
        names.sort_unstable();
        names.dedup();
        if names.contains(&group) { Ok(()) } else { Err(suggestion(group, &names, "group")) }
    }

    /// Nodes of the bodies in this place.
    pub(crate) fn nodes(&self) -> Vec<u32> {
        let mut nodes = Vec::new();
        for &body in self.bodies {
            let Placed { piece, first, .. } = &self.placed[body];
            match self.keys.group {
                None => nodes.extend((0..piece.nodes.len() as u32).map(|node| node + first[0])),
                Some(name) => {
                    let found = piece.groups.get(name).map(|group| piece.nodes_of(group)).unwrap_or_default();
                    nodes.extend(found.into_iter().map(|node| node + first[0]));
                }
            }
        }
        let boxes = self.boxes();
        nodes.retain(|&node| boxes.iter().any(|&limits| within(self.mesh.nodes[node as usize], limits)));
        nodes
    }

    /// Outer facets of the bodies in this place.
    pub(crate) fn facets(&self) -> Vec<[u32; D]> {
        let mut facets = Vec::new();
        for &body in self.bodies {
            let Placed { piece, first, .. } = &self.placed[body];
            let found = match self.keys.group {
                None => piece.outline.clone(),
                Some(name) => piece.groups.get(name).map(|group| piece.facets_of(group)).unwrap_or_default(),
            };
            facets.extend(found.into_iter().map(|facet| facet.map(|node| node + first[0])));
        }
        let boxes = self.boxes();
        let is_in = |facet: &[u32; D], limits| {
            facet.iter().all(|&node| within(self.mesh.nodes[node as usize], limits))
        };
        facets.retain(|facet| boxes.iter().any(|&limits| is_in(facet, limits)));
        facets
    }

    /// The boxes of which nodes have to be in one.
    fn boxes(&self) -> Vec<[[f64; D]; 2]> {
        let everywhere = [[f64::NEG_INFINITY; D], [f64::INFINITY; D]];
        if let Some(given) = self.keys.limits {
            let (least, most) = given.split_at(given.len() / 2);
            let [low, high] = everywhere;
            return vec![[least.try_into().unwrap_or(low), most.try_into().unwrap_or(high)]];
        }
        if self.keys.sides.is_empty() {
            return vec![everywhere];
        }
        let points = self.bodies.iter().flat_map(|&body| self.placed[body].piece.nodes.iter().copied());
        let [low, high] = bounds(points);
        let reach = SIDE * (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let of_side = |side| {
            let mut limits = everywhere;
            match side {
                Side::Left => limits[1][0] = low[0] + reach,
                Side::Right => limits[0][0] = high[0] - reach,
                Side::Front => limits[1][1] = low[1] + reach,
                Side::Back => limits[0][1] = high[1] - reach,
                Side::Bottom => limits[1][D - 1] = low[D - 1] + reach,
                Side::Top => limits[0][D - 1] = high[D - 1] - reach,
            }
            limits
        };
        self.keys.sides.iter().copied().map(of_side).collect()
    }
}

fn within<const D: usize>(point: [f64; D], [low, high]: [[f64; D]; 2]) -> bool {
    (0..D).all(|axis| low[axis] <= point[axis] && point[axis] <= high[axis])
}
