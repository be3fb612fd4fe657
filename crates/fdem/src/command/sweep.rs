//! `fdem sweep` runs one model many times, with other values of its parameters.
//!
//! Every run is a separate process, `fdem run` or `fdem resume`: one that crashes or takes too much memory
//! ends alone. The table is made from the `run.json` of the runs, so that it does not depend on the order in
//! which they end.

mod check;
mod children;
mod plan;
mod report;
mod store;
mod table;
mod values;

use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::num::NonZero;
use std::path::{Path, PathBuf};

use fdem_io::numbers::grouped;
use fdem_results::History;
use serde_json::{Value, json};

use crate::command::args::{MOST_RUNS_OF_A_SWEEP, SweepArguments};
use crate::command::failure::{Failure, display_name};
use crate::command::model_file::{read_text, refused};
use crate::command::output::{is_device, print};
use crate::command::progress::{Bar, Progress, is_terminal};
use crate::command::run::watch::Watch;
use check::{Checked, Models, Numbered, brief};
use children::Job;
use plan::Plan;
use store::{FolderContent, Store, TABLE};
use table::{RunRow, results};

pub use table::Table;

/// Largest number of runs, unless another is given.
pub const MOST_RUNS: usize = MOST_RUNS_OF_A_SWEEP;

/// The request for a sweep.
#[derive(Debug, Clone)]
pub struct Request {
    /// The sweep file.
    pub text: String,
    /// Name of the file, for messages.
    pub name: String,
    /// Where it is, or would be: the model and the table that it names are beside it.
    pub place: PathBuf,
    /// Folder for the results; `None` for that of the file.
    pub output: Option<PathBuf>,
    /// Number of simultaneous runs; `None` for the number in the file.
    pub processes: Option<usize>,
    /// Threads of each run; `None` for those of the file.
    pub threads: Option<usize>,
    /// Largest number of runs.
    pub most: usize,
    /// Replace another sweep in the folder.
    pub force: bool,
    /// Run the others if some models are refused.
    pub skip_refused: bool,
    /// Show no progress.
    pub quiet: bool,
    /// The `fdem` command: a program and its first arguments.
    pub program: Vec<OsString>,
}

/// A sweep that has ended.
#[derive(Debug, Clone)]
pub struct Swept {
    /// Folder of the sweep.
    pub folder: PathBuf,
    /// Results of the sweep.
    pub table: Table,
    /// Number of runs that have finished.
    pub finished: usize,
    /// The signal that has interrupted it.
    pub signal: Option<i32>,
}

pub(crate) fn run(arguments: &SweepArguments) -> Result<(), Failure> {
    let watch = Watch::new()?;
    let program = std::env::current_exe()
        .map_err(|error| Failure::Unusable(format!("cannot find the program fdem: {error}")))?;
    let request = Request {
        text: read_text(&arguments.sweep)?,
        name: display_name(&arguments.sweep),
        place: arguments.sweep.clone(),
        output: arguments.output.clone(),
        processes: arguments.processes,
        threads: arguments.threads,
        most: arguments.max_runs,
        force: arguments.force,
        skip_refused: arguments.skip_refused,
        quiet: arguments.quiet,
        program: vec![program.into()],
    };
    let done = swept(&request, &mut || watch.begin(), &mut || watch.signal())?;
    let (place, all) = (display_name(&done.folder), done.table.rows.len());
    let count = format!("{} of {} runs have finished", grouped(done.finished as u64), grouped(all as u64));
    match done.signal {
        Some(signal) => Err(Failure::Interrupted {
            message: format!("interrupted: {count}; the same command continues the sweep"),
            signal,
        }),
        None if done.finished < all => Err(Failure::Wrong(format!(
            "{count}; the column \"message\" of {place}/{TABLE} has the reasons of the others"
        ))),
        None => print(&format!("{count}: results are in {place}: report.html for a browser, {TABLE}\n")),
    }
}

/// Runs a sweep. `stop` is called repeatedly and returns a signal that is to end it: the runs then write
/// their checkpoints and end.
///
/// # Errors
/// The message of the command.
pub fn sweep(request: &Request, stop: &mut dyn FnMut() -> Option<i32>) -> Result<Swept, String> {
    swept(request, &mut || {}, stop).map_err(|failure| failure.to_string())
}

/// Runs a sweep. `begins` is called before the first run begins.
fn swept(
    request: &Request,
    begins: &mut dyn FnMut(),
    stop: &mut dyn FnMut() -> Option<i32>,
) -> Result<Swept, Failure> {
    let beside = request.place.parent().unwrap_or(Path::new("")).to_owned();
    let mut load = |file: &str| {
        let path = beside.join(file);
        if is_device(&path) {
            return Err("it is a device or a pipe, not a file".to_owned());
        }
        fs::read(path).map_err(|error| error.to_string())
    };
    let plan = Plan::read(&request.text, &request.name, &mut load, request.most);
    let plan = plan.map_err(|errors| refused(&errors))?;
    let path = beside.join(&plan.model);
    let text = read_text(&path)?;
    let models = Models { plan: &plan, path: &path, text: &text };
    let (processes, threads) = shares(request, &plan);
    let progress = Progress::new(request.quiet);
    let ((first, source), _) = progress.step("checking the model", None, |_| models.check(1));
    let folder = request
        .output
        .clone()
        .or_else(|| plan.folder.as_ref().map(|folder| beside.join(folder)))
        .unwrap_or_else(|| default_folder(&request.place));
    // Nothing is written before all models are checked.
    let earlier = EarlierRuns::of(&folder, plan.rows.len(), request.force);
    let open: Vec<usize> = (2..=plan.rows.len()).filter(|number| !earlier.is_over(*number)).collect();
    let mut found = vec![(1, first)];
    found.extend(models.check_all(open, processes, &progress)?);
    let refused: Vec<(usize, String)> =
        found.iter().filter_map(|(number, found)| Some((*number, found.as_ref().err()?.clone()))).collect();
    if !refused.is_empty() && (!request.skip_refused || refused.len() == plan.rows.len()) {
        return Err(models.refused(&refused));
    }
    let store = Store::open(&folder, &identity(&plan, &source), plan.rows.len(), request.force)?;
    begins();
    let sweep = Sweep { models: &models, store: &store, checked: found, threads };
    let jobs = sweep.jobs();
    let rows = (1..=plan.rows.len()).map(|number| sweep.row(number, "")).collect();
    let mut told = SweepProgress::new(request.quiet, rows, jobs.iter().map(|job| job.number).collect());
    sweep.write_table(&told.rows)?;
    let signal = children::work(&request.program, jobs, processes, stop, &mut |number, said| {
        told.rows[number - 1] = sweep.row(number, said);
        told.tell(&models.name(number), number);
        sweep.write_table(&told.rows)
    })?;
    told.end();
    let table = Table::of(&plan.names, &told.rows);
    let (page, _) = progress.step("drawing the report", None, |_| sweep.page(&told.rows, &table));
    store.write(crate::command::run::folder::REPORT, page.as_bytes())?;
    let finished = told.rows.iter().filter(|row| row.status == "finished").count();
    Ok(Swept { folder, table, finished, signal })
}

/// Number of simultaneous runs, and threads of each.
fn shares(request: &Request, plan: &Plan) -> (usize, usize) {
    let processors = std::thread::available_parallelism().map_or(1, NonZero::get);
    let threads = request.threads.or(plan.threads).unwrap_or(1);
    let each = if threads == 0 { processors } else { threads };
    let processes = request.processes.or(plan.processes).unwrap_or((processors / each).max(1));
    (processes, threads)
}

/// Returns the default folder: the name of the sweep file with `_results` after it, in the working directory.
fn default_folder(sweep: &Path) -> PathBuf {
    let mut name = sweep.file_stem().unwrap_or_default().to_owned();
    name.push("_results");
    PathBuf::from(name)
}

/// Identifies a sweep. `source`: the hash of the model and of the files that it names.
fn identity(plan: &Plan, source: &str) -> Value {
    let row = |row: &Vec<fdem_model::Setting>| row.iter().map(ToString::to_string).collect::<Vec<_>>();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "model_and_files": source,
        "parameters": plan.names,
        "runs": plan.rows.iter().map(row).collect::<Vec<_>>(),
    })
}

/// The runs that a folder holds, before it is known whether they are those of this sweep.
struct EarlierRuns(Option<Store>);

impl EarlierRuns {
    fn of(folder: &Path, runs: usize, force: bool) -> Self {
        Self((!force).then(|| Store::unopened(folder, runs)))
    }

    fn is_over(&self, number: usize) -> bool {
        self.0.as_ref().is_some_and(|store| matches!(store.found(number), FolderContent::Ended(_)))
    }
}

/// A sweep whose models are checked and whose folder is open.
struct Sweep<'s> {
    models: &'s Models<'s>,
    store: &'s Store,
    /// The models that were checked, by the numbers of their runs. Runs that have ended before are not among
    /// them.
    checked: Vec<Numbered>,
    threads: usize,
}

impl Sweep<'_> {
    fn checked(&self, number: usize) -> Option<&Result<Checked, String>> {
        self.checked.iter().find(|(known, _)| *known == number).map(|(_, checked)| checked)
    }

    /// The runs that have to begin or to continue.
    fn jobs(&self) -> Vec<Job> {
        let job = |number: usize| {
            if let Some(Err(_)) = self.checked(number) {
                return None;
            }
            let folder = self.store.run(number);
            let options = ["--quiet".into(), "--threads".into(), self.threads.to_string().into()];
            let mut arguments: Vec<OsString> = Vec::new();
            match self.store.found(number) {
                FolderContent::Ended(_) => return None,
                FolderContent::Interrupted => {
                    arguments.push("resume".into());
                    arguments.extend(options);
                    arguments.extend(["--".into(), folder.into()]);
                }
                found @ (FolderContent::Nothing | FolderContent::Begun) => {
                    arguments.push("run".into());
                    arguments.extend(options);
                    arguments.extend(["--output".into(), folder.into()]);
                    arguments.extend((found == FolderContent::Begun).then(|| "--force".into()));
                    for (name, value) in self.models.settings(number) {
                        arguments.push(format!("--set={name}={value}").into());
                    }
                    arguments.extend(["--".into(), self.models.path.into()]);
                }
            }
            Some(Job { number, arguments })
        };
        (1..=self.models.plan.rows.len()).filter_map(job).collect()
    }

    /// A run as its folder has it. `said`: the messages of its process, if it has ended now.
    fn row(&self, number: usize, said: &str) -> RunRow {
        let json = self.store.summary(number);
        let told = json.as_ref().and_then(|json| json["status"].as_str()).unwrap_or("");
        let said = brief(said.strip_prefix("error: ").unwrap_or(said));
        let other = match (self.checked(number), &json) {
            (Some(Ok(checked)), Some(json)) => {
                json["model_hash"].as_str().is_some_and(|hash| hash != checked.hash)
            }
            _ => false,
        };
        let (status, message) = match (self.checked(number), self.store.found(number)) {
            (Some(Err(why)), _) => ("refused", brief(why)),
            _ if other => ("failed", "the model has changed while the sweep ran".to_owned()),
            (_, FolderContent::Ended(_)) if told == "finished" => ("finished", String::new()),
            (_, FolderContent::Ended(_)) => ("stopped", told.trim_start_matches("stopped: ").to_owned()),
            _ if told == "interrupted" => ("interrupted", String::new()),
            _ if !said.is_empty() => ("failed", said),
            (_, FolderContent::Nothing) => ("waiting", String::new()),
            _ => ("interrupted", String::new()),
        };
        let has_results = matches!(status, "finished" | "stopped" | "interrupted");
        RunRow {
            number,
            values: self.models.plan.rows[number - 1].clone(),
            status,
            message,
            folder: self.store.name(number),
            results: json
                .filter(|_| has_results)
                .map(|json| {
                    let history = self.store.history(number).and_then(|text| History::read(&text).ok());
                    results(&json, history.as_ref())
                })
                .unwrap_or_default(),
        }
    }

    /// The page that compares the runs.
    fn page(&self, rows: &[RunRow], table: &Table) -> String {
        let first = self.checked.iter().find_map(|(_, checked)| checked.as_ref().ok());
        report::page(self.models.path, first, rows, table, self.store)
    }

    fn write_table(&self, rows: &[RunRow]) -> Result<(), Failure> {
        let table = Table::of(&self.models.plan.names, rows);
        let text =
            table.csv().map_err(|error| Failure::Unusable(format!("cannot write {TABLE}: {error}")))?;
        self.store.write(TABLE, &text)
    }
}

/// Rows of the table, and the progress on the terminal.
struct SweepProgress {
    rows: Vec<RunRow>,
    bar: Option<Bar>,
    lines: bool,
    /// Runs that are done now.
    jobs: Vec<usize>,
    done: usize,
}

impl SweepProgress {
    fn new(quiet: bool, rows: Vec<RunRow>, jobs: Vec<usize>) -> Self {
        let bar = (!quiet && is_terminal() && !jobs.is_empty()).then(|| Bar::of_run(jobs.len() as u64, 0));
        let told = Self { rows, bar, lines: !quiet && !is_terminal(), jobs, done: 0 };
        let (all, left) = (told.rows.len() as u64, told.jobs.len());
        let done = told.rows.iter().filter(|row| row.status == "finished").count();
        let before =
            if done > 0 { format!("; {} have finished before", grouped(done as u64)) } else { String::new() };
        told.say(&format!("{} runs, {} to do{before}", grouped(all), grouped(left as u64)));
        told
    }

    fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.print(text),
            None if self.lines => {
                let _ = writeln!(std::io::stderr(), "{text}");
            }
            None => {}
        }
    }

    /// Reports a run that has ended.
    fn tell(&mut self, name: &str, number: usize) {
        self.done += 1;
        let RunRow { status, message, .. } = &self.rows[number - 1];
        let why = if message.is_empty() { String::new() } else { format!(": {message}") };
        self.say(&format!("{name} {status}{why}"));
        let done = self.done as u64;
        if let Some(bar) = &mut self.bar {
            bar.show(done);
        }
    }

    fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish();
        }
    }
}
