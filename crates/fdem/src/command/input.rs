//! Input of the commands that search a packing: opens and reads files, and words the library's errors for the
//! command line.

use std::cell::RefCell;
use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::atomic::Ordering;

use fdem_contact::Error;
use fdem_io::numbers::grouped;
use fdem_io::{
    Column, Compression, FileKind, MeshFormat, Packing, PackingFormat, ReadError, ReadOptions, Role, Series,
    TypeColumn, unpack_within,
};
use fdem_results::network::{PairCutoffs, Sizes};

use crate::command::args::{InputArguments, NamedColumns};
use crate::command::cutoff::{self, Cutoff};
use crate::command::failure::{Failure, display_name};
use crate::command::frames::{Frames, Selection};
use crate::command::memory;
use crate::command::output::is_stdout;
use crate::command::pieces::FilesBeside;
use crate::command::progress::{Position, Progress};

/// A packing that has been read.
pub(crate) struct Input {
    /// Name of the file in messages.
    pub(crate) name: String,
    /// The packing. Its bodies are in `bodies`.
    pub(crate) packing: Packing,
    pub(crate) bodies: Option<Bodies>,
    /// The cut-off of each pair of elements, if `--cutoff` is by types.
    pub(crate) pairs: Option<Box<PairCutoffs>>,
    /// Time to read it, s.
    pub(crate) seconds: f64,
}

/// The bodies that elements are parts of.
pub(crate) struct Bodies {
    /// Number of the body of each element. Bodies are numbered from 0 in ascending order of their ids in the
    /// file.
    pub(crate) numbers: Vec<u32>,
    /// Number of bodies.
    pub(crate) count: usize,
}

impl Bodies {
    /// Numbers the bodies. 32 bits are enough: there are no more bodies than elements, and the library
    /// accepts no more elements than that.
    fn new(names: &[i64]) -> Self {
        let mut distinct = names.to_vec();
        distinct.sort_unstable();
        distinct.dedup();
        let number = |name: &i64| distinct.partition_point(|earlier| earlier < name) as u32;
        Self { numbers: names.iter().map(number).collect(), count: distinct.len() }
    }
}

/// A file that has been opened but not parsed.
pub(crate) struct Opened {
    /// Name of the file in messages.
    pub(crate) name: String,
    /// Decompressed content.
    pub(crate) bytes: Vec<u8>,
    pub(crate) kind: FileKind,
    /// Time to open it, s.
    pub(crate) seconds: f64,
    /// The files that it lists, if it is a collection.
    pieces: FilesBeside,
    /// Remarks on the frames that were printed, each once.
    remarks: RefCell<Vec<String>>,
}

impl Opened {
    /// Whether the file is a mesh, by its content or else its name.
    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self.kind, FileKind::Mesh(_))
    }

    /// Opens the frames of a packing.
    pub(crate) fn series(&self) -> Result<Series<'_>, Failure> {
        let format = match self.kind {
            FileKind::Packing(format) => format,
            FileKind::Mesh(_) => PackingFormat::Text,
        };
        let collection = if format == PackingFormat::VtkXml {
            Series::of_collection(&self.bytes, &self.pieces)
        } else {
            Ok(None)
        };
        collection
            .and_then(|collection| match collection {
                Some(series) => Ok(series),
                None => Series::open(&self.bytes, bare_name(&self.name), Some(format)),
            })
            .map_err(|error| unreadable(&self.name, &error))
    }

    /// Selects frames of the file.
    pub(crate) fn select(&self, series: &Series<'_>, frames: Option<Frames>) -> Result<Selection, Failure> {
        Frames::select(frames, series.frames())
            .map_err(|problem| Failure::Unusable(format!("{}: {problem}", self.name)))
    }

    /// Reads a frame, and the columns that options name. A flat packing becomes one in the plane. Warns
    /// of skipped lines and of columns that may be an axis.
    pub(crate) fn frame(
        &self,
        series: &Series<'_>,
        frame: usize,
        arguments: &InputArguments,
        columns: NamedColumns<'_>,
        progress: &Progress,
    ) -> Result<Input, Failure> {
        let pairs = arguments.cutoff.as_ref().and_then(Cutoff::pairs);
        let options = ReadOptions {
            columns: arguments.columns.clone(),
            skip_bad_lines: arguments.skip_bad_lines,
            ignore_ids: arguments.ignore_ids,
            bodies: columns.bodies.map(str::to_owned),
            types: pairs
                .map(|_| columns.types.map_or(TypeColumn::Usual, |name| TypeColumn::Named(name.to_owned()))),
        };
        let (packing, seconds) = progress.step("reading", Some(self.bytes.len() as u64), |position| {
            series.read(frame, &options, position).map_err(|error| unreadable(&self.name, &error))
        });
        let mut packing = packing?;
        report_skipped(&self.name, &packing, series.frames() > 1);
        if let Some(remark) = packing.source.unused_axis().filter(|_| options.columns.is_none()) {
            self.remark(remark);
        }
        if let Some(remark) = arguments.cutoff.as_ref().and_then(|cutoff| packing.layer(cutoff.largest())) {
            self.remark(remark);
        }
        if let Some(remark) = largest_diameter(arguments, &packing).and_then(|reach| packing.flatten(reach)) {
            self.remark(remark);
        }
        let bodies = packing.bodies.take().map(|names| Bodies::new(&names));
        let pairs = match (pairs, packing.types.take()) {
            (Some(pairs), Some(types)) => {
                let role = |column: &&Column| column.role == Some(Role::Type);
                let column = packing.source.columns.iter().find(role).map_or("", |column| &column.name);
                let frame = if series.frames() > 1 { format!(": frame {frame}") } else { String::new() };
                let found = cutoff::of_types(pairs, &types, column)
                    .map_err(|problem| Failure::Unusable(format!("{}{frame}: {problem}", self.name)))?;
                Some(Box::new(found))
            }
            _ => None,
        };
        Ok(Input { name: self.name.clone(), packing, bodies, pairs, seconds })
    }

    /// Prints a remark on a frame, even with `--quiet`, unless an earlier frame had the same.
    fn remark(&self, remark: String) {
        let mut earlier = self.remarks.borrow_mut();
        if !earlier.contains(&remark) {
            // Nothing can be done if it cannot be printed.
            let _ = writeln!(io::stderr(), "note: {}: {remark}", self.name);
            earlier.push(remark);
        }
    }
}

/// The largest diameter, with the tolerance; `None` for points with a cut-off, or if there are no radii.
fn largest_diameter(arguments: &InputArguments, packing: &Packing) -> Option<f64> {
    if arguments.cutoff.is_some() {
        return None;
    }
    let radii = packing.radii.as_deref().unwrap_or(&[]);
    let radius = arguments.radius.or_else(|| radii.iter().copied().reduce(f64::max))?;
    Some(2.0 * radius + arguments.tolerance)
}

/// Opens and decompresses the file, or standard input for `-`. A `format` overrides the content and the name.
/// `max_memory`: the option of this name, if it is given.
pub(crate) fn open(
    file: &Path,
    format: Option<PackingFormat>,
    max_memory: Option<u64>,
    progress: &Progress,
) -> Result<Opened, Failure> {
    let name = if is_stdout(file) { "standard input".to_owned() } else { display_name(file) };
    let (opened, seconds) = progress.step("opening, bytes", None, |position| {
        let most = max_memory.or_else(memory::default_limit);
        let bytes = read_bytes(file, &name, most, position)?;
        let wanted = |start: &[u8]| !is_rubbish(start, bytes.len() as u64, &name);
        // The elements take about as much as the text of their rows.
        let limit = most.map_or(u64::MAX, |most| most.saturating_sub(bytes.len() as u64) / 2);
        let unpacked = unpack_within((&bytes).into(), limit, wanted).map_err(|error| match error {
            ReadError::TooLarge { compression, bytes, .. } => {
                let content =
                    format!("the content of this {compression} file has {} or more", size_in_words(bytes));
                too_large(&name, &content, bytes.saturating_mul(2), most)
            }
            error => unreadable(&name, &error),
        })?;
        let unpacked = match unpacked {
            (_, None) => None,
            (unpacked, Some(_)) => Some(unpacked.into_owned()),
        };
        let bytes = unpacked.unwrap_or(bytes);
        let kind = match format {
            Some(format) => FileKind::Packing(format),
            None => FileKind::of(&bytes, bare_name(&name)).map_err(|error| unreadable(&name, &error))?,
        };
        Ok::<_, Failure>((bytes, kind))
    });
    let (bytes, kind) = opened?;
    let beside = if is_stdout(file) { Path::new("") } else { file };
    let pieces = FilesBeside::new(beside, max_memory);
    Ok(Opened { name, bytes, kind, seconds, pieces, remarks: RefCell::default() })
}

/// The failure for a file that takes more memory than is allowed. `content`: its size in words; `needed`:
/// memory for it and its elements, bytes.
fn too_large(name: &str, content: &str, needed: u64, most: Option<u64>) -> Failure {
    Failure::Unusable(format!(
        "{name}: {content}; with its elements it may take {} of memory, and {} are allowed: --max-memory SIZE \
         allows more",
        size_in_words(needed),
        size_in_words(most.unwrap_or(u64::MAX)),
    ))
}

/// A size in MB, rounded up; below one, in bytes.
fn size_in_words(bytes: u64) -> String {
    match bytes {
        1 => "1 byte".to_owned(),
        0..1_000_000 => format!("{} bytes", grouped(bytes)),
        _ => format!("{} MB", grouped(bytes.div_ceil(1_000_000))),
    }
}

/// Memory of an element of a row of text beside the text, bytes: three coordinates, the radius, the
/// identifier and its body, or four corners and the body.
const OF_ROW: u64 = 48;

/// Memory for a file of this size that begins with `start`, with its elements, bytes. The numbers of a binary
/// file are as many bytes again.
fn needed(start: &[u8], size: u64) -> u64 {
    if start.contains(&0) || start.is_empty() {
        return size.saturating_mul(2);
    }
    let rows = start.split(|byte| *byte == b'\n').count() as u64;
    let rows = size.saturating_mul(rows) / start.len() as u64;
    let rows = elements_of_frame(start).map_or(rows, |elements| elements.min(rows));
    size.saturating_add(OF_ROW.saturating_mul(rows))
}

/// Number of elements of the first frame of a LAMMPS dump or an XYZ file: frames are read one by one.
fn elements_of_frame(start: &[u8]) -> Option<u64> {
    let head = String::from_utf8_lossy(&start[..start.len().min(1000)]);
    let mut lines = head.lines().map(str::trim);
    let first = lines.next()?;
    let number = if first == "ITEM: TIMESTEP" {
        lines.skip_while(|line| *line != "ITEM: NUMBER OF ATOMS").nth(1)?
    } else {
        first
    };
    number.parse().ok()
}

/// File name without the extension of its compression.
fn bare_name(name: &str) -> &str {
    [".gz", ".zst", ".zstd"].iter().find_map(|end| name.strip_suffix(end)).unwrap_or(name)
}

/// Opens and reads a file of one frame, or the selected frame.
pub(crate) fn read(arguments: &InputArguments, progress: &Progress) -> Result<Input, Failure> {
    let opened = open(&arguments.file, arguments.format, arguments.max_memory, progress)?;
    understand(opened, arguments, progress)
}

/// Like [`read`], for a file that is open.
pub(crate) fn understand(
    opened: Opened,
    arguments: &InputArguments,
    progress: &Progress,
) -> Result<Input, Failure> {
    let series = opened.series()?;
    let frame = match opened.select(&series, arguments.frames)? {
        Selection::One(frame) => frame,
        Selection::Series(frames) => {
            return Err(Failure::Unusable(format!(
                "{}: {} frames are selected, but one is needed: choose it with --frames N",
                opened.name,
                frames.len()
            )));
        }
    };
    let mut input = opened.frame(&series, frame, arguments, NamedColumns::default(), progress)?;
    input.seconds += opened.seconds;
    drop(opened);
    Ok(input)
}

/// Reads a file, or standard input, unless it would take more than `most` bytes with its elements.
fn read_bytes(file: &Path, name: &str, most: Option<u64>, position: &Position) -> Result<Vec<u8>, Failure> {
    let failed = |error: io::Error| Failure::reading(name, &error);
    if is_stdout(file) {
        return read_all(io::stdin().lock(), 0, (name, most), position);
    }
    if file.is_dir() {
        return Err(Failure::Unusable(format!("cannot read {name}: it is a directory")));
    }
    let input = fs::File::open(file).map_err(failed)?;
    let size = input.metadata().map_or(0, |metadata| metadata.len());
    read_all(input, size, (name, most), position)
}

/// Reads to the end. Stops after the first block if it can be neither a packing nor a mesh: `/dev/zero` has
/// no end. `size`: that of the file, or 0 if it is not known.
fn read_all(
    mut input: impl Read,
    size: u64,
    (name, most): (&str, Option<u64>),
    position: &Position,
) -> Result<Vec<u8>, Failure> {
    let failed = |error: io::Error| Failure::reading(name, &error);
    let mut bytes = Vec::new();
    let mut first = 0;
    loop {
        let read = input.by_ref().take(BLOCK).read_to_end(&mut bytes).map_err(failed)?;
        position.store(bytes.len() as u64, Ordering::Relaxed);
        if read == 0 || (bytes.len() as u64 <= BLOCK && is_rubbish(&bytes, size, name)) {
            return Ok(bytes);
        }
        if first == 0 {
            first = read;
        }
        let or_more = if size == 0 { " or more" } else { "" };
        let size = size.max(bytes.len() as u64);
        // Content that is unpacked has its own bound.
        let needed = if Compression::of(&bytes).is_none() { needed(&bytes[..first], size) } else { size };
        if most.is_some_and(|most| needed > most) {
            let content = format!("this file has {}{or_more}", size_in_words(size));
            return Err(too_large(name, &content, needed, most));
        }
        if first == bytes.len() {
            let rest = usize::try_from(size).unwrap_or(usize::MAX).saturating_sub(bytes.len());
            bytes.try_reserve_exact(rest).map_err(|_| failed(io::ErrorKind::OutOfMemory.into()))?;
        }
    }
}

/// Size of the first block, bytes.
const BLOCK: u64 = 1 << 20;

/// Whether no supported file starts with these bytes.
fn is_rubbish(start: &[u8], size: u64, name: &str) -> bool {
    const ARRAYS: [&[u8]; 2] = [b"\x93NUMPY", b"PK\x03\x04"];
    let is_array = ARRAYS.iter().any(|magic| start.starts_with(magic));
    !is_array && start.contains(&0) && Compression::of(start).is_none() && !may_be_mesh(start, size, name)
}

/// Whether a file of this size that starts with these bytes may be a mesh. A binary STL file is recognised by
/// its size, which follows from its number of facets.
fn may_be_mesh(start: &[u8], size: u64, name: &str) -> bool {
    let facets = start.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let is_stl = facets.is_some_and(|facets| size == 84 + 50 * u64::from(facets));
    is_stl || MeshFormat::of(start, bare_name(name)).is_some()
}

/// The failure for an input that cannot be parsed: `file:line: error`, so that an editor can jump to the
/// line.
pub(crate) fn unreadable(name: &str, error: &ReadError) -> Failure {
    Failure::Unusable(match error.line() {
        Some(line) => format!("{name}:{line}: {error}"),
        None => format!("{name}: {error}"),
    })
}

/// Warns of skipped lines, even with `--quiet`.
fn report_skipped(name: &str, packing: &Packing, of_several: bool) {
    const SHOWN: usize = 5;
    let skipped = &packing.source.skipped;
    if skipped.count == 0 {
        return;
    }
    let format = &packing.source.format;
    let frame = if of_several { format!(" of frame {}", packing.frame.index) } else { String::new() };
    let mut text =
        vec![format!("warning: {name}: skipped {} bad {}{frame}", skipped.count, format.noun(skipped.count))];
    text.extend(skipped.first.iter().take(SHOWN).map(|bad| {
        // In an array, the problem itself names the row.
        let place = if format.has_lines() { format!("{}:", bad.line) } else { String::new() };
        format!("  {name}:{place} {}: {}", bad.problem, bad.text)
    }));
    if skipped.count > SHOWN as u64 {
        text.push(format!("  and {} more", skipped.count - SHOWN as u64));
    }
    // Nothing can be done if the warning cannot be printed. The count is in the JSON summary too.
    let _ = writeln!(io::stderr(), "{}", text.join("\n"));
}

/// Sizes of the elements. Options override the file.
pub(crate) fn sizes<'a>(arguments: &InputArguments, input: &'a Input) -> Result<Sizes<'a>, Failure> {
    let Input { name, packing, pairs, .. } = input;
    if let Some(pairs) = pairs {
        return Ok(Sizes::Pairs(pairs));
    }
    match (arguments.radius, &arguments.cutoff, &packing.radii) {
        (Some(radius), ..) => Ok(Sizes::All(radius)),
        (_, Some(cutoff), _) => Ok(Sizes::Cutoff(cutoff.largest())),
        (_, _, Some(radii)) => Ok(Sizes::Each(radii)),
        (None, None, None) => {
            let columns =
                packing.source.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>();
            Err(Failure::Unusable(format!(
                "{name}: no column for radius or diameter among {}: give --radius R, --cutoff D or --columns",
                columns.join(", ")
            )))
        }
    }
}

/// Id of an element in the file, or the number of its data row, from 0.
pub(crate) fn id(packing: &Packing, index: usize) -> i64 {
    match (&packing.ids, &packing.row_numbers) {
        (Some(ids), _) => ids[index],
        (None, Some(rows)) => rows[index].cast_signed(),
        (None, None) => index.cast_signed() as i64,
    }
}

/// The failure for an error of the library. It names elements by their id or row, and options by name.
pub(crate) fn refused(name: &str, packing: &Packing, error: &Error) -> Failure {
    Failure::Unusable(format!("{name}: {}", refusal(packing, error)))
}

/// Like [`refused`], without the file's name.
pub(crate) fn refusal(packing: &Packing, error: &Error) -> String {
    let element = |index: usize| match &packing.ids {
        Some(ids) => format!("the element with id {}", ids[index]),
        None => format!("the element of data row {} (counted from 0)", id(packing, index)),
    };
    match error {
        Error::DomainTooWide { axis, width, cell_size, stretched_by: Some((index, position)), .. } => {
            format!(
                "the domain is {width:e} wide along {axis}, {cells:.1e} cells of {cell_size:e}: too many for the \
             lists of this engine. It is stretched by {element} at {axis} = {position:e}. Remove that element, or choose \
             --engine rows, whose memory does not depend on the domain",
                axis = ["x", "y", "z"][*axis],
                cells = width / cell_size,
                element = element(*index),
            )
        }
        Error::OutOfMemory { bytes } => format!(
            "no memory for {bytes} bytes: the couples do not fit. --count needs no memory for them; a smaller \
             --tolerance, --radius or --cutoff gives fewer couples"
        ),
        Error::NoThreads { .. } => format!("--threads: {error}"),
        _ => match error.element() {
            Some(index) => format!("{error} ({} in the file)", element(index)),
            None => error.to_string(),
        },
    }
}
