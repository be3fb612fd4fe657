//! Conditions on a column of the history, which end a run or a stage, and servos, which move a boundary by
//! it.

use std::collections::BTreeSet;

use fdem_io::numbers::brief;
use fdem_mesh::Corners;
use fdem_results::history_columns;
use fdem_simulation::{Boundary, Load, Model};

use crate::output::curves::{AXES, Columns};
use crate::prepared::{Bound, PreparedServo, PreparedUntil};
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{self, Component, ModelFile};
use crate::text::values::dimension_of;

/// Checks conditions and servos before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let of_stages = (0..).zip(&file.stage).map(|(index, stage)| (Table::of("stage", index), &stage.until));
    for (table, until) in [(Table::one("model"), &file.model.until)].into_iter().chain(of_stages) {
        let Some(until) = until else { continue };
        let given: Vec<&str> = [
            ("until.above", until.above.is_some()),
            ("until.below", until.below.is_some()),
            ("until.share_of_peak", until.share_of_peak.is_some()),
        ]
        .into_iter()
        .filter_map(|(key, given)| given.then_some(key))
        .collect();
        if given.len() != 1 {
            let place = given.get(1).copied().unwrap_or("until");
            let message = "\"until\" has exactly one of above, below and share_of_peak";
            faults.push(Fault::at(document.key(table, place), message).label("one of them"));
        }
        if until.least_peak.is_some() && until.share_of_peak.is_none() {
            faults.push(
                Fault::at(document.key(table, "until.least_peak"), "\"least_peak\" goes with share_of_peak")
                    .label("take it out"),
            );
        }
    }
    for (index, boundary) in file.boundary.iter().enumerate() {
        let Some(servo) = &boundary.servo else { continue };
        let table = Table::of("boundary", index);
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        let moves = |velocity: &Vec<Component>| {
            velocity.iter().any(|component| component.prescribed().is_some_and(|velocity| velocity != 0.0))
        };
        if !boundary.velocity.as_ref().is_some_and(moves) {
            faults.push(
                Fault::at(document.key(table, "servo"), format!("{title}: a servo needs a velocity"))
                    .label("nothing to control")
                    .help("give the boundary the velocity with which it moves at most, towards the target"),
            );
        }
        if servo.target == 0.0 {
            faults.push(
                Fault::at(
                    document.value(table, "servo.target"),
                    format!("{title}: the target of a servo is not 0"),
                )
                .label("0")
                .help("the sign of the target says which way the velocity moves the column; a table of factors may lead the target through 0"),
            );
        }
    }
}

/// Force of the waves that a servo makes when it starts at full speed, over its band, from which on it swings
/// about its target.
const LOUD: f64 = 2.0;

/// Warns of servos whose velocity points away from their target, and of servos on a force that are too fast:
/// the waves and the inertia of the moved parts exceed their band. `own`: the columns of all `[[history]]`
/// tables.
pub(crate) fn warnings<const D: usize, const N: usize>(
    file: &ModelFile,
    model: &Model<D, N>,
    servos: &[PreparedServo],
    own: &[String],
    warnings: &mut Vec<String>,
) where
    [[f64; D]; N]: Corners<D, N>,
{
    for servo in servos {
        warnings.extend(turned_away(file, &model.boundaries[servo.boundary], servo, &own[servo.place]));
    }
    for servo in servos.iter().filter(|servo| own[servo.place].ends_with("[N]")) {
        let boundary = &model.boundaries[servo.boundary];
        let Load::Velocity(velocity) = boundary.load else { continue };
        let speed = velocity.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
        let moved: BTreeSet<u32> = boundary.target.nodes().into_iter().collect();
        let mut impedance = 0.0;
        for (nodes, &material) in model.mesh.elements.iter().zip(&model.mesh.materials) {
            let count = nodes.iter().filter(|node| moved.contains(node)).count();
            if count > 0 {
                let corners = nodes.map(|node| model.mesh.nodes[node as usize]);
                let material = &model.materials[material as usize];
                let measure = corners.measure();
                // A row of nodes has half of the mass of a row of elements.
                let mass = material.density * measure * model.thickness * count as f64 / N as f64;
                let width = (2.0 * measure).powf(1.0 / D as f64);
                impedance += 2.0 * mass * material.bar_speed() / width;
            }
        }
        if impedance * speed > LOUD * servo.band {
            warnings.push(format!(
                "[[boundary]] \"{}\": at its velocity the servo makes waves of {} N, and its band is {} N: it will swing about its target; take at most {} m/s, or a wider band",
                boundary.name,
                brief(impedance * speed),
                brief(servo.band),
                brief(servo.band / impedance)
            ));
        }
    }
}

/// The warning of a servo on its own force or displacement whose velocity has the wrong sign: a boundary that
/// is moved along an axis acts with a force of this direction, and is displaced in it.
fn turned_away<const D: usize>(
    file: &ModelFile,
    boundary: &Boundary<D>,
    servo: &PreparedServo,
    column: &str,
) -> Option<String> {
    let Load::Velocity(velocity) = boundary.load else { return None };
    let is_own = |axis: &str| {
        let own = file.history.iter().filter(|history| history.force.as_ref() == Some(&boundary.name));
        own.flat_map(|history| {
            [format!("{} f{axis} [N]", history.name), format!("{} u{axis} [m]", history.name)]
        })
        .any(|own| own == column)
    };
    let (name, speed) = AXES.into_iter().zip(velocity).find(|(axis, _)| is_own(axis))?;
    let speed = speed?;
    (speed * servo.target < 0.0).then(|| {
        format!(
            "[[boundary]] \"{}\": its servo moves away from its target: the velocity along {} is {} m/s, and {} of {column} needs the other sign",
            boundary.name,
            name,
            brief(speed),
            brief(servo.target)
        )
    })
}

/// The condition of `[model]`, those of the stages, and the servos, with the places of their columns.
pub(crate) struct Resolved {
    pub(crate) until: Option<PreparedUntil>,
    pub(crate) of_stages: Vec<Option<PreparedUntil>>,
    pub(crate) servos: Vec<PreparedServo>,
}

/// Refuses a value whose unit is not that of its column, which has it in brackets.
fn check_unit(
    document: &Document<'_>,
    (table, key): (Table, &'static str),
    column: &str,
    faults: &mut Vec<Fault>,
) {
    let Some(span) = document.value_if_any(table, key) else { return };
    let unit = column.rsplit_once(" [").and_then(|(_, unit)| unit.strip_suffix(']'));
    let (Some(found), Some(unit)) = (document.dimension(&span), unit) else { return };
    if dimension_of(unit).is_some_and(|expected| expected != found) {
        let name = key.rsplit('.').next().unwrap_or(key);
        let message = format!("\"{name}\" is {found}, but the column \"{column}\" is in {unit}");
        faults.push(Fault::at(span, message).label(format!("expected in {unit}")));
    }
}

/// Finds the columns of conditions and servos. `own`: the columns of all `[[history]]` tables. `file` has
/// been checked.
pub(crate) fn resolve<const D: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    own: &[String],
    faults: &mut Vec<Fault>,
) -> Resolved {
    let every = history_columns(D);
    let row = Columns { own, every: &every };
    let mut until = |until: Option<&file::Until>, table: Table| {
        let until = until?;
        let (column, place) = row.find(document.value(table, "until.column"), &until.column, faults)?;
        for key in ["until.above", "until.below", "until.least_peak"] {
            check_unit(document, (table, key), &column, faults);
        }
        let bound = match (until.above, until.below) {
            (Some(bound), _) => Bound::Above(bound),
            (None, Some(bound)) => Bound::Below(bound),
            (None, None) => Bound::ShareOfPeak {
                share: until.share_of_peak.unwrap_or_default(),
                least: until.least_peak.unwrap_or_default(),
            },
        };
        Some(PreparedUntil { column, place, bound })
    };
    let of_run = until(file.model.until.as_ref(), Table::one("model"));
    let of_stages = file.stage.iter().enumerate();
    let of_stages =
        of_stages.map(|(index, stage)| until(stage.until.as_ref(), Table::of("stage", index))).collect();
    let row = Columns { own, every: &[] };
    let mut servos = Vec::new();
    for (boundary, of_file) in file.boundary.iter().enumerate() {
        let Some(file::Servo { column, target, band, steps }) = &of_file.servo else { continue };
        let span = document.value(Table::of("boundary", boundary), "servo.column");
        let Some((column, place)) = row.find(span, column, faults) else { continue };
        check_unit(document, (Table::of("boundary", boundary), "servo.target"), &column, faults);
        servos.push(PreparedServo {
            boundary,
            place,
            target: *target,
            band: band * target.abs(),
            steps: *steps,
        });
    }
    Resolved { until: of_run, of_stages, servos }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peak_counts_from_the_least_one_on() {
        let until = PreparedUntil {
            column: "load".to_owned(),
            place: 1,
            bound: Bound::ShareOfPeak { share: 0.5, least: 10.0 },
        };
        let mut peak = 0.0;
        let met: Vec<bool> = [0.0, -4.0, -1.0, -20.0, -11.0, -10.0]
            .into_iter()
            .map(|value| until.met(&[7.0, value], &mut peak).is_some())
            .collect();
        assert_eq!(met, [false, false, false, false, false, true]);
    }

    #[test]
    fn a_servo_slows_down_near_its_target_and_comes_back() {
        let servo = PreparedServo { boundary: 0, place: 0, target: -200.0, band: 20.0, steps: 10 };
        let factors = [0.0, -190.0, -200.0, -210.0, -400.0].map(|measured| servo.factor(measured, 1.0));
        assert_eq!(factors, [1.0, 0.5, 0.0, -0.5, -1.0]);
        assert_eq!(servo.factor(-90.0, 0.5), 0.5);
        assert_eq!(servo.factor(f64::NAN, 1.0), 0.0);
    }
}
