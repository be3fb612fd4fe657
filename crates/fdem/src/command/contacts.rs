//! `fdem contacts` reads a packing, finds its couples, writes them and shows a summary.

use std::fmt;
use std::io::{self, Write};

use fdem_io::Centres;
use fdem_results::network::{Network, Space};
use serde::Serialize;

use crate::command::analyse;
use crate::command::args::ContactsArguments;
use crate::command::detect::{Request, check, detect};
use crate::command::drawings::Drawings;
use crate::command::explain::Told;
use crate::command::failure::Failure;
use crate::command::frames::Selection;
use crate::command::input::{self, Input, refused, sizes};
use crate::command::labels;
use crate::command::meshes;
use crate::command::output::{Output, TABLES, TableFormat, Written, is_stdout, refuse_to_overwrite};
use crate::command::periodic::{periodic_box, takes_file_box};
use crate::command::progress::Progress;
use crate::command::series::{self, SeriesTable};
use crate::command::summary::{Seconds, Summary};
use crate::command::tables::write_network;

pub(crate) fn run(arguments: &ContactsArguments) -> Result<(), Failure> {
    if arguments.labels.labels {
        return labels::run(arguments);
    }
    let inputs = || std::iter::once(&arguments.input.file).chain(&arguments.more);
    if inputs().filter(|file| is_stdout(file)).count() > 1 {
        return Err(Failure::Unusable("standard input can only be read once".to_owned()));
    }
    for input in inputs() {
        let mut files = vec![
            ("the input", Some(input)),
            ("--output", arguments.output.as_ref()),
            ("--json", arguments.json.as_ref()),
        ];
        files.extend(arguments.drawings.files());
        files.push(("--body-table", arguments.meshes.body_table.as_ref()));
        refuse_to_overwrite(&files)?;
    }
    let progress = Progress::new(arguments.quiet);
    let outputs = Outputs::open(arguments)?;

    let opened = input::open(&arguments.input.file, arguments.input.format, &progress)?;
    if opened.is_mesh() || !arguments.more.is_empty() {
        return meshes::run(arguments, opened, &progress, outputs);
    }
    let only_of_meshes = [
        ("--body-table", arguments.meshes.body_table.is_some()),
        ("--self-contact", arguments.meshes.self_contact),
    ];
    if let Some((option, _)) = only_of_meshes.into_iter().find(|(_, given)| *given) {
        return Err(Failure::Unusable(format!("{}: {option} is for meshes, this is a packing", opened.name)));
    }
    let frames = opened.series()?;
    let frame = match opened.select(&frames, arguments.input.frames)? {
        Selection::One(frame) => frame,
        Selection::Series(chosen) => {
            drop(outputs);
            return series::run(arguments, &opened, &frames, &chosen, &progress);
        }
    };
    let named;
    let (arguments, mut outputs) = if series::names_frames(arguments) {
        drop(outputs);
        named = series::of_frame(arguments, frame)?;
        (&named, Outputs::open(&named)?)
    } else {
        (arguments, outputs)
    };
    let mut input = opened.frame(&frames, frame, &arguments.input, arguments.bodies.as_deref(), &progress)?;
    input.seconds += opened.seconds;
    let of_several = frames.frames() > 1;
    drop(opened);

    if arguments.explain {
        return explain(arguments, &input, outputs);
    }
    let mut summary = treat(arguments, &progress, &input, &mut outputs)?;

    summary.frame = of_several.then_some(frame);
    // The summary is the last output, because it has the times of the others.
    summary.measure_peak();
    outputs.finish(&summary, arguments.quiet)
}

/// Finds the contacts of a packing and writes them.
pub(crate) fn treat(
    arguments: &ContactsArguments,
    progress: &Progress,
    input: &Input,
    outputs: &mut Outputs,
) -> Result<Summary, Failure> {
    arguments.drawings.check(input.packing.centres.len(), &input.name)?;
    match &input.packing.centres {
        Centres::Two(centres) => find(arguments, progress, input, centres, outputs),
        Centres::Three(centres) => find(arguments, progress, input, centres, outputs),
    }
}

/// Writes an estimate of the cost of the search, in place of the couples.
fn explain(arguments: &ContactsArguments, input: &Input, mut outputs: Outputs) -> Result<(), Failure> {
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
) -> Result<Told, Failure> {
    let Input { name, packing, bodies, .. } = input;
    let space = Space { centres, cell: periodic_box(&arguments.periodic, input)? };
    let bodies = bodies.as_ref().map(|bodies| bodies.count);
    Told::of(&space, &request(arguments, input)?, bodies).map_err(|error| refused(name, packing, &error))
}

fn request<'a>(arguments: &ContactsArguments, input: &'a Input) -> Result<Request<'a>, Failure> {
    Ok(Request {
        sizes: sizes(&arguments.input, &input.name, &input.packing)?,
        tolerance: arguments.input.tolerance,
        bodies: input.bodies.as_ref().map(|bodies| bodies.numbers.as_slice()),
        engine: arguments.engine.engine(),
        threads: arguments.threads,
        keep: !arguments.count
            || arguments.drawings.any()
            || arguments.verify.is_some()
            || arguments.analysis.analyse,
    })
}

/// Finds the couples, verifies and analyses them as asked for, and writes all outputs except the summary.
fn find<const D: usize>(
    arguments: &ContactsArguments,
    progress: &Progress,
    input: &Input,
    centres: &[[f64; D]],
    outputs: &mut Outputs,
) -> Result<Summary, Failure> {
    let Input { name, packing, .. } = input;
    let mut seconds = Seconds { read: input.seconds, ..Seconds::default() };
    let request = request(arguments, input)?;
    let space = Space { centres, cell: periodic_box(&arguments.periodic, input)? };
    let (found, detection) =
        progress.step("detecting, couples", None, |position| detect(&space, &request, position));
    seconds.detect = detection;
    let found = found.map_err(|error| refused(name, packing, &error))?;

    let mut verified = None;
    if let Some(sample) = arguments.verify {
        let (checked, verification) =
            progress.step("verifying", None, |_| check(&space, &request, &found.couples, sample));
        seconds.verify = Some(verification);
        verified = Some(checked.map_err(|mismatch| wrong(name, &mismatch))?);
    }

    let network = Network { space, sizes: request.sizes, couples: &found.couples };
    let (analysis, analysing) =
        progress.step("analysing", None, |_| analyse::run(&arguments.analysis, &network, name));
    let analysis = analysis?;
    seconds.analyse = analysis.is_some().then_some(analysing);

    let total = found.couples.len() as u64;
    let (written, writing) = progress.step("writing", Some(total), |position| {
        if arguments.count {
            return outputs.count(found.statistics.couples);
        }
        match (&mut outputs.series, &mut outputs.couples) {
            (Some(series), _) => series.write(packing, &network, position),
            (None, Some(couples)) => write_network(couples, outputs.table, packing, &network, position),
            (None, None) => Ok(()),
        }
    });
    written?;
    seconds.write = writing;
    let of_file = takes_file_box(&arguments.periodic);
    let summary =
        Summary::new(input, &space, of_file, &request, &found, verified, seconds).with_analysis(analysis);
    let (drawn, _) =
        progress.step("drawing", None, |_| outputs.drawings.write(input, &network, || summary.to_string()));
    drawn.map(|()| summary)
}

/// The files that the command writes. All appear together at the end.
pub(crate) struct Outputs {
    /// The table of all frames of a series, in place of `couples`.
    pub(crate) series: Option<SeriesTable>,
    pub(crate) table: TableFormat,
    /// `None` if only drawings are asked for.
    pub(crate) couples: Option<Output>,
    pub(crate) json: Option<Output>,
    pub(crate) drawings: Drawings,
    /// Table of the bodies that touch, for meshes.
    pub(crate) bodies: Option<(TableFormat, Output)>,
}

impl Outputs {
    pub(crate) fn open(arguments: &ContactsArguments) -> Result<Self, Failure> {
        let output = arguments.output.as_deref();
        let optional = |path: &Option<_>| path.as_deref().map(|path| Output::open(Some(path))).transpose();
        Ok(Self {
            series: None,
            table: TableFormat::of(output)?,
            couples: match output {
                None if !arguments.writes_couples() && !arguments.count => None,
                output => Some(Output::open(output)?),
            },
            json: optional(&arguments.json)?,
            drawings: Drawings::open(&arguments.drawings)?,
            bodies: match &arguments.meshes.body_table {
                Some(path) => Some((TableFormat::among(&TABLES, Some(path))?, Output::open(Some(path))?)),
                None => None,
            },
        })
    }

    /// Writes the number of couples in place of the couples.
    pub(crate) fn count(&mut self, couples: u64) -> Result<(), Failure> {
        self.couples.as_mut().map_or(Ok(()), |output| output.write(|out| writeln!(out, "{couples}")))
    }

    /// Writes the summary as JSON, puts all files in place, and shows the summary with their names.
    pub(crate) fn finish(
        mut self,
        summary: &(impl Serialize + fmt::Display),
        quiet: bool,
    ) -> Result<(), Failure> {
        self.tell(summary)?;
        let files = self.all();
        let names: Vec<_> = files.iter().filter_map(Output::file_name).collect();
        files.into_iter().try_for_each(Output::commit)?;
        if !quiet {
            show(summary, &names);
        }
        Ok(())
    }

    /// Writes the summary as JSON.
    pub(crate) fn tell(&mut self, summary: &impl Serialize) -> Result<(), Failure> {
        let Some(json) = &mut self.json else { return Ok(()) };
        json.write(|out| {
            serde_json::to_writer_pretty(&mut *out, summary)?;
            out.write_all(b"\n")
        })
    }

    /// Closes all files. They appear at [`Written::commit`].
    pub(crate) fn close(self) -> Result<Vec<Written>, Failure> {
        self.all().into_iter().map(Output::close).collect()
    }

    fn commit(self) -> Result<(), Failure> {
        self.all().into_iter().try_for_each(Output::commit)
    }

    /// Returns all outputs. The summary as JSON comes last, because it has the times of the others.
    fn all(self) -> Vec<Output> {
        let bodies = self.bodies.map(|(_, output)| output);
        self.couples.into_iter().chain(bodies).chain(self.drawings.outputs()).chain(self.json).collect()
    }
}

/// Shows a summary, and the names of the files that were written, on standard error.
pub(crate) fn show(summary: &impl fmt::Display, files: &[String]) {
    let mut text = summary.to_string();
    for (k, file) in files.iter().enumerate() {
        let label = if k == 0 { "written" } else { "" };
        text.extend([&format!("{label:<16} {file}"), "\n"]);
    }
    // A summary that cannot be shown is not an error.
    let _ = io::stderr().write_all(text.as_bytes());
}

pub(crate) fn wrong(name: &str, mismatch: &str) -> Failure {
    Failure::Wrong(format!(
        "{name}: --verify: {mismatch} (numbered in the order of the file, from 0). This is a bug in fdem: please report it with \
         the file. Nothing was written"
    ))
}
