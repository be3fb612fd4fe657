//! The share of a run that one rank computes and counts.
//!
//! A rank owns corners of elements, and moves their nodes. It holds every element that acts on them. Some of
//! these have corners of other ranks: their nodes are moved there. Parts that several ranks hold are counted
//! by one of them: an element, and a couple by its first element, by the owner of the first corner; a joint
//! by the owner of its first corner.

/// The corners and nodes of a run that belong to this rank: all of them, if all lists are empty.
#[derive(Clone, Debug, Default)]
pub(crate) struct Share {
    /// Whether each corner is owned.
    pub(crate) corners: Vec<bool>,
    /// Whether each node is, that is, all of its corners.
    pub(crate) nodes: Vec<bool>,
    /// Codes of the first corners of nodes that are not owned, whose elements need not all be here.
    pub(crate) codes: Vec<u32>,
    /// Number of corners of an element.
    pub(crate) of_element: usize,
}

impl Share {
    /// Whether everything belongs to this rank.
    #[inline]
    pub(crate) fn is_whole(&self) -> bool {
        self.corners.is_empty()
    }

    #[inline]
    pub(crate) fn corner(&self, corner: u32) -> bool {
        self.is_whole() || self.corners[corner as usize]
    }

    #[inline]
    pub(crate) fn node(&self, node: usize) -> bool {
        self.is_whole() || self.nodes[node]
    }

    /// Whether an element is counted here.
    #[inline]
    pub(crate) fn element(&self, element: u32) -> bool {
        self.is_whole() || self.corners[element as usize * self.of_element]
    }

    /// Whether an element acts on a node that is owned.
    #[inline]
    pub(crate) fn acts(&self, element: u32) -> bool {
        let first = element as usize * self.of_element;
        self.is_whole() || self.corners[first..first + self.of_element].contains(&true)
    }

    /// Selects the corners of a vertex that are owned, with their groups. Corners of one group have one
    /// owner.
    pub(crate) fn owned(&self, corners: &[u32], groups: &[u32]) -> (Vec<u32>, Vec<u32>) {
        if self.is_whole() {
            return (corners.to_vec(), groups.to_vec());
        }
        let own: Vec<usize> = (0..corners.len()).filter(|&place| self.corner(corners[place])).collect();
        // The number of a group is the place of its first corner.
        let group = |&place: &usize| own.binary_search(&(groups[place] as usize)).unwrap_or_default() as u32;
        (own.iter().map(|&place| corners[place]).collect(), own.iter().map(group).collect())
    }

    /// Notes a new node that has been split from another.
    pub(crate) fn split(&mut self, old: u32) {
        if !self.is_whole() {
            self.nodes.push(self.nodes[old as usize]);
            self.codes.push(self.codes[old as usize]);
        }
    }
}
