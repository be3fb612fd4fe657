//! Columns of the history, and curves of one over another.

use std::ops::Range;

use fdem_results::{HistoryCurve, history_columns};
use fdem_simulation::{Element, Probe};

use crate::prepared::{PreparedHistory, Quantity};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, nearest_first};
use crate::text::file::{self, ModelFile};

/// Names of the components of vectors.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// The names of the columns of all `[[history]]` tables, with their units.
pub fn columns<const D: usize, const N: usize>(
    histories: &[PreparedHistory],
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
            Quantity::Force(_) | Quantity::Torque(..) => &[("f", "N"), ("u", "m")],
            // The history has these columns in any case.
            Quantity::Energy | Quantity::CrackLength => &[],
        };
        for (letter, unit) in parts {
            names.extend(AXES[..D].iter().map(|axis| format!("{} {letter}{axis} [{unit}]", history.name)));
        }
        if matches!(history.quantity, Quantity::Torque(..)) {
            names.push(format!("{} torque [N m]", history.name));
        }
    }
    names
}

/// The columns of a history.
#[derive(Clone, Copy)]
pub(crate) struct Columns<'a> {
    /// Columns of the `[[history]]` tables.
    pub(crate) own: &'a [String],
    /// Columns before them, which every history has.
    pub(crate) every: &'a [String],
}

impl Columns<'_> {
    /// The full name of a column, and its place among the columns of every history and, after them, those of
    /// the tables. Its unit may be left out: files and the Python package take the same names. `span`: where
    /// the name is in the model file.
    pub(crate) fn find(
        self,
        span: Range<usize>,
        name: &str,
        faults: &mut Vec<Fault>,
    ) -> Option<(String, usize)> {
        let all: Vec<&str> = self.every.iter().chain(self.own).map(String::as_str).collect();
        let without_unit = |name: &str| name.rsplit_once(" [").map_or(name, |(name, _)| name).to_owned();
        let place = all.iter().position(|other| *other == name || without_unit(other) == name);
        if place.is_none() {
            let names: Vec<String> =
                self.own.iter().chain(self.every).map(|name| without_unit(name)).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            let names = of_first_words(name, &names);
            let help = if names.is_empty() {
                "the model has no [[history]] with columns of its own".to_owned()
            } else {
                nearest_first(name, &names, "[[history]]")
            };
            faults.push(
                Fault::at(span, format!("the history has no column \"{name}\""))
                    .label("unknown column")
                    .help(help),
            );
        }
        place.map(|place| (all[place].to_owned(), place))
    }
}

/// The names that begin with the same words as `name`, as many as possible: a column begins with the name of
/// its history. All names if none does.
fn of_first_words<'a>(name: &str, names: &[&'a str]) -> Vec<&'a str> {
    let starts = name.rmatch_indices(' ').map(|(at, _)| &name[..=at]);
    let of = |start: &str| names.iter().copied().filter(|other| other.starts_with(start)).collect::<Vec<_>>();
    starts.map(of).find(|some| !some.is_empty()).unwrap_or_else(|| names.to_vec())
}

/// The curves, with the full names of their columns. `own`: the columns of all histories.
pub(crate) fn curves<const D: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    own: &[String],
    faults: &mut Vec<Fault>,
) -> Vec<HistoryCurve> {
    let every = history_columns(D);
    let columns = Columns { own, every: &every };
    let mut curves = Vec::new();
    for (index, curve) in file.curve.iter().enumerate() {
        let table = Table::of("curve", index);
        let mut column = |key: &str, name: &str| {
            columns.find(document.value(table, key), name, faults).unwrap_or_default().0
        };
        let (x, y) = (column("x", &curve.x), column("y", &curve.y));
        let softening = curve.softening.as_deref().map(|name| column("softening", name));
        let lateral: Vec<String> =
            curve.lateral.iter().flatten().map(|name| column("lateral", name)).collect();
        let strain = |name: &str| name.is_empty() || name.ends_with("[m/m]");
        if let Some(other) = lateral.iter().find(|name| !strain(name)) {
            faults.push(
                Fault::at(
                    document.value(table, "lateral"),
                    format!("\"lateral\" is strains, and \"{other}\" is none"),
                )
                .help("take the strain of a gauge, or a component of the mean strain"),
            );
        } else if !lateral.is_empty() && curve.length.is_none() && !strain(&x) {
            faults.push(
                Fault::at(
                    document.value(table, "x"),
                    format!("\"lateral\" goes with a strain, and \"{x}\" is none"),
                )
                .help("divide a displacement by the length of the specimen: length = …"),
            );
        } else if !lateral.is_empty() && lateral.len() != D - 1 {
            let (wanted, found) = (D - 1, lateral.len());
            faults.push(Fault::at(
                document.value(table, "lateral"),
                format!("a volumetric strain in {D} dimensions has {wanted} lateral strains, not {found}"),
            ));
        }
        let cracked = softening.iter().filter(|name| !name.is_empty() && !name.contains(" softening_"));
        for other in cracked {
            faults.push(
                Fault::at(
                    document.value(table, "softening"),
                    format!(
                        "\"softening\" is a column of joints past their strength, and \"{other}\" is none"
                    ),
                )
                .help("take the softening_length or softening_area of a history with softening = true"),
            );
        }
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
        let file::Curve { length, area, optional, .. } = *curve;
        curves.push(HistoryCurve {
            name: curve.name.clone(),
            x,
            y,
            length,
            area,
            softening,
            lateral,
            optional,
        });
    }
    curves
}
