//! Legacy VTK: unstructured grids, poly data and structured points, ASCII and binary.

use crate::column_values::ColumnValues;
use crate::excerpt;
use crate::mesh::build::{Draft, Numbering};
use crate::mesh::cursor::{Cursor, Endian, NumberKind, integer, name, words};
use crate::mesh::error::{Fault, malformed, unsupported};
use crate::mesh::vtk_data::{
    BodyData, CellList, HEXAHEDRON, POLY_LINE, POLY_VERTEX, POLYGON, QUADRILATERAL, STRIP, names_bodies,
    whole,
};
use crate::mesh::vtk_points::{PointCloud, is_time};
use crate::place::Place;

pub(crate) fn read(bytes: &[u8]) -> Result<Draft, Fault> {
    VtkReader::new(bytes, Want::Mesh)?.read_all()?.finish()
}

/// Whether there are cells other than vertices.
pub(crate) fn has_cells(bytes: &[u8]) -> Result<bool, Fault> {
    let reader = VtkReader::new(bytes, Want::Cells)?.read_all()?;
    Ok(reader.raster.is_some() || reader.sections.iter().any(|(list, _)| list.has_cells()))
}

/// The points with their data, regardless of cells.
pub(crate) fn points(bytes: &[u8]) -> Result<PointCloud, Fault> {
    Ok(VtkReader::new(bytes, Want::Points)?.read_all()?.cloud)
}

/// The parts of a file that are read; everything else is skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Want {
    /// Points, cells, and the data that distinguish bodies.
    Mesh,
    Cells,
    /// Points and their data.
    Points,
}

/// Whether the file is binary, and whether cells have offsets, as they do from version 5 on.
fn header(cursor: &mut Cursor<'_>) -> Result<(bool, bool), Fault> {
    const MAGIC: &[u8] = b"# vtk datafile version";
    let (place, first) = cursor.line().unwrap_or((Place::Line(1), b""));
    let lower = first.to_ascii_lowercase();
    let major = lower.strip_prefix(MAGIC).and_then(|rest| {
        let digits = rest.trim_ascii().split(|&byte| byte == b'.').next()?;
        integer(digits).ok()
    });
    let Some(major) = major else {
        return Err((place, malformed("expected '# vtk DataFile Version' and a number")));
    };
    cursor.line();
    match cursor.line() {
        Some((_, line)) if line.eq_ignore_ascii_case(b"ascii") => Ok((false, major >= 5)),
        Some((_, line)) if line.eq_ignore_ascii_case(b"binary") => Ok((true, major >= 5)),
        Some((place, line)) => {
            Err((place, malformed(format!("expected ASCII or BINARY, found '{}'", excerpt::line(line)))))
        }
        None => cursor.cut_off("ASCII or BINARY"),
    }
}

/// Type of the values in an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum VtkNumber {
    Scalar(NumberKind),
    /// Eight values per byte.
    Bit,
}

/// The things that data describe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Cells,
    Points,
}

struct VtkReader<'a> {
    want: Want,
    cloud: PointCloud,
    cursor: Cursor<'a>,
    binary: bool,
    offsets: bool,
    draft: Draft,
    /// Cells of an unstructured grid; or vertices, lines, polygons and strips, in the order of their numbers.
    sections: [(CellList, Option<Place>); 4],
    /// The items that the following data describe; `None` before the first section.
    of: Option<Of>,
    /// Number of cells or points of the following data.
    rows: usize,
    bodies: BodyData,
    /// The grid of structured points.
    raster: Option<Raster>,
}

/// A grid of structured points along the axes, whose cells are pixels or voxels.
struct Raster {
    /// Number of points along each axis.
    points: [i64; 3],
    origin: [f64; 3],
    spacing: [f64; 3],
}

impl Default for Raster {
    fn default() -> Self {
        Self { points: [1; 3], origin: [0.0; 3], spacing: [1.0; 3] }
    }
}

impl Raster {
    /// Adds the points to the draft. Returns the cells: quadrilaterals if one axis has a single point,
    /// otherwise hexahedra. None if two axes have a single point.
    fn add(&self, draft: &mut Draft) -> Result<CellList, Fault> {
        let [nx, ny, nz] = self.points;
        let index = |[i, j, k]: [i64; 3]| i + nx * (j + ny * k);
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let at = [i, j, k];
                    let point =
                        std::array::from_fn(|axis| self.origin[axis] + self.spacing[axis] * at[axis] as f64);
                    draft.push_point(point, Place::File, index(at))?;
                }
            }
        }
        let thick: Vec<usize> = (0..3).filter(|&axis| self.points[axis] > 1).collect();
        // Offsets of the corners from the first, around each side.
        let along = |axis: usize| [0, 1, 2].map(|other| i64::from(other == axis));
        let sum = |axes: &[usize]| {
            axes.iter().map(|&axis| along(axis)).fold([0; 3], |sum, step| [0, 1, 2].map(|k| sum[k] + step[k]))
        };
        let (corners, kind) = match thick[..] {
            [a, b] => (vec![sum(&[]), sum(&[a]), sum(&[a, b]), sum(&[b])], QUADRILATERAL),
            [a, b, c] => {
                let side = [sum(&[]), sum(&[a]), sum(&[a, b]), sum(&[b])];
                let other = side.map(|corner| [0, 1, 2].map(|k| corner[k] + along(c)[k]));
                (side.into_iter().chain(other).collect(), HEXAHEDRON)
            }
            _ => return Ok(CellList::default()),
        };
        let mut list = CellList::default();
        for k in 0..(nz - 1).max(1) {
            for j in 0..(ny - 1).max(1) {
                for i in 0..(nx - 1).max(1) {
                    let nodes =
                        corners.iter().map(|corner| index([i + corner[0], j + corner[1], k + corner[2]]));
                    list.connectivity.extend(nodes);
                    list.ends.push(list.connectivity.len() as i64);
                    list.types.push(kind);
                }
            }
        }
        Ok(list)
    }
}

impl<'a> VtkReader<'a> {
    fn new(bytes: &'a [u8], want: Want) -> Result<Self, Fault> {
        let mut cursor = Cursor::new(bytes);
        let (binary, offsets) = header(&mut cursor)?;
        Ok(Self {
            want,
            cloud: PointCloud::default(),
            cursor,
            binary,
            offsets,
            draft: Draft::new(Numbering::From(0)),
            sections: Default::default(),
            of: None,
            rows: 0,
            bodies: BodyData::default(),
            raster: None,
        })
    }

    fn read_all(mut self) -> Result<Self, Fault> {
        while self.cursor.peek().is_some() {
            self.keyword()?;
        }
        Ok(self)
    }

    fn keyword(&mut self) -> Result<(), Fault> {
        let keyword = self.cursor.word("a keyword")?.to_ascii_uppercase();
        match keyword.as_slice() {
            b"DATASET" => {
                let kind = self.cursor.word("the kind of data set")?;
                if kind.eq_ignore_ascii_case(b"STRUCTURED_POINTS") && self.want != Want::Points {
                    self.raster = Some(Raster::default());
                } else if !kind.eq_ignore_ascii_case(b"UNSTRUCTURED_GRID")
                    && !kind.eq_ignore_ascii_case(b"POLYDATA")
                {
                    let what = format!("the data set {}", excerpt::field(kind));
                    let help = "UNSTRUCTURED_GRID and POLYDATA are read, and STRUCTURED_POINTS as a mesh";
                    return self.cursor.fault(unsupported(what, help));
                }
                Ok(())
            }
            b"DIMENSIONS" | b"ORIGIN" | b"SPACING" | b"ASPECT_RATIO" if self.raster.is_some() => {
                self.raster_keyword(&keyword)
            }
            b"POINTS" => self.points(),
            b"CELLS" => self.cells(0, None),
            b"VERTICES" => self.cells(0, Some(POLY_VERTEX)),
            b"LINES" => self.cells(1, Some(POLY_LINE)),
            b"POLYGONS" => self.cells(2, Some(POLYGON)),
            b"TRIANGLE_STRIPS" => self.cells(3, Some(STRIP)),
            b"CELL_TYPES" => {
                let count = self.cursor.word_count("number of cell types")?;
                self.cursor.line();
                self.sections[0].0.types =
                    self.integers(count, VtkNumber::Scalar(NumberKind::I32), "type of a cell")?;
                Ok(())
            }
            b"CELL_DATA" | b"POINT_DATA" => {
                self.of = Some(if keyword == b"CELL_DATA" { Of::Cells } else { Of::Points });
                self.rows = self.cursor.word_count("number of data")?;
                Ok(())
            }
            b"METADATA" => {
                self.cursor.line();
                while self.cursor.line().is_some_and(|(_, line)| !line.is_empty()) {}
                Ok(())
            }
            other => self.data(other),
        }
    }

    /// A keyword of structured points.
    fn raster_keyword(&mut self, keyword: &[u8]) -> Result<(), Fault> {
        let mut raster = self.raster.take().unwrap_or_default();
        if keyword == b"DIMENSIONS" {
            let mut points = 1_i64;
            for count in &mut raster.points {
                *count = self.cursor.word_integer("number of points along an axis")?;
                points = if *count < 1 { i64::MAX } else { points.saturating_mul(*count) };
            }
            // A file has a value for each cell or point, of at least one bit.
            if points > 8 * self.cursor.rest().len() as i64 {
                let [x, y, z] = raster.points;
                return self.cursor.bad(format!(
                    "DIMENSIONS {x} {y} {z} do not fit the file, which has {} more bytes",
                    self.cursor.rest().len()
                ));
            }
        } else {
            let values = if keyword == b"ORIGIN" { &mut raster.origin } else { &mut raster.spacing };
            for value in values {
                *value = self.cursor.word_float("coordinate of structured points")?;
            }
        }
        self.raster = Some(raster);
        Ok(())
    }

    fn points(&mut self) -> Result<(), Fault> {
        if !self.draft.points.is_empty() {
            return self.cursor.bad("a second section POINTS");
        }
        let count = self.cursor.word_count("number of points")?;
        let kind = self.kind()?;
        if self.want == Want::Cells {
            return self.skip(3, count as i64, kind);
        }
        for node in 0..count as i64 {
            let place = self.cursor.place();
            let mut point = [0.0; 3];
            for value in &mut point {
                *value = self.real(kind, "coordinate of a point")?;
            }
            if self.want == Want::Points {
                self.cloud.points.push(point);
                continue;
            }
            let place = if self.binary { place } else { self.cursor.place() };
            self.draft.push_point(point, place, node)?;
        }
        Ok(())
    }

    fn cells(&mut self, section: usize, kind: Option<i64>) -> Result<(), Fault> {
        let place = self.cursor.place();
        if self.sections[section].1.replace(place).is_some() {
            return self.cursor.bad("a second section of the same cells");
        }
        let first = self.cursor.word_count("number of cells")?;
        let second = self.cursor.word_count("size of the cells")?;
        self.cursor.line();
        let list =
            if self.offsets { self.with_offsets(first, second)? } else { self.with_counts(first, second)? };
        let types = kind.map(|kind| vec![kind; list.ends.len()]);
        let old = std::mem::replace(&mut self.sections[section].0, list);
        // The types may come before the cells.
        self.sections[section].0.types = types.unwrap_or(old.types);
        Ok(())
    }

    /// Cells up to version 4: each is preceded by the number of its nodes.
    fn with_counts(&mut self, cells: usize, size: usize) -> Result<CellList, Fault> {
        let mut list = CellList::default();
        let int = VtkNumber::Scalar(NumberKind::I32);
        let mut left = size as i64;
        for _ in 0..cells {
            let nodes = self.integer(int, "number of nodes of a cell")?;
            left = left.saturating_sub(1).saturating_sub(nodes);
            if nodes < 0 || left < 0 {
                return self.cursor.bad(format!(
                    "a cell of {nodes} nodes, more than the {size} numbers of all cells allow"
                ));
            }
            for _ in 0..nodes {
                list.connectivity.push(self.integer(int, "node of a cell")?);
            }
            list.ends.push(list.connectivity.len() as i64);
        }
        if left > 0 {
            return self.cursor.bad(format!("the cells should take {size} numbers, {left} are left"));
        }
        Ok(list)
    }

    /// Cells from version 5 on: the start of each, followed by the end of the last, then all nodes.
    fn with_offsets(&mut self, offsets: usize, nodes: usize) -> Result<CellList, Fault> {
        self.expect("OFFSETS")?;
        let kind = self.kind()?;
        let ends = self.integers(offsets, kind, "offset of a cell")?;
        self.expect("CONNECTIVITY")?;
        let kind = self.kind()?;
        let connectivity = self.integers(nodes, kind, "node of a cell")?;
        match ends.split_first() {
            Some((0, ends)) => Ok(CellList { connectivity, ends: ends.to_vec(), types: Vec::new() }),
            None => Ok(CellList { connectivity, ends, types: Vec::new() }),
            Some((first, _)) => self.cursor.bad(format!("the first cell starts at {first}, not at 0")),
        }
    }

    fn expect(&mut self, keyword: &str) -> Result<(), Fault> {
        let found = self.cursor.word(keyword)?;
        if !found.eq_ignore_ascii_case(keyword.as_bytes()) {
            return self.cursor.bad(format!("expected {keyword}, found '{}'", excerpt::field(found)));
        }
        Ok(())
    }

    /// The arrays of cells and points. Arrays that define bodies are read; others are skipped.
    fn data(&mut self, keyword: &[u8]) -> Result<(), Fault> {
        match keyword {
            b"SCALARS" => {
                let (place, line) = self.cursor.line().unwrap_or((self.cursor.place(), b""));
                let fields: Vec<&[u8]> = words(line).collect();
                let (label, kind, components) = match fields[..] {
                    [label, kind] => (label, kind, 1),
                    [label, kind, count] => {
                        (label, kind, integer(count).map_err(|problem| (place, malformed(problem)))?)
                    }
                    _ => return Err((place, malformed("expected name, type and components of SCALARS"))),
                };
                let kind = self.kind_of(kind)?;
                let table = self.cursor.peek().is_some_and(|word| word.eq_ignore_ascii_case(b"LOOKUP_TABLE"));
                if table {
                    self.cursor.word("LOOKUP_TABLE")?;
                    self.cursor.line();
                }
                let rows = self.rows as i64;
                self.array(&name(label), kind, components, rows)
            }
            b"VECTORS" | b"NORMALS" => self.plain_array(3),
            b"TENSORS" => self.plain_array(9),
            b"TENSORS6" => self.plain_array(6),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => self.plain_array(1),
            b"TEXTURE_COORDINATES" => {
                self.cursor.word("name of an array")?;
                let components = self.cursor.word_integer("number of components")?;
                let kind = self.kind()?;
                self.skip(components, self.rows as i64, kind)
            }
            // Colours are floats in text files and bytes in binary files.
            b"COLOR_SCALARS" => {
                self.cursor.word("name of an array")?;
                let components = self.cursor.word_integer("number of components")?;
                self.cursor.line();
                self.skip(components, self.rows as i64, VtkNumber::Scalar(NumberKind::U8))
            }
            b"LOOKUP_TABLE" => {
                self.cursor.word("name of a table")?;
                let rows = self.cursor.word_integer("number of colours")?;
                self.cursor.line();
                self.skip(4, rows, VtkNumber::Scalar(NumberKind::U8))
            }
            b"FIELD" => {
                self.cursor.word("name of a field")?;
                let arrays = self.cursor.word_count("number of arrays")?;
                for _ in 0..arrays {
                    // Metadata may come between arrays.
                    while self.cursor.peek() == Some(b"METADATA") {
                        self.keyword()?;
                    }
                    let label = name(self.cursor.word("name of an array")?);
                    let components = self.cursor.word_integer("number of components")?;
                    let rows = self.cursor.word_integer("number of rows")?;
                    let kind = self.kind()?;
                    self.array(&label, kind, components, rows)?;
                }
                Ok(())
            }
            _ => {
                let what = format!("the keyword '{}'", excerpt::field(keyword));
                self.cursor.fault(unsupported(what, "points, cells and their data are read"))
            }
        }
    }

    fn plain_array(&mut self, components: i64) -> Result<(), Fault> {
        self.cursor.word("name of an array")?;
        let kind = self.kind()?;
        self.skip(components, self.rows as i64, kind)
    }

    fn array(&mut self, name: &str, kind: VtkNumber, components: i64, rows: i64) -> Result<(), Fault> {
        if self.want == Want::Points && components == 1 && self.keeps(name, rows) {
            return self.point_array(name, kind, rows);
        }
        let bodies = self.of == Some(Of::Cells) && names_bodies(name) && components == 1;
        if self.of == Some(Of::Cells) && !bodies {
            self.bodies.skip(name);
        }
        if self.want != Want::Mesh || !bodies {
            return self.skip(components, rows, kind);
        }
        let place = self.cursor.place();
        let rows = self.cursor.checked_count(rows, 1, "number of data")?;
        let values = match kind {
            VtkNumber::Scalar(scalar) if scalar.is_float() => {
                let mut values = Vec::new();
                for _ in 0..rows {
                    values.push(self.real(kind, "value of cell data")?);
                }
                whole(&values, name).map_err(|problem| (place, problem))?
            }
            _ => self.integers(rows, kind, "value of cell data")?,
        };
        self.bodies.push(name, place, &values);
        Ok(())
    }

    /// Whether the array is kept: data of points, or the time of the file.
    fn keeps(&self, name: &str, rows: i64) -> bool {
        match self.of {
            Some(Of::Points) => true,
            Some(Of::Cells) => false,
            None => rows == 1 && is_time(name),
        }
    }

    fn point_array(&mut self, name: &str, kind: VtkNumber, rows: i64) -> Result<(), Fault> {
        if kind == VtkNumber::Bit && self.binary {
            return self.skip(1, rows, kind);
        }
        let place = self.cursor.place();
        let rows = self.cursor.checked_count(rows, 1, "number of data")?;
        let is_real = matches!(kind, VtkNumber::Scalar(scalar) if scalar.is_float());
        let values = if is_real || self.of.is_none() {
            let values: Result<Vec<f64>, Fault> =
                (0..rows).map(|_| self.real(kind, "value of point data")).collect();
            ColumnValues::Real(values?)
        } else {
            ColumnValues::Whole(self.integers(rows, kind, "value of point data")?)
        };
        match (self.of, &values) {
            (None, ColumnValues::Real(values)) => {
                for &value in values {
                    self.cloud.note(name, value);
                }
            }
            _ if self.cloud.arrays.iter().any(|(known, _)| known == name) => {
                return Err((place, malformed(format!("point data {name} for the second time"))));
            }
            _ => self.cloud.push(name, values),
        }
        Ok(())
    }

    /// The type of the following values; reads to the end of the line.
    fn kind(&mut self) -> Result<VtkNumber, Fault> {
        let word = self.cursor.word("type of values")?;
        let kind = self.kind_of(word)?;
        self.cursor.line();
        Ok(kind)
    }

    fn kind_of(&self, word: &[u8]) -> Result<VtkNumber, Fault> {
        Ok(VtkNumber::Scalar(match word.to_ascii_lowercase().as_slice() {
            b"bit" => return Ok(VtkNumber::Bit),
            b"char" | b"signed_char" => NumberKind::I8,
            b"unsigned_char" => NumberKind::U8,
            b"short" => NumberKind::I16,
            b"unsigned_short" => NumberKind::U16,
            b"int" | b"vtkidtype" => NumberKind::I32,
            b"unsigned_int" => NumberKind::U32,
            b"long" | b"vtktypeint64" => NumberKind::I64,
            b"unsigned_long" | b"vtktypeuint64" => NumberKind::U64,
            b"float" => NumberKind::F32,
            b"double" => NumberKind::F64,
            _ => {
                let what = format!("values of type '{}'", excerpt::field(word));
                return self.cursor.fault(unsupported(what, "numbers are read"));
            }
        }))
    }

    fn real(&mut self, kind: VtkNumber, what: &str) -> Result<f64, Fault> {
        match kind {
            VtkNumber::Scalar(scalar) if self.binary => self.cursor.float(scalar, Endian::Big, what),
            VtkNumber::Bit if self.binary => self.cursor.bad(format!("{what} is a bit")),
            _ => self.cursor.word_float(what),
        }
    }

    fn integer(&mut self, kind: VtkNumber, what: &str) -> Result<i64, Fault> {
        match kind {
            VtkNumber::Scalar(scalar) if self.binary => self.cursor.integer(scalar, Endian::Big, what),
            VtkNumber::Bit if self.binary => self.cursor.bad(format!("{what} is a bit")),
            _ => self.cursor.word_integer(what),
        }
    }

    fn integers(&mut self, count: usize, kind: VtkNumber, what: &str) -> Result<Vec<i64>, Fault> {
        (0..count).map(|_| self.integer(kind, what)).collect()
    }

    fn skip(&mut self, components: i64, rows: i64, kind: VtkNumber) -> Result<(), Fault> {
        let Some(values) = components.checked_mul(rows).filter(|_| components >= 0) else {
            return self.cursor.bad(format!("an array of {components} times {rows} values"));
        };
        let count = match kind {
            _ if !self.binary => {
                for _ in 0..self.cursor.checked_count(values, 1, "values of an array")? {
                    self.cursor.word("value of an array")?;
                }
                return Ok(());
            }
            VtkNumber::Scalar(scalar) => {
                self.cursor.checked_count(values, scalar.size(), "values of an array")? * scalar.size()
            }
            VtkNumber::Bit => {
                self.cursor.checked_count(values / 8 + i64::from(values % 8 != 0), 1, "bits of an array")?
            }
        };
        self.cursor.take(count, "values of an array")?;
        Ok(())
    }

    fn finish(mut self) -> Result<Draft, Fault> {
        let mut number = 0;
        if let Some(raster) = &self.raster {
            self.sections[0].0 = raster.add(&mut self.draft)?;
        }
        for (list, place) in &self.sections {
            list.add(&mut self.draft, number, 0, place.unwrap_or(Place::File))?;
            number += list.ends.len() as u64;
        }
        self.bodies.apply(&mut self.draft, number)?;
        Ok(self.draft)
    }
}
