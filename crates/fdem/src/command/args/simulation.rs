//! Options of the commands that simulate.

use std::path::PathBuf;

use clap::Args;

use crate::results::Field;

/// Write a model to start from, with a word on every part.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem new disc.toml && fdem check disc.toml")]
pub(crate) struct NewArguments {
    /// Name of the new file.
    #[arg(value_name = "NAME", default_value = "model.toml")]
    pub(crate) name: PathBuf,

    /// Replace a file that is there already.
    #[arg(long)]
    pub(crate) force: bool,
}

/// Check a model without running it: everything that is wrong with the file, else its mesh, time step, run time, memory, and warnings.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem check model.toml")]
pub(crate) struct CheckArguments {
    /// The model, a TOML file. Meshes and packings that it names are looked for beside it.
    #[arg(value_name = "MODEL", required_unless_present = "schema")]
    pub(crate) model: Option<PathBuf>,

    /// Print the preflight as JSON.
    #[arg(long)]
    pub(crate) json: bool,

    /// Print the JSON schema of model files instead, for editors: keys, descriptions, types, ranges, defaults.
    #[arg(long, conflicts_with_all = ["model", "json"])]
    pub(crate) schema: bool,
}

/// Simulate a model: bodies that deform, collide and break. Writes results as it goes.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem run examples/brazilian_disc.toml --threads 2")]
pub(crate) struct RunArguments {
    /// The model, a TOML file. Meshes and packings that it names are looked for beside it.
    #[arg(value_name = "MODEL")]
    pub(crate) model: PathBuf,

    /// Folder for the results [default: the name of the model and `_results`, in the working directory].
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: Option<PathBuf>,

    /// Replace the results of an earlier run in the folder.
    #[arg(long)]
    pub(crate) force: bool,

    #[command(flatten)]
    pub(crate) options: RunOptions,
}

/// Go on with a run that was interrupted, from its last checkpoint, or with one that is finished, to a later end time.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem resume brazilian_disc_results")]
pub(crate) struct ResumeArguments {
    /// The folder of its results.
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,

    /// Make the run end at another time, s. `end_time` in the folder's model.toml is changed; frames and rows of the history keep their spacing.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub(crate) end_time: Option<f64>,

    #[command(flatten)]
    pub(crate) options: RunOptions,
}

/// Options of a simulation.
#[derive(Debug, Args)]
#[expect(clippy::option_option, reason = "so clap has options whose value may be left out")]
pub(crate) struct RunOptions {
    /// Threads; 0: one for each processor. Results are the same for any number.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) threads: usize,

    /// Write animation.gif at the end, as `animate` in the model does; without FIELD of the first field that the model shows.
    #[arg(long, value_name = "FIELD", num_args = 0..=1, require_equals = true)]
    pub(crate) animate: Option<Option<Field>>,

    /// Show no progress.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Run the verification ladder: cases whose answer is known, against what the simulation says. Exit code 1 if one fails.
#[derive(Debug, Args)]
#[command(after_help = "Example: fdem validate 1 4 --html ladder.html")]
pub(crate) struct ValidateArguments {
    /// Numbers of cases, or words of their names; all without any.
    #[arg(value_name = "CASE")]
    pub(crate) cases: Vec<String>,

    /// Finer models and more variants: minutes instead of seconds.
    #[arg(long)]
    pub(crate) full: bool,

    /// Write the table as a page for a browser, too.
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,

    /// Do not tell how long it has taken so far.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err("a number above 0 is needed".to_owned()),
    }
}
