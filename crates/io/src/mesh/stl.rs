//! STL: solids of facets; equal corners are merged.

use crate::mesh::build::{Draft, Numbering, Raw, check_finite, corners};
use crate::mesh::cursor::{Cursor, Endian, NumberKind, float, name, words};
use crate::mesh::error::{Fault, malformed};
use crate::mesh::file::{BodiesFrom, MeshBody};
use crate::mesh::shape::Shape;
use crate::place::Place;

/// Number of bytes before the first facet of a binary file.
const HEADER: usize = 84;
/// Number of bytes of a facet: normal, three corners, attribute.
const FACET: usize = 50;

/// Whether the size matches the number of facets of a binary file; some binary files start with `solid` too.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    claimed(bytes).is_some_and(|facets| bytes.len() as u64 == HEADER as u64 + facets * FACET as u64)
}

fn claimed(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let text = bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    if is_binary(bytes) || !text { binary(bytes) } else { ascii(bytes) }
}

/// A corner before merging.
pub(crate) type Corner = [f64; 3];

/// A facet with its place, its solid, and its number, counted from 0.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    pub(crate) corners: [Corner; 3],
    pub(crate) place: Place,
    pub(crate) solid: u32,
    pub(crate) number: u64,
}

fn binary(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut cursor = Cursor::new(bytes);
    cursor.take(HEADER, "header of a binary STL file")?;
    let facets = claimed(bytes).unwrap_or(0);
    let expected = u128::from(facets) * FACET as u128;
    if expected != cursor.rest().len() as u128 {
        let found = cursor.rest().len();
        return cursor.bad(format!("{facets} facets take {expected} bytes, found {found}: the file is cut off, damaged or no STL file"));
    }
    let mut list = Vec::with_capacity(facets as usize);
    for number in 0..facets {
        let place = cursor.place();
        let facet = cursor.take(FACET, "a facet")?;
        let value = |at: usize| NumberKind::F32.float(&facet[4 * at..], Endian::Little);
        let corners = [3, 6, 9].map(|at| [value(at), value(at + 1), value(at + 2)]);
        list.push(Facet { corners, place, solid: 0, number });
    }
    weld(&list, vec![MeshBody { number: None, name: None }], BodiesFrom::File)
}

/// The statements that may come next in an ASCII file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Outside,
    Solid,
    Facet,
    Loop,
    LoopEnded,
}

impl State {
    fn expected(self) -> &'static str {
        match self {
            Self::Outside => "'solid'",
            Self::Solid => "'facet' or 'endsolid'",
            Self::Facet => "'outer loop'",
            Self::Loop => "'vertex' three times, then 'endloop'",
            Self::LoopEnded => "'endfacet'",
        }
    }
}

fn ascii(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut cursor = Cursor::new(bytes);
    let (mut state, mut solids, mut facets) = (State::Outside, Vec::new(), Vec::new());
    let (mut corners, mut started): (Vec<Corner>, Place) = (Vec::new(), cursor.place());
    while let Some((place, line)) = cursor.filled_line() {
        let mut fields = words(line);
        let keyword = fields.next().unwrap_or(b"").to_ascii_lowercase();
        state = match (state, keyword.as_slice()) {
            (State::Outside, b"solid") => {
                let named = name(&line[5..]);
                solids.push(MeshBody { number: None, name: (!named.is_empty()).then_some(named) });
                State::Solid
            }
            (State::Solid, b"facet") => {
                started = place;
                State::Facet
            }
            (State::Solid, b"endsolid") => State::Outside,
            (State::Facet, b"outer") => State::Loop,
            (State::Loop, b"vertex") if corners.len() < 3 => {
                corners.push(corner(fields).map_err(|problem| (place, malformed(problem)))?);
                State::Loop
            }
            (State::Loop, b"endloop") if corners.len() == 3 => State::LoopEnded,
            (State::LoopEnded, b"endfacet") => {
                let solid = solids.len() as u32 - 1;
                let corners = [corners.remove(0), corners.remove(0), corners.remove(0)];
                facets.push(Facet { corners, place: started, solid, number: facets.len() as u64 });
                State::Solid
            }
            _ => {
                let found = crate::excerpt::line(line);
                return Err((place, malformed(format!("expected {}, found '{found}'", state.expected()))));
            }
        };
    }
    if state != State::Outside {
        return cursor.cut_off(state.expected());
    }
    weld(&facets, solids, BodiesFrom::Solids)
}

fn corner<'a>(mut fields: impl Iterator<Item = &'a [u8]>) -> Result<Corner, String> {
    let mut corner = [0.0; 3];
    for (value, axis) in corner.iter_mut().zip("xyz".chars()) {
        let field = fields.next().ok_or_else(|| format!("the vertex has no {axis}"))?;
        *value = float(field).map_err(|problem| format!("{axis}: {problem}"))?;
    }
    match fields.next() {
        Some(_) => Err("the vertex has more than three coordinates".into()),
        None => Ok(corner),
    }
}

/// Merges corners of one solid with equal coordinates into one node; nodes are numbered in the order of
/// appearance.
pub(crate) fn weld(facets: &[Facet], solids: Vec<MeshBody>, bodies_from: BodiesFrom) -> Result<Draft, Fault> {
    let mut draft = Draft::new(Numbering::From(0));
    (draft.bodies, draft.bodies_from) = (solids, bodies_from);
    for facet in facets {
        for (corner, at) in facet.corners.iter().zip(0..) {
            check_finite(*corner, at).map_err(|problem| (facet.place, problem))?;
        }
    }
    let collapsed = |facet: &&Facet| {
        let [a, b, c] = facet.corners;
        a == b || b == c || c == a
    };
    draft.collapsed_facets = facets.iter().filter(collapsed).count() as u64;
    let facets: Vec<&Facet> = facets.iter().filter(|facet| !collapsed(facet)).collect();
    let corner = |at: usize| facets[at / 3].corners[at % 3];
    // Adding 0 turns -0 into 0, so that equal numbers have equal bits.
    let key = |at: usize| (facets[at / 3].solid, corner(at).map(|value| (value + 0.0).to_bits()));
    let mut sorted: Vec<((u32, [u64; 3]), usize)> = (0..3 * facets.len()).map(|at| (key(at), at)).collect();
    sorted.sort_unstable();
    // For each corner, the first one that is equal.
    let mut first: Vec<usize> = (0..sorted.len()).collect();
    for pair in sorted.windows(2) {
        if pair[0].0 == pair[1].0 {
            first[pair[1].1] = first[pair[0].1];
        }
    }
    let mut nodes = vec![0_i64; first.len()];
    for at in 0..first.len() {
        if first[at] == at {
            nodes[at] = draft.points.len() as i64;
            draft.points.push(corner(at));
        } else {
            nodes[at] = nodes[first[at]];
        }
    }
    for (facet, of) in facets.iter().zip(nodes.chunks_exact(3)) {
        let (place, number, body) = (facet.place, facet.number, facet.solid);
        draft.elements.push(Raw { shape: Shape::Triangle, place, number, body, nodes: corners(of) });
    }
    Ok(draft)
}
