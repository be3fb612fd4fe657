//! Wavefront OBJ: vertices, faces, lines, objects, groups.

use std::collections::BTreeMap;

use crate::excerpt;
use crate::mesh::build::{Draft, Numbering, Raw, corners};
use crate::mesh::cursor::{Cursor, float, integer, name, words};
use crate::mesh::error::{Fault, MeshProblem, malformed, unsupported};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::mesh::shape::Shape;
use crate::place::Place;

/// Statements that do not affect elements.
const IGNORED: [&[u8]; 14] = [
    b"vt",
    b"vn",
    b"vp",
    b"s",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
];

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut reader = ObjReader {
        draft: Draft::new(Numbering::From(1)),
        objects: Names::default(),
        groups: Names::default(),
        parts: Vec::new(),
    };
    let mut cursor = Cursor::new(bytes);
    while let Some((place, line)) = statement(&mut cursor)? {
        reader.statement(&line, place).map_err(|problem| (place, problem))?;
    }
    Ok(reader.finish())
}

/// A statement with the place of its first line.
type Statement<'a> = (Place, std::borrow::Cow<'a, [u8]>);

/// The next line without its comment, joined with continuation lines after a backslash.
fn statement<'a>(cursor: &mut Cursor<'a>) -> Result<Option<Statement<'a>>, Fault> {
    let bare = |line: &'a [u8]| match memchr::memchr(b'#', line) {
        Some(at) => line[..at].trim_ascii(),
        None => line,
    };
    let Some((place, line)) = cursor.line() else { return Ok(None) };
    let Some(start) = bare(line).strip_suffix(b"\\") else { return Ok(Some((place, bare(line).into()))) };
    let mut joined = start.to_vec();
    loop {
        let Some((_, line)) = cursor.line() else { return cursor.cut_off("the rest of a line after '\\'") };
        joined.push(b' ');
        let Some(more) = bare(line).strip_suffix(b"\\") else {
            joined.extend_from_slice(bare(line));
            return Ok(Some((place, joined.into())));
        };
        joined.extend_from_slice(more);
    }
}

/// Names in the order of their first appearance; index 0 means everything before the first name.
#[derive(Debug, Default)]
struct Names {
    numbers: BTreeMap<String, u32>,
    current: u32,
}

impl Names {
    fn enter(&mut self, name: String) {
        let next = self.numbers.len() as u32 + 1;
        self.current = *self.numbers.entry(name).or_insert(next);
    }

    fn bodies(self) -> Vec<MeshBody> {
        let mut bodies = vec![MeshBody { number: None, name: None }; self.numbers.len() + 1];
        for (name, number) in self.numbers {
            bodies[number as usize].name = Some(name);
        }
        bodies
    }
}

struct ObjReader {
    draft: Draft,
    objects: Names,
    groups: Names,
    /// Object and group of each element.
    parts: Vec<(u32, u32)>,
}

impl ObjReader {
    fn statement(&mut self, line: &[u8], place: Place) -> Result<(), MeshProblem> {
        let mut fields = words(line);
        let Some(keyword) = fields.next() else { return Ok(()) };
        match keyword {
            b"v" => self.vertex(fields, place),
            b"f" => {
                let nodes = fields.map(|field| self.reference(field)).collect::<Result<Vec<_>, _>>()?;
                let number = self.next_number();
                self.parts.push((self.objects.current, self.groups.current));
                self.draft.push_polygon(nodes, (number, place, 0))
            }
            b"l" => {
                let nodes = fields.map(|field| self.reference(field)).collect::<Result<Vec<_>, _>>()?;
                if nodes.len() < 2 {
                    return Err(malformed(format!("a line needs two vertices, found {}", nodes.len())));
                }
                for pair in nodes.windows(2) {
                    self.push(Shape::Segment, pair, place);
                }
                Ok(())
            }
            b"p" => {
                for field in fields {
                    let node = self.reference(field)?;
                    self.push(Shape::Point, &[node], place);
                }
                Ok(())
            }
            b"o" => {
                self.objects.enter(name(&line[1..]));
                Ok(())
            }
            b"g" => {
                self.groups.enter(name(&line[1..]));
                Ok(())
            }
            keyword if IGNORED.contains(&keyword) => Ok(()),
            keyword => Err(unsupported(
                format!("the statement '{}'", excerpt::field(keyword)),
                "vertices, faces, lines, points, objects and groups are read",
            )),
        }
    }

    fn vertex<'a>(
        &mut self,
        fields: impl Iterator<Item = &'a [u8]>,
        place: Place,
    ) -> Result<(), MeshProblem> {
        let mut values = [0.0; 3];
        let mut found = 0;
        for field in fields {
            // A weight or a colour may follow x, y and z.
            let value = float(field).map_err(malformed)?;
            if let Some(to) = values.get_mut(found) {
                *to = value;
            }
            found += 1;
        }
        if !matches!(found, 3 | 4 | 6 | 7) {
            return Err(malformed(format!("expected x, y and z of a vertex, found {found} numbers")));
        }
        let node = self.draft.points.len() as i64 + 1;
        self.draft.push_point(values, place, node).map_err(|(_, problem)| problem)
    }

    /// The vertex of `7`, `7/1`, `7//3`, `7/1/3`, or of `-1`, which is the latest one.
    fn reference(&self, field: &[u8]) -> Result<i64, MeshProblem> {
        let vertex = field.split(|&byte| byte == b'/').next().unwrap_or(field);
        let number = integer(vertex).map_err(malformed)?;
        let vertices = self.draft.points.len() as i64;
        match number {
            1.. => Ok(number),
            0 => Err(malformed("vertices are counted from 1, found 0")),
            _ => match vertices.checked_add(number) {
                Some(before @ 0..) => Ok(before + 1),
                _ => Err(malformed(format!("vertex {number} of the {vertices} so far"))),
            },
        }
    }

    fn next_number(&self) -> u64 {
        self.draft.elements.len() as u64
    }

    fn push(&mut self, shape: Shape, nodes: &[i64], place: Place) {
        let number = self.next_number();
        self.parts.push((self.objects.current, self.groups.current));
        self.draft.elements.push(Raw { shape, place, number, body: 0, nodes: corners(nodes) });
    }

    fn finish(self) -> Draft {
        let mut draft = self.draft;
        let by_object = !self.objects.numbers.is_empty();
        for (raw, (object, group)) in draft.elements.iter_mut().zip(self.parts) {
            raw.body = if by_object { object } else { group };
        }
        draft.bodies_from = match (by_object, self.groups.numbers.is_empty()) {
            (true, _) => BodiesFrom::Objects,
            (false, false) => BodiesFrom::Groups,
            (false, true) => BodiesFrom::File,
        };
        draft.bodies = if by_object { self.objects.bodies() } else { self.groups.bodies() };
        draft
    }
}
