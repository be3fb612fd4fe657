//! The page that compares the runs of a sweep.

use std::path::Path;

use fdem_results::page::sweep::SweepReport;
use fdem_results::{History, HistoryCurve};

use crate::command::sweep::check::Checked;
use crate::command::sweep::store::Store;
use crate::command::sweep::table::{RunRow, Table};

/// The page of a sweep. `model`: the model file; `checked`: the model of a run.
pub(super) fn page(
    model: &Path,
    checked: Option<&Checked>,
    rows: &[RunRow],
    table: &Table,
    store: &Store,
) -> String {
    let curves: &[HistoryCurve] = checked.map_or(&[], |checked| &checked.curves);
    let title = checked.map_or("", |checked| checked.title.as_str());
    let model = model.file_name().unwrap_or_default().to_string_lossy();
    let title =
        if title.is_empty() { format!("Sweep of {model}") } else { format!("Sweep of {model}: {title}") };
    let history = |row: &RunRow| {
        let is_there = matches!(row.status, "finished" | "stopped" | "interrupted");
        History::read(&store.history(row.number).filter(|_| is_there)?).ok()
    };
    let histories: Vec<Option<History>> = rows.iter().map(history).collect();
    SweepReport {
        title: &title,
        columns: &table.columns,
        parameters: table.parameters,
        rows: &table.rows,
        histories: &histories,
        curves,
    }
    .html()
}
