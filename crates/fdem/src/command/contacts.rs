//! `fdem contacts`: read, detect, write, report.

use std::fs;
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::atomic::Ordering;

use fdem_contact::{Couple, Error, Mismatch};
use fdem_io::{Centres, CoupleRow, Format, Packing, ReadError, ReadOptions};

use crate::command::args::ContactsArguments;
use crate::command::detect::{Request, Sizes, check, detect, distance};
use crate::command::failure::{Failure, display_name};
use crate::command::output::{Output, Table, is_stdout, same_file};
use crate::command::picture;
use crate::command::progress::{Position, Progress};
use crate::command::summary::{Seconds, Summary};

pub(crate) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    refuse_to_overwrite(arguments)?;
    let progress = Progress::new(arguments.quiet);
    let mut outputs = Outputs::open(arguments)?;

    let name =
        if is_stdout(&arguments.file) { "standard input".to_owned() } else { display_name(&arguments.file) };
    let (bytes, opening) =
        progress.step("opening, bytes", None, |position| read_bytes(&arguments.file, &name, position));
    let bytes = bytes?;
    let options = ReadOptions {
        columns: arguments.columns.clone(),
        skip_bad_lines: arguments.skip_bad_lines,
        ignore_ids: arguments.ignore_ids,
    };
    let (packing, reading) = progress.step("reading", Some(bytes.len() as u64), |position| {
        fdem_io::read(&bytes, &options, position).map_err(|error| unreadable(&name, &error))
    });
    drop(bytes);
    let packing = packing?;
    report_skipped(&name, &packing);
    if arguments.picture.is_some() {
        picture::check(packing.centres.len(), &name)?;
    }

    let seconds = Seconds { read: opening + reading, ..Seconds::default() };
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
        keep: !arguments.count || arguments.picture.is_some() || arguments.verify.is_some(),
    };
    let (found, detection) =
        progress.step("detecting, couples", None, |position| detect(centres, &request, position));
    seconds.detect = detection;
    let found = found.map_err(|error| refused(name, packing, &error))?;

    let mut verified = None;
    if let Some(sample) = arguments.verify {
        let (checked, verification) =
            progress.step("verifying", None, |_| check(centres, &request, &found.couples, sample));
        seconds.verify = Some(verification);
        verified = Some(checked.map_err(|mismatch| wrong(name, &mismatch))?);
    }

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
        picture.write(|out| picture::draw(out, centres, sizes, &found.couples))?;
    }
    Ok(Summary::new(name, packing, centres, &request, &found, verified, seconds))
}

fn row<const D: usize>(
    packing: &Packing,
    centres: &[[f64; D]],
    sizes: Sizes<'_>,
    couple: Couple,
) -> CoupleRow {
    let distance = distance(centres, couple);
    let overlap = sizes.contact_distance(couple) - distance;
    CoupleRow { i: id(packing, couple.i as usize), j: id(packing, couple.j as usize), distance, overlap }
}

/// What an element is called: its id in the file, or the number of its data row, the first being 0.
pub(crate) fn id(packing: &Packing, index: usize) -> i64 {
    match (&packing.ids, &packing.row_numbers) {
        (Some(ids), _) => ids[index],
        (None, Some(rows)) => rows[index].cast_signed(),
        (None, None) => index.cast_signed() as i64,
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
                return Err(Failure::Unusable(format!("{option} {} is {other} too", display_name(path))));
            }
        }
    }
    Ok(())
}

fn read_bytes(file: &Path, name: &str, position: &Position) -> Result<Vec<u8>, Failure> {
    let failed = |error: io::Error| Failure::reading(name, &error);
    if is_stdout(file) {
        return read_all(io::stdin().lock(), 0, position).map_err(failed);
    }
    if file.is_dir() {
        return Err(Failure::Unusable(format!("cannot read {name}: it is a directory")));
    }
    let input = fs::File::open(file).map_err(failed)?;
    let size = input.metadata().map_or(0, |metadata| metadata.len());
    read_all(input, size, position).map_err(failed)
}

/// Reads to the end, but no further than the first block of what cannot be a packing: `/dev/zero` has no end.
fn read_all(mut input: impl Read, size: u64, position: &Position) -> io::Result<Vec<u8>> {
    const BLOCK: u64 = 1 << 20;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(0)).map_err(|_| io::ErrorKind::OutOfMemory)?;
    loop {
        let read = input.by_ref().take(BLOCK).read_to_end(&mut bytes)?;
        position.store(bytes.len() as u64, Ordering::Relaxed);
        let is_array = bytes.starts_with(b"\x93NUMPY");
        let is_rubbish = bytes.len() as u64 <= BLOCK && !is_array && bytes.contains(&0);
        if read == 0 || is_rubbish {
            return Ok(bytes);
        }
    }
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
    let format = &packing.source.format;
    let mut text =
        vec![format!("warning: {name}: skipped {} bad {}", skipped.count, format.noun(skipped.count))];
    text.extend(skipped.first.iter().take(SHOWN).map(|bad| {
        // Of an array the problem itself names the row.
        let place =
            if matches!(format, Format::Npy { .. }) { String::new() } else { format!("{}:", bad.line) };
        format!("  {name}:{place} {}: {}", bad.problem, bad.text)
    }));
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

/// The library's refusals in the words of the command: elements by their id or row, options by name.
fn refused(name: &str, packing: &Packing, error: &Error) -> Failure {
    let element = |index: usize| match &packing.ids {
        Some(ids) => format!("the element with id {}", ids[index]),
        None => format!("the element of data row {} (counted from 0)", id(packing, index)),
    };
    Failure::Unusable(match error {
        Error::DomainTooWide { axis, width, cell_size, stretched_by: Some((index, position)), .. } => {
            format!(
                "{name}: the domain is {width:e} wide along {axis}, {cells:.1e} cells of {cell_size:e}: too many for the \
             lists of this engine. It is stretched by {element} at {axis} = {position:e}. Remove that element, or take \
             --engine rows, whose memory does not depend on the domain",
                axis = ["x", "y", "z"][*axis],
                cells = width / cell_size,
                element = element(*index),
            )
        }
        Error::OutOfMemory { bytes } => format!(
            "{name}: no memory for {bytes} bytes: the couples do not fit. --count needs no memory for them; a smaller \
             --tolerance, --radius or --cutoff makes fewer"
        ),
        _ => match error.element() {
            Some(index) => format!("{name}: {error} ({} in the file)", element(index)),
            None => format!("{name}: {error}"),
        },
    })
}

fn wrong(name: &str, mismatch: &Mismatch) -> Failure {
    Failure::Wrong(format!(
        "{name}: --verify: {mismatch} (in the order of the file, from 0). This is a bug in fdem: please report it with \
         the file. Nothing was written"
    ))
}
