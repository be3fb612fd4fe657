//! The models of a sweep, checked before any of them runs.

use std::fmt::Write;
use std::path::Path;

use fdem_io::numbers::grouped;
use fdem_results::HistoryCurve;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::command::failure::{Failure, display_name};
use crate::command::memory;
use crate::command::model_file::{inputs_of, refusal};
use crate::command::progress::Progress;
use crate::command::run::results::Results;
use crate::command::sweep::plan::Plan;
use fdem_model::{AnyPrepared, Drawing, Prepared, Setting, check, prepare_any, with_values};

/// Refused runs that are named; the rest is counted.
const NAMED: usize = 10;

/// A run by its number, and its model, or why it is refused.
pub(crate) type Numbered = (usize, Result<Checked, String>);

/// A model that can run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Checked {
    /// Hash of the model.
    pub(crate) hash: String,
    pub(crate) title: String,
    pub(crate) curves: Vec<HistoryCurve>,
}

/// The models of a sweep.
pub(crate) struct Models<'p> {
    pub(crate) plan: &'p Plan,
    /// The model file and its text.
    pub(crate) path: &'p Path,
    pub(crate) text: &'p str,
}

impl Models<'_> {
    /// Names and values of a run. `number`: from 1.
    pub(crate) fn settings(&self, number: usize) -> Vec<(String, Setting)> {
        self.plan.names.iter().cloned().zip(self.plan.rows[number - 1].iter().cloned()).collect()
    }

    /// The run in words: `run 3 (strength = 8 MPa)`.
    pub(crate) fn name(&self, number: usize) -> String {
        let settings = self.settings(number);
        let values: Vec<String> = settings.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        format!("run {number} ({})", values.join(", "))
    }

    /// Checks the model of a run as `fdem check` does. Also returns the hash of the text and of the files
    /// that it names.
    pub(crate) fn check(&self, number: usize) -> (Result<Checked, String>, String) {
        let mut digest = Sha256::new();
        digest.update(self.text);
        let mut read = inputs_of(self.path);
        let mut load = |file: &str| {
            let bytes = read(file)?;
            digest.update((bytes.len() as u64).to_le_bytes());
            digest.update(&bytes);
            Ok(bytes)
        };
        let name = display_name(self.path);
        let found = with_values(self.text, &mut inputs_of(self.path), &self.settings(number))
            .map_err(|why| format!("{name}: {why}"))
            .and_then(|text| {
                prepare_any(&text, &name, &mut load, memory::free())
                    .map_err(|errors| refusal(&errors, Drawing::Plain))
            })
            .and_then(|prepared| match &prepared {
                AnyPrepared::Plane(prepared) => checked(prepared, &name),
                AnyPrepared::Space(prepared) => checked(prepared, &name),
            });
        (found, format!("{:x}", digest.finalize()))
    }

    /// Checks the models of several runs, several at a time.
    ///
    /// # Errors
    /// Threads that cannot be had.
    pub(crate) fn check_all(
        &self,
        numbers: Vec<usize>,
        processes: usize,
        progress: &Progress,
    ) -> Result<Vec<Numbered>, Failure> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(processes).build();
        let pool = pool.map_err(|error| Failure::Unusable(format!("cannot start threads: {error}")))?;
        let total = numbers.len() as u64;
        let (found, _) = progress.step("checking the models of all runs", Some(total), |done| {
            let one = |number: usize| {
                let (found, _) = self.check(number);
                done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                (number, found)
            };
            pool.install(|| numbers.into_par_iter().map(one).collect())
        });
        Ok(found)
    }

    /// The failure of a sweep of which some models are refused: the first in full, the others by name.
    pub(crate) fn refused(&self, refused: &[(usize, String)]) -> Failure {
        let Some(((first, why), others)) = refused.split_first() else {
            return Failure::Unusable("no model is refused".to_owned());
        };
        let of = self.plan.rows.len();
        let mut text = format!("{} of {} is refused: {why}", self.name(*first), grouped(of as u64));
        for (number, why) in others.iter().take(NAMED) {
            // Writing to a string does not fail.
            let _ = write!(text, "\n\n{} is refused: {}", self.name(*number), brief(why));
        }
        if let Some(more) = others.len().checked_sub(NAMED).filter(|more| *more > 0) {
            let _ = write!(text, "\n\nand {} more", grouped(more as u64));
        }
        Failure::Unusable(format!("{text}\n\nnothing has run; --skip-refused runs the others"))
    }
}

fn checked<const D: usize, const N: usize>(prepared: &Prepared<D, N>, name: &str) -> Result<Checked, String>
where
    [[f64; D]; N]: Results<D, N>,
    fdem_simulation::Model<D, N>: Serialize,
{
    check(prepared).map_err(|why| format!("{name} cannot run: {why}"))?;
    Ok(Checked {
        hash: prepared.hash.clone(),
        title: prepared.title.clone(),
        curves: prepared.curves.clone(),
    })
}

/// The message of a refusal on one line: its first error.
pub(crate) fn brief(why: &str) -> String {
    let error = why.lines().find_map(|line| line.strip_prefix("error: "));
    error.or_else(|| why.lines().next()).unwrap_or_default().to_owned()
}
