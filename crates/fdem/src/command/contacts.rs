//! `fdem contacts`: read, detect, write, report.

use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::atomic::Ordering;

use fdem_contact::{Couple, Error};
use fdem_io::{Centres, CoupleRow, Packing, ReadError, ReadOptions};

use crate::command::args::ContactsArguments;
use crate::command::detect::{Found, Refusal, Request, Sizes, detect, distance};
use crate::command::failure::Failure;
use crate::command::output::{Output, Table};
use crate::command::picture;
use crate::command::progress::Progress;
use crate::command::summary::{Seconds, Summary};

pub(crate) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    refuse_to_overwrite(arguments)?;
    let progress = Progress::new(arguments.quiet);
    let mut outputs = Outputs::open(arguments)?;

    let name = display_name(&arguments.file);
    let (packing, read) = progress.step("opening", None, |_| read_bytes(&arguments.file));
    let bytes = packing?;
    let options = ReadOptions {
        columns: arguments.columns.clone(),
        skip_bad_lines: arguments.skip_bad_lines,
        ignore_ids: arguments.ignore_ids,
    };
    let (packing, parse) = progress.step("reading", Some(bytes.len() as u64), |position| {
        fdem_io::read(&bytes, &options, position).map_err(|error| unreadable(&name, &error))
    });
    drop(bytes);
    let packing = packing?;
    report_skipped(&name, &packing);

    let seconds = Seconds { read: read + parse, ..Seconds::default() };
    let mut summary = match &packing.centres {
        Centres::Two(centres) => find(arguments, &progress, &name, &packing, centres, &mut outputs, seconds),
        Centres::Three(centres) => {
            find(arguments, &progress, &name, &packing, centres, &mut outputs, seconds)
        }
    }?;

    // The last output is the summary, which tells how long the others took.
    summary.measure_peak();
    if let Some(json) = &mut outputs.json {
        json.write(|out| {
            serde_json::to_writer_pretty(&mut *out, &summary)?;
            out.write_all(b"\n")
        })?;
    }
    outputs.commit()?;
    if !arguments.quiet {
        // A summary that nobody can see any more is no failure.
        let _ = write!(io::stderr(), "{summary}");
    }
    Ok(())
}

/// Detection and the outputs that need the dimension.
fn find<const D: usize>(
    arguments: &ContactsArguments,
    progress: &Progress,
    name: &str,
    packing: &Packing,
    centres: &[[f64; D]],
    outputs: &mut Outputs,
    mut seconds: Seconds,
) -> Result<Summary, Failure> {
    let sizes = sizes(arguments, name, packing)?;
    let request = Request {
        sizes,
        tolerance: arguments.tolerance,
        engine: arguments.engine.into(),
        keep: !arguments.count || arguments.picture.is_some(),
        verify: arguments.verify,
    };
    let (found, detection) =
        progress.step("detecting, couples", None, |position| detect(centres, &request, position));
    seconds.detect = detection;
    let found = found.map_err(|refusal| refused(name, packing, &refusal))?;

    let total = found.couples.len() as u64;
    let (written, writing) = progress.step("writing", Some(total), |position| {
        let rows = found.couples.iter().enumerate().map(|(written, &couple)| {
            position.store(written as u64, Ordering::Relaxed);
            row(packing, centres, sizes, couple)
        });
        if arguments.count {
            return outputs.couples.write(|out| writeln!(out, "{}", found.statistics.couples));
        }
        outputs.couples.write(|mut out| match outputs.table {
            Table::Csv => fdem_io::write_csv(&mut out, rows).map(drop),
            Table::Npy => fdem_io::write_npy(&mut out, rows),
        })
    });
    written?;
    seconds.write = writing;
    if let Some(picture) = &mut outputs.picture {
        picture::check(centres.len(), &arguments.file)?;
        picture.write(|out| picture::draw(out, centres, sizes, &found.couples))?;
    }
    Ok(Summary::new(name, packing, centres, sizes, arguments.tolerance, &found, seconds))
}

fn row<const D: usize>(
    packing: &Packing,
    centres: &[[f64; D]],
    sizes: Sizes<'_>,
    couple: Couple,
) -> CoupleRow {
    let id = |element: u32| packing.ids.as_ref().map_or(i64::from(element), |ids| ids[element as usize]);
    let distance = distance(centres, couple);
    CoupleRow {
        i: id(couple.i),
        j: id(couple.j),
        distance,
        overlap: sizes.contact_distance(couple) - distance,
    }
}

/// The files that the command writes; all appear together, at the end.
struct Outputs {
    table: Table,
    couples: Output,
    json: Option<Output>,
    picture: Option<Output>,
}

impl Outputs {
    fn open(arguments: &ContactsArguments) -> Result<Self, Failure> {
        let output = arguments.output.as_deref();
        let optional = |path: &Option<_>| path.as_deref().map(|path| Output::open(Some(path))).transpose();
        Ok(Self {
            table: Table::of(output)?,
            couples: Output::open(output)?,
            json: optional(&arguments.json)?,
            picture: optional(&arguments.picture)?,
        })
    }

    fn commit(self) -> Result<(), Failure> {
        self.couples.commit()?;
        [self.json, self.picture].into_iter().flatten().try_for_each(Output::commit)
    }
}

/// No output may replace the input, nor another output.
fn refuse_to_overwrite(arguments: &ContactsArguments) -> Result<(), Failure> {
    let input = ("the input", Some(&arguments.file));
    let outputs = [
        ("--output", arguments.output.as_ref()),
        ("--json", arguments.json.as_ref()),
        ("--picture", arguments.picture.as_ref()),
    ];
    for (k, (option, path)) in outputs.iter().enumerate() {
        let Some(path) = path else { continue };
        for (other, taken) in std::iter::once(&input).chain(&outputs[..k]) {
            if taken.is_some_and(|taken| same_file(path, taken)) {
                return Err(Failure::Unusable(format!("{option} {} is {other} too", path.display())));
            }
        }
    }
    Ok(())
}

/// Whether two names stand for one regular file, that exists or not.
fn same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b && a.is_file(),
        _ => a == b,
    }
}

fn display_name(file: &Path) -> String {
    if file == Path::new("-") { "standard input".to_owned() } else { file.display().to_string() }
}

fn read_bytes(file: &Path) -> Result<Vec<u8>, Failure> {
    let name = display_name(file);
    let failed = |error: &io::Error| Failure::Unusable(format!("cannot read {name}: {error}"));
    if file == Path::new("-") {
        let mut bytes = Vec::new();
        io::stdin().lock().read_to_end(&mut bytes).map_err(|error| failed(&error))?;
        return Ok(bytes);
    }
    if file.is_dir() {
        return Err(Failure::Unusable(format!("cannot read {name}: it is a directory")));
    }
    fs::read(file).map_err(|error| failed(&error))
}

/// `file:line: what is wrong`, so that an editor can jump there.
fn unreadable(name: &str, error: &ReadError) -> Failure {
    Failure::Unusable(match error.line() {
        Some(line) => format!("{name}:{line}: {error}"),
        None => format!("{name}: {error}"),
    })
}

/// Lines left out are never left out in silence, not even with `--quiet`.
fn report_skipped(name: &str, packing: &Packing) {
    const SHOWN: usize = 5;
    let skipped = &packing.source.skipped;
    if skipped.count == 0 {
        return;
    }
    let noun = if skipped.count == 1 { "line" } else { "lines" };
    let mut text = vec![format!("warning: {name}: skipped {} bad {noun}", skipped.count)];
    let shown = skipped.first.iter().take(SHOWN);
    text.extend(shown.map(|bad| format!("  {name}:{}: {}: {}", bad.line, bad.problem, bad.text)));
    if skipped.count > SHOWN as u64 {
        text.push(format!("  and {} more", skipped.count - SHOWN as u64));
    }
    // Nothing is left to do if even the warning cannot be printed; the count is in the JSON summary too.
    let _ = writeln!(io::stderr(), "{}", text.join("\n"));
}

/// An option on the command line wins over the file.
fn sizes<'a>(arguments: &ContactsArguments, name: &str, packing: &'a Packing) -> Result<Sizes<'a>, Failure> {
    match (arguments.radius, arguments.cutoff, &packing.radii) {
        (Some(radius), ..) => Ok(Sizes::All(radius)),
        (_, Some(cutoff), _) => Ok(Sizes::Cutoff(cutoff)),
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

/// The library's refusals in the words of the command: elements by id or row, options by name.
fn refused(name: &str, packing: &Packing, refusal: &Refusal) -> Failure {
    let element = |index: usize| match &packing.ids {
        Some(ids) => format!("element {}", ids[index]),
        None => format!("element {index} (counted from 0)"),
    };
    match refusal {
        Refusal::Elements(Error::DomainTooWide {
            axis, width, cell_size, element: index, position, ..
        }) => {
            let axis = ["x", "y", "z"][*axis];
            Failure::Unusable(format!(
                "{name}: the domain is {width:e} wide along {axis}, {cells:.1e} cells of {cell_size:e}: too many for \
                 the lists of this engine. It is stretched by {element} at {axis} = {position:e}. Remove that element, \
                 or take --engine rows, whose memory does not depend on the domain",
                cells = width / cell_size,
                element = element(*index),
            ))
        }
        Refusal::Elements(error) => Failure::Unusable(format!("{name}: {error}")),
        Refusal::Mismatch(mismatch) => Failure::Wrong(format!(
            "{name}: --verify: {mismatch} (counted from 0). This is a bug in fdem: please report it with the file. \
             Nothing was written"
        )),
    }
}

impl<const D: usize> Found<D> {
    /// The couple with the largest overlap as it is written.
    pub(crate) fn max_overlap_ids(&self, packing: &Packing) -> Option<(f64, [i64; 2])> {
        let (overlap, couple) = self.statistics.max_overlap?;
        let id = |element: u32| packing.ids.as_ref().map_or(i64::from(element), |ids| ids[element as usize]);
        Some((overlap, [id(couple.i), id(couple.j)]))
    }
}
