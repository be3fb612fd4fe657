//! The contacts of a packing: found, counted, and written.

use std::io::{self, Write};

use fdem_contact::Engine;
use fdem_io::Centres;
use fdem_results::detection::{DetectionRequest, Statistics, check, detect};
use fdem_results::network::{Network, Space};

use crate::command::analyse;
use crate::command::args::ContactsArguments;
use crate::command::couples::{CoupleFile, Joined};
use crate::command::device;
use crate::command::device_name::DeviceName;
use crate::command::explain::Estimate;
use crate::command::failure::Failure;
use crate::command::input::{Input, id, refused, sizes};
use crate::command::outputs::Outputs;
use crate::command::periodic::{periodic_box, takes_file_box};
use crate::command::progress::Progress;
use crate::command::summary::{Seconds, Summary, grouped};
use crate::command::tables::write_network;

/// Finds the contacts of a packing, or takes them from a file of couples, and writes them.
pub(crate) fn treat(
    arguments: &ContactsArguments,
    progress: &Progress,
    input: &Input,
    file: Option<&CoupleFile>,
    outputs: &mut Outputs,
) -> Result<Summary, Failure> {
    match &input.packing.centres {
        Centres::Two(centres) => find(arguments, progress, input, file, centres, outputs),
        Centres::Three(centres) => find(arguments, progress, input, file, centres, outputs),
    }
}

/// Writes an estimate of the cost of the search, in place of the couples.
pub(crate) fn explain(
    arguments: &ContactsArguments,
    input: &Input,
    mut outputs: Outputs,
) -> Result<(), Failure> {
    let told = match &input.packing.centres {
        Centres::Two(centres) => told(arguments, input, centres),
        Centres::Three(centres) => told(arguments, input, centres),
    }?;
    if let Some(out) = &mut outputs.couples {
        out.write(|out| out.write_all(told.text().as_bytes()))?;
    }
    if let Some(json) = &mut outputs.json {
        json.write(|out| {
            serde_json::to_writer_pretty(&mut *out, &told)?;
            out.write_all(b"\n")
        })?;
    }
    outputs.commit()
}

fn told<const D: usize>(
    arguments: &ContactsArguments,
    input: &Input,
    centres: &[[f64; D]],
) -> Result<Estimate, Failure> {
    let Input { name, packing, bodies, .. } = input;
    let space =
        Space { centres, cell: periodic_box(&arguments.periodic, &input.name, input.packing.cell.as_ref())? };
    let bodies = bodies.as_ref().map(|bodies| bodies.count);
    Estimate::of(&space, &request(arguments, input)?, bodies).map_err(|error| refused(name, packing, &error))
}

fn request<'a>(arguments: &ContactsArguments, input: &'a Input) -> Result<DetectionRequest<'a>, Failure> {
    Ok(DetectionRequest {
        sizes: sizes(&arguments.input, input)?,
        tolerance: arguments.input.tolerance,
        bodies: input.bodies.as_ref().map(|bodies| bodies.numbers.as_slice()),
        engine: engine_of(arguments),
        device: None,
        threads: arguments.threads,
        keep: !arguments.count
            || arguments.drawings.any()
            || arguments.verify.is_some()
            || arguments.analysis.analyse,
    })
}

/// The engine; a device has but one.
fn engine_of(arguments: &ContactsArguments) -> Option<Engine> {
    match arguments.device {
        DeviceName::Cpu => arguments.engine.engine(),
        DeviceName::Gpu(_) => Some(Engine::Rows),
    }
}

/// Notes elements that are listed together with a periodic image of themselves, even with `--quiet`.
fn note_repeated<const D: usize>(input: &Input, statistics: &Statistics<D>) {
    let Some(couple) = statistics.first_repeated else { return };
    let [i, j] = [couple.i, couple.j].map(|k| id(&input.packing, k as usize));
    let others = if statistics.repeated > 1 {
        format!(", and so do {} more pairs", grouped(statistics.repeated - 1))
    } else {
        String::new()
    };
    // Nothing can be done if it cannot be printed. The count is in the JSON summary too.
    let _ = writeln!(
        io::stderr(),
        "note: {}: elements {i} and {j} have the same place in the periodic box, {:?} edges apart{others}. If the file \
         lists elements together with their periodic images, remove the images: the search finds them itself",
        input.name,
        couple.shift,
    );
}

/// Finds the couples, verifies and analyses them as requested, and writes all outputs except the summary.
fn find<const D: usize>(
    arguments: &ContactsArguments,
    progress: &Progress,
    input: &Input,
    file: Option<&CoupleFile>,
    centres: &[[f64; D]],
    outputs: &mut Outputs,
) -> Result<Summary, Failure> {
    let Input { name, packing, .. } = input;
    let read = input.seconds + file.map_or(0.0, |file| file.seconds);
    let mut seconds = Seconds { read, ..Seconds::default() };
    let device = device::of(arguments)?;
    let request = DetectionRequest { device: device.as_deref(), ..request(arguments, input)? };
    let space =
        Space { centres, cell: periodic_box(&arguments.periodic, &input.name, input.packing.cell.as_ref())? };
    let (found, detection) = progress.step("detecting, couples", None, |position| match file {
        Some(file) => file.join(input, &space, &request),
        None => detect(&space, &request, position)
            .map(|detection| Joined { detection, columns: Vec::new(), forces: None })
            .map_err(|error| refused(name, packing, &error)),
    });
    seconds.detect = detection;
    let Joined { detection: found, columns, forces } = found?;
    note_repeated(input, &found.statistics);

    let mut verified = None;
    if let Some(sample) = arguments.verify {
        let (checked, verification) =
            progress.step("verifying", None, |_| check(&space, &request, &found.couples, sample));
        seconds.verify = Some(verification);
        verified = Some(checked.map_err(|mismatch| Failure::of_couples(name, &mismatch))?);
    }

    let network = Network { space, sizes: request.sizes, couples: &found.couples, forces: forces.as_deref() };
    let (analysis, analysing) = progress.step("analysing, couples", None, |position| {
        analyse::run(&arguments.analysis, arguments.threads, &network, name, position)
    });
    let analysis = analysis?;
    seconds.analyse = analysis.is_some().then_some(analysing);

    let total = found.couples.len() as u64;
    let (written, writing) = progress.step("writing", Some(total), |position| {
        if arguments.count {
            return outputs.count(found.statistics.couples);
        }
        match (&mut outputs.series, &mut outputs.couples) {
            (Some(series), _) => series.write(packing, &network, position),
            (None, Some(couples)) => {
                write_network(couples, outputs.table, packing, &network, &columns, position)
            }
            (None, None) => Ok(()),
        }
    });
    written?;
    seconds.write = writing;
    let of_file = takes_file_box(&arguments.periodic);
    let summary = Summary::new(input, &space, of_file, &request, &found, verified, seconds)
        .with_analysis(analysis)
        .with_cutoffs(arguments.pairs());
    let summary = match file {
        Some(file) => summary.with_couples_of(&file.name),
        None => summary,
    };
    let (drawn, _) =
        progress.step("drawing", None, |_| outputs.drawings.write(input, &network, || summary.to_string()));
    drawn.map(|()| summary)
}
