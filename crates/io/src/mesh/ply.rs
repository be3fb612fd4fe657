//! PLY: vertices, faces and edges.

use crate::excerpt;
use crate::mesh::build::{self, Draft, Numbering, Raw};
use crate::mesh::cursor::{Cursor, Endian, NumberKind, float, integer, words};
use crate::mesh::error::{Fault, malformed, unsupported};
use crate::mesh::shape::Shape;
use crate::place::Place;

/// How the values of an element are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlyEncoding {
    Ascii,
    Binary(Endian),
}

/// An element of the header: a table in the data.
#[derive(Debug)]
struct PlyElement {
    name: String,
    rows: i64,
    properties: Vec<Property>,
    place: Place,
}

#[derive(Debug)]
struct Property {
    name: String,
    /// Type of the length if the property is a list.
    length: Option<NumberKind>,
    scalar: NumberKind,
}

impl PlyElement {
    fn property(&self, names: &[&str]) -> Option<usize> {
        self.properties.iter().position(|property| names.contains(&property.name.as_str()))
    }
}

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    let mut cursor = Cursor::new(bytes);
    let (encoding, tables) = header(&mut cursor)?;
    let mut draft = Draft::new(Numbering::From(0));
    for table in &tables {
        match table.name.as_str() {
            "vertex" => vertices(&mut cursor, encoding, table, &mut draft)?,
            "face" | "edge" => elements(&mut cursor, encoding, table, &mut draft)?,
            "tristrips" if table.rows > 0 => {
                return Err((table.place, unsupported("triangle strips", "write faces instead")));
            }
            _ => each_row(&mut cursor, encoding, table, |_, _, _| Ok(()))?,
        }
    }
    let left = cursor.rest().trim_ascii().len();
    if left > 0 {
        return cursor.bad(format!("{left} bytes follow the last element of the header"));
    }
    Ok(draft)
}

fn header(cursor: &mut Cursor<'_>) -> Result<(PlyEncoding, Vec<PlyElement>), Fault> {
    let (mut encoding, mut tables): (_, Vec<PlyElement>) = (None, Vec::new());
    if cursor.line().is_none_or(|(_, line)| line != b"ply") {
        return Err((Place::Line(1), malformed("expected 'ply'")));
    }
    while let Some((place, line)) = cursor.line() {
        let bad = |problem: &str| Err((place, malformed(format!("{problem}: {}", excerpt::line(line)))));
        let fields: Vec<&[u8]> = words(line).collect();
        match fields[..] {
            [b"comment" | b"obj_info", ..] | [] => {}
            [b"format", kind, b"1.0"] => {
                encoding = Some(match kind {
                    b"ascii" => PlyEncoding::Ascii,
                    b"binary_little_endian" => PlyEncoding::Binary(Endian::Little),
                    b"binary_big_endian" => PlyEncoding::Binary(Endian::Big),
                    _ => return bad("expected ascii, binary_little_endian or binary_big_endian"),
                });
            }
            [b"element", name, rows] => {
                let rows = integer(rows).map_err(|problem| (place, malformed(problem)))?;
                tables.push(PlyElement { name: excerpt::field(name), rows, properties: Vec::new(), place });
            }
            [b"property", ref property @ ..] => {
                let Some(table) = tables.last_mut() else { return bad("a property before any element") };
                let (length, kind, name) = match *property {
                    [b"list", length, kind, name] => match scalar(length) {
                        Some(length) if !length.is_float() => (Some(length), kind, name),
                        _ => return bad("the length of a list is no integer"),
                    },
                    [kind, name] => (None, kind, name),
                    _ => return bad("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'"),
                };
                let Some(scalar) = scalar(kind) else { return bad("unknown type") };
                table.properties.push(Property { name: excerpt::field(name), length, scalar });
            }
            [b"end_header"] => {
                let Some(encoding) = encoding else { return bad("no line 'format' before") };
                return Ok((encoding, tables));
            }
            _ => return bad("expected format, element, property, comment or end_header"),
        }
    }
    cursor.cut_off("'end_header'")
}

fn scalar(name: &[u8]) -> Option<NumberKind> {
    Some(match name {
        b"char" | b"int8" => NumberKind::I8,
        b"uchar" | b"uint8" => NumberKind::U8,
        b"short" | b"int16" => NumberKind::I16,
        b"ushort" | b"uint16" => NumberKind::U16,
        b"int" | b"int32" => NumberKind::I32,
        b"uint" | b"uint32" => NumberKind::U32,
        b"int64" | b"long" => NumberKind::I64,
        b"uint64" | b"ulong" => NumberKind::U64,
        b"float" | b"float32" => NumberKind::F32,
        b"double" | b"float64" => NumberKind::F64,
        _ => return None,
    })
}

/// The values of one property in one row: one value, or those of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Value {
    Whole(i64),
    Real(f64),
}

impl Value {
    fn real(self) -> f64 {
        match self {
            Self::Whole(value) => value as f64,
            Self::Real(value) => value,
        }
    }
}

/// Calls `with` for each row with its number, its place, and the values of each property.
fn each_row(
    cursor: &mut Cursor<'_>,
    encoding: PlyEncoding,
    table: &PlyElement,
    mut with: impl FnMut(u64, Place, &[Vec<Value>]) -> Result<(), Fault>,
) -> Result<(), Fault> {
    if table.properties.is_empty() && table.rows != 0 {
        return Err((table.place, malformed(format!("element {} has rows and no property", table.name))));
    }
    let rows = cursor.checked_count(table.rows, 1, &format!("number of {}", table.name))?;
    let mut values: Vec<Vec<Value>> = vec![Vec::new(); table.properties.len()];
    for row in 0..rows as u64 {
        let label = format_args!("{} {row}", table.name).to_string();
        let place = match encoding {
            PlyEncoding::Ascii => ascii_row(cursor, table, &label, &mut values)?,
            PlyEncoding::Binary(endian) => {
                let place = cursor.place();
                for (property, values) in table.properties.iter().zip(&mut values) {
                    binary_values(cursor, endian, property, &label, values)?;
                }
                place
            }
        };
        with(row, place, &values)?;
    }
    Ok(())
}

fn ascii_row(
    cursor: &mut Cursor<'_>,
    table: &PlyElement,
    label: &str,
    values: &mut [Vec<Value>],
) -> Result<Place, Fault> {
    let Some((place, line)) = cursor.filled_line() else { return cursor.cut_off(label) };
    let mut fields = words(line);
    let bad = |problem: String| (place, malformed(format!("{label}: {problem}")));
    for (property, values) in table.properties.iter().zip(values) {
        let mut next = || fields.next().ok_or_else(|| bad(format!("no value of {}", property.name)));
        values.clear();
        let length = match property.length {
            None => 1,
            Some(_) => integer(next()?).map_err(bad)?,
        };
        for _ in 0..length {
            let field = next()?;
            let real = property.scalar.is_float();
            let value = if real { float(field).map(Value::Real) } else { integer(field).map(Value::Whole) };
            values.push(value.map_err(bad)?);
        }
    }
    match fields.next() {
        Some(_) => Err(bad("more values than properties".into())),
        None => Ok(place),
    }
}

fn binary_values(
    cursor: &mut Cursor<'_>,
    endian: Endian,
    property: &Property,
    label: &str,
    values: &mut Vec<Value>,
) -> Result<(), Fault> {
    values.clear();
    let length = match property.length {
        None => 1,
        Some(kind) => {
            let length = cursor.integer(kind, endian, label)?;
            cursor.checked_count(length, property.scalar.size(), label)?
        }
    };
    for _ in 0..length {
        values.push(if property.scalar.is_float() {
            Value::Real(cursor.float(property.scalar, endian, label)?)
        } else {
            Value::Whole(cursor.integer(property.scalar, endian, label)?)
        });
    }
    Ok(())
}

fn vertices(
    cursor: &mut Cursor<'_>,
    encoding: PlyEncoding,
    table: &PlyElement,
    draft: &mut Draft,
) -> Result<(), Fault> {
    let axes = ["x", "y", "z"].map(|name| table.property(&[name]));
    let ([Some(x), Some(y), z], true) = (axes, draft.points.is_empty()) else {
        return Err((table.place, malformed("expected one element vertex, with x and y")));
    };
    if [Some(x), Some(y), z].iter().flatten().any(|&axis| table.properties[axis].length.is_some()) {
        return Err((table.place, malformed("a coordinate is a list")));
    }
    each_row(cursor, encoding, table, |row, place, values| {
        let value = |axis: usize| values[axis].first().map_or(0.0, |value| value.real());
        let point = [value(x), value(y), z.map_or(0.0, value)];
        draft.push_point(point, place, row as i64)
    })
}

fn elements(
    cursor: &mut Cursor<'_>,
    encoding: PlyEncoding,
    table: &PlyElement,
    draft: &mut Draft,
) -> Result<(), Fault> {
    let bad = |problem: &str| Err((table.place, malformed(problem)));
    let columns = if table.name == "face" {
        let Some(list) = table.property(&["vertex_indices", "vertex_index"]) else {
            return bad("expected faces with a list vertex_indices");
        };
        vec![list]
    } else {
        let (Some(first), Some(second)) = (table.property(&["vertex1"]), table.property(&["vertex2"])) else {
            return bad("expected edges with vertex1 and vertex2");
        };
        vec![first, second]
    };
    let list = |&column: &usize| table.properties[column].length.is_some();
    let float = |&column: &usize| table.properties[column].scalar.is_float();
    if columns.iter().any(float) || columns.iter().any(|column| list(column) != (columns.len() == 1)) {
        return bad("expected vertices as whole numbers, of a face as a list");
    }
    each_row(cursor, encoding, table, |_, place, values| {
        let number = draft.elements.len() as u64;
        let corners = columns.iter().flat_map(|&column| &values[column]);
        let whole = |value: &Value| match value {
            Value::Whole(value) => Some(*value),
            Value::Real(_) => None,
        };
        let nodes: Vec<i64> = corners.filter_map(whole).collect();
        if columns.len() == 1 {
            return draft.push_polygon(nodes, (number, place, 0)).map_err(|problem| (place, problem));
        }
        draft.elements.push(Raw {
            shape: Shape::Segment,
            place,
            number,
            body: 0,
            nodes: build::corners(&nodes),
        });
        Ok(())
    })
}
