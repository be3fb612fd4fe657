//! The page of a sweep, which compares its runs: the table of results, a plot of any result over any
//! parameter, and the histories of all runs over each other.
//!
//! Like the other pages it is one file, which loads nothing over the network. Without a script the table is
//! there.

use std::fmt::Write;

use fdem_io::numbers::brief;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use crate::page::{PageParts, STYLE};
use crate::picture::svg::escape;
use crate::run::{History, HistoryCurve};

/// Rows of the history of a run that the page has at most.
const MOST_ROWS: usize = 400;

/// Numbers of all histories together that the page has at most.
const MOST_NUMBERS: usize = 2_000_000;

const PAGE: &str = include_str!("sweep/page.html");
const STYLE_OF_SWEEPS: &str = include_str!("sweep/sweep.css");
const SCRIPTS: [&str; 2] = [include_str!("sweep/plot.js"), include_str!("sweep/main.js")];

/// A cell of the table of results.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// A result that the run does not have.
    Missing,
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) if number.is_finite() => out.serialize_f64(*number),
            Self::Text(text) => out.serialize_str(text),
            Self::Number(_) | Self::Missing => out.serialize_none(),
        }
    }
}

/// The page of a sweep.
#[derive(Debug)]
pub struct SweepReport<'a> {
    /// Title.
    pub title: &'a str,
    /// Names of the columns: `run`, the parameters, `status`, `message`, the results, `folder`.
    pub columns: &'a [String],
    /// Number of parameters.
    pub parameters: usize,
    /// Cells of each run.
    pub rows: &'a [Vec<Cell>],
    /// The history of each run, if it has one.
    pub histories: &'a [Option<History>],
    /// Curves of the model.
    pub curves: &'a [HistoryCurve],
}

impl SweepReport<'_> {
    /// The page.
    pub fn html(&self) -> String {
        let parts = PageParts {
            kind: "sweep",
            command: "fdem sweep",
            skip: ["runs", "Skip to the table"],
            main: PAGE,
            data: "",
            style: format!("{STYLE}{STYLE_OF_SWEEPS}"),
            scripts: &SCRIPTS,
        };
        let page = parts.page(|name| {
            Ok::<String, std::convert::Infallible>(match name {
                "title" => escape(self.title),
                "counts" => self.counts(),
                "columns" => self.shown().map(|column| heading(&self.columns[column])).collect(),
                "rows" => self.rows.iter().map(|row| self.row(row)).collect(),
                // A script element ends at "</script", so no "<" may remain.
                "meta" => self.meta().to_string().replace('<', "\\u003c"),
                // The template has no other placeholders.
                _ => String::new(),
            })
        });
        match page {
            Ok(page) => page,
        }
    }

    /// Columns of the table of the page: all but the folder, which is a link, and hashes.
    fn shown(&self) -> impl Iterator<Item = usize> {
        let is_shown = |column: &usize| !["folder", "state_hash"].contains(&self.columns[*column].as_str());
        (0..self.columns.len()).filter(is_shown)
    }

    fn counts(&self) -> String {
        let status = self.columns.iter().position(|column| column == "status").unwrap_or(0);
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for row in self.rows {
            let Some(Cell::Text(status)) = row.get(status) else { continue };
            match counts.iter_mut().find(|(known, _)| known == status) {
                Some((_, count)) => *count += 1,
                None => counts.push((status, 1)),
            }
        }
        let counts: Vec<String> = counts.iter().map(|(status, count)| format!("{count} {status}")).collect();
        let runs = self.rows.len();
        format!("{runs} run{}: {}", if runs == 1 { "" } else { "s" }, escape(&counts.join(", ")))
    }

    fn row(&self, row: &[Cell]) -> String {
        let mut text = String::from("<tr>");
        let folder = match (self.columns.last().map(String::as_str), row.last()) {
            (Some("folder"), Some(Cell::Text(folder))) => folder.as_str(),
            _ => "",
        };
        for column in self.shown() {
            let cell = match &row[column] {
                Cell::Number(number) => escape(&brief(*number)),
                Cell::Text(text) => escape(text),
                Cell::Missing => "–".to_owned(),
            };
            // Writing to a string does not fail.
            let _ = match (column, folder) {
                (0, folder) if !folder.is_empty() => {
                    write!(
                        text,
                        "<th scope=\"row\"><a href=\"{}/report.html\">{cell}</a></th>",
                        escape(folder)
                    )
                }
                _ => write!(text, "<td>{cell}</td>"),
            };
        }
        text + "</tr>\n"
    }

    fn meta(&self) -> Value {
        let columns: usize = self.histories.iter().flatten().map(|history| history.names().len()).sum();
        let most = (MOST_NUMBERS / columns.max(1)).clamp(2, MOST_ROWS);
        let curves: Vec<Value> = self
            .curves
            .iter()
            .map(|curve| {
                json!({ "name": curve.name, "x": curve.x, "y": curve.y, "length": curve.length, "area": curve.area })
            })
            .collect();
        let histories: Vec<Value> = self
            .histories
            .iter()
            .map(|history| history.as_ref().map_or(Value::Null, |history| thinned(history, most)))
            .collect();
        json!({
            "title": self.title,
            "columns": self.columns,
            "parameters": self.parameters,
            "rows": self.rows,
            "histories": histories,
            "curves": curves,
        })
    }
}

fn heading(name: &str) -> String {
    format!("<th scope=\"col\">{}</th>", escape(name))
}

/// The columns of a history by their names, with at most `most` rows: the first of each part of it, and the
/// last of all.
fn thinned(history: &History, most: usize) -> Value {
    let mut columns = serde_json::Map::new();
    for name in history.names() {
        let Some(values) = history.column(name) else { continue };
        let count = values.len().min(most);
        let place = |k: usize| if count < 2 { k } else { k * (values.len() - 1) / (count - 1) };
        let kept: Vec<Value> = (0..count).map(|k| short(values[place(k)])).collect();
        columns.insert(name.clone(), kept.into());
    }
    columns.into()
}

/// A number of six digits, which keeps the page small; null if it is not finite.
fn short(number: f64) -> Value {
    let digits: f64 = format!("{number:.5e}").parse().unwrap_or(f64::NAN);
    if digits.is_finite() { json!(digits) } else { Value::Null }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{HistoryWriter, Row};

    fn history(rows: u32) -> History {
        let mut text = Vec::new();
        let mut writer = HistoryWriter::new(&mut text, 2, &["force [N]".to_owned()]).unwrap();
        for step in 0..rows {
            let values = vec![f64::from(step) / 3.0];
            writer.row(&Row { time: f64::from(step), values, ..Row::default() }).unwrap();
        }
        History::read(&text).unwrap()
    }

    #[test]
    fn a_page_has_the_table_and_the_histories() {
        let columns =
            ["run", "a<b", "status", "message", "energy kinetic", "state_hash", "folder"].map(str::to_owned);
        let text = |text: &str| Cell::Text(text.to_owned());
        let rows = [
            vec![
                Cell::Number(1.0),
                Cell::Number(2.5e6),
                text("finished"),
                text(""),
                Cell::Number(0.125),
                text("ab"),
                text("runs/001"),
            ],
            vec![
                Cell::Number(2.0),
                text("x"),
                text("refused"),
                text("</script>"),
                Cell::Missing,
                Cell::Missing,
                text("runs/002"),
            ],
        ];
        let curve = HistoryCurve {
            name: "force".into(),
            x: "time".into(),
            y: "force [N]".into(),
            ..HistoryCurve::default()
        };
        let histories = [Some(history(1001)), None];
        let report = SweepReport {
            title: "discs & more",
            columns: &columns,
            parameters: 1,
            rows: &rows,
            histories: &histories,
            curves: &[curve],
        };
        let page = report.html();
        assert!(page.contains("<h1>discs &amp; more</h1>"));
        assert!(page.contains("2 runs: 1 finished, 1 refused"));
        assert!(page.contains(
            "<tr><th scope=\"row\"><a href=\"runs/001/report.html\">1</a></th><td>2.5e6</td><td>finished</td><td></td><td>0.125</td></tr>"
        ));
        assert!(page.contains("<th scope=\"col\">a&lt;b</th>") && !page.contains("state_hash</th>"));
        let meta = page.split("<script type=\"application/json\" id=\"meta\">").nth(1).unwrap();
        let meta: Value = serde_json::from_str(meta.split("</script>").next().unwrap()).unwrap();
        assert_eq!(meta["rows"][1][3], "</script>");
        assert_eq!(meta["rows"][1][4], Value::Null);
        let force = meta["histories"][0]["force [N]"].as_array().unwrap();
        assert_eq!((force.len(), &force[0], &force[399]), (400, &json!(0.0), &json!(333.333)));
        assert_eq!(meta["histories"][1], Value::Null);
    }
}
