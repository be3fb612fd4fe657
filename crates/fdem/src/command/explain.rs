//! `fdem contacts --explain` estimates the cost of a search and writes no couples. For levels, the work is
//! also counted.

use std::fmt::Write;

use fdem_contact::{Detector, Engine, Error, Explanation, Level, Multilevel, PeriodicSearch, Work};
use fdem_results::detection::DetectionRequest;
use fdem_results::network::Space;
use serde::Serialize;

/// The estimate, written as JSON by `--json` and as text to standard output.
#[derive(Debug, Serialize)]
pub(crate) struct Estimate {
    elements: usize,
    /// Number of bodies. Elements of the same body form no couple.
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<usize>,
    /// Number of images, in a periodic box only.
    #[serde(skip_serializing_if = "Option::is_none")]
    images: Option<usize>,
    engine: &'static str,
    reason: String,
    cell_size: Option<f64>,
    cells: Option<Vec<u64>>,
    /// Levels of the engines multilevel and cgrid.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    levels: Vec<ToldLevel>,
    /// Predicted and counted work in each level and between each two levels. Empty in a periodic box.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    work: Vec<ToldWork>,
    rows: Option<f64>,
    occupied_rows_at_most: Option<u64>,
    expected_couples: f64,
    expected_couples_error: f64,
    engine_bytes: usize,
    list_bytes: f64,
    threads: usize,
    simd: Option<&'static str>,
    #[serde(skip)]
    text: String,
}

#[derive(Debug, Serialize)]
struct ToldLevel {
    elements: usize,
    smallest: f64,
    largest: f64,
    cell_size: f64,
}

impl From<&Level> for ToldLevel {
    fn from(level: &Level) -> Self {
        let &Level { elements, smallest, largest, cell_size, .. } = level;
        Self { elements, smallest, largest, cell_size }
    }
}

#[derive(Debug, Serialize)]
struct ToldWork {
    levels: [usize; 2],
    predicted_windows: f64,
    windows: u64,
    predicted_candidates: f64,
    candidates: u64,
    couples: u64,
}

impl From<&Work> for ToldWork {
    fn from(work: &Work) -> Self {
        let &Work { levels, predicted_windows, windows, predicted_candidates, candidates, couples, .. } =
            work;
        Self { levels, predicted_windows, windows, predicted_candidates, candidates, couples }
    }
}

/// Formats the work as a table. Levels are counted from 1.
fn table(works: &[ToldWork]) -> String {
    let mut text = String::new();
    let mut line = |cells: [String; 6]| {
        let [levels, rest @ ..] = cells;
        _ = write!(text, "\n  {levels:<8}");
        for cell in rest {
            _ = write!(text, " {cell:>14}");
        }
    };
    line(["levels", "windows", "predicted w.", "candidates", "predicted c.", "couples"].map(str::to_owned));
    for work in works {
        let [level, other] = work.levels.map(|level| level + 1);
        line([
            if level == other { level.to_string() } else { format!("{level} in {other}") },
            work.windows.to_string(),
            format!("{:.0}", work.predicted_windows),
            work.candidates.to_string(),
            format!("{:.0}", work.predicted_candidates),
            work.couples.to_string(),
        ]);
    }
    text.push('\n');
    text
}

impl Estimate {
    pub(crate) fn of<const D: usize>(
        space: &Space<'_, D>,
        request: &DetectionRequest<'_>,
        bodies: Option<usize>,
    ) -> Result<Self, Error> {
        let elements = request.elements(space.centres)?;
        let (engine, threads) = (request.engine, request.threads);
        let explanation = match &space.cell {
            None => Detector::new().with_engine(engine).with_threads(threads)?.explain(&elements),
            Some(cell) => {
                PeriodicSearch::new().with_engine(engine).with_threads(threads)?.explain(&elements, cell)
            }
        }?;
        let mut text = explanation.to_string();
        let Explanation {
            plan, elements, images, rows, occupied_rows, couples, couples_error, bytes, ..
        } = explanation;
        let mut work = Vec::new();
        if plan.engine == Engine::Multilevel && space.cell.is_none() {
            let works = Multilevel::new().with_threads(threads)?.work(&request.elements(space.centres)?)?;
            work = works.iter().map(ToldWork::from).collect();
            if !work.is_empty() {
                text += &table(&work);
            }
        }
        Ok(Self {
            elements,
            bodies,
            images,
            engine: Engine::name(plan.engine),
            reason: plan.reason,
            cell_size: plan.cell_size,
            cells: plan.cells.map(|cells| cells.to_vec()),
            levels: plan.levels.iter().map(ToldLevel::from).collect(),
            work,
            rows,
            occupied_rows_at_most: occupied_rows,
            expected_couples: couples,
            expected_couples_error: couples_error,
            engine_bytes: bytes,
            list_bytes: explanation.list_bytes,
            threads: explanation.threads,
            simd: explanation.simd.map(fdem_contact::Simd::name),
            text,
        })
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }
}
