//! Columns of the history, and curves of one over another.

use fdem_results::{HistoryCurve, history_columns};
use fdem_simulation::{Element, Probe};

use crate::model::document::{Document, Table};
use crate::model::fault::{Fault, suggestion};
use crate::model::file::ModelFile;
use crate::model::settings::{History, Quantity};

/// Names of the components of vectors.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The names of the columns of all `[[history]]` tables, with their units.
pub(crate) fn columns<const D: usize, const N: usize>(
    histories: &[History],
    probes: &[Probe<D, N>],
) -> Vec<String>
where
    [[f64; D]; N]: Element<D, N>,
{
    let mut names = Vec::new();
    for history in histories {
        let parts: &[(&str, &str)] = match history.quantity {
            Quantity::Probe(probe) => {
                let columns = probes[probe].columns().into_iter();
                names.extend(columns.map(|(part, unit)| format!("{} {part} [{unit}]", history.name)));
                continue;
            }
            Quantity::Node(_) => &[("u", "m"), ("v", "m/s")],
            Quantity::Force(_) => &[("f", "N"), ("u", "m")],
            // The history has these columns in any case.
            Quantity::Energy | Quantity::CrackLength => &[],
        };
        for (letter, unit) in parts {
            names.extend(AXES[..D].iter().map(|axis| format!("{} {letter}{axis} [{unit}]", history.name)));
        }
    }
    names
}

/// The curves, with the full names of their columns. `own`: the columns of all histories.
pub(crate) fn curves<const D: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    own: &[String],
    faults: &mut Vec<Fault>,
) -> Vec<HistoryCurve> {
    let every = history_columns(D);
    let all: Vec<&str> = own.iter().chain(&every).map(String::as_str).collect();
    let without_unit = |name: &'_ str| name.rsplit_once(" [").map_or(name, |(name, _)| name).to_owned();
    let mut curves = Vec::new();
    for (index, curve) in file.curve.iter().enumerate() {
        let table = Table::of("curve", index);
        let mut column = |key: &str, name: &str| {
            let found = all.iter().find(|other| **other == name || without_unit(other) == name);
            if found.is_none() {
                let names: Vec<String> = all.iter().map(|name| without_unit(name)).collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                faults.push(
                    Fault::at(document.value(table, key), format!("the history has no column \"{name}\""))
                        .label("unknown column")
                        .help(suggestion(name, &names, "[[history]]")),
                );
            }
            found.map(|name| (*name).to_owned()).unwrap_or_default()
        };
        let (x, y) = (column("x", &curve.x), column("y", &curve.y));
        for (key, given, name, unit) in [("length", curve.length, &x, "[m]"), ("area", curve.area, &y, "[N]")]
        {
            if given.is_some() && !name.is_empty() && !name.ends_with(unit) {
                faults.push(
                    Fault::at(
                        document.key(table, key),
                        format!("\"{key}\" divides a column in {unit}, and \"{name}\" is none"),
                    )
                    .label("take it out"),
                );
            }
        }
        curves.push(HistoryCurve { name: curve.name.clone(), x, y, length: curve.length, area: curve.area });
    }
    curves
}
