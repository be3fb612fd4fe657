//! Gmsh `.msh`, versions 2.2 and 4.1, ASCII and binary.

use std::collections::BTreeMap;

use memchr::memmem;

use crate::excerpt;
use crate::mesh::build::{Draft, DraftGroup, Numbering, Raw};
use crate::mesh::cursor::{Cursor, Endian, NumberKind, integer, name, words};
use crate::mesh::error::{Fault, MeshProblem, malformed, unsupported};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::mesh::shape::{Shape, refused};
use crate::place::Place;

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut reader = GmshReader::new(bytes);
    while reader.cursor.peek().is_some() {
        reader.section()?;
    }
    if reader.version.is_none() {
        return reader.cursor.cut_off("$MeshFormat");
    }
    if reader.nodes.is_none() {
        return reader.cursor.cut_off("$Nodes");
    }
    reader.finish()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// How numbers are stored.
#[derive(Debug, Clone, Copy)]
enum GmshEncoding {
    Ascii,
    Binary { endian: Endian, size: NumberKind },
}

/// Dimension and tag of an entity or a physical group.
type Tag = (i64, i64);

/// A type of elements: its corners come first.
#[derive(Debug, Clone, Copy)]
struct GmshKind {
    shape: Shape,
    dimension: i64,
    nodes: usize,
}

/// Elements of an entity that is in several physical groups.
#[derive(Debug)]
struct Further {
    entity: Tag,
    /// The groups after the first one.
    groups: Vec<i64>,
    elements: std::ops::Range<usize>,
    place: Place,
}

/// The possible bodies of an element; `physical` is 0 without a group.
#[derive(Debug, Clone, Copy)]
struct GmshPart {
    dimension: i64,
    physical: i64,
    entity: i64,
}

struct GmshReader<'a> {
    cursor: Cursor<'a>,
    version: Option<Version>,
    encoding: GmshEncoding,
    names: BTreeMap<Tag, String>,
    /// Physical groups of the entities, version 4.1.
    groups: BTreeMap<Tag, Vec<i64>>,
    /// The entities of the model that parts of them are of, version 4.1.
    parents: BTreeMap<Tag, i64>,
    further: Vec<Further>,
    draft: Draft,
    /// Numbers of the nodes; `None` until they have been read.
    nodes: Option<Vec<i64>>,
    parts: Vec<GmshPart>,
}

impl<'a> GmshReader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self {
            cursor: Cursor::new(bytes),
            version: None,
            encoding: GmshEncoding::Ascii,
            names: BTreeMap::new(),
            groups: BTreeMap::new(),
            parents: BTreeMap::new(),
            further: Vec::new(),
            draft: Draft::new(Numbering::Own(Vec::new())),
            nodes: None,
            parts: Vec::new(),
        }
    }

    fn section(&mut self) -> Result<(), Fault> {
        let section = self.cursor.word("a section")?;
        let end = [b"$End", section.get(1..).unwrap_or(b"")].concat();
        match (section, self.version) {
            (b"$MeshFormat", None) => self.format()?,
            (b"$NOD" | b"$ELM", _) => {
                return self.cursor.fault(unsupported("version 1 of the format", "save as 4.1 or 2.2"));
            }
            (b"$PhysicalNames", _) => self.physical_names()?,
            (b"$Nodes" | b"$Elements" | b"$Entities" | b"$PartitionedEntities", None) => {
                return self.cursor.bad("expected $MeshFormat before this section");
            }
            (b"$ParametricNodes", _) => {
                return self
                    .cursor
                    .fault(unsupported("$ParametricNodes", "save the mesh without parametric coordinates"));
            }
            (b"$Nodes" | b"$Elements" | b"$Entities" | b"$PartitionedEntities", Some(version)) => {
                self.cursor.line();
                match (section, version) {
                    (b"$Nodes", _) if self.nodes.is_some() => {
                        return self.cursor.bad("a second section $Nodes");
                    }
                    (b"$Nodes", Version::Two) => self.nodes_2()?,
                    (b"$Nodes", Version::Four) => self.nodes_4()?,
                    (b"$Elements", Version::Two) => self.elements_2()?,
                    (b"$Elements", Version::Four) => self.elements_4()?,
                    _ => self.entities(section == b"$PartitionedEntities")?,
                }
            }
            _ if section.starts_with(b"$") && !section.starts_with(b"$End") => {
                let Some(at) = memmem::find(self.cursor.rest(), &end) else {
                    return self.cursor.cut_off(excerpt::field(&end));
                };
                self.cursor.advance(at);
            }
            _ => return self.cursor.bad(format!("expected a section, found '{}'", excerpt::field(section))),
        }
        let expected = excerpt::field(&end);
        let found = self.cursor.word(&expected)?;
        if found != end {
            return self.cursor.bad(format!("expected {expected}, found '{}'", excerpt::field(found)));
        }
        Ok(())
    }

    fn format(&mut self) -> Result<(), Fault> {
        let version = self.cursor.word("the version")?;
        self.version = match version {
            b"2" | b"2.0" | b"2.1" | b"2.2" => Some(Version::Two),
            b"4.1" => Some(Version::Four),
            other => {
                let what = format!("version '{}' of the format", excerpt::field(other));
                return self.cursor.fault(unsupported(what, "save as 4.1 or 2.2"));
            }
        };
        let binary = self.cursor.word_integer("0 for ASCII or 1 for binary")?;
        let size = match self.cursor.word_integer("data size")? {
            4 if self.version == Some(Version::Four) => NumberKind::U32,
            8 => NumberKind::U64,
            other => return self.cursor.fault(unsupported(format!("data size {other}"), "8 is read")),
        };
        match binary {
            0 => {}
            1 => {
                self.cursor.line();
                let one = self.cursor.take(4, "the number 1 as it is stored")?;
                let endian = match one {
                    [1, 0, 0, 0] => Endian::Little,
                    [0, 0, 0, 1] => Endian::Big,
                    _ => return self.cursor.bad("expected the binary number 1"),
                };
                self.encoding = GmshEncoding::Binary { endian, size };
            }
            other => return self.cursor.bad(format!("expected 0 for ASCII or 1 for binary, found {other}")),
        }
        Ok(())
    }

    fn physical_names(&mut self) -> Result<(), Fault> {
        let count = self.cursor.word_count("number of physical names")?;
        self.cursor.line();
        for _ in 0..count {
            let Some((place, line)) = self.cursor.filled_line() else {
                return self.cursor.cut_off("a physical name");
            };
            let bad = || {
                (place, malformed(format!("expected dimension, tag and \"name\": {}", excerpt::line(line))))
            };
            let mut numbers = words(line).map_while(|word| integer(word).ok());
            let (dimension, tag) = (numbers.next().ok_or_else(bad)?, numbers.next().ok_or_else(bad)?);
            let named = match (memchr::memchr(b'"', line), memchr::memrchr(b'"', line)) {
                (Some(open), Some(close)) if close > open => &line[open + 1..close],
                (None, _) => {
                    // Some programs write names without quotes.
                    let third = words(line).nth(2).ok_or_else(bad)?;
                    &line[line.len() - rest_from(line, third)..]
                }
                _ => return Err(bad()),
            };
            self.names.insert((dimension, tag), name(named));
        }
        Ok(())
    }

    /// A 32-bit number.
    fn int(&mut self, what: &str) -> Result<i64, Fault> {
        match self.encoding {
            GmshEncoding::Ascii => self.cursor.word_integer(what),
            GmshEncoding::Binary { endian, .. } => self.cursor.integer(NumberKind::I32, endian, what),
        }
    }

    /// A number with the width of an address, version 4.1.
    fn wide(&mut self, what: &str) -> Result<i64, Fault> {
        match self.encoding {
            GmshEncoding::Ascii => self.cursor.word_integer(what),
            GmshEncoding::Binary { endian, size } => self.cursor.integer(size, endian, what),
        }
    }

    fn real(&mut self, what: &str) -> Result<f64, Fault> {
        match self.encoding {
            GmshEncoding::Ascii => self.cursor.word_float(what),
            GmshEncoding::Binary { endian, .. } => self.cursor.float(NumberKind::F64, endian, what),
        }
    }

    /// A number of items of at least `binary` bytes each, or of two characters each.
    fn count(&mut self, binary: usize, what: &str) -> Result<usize, Fault> {
        let count = self.wide(what)?;
        let size = if matches!(self.encoding, GmshEncoding::Ascii) { 2 } else { binary };
        self.cursor.checked_count(count, size, what)
    }

    fn point(&mut self, node: i64) -> Result<(), Fault> {
        let mut point = [0.0; 3];
        let mut place = self.cursor.place();
        for (value, what) in point.iter_mut().zip(["x of a node", "y of a node", "z of a node"]) {
            *value = self.real(what)?;
            if matches!(self.encoding, GmshEncoding::Ascii) {
                place = self.cursor.place();
            }
        }
        self.draft.places.push(place);
        self.draft.push_point(point, place, node)
    }

    fn nodes_2(&mut self) -> Result<(), Fault> {
        let count = self.cursor.word_count("number of nodes")?;
        self.cursor.line();
        let mut nodes = Vec::new();
        for _ in 0..count {
            let node = self.int("number of a node")?;
            self.point(node)?;
            nodes.push(node);
        }
        self.nodes = Some(nodes);
        Ok(())
    }

    fn nodes_4(&mut self) -> Result<(), Fault> {
        let blocks = self.count(20, "number of blocks of nodes")?;
        let total = self.count(24, "number of nodes")?;
        self.wide("lowest node")?;
        self.wide("highest node")?;
        let mut nodes = Vec::new();
        for _ in 0..blocks {
            let dimension = self.int("dimension of an entity")?;
            self.int("tag of an entity")?;
            let parametric = self.int("0 or 1 for parametric nodes")?;
            let parameters = match (parametric, dimension) {
                (0, _) => 0,
                (1, 0..=3) => dimension,
                _ => {
                    return self
                        .cursor
                        .bad("expected 0 or 1 for parametric nodes, and a dimension from 0 to 3");
                }
            };
            let count = self.count(24, "number of nodes of an entity")?;
            let first = nodes.len();
            for _ in 0..count {
                nodes.push(self.wide("number of a node")?);
            }
            for &node in &nodes[first..] {
                self.point(node)?;
                for _ in 0..parameters {
                    self.real("parameter of a node")?;
                }
            }
        }
        if nodes.len() != total {
            return self.cursor.bad(format!("expected {total} nodes, found {}", nodes.len()));
        }
        self.nodes = Some(nodes);
        Ok(())
    }

    /// Reads the physical groups of entities or, if the mesh is partitioned, of their parts.
    fn entities(&mut self, partitioned: bool) -> Result<(), Fault> {
        if self.version == Some(Version::Two) {
            return self.cursor.bad("version 2 of the format has no $Entities");
        }
        if !self.parts.is_empty() {
            return self.cursor.bad("$Entities behind $Elements, which need their physical groups");
        }
        if partitioned {
            self.wide("number of partitions")?;
            for _ in 0..self.count(8, "number of ghost entities")? {
                self.int("tag of a ghost entity")?;
                self.int("partition of a ghost entity")?;
            }
        }
        let mut counts = [0; 4];
        for (count, what) in counts.iter_mut().zip(["points", "curves", "surfaces", "volumes"]) {
            *count = self.count(1, &format!("number of {what}"))?;
        }
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let tag = self.int("tag of an entity")?;
                if partitioned {
                    let parent = (self.int("dimension of an entity")?, self.int("tag of an entity")?);
                    if parent.0 == dimension {
                        self.parents.insert((dimension, tag), parent.1);
                    }
                    for _ in 0..self.count(4, "number of partitions of an entity")? {
                        self.int("partition of an entity")?;
                    }
                }
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    self.real("bound of an entity")?;
                }
                let groups = self.count(4, "number of physical groups of an entity")?;
                for _ in 0..groups {
                    let group = self.int("physical group")?.saturating_abs();
                    let known = self.groups.entry((dimension, tag)).or_default();
                    if !known.contains(&group) {
                        known.push(group);
                    }
                }
                if dimension > 0 {
                    for _ in 0..self.count(4, "number of bounding entities")? {
                        self.int("bounding entity")?;
                    }
                }
            }
        }
        Ok(())
    }

    fn elements_2(&mut self) -> Result<(), Fault> {
        let total = self.cursor.word_count("number of elements")?;
        self.cursor.line();
        let mut read = 0;
        while read < total {
            let binary = !matches!(self.encoding, GmshEncoding::Ascii);
            // Binary files have one header per block, text files one per element.
            let mut number = if binary { 0 } else { self.int("number of an element")? };
            let kind = self.int("type of an element")?;
            let block = if binary { self.int("number of elements of a block")? } else { 1 };
            let tags = self.int("number of tags")?;
            if !(0..=1_000_000).contains(&tags) {
                return self.cursor.bad(format!("an element of {tags} tags"));
            }
            if block < 1 || block as usize > total - read {
                return self
                    .cursor
                    .bad(format!("a block of {block} elements, with {} to come", total - read));
            }
            for _ in 0..block {
                if binary {
                    number = self.int("number of an element")?;
                }
                let kind = self.kind(kind, number)?;
                let mut part = GmshPart { dimension: kind.dimension, physical: 0, entity: 0 };
                for place in 0..tags {
                    let tag = self.int("tag of an element")?;
                    match place {
                        0 => part.physical = tag.saturating_abs(),
                        1 => part.entity = tag,
                        _ => {}
                    }
                }
                self.element(number, kind, part, Self::int)?;
            }
            read += block as usize;
        }
        Ok(())
    }

    fn elements_4(&mut self) -> Result<(), Fault> {
        let blocks = self.count(20, "number of blocks of elements")?;
        let total = self.count(8, "number of elements")?;
        self.wide("lowest element")?;
        self.wide("highest element")?;
        let before = self.draft.elements.len();
        for _ in 0..blocks {
            let dimension = self.int("dimension of an entity")?;
            let entity = self.int("tag of an entity")?;
            let place = self.cursor.place();
            let kind = self.int("type of elements")?;
            let count = self.count(8, "number of elements of an entity")?;
            let groups = self.groups.get(&(dimension, entity)).cloned().unwrap_or_default();
            let physical = groups.first().copied().unwrap_or(0);
            let own = self.parents.get(&(dimension, entity)).copied().unwrap_or(entity);
            let first = self.draft.elements.len();
            for _ in 0..count {
                let number = self.wide("number of an element")?;
                let kind = self.kind(kind, number)?;
                self.element(number, kind, GmshPart { dimension, physical, entity: own }, Self::wide)?;
            }
            if groups.len() > 1 {
                let elements = first..self.draft.elements.len();
                let groups = groups[1..].to_vec();
                self.further.push(Further { entity: (dimension, entity), groups, elements, place });
            }
        }
        let read = self.draft.elements.len() - before;
        if read != total {
            return self.cursor.bad(format!("expected {total} elements, found {read}"));
        }
        Ok(())
    }

    fn element(
        &mut self,
        number: i64,
        kind: GmshKind,
        part: GmshPart,
        node: impl Fn(&mut Self, &str) -> Result<i64, Fault>,
    ) -> Result<(), Fault> {
        let Ok(number) = u64::try_from(number) else {
            return self.cursor.bad(format!("the element has the number {number}"));
        };
        let shape = kind.shape;
        let mut nodes = [0; 8];
        for at in 0..kind.nodes {
            let found = node(self, "node of an element")?;
            // Nodes on edges, on faces and inside follow the corners.
            if at < shape.nodes() {
                nodes[at] = found;
            }
        }
        self.draft.second_order += u64::from(kind.nodes > shape.nodes());
        self.parts.push(part);
        let place = self.cursor.place();
        self.draft.elements.push(Raw { shape, place, number, body: 0, nodes });
        Ok(())
    }

    fn kind(&self, kind: i64, element: i64) -> Result<GmshKind, Fault> {
        let (shape, nodes) = match kind {
            15 => (Shape::Point, 1),
            1 => (Shape::Segment, 2),
            2 => (Shape::Triangle, 3),
            3 => (Shape::Quadrilateral, 4),
            4 => (Shape::Tetrahedron, 4),
            5 => (Shape::Hexahedron, 8),
            6 => (Shape::Wedge, 6),
            7 => (Shape::Pyramid, 5),
            8 => (Shape::Segment, 3),
            9 => (Shape::Triangle, 6),
            10 => (Shape::Quadrilateral, 9),
            11 => (Shape::Tetrahedron, 10),
            12 => (Shape::Hexahedron, 27),
            13 => (Shape::Wedge, 18),
            14 => (Shape::Pyramid, 14),
            16 => (Shape::Quadrilateral, 8),
            17 => (Shape::Hexahedron, 20),
            18 => (Shape::Wedge, 15),
            19 => (Shape::Pyramid, 13),
            _ => return self.cursor.fault(refused(element.max(0) as u64, &format!("of Gmsh's type {kind}"))),
        };
        let dimension = match shape {
            Shape::Point => 0,
            Shape::Segment => 1,
            Shape::Triangle | Shape::Quadrilateral | Shape::Polygon => 2,
            Shape::Tetrahedron | Shape::Pyramid | Shape::Wedge | Shape::Hexahedron => 3,
        };
        Ok(GmshKind { shape, dimension, nodes })
    }

    fn group_name(&self, (dimension, tag): Tag) -> String {
        match self.names.get(&(dimension, tag)) {
            Some(name) => format!("physical group {tag} ({name})"),
            None => format!("physical group {tag}"),
        }
    }

    fn finish(mut self) -> Result<Draft, Fault> {
        let grouped = self.parts.iter().any(|part| part.physical != 0);
        let tagged = self.parts.iter().any(|part| part.entity != 0);
        let body = |part: &GmshPart| if grouped { part.physical } else { part.entity };
        if grouped {
            self.check_groups()?;
        }
        self.further_groups()?;
        let mut known: BTreeMap<Tag, u32> = BTreeMap::new();
        self.draft.bodies.clear();
        for (raw, part) in self.draft.elements.iter_mut().zip(&self.parts) {
            // Elements in no group form one body, whatever their dimension.
            let tag = if body(part) == 0 { (0, 0) } else { (part.dimension, body(part)) };
            raw.body = *known.entry(tag).or_insert_with(|| {
                let number = (tag != (0, 0)).then_some(tag.1);
                let name = if grouped { self.names.get(&tag).cloned() } else { None };
                self.draft.bodies.push(MeshBody { number, name });
                self.draft.bodies.len() as u32 - 1
            });
        }
        self.draft.bodies_from = match (grouped, tagged) {
            (true, _) => BodiesFrom::PhysicalGroups,
            (false, true) => BodiesFrom::Entities,
            (false, false) => BodiesFrom::File,
        };
        self.draft.numbering = Numbering::Own(self.nodes.unwrap_or_default());
        Ok(self.draft)
    }

    /// The largest dimension of an element: elements of this dimension are those of bodies.
    fn largest(&self) -> i64 {
        self.parts.iter().map(|part| part.dimension).max().unwrap_or(0)
    }

    /// Makes groups of the curves and surfaces that are in several; elements of bodies are in one.
    fn further_groups(&mut self) -> Result<(), Fault> {
        let largest = self.largest();
        let mut groups: BTreeMap<Tag, Vec<u32>> = BTreeMap::new();
        for further in &self.further {
            let (dimension, tag) = further.entity;
            if dimension == largest {
                let first = self.parts[further.elements.start..].first().map_or(0, |part| part.physical);
                let [first, second] =
                    [first, further.groups[0]].map(|group| self.group_name((dimension, group)));
                let what = format!("entity {tag} of dimension {dimension}");
                return Err((further.place, MeshProblem::TwoBodies { what, first, second }));
            }
            for &group in &further.groups {
                let elements = further.elements.clone().map(|element| element as u32);
                groups.entry((dimension, group)).or_default().extend(elements);
            }
        }
        for (tag, elements) in groups {
            let body = MeshBody { number: Some(tag.1), name: self.names.get(&tag).cloned() };
            self.draft.groups.push(DraftGroup { body, elements, nodes: Vec::new(), facets: Vec::new() });
        }
        Ok(())
    }

    /// Version 2.2 writes an element of two groups twice: with the same nodes and different numbers.
    fn check_groups(&self) -> Result<(), Fault> {
        if self.version != Some(Version::Two) {
            return Ok(());
        }
        let largest = self.largest();
        let key = |at: usize| {
            let (raw, part) = (&self.draft.elements[at], &self.parts[at]);
            (part.dimension, raw.nodes, part.entity)
        };
        let mut order: Vec<usize> = (0..self.parts.len()).collect();
        // A curve or a surface in two groups is in the mesh twice.
        order.retain(|&at| self.parts[at].dimension == largest);
        order.sort_unstable_by_key(|&at| (key(at), at));
        for pair in order.windows(2) {
            let (first, second) = (self.parts[pair[0]], self.parts[pair[1]]);
            if key(pair[0]) == key(pair[1]) && first.physical != second.physical {
                let [first, second] =
                    [first, second].map(|part| self.group_name((part.dimension, part.physical)));
                let raw = &self.draft.elements[pair[1]];
                let what = format!("element {} ({})", raw.number, raw.shape.name());
                return Err((raw.place, MeshProblem::TwoBodies { what, first, second }));
            }
        }
        Ok(())
    }
}

/// Number of bytes of a line from one of its words on.
fn rest_from(line: &[u8], word: &[u8]) -> usize {
    line.len() - (word.as_ptr() as usize - line.as_ptr() as usize)
}
