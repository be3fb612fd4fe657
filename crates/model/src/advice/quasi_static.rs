//! Advice for runs that look for a state of rest: the duration of loads, the speed of boundaries, and damping
//! of the waves that they send.

use fdem_io::numbers::brief;
use fdem_simulation::{Boundary, Load, LoadEffect, LoadSummary, Material, Model, Schedule};

use crate::advice::deforming;
use crate::advice::loading_rate;
use crate::text::file::{ModelFile, Stage};

/// Passages of a wave through the model in which a load comes slowly, and those below which it sends a wave.
const SLOW: f64 = 20.0;
const SUDDEN: f64 = 3.0;

/// Passage of a wave, s, that is longer than in any solid.
const ENDLESS: f64 = 1e6;

/// Damping of a material, as a share of critical damping, with which waves die out soon.
const VISCOUS: f64 = 0.1;

/// Local damping that is proposed.
const DAMPING: f64 = 0.7;

/// Whether a model is meant to be quasi-static: its motion is damped, or it is driven without weight and does
/// not break, and nothing in it flies or rings.
pub(crate) fn is_quasi_static<const D: usize, const N: usize>(model: &Model<D, N>) -> bool {
    let is_damped = model.time.local_damping > 0.0 || model.time.dynamic_relaxation;
    let is_driven = || model.gravity == [0.0; D] && !breaks(model) && model.boundaries.iter().any(lasts);
    is_without_waves(model) && (is_damped || is_driven())
}

/// Whether no body has a velocity, and no waves are to leave.
fn is_without_waves<const D: usize, const N: usize>(model: &Model<D, N>) -> bool {
    let absorbs = |boundary: &Boundary<D>| boundary.load == Load::Absorbing;
    let pulses = |boundary: &Boundary<D>| acts(boundary) && !lasts(boundary);
    model.velocities.is_empty()
        && !model.boundaries.iter().any(|boundary| absorbs(boundary) || pulses(boundary))
}

/// Whether a boundary moves or loads anything.
fn acts<const D: usize>(boundary: &Boundary<D>) -> bool {
    boundary.load.summary().components.iter().any(|component| *component != 0.0)
}

/// Whether a boundary moves or loads anything, and does not become less with time, as a pulse does.
fn lasts<const D: usize>(boundary: &Boundary<D>) -> bool {
    acts(boundary) && stays(&boundary.schedule)
}

fn stays(schedule: &Schedule) -> bool {
    match schedule {
        Schedule::Constant | Schedule::Ramp(_) => true,
        Schedule::Table(rows) => rows.windows(2).all(|pair| pair[1][1].abs() >= pair[0][1].abs()),
        Schedule::From(_, inner) => stays(inner),
    }
}

/// Time in which a factor grows from 0 to its full value, s; 0 if it starts at this value, `None` if it is
/// more than one ramp.
fn duration(schedule: &Schedule) -> Option<f64> {
    match schedule {
        Schedule::Constant => Some(0.0),
        Schedule::Ramp(duration) => Some(*duration),
        Schedule::Table(rows) => match rows[..] {
            [[start, 0.0], [end, _]] => Some(end - start),
            [[_, first]] if first != 0.0 => Some(0.0),
            _ => None,
        },
        Schedule::From(_, inner) => duration(inner),
    }
}

/// Adds advice if a model is meant to come to rest, and does not.
pub(crate) fn advice<const D: usize, const N: usize>(
    file: &ModelFile,
    model: &Model<D, N>,
    warnings: &mut Vec<String>,
) {
    undamped_stages(file, model, warnings);
    let relaxes = |stage: &Stage| stage.dynamic_relaxation == Some(true);
    if !model.velocities.is_empty() && (model.time.dynamic_relaxation || file.stage.iter().any(relaxes)) {
        warnings.push(
            "a body begins with a velocity, and dynamic relaxation is for runs that look for a state of rest: it damps the motion after an impact"
                .to_owned(),
        );
    }
    if !is_without_waves(model) {
        return;
    }
    warnings.extend(loading_rate::advice(model, model.boundaries.iter().filter(|boundary| lasts(boundary))));
    let passage = passage(model);
    // Moduli and densities of no solid have a warning of their own.
    if passage > ENDLESS {
        return;
    }
    // Initial stress holds loads that are there from the beginning, a body that is not held has no state of
    // rest, and a body that does not break reaches it by damping.
    let is_damped = is_damped(file, model);
    if model.stresses.is_empty() && is_held(model) && (breaks(model) || !is_damped) {
        let damping = if is_damped {
            String::new()
        } else {
            format!(
                ", and local_damping = {DAMPING} or dynamic_relaxation = true in [model] if only that state counts"
            )
        };
        let mut lasting = model.boundaries.iter().filter(|boundary| lasts(boundary));
        warnings.extend(lasting.find_map(|boundary| sudden(boundary, passage, &damping)));
        warnings.extend(sudden_gravity(model, passage, &damping));
    }
}

/// Whether local damping or dynamic relaxation acts in any part of the run.
fn is_damped<const D: usize, const N: usize>(file: &ModelFile, model: &Model<D, N>) -> bool {
    let damps = |stage: &Stage| {
        stage.local_damping.is_some_and(|damping| damping > 0.0) || stage.dynamic_relaxation == Some(true)
    };
    model.time.local_damping > 0.0 || model.time.dynamic_relaxation || file.stage.iter().any(damps)
}

/// Time in which the slowest wave along a bar passes through the bodies that deform, s; 0 if none does.
pub(crate) fn passage<const D: usize, const N: usize>(model: &Model<D, N>) -> f64 {
    let [low, high] = deforming::extent(model);
    let length = (0..D).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let material = |element: u32| &model.materials[model.mesh.materials[element as usize] as usize];
    let waves = deforming::elements(model).map(|element| wave(material(element)));
    length / waves.fold(f64::INFINITY, f64::min)
}

/// Speed of a wave along a bar, m/s.
fn wave(material: &Material) -> f64 {
    material.bar_speed()
}

fn breaks<const D: usize, const N: usize>(model: &Model<D, N>) -> bool {
    deforming::breaks(model) || !model.joint_sets.is_empty()
}

/// Advice on a load that comes within a few passages of a wave. Motions without a ramp are reported
/// elsewhere.
fn sudden<const D: usize>(boundary: &Boundary<D>, passage: f64, damping: &str) -> Option<String> {
    let LoadSummary { key: what, effect, .. } = boundary.load.summary();
    if matches!(effect, LoadEffect::Velocity | LoadEffect::Support) {
        return None;
    }
    let within = duration(&boundary.schedule)?;
    if within >= SUDDEN * passage || (within == 0.0 && effect == LoadEffect::Displacement) {
        return None;
    }
    let when = if within == 0.0 {
        "is there at once, and stresses swing to twice their static values".to_owned()
    } else {
        format!(
            "is there after {} passages of a wave through the model, and its wave stays",
            brief(within / passage)
        )
    };
    Some(format!(
        "[[boundary]] \"{}\": its {what} {when}; if a state of rest is meant, write ramp = {}, which is {SLOW} passages{damping}",
        boundary.name,
        brief(SLOW * passage)
    ))
}

/// Advice on gravity that comes within a few passages of a wave. Full gravity from the first step on bodies
/// that can fail under it, or that rest on each other, is reported elsewhere.
fn sudden_gravity<const D: usize, const N: usize>(
    model: &Model<D, N>,
    passage: f64,
    damping: &str,
) -> Option<String> {
    if model.gravity == [0.0; D] {
        return None;
    }
    let within = duration(&model.gravity_schedule).filter(|within| *within < SUDDEN * passage)?;
    let bodies = &model.mesh.bodies;
    let when = match within {
        0.0 if breaks(model) || bodies.iter().any(|body| *body != bodies[0]) => return None,
        0.0 => "at once, and bodies swing about their state of rest".to_owned(),
        within => {
            format!(
                "within {} passages of a wave through the model, and its wave stays",
                brief(within / passage)
            )
        }
    };
    Some(format!(
        "gravity comes {when}; if a state of rest is meant, write gravity_ramp = {}, which is {SLOW} passages{damping}",
        brief(SLOW * passage)
    ))
}

/// Whether boundaries hold or move nodes of every body, so that none falls.
fn is_held<const D: usize, const N: usize>(model: &Model<D, N>) -> bool {
    let mut held = vec![false; model.mesh.nodes.len()];
    for boundary in &model.boundaries {
        if boundary.load.moves_nodes() {
            for node in boundary.target.nodes() {
                held[node as usize] = true;
            }
        }
    }
    let count = model.mesh.bodies.iter().max().map_or(0, |last| *last as usize + 1);
    let mut of_bodies = vec![false; count];
    for (nodes, &body) in model.mesh.elements.iter().zip(&model.mesh.bodies) {
        of_bodies[body as usize] |= nodes.iter().any(|&node| held[node as usize]);
    }
    of_bodies.iter().all(|held| *held)
}

/// Advice on stages that end at an equilibrium and are not damped. Initial stress is in equilibrium until
/// something changes.
fn undamped_stages<const D: usize, const N: usize>(
    file: &ModelFile,
    model: &Model<D, N>,
    warnings: &mut Vec<String>,
) {
    // The viscosity of all materials calms waves too, and rigid bodies have none.
    if deforming::none(model) || model.materials.iter().all(|material| material.damping >= VISCOUS) {
        return;
    }
    let initial = &file.initial;
    let rests = initial.ground.is_some()
        || initial.stress.is_some()
        || initial.principal.is_some()
        || initial.stress_gradient.is_some();
    for (number, stage) in file.stage.iter().enumerate() {
        if rests && number == 0 {
            continue;
        }
        let damping = stage.local_damping.unwrap_or(file.model.local_damping);
        let relaxes = stage.dynamic_relaxation.unwrap_or(file.model.dynamic_relaxation);
        if stage.equilibrium.is_some() && damping == 0.0 && !relaxes {
            warnings.push(format!(
                "[[stage]] \"{}\" ends at an equilibrium, and without damping waves need long to die out; write local_damping = {DAMPING} or dynamic_relaxation = true in it",
                stage.name
            ));
        }
    }
}
