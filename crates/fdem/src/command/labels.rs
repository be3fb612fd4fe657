//! `fdem contacts --labels`: contacts of bodies in labelled images, read plane by plane.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Instant;

use fdem_contact::Error;
use fdem_contact::image::{ImageContact, ImageContacts, Label, Neighbourhood, Spacing};
use fdem_io::{LabelImage, LabelKind, LabelValue, Table, Values, with_label_image};

use crate::command::args::{ContactsArguments, NeighbourhoodName};
use crate::command::drawings::BodiesDrawing;
use crate::command::failure::{Failure, display_name};
use crate::command::label_axes::{AxisOrder, ImageStop};
use crate::command::label_middles::{DrawnBodies, Middles, Sum};
use crate::command::label_summary::LabelSummary;
use crate::command::output::{TableFormat, is_stdout, refuse_to_overwrite};
use crate::command::outputs::Outputs;
use crate::command::progress::{Position, Progress};
use crate::command::summary::Seconds;
use crate::command::tables::{normal, point, write_table};

pub(crate) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    let file = &arguments.input.file;
    let mut files = vec![
        ("the input", Some(file)),
        ("--output", arguments.output.as_ref()),
        ("--json", arguments.json.as_ref()),
    ];
    files.extend(arguments.drawings.files());
    refuse_to_overwrite(&files)?;
    let progress = Progress::new(arguments.quiet);
    let mut outputs = Outputs::open(arguments)?;
    if outputs.table != TableFormat::Vtp {
        outputs.table.is_table("bodies of an image")?;
    }
    let name = if is_stdout(file) { "standard input".to_owned() } else { display_name(file) };
    let task = ImageTask { arguments, progress: &progress, name: &name };
    let visit = |image: &mut LabelImage<'_>| task.visit(image, &mut outputs);
    let member = arguments.labels.member.as_deref();
    let done = match open(file, &name)? {
        OpenedImage::File(file) => with_label_image(file, member, visit),
        OpenedImage::Memory(bytes) => with_label_image(bytes, member, visit),
    };
    let mut summary = done.map_err(|stop| stop.told(&name))?;

    summary.measure_peak();
    outputs.finish(&summary, arguments.quiet)
}

/// An image that can be read from any position.
enum OpenedImage {
    File(File),
    Memory(Cursor<Vec<u8>>),
}

/// Opens an image. A pipe is read into memory if it starts like an image: `/dev/zero` has no end.
fn open(file: &Path, name: &str) -> Result<OpenedImage, Failure> {
    const STARTS: [&[u8]; 4] = [b"\x93NUMPY", b"PK", b"II", b"MM"];
    let failed = |error: io::Error| Failure::reading(name, &error);
    let mut input: Box<dyn Read> = if is_stdout(file) {
        Box::new(io::stdin().lock())
    } else {
        if file.is_dir() {
            return Err(Failure::Unusable(format!("cannot read {name}: it is a directory")));
        }
        let opened = File::open(file).map_err(failed)?;
        if opened.metadata().is_ok_and(|metadata| metadata.is_file()) {
            return Ok(OpenedImage::File(opened));
        }
        Box::new(opened)
    };
    let mut bytes = Vec::new();
    input.by_ref().take(8).read_to_end(&mut bytes).map_err(failed)?;
    if STARTS.iter().any(|start| bytes.starts_with(start)) {
        input.read_to_end(&mut bytes).map_err(failed)?;
    }
    Ok(OpenedImage::Memory(Cursor::new(bytes)))
}

/// The arguments of the command and its progress.
struct ImageTask<'a> {
    arguments: &'a ContactsArguments,
    progress: &'a Progress,
    name: &'a str,
}

/// Pixels or voxels that are compared at a time, unless one plane has more.
const SLAB: usize = 1 << 17;

impl ImageTask<'_> {
    fn visit(&self, image: &mut LabelImage<'_>, outputs: &mut Outputs) -> Result<LabelSummary, ImageStop> {
        match image.kind() {
            LabelKind::U8 => self.typed::<u8>(image, outputs),
            LabelKind::U16 => self.typed::<u16>(image, outputs),
            LabelKind::U32 => self.typed::<u32>(image, outputs),
            LabelKind::U64 => self.typed::<u64>(image, outputs),
            LabelKind::I32 => self.typed::<i32>(image, outputs),
            LabelKind::I64 => self.typed::<i64>(image, outputs),
        }
    }

    fn typed<L: Label + LabelValue + TryFrom<i128>>(
        &self,
        image: &mut LabelImage<'_>,
        outputs: &mut Outputs,
    ) -> Result<LabelSummary, ImageStop> {
        let background = self.arguments.labels.background.0;
        let converted = background.map(|number| {
            L::try_from(number).map_err(|_| {
                ImageStop::Option(format!(
                    "--background {number}: a label of {} cannot have this value",
                    image.format()
                ))
            })
        });
        let converted = converted.transpose()?;
        match *image.shape() {
            [rows, columns] => self.compare(image, [rows, columns], converted, outputs),
            [planes, rows, columns] => self.compare(image, [planes, rows, columns], converted, outputs),
            _ => Err(ImageStop::Option("an image has two or three axes".to_owned())),
        }
    }

    /// Compares the image and writes the contacts. It is compiled for each type of label; [`Self::finish`] is
    /// not.
    fn compare<L: Label + LabelValue, const D: usize>(
        &self,
        image: &mut LabelImage<'_>,
        shape: [usize; D],
        background: Option<L>,
        outputs: &mut Outputs,
    ) -> Result<LabelSummary, ImageStop> {
        // An option that does not fit is refused before the image is read.
        let spacing = self.spacing(AxisOrder { reversed: image.reversed() })?;
        let contacts = ImageContacts::new(shape, self.arguments.labels.neighbourhood.into())?
            .with_background(background)
            .with_threads(self.arguments.threads)?;
        let drawn = self.arguments.drawings.any() || writes_vtp(outputs);
        let mut middles = drawn.then(|| Middles::new(shape, background));
        let mut seconds = Seconds::default();
        let (found, _) = self.progress.step("reading and comparing", Some(shape[0] as u64), |position| {
            stream(image, contacts, middles.as_mut(), position, &mut seconds)
        });
        let (contacts, bodies) = found?;
        let found = ImageResult { contacts, bodies, sums: middles.map(Middles::into_sums), seconds };
        self.finish(image, shape, &spacing, found, outputs)
    }

    /// Writes the contacts, draws the bodies, and returns the summary.
    fn finish<const D: usize>(
        &self,
        image: &LabelImage<'_>,
        shape: [usize; D],
        spacing: &Spacing<D>,
        found: ImageResult<D>,
        outputs: &mut Outputs,
    ) -> Result<LabelSummary, ImageStop> {
        let ImageResult { contacts, bodies, sums, mut seconds } = found;
        let order = AxisOrder { reversed: image.reversed() };
        let neighbourhood: Neighbourhood = self.arguments.labels.neighbourhood.into();
        let drawn = sums.map(|sums| DrawnBodies::new(sums, &contacts, spacing, order)).transpose()?;

        let is_vtp = writes_vtp(outputs);
        let edges = D == 3 && neighbourhood >= Neighbourhood::Edge;
        let vertices = neighbourhood == Neighbourhood::Vertex;
        let (written, writing) = self.progress.step("writing", Some(contacts.len() as u64), |position| {
            if self.arguments.count {
                return outputs.count(contacts.len() as u64);
            }
            let Some(couples) = &mut outputs.couples else { return Ok(()) };
            if let (true, Some(drawn)) = (is_vtp, &drawn) {
                let (points, lines) = (drawn.points(), drawn.lines(&contacts, spacing, order));
                return couples.write(|mut out| fdem_io::write_vtp(&mut out, &points, &lines));
            }
            let table = table(&contacts, image.kind(), [edges, vertices], spacing, order, position);
            write_table(couples, outputs.table, &table)
        });
        written.map_err(ImageStop::Failed)?;
        seconds.write = writing;

        let mut in_contact: Vec<i128> = contacts.iter().flat_map(ImageContact::labels).collect();
        in_contact.sort_unstable();
        in_contact.dedup();
        let sum = |count: fn(&ImageContact<i128, D>) -> u64| contacts.iter().map(count).sum::<u64>();
        let summary = LabelSummary {
            file: self.name.to_owned(),
            format: image.format().to_owned(),
            shape: order.xyz(shape).to_vec(),
            spacing: order.xyz(spacing.edges()).to_vec(),
            background: self.arguments.labels.background.0,
            bodies,
            neighbourhood: self.arguments.labels.neighbourhood.name(),
            threads: self.arguments.threads,
            contacts: contacts.len(),
            mean_coordination: if bodies == 0 { 0.0 } else { 2.0 * contacts.len() as f64 / bodies as f64 },
            without_contact: bodies - in_contact.len(),
            faces: sum(ImageContact::faces),
            edges: edges.then(|| sum(ImageContact::edges)),
            vertices: vertices.then(|| sum(ImageContact::vertices)),
            area: contacts.iter().fold(0.0, |sum, contact| sum + contact.area(spacing)),
            seconds,
            peak_bytes: None,
        };
        if let (true, Some(drawn)) = (self.arguments.drawings.any(), &drawn) {
            let drawing = BodiesDrawing {
                name: self.name,
                bodies: drawn.bodies(),
                unit: None,
                ids: Some(drawn.ids()),
                columns: &drawn.columns(),
                summary: &summary.to_string(),
            };
            outputs.drawings.write_bodies(&drawing).map_err(ImageStop::Failed)?;
        }
        Ok(summary)
    }

    /// Spacing in the order of the stored axes.
    fn spacing<const D: usize>(&self, order: AxisOrder) -> Result<Spacing<D>, ImageStop> {
        let Some(numbers) = &self.arguments.labels.spacing else { return Ok(Spacing::UNIT) };
        let edges: [f64; D] = numbers.0[..].try_into().map_err(|_| {
            let wanted = if D == 2 { "X,Y" } else { "X,Y,Z" };
            ImageStop::Option(format!(
                "--spacing has {} numbers, the image is {D}D: give {wanted}",
                numbers.0.len()
            ))
        })?;
        // Reversing the order is its own inverse.
        Ok(Spacing::new(order.xyz(edges))?)
    }
}

/// Whether the contacts go into a VTP file, which has the centres of the bodies.
fn writes_vtp(outputs: &Outputs) -> bool {
    outputs.table == TableFormat::Vtp && outputs.couples.is_some()
}

/// The contacts and bodies that were found in an image, the same for every type of label.
struct ImageResult<const D: usize> {
    contacts: Vec<ImageContact<i128, D>>,
    /// Number of bodies.
    bodies: usize,
    /// For drawings: the sums over the pixels or voxels of each body, in ascending order of labels.
    sums: Option<Vec<(i128, Sum<D>)>>,
    seconds: Seconds,
}

/// Reads and compares the image slab by slab. Returns the contacts and the number of bodies.
fn stream<L: Label + LabelValue, const D: usize>(
    image: &mut LabelImage<'_>,
    mut contacts: ImageContacts<L, D>,
    mut middles: Option<&mut Middles<L, D>>,
    position: &Position,
    seconds: &mut Seconds,
) -> Result<(Vec<ImageContact<i128, D>>, usize), ImageStop> {
    let plane: usize = image.shape()[1..].iter().product();
    let planes = (SLAB / plane.max(1)).max(1);
    let mut slab = Vec::new();
    loop {
        let start = Instant::now();
        let read = image.read_planes(planes, &mut slab)?;
        seconds.read += start.elapsed().as_secs_f64();
        if read == 0 {
            break;
        }
        let start = Instant::now();
        contacts.add(&slab)?;
        if let Some(middles) = &mut middles {
            middles.add(&slab);
        }
        seconds.detect += start.elapsed().as_secs_f64();
        position.fetch_add(read as u64, Ordering::Relaxed);
    }
    drop(slab);
    let start = Instant::now();
    let bodies = contacts.labels();
    let found = contacts.finish()?;
    let mut wide = Vec::new();
    let bytes = found.len() * size_of::<ImageContact<i128, D>>();
    wide.try_reserve_exact(found.len()).map_err(|_| Error::OutOfMemory { bytes })?;
    wide.extend(found.into_iter().map(ImageContact::widened));
    seconds.detect += start.elapsed().as_secs_f64();
    Ok((wide, bodies))
}

/// Table with a row per contact, and with the numbers of edges and vertices if they were counted. `position`
/// counts the rows.
fn table<'a, const D: usize>(
    contacts: &'a [ImageContact<i128, D>],
    kind: LabelKind,
    [edges, vertices]: [bool; 2],
    spacing: &'a Spacing<D>,
    order: AxisOrder,
    position: &'a Position,
) -> Table<'a> {
    let label = |which: usize| {
        let at = move |k: usize| contacts[k].labels()[which];
        // Labels fit into these types.
        if kind == LabelKind::U64 {
            Values::u64(move |k| at(k) as u64)
        } else {
            Values::i64(move |k| at(k) as i64)
        }
    };
    let faces = move |k: usize| {
        position.store(k as u64, Ordering::Relaxed);
        contacts[k].faces()
    };
    let mut table =
        Table::new(contacts.len()).with("i", label(0)).with("j", label(1)).with("faces", Values::u64(faces));
    if edges {
        table = table.with("edges", Values::u64(move |k| contacts[k].edges()));
    }
    if vertices {
        table = table.with("vertices", Values::u64(move |k| contacts[k].vertices()));
    }
    let area = Values::f64(move |k| contacts[k].area(spacing));
    let centroid = Values::f64(move |k| order.xyz(contacts[k / D].centroid(spacing))[k % D]);
    let direction = Values::f64(move |k| order.xyz(contacts[k / D].normal(spacing))[k % D]);
    table
        .with(if D == 2 { "length" } else { "area" }, area)
        .with_components("centroid", point::<D>(), centroid)
        .with_components("normal", normal::<D>(), direction)
}

impl From<NeighbourhoodName> for Neighbourhood {
    fn from(name: NeighbourhoodName) -> Self {
        match name {
            NeighbourhoodName::Face => Self::Face,
            NeighbourhoodName::Edge => Self::Edge,
            NeighbourhoodName::Vertex => Self::Vertex,
        }
    }
}
