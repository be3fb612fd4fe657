//! Elements that can touch at all.
//!
//! Only elements near a free surface can touch elements to which they are not connected. A vertex is free if
//! an outer edge or a broken joint ends there. Elements within two rings around the free vertices are
//! *watched*: contact detection gets their boxes, with a buffer. When a crack reaches an element that is not
//! watched, the watched elements are determined again.

use crate::faces::Faces;
use crate::joints::Joints;
use crate::share::Share;
use crate::simplex::Simplex;
use crate::topology::{NONE, Topology};

/// Elements that can touch, and those that have separated.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    /// Whether each vertex is free: on an outer facet or a broken joint.
    pub(crate) free: Vec<bool>,
    /// Group of each corner among those of its vertex, by the code of its first corner: elements of one group
    /// are connected there.
    pub(crate) groups: Vec<u32>,
    /// Whether each element is bare: whether one of its vertices is free. Only bare elements touch others.
    pub(super) bare: Vec<bool>,
    /// Whether each element is watched.
    pub(crate) watched: Vec<bool>,
    /// The watched elements, ascending.
    pub(super) list: Vec<u32>,
    /// Pairs of elements that separated in the last step, at a vertex or along a facet, and elements that
    /// became bare in it, ascending. Their overlap must not count immediately.
    pub(super) parted: Vec<[u32; 2]>,
    pub(crate) bared: Vec<u32>,
    /// Elements that the model has since this step and whose overlaps must not count immediately, ascending.
    pub(crate) new: Vec<u32>,
    /// Whether an element at a free vertex is not watched yet.
    pub(super) unwatched: bool,
}

impl Surface {
    pub(super) fn new<const D: usize, const N: usize>(topology: &Topology<D, N>, faces: &Faces<D>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let elements = topology.facet_of.len();
        let mut surface = Self {
            free: faces.vertices(topology),
            groups: vec![0; topology.vertices.len()],
            bare: vec![false; elements],
            watched: vec![false; elements],
            list: Vec::new(),
            parted: Vec::new(),
            bared: Vec::new(),
            new: Vec::new(),
            unwatched: true,
        };
        for vertex in 0..topology.vertex_count() as u32 {
            for (corner, group) in group(vertex, topology, |_| true) {
                surface.groups[corner as usize] = group;
            }
        }
        surface.bare_all(topology);
        surface
    }

    /// Memory, bytes.
    pub(super) fn bytes(&self) -> usize {
        let Self { free, groups, bare, watched, list, .. } = self;
        size_of_val(&**free)
            + size_of_val(&**groups)
            + size_of_val(&**bare)
            + size_of_val(&**watched)
            + size_of_val(&**list)
    }

    /// Marks the elements at a free vertex as bare.
    fn bare_at<const D: usize, const N: usize>(&mut self, vertex: u32, topology: &Topology<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        for &corner in topology.corners_of(vertex) {
            let element = corner as usize / N;
            if !self.bare[element] {
                self.bare[element] = true;
                self.bared.push(element as u32);
            }
        }
    }

    /// Marks the elements at all free vertices as bare, as they have been for long.
    fn bare_all<const D: usize, const N: usize>(&mut self, topology: &Topology<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        for vertex in 0..self.free.len() as u32 {
            if self.free[vertex as usize] {
                self.bare_at(vertex, topology);
            }
        }
        self.bared.clear();
    }

    /// Sets the groups of all corners, and which vertices are free.
    pub(crate) fn set_known<const D: usize, const N: usize>(
        &mut self,
        groups: Vec<u32>,
        free: Vec<bool>,
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        (self.groups, self.free) = (groups, free);
        self.bare_all(topology);
    }

    /// Registers joints that broke: their elements may touch from the next step on. Returns the vertices at
    /// which they are, ascending.
    pub(crate) fn part<const D: usize, const N: usize>(
        &mut self,
        broken: &[u32],
        joints: &Joints<D>,
        topology: &Topology<D, N>,
        share: &Share,
    ) -> Vec<u32>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut vertices = Vec::new();
        for &joint in broken {
            let facet = &topology.facets[joints.all[joint as usize].facet as usize];
            vertices.extend(facet.corners[0].map(|corner| topology.vertices[corner as usize]));
            self.parted.push(facet.elements());
        }
        vertices.sort_unstable();
        vertices.dedup();
        for &vertex in &vertices {
            let groups = group(vertex, topology, |facet| joints.holds(facet));
            let owned: Vec<_> = groups.into_iter().filter(|(corner, _)| share.corner(*corner)).collect();
            self.divide(vertex, &owned, topology);
        }
        self.list_parted();
        vertices
    }

    /// Sets the groups of some corners of a vertex, which is free from now on.
    pub(crate) fn divide<const D: usize, const N: usize>(
        &mut self,
        vertex: u32,
        groups: &[(u32, u32)],
        topology: &Topology<D, N>,
    ) where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.free[vertex as usize] = true;
        self.bare_at(vertex, topology);
        let corners = topology.corners_of(vertex);
        self.unwatched |= corners.iter().any(|&corner| !self.watched[corner as usize / N]);
        for (k, &(one, group)) in groups.iter().enumerate() {
            for &(other, another) in &groups[k + 1..] {
                if self.groups[one as usize] == self.groups[other as usize] && group != another {
                    self.parted.push([one / N as u32, other / N as u32]);
                }
            }
        }
        for &(corner, group) in groups {
            self.groups[corner as usize] = group;
        }
    }

    /// Orders the lists of elements that have separated or become bare.
    pub(crate) fn list_parted(&mut self) {
        self.parted.sort_unstable();
        // Elements that share a facet are listed for the facet and for all of its vertices.
        self.parted.dedup();
        self.bared.sort_unstable();
        self.bared.dedup();
    }

    /// Whether one of these elements has become bare in the last step.
    pub(super) fn has_bared(&self, elements: [u32; 2]) -> bool {
        elements.iter().any(|element| self.bared.binary_search(element).is_ok())
    }

    /// Lists all bare elements as new.
    pub(super) fn begin(&mut self) {
        self.new = (0..self.bare.len() as u32).filter(|&element| self.bare[element as usize]).collect();
    }

    /// Whether the model has one of these elements since this step.
    pub(super) fn has_new(&self, elements: [u32; 2]) -> bool {
        elements.iter().any(|element| self.new.binary_search(element).is_ok())
    }

    /// Watches all bare elements, and those beside them, if some are not watched yet. Returns whether the
    /// watched elements have changed.
    pub(super) fn watch_bare<const D: usize, const N: usize>(
        &mut self,
        joints: &Joints<D>,
        topology: &Topology<D, N>,
    ) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let changes = std::mem::take(&mut self.unwatched);
        if changes {
            self.watch(joints, topology);
        }
        changes
    }

    /// Watches the elements at free vertices, and those beside them that can break: cracks reach these next.
    fn watch<const D: usize, const N: usize>(&mut self, joints: &Joints<D>, topology: &Topology<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let may_part = |element: usize| {
            topology.facet_of[element].iter().any(|&facet| facet != NONE && joints.may_part(facet))
        };
        let mut near = self.free.clone();
        for ring in 0..2 {
            let mut next = near.clone();
            for (element, watched) in self.watched.iter_mut().enumerate() {
                let vertices = &topology.vertices[N * element..N * element + N];
                let is_near = vertices.iter().any(|&vertex| near[vertex as usize]);
                if is_near && (ring == 0 || may_part(element)) {
                    *watched = true;
                    for &vertex in vertices {
                        next[vertex as usize] = true;
                    }
                }
            }
            near = next;
        }
        self.list.clear();
        self.list.extend((0..self.watched.len() as u32).filter(|&element| self.watched[element as usize]));
    }
}

/// Groups the corners of a vertex: elements are connected by the facets that `holds` accepts. Returns each
/// corner with the code of the first corner of its group.
fn group<const D: usize, const N: usize>(
    vertex: u32,
    topology: &Topology<D, N>,
    holds: impl Fn(u32) -> bool,
) -> Vec<(u32, u32)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (corners, mut groups) = (topology.corners_of(vertex), Vec::new());
    topology.groups(vertex, holds, &mut groups);
    let label = |group: u32| topology.code_of_corner(corners[group as usize]);
    corners.iter().zip(groups).map(|(&corner, group)| (corner, label(group))).collect()
}
