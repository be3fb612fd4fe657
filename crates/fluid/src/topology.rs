//! The connections of cells: junctions, compartments, links.

use std::ops::Range;

use crate::cell::Cell;

/// Compartment of a member that is dry.
pub(crate) const DRY: u32 = u32::MAX;

/// The way from the centre of a cell to one of its doors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arm {
    pub(crate) cell: u32,
    /// The corner opposite to the door.
    pub(crate) door: u32,
}

/// A connection of two compartments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Link {
    pub(crate) junction: u32,
    /// Two arms of the junction.
    pub(crate) arms: [u32; 2],
    /// The compartments at their ends, the smaller one first.
    pub(crate) ends: [u32; 2],
    /// The entry of the matrix between these.
    pub(crate) entry: u32,
}

impl Link {
    /// The end that fluid leaves and the one that it reaches, where a pressure drives it from the first one.
    pub(crate) fn along(&self, drop: f64) -> [u32; 2] {
        let [first, second] = self.ends;
        if drop >= 0.0 { [first, second] } else { [second, first] }
    }
}

/// Connections of the wet members: cells in the order of their keys, then sources in the order of theirs.
///
/// Cells meet in junctions: at a corner in the plane, at an edge in space. A compartment is a set of members
/// with one pressure.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Topology {
    /// The compartment of each member, or [`DRY`].
    pub(crate) compartment: Vec<u32>,
    /// Members of compartment `k`, in order: `members[starts[k]..starts[k + 1]]`.
    members: Vec<u32>,
    starts: Vec<usize>,
    /// Arms of junction `k`, by their cells: `arms[junctions[k]..junctions[k + 1]]`.
    pub(crate) arms: Vec<Arm>,
    pub(crate) junctions: Vec<usize>,
    /// Sorted by their ends.
    pub(crate) links: Vec<Link>,
    /// Links of compartment `k`, in order: `links_of[link_starts[k]..link_starts[k + 1]]`.
    links_of: Vec<u32>,
    link_starts: Vec<usize>,
    /// Pairs of compartments with links, sorted.
    pub(crate) entries: Vec<[u32; 2]>,
}

/// Sets that are united one by one; the smallest member stands for its set.
struct Sets(Vec<u32>);

impl Sets {
    fn find(&mut self, member: u32) -> u32 {
        let mut at = member;
        while self.0[at as usize] != at {
            let next = self.0[at as usize];
            self.0[at as usize] = self.0[next as usize];
            at = next;
        }
        at
    }

    fn unite(&mut self, a: u32, b: u32) {
        let [a, b] = [self.find(a), self.find(b)];
        self.0[a.max(b) as usize] = a.min(b);
    }
}

impl Topology {
    /// Connects wet cells. `sources`: the cells of each source, and whether it has a volume. `is_cavities`:
    /// cells that are connected have one pressure.
    pub(crate) fn of<const D: usize>(
        cells: &[Cell<D>],
        is_wet: &[bool],
        sources: &[(Vec<u32>, bool)],
        is_cavities: bool,
    ) -> Self {
        let mut new = Self::default();
        new.add_junctions(cells, is_wet);
        new.add_compartments(is_wet, sources, is_cavities);
        new.add_links();
        new
    }

    pub(crate) fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    pub(crate) fn members(&self, compartment: usize) -> &[u32] {
        &self.members[self.starts[compartment]..self.starts[compartment + 1]]
    }

    /// Numbers of the links of a compartment.
    pub(crate) fn links_of(&self, compartment: usize) -> &[u32] {
        &self.links_of[self.link_starts[compartment]..self.link_starts[compartment + 1]]
    }

    fn junction(&self, number: usize) -> Range<usize> {
        self.junctions[number]..self.junctions[number + 1]
    }

    fn add_junctions<const D: usize>(&mut self, cells: &[Cell<D>], is_wet: &[bool]) {
        let mut doors: Vec<([u32; 2], Arm)> = Vec::new();
        for (k, cell) in cells.iter().enumerate().filter(|(k, _)| is_wet[*k]) {
            doors.extend((0..D).map(|at| (cell.door(at), Arm { cell: k as u32, door: at as u32 })));
        }
        doors.sort_unstable_by_key(|(corners, arm)| (*corners, arm.cell));
        let mut groups: Vec<&[([u32; 2], Arm)]> =
            doors.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1).collect();
        // By keys of cells: numbers of corners decide only between junctions of the same cells.
        groups.sort_by(|a, b| {
            let cells =
                |group: &[([u32; 2], Arm)]| group.iter().map(|(_, arm)| arm.cell).collect::<Vec<u32>>();
            let first = a[0].1.cell.cmp(&b[0].1.cell);
            first.then_with(|| cells(a).cmp(&cells(b))).then(a[0].0.cmp(&b[0].0))
        });
        self.junctions.push(0);
        for group in groups {
            self.arms.extend(group.iter().map(|(_, arm)| *arm));
            self.junctions.push(self.arms.len());
        }
    }

    fn add_compartments(&mut self, is_wet: &[bool], sources: &[(Vec<u32>, bool)], is_cavities: bool) {
        let cells = is_wet.len();
        let mut sets = Sets((0..(cells + sources.len()) as u32).collect());
        let mut is_in = is_wet.to_vec();
        for (k, (of, has_volume)) in sources.iter().enumerate() {
            let wet = of.iter().filter(|cell| is_wet[**cell as usize]);
            is_in.push(*has_volume || wet.clone().next().is_some());
            wet.for_each(|cell| sets.unite(*cell, (cells + k) as u32));
        }
        if is_cavities {
            for number in 0..self.junctions.len() - 1 {
                let arms = &self.arms[self.junction(number)];
                arms.windows(2).for_each(|pair| sets.unite(pair[0].cell, pair[1].cell));
            }
        }
        // A set has the number of its first member.
        self.compartment = vec![DRY; is_in.len()];
        let mut count = 0;
        for member in (0..is_in.len() as u32).filter(|member| is_in[*member as usize]) {
            let first = sets.find(member) as usize;
            if first == member as usize {
                self.compartment[first] = count;
                count += 1;
            }
            self.compartment[member as usize] = self.compartment[first];
        }
        self.members = (0..is_in.len() as u32).filter(|member| is_in[*member as usize]).collect();
        self.members.sort_by_key(|member| self.compartment[*member as usize]);
        let place = |k: u32| self.members.partition_point(|member| self.compartment[*member as usize] < k);
        self.starts = (0..=count).map(place).collect();
    }

    fn add_links(&mut self) {
        let mut links = Vec::new();
        for number in 0..self.junctions.len() - 1 {
            let arms = self.junction(number);
            for (a, b) in arms.clone().flat_map(|a| (a + 1..arms.end).map(move |b| (a, b))) {
                let [from, to] = [a, b].map(|arm| self.compartment[self.arms[arm].cell as usize]);
                let (ends, arms) = if from < to { ([from, to], [a, b]) } else { ([to, from], [b, a]) };
                if from != to {
                    let arms = arms.map(|arm| arm as u32);
                    links.push(Link { junction: number as u32, arms, ends, entry: 0 });
                }
            }
        }
        links.sort_by_key(|link| link.ends);
        for link in &mut links {
            if self.entries.last() != Some(&link.ends) {
                self.entries.push(link.ends);
            }
            link.entry = (self.entries.len() - 1) as u32;
        }
        let mut of: Vec<(u32, u32)> =
            (0_u32..).zip(&links).flat_map(|(k, link)| link.ends.map(|end| (end, k))).collect();
        of.sort_unstable();
        let start = |k: usize| of.partition_point(|(end, _)| (*end as usize) < k);
        self.link_starts = (0..=self.len()).map(start).collect();
        self.links_of = of.into_iter().map(|(_, k)| k).collect();
        self.links = links;
    }
}
