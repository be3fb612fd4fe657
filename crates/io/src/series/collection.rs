//! Collections of ParaView: `.pvd`, `.pvtp`, `.pvtu` and `.vtm`, files of points that list other files.

use std::collections::BTreeSet;
use std::fmt;

use roxmltree::{Document, Node};

use crate::column_values::ColumnValues;
use crate::error::ReadError;
use crate::excerpt;
use crate::foreign::BYTE_ORDER_MARK;
use crate::mesh::error::Fault;
use crate::mesh::vtk_points::PointCloud;
use crate::mesh::{vtk, vtk_xml};
use crate::place::Place;
use crate::series::rows::broken;

/// The flag of a ghost: a point that is in another piece too.
const DUPLICATE: i64 = 1;
/// Point data with the flags of ghosts.
const GHOSTS: &str = "vtkGhostType";

/// The files that a collection lists, as the program that has the collection finds them.
pub trait PieceFiles: fmt::Debug {
    /// Opens and unpacks a file. `chain`: the names of the files as they are listed: that in the collection,
    /// that in the file of this name, and so on; each is relative to the folder of the file that lists it.
    /// Without names, the file is the collection itself, of which only the place is needed.
    ///
    /// # Errors
    /// The reason why it cannot be opened.
    fn open(&self, chain: &[String]) -> Result<PieceFile, String>;
}

/// A file that a collection lists.
#[derive(Debug)]
pub struct PieceFile {
    /// The place of the file: equal if and only if the file is the same.
    pub place: String,
    /// The content of the file, unpacked.
    pub bytes: Vec<u8>,
}

/// The pieces of each frame of a collection.
#[derive(Debug)]
pub(super) struct Collection {
    pub(super) frames: Vec<Pieces>,
}

/// The pieces of a frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Pieces {
    /// The time that the collection gives.
    time: Option<f64>,
    /// The name of each piece, and its line in the file that lists it.
    files: Vec<(String, u64)>,
}

/// Whether the file is a collection.
pub(crate) fn is(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1 << 16)];
    let Some(start) = memchr::memmem::find(head, b"<VTKFile") else { return false };
    let end = memchr::memchr(b'>', &head[start..]).map_or(head.len(), |end| start + end);
    let tag = &head[start..end];
    let kinds: [&[u8]; 4] = [b"Collection", b"PPolyData", b"PUnstructuredGrid", b"vtkMultiBlockDataSet"];
    kinds.iter().any(|kind| {
        [b'"', b'\''].iter().any(|quote| {
            let value = [&[*quote][..], kind, &[*quote][..]].concat();
            memchr::memmem::find(tag, &value).is_some()
        })
    })
}

impl Collection {
    /// Reads the list of files.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, ReadError> {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        let text = match str::from_utf8(bytes) {
            Ok(text) => text,
            Err(error) => {
                let place = Place::Byte(error.valid_up_to() as u64);
                return Err(ReadError::Broken { place, problem: "not UTF-8".to_owned() });
            }
        };
        let document = match Document::parse(text) {
            Ok(document) => document,
            Err(error) => {
                let problem = excerpt::line(error.to_string().as_bytes());
                return broken(u64::from(error.pos().row), format!("XML: {problem}"));
            }
        };
        let root = document.root_element();
        let kind = root.attribute("type").unwrap_or("");
        let Some(list) = root.children().find(|node| node.has_tag_name(kind)) else {
            return broken(line(root), format!("expected <{}>", excerpt::field(kind.as_bytes())));
        };
        let (tag, attribute) = match kind {
            "PPolyData" | "PUnstructuredGrid" => ("Piece", "Source"),
            _ => ("DataSet", "file"),
        };
        let mut frames: Vec<Pieces> = Vec::new();
        for node in list.descendants().filter(|node| node.has_tag_name(tag)) {
            let file = match node.attribute(attribute) {
                Some(file) => file,
                // Empty blocks have no file.
                None if kind == "vtkMultiBlockDataSet" => continue,
                None => return broken(line(node), format!("<{tag}> has no attribute {attribute}")),
            };
            let time = match node.attribute("timestep").filter(|_| kind == "Collection") {
                None => None,
                Some(text) => match text.trim().parse::<f64>() {
                    Ok(time) if time.is_finite() => Some(time),
                    _ => {
                        let text = excerpt::field(text.as_bytes());
                        return broken(line(node), format!("timestep '{text}' is not a finite number"));
                    }
                },
            };
            let place = frames.iter().position(|frame| frame.time == time).unwrap_or_else(|| {
                frames.push(Pieces { time, files: Vec::new() });
                frames.len() - 1
            });
            frames[place].files.push((file.to_owned(), line(node)));
        }
        if frames.is_empty() {
            return broken(line(list), format!("the collection lists no file: there is no <{tag}>"));
        }
        Ok(Self { frames })
    }
}

impl Pieces {
    /// The points of all pieces.
    pub(super) fn points(&self, files: &dyn PieceFiles) -> Result<PointCloud, ReadError> {
        let place = match files.open(&[]) {
            Ok(itself) => itself.place,
            Err(problem) => return broken(1, problem),
        };
        let mut joined = Joined::default();
        self.join(&mut joined, &mut Vec::new(), &mut vec![place], files)?;
        let mut cloud = joined.cloud;
        cloud.time = self.time.or(cloud.time);
        Ok(cloud)
    }

    /// Adds the points of these pieces. `chain`: the names of the files that led here; `places`: their
    /// places.
    fn join(
        &self,
        joined: &mut Joined,
        chain: &mut Vec<String>,
        places: &mut Vec<String>,
        files: &dyn PieceFiles,
    ) -> Result<(), ReadError> {
        for (name, line) in &self.files {
            let shown = excerpt::line(name.as_bytes());
            let wrong = |problem: &str| ReadError::Broken {
                place: Place::Line(*line),
                problem: format!("piece {shown}: {problem}"),
            };
            chain.push(name.clone());
            let PieceFile { place, bytes } = files.open(chain).map_err(|problem| wrong(&problem))?;
            if places.contains(&place) {
                return Err(wrong("the file lists itself, or leads to itself"));
            }
            places.push(place);
            let added = if is(&bytes) {
                inner(&bytes).and_then(|pieces| pieces.join(joined, chain, places, files))
            } else {
                points(&bytes).and_then(|cloud| joined.add(cloud, &shown))
            };
            added.map_err(|error| match error.line() {
                Some(inside) => wrong(&format!("line {inside}: {error}")),
                None => wrong(&error.to_string()),
            })?;
            places.pop();
            chain.pop();
        }
        Ok(())
    }
}

/// The pieces of a collection inside another one.
fn inner(bytes: &[u8]) -> Result<Pieces, ReadError> {
    let frames = Collection::read(bytes)?.frames;
    match <[Pieces; 1]>::try_from(frames) {
        Ok([pieces]) => Ok(pieces),
        Err(frames) => {
            let problem = format!("it has {} time steps, but a piece has one", frames.len());
            Err(ReadError::Broken { place: Place::File, problem })
        }
    }
}

/// The points of a piece.
fn points(bytes: &[u8]) -> Result<PointCloud, ReadError> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let fault = |(place, problem): Fault| ReadError::Broken { place, problem: problem.to_string() };
    let of_file = |problem: &str| ReadError::Broken { place: Place::File, problem: problem.to_owned() };
    let (cells, cloud) = if bytes.starts_with(b"# vtk DataFile") {
        (vtk::has_cells(bytes).map_err(fault)?, vtk::points(bytes).map_err(fault)?)
    } else if memchr::memmem::find(&bytes[..bytes.len().min(1 << 16)], b"<VTKFile").is_some() {
        (vtk_xml::has_cells(bytes).map_err(fault)?, vtk_xml::points(bytes).map_err(fault)?)
    } else {
        return Err(of_file("this is no VTK file"));
    };
    if cells {
        return Err(of_file(
            "it has cells, and collections are read as points only: give the meshes themselves, as several files",
        ));
    }
    without_ghosts(cloud)
}

/// Leaves out the points that are in another piece too.
fn without_ghosts(mut cloud: PointCloud) -> Result<PointCloud, ReadError> {
    let Some(place) = cloud.arrays.iter().position(|(name, _)| name == GHOSTS) else { return Ok(cloud) };
    let (_, flags) = cloud.arrays.remove(place);
    let is_own: Vec<bool> = (0..flags.len())
        .map(|point| flags.whole(point).map(|flags| flags & DUPLICATE == 0))
        .collect::<Option<_>>()
        .ok_or_else(|| ReadError::Broken {
            place: Place::File,
            problem: format!("point data {GHOSTS} are no whole numbers"),
        })?;
    let kept = |point: usize| is_own.get(point).copied().unwrap_or(true);
    for (_, values) in &mut cloud.arrays {
        *values = match &*values {
            ColumnValues::Whole(all) => ColumnValues::Whole(own(all, kept)),
            ColumnValues::Real(all) => ColumnValues::Real(own(all, kept)),
        };
    }
    cloud.points = own(&cloud.points, kept);
    Ok(cloud)
}

fn own<T: Copy>(all: &[T], kept: impl Fn(usize) -> bool) -> Vec<T> {
    all.iter().enumerate().filter(|(point, _)| kept(*point)).map(|(_, value)| *value).collect()
}

/// Points of several pieces.
#[derive(Default)]
struct Joined {
    cloud: PointCloud,
    /// Name of the first piece with points.
    first: Option<String>,
}

impl Joined {
    /// Adds a piece, whose data must have the names of those before. Pieces without points have no data.
    fn add(&mut self, piece: PointCloud, name: &str) -> Result<(), ReadError> {
        let PointCloud { points, arrays, step, time } = piece;
        self.cloud.step = self.cloud.step.or(step);
        self.cloud.time = self.cloud.time.or(time);
        if points.is_empty() {
            return Ok(());
        }
        if let Some(first) = &self.first {
            let names = |arrays: &[(String, ColumnValues)]| -> BTreeSet<String> {
                arrays.iter().map(|(name, _)| name.clone()).collect()
            };
            let (before, now) = (names(&self.cloud.arrays), names(&arrays));
            if let Some(array) = before.symmetric_difference(&now).next() {
                let [with, without] = if now.contains(array) { [name, first] } else { [first, name] };
                let array = excerpt::field(array.as_bytes());
                let problem = format!("{with} has the point data {array}, {without} has not");
                return Err(ReadError::Broken { place: Place::File, problem });
            }
        }
        self.first.get_or_insert_with(|| name.to_owned());
        self.cloud.points.extend(points);
        for (label, values) in arrays {
            self.cloud.push(&label, values);
        }
        Ok(())
    }
}

/// Line of a node, counted from 1.
fn line(node: Node<'_, '_>) -> u64 {
    u64::from(node.document().text_pos_at(node.range().start).row)
}
