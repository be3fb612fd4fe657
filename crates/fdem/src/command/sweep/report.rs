//! The page that compares the runs of a sweep.

use fdem_results::page::sweep::SweepReport;
use fdem_results::{History, HistoryCurve};

use crate::command::sweep::Sweep;
use crate::command::sweep::table::{Row, Table};

/// The page of a sweep.
pub(super) fn page(sweep: &Sweep<'_>, rows: &[Row], table: &Table) -> String {
    let first = sweep.checked.iter().find_map(|(_, checked)| checked.as_ref().ok());
    let curves: &[HistoryCurve] = first.map_or(&[], |checked| &checked.curves);
    let title = first.map_or("", |checked| checked.title.as_str());
    let model = sweep.models.path.file_name().unwrap_or_default().to_string_lossy();
    let title =
        if title.is_empty() { format!("Sweep of {model}") } else { format!("Sweep of {model}: {title}") };
    let history = |row: &Row| {
        let is_there = matches!(row.status, "finished" | "stopped" | "interrupted");
        History::read(&sweep.store.history(row.number).filter(|_| is_there)?).ok()
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
