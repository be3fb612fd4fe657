//! Factors of boundaries in time: ramps, tables, files with tables, and expressions.

use fdem_simulation::Schedule;

use crate::joints::shape_file::rows;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, ModelFile};
use crate::text::included::Load;
use crate::text::values;

/// Intervals of the run in which an expression of the time is replaced by straight lines.
const INTERVALS: u32 = 4000;

/// Checks the schedules of boundaries before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        if let [first, second, ..] = given(boundary)[..] {
            faults.push(
                Fault::at(document.key(table, second), format!("{title} has both {first} and {second}"))
                    .label("a second schedule"),
            );
        }
        if boundary.table.as_deref().is_some_and(|times| !ascend(times)) {
            faults.push(
                Fault::at(
                    document.value(table, "table"),
                    format!("{title}: the times of its table do not ascend"),
                )
                .label("out of order"),
            );
        }
    }
}

/// The keys of schedules that are given.
fn given(boundary: &file::Boundary) -> Vec<&'static str> {
    let all = [
        ("ramp", boundary.ramp.is_some()),
        ("table", boundary.table.is_some()),
        ("table_file", boundary.table_file.is_some()),
        ("expression", boundary.expression.is_some()),
    ];
    all.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
}

fn ascend(times: &[[f64; 2]]) -> bool {
    times.windows(2).all(|pair| pair[0][0] < pair[1][0])
}

/// The factor of a boundary in time.
pub(crate) fn schedule(
    (file, boundary): (&ModelFile, &file::Boundary),
    (document, table): (&Document<'_>, Table),
    load: &mut Load<'_>,
    faults: &mut Vec<Fault>,
) -> Schedule {
    let mut fault = |key: &str, message: String| {
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        faults.push(Fault::at(document.value(table, key), format!("{title}: {message}")));
        Schedule::Constant
    };
    if let Some(name) = &boundary.table_file {
        return match read(name, load) {
            Ok(times) => Schedule::Table(times),
            Err(message) => fault("table_file", message),
        };
    }
    if let Some(text) = &boundary.expression {
        let end = file.model.end_time;
        let times = (0..=INTERVALS).map(|k| end * f64::from(k) / f64::from(INTERVALS));
        return match values::of_time(text, times) {
            Ok(times) => Schedule::Table(times),
            Err(message) => fault("expression", message),
        };
    }
    match (boundary.ramp, &boundary.table) {
        (Some(ramp), _) => Schedule::Ramp(ramp),
        (None, Some(table)) => Schedule::Table(table.clone()),
        (None, None) => Schedule::Constant,
    }
}

/// The table of a file: times, s, and factors.
fn read(name: &str, load: &mut Load<'_>) -> Result<Vec<[f64; 2]>, String> {
    let bytes = load(name).map_err(|why| format!("cannot read {name}: {why}"))?;
    let text = String::from_utf8(bytes).map_err(|_| format!("{name} is not a text file"))?;
    let times =
        rows(&text, |numbers| <[f64; 2]>::try_from(numbers).ok(), ("a time and a factor", &["t", ""], "s"));
    let times = times.map_err(|why| format!("{name}: {why}"))?;
    let times: Vec<[f64; 2]> = times.into_iter().map(|(_, pair)| pair).collect();
    if times.is_empty() {
        return Err(format!("{name} has no rows"));
    }
    if let Some(number) = times.as_flattened().iter().find(|number| !number.is_finite()) {
        return Err(format!("{name} has the number {number}"));
    }
    if ascend(&times) { Ok(times) } else { Err(format!("{name}: the times do not ascend")) }
}
