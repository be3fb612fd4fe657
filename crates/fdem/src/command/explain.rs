//! `fdem contacts --explain`: what a search would take, and no search.

use fdem_contact::{Detector, Engine, Error, Explanation, Level, PeriodicSearch};
use serde::Serialize;

use crate::command::detect::Request;
use crate::command::periodic::Space;

/// Written as JSON by `--json`, and as text to standard output.
#[derive(Debug, Serialize)]
pub(crate) struct Told {
    elements: usize,
    /// Parts of one of these form no couple.
    #[serde(skip_serializing_if = "Option::is_none")]
    bodies: Option<usize>,
    /// In a box that repeats.
    #[serde(skip_serializing_if = "Option::is_none")]
    images: Option<usize>,
    engine: &'static str,
    reason: String,
    cell_size: Option<f64>,
    cells: Option<Vec<u64>>,
    /// Those of the engines multilevel and cgrid.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    levels: Vec<ToldLevel>,
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

impl Told {
    pub(crate) fn of<const D: usize>(
        space: &Space<'_, D>,
        request: &Request<'_>,
        bodies: Option<usize>,
    ) -> Result<Self, Error> {
        let elements = request.elements(space.centres)?;
        let (engine, threads) = (request.engine, request.threads);
        let explanation = match &space.cell {
            None => Detector::new(engine).with_threads(threads)?.explain(&elements),
            Some(cell) => PeriodicSearch::new(engine).with_threads(threads)?.explain(&elements, cell),
        }?;
        let text = explanation.to_string();
        let Explanation {
            plan, elements, images, rows, occupied_rows, couples, couples_error, bytes, ..
        } = explanation;
        Ok(Self {
            elements,
            bodies,
            images,
            engine: Engine::name(plan.engine),
            reason: plan.reason,
            cell_size: plan.cell_size,
            cells: plan.cells.map(|cells| cells.to_vec()),
            levels: plan.levels.iter().map(ToldLevel::from).collect(),
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
