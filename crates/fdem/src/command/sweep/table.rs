//! The table of the results of a sweep.

use fdem_results::History;
use fdem_results::page::sweep::Cell;
use serde_json::Value;

use fdem_model::Setting;

/// A run in the table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RunRow {
    /// Number, from 1.
    pub(crate) number: usize,
    pub(crate) values: Vec<Setting>,
    /// "finished", "stopped", "interrupted", "failed", "refused" or "waiting".
    pub(crate) status: &'static str,
    /// Why it has not finished; empty if it has.
    pub(crate) message: String,
    /// Folder, relative to that of the sweep.
    pub(crate) folder: String,
    pub(crate) results: Vec<(String, Cell)>,
}

/// Results of all runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Names of the columns: `run`, the parameters, `status`, `message`, the results, `folder`.
    pub columns: Vec<String>,
    /// Number of parameters.
    pub parameters: usize,
    /// Cells of each run.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// The table of rows that are in the order of their numbers.
    pub(crate) fn of(names: &[String], rows: &[RunRow]) -> Self {
        let mut results: Vec<&str> = Vec::new();
        for (name, _) in rows.iter().flat_map(|row| &row.results) {
            if !results.contains(&name.as_str()) {
                results.push(name);
            }
        }
        let first = ["run"].into_iter().chain(names.iter().map(String::as_str));
        let columns = first.chain(["status", "message"]).chain(results.iter().copied()).chain(["folder"]);
        let cells = |row: &RunRow| -> Vec<Cell> {
            let mut cells = vec![Cell::Number(row.number as f64)];
            cells.extend(row.values.iter().map(cell));
            cells.extend([Cell::Text(row.status.to_owned()), Cell::Text(row.message.clone())]);
            cells.extend(results.iter().map(|wanted| {
                let found = row.results.iter().find(|(name, _)| name == wanted);
                found.map_or(Cell::Missing, |(_, cell)| cell.clone())
            }));
            cells.push(Cell::Text(row.folder.clone()));
            cells
        };
        Self {
            columns: columns.map(str::to_owned).collect(),
            parameters: names.len(),
            rows: rows.iter().map(cells).collect(),
        }
    }

    /// The table as CSV. Numbers are read back exactly.
    pub(crate) fn csv(&self) -> Result<Vec<u8>, csv::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(|cell| match cell {
                Cell::Number(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
                    format!("{number:.0}")
                }
                Cell::Number(number) => format!("{number:?}"),
                Cell::Text(text) => text.clone(),
                Cell::Missing => String::new(),
            }))?;
        }
        writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
    }
}

/// A value in the table: its number in SI units, or a text.
fn cell(value: &Setting) -> Cell {
    // Larger ones are not all floating-point numbers, and a seed is of use with all of its digits only.
    if let Setting::Whole(number) = value
        && number.unsigned_abs() > 1 << 53
    {
        return Cell::Text(number.to_string());
    }
    value.number().map_or_else(|| Cell::Text(value.to_string()), Cell::Number)
}

/// Numbers at the top of `run.json` that are results.
const NUMBERS: [&str; 8] =
    ["time", "steps", "time_step", "elements", "nodes", "joints", "broken_joints", "crack_length"];

/// The results in a `run.json`, and the last values of the user's columns of a history. Times of the clock,
/// which differ from machine to machine, are left out.
pub(crate) fn results(json: &Value, history: Option<&History>) -> Vec<(String, Cell)> {
    let mut found = Vec::new();
    let mut add = |name: String, value: &Value| {
        if let Some(number) = value.as_f64() {
            found.push((name, Cell::Number(number)));
        }
    };
    NUMBERS.iter().chain(&["crack_area"]).for_each(|name| add((*name).to_owned(), &json[name]));
    for (table, before) in
        [("fragments", "fragments"), ("energies", "energy"), ("acoustic_emission", "emission")]
    {
        for (name, value) in json[table].as_object().into_iter().flatten() {
            add(format!("{before} {name}"), value);
        }
    }
    for curve in json["curves"].as_array().into_iter().flatten() {
        let name = curve["name"].as_str().unwrap_or("curve");
        for key in ["peak", "x_at_peak", "time_of_peak", "modulus"] {
            add(format!("{name} {key}"), &curve[key]);
        }
    }
    for (name, values) in history.into_iter().flat_map(History::of_user) {
        if let Some(last) = values.last().filter(|last| last.is_finite()) {
            found.push((format!("{name} at the end"), Cell::Number(*last)));
        }
    }
    if let Some(met) = json["until_met"].as_bool() {
        found.push(("until_met".to_owned(), Cell::Text(if met { "yes" } else { "no" }.to_owned())));
    }
    if let Some(hash) = json["state_hash"].as_str() {
        found.push(("state_hash".to_owned(), Cell::Text(hash.to_owned())));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_table_has_the_columns_of_all_runs() {
        let names = ["strength".to_owned()];
        let json = json!({
            "time": 1e-3, "steps": 40, "broken_joints": 3, "seconds": { "total": 7.0 }, "fragments": { "number": 2, "d50": null },
            "energies": { "kinetic": 0.25 }, "curves": [{ "name": "impact", "peak": -2e3, "modulus": null }], "until_met": true, "state_hash": "ab",
        });
        let row = |number, value: &str, status, message: &str, results| RunRow {
            number,
            values: vec![Setting::parse(value)],
            status,
            message: message.to_owned(),
            folder: format!("runs/00{number}"),
            results,
        };
        let rows = [
            row(1, "-1 m", "refused", "said \"no\", twice", Vec::new()),
            row(2, "8 MPa", "finished", "", results(&json, None)),
        ];
        let table = Table::of(&names, &rows);
        assert_eq!(
            String::from_utf8(table.csv().unwrap()).unwrap(),
            "run,strength,status,message,time,steps,broken_joints,fragments number,energy kinetic,impact peak,until_met,state_hash,folder\n\
             1,-1,refused,\"said \"\"no\"\", twice\",,,,,,,,,runs/001\n\
             2,8000000,finished,,0.001,40,3,2,0.25,-2000,yes,ab,runs/002\n"
        );
    }
}
