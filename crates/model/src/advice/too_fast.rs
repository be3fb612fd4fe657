//! Speeds at which a run stops in its first steps.

use fdem_io::numbers::brief;
use fdem_simulation::{Boundary, Load, Model};

use crate::shapes::placed::Placed;
use crate::text::document::{Document, Table};
use crate::text::fault::Fault;
use crate::text::file::{ModelFile, Vector};

const HELP: &str = "take a lower speed, or see that it, moduli and densities have the right units";

/// Refuses boundaries and bodies that are so fast that a run stops. A boundary that reaches such a speed
/// after the end of the run, or that a servo drives, or that acts in some of the stages alone, is a warning.
pub(crate) fn check<const D: usize, const N: usize>(
    (file, document): (&ModelFile, &Document<'_>),
    model: &Model<D, N>,
    placed: &[Placed<D, N>],
    warnings: &mut Vec<String>,
    faults: &mut Vec<Fault>,
) {
    let limit = model.speed_limit();
    let message = |title: &str, speed: f64| {
        format!(
            "{title} moves at {} m/s: a run stops where a node is faster than 10 times the speed of waves in the bodies, {} m/s",
            brief(speed),
            brief(limit)
        )
    };
    for boundary in &model.boundaries {
        let title = format!("[[boundary]] \"{}\"", boundary.name);
        let speed = |end: f64| boundary.greatest_speed(&model.mesh.nodes, end);
        let Some(index) = file.boundary.iter().position(|given| given.name == boundary.name) else {
            continue;
        };
        let given = &file.boundary[index];
        let is_sure = given.servo.is_none() && given.stages.is_none() && speed(file.model.end_time) > limit;
        if is_sure {
            let span = document.value(Table::of("boundary", index), key(boundary));
            let fault = Fault::at(span, message(&title, speed(file.model.end_time))).label("too fast");
            faults.push(fault.help(HELP));
        } else if speed(f64::INFINITY) > limit {
            warnings.push(message(&title, speed(f64::INFINITY)));
        }
    }
    let velocities = |body: &Placed<D, N>| {
        let first = body.first[0] as usize;
        model.velocities.get(first..first + body.piece.nodes.len()).unwrap_or_default()
    };
    let length = |velocity: &[f64; D]| velocity.iter().fold(0.0, |sum: f64, x| sum.hypot(*x));
    let fastest = |body: &Placed<D, N>| velocities(body).iter().map(length).fold(0.0, f64::max);
    // Pieces of a packing have the velocity of their table.
    let mut known = None;
    for body in placed.iter().filter(|body| fastest(body) > limit) {
        if known.replace(body.table) == Some(body.table) {
            continue;
        }
        let (of_file, table) = (&file.body[body.table], Table::of("body", body.table));
        let own = of_file.velocity.as_ref().map(Vector::components);
        let span = match own {
            Some(own) if of_file.spin.is_none() || length(&own) > limit => document.value(table, "velocity"),
            _ if of_file.spin.is_some() => document.value(table, "spin"),
            _ => document.value(Table::one("initial"), &format!("velocity.{}", of_file.name)),
        };
        let title = format!("[[body]] \"{}\"", of_file.name);
        let fault = Fault::at(span, message(&title, fastest(body))).label("too fast");
        faults.push(fault.help(HELP));
    }
}

/// The key of the speed of a boundary.
fn key<const D: usize>(boundary: &Boundary<D>) -> &'static str {
    match boundary.load {
        Load::Rotation { .. } => "rotation.speed",
        Load::Displacement(_) => "displacement",
        _ => "velocity",
    }
}
