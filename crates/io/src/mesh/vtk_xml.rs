//! XML VTK: `.vtu` and `.vtp`, with arrays as text, in base64 or appended, optionally compressed with zlib.

use std::borrow::Cow;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use memchr::memmem;
use roxmltree::{Document, Node};

use crate::column_values::ColumnValues;
use crate::excerpt;
use crate::mesh::build::{Draft, Numbering};
use crate::mesh::cursor::{Endian, NumberKind, float, integer, name, words};
use crate::mesh::error::{Fault, MeshProblem, malformed, unsupported};
use crate::mesh::vtk_data::{
    BodyData, CellList, POLY_LINE, POLY_VERTEX, POLYGON, STRIP, names_bodies, whole,
};
use crate::mesh::vtk_points::{PointCloud, is_time};
use crate::place::Place;

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    with_file(bytes, |file| {
        let mut draft = Draft::new(Numbering::From(0));
        let (mut cells, mut bodies) = (0, BodyData::default());
        for piece in file.pieces() {
            cells += file.piece(piece, cells, &mut draft, &mut bodies)?;
        }
        bodies.apply(&mut draft, cells)?;
        Ok(draft)
    })
}

/// Whether there are cells other than vertices.
pub(crate) fn has_cells(bytes: &[u8]) -> Result<bool, Fault> {
    with_file(bytes, |file| {
        for piece in file.pieces() {
            if file.piece_has_cells(piece)? {
                return Ok(true);
            }
        }
        Ok(false)
    })
}

/// The points with their data, regardless of cells.
pub(crate) fn points(bytes: &[u8]) -> Result<PointCloud, Fault> {
    with_file(bytes, |file| {
        let mut cloud = PointCloud::default();
        for piece in file.pieces() {
            // Reports the errors that also prevent the file from being a mesh.
            file.piece_has_cells(piece)?;
            file.cloud(piece, &mut cloud)?;
        }
        for array in children(child(file.data_set, "FieldData")).filter(|node| node.has_tag_name("DataArray"))
        {
            let label = array.attribute("Name").unwrap_or("");
            if is_time(label)
                && let Ok(values) = file.array(array)
            {
                match values {
                    ColumnValues::Real(values) => {
                        values.iter().take(1).for_each(|&value| cloud.note(label, value));
                    }
                    ColumnValues::Whole(values) => {
                        values.iter().take(1).for_each(|&value| cloud.note(label, value as f64));
                    }
                }
            }
        }
        Ok(cloud)
    })
}

/// Parses a file and passes it to `act`.
fn with_file<T>(bytes: &[u8], act: impl FnOnce(&File<'_, '_>) -> Result<T, Fault>) -> Result<T, Fault> {
    let (xml, appended) = split(bytes);
    let text = match str::from_utf8(&xml) {
        Ok(text) => text,
        Err(error) => return Err((Place::Byte(error.valid_up_to() as u64), malformed("not UTF-8"))),
    };
    let document = Document::parse(text).map_err(|error| {
        // The error text ends with its place, which is a separate field here.
        let (line, said) = (error.pos().row, error.to_string());
        let said = said.split_once(" at ").map_or(said.as_str(), |(problem, _)| problem);
        (Place::Line(u64::from(line)), malformed(format!("XML: {}", excerpt::line(said.as_bytes()))))
    })?;
    let file = File::new(&document, appended)?;
    act(&file)
}

/// The XML without appended data, which need not be text, and these data from the byte after `_`.
fn split(bytes: &[u8]) -> (Cow<'_, [u8]>, Option<&[u8]>) {
    let found = memmem::find(bytes, b"<AppendedData").and_then(|start| {
        let close = start + memchr::memchr(b'>', &bytes[start..])?;
        let data = close + 1 + memchr::memchr(b'_', &bytes[close + 1..])? + 1;
        Some((close, data))
    });
    match found {
        Some((close, data)) if bytes[close - 1] != b'/' => {
            ([&bytes[..close], b"/></VTKFile>"].concat().into(), Some(&bytes[data..]))
        }
        _ => (bytes.into(), None),
    }
}

/// Properties of all arrays of a file.
struct File<'a, 'input> {
    data_set: Node<'a, 'input>,
    endian: Endian,
    /// Type of the integers before binary data: the numbers of bytes or blocks.
    header: NumberKind,
    zlib: bool,
    appended: Option<(Coding, &'input [u8])>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Coding {
    Base64,
    Raw,
}

impl<'a, 'input> File<'a, 'input> {
    fn new(document: &'a Document<'input>, appended: Option<&'input [u8]>) -> Result<Self, Fault> {
        let root = document.root_element();
        let fault = |problem| Err((place(root), problem));
        if !root.has_tag_name("VTKFile") {
            return fault(malformed("expected <VTKFile>"));
        }
        let kind = root.attribute("type").unwrap_or("");
        if !["UnstructuredGrid", "PolyData"].contains(&kind) {
            let what = format!("a VTK file of type '{}'", excerpt::field(kind.as_bytes()));
            return fault(unsupported(what, "UnstructuredGrid and PolyData are read"));
        }
        let Some(data_set) = child(root, kind) else { return fault(malformed(format!("expected <{kind}>"))) };
        let endian = match root.attribute("byte_order") {
            Some("BigEndian") => Endian::Big,
            _ => Endian::Little,
        };
        let header = match root.attribute("header_type") {
            None | Some("UInt32") => NumberKind::U32,
            Some("UInt64") => NumberKind::U64,
            Some(other) => {
                return fault(malformed(format!("header_type '{}'", excerpt::field(other.as_bytes()))));
            }
        };
        let zlib = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let what = format!("the compressor {}", excerpt::field(other.as_bytes()));
                return fault(unsupported(what, "write with zlib or without compression"));
            }
        };
        let appended = match (child(root, "AppendedData"), appended) {
            (Some(node), Some(data)) => match node.attribute("encoding") {
                Some("raw") => Some((Coding::Raw, data)),
                Some("base64") | None => Some((Coding::Base64, data)),
                Some(other) => {
                    let what = format!("the encoding {}", excerpt::field(other.as_bytes()));
                    return Err((place(node), unsupported(what, "raw and base64 are read")));
                }
            },
            _ => None,
        };
        Ok(Self { data_set, endian, header, zlib, appended })
    }

    fn pieces(&self) -> impl Iterator<Item = Node<'a, 'input>> + use<'a, 'input> {
        self.data_set.children().filter(|node| node.has_tag_name("Piece"))
    }

    fn is_grid(&self) -> bool {
        self.data_set.has_tag_name("UnstructuredGrid")
    }

    /// Whether a piece has cells other than vertices.
    fn piece_has_cells(&self, piece: Node<'a, 'input>) -> Result<bool, Fault> {
        for counted in ["NumberOfLines", "NumberOfPolys", "NumberOfStrips"] {
            if count(piece, counted)? > 0 {
                return Ok(true);
            }
        }
        Ok(self.is_grid() && count(piece, "NumberOfCells")? > 0 && self.types(piece)?.has_cells())
    }

    /// The types of the cells of a grid, without their nodes.
    fn types(&self, piece: Node<'a, 'input>) -> Result<CellList, Fault> {
        let mut list = CellList::default();
        for array in children(child(piece, "Cells")).filter(|node| node.attribute("Name") == Some("types")) {
            if let ColumnValues::Whole(types) = self.array(array)? {
                list.types = types;
            }
        }
        Ok(list)
    }

    /// Adds the points of a piece and their data.
    fn cloud(&self, piece: Node<'a, 'input>, cloud: &mut PointCloud) -> Result<(), Fault> {
        let before = cloud.points.len();
        if let Some((_, coordinates)) = self.coordinates(piece)? {
            cloud.points.extend_from_slice(coordinates.as_chunks::<3>().0);
        }
        let (base, points) = (before, cloud.points.len() - before);
        for array in children(child(piece, "PointData")).filter(|node| node.has_tag_name("DataArray")) {
            // Some programs write 0 instead of 1.
            if !matches!(array.attribute("NumberOfComponents"), None | Some("1" | "0"))
                || scalar(array.attribute("type").unwrap_or("")).is_none()
            {
                continue;
            }
            let label = name(array.attribute("Name").unwrap_or("").as_bytes());
            let values = self.array(array)?;
            check(array, &format!("point data {label}"), points, values.len())?;
            let known =
                cloud.arrays.iter().find(|(known, _)| *known == label).map_or(0, |(_, known)| known.len());
            if known != base {
                return Err((
                    place(array),
                    malformed(format!("point data {label} is not in every piece once")),
                ));
            }
            cloud.push(&label, values);
        }
        Ok(())
    }

    /// Adds the points and cells of a piece to the draft; returns the number of its cells.
    fn piece(
        &self,
        piece: Node<'a, 'input>,
        first: u64,
        draft: &mut Draft,
        bodies: &mut BodyData,
    ) -> Result<u64, Fault> {
        let base = draft.points.len();
        self.points(piece, draft)?;
        let mut number = first;
        if self.data_set.has_tag_name("UnstructuredGrid") {
            let cells = count(piece, "NumberOfCells")?;
            let list = self.cell_list(piece, "Cells", None)?;
            check(piece, "cells", cells, list.ends.len())?;
            list.add(draft, number, base, place(piece))?;
            number += list.ends.len() as u64;
        } else {
            let sections = [
                ("Verts", "NumberOfVerts", POLY_VERTEX),
                ("Lines", "NumberOfLines", POLY_LINE),
                ("Polys", "NumberOfPolys", POLYGON),
                ("Strips", "NumberOfStrips", STRIP),
            ];
            for (section, counted, kind) in sections {
                let cells = count(piece, counted)?;
                let list = self.cell_list(piece, section, Some(kind))?;
                check(piece, section, cells, list.ends.len())?;
                list.add(draft, number, base, place(piece))?;
                number += list.ends.len() as u64;
            }
        }
        for array in children(child(piece, "CellData")).filter(|node| node.has_tag_name("DataArray")) {
            let label = array.attribute("Name").unwrap_or("");
            if !names_bodies(label)
                || !matches!(array.attribute("NumberOfComponents"), None | Some("1" | "0"))
            {
                bodies.skip(&name(label.as_bytes()));
                continue;
            }
            let values = match self.array(array)? {
                ColumnValues::Whole(values) => values,
                ColumnValues::Real(values) => {
                    whole(&values, label).map_err(|problem| (place(array), problem))?
                }
            };
            check(array, "values of cell data", (number - first) as usize, values.len())?;
            bodies.push(&name(label.as_bytes()), place(array), &values);
        }
        Ok(number - first)
    }

    fn points(&self, piece: Node<'a, 'input>, draft: &mut Draft) -> Result<(), Fault> {
        let Some((at, coordinates)) = self.coordinates(piece)? else { return Ok(()) };
        for (point, node) in coordinates.as_chunks::<3>().0.iter().zip(draft.points.len() as i64..) {
            draft.push_point(*point, at, node)?;
        }
        Ok(())
    }

    /// The coordinates of a piece and their place; `None` if there are none.
    fn coordinates(&self, piece: Node<'a, 'input>) -> Result<Option<(Place, Vec<f64>)>, Fault> {
        let expected = count(piece, "NumberOfPoints")?;
        let arrays = children(child(piece, "Points"));
        let Some(array) = arrays.into_iter().find(|node| node.has_tag_name("DataArray")) else {
            return check(piece, "points", expected, 0).map(|()| None);
        };
        if array.attribute("NumberOfComponents") != Some("3") {
            return Err((place(array), malformed("expected points of 3 components")));
        }
        let coordinates = match self.array(array)? {
            ColumnValues::Real(values) => values,
            ColumnValues::Whole(values) => values.into_iter().map(|value| value as f64).collect(),
        };
        check(array, "coordinates", expected.saturating_mul(3), coordinates.len())?;
        // Finding a place takes a count of the lines from the start.
        Ok(Some((place(array), coordinates)))
    }

    /// Connectivity, offsets, and the types of cells; `kind` if all have the same type.
    fn cell_list(
        &self,
        piece: Node<'a, 'input>,
        section: &str,
        kind: Option<i64>,
    ) -> Result<CellList, Fault> {
        let mut list = CellList::default();
        let Some(parent) = child(piece, section) else { return Ok(list) };
        for array in parent.children().filter(|node| node.has_tag_name("DataArray")) {
            let to = match array.attribute("Name") {
                Some("connectivity") => &mut list.connectivity,
                Some("offsets") => &mut list.ends,
                Some("types") => &mut list.types,
                _ => continue,
            };
            match self.array(array)? {
                ColumnValues::Whole(values) => *to = values,
                ColumnValues::Real(_) => return Err((place(array), malformed("cells of floats"))),
            }
        }
        if let Some(kind) = kind {
            list.types = vec![kind; list.ends.len()];
        }
        Ok(list)
    }

    fn array(&self, array: Node<'a, 'input>) -> Result<ColumnValues, Fault> {
        let fault = |problem: MeshProblem| (place(array), problem);
        let kind = array.attribute("type").unwrap_or("");
        let scalar = scalar(kind).ok_or_else(|| {
            fault(malformed(format!("type '{}' of an array", excerpt::field(kind.as_bytes()))))
        })?;
        // Elements with remarks may precede or follow the data.
        let texts = array.children().filter(|node| !node.is_element()).filter_map(|node| node.text());
        let texts: Vec<&str> = texts.filter(|text| !text.trim_ascii().is_empty()).collect();
        let text = match texts[..] {
            [] => b"",
            [text] => text.as_bytes(),
            _ => return Err(fault(malformed("data in several pieces"))),
        };
        let bytes = match array.attribute("format") {
            None | Some("ascii") => return ascii(text, scalar).map_err(|problem| fault(malformed(problem))),
            Some("binary") => self.decode(Coding::Base64, text),
            Some("appended") => {
                let offset = array.attribute("offset").unwrap_or("");
                let Some((coding, data)) = self.appended else {
                    return Err(fault(malformed("an appended array in a file without appended data")));
                };
                match offset.trim().parse().ok().and_then(|offset: usize| data.get(offset..)) {
                    Some(data) => self.decode(coding, data),
                    None => {
                        Err(format!("no appended data at offset '{}'", excerpt::field(offset.as_bytes())))
                    }
                }
            }
            Some(other) => Err(format!("format '{}' of an array", excerpt::field(other.as_bytes()))),
        };
        let bytes = bytes.map_err(|problem| fault(malformed(problem)))?;
        let values = bytes.chunks_exact(scalar.size());
        if !values.remainder().is_empty() {
            return Err(fault(malformed(format!("{} bytes are no whole number of values", bytes.len()))));
        }
        if scalar.is_float() {
            return Ok(ColumnValues::Real(values.map(|value| scalar.float(value, self.endian)).collect()));
        }
        let integers: Option<Vec<i64>> = values.map(|value| scalar.integer(value, self.endian)).collect();
        integers.map(ColumnValues::Whole).ok_or_else(|| fault(malformed("a number beyond 63 bits")))
    }

    /// The bytes of an array, decompressed and without headers.
    fn decode(&self, coding: Coding, data: &[u8]) -> Result<Vec<u8>, String> {
        // In base64 the data may be preceded by blanks; in raw data every byte counts.
        let data = if coding == Coding::Base64 { data.trim_ascii_start() } else { data };
        let word = self.header.size();
        let number = |bytes: &[u8], at: usize| -> Result<usize, String> {
            let bytes = bytes.get(at * word..(at + 1) * word).ok_or("the header of an array is cut off")?;
            let number =
                self.header.integer(bytes, self.endian).and_then(|number| usize::try_from(number).ok());
            number.ok_or_else(|| "the header of an array is damaged".into())
        };
        let too_large = || String::from("the header of an array is damaged");
        let first = number(&bytes_of(coding, data, word)?, 0)?;
        if !self.zlib {
            let all = word.checked_add(first).ok_or_else(too_large)?;
            return Ok(bytes_of(coding, data, all)?.split_off(word));
        }
        if first == 0 {
            return Ok(Vec::new());
        }
        let header = first.checked_add(3).and_then(|words| words.checked_mul(word)).ok_or_else(too_large)?;
        let sizes = bytes_of(coding, data, header)?;
        let (block, last) = (number(&sizes, 1)?, number(&sizes, 2)?);
        let packed = (0..first).map(|at| number(&sizes, 3 + at)).collect::<Result<Vec<usize>, String>>()?;
        let all = packed.iter().try_fold(header, |sum, &size| sum.checked_add(size)).ok_or_else(too_large)?;
        let bytes = bytes_of(coding, data, all)?;
        let (mut unpacked, mut from) = (Vec::new(), header);
        for (at, size) in packed.into_iter().enumerate() {
            let expected = if at + 1 == first && last != 0 { last } else { block };
            let part = &bytes[from..from + size];
            // Decompresses at most the size in the header, and allocates at most the size of the data.
            match miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(part, expected) {
                Ok(part) if part.len() == expected => unpacked.extend_from_slice(&part),
                Ok(part) => {
                    return Err(format!(
                        "block {at} of an array should unpack to {expected} bytes, not {}",
                        part.len()
                    ));
                }
                Err(error) => {
                    return Err(format!("block {at} of an array cannot be unpacked: {:?}", error.status));
                }
            }
            from += size;
        }
        Ok(unpacked)
    }
}

/// The first bytes of data, decoded. In base64 a header may be encoded separately, with its own padding.
fn bytes_of(coding: Coding, data: &[u8], count: usize) -> Result<Vec<u8>, String> {
    let cut_off =
        || format!("an array should take {}, and ends before", excerpt::count(count as u64, "byte"));
    if coding == Coding::Raw {
        return data.get(..count).map(<[u8]>::to_vec).ok_or_else(cut_off);
    }
    let (mut bytes, mut at) = (Vec::new(), 0_usize);
    while bytes.len() < count {
        // A run ends with padding, or when enough bytes are decoded.
        let wanted = (count - bytes.len()).div_ceil(3).saturating_mul(4);
        let window = &data[at..data.len().min(at.saturating_add(wanted))];
        let padding = memchr::memchr(b'=', window);
        let length = padding.map_or(window.len(), |padding| padding + 4 - padding % 4).min(window.len());
        if length == 0 || !length.is_multiple_of(4) {
            return Err(cut_off());
        }
        let decoded = STANDARD.decode(&window[..length]).map_err(|error| format!("base64: {error}"))?;
        bytes.extend_from_slice(&decoded);
        at += length;
    }
    bytes.truncate(count);
    Ok(bytes)
}

fn ascii(text: &[u8], scalar: NumberKind) -> Result<ColumnValues, String> {
    if scalar.is_float() {
        return words(text).map(float).collect::<Result<_, _>>().map(ColumnValues::Real);
    }
    words(text).map(integer).collect::<Result<_, _>>().map(ColumnValues::Whole)
}

fn scalar(name: &str) -> Option<NumberKind> {
    Some(match name {
        "Int8" => NumberKind::I8,
        "UInt8" => NumberKind::U8,
        "Int16" => NumberKind::I16,
        "UInt16" => NumberKind::U16,
        "Int32" => NumberKind::I32,
        "UInt32" => NumberKind::U32,
        "Int64" => NumberKind::I64,
        "UInt64" => NumberKind::U64,
        "Float32" => NumberKind::F32,
        "Float64" => NumberKind::F64,
        _ => return None,
    })
}

fn check(node: Node<'_, '_>, what: &str, expected: usize, found: usize) -> Result<(), Fault> {
    if expected == found {
        return Ok(());
    }
    Err((place(node), malformed(format!("{what}: expected {expected}, found {found}"))))
}

fn place(node: Node<'_, '_>) -> Place {
    Place::Line(u64::from(node.document().text_pos_at(node.range().start).row))
}

fn child<'a, 'input>(node: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    node.children().find(|child| child.has_tag_name(name))
}

fn children<'a, 'input>(node: Option<Node<'a, 'input>>) -> impl Iterator<Item = Node<'a, 'input>> {
    node.into_iter().flat_map(|node| node.children())
}

/// A count of a piece; 0 if it is not given.
fn count(piece: Node<'_, '_>, attribute: &str) -> Result<usize, Fault> {
    let Some(text) = piece.attribute(attribute) else { return Ok(0) };
    text.trim().parse().map_err(|_| {
        (place(piece), malformed(format!("{attribute} is '{}'", excerpt::field(text.as_bytes()))))
    })
}
