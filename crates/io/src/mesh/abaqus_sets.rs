//! Sets and surfaces of Abaqus: how their lines become groups of elements, nodes and facets.

use std::collections::{BTreeMap, BTreeSet};

use crate::excerpt;
use crate::mesh::build::{DraftGroup, Raw};
use crate::mesh::cursor::{integer, name};
use crate::mesh::error::{Fault, malformed};
use crate::mesh::file::MeshBody;
use crate::place::Place;

/// Most members of all sets together, for each element and node of the mesh: sets of sets may grow without
/// bound otherwise.
const MEMBERS: usize = 64;

/// The members that a line of a set has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SetKind {
    Elements,
    Nodes,
    /// The nodes of elements.
    NodesOf,
    /// The faces with this index of elements.
    Facets(usize),
}

/// A member of a set: numbers, or another set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Member {
    /// From, to, step.
    Range(u64, u64, u64),
    Set(String),
}

/// Reads a member: a number, or a name.
pub(crate) fn member(field: &[u8]) -> Result<Member, String> {
    let is_number = field.first().is_none_or(|byte| byte.is_ascii_digit() || *byte == b'-');
    // A name with an instance before it may start with a digit: 1-block.7.
    if !is_number || field.contains(&b'.') {
        return Ok(Member::Set(name(field).trim_matches('"').to_owned()));
    }
    number(field).map(|number| Member::Range(number, number, 1))
}

fn number(field: &[u8]) -> Result<u64, String> {
    let number = integer(field)?;
    u64::try_from(number).map_err(|_| format!("expected a number of an element or a node, found {number}"))
}

/// Reads the members of a data line. `generate`: first, last and step.
pub(crate) fn members(fields: &[&[u8]], generate: bool) -> Result<Vec<Member>, String> {
    if !generate {
        return fields.iter().map(|field| member(field)).collect();
    }
    let numbers = fields.iter().map(|field| number(field)).collect::<Result<Vec<u64>, String>>()?;
    match numbers[..] {
        [from, to] if from <= to => Ok(vec![Member::Range(from, to, 1)]),
        [from, to, step] if from <= to && step > 0 => Ok(vec![Member::Range(from, to, step)]),
        _ => Err("expected first, last and step of a set".into()),
    }
}

/// A line of a set.
#[derive(Debug)]
struct SetLine {
    set: u32,
    kind: SetKind,
    member: Member,
    /// Name of the instance whose members are meant.
    instance: Option<String>,
    place: Place,
}

/// Sets by their part, 0 outside of parts, and their name in capitals: Abaqus ignores case.
#[derive(Debug, Default)]
pub(crate) struct Sets {
    numbers: BTreeMap<(usize, String), u32>,
    /// Part and first spelling.
    names: Vec<(usize, String)>,
    lines: Vec<SetLine>,
}

/// A part in its place: an instance, or a part without instance.
#[derive(Debug)]
pub(crate) struct Placement {
    pub(crate) name: String,
    pub(crate) part: usize,
    /// Numbers of elements with their indices, sorted.
    pub(crate) elements: Vec<(u64, u32)>,
    /// Numbers of nodes with their indices, sorted.
    pub(crate) nodes: Vec<(u64, u32)>,
    /// Numbers of elements that were left out, sorted.
    pub(crate) left_out: Vec<u64>,
}

/// Members of a set in each placement.
#[derive(Debug, Clone, Default)]
struct Content {
    elements: BTreeMap<usize, Vec<u32>>,
    nodes: BTreeMap<usize, Vec<u32>>,
    facets: BTreeMap<usize, Vec<(u32, usize)>>,
}

/// The sets with their members.
pub(crate) struct Resolved {
    names: Vec<(usize, String)>,
    contents: Vec<Content>,
}

impl Sets {
    /// The number of a set, which is made if it is new.
    pub(crate) fn number(&mut self, part: usize, spelled: &str) -> u32 {
        let next = self.names.len() as u32;
        let set = *self.numbers.entry((part, spelled.to_uppercase())).or_insert(next);
        if set == next {
            self.names.push((part, name(spelled.as_bytes())));
        }
        set
    }

    pub(crate) fn name(&self, set: u32) -> &str {
        &self.names[set as usize].1
    }

    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// Adds members to a set.
    pub(crate) fn add(
        &mut self,
        (set, kind): (u32, SetKind),
        member: Member,
        instance: Option<&str>,
        place: Place,
    ) {
        let instance = instance.map(str::to_owned);
        self.lines.push(SetLine { set, kind, member, instance, place });
    }

    /// Adds an element or a node to a set, in one line with its predecessor if their numbers are consecutive.
    pub(crate) fn add_next(&mut self, (set, kind): (u32, SetKind), number: u64, place: Place) {
        if let Some(SetLine { set: last, kind: of, member: Member::Range(_, to, 1), instance: None, .. }) =
            self.lines.last_mut()
            && *last == set
            && *of == kind
            && to.checked_add(1) == Some(number)
        {
            *to = number;
            return;
        }
        self.add((set, kind), Member::Range(number, number, 1), None, place);
    }

    /// Finds the members of all sets. `nodes_of`: the nodes of an element.
    pub(crate) fn resolve(
        self,
        placements: &[Placement],
        raws: &[Raw],
        nodes_of: impl Fn(&Raw) -> Vec<u32>,
    ) -> Result<Resolved, Fault> {
        let size: usize =
            placements.iter().map(|placement| placement.elements.len() + placement.nodes.len()).sum();
        let most = (MEMBERS * size).max(1 << 20);
        let mut contents = vec![Content::default(); self.names.len()];
        let mut total = 0;
        for line in &self.lines {
            let bad = |problem: String| (line.place, malformed(problem));
            for (at, member) in self.targets(line, placements).map_err(bad)? {
                let of_nodes = line.kind == SetKind::Nodes;
                let found = self.found((line, member), &contents, (at, placements)).map_err(bad)?;
                total += found.len();
                if total > most {
                    return Err(bad(format!("the sets have more than {most} members")));
                }
                let content = &mut contents[line.set as usize];
                match line.kind {
                    SetKind::NodesOf => {
                        let nodes = found.iter().flat_map(|&element| nodes_of(&raws[element as usize]));
                        content.nodes.entry(at).or_default().extend(nodes);
                    }
                    SetKind::Facets(face) => {
                        for element in found {
                            let raw = &raws[element as usize];
                            if face >= raw.shape.faces().len() {
                                let name = self.name(line.set);
                                let (number, kind) = (raw.number, raw.shape.name());
                                let problem = format!(
                                    "*SURFACE {name}: element {number} ({kind}) has no face S{}",
                                    face + 1
                                );
                                return Err(bad(problem));
                            }
                            content.facets.entry(at).or_default().push((element, face));
                        }
                    }
                    _ if of_nodes => content.nodes.entry(at).or_default().extend(found),
                    _ => content.elements.entry(at).or_default().extend(found),
                }
            }
        }
        for content in &mut contents {
            for members in content.elements.values_mut().chain(content.nodes.values_mut()) {
                members.sort_unstable();
                members.dedup();
            }
        }
        Ok(Resolved { names: self.names, contents })
    }

    /// The placements that a line is about, each with the names there.
    fn targets<'a>(
        &self,
        line: &'a SetLine,
        placements: &'a [Placement],
    ) -> Result<Vec<(usize, std::borrow::Cow<'a, Member>)>, String> {
        use std::borrow::Cow;
        let part = self.names[line.set as usize].0;
        let named =
            |name: &str| (1..placements.len()).find(|&at| placements[at].name.eq_ignore_ascii_case(name));
        if part > 0 {
            let of_part = (1..placements.len()).filter(|&at| placements[at].part == part);
            return Ok(of_part.map(|at| (at, Cow::Borrowed(&line.member))).collect());
        }
        if let Some(instance) = &line.instance {
            let at = named(instance).ok_or_else(|| {
                let shown = excerpt::field(instance.as_bytes());
                format!("set {} names the instance '{shown}', which is not there", self.name(line.set))
            })?;
            return Ok(vec![(at, Cow::Borrowed(&line.member))]);
        }
        let Member::Set(name) = &line.member else { return Ok(vec![(0, Cow::Borrowed(&line.member))]) };
        // A set outside of parts has members from all placements.
        if self.numbers.contains_key(&(0, name.to_uppercase())) {
            return Ok((0..placements.len()).map(|at| (at, Cow::Borrowed(&line.member))).collect());
        }
        match name.split_once('.').and_then(|(instance, rest)| Some((named(instance)?, rest))) {
            Some((at, rest)) => Ok(vec![(at, Cow::Owned(member(rest.as_bytes())?))]),
            None => Ok(vec![(0, Cow::Borrowed(&line.member))]),
        }
    }

    /// The elements or nodes that a member of a line is in a placement.
    fn found(
        &self,
        (line, member): (&SetLine, std::borrow::Cow<'_, Member>),
        contents: &[Content],
        (at, placements): (usize, &[Placement]),
    ) -> Result<Vec<u32>, String> {
        let placement = &placements[at];
        let of_nodes = line.kind == SetKind::Nodes;
        let (noun, set) = (if of_nodes { "node" } else { "element" }, self.name(line.set));
        match &*member {
            &Member::Range(from, to, step) => {
                let known = if of_nodes { &placement.nodes } else { &placement.elements };
                let start = known.partition_point(|&(number, _)| number < from);
                let within = known[start..].iter().take_while(|&&(number, _)| number <= to);
                let found = within.filter(|&&(number, _)| (number - from) % step == 0);
                let found: Vec<u32> = found.map(|&(_, index)| index).collect();
                let left_out = || {
                    let start = placement.left_out.partition_point(|&number| number < from);
                    !of_nodes && placement.left_out.get(start).is_some_and(|&number| number <= to)
                };
                if found.is_empty() && !left_out() {
                    return Err(format!("set {set} names {noun} {from}, which is not there"));
                }
                Ok(found)
            }
            Member::Set(name) => {
                let number = |part| self.numbers.get(&(part, name.to_uppercase()));
                // Sets of the part come first for its instances.
                let known = number(placement.part).or_else(|| number(0)).ok_or_else(|| {
                    let shown = excerpt::field(name.as_bytes());
                    format!("set {set} names the set '{shown}', which is not there")
                })?;
                let content = &contents[*known as usize];
                let members = if of_nodes { &content.nodes } else { &content.elements };
                if members.is_empty() {
                    let shown = excerpt::field(name.as_bytes());
                    return Err(format!(
                        "set {set} names the set '{shown}', which has no {noun} so far: define a set before the sets of it"
                    ));
                }
                Ok(members.get(&at).cloned().unwrap_or_default())
            }
        }
    }
}

impl Resolved {
    /// The set of each of `count` elements, if no element is in two of the sets outside of parts.
    pub(crate) fn bodies(&self, count: usize) -> Option<Vec<Option<u32>>> {
        let mut bodies = vec![None; count];
        for (set, ((part, _), content)) in (0..).zip(self.names.iter().zip(&self.contents)) {
            for &element in content.elements.get(&0).filter(|_| *part == 0).into_iter().flatten() {
                if bodies[element as usize].replace(set).is_some() {
                    return None;
                }
            }
        }
        Some(bodies)
    }

    /// The groups: one for each name and, if there are instances or several parts, one for each name in each.
    /// Notes the names that several sets have.
    pub(crate) fn groups(
        self,
        placements: &[Placement],
        instanced: bool,
        notes: &mut Vec<String>,
    ) -> Vec<DraftGroup> {
        let mut groups: Vec<DraftGroup> = Vec::new();
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        let mut merged: BTreeSet<usize> = BTreeSet::new();
        for ((part, name), content) in self.names.iter().zip(&self.contents) {
            let mut all = content.elements.keys().chain(content.nodes.keys()).chain(content.facets.keys());
            if all.next().is_none() {
                continue;
            }
            if known.contains_key(&name.to_uppercase()) {
                merged.insert(known[&name.to_uppercase()]);
            }
            let mut group = |name: String| {
                *known.entry(name.to_uppercase()).or_insert_with(|| {
                    let body = MeshBody { number: None, name: Some(name) };
                    groups.push(DraftGroup {
                        body,
                        elements: Vec::new(),
                        nodes: Vec::new(),
                        facets: Vec::new(),
                    });
                    groups.len() - 1
                })
            };
            let whole = group(name.clone());
            let mut into = vec![(whole, None)];
            if *part > 0 && (instanced || placements.len() > 2) {
                let of_part = (1..placements.len()).filter(|&at| placements[at].part == *part);
                for at in of_part {
                    into.push((
                        group(format!("{}.{name}", excerpt::line(placements[at].name.as_bytes()))),
                        Some(at),
                    ));
                }
            }
            for (index, only) in into {
                let is_meant = |at: &usize| only.is_none_or(|only| only == *at);
                let group = &mut groups[index];
                let members = |of: &BTreeMap<usize, Vec<u32>>| -> Vec<u32> {
                    of.iter()
                        .filter(|(at, _)| is_meant(at))
                        .flat_map(|(_, members)| members.clone())
                        .collect()
                };
                group.elements.extend(members(&content.elements));
                group.nodes.extend(members(&content.nodes));
                let facets = content.facets.iter().filter(|(at, _)| is_meant(at));
                group.facets.extend(facets.flat_map(|(_, facets)| facets.iter().copied()));
            }
        }
        let named = merged.into_iter().filter_map(|index| groups[index].body.name.as_deref());
        notes.extend(named.map(|name| {
            format!("several sets have the name {name}: the group {name} has all of them, INSTANCE.{name} those of an instance")
        }));
        groups
    }
}
