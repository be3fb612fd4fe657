//! Bonds: joint sets on the common sides of two bodies, such as mortar between bricks.
//!
//! Where facets of two bodies lie on each other, their nodes become one, and the facet is a joint of the set.
//! The bodies are meshed by then; facets that lie on each other only in part are refused.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use fdem_mesh::{Corners, bounds, sorted};
use fdem_simulation::{Element, Subset, Target};

use crate::joints::lines::is_between_groups;
use crate::prepared::{Joints, Prepared, Quantity};
use crate::shapes::placed::{self, Placed};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::ModelFile;

/// Advice for meshes that do not fit together.
const IN_THE_PLANE: &str = "give both the same mesh_size, one that divides the common sides into a whole number of parts; or make the two one body with a joint set along a line, or take a mesh file in which they share nodes";
const IN_SPACE: &str = "faces of shapes seldom have the same triangles: make the two one body with a joint set on a polygon, or take a mesh file in which they share nodes";

/// Distance up to which two nodes are one, over the longest edge of their facets.
const NEAR: f64 = 1e-5;

/// Facets of two bodies that lie on each other: their nodes, in pairs.
#[derive(Default)]
pub(crate) struct Bonds<const D: usize> {
    /// For each joint set with bonds: its number, the number of pairs of bodies, and the bonded facets, by
    /// the nodes of the body that comes first.
    sets: Vec<(u32, usize, Vec<[u32; D]>)>,
    /// A node before it that each merged node lies on.
    merged: BTreeMap<u32, u32>,
}

impl<const D: usize> Bonds<D> {
    /// Finds the bonds of all joint sets that are `between` bodies. Reports sides that do not lie on each
    /// other.
    pub(crate) fn find<const N: usize>(
        file: &ModelFile,
        document: &Document<'_>,
        placed: &[Placed<D, N>],
        faults: &mut Vec<Fault>,
    ) -> Self
    where
        [[f64; D]; N]: Corners<D, N> + Element<D, N>,
    {
        let mut bonds = Self { sets: Vec::new(), merged: BTreeMap::new() };
        let mut outsides: BTreeMap<usize, Outside<D>> = BTreeMap::new();
        let appears = |body: usize| {
            let activates = |name: &String| placed::named(placed, file, name).contains(&body);
            file.stage.iter().position(|stage| stage.activate.iter().any(activates))
        };
        for (number, set) in file.joint_set.iter().enumerate() {
            let Some([one, other]) =
                set.between.as_deref().and_then(|names| <&[String; 2]>::try_from(names).ok())
            else {
                continue;
            };
            if is_between_groups(set, file) {
                continue;
            }
            let [ones, others] = [one, other].map(|name| placed::fitting(placed, file, name));
            let is_rigid = |body: &&usize| file.body[placed[**body].table].rigid.at_first();
            if let Some(&body) = ones.iter().chain(&others).find(is_rigid) {
                let span = document.value(Table::of("joint_set", number), "between");
                let message = format!(
                    "[[joint_set]] \"{}\": the rigid body \"{}\" cannot be bonded",
                    set.name, placed[body].name
                );
                let help = "a bond needs bodies that deform: take rigid out, or the bond";
                faults.push(Fault::at(span, message).label("not with a rigid body").help(help));
                continue;
            }
            for &body in ones.iter().chain(&others) {
                outsides.entry(body).or_insert_with(|| Outside::of(&placed[body]));
            }
            let (mut facets, mut bonded) = (Vec::new(), 0);
            let pairs = near(&outsides, &ones, &others);
            let (mut wrong, mut apart) = (None, None);
            for (a, b) in pairs {
                match outsides[&a].on(&outsides[&b]) {
                    Ok(found) => {
                        bonded += usize::from(!found.is_empty());
                        if !found.is_empty() && appears(a) != appears(b) {
                            apart = apart.or(Some((a, b)));
                        }
                        for (first, second) in found {
                            first.into_iter().zip(second).for_each(|pair| bonds.merge(pair));
                            facets.push(first);
                        }
                    }
                    Err(place) => {
                        wrong = wrong.or(Some((a, b, place)));
                    }
                }
            }
            let span = document.value(Table::of("joint_set", number), "between");
            if let Some((a, b, place)) = wrong {
                let message = format!(
                    "[[joint_set]] \"{}\": the meshes of \"{}\" and \"{}\" do not fit together near {place:?}",
                    set.name, placed[a].name, placed[b].name
                );
                faults.push(
                    Fault::at(span, message).label("bonds need common edges or faces").help(if D == 2 {
                        IN_THE_PLANE
                    } else {
                        IN_SPACE
                    }),
                );
            } else if let Some((early, late)) = apart {
                let message = format!(
                    "[[joint_set]] \"{}\": \"{}\" and \"{}\" do not appear in the same stage",
                    set.name, placed[early].name, placed[late].name
                );
                faults.push(Fault::at(span, message).label("bonded bodies appear together"));
            } else if facets.is_empty() {
                let message = format!(
                    "[[joint_set]] \"{}\": \"{one}\" and \"{other}\" do not lie on each other",
                    set.name
                );
                faults.push(Fault::at(span, message).label("no common side"));
            }
            bonds.sets.push((number as u32, bonded, facets));
        }
        bonds
    }

    /// The bonded facets: the number of the joint set, and the nodes of the body that comes first.
    pub(crate) fn facets(&self) -> Vec<(u32, [u32; D])> {
        let of = |(set, _, facets): &(u32, usize, Vec<[u32; D]>)| {
            let set = *set;
            facets.iter().map(|facet| (set, *facet)).collect::<Vec<_>>()
        };
        self.sets.iter().flat_map(of).collect()
    }

    /// The node that a node becomes: the first of all that lie on each other. Three bodies and more may meet
    /// there, whether or not each two of them are bonded.
    fn first(&self, mut node: u32) -> u32 {
        while let Some(&other) = self.merged.get(&node) {
            node = other;
        }
        node
    }

    /// Makes two nodes one.
    fn merge(&mut self, (one, other): (u32, u32)) {
        let [one, other] = [one, other].map(|node| self.first(node));
        if one != other {
            self.merged.insert(one.max(other), one.min(other));
        }
    }

    /// Makes bonded facets joints of their sets, and their nodes one.
    ///
    /// A boundary on one of two bonded bodies leaves out their common nodes, which it would move in both.
    ///
    /// # Errors
    /// Says which boundary is on nothing else, or which velocities differ.
    pub(crate) fn join<const N: usize>(&self, prepared: &mut Prepared<D, N>) -> Result<(), String>
    where
        [[f64; D]; N]: Corners<D, N> + Element<D, N>,
    {
        if self.sets.is_empty() {
            return Ok(());
        }
        let first = |node: u32| self.first(node);
        let model = &mut prepared.model;
        let mut members: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &node in self.merged.keys() {
            members.entry(first(node)).or_insert_with(|| vec![first(node)]).push(node);
        }
        let velocity = |node: u32| model.velocities.get(node as usize);
        if let Some((node, _)) =
            members.iter().find(|(_, all)| all.iter().any(|node| velocity(*node) != velocity(all[0])))
        {
            let place = model.mesh.nodes[*node as usize];
            return Err(format!("bonded bodies begin with different velocities near {place:?}"));
        }
        for nodes in &mut model.mesh.elements {
            *nodes = nodes.map(first);
        }
        for boundary in &mut model.boundaries {
            match &mut boundary.target {
                Target::Nodes(nodes) => {
                    let all: BTreeSet<u32> = nodes.iter().copied().collect();
                    let is_whole = |node: &u32| {
                        members
                            .get(&first(*node))
                            .is_none_or(|members| members.iter().all(|node| all.contains(node)))
                    };
                    let kept: BTreeSet<u32> =
                        all.iter().filter(|node| is_whole(node)).map(|&node| first(node)).collect();
                    let left_out = all.iter().filter(|node| !is_whole(node)).count();
                    if kept.is_empty() && left_out > 0 {
                        return Err(format!(
                            "[[boundary]] \"{}\" is on nodes of bonds alone, which belong to other bodies too",
                            boundary.name
                        ));
                    }
                    if left_out > 0 {
                        prepared.warnings.push(format!(
                            "[[boundary]] \"{}\" leaves out {left_out} nodes on bonds: they belong to other bodies too",
                            boundary.name
                        ));
                    }
                    *nodes = kept.into_iter().collect();
                }
                Target::Facets(facets) | Target::Held(facets, _) => {
                    for facet in facets {
                        *facet = facet.map(first);
                    }
                }
            }
        }
        for source in model.fluid.iter_mut().flat_map(|fluid| &mut fluid.sources) {
            source.facets.iter_mut().for_each(|facet| *facet = facet.map(first));
        }
        for surface in model.pores.iter_mut().flat_map(|pores| &mut pores.surfaces) {
            surface.target.nodes_mut().iter_mut().for_each(|node| *node = first(*node));
        }
        for (set, pairs, facets) in &self.sets {
            let facets: Vec<[u32; D]> = facets.iter().map(|facet| facet.map(first)).collect();
            let corners = |facet: &[u32; D]| facet.map(|node| model.mesh.nodes[node as usize]);
            let measure =
                facets.iter().map(|facet| <[[f64; D]; N]>::facet_measure(&corners(facet))).sum::<f64>();
            let Joints { facets: count, joints, length, area, .. } = &mut prepared.joint_sets[*set as usize];
            (*count, *joints) = (facets.len(), *pairs);
            length.iter_mut().chain(area).for_each(|all| *all = measure);
            if model.add_joints(*set, &facets) != facets.len() {
                return Err("bonds are not between two elements each: bodies lie on each other".to_owned());
            }
        }
        let Subset { model, nodes, .. } =
            model.keeping(&vec![true; model.mesh.elements.len()]).map_err(|error| error.to_string())?;
        prepared.model = model;
        let number = |node: u32| nodes[first(node) as usize];
        for body in &mut prepared.bodies {
            let own = body.nodes.clone().filter_map(|node| nodes[node as usize]);
            body.nodes = range(own, prepared.model.mesh.nodes.len() as u32);
        }
        for group in &mut prepared.groups {
            group.nodes = group.nodes.iter().filter_map(|&node| number(node)).collect();
            let bonded: BTreeSet<[u32; D]> = self
                .sets
                .iter()
                .flat_map(|(_, _, facets)| facets)
                .map(|facet| sorted(facet.map(first)))
                .collect();
            group.facets.retain(|facet| !bonded.contains(&sorted(facet.map(first))));
            for facet in &mut group.facets {
                *facet = facet.map(|node| number(node).unwrap_or_default());
            }
        }
        for history in &mut prepared.histories {
            if let Quantity::Node(node) = &mut history.quantity {
                *node = number(*node).unwrap_or(u32::MAX);
            }
        }
        for probe in &mut prepared.probes {
            *probe = probe.renumbered(Some, number);
        }
        Ok(())
    }
}

/// Pairs of different bodies, one of each list, whose boxes are near each other along x.
fn near<const D: usize>(
    outsides: &BTreeMap<usize, Outside<D>>,
    ones: &[usize],
    others: &[usize],
) -> BTreeSet<(usize, usize)> {
    let reach = |body: &usize| {
        let Outside { low, high, .. } = &outsides[body];
        let slack = NEAR * (high[0] - low[0]);
        [low[0] - slack, high[0] + slack]
    };
    let mut sorted: Vec<([f64; 2], usize)> = others.iter().map(|body| (reach(body), *body)).collect();
    sorted.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let widest = sorted.iter().map(|(reach, _)| reach[1] - reach[0]).fold(0.0, f64::max);
    let mut pairs = BTreeSet::new();
    for one in ones {
        let [low, high] = reach(one);
        let first = sorted.partition_point(|(reach, _)| reach[0] < low - widest);
        let candidates = sorted[first..].iter().take_while(|(reach, _)| reach[0] <= high);
        let touching = candidates.filter(|(reach, body)| reach[1] >= low && body != one);
        pairs.extend(touching.map(|&(_, body)| (body.min(*one), body.max(*one))));
    }
    pairs
}

/// The range of ascending numbers without gaps; an empty one at the end if there are no numbers.
fn range(mut numbers: impl Iterator<Item = u32>, end: u32) -> Range<u32> {
    let first = numbers.next();
    first.map_or(end..end, |first| first..first + 1 + numbers.count() as u32)
}

/// The outer facets of a body, and their nodes from left to right.
struct Outside<const D: usize> {
    facets: Vec<Outer<D>>,
    nodes: Vec<(u32, [f64; D])>,
    low: [f64; D],
    high: [f64; D],
}

/// An outer facet.
struct Outer<const D: usize> {
    nodes: [u32; D],
    places: [[f64; D]; D],
    /// Distance up to which nodes are one, m.
    near: f64,
}

impl<const D: usize> Outside<D> {
    fn of<const N: usize>(placed: &Placed<D, N>) -> Self
    where
        [[f64; D]; N]: Corners<D, N>,
    {
        let piece = &placed.piece;
        let mut facets = Vec::new();
        let mut nodes = BTreeMap::new();
        for &facet in &piece.outline {
            let places = facet.map(|node| piece.nodes[node as usize]);
            let longest =
                places.iter().flat_map(|a| places.iter().map(|b| distance(*a, *b))).fold(0.0, f64::max);
            let numbers = facet.map(|node| node + placed.first[0]);
            nodes.extend(numbers.into_iter().zip(places));
            facets.push(Outer { nodes: numbers, places, near: NEAR * longest });
        }
        let mut nodes: Vec<(u32, [f64; D])> = nodes.into_iter().collect();
        nodes.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
        let [low, high] = bounds(nodes.iter().map(|node| node.1));
        Self { facets, nodes, low, high }
    }

    /// The nodes within a box.
    fn within(&self, low: [f64; D], high: [f64; D]) -> impl Iterator<Item = (u32, [f64; D])> {
        let first = self.nodes.partition_point(|node| node.1[0] < low[0]);
        let near = self.nodes[first..].iter().take_while(move |node| node.1[0] <= high[0]);
        near.filter(move |node| (0..D).all(|axis| low[axis] <= node.1[axis] && node.1[axis] <= high[axis]))
            .copied()
    }

    /// The facets of this body that lie on facets of another, each with the nodes of the other in the same
    /// order. The error is a place where facets lie on each other in part.
    #[allow(clippy::type_complexity, reason = "pairs of facets, named where they are used")]
    fn on(&self, other: &Self) -> Result<Vec<([u32; D], [u32; D])>, [f64; D]> {
        let apart = |axis: usize| {
            let near = NEAR * (self.high[axis] - self.low[axis]);
            self.low[axis] > other.high[axis] + near || other.low[axis] > self.high[axis] + near
        };
        if (0..D).any(apart) {
            return Ok(Vec::new());
        }
        let theirs: BTreeSet<[u32; D]> = other.facets.iter().map(|facet| sorted(facet.nodes)).collect();
        let mut found = Vec::new();
        let mut matched = BTreeSet::new();
        for facet in &self.facets {
            let partners = facet.places.map(|place| other.at(place, facet.near));
            if let Some(partners) = all(partners) {
                if !theirs.contains(&sorted(partners)) {
                    return Err(facet.places[0]);
                }
                matched.insert(sorted(partners));
                found.push((facet.nodes, partners));
            } else if let Some(place) = other.inside(facet) {
                return Err(place);
            }
        }
        let mut unmatched = other.facets.iter().filter(|facet| !matched.contains(&sorted(facet.nodes)));
        match unmatched.find_map(|facet| self.inside(facet)) {
            Some(place) => Err(place),
            None => Ok(found),
        }
    }

    /// The node at a place.
    fn at(&self, place: [f64; D], near: f64) -> Option<u32> {
        let nodes = self.within(place.map(|x| x - near), place.map(|x| x + near));
        nodes.min_by(|a, b| distance(a.1, place).total_cmp(&distance(b.1, place))).map(|node| node.0)
    }

    /// The place of a node that is on a facet of another body, and not at one of its nodes.
    fn inside(&self, facet: &Outer<D>) -> Option<[f64; D]> {
        let [low, high] = bounds(facet.places.into_iter());
        let near = facet.near;
        let mut nodes = self.within(low.map(|x| x - near), high.map(|x| x + near));
        nodes
            .find(|(_, place)| {
                facet.places.iter().all(|corner| distance(*corner, *place) > near)
                    && is_on(&facet.places, *place, near)
            })
            .map(|node| node.1)
    }
}

/// All of some values, or none.
fn all<const D: usize>(values: [Option<u32>; D]) -> Option<[u32; D]> {
    values.iter().all(Option::is_some).then(|| values.map(Option::unwrap_or_default))
}

fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

/// Whether a place is on a facet: its coordinates along the edges from the first corner, by least squares,
/// are within the facet, and it is as near to their point as that.
fn is_on<const D: usize>(corners: &[[f64; D]; D], place: [f64; D], near: f64) -> bool {
    let minus = |a: [f64; D], b: [f64; D]| -> [f64; D] { std::array::from_fn(|axis| a[axis] - b[axis]) };
    let dot = |a: [f64; D], b: [f64; D]| (0..D).map(|axis| a[axis] * b[axis]).sum::<f64>();
    let to = minus(place, corners[0]);
    let edges: Vec<[f64; D]> = corners[1..].iter().map(|corner| minus(*corner, corners[0])).collect();
    // Gram and Schmidt, from the last edge back.
    let mut axes: Vec<[f64; D]> = Vec::new();
    for edge in &edges {
        let mut axis = *edge;
        for before in &axes {
            let share = dot(axis, *before) / dot(*before, *before);
            axis = std::array::from_fn(|k| axis[k] - share * before[k]);
        }
        axes.push(axis);
    }
    let mut left = to;
    let mut shares = vec![0.0; edges.len()];
    for k in (0..edges.len()).rev() {
        let share = dot(left, axes[k]) / dot(edges[k], axes[k]);
        shares[k] = share;
        left = std::array::from_fn(|axis| left[axis] - share * edges[k][axis]);
    }
    let rest = 1.0 - shares.iter().sum::<f64>();
    let size = edges.iter().map(|edge| dot(*edge, *edge).sqrt()).fold(0.0, f64::max);
    let slack = near / size;
    dot(left, left).sqrt() <= near && shares.iter().chain([&rest]).all(|share| *share >= -slack)
}
