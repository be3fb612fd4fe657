//! Settings of the output, and quantities to record over time.

use fdem_results::{Field, LiquidIn, MOST_ELEMENTS, SAMPLE};

use crate::output::{coarse, fluid_columns, probes};
use crate::prepared::{Checkpoint, OutputSettings, PreparedHistory, Quantity};
use crate::shapes::placed::{self, Placed, is_body};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::{Animate, Gravity, History, ModelFile};

/// Wall-clock time between checkpoints, s.
const CHECKPOINT: f64 = 60.0;

/// Result files after the first, which is of the start.
const FRAMES: u32 = 50;

/// Rows of the history.
const ROWS: f64 = 1000.0;

/// Checks the output before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    if file.model.gravity_ramp.is_some() && matches!(file.model.gravity, Gravity::None(_)) {
        faults.push(
            Fault::at(
                document.key(Table::one("model"), "gravity_ramp"),
                "\"gravity_ramp\" goes with gravity",
            )
            .label("there is no gravity")
            .help("write gravity = [0, -9.81], in three dimensions [0, 0, -9.81], or take gravity_ramp out"),
        );
    }
    let output = &file.output;
    for (first, second, both) in [
        ("interval", "frames", output.interval.is_some() && output.frames.is_some()),
        (
            "checkpoint_interval",
            "checkpoint_steps",
            output.checkpoint_interval.is_some() && output.checkpoint_steps.is_some(),
        ),
    ] {
        if both {
            faults.push(
                Fault::at(
                    document.key(Table::one("output"), second),
                    format!("[output] has both {first} and {second}"),
                )
                .label("take one of them"),
            );
        }
    }
    if output.fields.as_ref().is_some_and(Vec::is_empty) {
        faults.push(
            Fault::at(document.value(Table::one("output"), "fields"), "\"fields\" is an empty list")
                .label("empty"),
        );
    }
    coarse::check(file, document, faults);
    check_fields(file, document, faults);
    for (index, name) in output.fragments.iter().flatten().enumerate() {
        if is_body(file, name) {
            continue;
        }
        faults.push(
            Fault::at(
                document.entry(Table::one("output"), "fragments", index),
                format!("there is no body \"{name}\""),
            )
            .label("unknown body")
            .help(placed::suggestion(file, name)),
        );
    }
    for (index, history) in file.history.iter().enumerate() {
        let table = Table::of("history", index);
        probes::check(file, index, document, faults);
        if probes::quantities(history).len() != 1 {
            faults.push(
                Fault::at(
                    document.key(table, "name"),
                    format!("[[history]] \"{}\" is of one quantity", history.name),
                )
                .label("this history")
                .help("give it one of node = [x, y] or [x, y, z], force = \"name of a boundary\", stress, strain or velocity = [x, y] or \"mean\", pore_pressure = [x, y], gauge = [[x, y], [x, y]], contact_force = [\"body\", \"body\"], reaction = \"group\", cavity = \"boundary\", joint_set = \"joint set\", motion = \"rigid body\", wall = \"wall\", grains = true, softening = true, energy = true, crack_length = true"),
            );
        }
        if let Some(name) = &history.body {
            if history.node.is_none() && !probes::takes_body(history) {
                faults.push(
                    Fault::at(
                        document.key(table, "body"),
                        "\"body\" goes with node, stress, strain, velocity, pore_pressure, gauge and reaction",
                    )
                    .label("take it out"),
                );
            } else if !name.is_empty() && !is_body(file, name) {
                faults.push(
                    Fault::at(document.value(table, "body"), format!("there is no body \"{name}\""))
                        .label("unknown body")
                        .help(placed::suggestion(file, name)),
                );
            }
        }
        if let Some(force) = &history.force
            && !file.boundary.iter().any(|boundary| boundary.name == *force)
        {
            let names: Vec<&str> = file.boundary.iter().map(|boundary| boundary.name.as_str()).collect();
            faults.push(
                Fault::at(document.value(table, "force"), format!("there is no boundary \"{force}\""))
                    .label("unknown boundary")
                    .help(suggestion(force, &names, "[[boundary]]")),
            );
        }
    }
}

/// Reports fields of a liquid where there is none.
fn check_fields(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let output = &file.output;
    let animated = match output.animate {
        Some(Animate::Field(field)) => Some(("animate", field)),
        _ => None,
    };
    let drawn = output.fields.iter().flatten().map(|field| ("fields", *field)).chain(animated);
    for (key, field) in drawn {
        let (what, table) = match field.quantity().liquid {
            Some(LiquidIn::Cracks) if file.fluid.is_none() => ("fluid", "[fluid]"),
            Some(LiquidIn::Pores) if file.pores.is_none() => ("liquid in pores", "[pores]"),
            _ => continue,
        };
        let message = format!("[output] {key} has \"{}\", and there is no {what}", field.key());
        faults.push(
            Fault::at(document.value(Table::one("output"), key), message)
                .label(format!("no {table}"))
                .help(format!("add a table {table}, or take the field out")),
        );
    }
}

/// The settings, with defaults. `file` has been checked.
pub(crate) fn settings<const D: usize, const N: usize>(
    file: &ModelFile,
    placed: &[Placed<D, N>],
) -> OutputSettings {
    let output = &file.output;
    let fields = output.fields.clone().filter(|fields| !fields.is_empty());
    let fields = fields.unwrap_or_else(|| vec![Field::MAX_PRINCIPAL, Field::VELOCITY, Field::DAMAGE]);
    let interval = output.history_interval.unwrap_or(file.model.end_time / ROWS);
    OutputSettings {
        interval: output
            .interval
            .unwrap_or_else(|| file.model.end_time / f64::from(output.frames.unwrap_or(FRAMES))),
        animate: match output.animate {
            Some(Animate::Switch(true)) => fields.first().copied(),
            Some(Animate::Field(field)) => Some(field),
            None | Some(Animate::Switch(false)) => None,
        },
        fields,
        shown: output.shown_elements.map_or([MOST_ELEMENTS, SAMPLE], |most| [most as usize; 2]),
        // Fluid flows in closed joints that have an aperture.
        intact_joints: output.intact_joints || fluid_columns::conducts(file),
        fragments: output.fragments.as_ref().map(|names| {
            let bodies = names.iter().flat_map(|name| placed::named(placed, file, name));
            bodies.map(|body| body as u32).collect()
        }),
        emission: output.acoustic_emission,
        coarse: output.coarse.as_ref().map(coarse::grid),
        checkpoint: match output.checkpoint_steps {
            Some(steps) => Checkpoint::Steps(steps),
            None => Checkpoint::Seconds(output.checkpoint_interval.unwrap_or(CHECKPOINT)),
        },
        given: given(file),
        history_interval: file.history.iter().filter_map(|history| history.interval).fold(interval, f64::min),
    }
}

/// Times between results that a file gives, s, with their keys.
fn given(file: &ModelFile) -> Vec<(String, f64)> {
    let output = &file.output;
    let frames = output.frames.map(|frames| file.model.end_time / f64::from(frames));
    let of_output =
        [("interval", output.interval), ("frames", frames), ("history_interval", output.history_interval)];
    let of_output = of_output.into_iter().filter_map(|(key, time)| Some((format!("[output] {key}"), time?)));
    let of_histories = file.history.iter().filter_map(|history| {
        Some((format!("[[history]] \"{}\": interval", history.name), history.interval?))
    });
    of_output.chain(of_histories).collect()
}

/// The histories, with the nodes, boundaries and probes that they are of. Probes are counted in the order of
/// their histories. `boundaries` and `file` have been checked.
pub(crate) fn histories<const D: usize, const N: usize>(
    file: &ModelFile,
    nodes: &[[f64; D]],
    placed: &[Placed<D, N>],
    warnings: &mut Vec<String>,
) -> Vec<PreparedHistory> {
    let mut histories = Vec::with_capacity(file.history.len());
    let mut probes = 0..file.history.len();
    for history in &file.history {
        let quantity = if let Some(point) = &history.node {
            let point = point.components::<D>();
            let bodies = match &history.body {
                Some(name) => placed::named(placed, file, name),
                None => (0..placed.len()).collect(),
            };
            let Some(found) = nearest(nodes, placed, &bodies, point) else { continue };
            let (node, gap) = if history.body.is_none() {
                of_staying_body(found, nodes, placed, point, file, history, warnings)
            } else {
                found
            };
            let size = bodies.iter().map(|&body| edge(&placed[body])).fold(0.0, f64::max);
            if gap > 2.0 * size {
                let at = nodes[node as usize].map(|x| format!("{x:.6}")).join(", ");
                warnings.push(format!(
                    "[[history]] \"{}\": the nearest node to {point:?} is {gap:.3e} m away, at [{at}]",
                    history.name
                ));
            }
            Quantity::Node(node)
        } else if let Some(name) = &history.force {
            let Some(place) = file.boundary.iter().position(|boundary| boundary.name == *name) else {
                continue;
            };
            match &file.boundary[place].rotation {
                Some(rotation) => Quantity::Torque(place, rotation.direction()),
                None => Quantity::Force(place),
            }
        } else if let Some(probe) = probes::is_probe(history).then(|| probes.next()).flatten() {
            Quantity::Probe(probe)
        } else if history.energy {
            Quantity::Energy
        } else {
            Quantity::CrackLength
        };
        histories.push(PreparedHistory { name: history.name.clone(), quantity });
    }
    histories
}

/// The node and distance that were found, or those of a body that no stage removes, if that has a node as
/// near. A node that a stage removes brings a warning.
fn of_staying_body<const D: usize, const N: usize>(
    (node, gap): (u32, f64),
    nodes: &[[f64; D]],
    placed: &[Placed<D, N>],
    point: [f64; D],
    file: &ModelFile,
    history: &History,
    warnings: &mut Vec<String>,
) -> (u32, f64) {
    let removed: Vec<usize> = file
        .stage
        .iter()
        .flat_map(|stage| &stage.excavate)
        .flat_map(|name| placed::named(placed, file, name))
        .collect();
    let has = |body: &usize| {
        let first = placed[*body].first[0];
        (first..first + placed[*body].piece.nodes.len() as u32).contains(&node)
    };
    let Some(&body) = removed.iter().find(|body| has(body)) else { return (node, gap) };
    let staying: Vec<usize> = (0..placed.len()).filter(|body| !removed.contains(body)).collect();
    let near = nearest(nodes, placed, &staying, point);
    // Nodes of two meshes at one place differ by rounding.
    if let Some(found) = near.filter(|(_, other)| *other <= gap + 1e-9 * edge(&placed[body])) {
        return found;
    }
    warnings.push(format!(
        "[[history]] \"{}\": the node nearest to {point:?} is removed by a stage, and has no values from then on; \
         write body = \"...\" to choose the body",
        history.name
    ));
    (node, gap)
}

/// The nearest node of some bodies, and how far it is.
fn nearest<const D: usize, const N: usize>(
    nodes: &[[f64; D]],
    placed: &[Placed<D, N>],
    bodies: &[usize],
    point: [f64; D],
) -> Option<(u32, f64)> {
    let all = bodies.iter().flat_map(|&body| {
        let first = placed[body].first[0];
        first..first + placed[body].piece.nodes.len() as u32
    });
    all.map(|node| (node, distance(nodes[node as usize], point))).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// An edge of a body, m.
fn edge<const D: usize, const N: usize>(placed: &Placed<D, N>) -> f64 {
    let Some(element) = placed.piece.elements.first() else { return 0.0 };
    distance(placed.piece.nodes[element[0] as usize], placed.piece.nodes[element[1] as usize])
}

fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}
