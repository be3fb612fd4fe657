//! Options of the commands that simulate.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use fdem_results::Field;

use crate::command::args::drawings::drawing;
use crate::command::device_name::DeviceName;
use crate::command::templates::TEMPLATES;
use crate::command::threads;
use fdem_model::{Setting, library};

/// Largest number of runs of a sweep, unless another is given.
pub(crate) const MOST_RUNS: usize = 1000;

/// Write a model file to start from, with a comment on every part.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  fdem new disc.toml && fdem check disc.toml\n  fdem new beam.toml --template three_point_bending"
)]
pub(crate) struct NewArguments {
    /// Name of the new file.
    #[arg(value_name = "NAME", default_value = "model.toml")]
    pub(crate) name: PathBuf,

    /// A model in three dimensions; with --template the one of this name in space.
    #[arg(long = "3d")]
    pub(crate) space: bool,

    /// Name of the model to write; --list lists all names.
    #[arg(short, long, value_name = "TEMPLATE", value_parser = templates(), hide_possible_values = true)]
    pub(crate) template: Option<String>,

    /// List the templates and write nothing.
    #[arg(long, conflicts_with_all = ["name", "space", "template", "force"])]
    pub(crate) list: bool,

    /// Replace an existing file.
    #[arg(long)]
    pub(crate) force: bool,
}

/// List the materials that `library = "…"` in a `[[material]]` of a model gives, with their figures and
/// sources.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  fdem materials\n  fdem materials granite >> model.toml")]
pub(crate) struct MaterialsArguments {
    /// Print this material as a table of a model file, to be changed.
    #[arg(value_name = "NAME", value_parser = materials())]
    pub(crate) name: Option<String>,
}

/// Check a model without running it: print all errors of the file, or else its mesh, time step, run time,
/// memory, and warnings.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  fdem check model.toml --picture model.png\n  fdem check model.toml --ranks 64\n  fdem check model.toml --device gpu"
)]
pub(crate) struct CheckArguments {
    /// The model, a TOML file. Paths of meshes and packings in it are relative to its folder.
    #[arg(value_name = "MODEL", required_unless_present = "schema")]
    pub(crate) model: Option<PathBuf>,

    /// Print the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,

    /// Set a parameter of the model, or a key by its path: `--set strength="8 MPa"`,
    /// `--set material.rock.friction=0.4`. May come several times.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    pub(crate) set: Vec<(String, Setting)>,

    /// Also predict how a run would be divided among RANKS processes: elements, halos, messages, memory, and
    /// the time of a step on an assumed network.
    #[arg(long, value_name = "RANKS", allow_negative_numbers = true, value_parser = ranks)]
    pub(crate) ranks: Option<usize>,

    /// Also estimate a run on a graphics processor, `gpu` or `gpu:N` with a number of `fdem devices`: its
    /// memory there, whether it fits, and a guess of its time. Without such a card there is all but the fit.
    #[arg(long, value_name = "DEVICE", default_value = "cpu", conflicts_with = "ranks")]
    pub(crate) device: DeviceName,

    /// Also draw the model: bodies by colour, joint sets, boundaries and histories at points, with a legend
    /// that names them and lists the stages. Nothing is simulated.
    #[arg(long, value_name = "FILE.svg|FILE.png", value_parser = drawing)]
    pub(crate) picture: Option<PathBuf>,

    /// Width of a PNG picture in pixels [default: twice the width of an SVG].
    #[arg(long, value_name = "PIXELS", requires = "picture", value_parser = clap::value_parser!(u32).range(200..=10_000))]
    pub(crate) picture_width: Option<u32>,

    /// Print the JSON schema of model files, for editors: keys, descriptions, types, ranges, defaults.
    #[arg(long, conflicts_with_all = ["model", "json", "ranks", "device", "set", "picture"])]
    pub(crate) schema: bool,
}

/// Simulate a model: bodies that deform, collide and break. Results are written during the run.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  fdem run examples/brazilian_disc.toml --threads 2\n  fdem run load.toml --from settle_results"
)]
pub(crate) struct RunArguments {
    /// The model, a TOML file. Paths of meshes and packings in it are relative to its folder.
    #[arg(value_name = "MODEL")]
    pub(crate) model: PathBuf,

    /// Folder for the results [default: the name of the model with `_results`, in the working directory].
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,

    /// Begin with the state at the end of another run, by its folder. Bodies of the same name have the same
    /// mesh; materials, loads and stages may differ, and bodies may be missing or new. Time continues.
    #[arg(long, value_name = "DIR")]
    pub(crate) from: Option<PathBuf>,

    /// Replace the results of an earlier run in the folder.
    #[arg(long)]
    pub(crate) force: bool,

    /// Set a parameter of the model, or a key by its path: `--set strength="8 MPa"`,
    /// `--set material.rock.friction=0.4`. May come several times. The folder keeps the changed model.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    pub(crate) set: Vec<(String, Setting)>,

    #[command(flatten)]
    pub(crate) options: RunOptions,
}

/// Continue an interrupted run from its last checkpoint, or a finished run to a later end time.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem resume brazilian_disc_results")]
pub(crate) struct ResumeArguments {
    /// The folder with the results of the run.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// New end time of the run, s. It replaces `end_time` in the model.toml of the folder; frames and rows of
    /// the history keep their spacing.
    #[arg(long, visible_alias = "until", value_name = "SECONDS", value_parser = positive)]
    pub(crate) end_time: Option<f64>,

    #[command(flatten)]
    pub(crate) options: RunOptions,
}

/// Options of a simulation.
#[derive(Debug, Args)]
#[expect(clippy::option_option, reason = "so clap has options whose value may be left out")]
pub(crate) struct RunOptions {
    /// Number of threads; 0 is one per processor, and on ranks under `mpirun` one thread for each rank.
    /// Results do not depend on it.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = threads)]
    pub(crate) threads: usize,

    /// Where elements, joints and nodes are computed: `cpu`, `gpu`, or `gpu:N` with a number of
    /// `fdem devices`. Results are the same to the last bit. Contacts, loads, rigid bodies and the insertion
    /// of joints stay on the processor.
    #[arg(long, value_name = "DEVICE", default_value = "cpu")]
    pub(crate) device: DeviceName,

    /// Write animation.gif at the end, as with `animate` in the model. Without FIELD, it shows the first
    /// field of the model.
    #[arg(long, value_name = "FIELD", num_args = 0..=1, require_equals = true, value_parser = fields())]
    pub(crate) animate: Option<Option<Field>>,

    /// Show no progress.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Run a model many times with other values of its parameters: all combinations, rows of a table, or a Latin
/// hypercube. All models are checked before the first run. The same command continues an interrupted sweep.
///
/// The sweep file, in TOML, has `model = "disc.toml"`, and one of `[grid]`, `[[run]]`, `table = "values.csv"`
/// and `[latin_hypercube]`, whose names are parameters of the model, or paths of keys such as
/// `material.rock.cohesion`. It may have `folder`, `processes` and `threads`.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem sweep sweep.toml --processes 4")]
pub(crate) struct SweepArguments {
    /// The sweep, a TOML file. The model that it names is relative to its folder.
    #[arg(value_name = "SWEEP")]
    pub(crate) sweep: PathBuf,

    /// Folder for the results [default: `folder` of the sweep file, or its name with `_results`, in the
    /// working directory].
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,

    /// Number of simultaneous runs [default: `processes` of the sweep file, or the number of processors].
    /// Results do not depend on it.
    #[arg(short, long, value_name = "N", allow_negative_numbers = true, value_parser = at_once)]
    pub(crate) processes: Option<usize>,

    /// Number of threads of each run [default: `threads` of the sweep file, or 1]. Results do not depend on
    /// it.
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = threads)]
    pub(crate) threads: Option<usize>,

    /// Largest number of runs.
    #[arg(long, value_name = "N", default_value_t = MOST_RUNS)]
    pub(crate) max_runs: usize,

    /// Replace the runs of another sweep in the folder.
    #[arg(long)]
    pub(crate) force: bool,

    /// If the models of some runs are refused, note it in the table and run the others.
    #[arg(long)]
    pub(crate) skip_refused: bool,

    /// Show no progress.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Run the verification ladder, which compares simulations with known solutions. Exit code 1 if a case fails.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem validate 1 4 --html ladder.html")]
pub(crate) struct ValidateArguments {
    /// Numbers of cases, or words of their names [default: all cases].
    #[arg(value_name = "CASE")]
    pub(crate) cases: Vec<String>,

    /// List the cases and run none.
    #[arg(long, conflicts_with_all = ["cases", "full", "html", "quiet"])]
    pub(crate) list: bool,

    /// Run finer models and more variants, for minutes instead of seconds.
    #[arg(long)]
    pub(crate) full: bool,

    /// Also write the table as an HTML page.
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,

    /// Do not print the time taken so far.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// The fields of results by their keys.
fn fields() -> impl TypedValueParser<Value = Field> {
    let values = Field::ALL.map(|field| PossibleValue::new(field.key()).help(field.name()));
    PossibleValuesParser::new(values).try_map(|key| Field::named(&key).ok_or("there is no such field"))
}

/// The templates by their names; one that is in space only also without the end of its name.
fn templates() -> PossibleValuesParser {
    PossibleValuesParser::new(TEMPLATES.iter().map(|template| {
        let plain = template.name.strip_suffix("_3d");
        let alone = plain.filter(|plain| !TEMPLATES.iter().any(|other| other.name == *plain));
        PossibleValue::new(template.name).aliases(alone)
    }))
}

/// The materials of the library by their names.
fn materials() -> PossibleValuesParser {
    PossibleValuesParser::new(library().iter().map(|material| material.name.as_str()))
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}

/// More ranks than elements are refused when the model is known.
fn ranks(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("a run on 0 ranks computes nothing".to_owned()),
        Ok(count) => Ok(count),
        Err(_) => Err("a whole number above 0 is needed".to_owned()),
    }
}

/// A name and a value with an equals sign between them.
fn setting(text: &str) -> Result<(String, Setting), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() && !value.trim().is_empty() => {
            Ok((name.trim().to_owned(), Setting::parse(value)))
        }
        _ => Err("a name and a value with an equals sign between them are needed".to_owned()),
    }
}

/// More processes than 1024 are hardly meant.
fn at_once(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=1024) => Ok(count),
        _ => Err("a whole number from 1 to 1024 is needed".to_owned()),
    }
}

/// Many more threads than processors slow each other down.
fn threads(text: &str) -> Result<usize, String> {
    let most = threads::most();
    match text.parse() {
        Ok(count) if count <= most => Ok(count),
        _ => Err(format!("a whole number from 0 to {most} is needed: more only wait for the processors")),
    }
}
