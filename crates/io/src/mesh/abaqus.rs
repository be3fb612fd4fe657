//! Abaqus input: nodes, elements, element sets, parts and instances.

use std::collections::{BTreeMap, BTreeSet};

use crate::excerpt;
use crate::foreign::BYTE_ORDER_MARK;
use crate::mesh::abaqus_include::{Includes, MeshLoad};
use crate::mesh::abaqus_sets::{Member, Placement, SetKind, Sets, member, members};
use crate::mesh::abaqus_types::{AbaqusType, element_type};
use crate::mesh::build::{Draft, Lookup, Numbering, Raw, check_finite, corners as corners_of};
use crate::mesh::cursor::{Cursor, float, integer, name};
use crate::mesh::error::{Fault, malformed, unsupported};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::place::Place;

/// Keywords that create or move nodes and elements in ways that are not supported.
const REFUSED: [&str; 9] = [
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SYSTEM",
    "IMPORT",
    "PARAMETER",
    "SYMMETRIC MODEL GENERATION",
];

/// Keywords without data for a mesh that need no mention.
const SILENT: [&str; 9] = [
    "HEADING",
    "PREPRINT",
    "ASSEMBLY",
    "END ASSEMBLY",
    "END STEP",
    "RESTART",
    "OUTPUT",
    "NODE OUTPUT",
    "ELEMENT OUTPUT",
];

/// Most nodes that `*NGEN` makes, because a short line may ask for any number.
const GENERATED: usize = 1 << 20;

/// Cohesive elements are without thickness up to this part of their length: files have few digits.
const THICK: f64 = 1e-5;

/// Reads a file. `load` reads the files that it includes.
pub(crate) fn read(bytes: &[u8], name: &str, load: &mut MeshLoad<'_>) -> Result<Draft, Fault> {
    let mut reader = AbaqusReader::default();
    let mut block = Block::Other;
    let end = reader.lines(bytes, &mut block, &mut Includes::new(name, load))?;
    block.check_complete()?;
    reader.finish(end)
}

/// A keyword line: `*NAME, KEY=VALUE, KEY`.
struct Keyword {
    /// The keyword in capitals; runs of blanks are reduced to one.
    name: String,
    /// Keys in capitals; values unchanged, without quotes.
    parameters: Vec<(String, String)>,
}

impl Keyword {
    fn new(line: &[u8]) -> Self {
        let text = String::from_utf8_lossy(&line[1..]);
        let mut parts = text.split(',');
        let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase();
        let name = plain(parts.next().unwrap_or(""));
        let parameter = |part: &str| {
            let (key, value) = part.split_once('=').unwrap_or((part, ""));
            (plain(key), value.trim().trim_matches('"').to_owned())
        };
        Self { name, parameters: parts.map(parameter).collect() }
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.parameters.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }

    /// A required parameter.
    fn need(&self, key: &str, place: Place) -> Result<&str, Fault> {
        let missing =
            || (place, malformed(format!("*{} without {key}=", excerpt::field(self.name.as_bytes()))));
        self.get(key).filter(|value| !value.is_empty()).ok_or_else(missing)
    }
}

/// The meaning of the following data lines.
enum Block {
    Other,
    Nodes {
        set: Option<u32>,
    },
    /// Nodes between others, whose indices are known by their numbers.
    Between {
        set: Option<u32>,
        known: BTreeMap<i64, usize>,
    },
    Elements {
        kind: AbaqusType,
        set: Option<u32>,
        pending: Option<Pending>,
    },
    Set {
        set: u32,
        kind: SetKind,
        generate: bool,
        instance: Option<String>,
    },
    Surface {
        set: u32,
        of_nodes: bool,
    },
    Instance {
        lines: u32,
    },
}

impl Block {
    fn check_complete(&self) -> Result<(), Fault> {
        match self {
            Self::Elements { pending: Some(pending), .. } => {
                Err((pending.place, malformed(format!("element {} ends too early", pending.number))))
            }
            _ => Ok(()),
        }
    }
}

/// An element whose line is incomplete so far.
#[derive(Debug, Clone, Copy)]
struct Pending {
    number: u64,
    place: Place,
    /// The corners; further nodes are counted.
    nodes: [i64; 8],
    found: usize,
}

/// Nodes and elements of a part, or those outside of parts.
#[derive(Default)]
struct AbaqusPart {
    name: Option<String>,
    place: Option<Place>,
    numbers: Vec<i64>,
    points: Vec<[f64; 3]>,
    places: Vec<Place>,
    elements: Vec<Raw>,
    /// For each element, the set named by `*ELEMENT`.
    named: Vec<Option<u32>>,
    /// Cohesive elements, in ascending order of their elements; at the end those without thickness.
    cohesive: Vec<Cohesive>,
    /// For each node, one before it at the other side of a cohesive element, or itself; empty if there are
    /// no cohesive elements.
    merged: Vec<u32>,
    /// Numbers of cohesive elements with a thickness, which are left out.
    left_out: Vec<u64>,
}

/// A cohesive element: the first side is an element, and each of its nodes has one on the other side.
struct Cohesive {
    /// Index of the element.
    element: usize,
    /// Node numbers of the other side, in the order of the first.
    opposite: Vec<i64>,
}

struct Instance {
    name: String,
    part: usize,
    shift: [f64; 3],
}

#[derive(Default)]
struct AbaqusReader {
    /// The first entry holds everything outside of parts.
    parts: Vec<AbaqusPart>,
    /// Index of the open part.
    open: usize,
    instances: Vec<Instance>,
    instance_open: bool,
    sets: Sets,
    /// Number of elements of second order, by their part.
    second_order: BTreeMap<usize, u64>,
    /// Number of nodes that were generated.
    generated: usize,
    /// Keywords that are not used.
    ignored: BTreeSet<String>,
    unused: Vec<String>,
}

impl AbaqusReader {
    fn part(&mut self) -> &mut AbaqusPart {
        if self.parts.is_empty() {
            self.parts.push(AbaqusPart::default());
        }
        &mut self.parts[self.open]
    }

    /// Reads the lines of a file, and of the files that it includes. Returns the place of its end.
    fn lines(
        &mut self,
        bytes: &[u8],
        block: &mut Block,
        includes: &mut Includes<'_, '_>,
    ) -> Result<Place, Fault> {
        let mut cursor = Cursor::new(bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes));
        while let Some((place, line)) = cursor.line() {
            if line.is_empty() || line.starts_with(b"**") {
                continue;
            }
            // A line of an included file is none of the mesh file.
            let kept = if includes.is_included() { Place::File } else { place };
            let at_line = |(_, problem): Fault| (place, problem);
            if !line.starts_with(b"*") {
                self.data(block, line, kept).map_err(|fault| includes.located(at_line(fault)))?;
                continue;
            }
            let mut text = line.to_vec();
            // A keyword line continues after a comma at its end.
            while text.ends_with(b",") {
                let Some((_, more)) = cursor.line() else { break };
                text.extend_from_slice(more);
            }
            let keyword = Keyword::new(&text);
            let is_include = keyword.name == "INCLUDE";
            if !is_include {
                block.check_complete().map_err(|fault| includes.located(fault))?;
                *block = self.keyword(&keyword, kept).map_err(|fault| includes.located(at_line(fault)))?;
            }
            let path = if is_include {
                Some(keyword.need("INPUT", place).map_err(|fault| includes.located(fault))?)
            } else {
                keyword.get("INPUT").filter(|_| !matches!(block, Block::Other))
            };
            if let Some(path) = path {
                let included = includes.open(&excerpt::field(keyword.name.as_bytes()), path);
                let included = included.map_err(|problem| includes.located((place, problem)))?;
                let read = self.lines(&included, block, includes);
                includes.close();
                read.map_err(|(_, problem)| includes.located((place, problem)))?;
            }
        }
        Ok(cursor.place())
    }

    /// The set of the open part with this name.
    fn set(&mut self, spelled: &str) -> u32 {
        self.sets.number(self.open, spelled)
    }

    fn keyword(&mut self, keyword: &Keyword, place: Place) -> Result<Block, Fault> {
        let fault = |problem| Err((place, problem));
        let shown = excerpt::field(keyword.name.as_bytes());
        if REFUSED.contains(&keyword.name.as_str()) {
            return fault(unsupported(format!("*{shown}"), "write nodes and elements in full"));
        }
        if self.instance_open && ["NODE", "ELEMENT"].contains(&&*keyword.name) {
            return fault(unsupported(format!("*{shown} in an instance"), "write it in its part"));
        }
        self.part();
        match keyword.name.as_str() {
            "NODE" => {
                if keyword.get("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
                    return fault(unsupported("*NODE, SYSTEM=", "write rectangular coordinates"));
                }
                let set = keyword.get("NSET").map(str::to_owned).map(|spelled| self.set(&spelled));
                Ok(Block::Nodes { set })
            }
            "NGEN" => {
                if keyword.get("LINE").is_some() || keyword.get("SYSTEM").is_some() {
                    return fault(unsupported("*NGEN, LINE= or SYSTEM=", "write the nodes in full"));
                }
                let set = keyword.get("NSET").map(str::to_owned).map(|spelled| self.set(&spelled));
                let known = self.part().numbers.iter().copied().zip(0..).collect();
                Ok(Block::Between { set, known })
            }
            "ELEMENT" => {
                let kind = keyword.need("TYPE", place)?.to_uppercase();
                let Some(kind) = element_type(&kind) else {
                    return fault(unsupported(
                        format!("elements of type {}", excerpt::field(kind.as_bytes())),
                        "trusses, beams, triangles, quadrilaterals, tetrahedra, pyramids, wedges and hexahedra of first and second order are read",
                    ));
                };
                let set = keyword.get("ELSET").map(str::to_owned).map(|spelled| self.set(&spelled));
                Ok(Block::Elements { kind, set, pending: None })
            }
            "ELSET" | "NSET" | "SURFACE" => self.set_keyword(keyword, place),
            "PART" => {
                let named = keyword.need("NAME", place)?.to_owned();
                if self.open != 0 || self.parts.iter().any(|part| part.is(&named)) {
                    return fault(malformed("a part in a part, or two of one name"));
                }
                self.open = self.parts.len();
                self.parts.push(AbaqusPart {
                    name: Some(named),
                    place: Some(place),
                    ..AbaqusPart::default()
                });
                Ok(Block::Other)
            }
            "END PART" => {
                self.open = 0;
                Ok(Block::Other)
            }
            "INSTANCE" => {
                let part = keyword.need("PART", place)?;
                let Some(part) = self.parts.iter().position(|known| known.is(part)) else {
                    let shown = excerpt::field(part.as_bytes());
                    return fault(malformed(format!(
                        "*INSTANCE names the part '{shown}', which is not there"
                    )));
                };
                let name = keyword.need("NAME", place)?.to_owned();
                self.instances.push(Instance { name, part, shift: [0.0; 3] });
                self.instance_open = true;
                Ok(Block::Instance { lines: 0 })
            }
            "END INSTANCE" => {
                self.instance_open = false;
                Ok(Block::Other)
            }
            other => {
                if !SILENT.contains(&other) {
                    self.ignored.insert(shown);
                }
                Ok(Block::Other)
            }
        }
    }

    /// A set or a surface.
    fn set_keyword(&mut self, keyword: &Keyword, place: Place) -> Result<Block, Fault> {
        if keyword.name == "SURFACE" {
            let spelled = keyword.need("NAME", place)?.to_owned();
            let kind = keyword.get("TYPE").unwrap_or("ELEMENT").to_uppercase();
            if !["ELEMENT", "NODE"].contains(&&*kind) || keyword.get("COMBINE").is_some() {
                let shown = name(spelled.as_bytes());
                self.unused.push(format!("the surface {shown} is not used: it is not of elements or nodes"));
                return Ok(Block::Other);
            }
            return Ok(Block::Surface { set: self.set(&spelled), of_nodes: kind == "NODE" });
        }
        let of_nodes = keyword.name == "NSET";
        let set = self.set(keyword.need(if of_nodes { "NSET" } else { "ELSET" }, place)?);
        let instance = keyword.get("INSTANCE").map(str::to_owned);
        if let Some(elements) = keyword.get("ELSET").filter(|_| of_nodes) {
            let member = member(elements.as_bytes()).map_err(|problem| (place, malformed(problem)))?;
            self.sets.add((set, SetKind::NodesOf), member, instance.as_deref(), place);
        }
        let kind = if of_nodes { SetKind::Nodes } else { SetKind::Elements };
        Ok(Block::Set { set, kind, generate: keyword.get("GENERATE").is_some(), instance })
    }

    fn data(&mut self, block: &mut Block, line: &[u8], place: Place) -> Result<(), Fault> {
        let bad = |problem: String| (place, malformed(problem));
        let mut fields: Vec<&[u8]> = line.split(|&byte| byte == b',').map(<[u8]>::trim_ascii).collect();
        // A comma at the end is not followed by a field.
        if fields.last().is_some_and(|field| field.is_empty()) {
            fields.pop();
        }
        match block {
            Block::Other => Ok(()),
            Block::Nodes { set } => self.node(*set, &fields, place),
            Block::Between { set, known } => self.between(*set, known, &fields).map_err(bad),
            Block::Elements { kind, set, pending } => {
                let (AbaqusType { shape, nodes: count, opposite }, set) = (*kind, *set);
                let numbers =
                    fields.iter().map(|field| integer(field)).collect::<Result<Vec<_>, _>>().map_err(bad)?;
                let (mut element, nodes) = match (pending.take(), &numbers[..]) {
                    (Some(element), nodes) => (element, nodes),
                    (None, [number, nodes @ ..]) => {
                        let number = u64::try_from(*number).map_err(|_| bad(format!("element {number}")))?;
                        (Pending { number, place, nodes: [0; 8], found: 0 }, nodes)
                    }
                    (None, []) => return Err(bad("expected an element".into())),
                };
                for &node in nodes {
                    if element.found == count {
                        return Err(bad(format!("element {} has more than {count} nodes", element.number)));
                    }
                    // Nodes on edges and inside follow the corners.
                    if let Some(corner) = element.nodes.get_mut(element.found) {
                        *corner = node;
                    }
                    element.found += 1;
                }
                if element.found < count {
                    if !line.ends_with(b",") {
                        let (number, found) = (element.number, element.found);
                        let name = if opposite.is_some() { "cohesive element" } else { shape.name() };
                        return Err(bad(format!("element {number} ({name}) has {found} nodes")));
                    }
                    *pending = Some(element);
                    return Ok(());
                }
                let Pending { number, place, nodes, .. } = element;
                if let Some(set) = set {
                    self.sets.add_next((set, SetKind::Elements), number, place);
                }
                let open = self.open;
                if count > shape.nodes() && opposite.is_none() {
                    *self.second_order.entry(open).or_default() += 1;
                }
                let part = self.part();
                if let Some(opposite) = opposite {
                    let opposite = opposite.iter().map(|&at| nodes[at]).collect();
                    part.cohesive.push(Cohesive { element: part.elements.len(), opposite });
                }
                part.elements.push(Raw { shape, place, number, body: 0, nodes });
                part.named.push(set);
                Ok(())
            }
            Block::Set { set, kind, generate, instance } => {
                for member in members(&fields, *generate).map_err(bad)? {
                    self.sets.add((*set, *kind), member, instance.as_deref(), place);
                }
                Ok(())
            }
            Block::Surface { set, of_nodes } => self.surface(*set, *of_nodes, &fields, place),
            Block::Instance { lines } => {
                *lines += 1;
                if *lines > 1 {
                    return Err((
                        place,
                        unsupported("a rotated instance", "instances may be moved, not rotated"),
                    ));
                }
                if fields.len() > 3 {
                    return Err(bad(format!(
                        "expected x, y and z of an instance, found {} fields",
                        fields.len()
                    )));
                }
                let Some(instance) = self.instances.last_mut() else { return Ok(()) };
                for (value, field) in
                    instance.shift.iter_mut().zip(fields).filter(|(_, field)| !field.is_empty())
                {
                    *value = float(field).map_err(bad)?;
                }
                Ok(())
            }
        }
    }

    /// A node, and the set that it is in.
    fn node(&mut self, set: Option<u32>, fields: &[&[u8]], place: Place) -> Result<(), Fault> {
        let bad = |problem: String| (place, malformed(problem));
        let [number, coordinates @ ..] = fields else {
            return Err(bad("expected a node".into()));
        };
        let number = integer(number).map_err(bad)?;
        // The direction of a normal may follow the coordinates.
        if !matches!(coordinates.len(), 1..=6) {
            return Err(bad(format!("node {number} has {} coordinates", coordinates.len())));
        }
        let mut point = [0.0; 3];
        for (value, field) in point.iter_mut().zip(coordinates).filter(|(_, field)| !field.is_empty()) {
            *value = float(field).map_err(|problem| bad(format!("node {number}: {problem}")))?;
        }
        check_finite(point, number).map_err(|problem| (place, problem))?;
        let part = self.part();
        part.numbers.push(number);
        part.points.push(point);
        part.places.push(place);
        if let (Some(set), Ok(number)) = (set, u64::try_from(number)) {
            self.sets.add_next((set, SetKind::Nodes), number, place);
        }
        Ok(())
    }

    fn finish(mut self, end: Place) -> Result<Draft, Fault> {
        self.part();
        for part in &mut self.parts {
            part.close_cohesive()?;
        }
        let parts = &self.parts;
        let (instanced, several) = (!self.instances.is_empty(), parts.len() > 1);
        if several && instanced {
            let alone =
                (1..parts.len()).find(|&part| self.instances.iter().all(|instance| instance.part != part));
            if let Some(part) = alone {
                let what = format!("the part {} without an instance", parts[part].shown());
                return Err((
                    parts[part].place.unwrap_or(end),
                    unsupported(what, "give it one or remove it"),
                ));
            }
        }
        let mut draft = Draft::new(Numbering::From(0));
        let body =
            |name: &str| MeshBody { number: None, name: Some(crate::mesh::cursor::name(name.as_bytes())) };
        // Elements outside of parts form a separate body without name.
        let alone = (1..parts.len()).map(|part| (parts[part].name.as_deref().unwrap_or(""), part, [0.0; 3]));
        let moved =
            self.instances.iter().map(|instance| (instance.name.as_str(), instance.part, instance.shift));
        let mut all = vec![("", 0, [0.0; 3])];
        if instanced && several {
            all.extend(moved);
        } else {
            all.extend(alone);
        }
        let mut placements = Vec::with_capacity(all.len());
        draft.bodies.clear();
        for (name, part, shift) in all {
            let number = draft.bodies.len() as u32;
            draft.bodies.push(if part == 0 { MeshBody { number: None, name: None } } else { body(name) });
            let mut placement = place_part(&parts[part], shift, number, &mut draft)?;
            (placement.name, placement.part) = (name.to_owned(), part);
            draft.cohesive_elements += placement.left_out.len() as u64;
            draft.cohesive_facets += parts[part].cohesive.len() as u64;
            draft.second_order += self.second_order.get(&part).copied().unwrap_or(0);
            placements.push(placement);
        }
        let names: Vec<MeshBody> = (0..self.sets.len() as u32).map(|set| body(self.sets.name(set))).collect();
        let of_nodes = |raw: &Raw| raw.nodes[..raw.shape.nodes()].iter().map(|&node| node as u32).collect();
        let resolved = self.sets.resolve(&placements, &draft.elements, of_nodes)?;
        if several {
            draft.bodies_from = if instanced { BodiesFrom::Instances } else { BodiesFrom::Parts };
        } else {
            let named = &parts[0].named;
            let is_named = named.iter().any(Option::is_some);
            let sets = if is_named { Some(named.clone()) } else { resolved.bodies(draft.elements.len()) };
            if let Some(sets) = sets.filter(|sets| sets.iter().any(Option::is_some)) {
                draft.bodies_from = BodiesFrom::ElementSets;
                let none = names.len() as u32;
                draft.bodies = names;
                draft.bodies.push(MeshBody { number: None, name: None });
                for (raw, set) in draft.elements.iter_mut().zip(sets) {
                    raw.body = set.unwrap_or(none);
                }
            }
        }
        draft.unused = self.unused;
        draft.groups = resolved.groups(&placements, instanced, &mut draft.unused);
        if !self.ignored.is_empty() {
            let keywords: Vec<String> = self.ignored.iter().map(|keyword| format!("*{keyword}")).collect();
            draft.unused.push(format!("not used: {}", keywords.join(", ")));
        }
        Ok(draft)
    }

    /// Adds nodes at equal distances between two, which have numbers in equal steps.
    fn between(
        &mut self,
        set: Option<u32>,
        known: &mut BTreeMap<i64, usize>,
        fields: &[&[u8]],
    ) -> Result<(), String> {
        let numbers = fields.iter().map(|field| integer(field)).collect::<Result<Vec<i64>, String>>()?;
        let (from, to, step) = match numbers[..] {
            [from, to] => (from, to, 1),
            [from, to, step] => (from, to, step),
            _ => return Err("expected the first and the last node of *NGEN, and the step".into()),
        };
        let steps = match to.checked_sub(from) {
            Some(span) if step > 0 && span > 0 && span % step == 0 => (span / step) as usize,
            _ => return Err(format!("*NGEN goes from node {from} to node {to} in steps of {step}")),
        };
        let index = |number: i64| {
            let found = known.get(&number).copied();
            found.ok_or_else(|| format!("*NGEN names node {number}, which is not defined so far"))
        };
        let [first, last] = [index(from)?, index(to)?];
        self.generated = self.generated.saturating_add(steps);
        if self.generated > GENERATED {
            return Err(format!("*NGEN makes more than {GENERATED} nodes"));
        }
        let part = self.part();
        let (place, ends) = (part.places[last], [part.points[first], part.points[last]]);
        for k in 1..steps {
            let share = k as f64 / steps as f64;
            let number = from + k as i64 * step;
            known.insert(number, part.points.len());
            part.numbers.push(number);
            part.points.push([0, 1, 2].map(|axis| ends[0][axis] * (1.0 - share) + ends[1][axis] * share));
            part.places.push(place);
        }
        if let (Some(set), Ok(from), Ok(to)) = (set, u64::try_from(from), u64::try_from(to)) {
            self.sets.add((set, SetKind::Nodes), Member::Range(from, to, step as u64), None, place);
        }
        Ok(())
    }

    /// A line of a surface: an element or a set, and a face; or a node or a set.
    fn surface(&mut self, set: u32, of_nodes: bool, fields: &[&[u8]], place: Place) -> Result<(), Fault> {
        let bad = |problem: String| (place, malformed(problem));
        let [first, rest @ ..] = fields else {
            return Err(bad("expected an element or a set of a surface".into()));
        };
        let face = rest.first().copied().unwrap_or(b"").to_ascii_uppercase();
        let number = face.strip_prefix(b"S").or_else(|| face.strip_prefix(b"E"));
        let number =
            number.and_then(|digits| integer(digits).ok()).and_then(|number| usize::try_from(number).ok());
        let kind = match number {
            _ if of_nodes => SetKind::Nodes,
            Some(number @ 1..) => SetKind::Facets(number - 1),
            // The two sides of elements that are facets.
            _ if face == b"SPOS" || face == b"SNEG" => SetKind::Elements,
            _ => {
                let name = self.sets.name(set);
                let shown = excerpt::field(&face);
                self.unused.push(if face.is_empty() {
                    format!("a line of the surface {name} is not used: it names no face, S1, S2, …")
                } else {
                    format!(
                        "a line of the surface {name} is not used: '{shown}' is none of S1, S2, …, SPOS, SNEG"
                    )
                });
                return Ok(());
            }
        };
        self.sets.add((set, kind), member(first).map_err(bad)?, None, place);
        Ok(())
    }
}

impl AbaqusPart {
    fn is(&self, name: &str) -> bool {
        self.name.as_ref().is_some_and(|own| own.eq_ignore_ascii_case(name))
    }

    /// Makes the two sides of cohesive elements without thickness one, and takes out those with a thickness.
    fn close_cohesive(&mut self) -> Result<(), Fault> {
        if self.cohesive.is_empty() {
            return Ok(());
        }
        let lookup = Lookup::new(Numbering::Own(self.numbers.clone()), self.points.len(), &self.places)?;
        self.merged = (0..self.points.len() as u32).collect();
        let mut is_thick = vec![false; self.elements.len()];
        for cohesive in std::mem::take(&mut self.cohesive) {
            let raw = &self.elements[cohesive.element];
            let sides = [&raw.nodes[..cohesive.opposite.len()], &cohesive.opposite];
            let nodes = |side: &[i64]| lookup.nodes(raw, side).map_err(|problem| (raw.place, problem));
            let [one, other] = [nodes(sides[0])?, nodes(sides[1])?];
            let apart = |a: u32, b: u32| {
                let [a, b] = [a, b].map(|node| self.points[node as usize]);
                (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
            };
            let length = one.iter().map(|&node| apart(node, one[0])).fold(0.0, f64::max);
            if one.iter().zip(&other).any(|(&a, &b)| apart(a, b) > THICK * length) {
                is_thick[cohesive.element] = true;
                continue;
            }
            for (&a, &b) in one.iter().zip(&other) {
                let [first_a, first_b] = [a, b].map(|node| first_of(&self.merged, node));
                let first = first_a.min(first_b);
                for node in [a, b, first_a, first_b] {
                    self.merged[node as usize] = first;
                }
            }
            self.cohesive.push(cohesive);
        }
        for node in 0..self.merged.len() as u32 {
            self.merged[node as usize] = first_of(&self.merged, node);
        }
        let thick = self.elements.iter().zip(&is_thick).filter(|(_, is_thick)| **is_thick);
        self.left_out = thick.map(|(raw, _)| raw.number).collect();
        let mut kept = is_thick.iter().map(|is_thick| !is_thick);
        self.elements.retain(|_| kept.next().unwrap_or(true));
        let mut kept = is_thick.iter().map(|is_thick| !is_thick);
        self.named.retain(|_| kept.next().unwrap_or(true));
        self.left_out.sort_unstable();
        Ok(())
    }

    /// The node that stands for a node: the first of those that are one.
    fn merged(&self, node: u32) -> u32 {
        self.merged.get(node as usize).copied().unwrap_or(node)
    }

    fn shown(&self) -> String {
        name(self.name.as_deref().unwrap_or("").as_bytes())
    }
}

/// Adds a translated part whose elements have the body `body`. Returns its numbers, without name and part.
fn place_part(part: &AbaqusPart, shift: [f64; 3], body: u32, draft: &mut Draft) -> Result<Placement, Fault> {
    let base = draft.points.len() as i64;
    let lookup = Lookup::new(Numbering::Own(part.numbers.clone()), part.points.len(), &part.places)?;
    for ((point, place), number) in part.points.iter().zip(&part.places).zip(&part.numbers) {
        let moved = [0, 1, 2].map(|axis| point[axis] + shift[axis]);
        draft.push_point(moved, *place, *number)?;
    }
    let first = draft.elements.len() as u32;
    let mut elements: Vec<(u64, u32)> = part.elements.iter().map(|raw| raw.number).zip(first..).collect();
    elements.sort_unstable();
    if let Some(pair) = elements.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let twice = part.elements.iter().rfind(|raw| raw.number == pair[0].0);
        let place = twice.map_or(Place::File, |raw| raw.place);
        return Err((place, malformed(format!("element {} is defined twice", pair[0].0))));
    }
    for raw in &part.elements {
        let corners = &raw.nodes[..raw.shape.nodes()];
        let nodes = lookup.nodes(raw, corners).map_err(|problem| (raw.place, problem))?;
        let nodes: Vec<i64> = nodes.into_iter().map(|node| i64::from(part.merged(node)) + base).collect();
        draft.elements.push(Raw { body, nodes: corners_of(&nodes), ..*raw });
    }
    let numbered =
        |(&number, index): (&i64, u32)| Some((u64::try_from(number).ok()?, part.merged(index) + base as u32));
    let mut nodes: Vec<(u64, u32)> = part.numbers.iter().zip(0..).filter_map(numbered).collect();
    nodes.sort_unstable();
    Ok(Placement { name: String::new(), part: 0, elements, nodes, left_out: part.left_out.clone() })
}

/// Follows nodes that stand for others to the first.
fn first_of(merged: &[u32], mut node: u32) -> u32 {
    while merged[node as usize] != node {
        node = merged[node as usize];
    }
    node
}
