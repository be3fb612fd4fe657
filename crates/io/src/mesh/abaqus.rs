//! Abaqus input: nodes, elements, element sets, parts and instances.

use std::collections::BTreeMap;

use crate::excerpt;
use crate::mesh::build::{Draft, Lookup, Numbering, Raw, Shape, check_finite};
use crate::mesh::cursor::{Cursor, float, integer, name};
use crate::mesh::error::{Fault, MeshProblem, malformed, unsupported};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::place::Place;

/// Keywords that create or move nodes and elements in ways that are not supported.
const REFUSED: [&str; 11] = [
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "INCLUDE",
    "SYSTEM",
    "IMPORT",
    "PARAMETER",
    "SYMMETRIC MODEL GENERATION",
];

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut reader = AbaqusReader::default();
    let mut cursor = Cursor::new(bytes);
    let mut block = Block::Other;
    while let Some((place, line)) = cursor.line() {
        if line.is_empty() || line.starts_with(b"**") {
            continue;
        }
        if line.starts_with(b"*") {
            let mut text = line.to_vec();
            // A keyword line continues after a comma at its end.
            while text.ends_with(b",") {
                let Some((_, more)) = cursor.line() else { break };
                text.extend_from_slice(more);
            }
            block.check_complete()?;
            block = reader.keyword(&Keyword::new(&text), place)?;
        } else {
            reader.data(&mut block, line, place)?;
        }
    }
    block.check_complete()?;
    reader.finish(cursor.place())
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
    Nodes,
    Elements { shape: Shape, set: Option<u32>, pending: Option<Pending> },
    Set { set: u32, generate: bool },
    Instance { lines: u32 },
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
    nodes: [i64; 4],
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
    /// The number of an element or the name of a set, and the set that `*ELSET` adds it to.
    members: Vec<(Member, u32, Place)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Member {
    /// From, to, step.
    Range(u64, u64, u64),
    Set(String),
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
    /// Names of sets in capitals, because Abaqus ignores case, with their numbers.
    sets: BTreeMap<String, u32>,
    /// Names in their first spelling.
    set_names: Vec<String>,
}

impl AbaqusReader {
    fn part(&mut self) -> &mut AbaqusPart {
        if self.parts.is_empty() {
            self.parts.push(AbaqusPart::default());
        }
        &mut self.parts[self.open]
    }

    fn set(&mut self, spelled: &str) -> u32 {
        let next = self.set_names.len() as u32;
        let set = *self.sets.entry(spelled.to_uppercase()).or_insert(next);
        if set == next {
            self.set_names.push(name(spelled.as_bytes()));
        }
        set
    }

    fn keyword(&mut self, keyword: &Keyword, place: Place) -> Result<Block, Fault> {
        let fault = |problem| Err((place, problem));
        let shown = excerpt::field(keyword.name.as_bytes());
        let from_file =
            keyword.get("INPUT").is_some() && ["NODE", "ELEMENT", "ELSET"].contains(&&*keyword.name);
        if from_file || REFUSED.contains(&keyword.name.as_str()) {
            let what = if from_file { format!("*{shown}, INPUT=") } else { format!("*{shown}") };
            return fault(unsupported(what, "write nodes and elements in full, into one file"));
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
                Ok(Block::Nodes)
            }
            "ELEMENT" => {
                let kind = keyword.need("TYPE", place)?.to_uppercase();
                let Some(shape) = shape(&kind) else {
                    return fault(unsupported(
                        format!("elements of type {}", excerpt::field(kind.as_bytes())),
                        "trusses, beams, triangles, quadrilaterals and tetrahedra of corner nodes are read",
                    ));
                };
                let set = keyword.get("ELSET").map(str::to_owned).map(|spelled| self.set(&spelled));
                Ok(Block::Elements { shape, set, pending: None })
            }
            "ELSET" => {
                let spelled = keyword.need("ELSET", place)?.to_owned();
                // If there are parts, they are the bodies.
                if self.open != 0 || keyword.get("INSTANCE").is_some() {
                    return Ok(Block::Other);
                }
                Ok(Block::Set { set: self.set(&spelled), generate: keyword.get("GENERATE").is_some() })
            }
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
            _ => Ok(Block::Other),
        }
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
            Block::Nodes => {
                let [number, coordinates @ ..] = &fields[..] else {
                    return Err(bad("expected a node".into()));
                };
                let number = integer(number).map_err(bad)?;
                // The direction of a normal may follow the coordinates.
                if !matches!(coordinates.len(), 1..=6) {
                    return Err(bad(format!("node {number} has {} coordinates", coordinates.len())));
                }
                let mut point = [0.0; 3];
                for (value, field) in point.iter_mut().zip(coordinates).filter(|(_, field)| !field.is_empty())
                {
                    *value = float(field).map_err(|problem| bad(format!("node {number}: {problem}")))?;
                }
                check_finite(point, number).map_err(|problem| (place, problem))?;
                let part = self.part();
                part.numbers.push(number);
                part.points.push(point);
                part.places.push(place);
                Ok(())
            }
            Block::Elements { shape, set, pending } => {
                let (shape, set) = (*shape, *set);
                let numbers =
                    fields.iter().map(|field| integer(field)).collect::<Result<Vec<_>, _>>().map_err(bad)?;
                let (mut element, nodes) = match (pending.take(), &numbers[..]) {
                    (Some(element), nodes) => (element, nodes),
                    (None, [number, nodes @ ..]) => {
                        let number = u64::try_from(*number).map_err(|_| bad(format!("element {number}")))?;
                        (Pending { number, place, nodes: [0; 4], found: 0 }, nodes)
                    }
                    (None, []) => return Err(bad("expected an element".into())),
                };
                for &node in nodes {
                    if element.found == shape.nodes() {
                        let problem =
                            format!("element {} has more than {} nodes", element.number, shape.nodes());
                        return Err(bad(problem));
                    }
                    element.nodes[element.found] = node;
                    element.found += 1;
                }
                if element.found < shape.nodes() {
                    if !line.ends_with(b",") {
                        let (number, found) = (element.number, element.found);
                        return Err(bad(format!("element {number} ({}) has {found} nodes", shape.name())));
                    }
                    *pending = Some(element);
                    return Ok(());
                }
                let Pending { number, place, nodes, .. } = element;
                let part = self.part();
                part.elements.push(Raw { shape, place, number, body: 0, nodes });
                part.named.push(set);
                Ok(())
            }
            Block::Set { set, generate } => {
                let set = *set;
                let members = members(&fields, *generate).map_err(bad)?;
                self.part().members.extend(members.into_iter().map(|member| (member, set, place)));
                Ok(())
            }
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

    fn finish(mut self, end: Place) -> Result<Draft, Fault> {
        self.part();
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
        if !several {
            let bodies = self.body_of_elements(&parts[0])?;
            draft.bodies_from =
                if bodies.iter().all(Option::is_none) { BodiesFrom::File } else { BodiesFrom::ElementSets };
            draft.bodies = self.set_names.iter().map(|name| body(name)).collect();
            draft.bodies.push(MeshBody { number: None, name: None });
            let none = self.set_names.len() as u32;
            let bodies = bodies.into_iter().map(|set| set.unwrap_or(none));
            place_part(&parts[0], [0.0; 3], bodies, &mut draft)?;
            return Ok(draft);
        }
        // Elements outside of parts form a separate body without name.
        draft.bodies = vec![MeshBody { number: None, name: None }];
        place_part(&parts[0], [0.0; 3], std::iter::repeat(0), &mut draft)?;
        draft.bodies_from = if instanced { BodiesFrom::Instances } else { BodiesFrom::Parts };
        let alone = (1..parts.len()).map(|part| (parts[part].name.as_deref().unwrap_or(""), part, [0.0; 3]));
        let moved =
            self.instances.iter().map(|instance| (instance.name.as_str(), instance.part, instance.shift));
        let all: Vec<_> = if instanced { moved.collect() } else { alone.collect() };
        for (name, part, shift) in all {
            let number = draft.bodies.len() as u32;
            draft.bodies.push(body(name));
            place_part(&parts[part], shift, std::iter::repeat(number), &mut draft)?;
        }
        Ok(draft)
    }

    /// The set of each element: the one named by `*ELEMENT` or, if no `*ELEMENT` names one, that of `*ELSET`.
    fn body_of_elements(&self, part: &AbaqusPart) -> Result<Vec<Option<u32>>, Fault> {
        if part.named.iter().any(Option::is_some) {
            return Ok(part.named.clone());
        }
        let mut order: Vec<(u64, usize)> = part.elements.iter().map(|raw| raw.number).zip(0..).collect();
        order.sort_unstable();
        let mut sets: Vec<Option<u32>> = vec![None; part.elements.len()];
        for (member, set, place) in &part.members {
            let &Member::Range(from, to, step) = member else {
                let what = format!("a set of sets, in *ELSET {}", self.set_names[*set as usize]);
                return Err((*place, unsupported(what, "list the elements, or name the set at *ELEMENT")));
            };
            let start = order.partition_point(|&(number, _)| number < from);
            let mut found = 0;
            for &(number, at) in order[start..].iter().take_while(|&&(number, _)| number <= to) {
                if (number - from) % step != 0 {
                    continue;
                }
                found += 1;
                if let Some(other) = sets[at].replace(*set).filter(|other| other != set) {
                    let [first, second] =
                        [other, *set].map(|set| format!("set {}", self.set_names[set as usize]));
                    let what = format!("element {number}");
                    return Err((*place, MeshProblem::TwoBodies { what, first, second }));
                }
            }
            if found == 0 {
                let problem = format!(
                    "*ELSET {} names element {from}, which is not there",
                    self.set_names[*set as usize]
                );
                return Err((*place, malformed(problem)));
            }
        }
        Ok(sets)
    }
}

impl AbaqusPart {
    fn is(&self, name: &str) -> bool {
        self.name.as_ref().is_some_and(|own| own.eq_ignore_ascii_case(name))
    }

    fn shown(&self) -> String {
        name(self.name.as_deref().unwrap_or("").as_bytes())
    }
}

fn members(fields: &[&[u8]], generate: bool) -> Result<Vec<Member>, String> {
    let element = |field: &[u8]| {
        let number = integer(field)?;
        u64::try_from(number).map_err(|_| format!("element {number}"))
    };
    if generate {
        let numbers = fields.iter().map(|field| element(field)).collect::<Result<Vec<u64>, String>>()?;
        return match numbers[..] {
            [from, to] if from <= to => Ok(vec![Member::Range(from, to, 1)]),
            [from, to, step] if from <= to && step > 0 => Ok(vec![Member::Range(from, to, step)]),
            _ => Err("expected first, last and step of a set".into()),
        };
    }
    let member = |field: &&[u8]| match element(field) {
        Ok(number) => Ok(Member::Range(number, number, 1)),
        Err(_) if field.first().is_some_and(|byte| !byte.is_ascii_digit() && *byte != b'-') => {
            Ok(Member::Set(name(field)))
        }
        Err(problem) => Err(problem),
    };
    fields.iter().map(member).collect()
}

/// Adds a translated part, with the body of each of its elements.
fn place_part(
    part: &AbaqusPart,
    shift: [f64; 3],
    bodies: impl Iterator<Item = u32>,
    draft: &mut Draft,
) -> Result<(), Fault> {
    let base = draft.points.len() as i64;
    let lookup = Lookup::new(Numbering::Own(part.numbers.clone()), part.points.len(), &part.places)?;
    for ((point, place), number) in part.points.iter().zip(&part.places).zip(&part.numbers) {
        let moved = [0, 1, 2].map(|axis| point[axis] + shift[axis]);
        draft.push_point(moved, *place, *number)?;
    }
    let mut known: Vec<u64> = part.elements.iter().map(|raw| raw.number).collect();
    known.sort_unstable();
    if let Some(pair) = known.windows(2).find(|pair| pair[0] == pair[1]) {
        let twice = part.elements.iter().rfind(|raw| raw.number == pair[0]);
        let place = twice.map_or(Place::File, |raw| raw.place);
        return Err((place, malformed(format!("element {} is defined twice", pair[0]))));
    }
    for (raw, body) in part.elements.iter().zip(bodies) {
        let nodes = lookup.nodes(raw).map_err(|problem| (raw.place, problem))?;
        draft.elements.push(Raw { body, nodes: nodes.map(|node| i64::from(node) + base), ..*raw });
    }
    Ok(())
}

/// The shape of an element type: its name is a family, the number of nodes, and letters for the formulation.
fn shape(kind: &str) -> Option<Shape> {
    const FAMILIES: [(&str, Shape); 38] = [
        ("T2D2", Shape::Segment),
        ("T3D2", Shape::Segment),
        ("B21", Shape::Segment),
        ("B31", Shape::Segment),
        ("B23", Shape::Segment),
        ("B33", Shape::Segment),
        ("R2D2", Shape::Segment),
        ("RAX2", Shape::Segment),
        ("RB2D2", Shape::Segment),
        ("RB3D2", Shape::Segment),
        ("CPS3", Shape::Triangle),
        ("CPE3", Shape::Triangle),
        ("CPEG3", Shape::Triangle),
        ("CAX3", Shape::Triangle),
        ("DC2D3", Shape::Triangle),
        ("AC2D3", Shape::Triangle),
        ("S3", Shape::Triangle),
        ("STRI3", Shape::Triangle),
        ("R3D3", Shape::Triangle),
        ("M3D3", Shape::Triangle),
        ("SFM3D3", Shape::Triangle),
        ("DS3", Shape::Triangle),
        ("CPS4", Shape::Quadrilateral),
        ("CPE4", Shape::Quadrilateral),
        ("CPEG4", Shape::Quadrilateral),
        ("CAX4", Shape::Quadrilateral),
        ("DC2D4", Shape::Quadrilateral),
        ("AC2D4", Shape::Quadrilateral),
        ("S4", Shape::Quadrilateral),
        ("R3D4", Shape::Quadrilateral),
        ("M3D4", Shape::Quadrilateral),
        ("SFM3D4", Shape::Quadrilateral),
        ("DS4", Shape::Quadrilateral),
        ("C3D4", Shape::Tetrahedron),
        ("DC3D4", Shape::Tetrahedron),
        ("AC3D4", Shape::Tetrahedron),
        ("MASS", Shape::Point),
        ("ROTARYI", Shape::Point),
    ];
    FAMILIES.iter().find_map(|&(family, shape)| {
        let formulation = kind.strip_prefix(family)?;
        formulation.bytes().all(|byte| byte.is_ascii_alphabetic()).then_some(shape)
    })
}
