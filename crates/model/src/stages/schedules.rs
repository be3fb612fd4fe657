//! Factors of boundaries, injections and surfaces of pores in time: ramps, tables, files with tables, and
//! expressions.

use fdem_simulation::Schedule;

use crate::joints::shape_file::rows;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, ModelFile};
use crate::text::included::Load;
use crate::text::values;

/// Intervals of the run in which an expression of the time is replaced by straight lines.
const INTERVALS: u32 = 4000;

/// The keys of the schedule of a boundary, an injection or a surface of pores.
pub(crate) struct Factor<'a> {
    /// "[[boundary]] "name"".
    title: String,
    table: Table,
    ramp: Option<f64>,
    rows: Option<&'a [[f64; 2]]>,
    table_file: Option<&'a str>,
    expression: Option<&'a str>,
}

impl<'a> Factor<'a> {
    /// The keys of a boundary, by its number.
    pub(crate) fn of_boundary(boundary: &'a file::Boundary, index: usize) -> Self {
        Self {
            title: format!("[[boundary]] \"{}\"", boundary.name),
            table: Table::of("boundary", index),
            ramp: boundary.ramp,
            rows: boundary.table.as_deref(),
            table_file: boundary.table_file.as_deref(),
            expression: boundary.expression.as_deref(),
        }
    }

    /// The keys of an injection, by its number.
    pub(crate) fn of_injection(injection: &'a file::Injection, index: usize) -> Self {
        Self {
            title: format!("[[injection]] \"{}\"", injection.name),
            table: Table::of("injection", index),
            ramp: injection.ramp,
            rows: injection.table.as_deref(),
            table_file: injection.table_file.as_deref(),
            expression: injection.expression.as_deref(),
        }
    }

    /// The keys of a surface of pores, by its number.
    pub(crate) fn of_pore_surface(surface: &'a file::PoreSurface, index: usize) -> Self {
        Self {
            title: format!("[[pore_surface]] \"{}\"", surface.name),
            table: Table::of("pore_surface", index),
            ramp: surface.ramp,
            rows: surface.table.as_deref(),
            table_file: surface.table_file.as_deref(),
            expression: surface.expression.as_deref(),
        }
    }

    /// The keys that are given.
    pub(crate) fn given(&self) -> Vec<&'static str> {
        let all = [
            ("ramp", self.ramp.is_some()),
            ("table", self.rows.is_some()),
            ("table_file", self.table_file.is_some()),
            ("expression", self.expression.is_some()),
        ];
        all.into_iter().filter(|(_, given)| *given).map(|(key, _)| key).collect()
    }

    /// Checks the keys before anything is meshed.
    fn check(&self, document: &Document<'_>, faults: &mut Vec<Fault>) {
        let Self { title, table, .. } = self;
        if let [first, second, ..] = self.given()[..] {
            faults.push(
                Fault::at(document.key(*table, second), format!("{title} has both {first} and {second}"))
                    .label("a second schedule"),
            );
        }
        if self.rows.is_some_and(|times| !ascend(times)) {
            faults.push(
                Fault::at(
                    document.value(*table, "table"),
                    format!("{title}: the times of its table do not ascend"),
                )
                .label("out of order"),
            );
        }
    }

    /// The factor in time. `end`: that of the run, s.
    pub(crate) fn schedule(
        &self,
        end: f64,
        document: &Document<'_>,
        load: &mut Load<'_>,
        faults: &mut Vec<Fault>,
    ) -> Schedule {
        let mut fault = |key: &str, message: String| {
            let title = &self.title;
            faults.push(Fault::at(document.value(self.table, key), format!("{title}: {message}")));
            Schedule::Constant
        };
        if let Some(name) = self.table_file {
            return match read(name, load) {
                Ok(times) => Schedule::Table(times),
                Err(message) => fault("table_file", message),
            };
        }
        if let Some(text) = self.expression {
            let times = (0..=INTERVALS).map(|k| end * f64::from(k) / f64::from(INTERVALS));
            return match values::of_time(text, times) {
                Ok(times) => Schedule::Table(times),
                Err(message) => fault("expression", message),
            };
        }
        match (self.ramp, self.rows) {
            (Some(ramp), _) => Schedule::Ramp(ramp),
            (None, Some(table)) => Schedule::Table(table.to_vec()),
            (None, None) => Schedule::Constant,
        }
    }
}

/// Checks the schedules of boundaries, injections and surfaces of pores before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    for (index, boundary) in file.boundary.iter().enumerate() {
        Factor::of_boundary(boundary, index).check(document, faults);
    }
    for (index, injection) in file.injection.iter().enumerate() {
        Factor::of_injection(injection, index).check(document, faults);
    }
    for (index, surface) in file.pore_surface.iter().enumerate() {
        Factor::of_pore_surface(surface, index).check(document, faults);
    }
}

fn ascend(times: &[[f64; 2]]) -> bool {
    times.windows(2).all(|pair| pair[0][0] < pair[1][0])
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
