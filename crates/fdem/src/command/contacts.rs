//! `fdem contacts`: read, detect, write, report.

use std::io::{self, Write};
use std::sync::atomic::Ordering;

use fdem_contact::{Couple, Mismatch};
use fdem_io::{Centres, CoupleRow, Packing};

use crate::command::args::ContactsArguments;
use crate::command::detect::{Request, Sizes, check, detect, distance};
use crate::command::failure::Failure;
use crate::command::input::{self, Input, id, refused, sizes};
use crate::command::output::{Output, Table, refuse_to_overwrite};
use crate::command::picture;
use crate::command::progress::Progress;
use crate::command::summary::{Seconds, Summary};

pub(crate) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    refuse_to_overwrite(&[
        ("the input", Some(&arguments.input.file)),
        ("--output", arguments.output.as_ref()),
        ("--json", arguments.json.as_ref()),
        ("--picture", arguments.picture.as_ref()),
    ])?;
    let progress = Progress::new(arguments.quiet);
    let mut outputs = Outputs::open(arguments)?;

    let Input { name, packing, seconds } = input::read(&arguments.input, &progress)?;
    if arguments.picture.is_some() {
        picture::check(packing.centres.len(), &name)?;
    }

    let seconds = Seconds { read: seconds, ..Seconds::default() };
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
    let sizes = sizes(&arguments.input, name, packing)?;
    let request = Request {
        sizes,
        tolerance: arguments.input.tolerance,
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

fn wrong(name: &str, mismatch: &Mismatch) -> Failure {
    Failure::Wrong(format!(
        "{name}: --verify: {mismatch} (in the order of the file, from 0). This is a bug in fdem: please report it with \
         the file. Nothing was written"
    ))
}
