//! Gravity without a ramp on bodies that rest.

use fdem_contact::{Couple, Detector, Elements, Filter, Search};
use fdem_io::numbers::brief;
use fdem_mesh::bounds;
use fdem_simulation::{Load, LoadEffect, Model, Schedule};

use crate::advice::deforming;
use crate::bodies::dimensions::Dimensions;
use crate::prepared::PreparedBody;

/// Bodies rest on each other if the gap between them is below this share of the shortest edge of an element's
/// box.
const RESTING: f64 = 1e-3;

/// Share of the tensile strength below which the weight of a body is no load.
const NO_LOAD: f64 = 0.01;

/// Passages of a wave through the height of the model in the ramp that is proposed: five periods of a column.
const PASSAGES: f64 = 20.0;

/// Ramp, s, that is longer than any solid needs: its modulus or density is that of none.
const ENDLESS: f64 = 1e6;

/// Warns of gravity without a ramp where a body that can break is held up, or where bodies rest on each
/// other. Rigid bodies have no stress that could swing.
pub(super) fn sudden<const D: usize, const N: usize>(
    model: &Model<D, N>,
    bodies: &[PreparedBody],
    warnings: &mut Vec<String>,
) where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let gravity = model.gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
    if gravity == 0.0 || model.gravity_schedule != Schedule::Constant {
        return;
    }
    let held = held_nodes(model);
    if !held.contains(&true) {
        return;
    }
    let [low, high] = bounds(model.mesh.nodes.iter().copied());
    let height =
        (0..D).map(|axis| (high[axis] - low[axis]) * model.gravity[axis].abs() / gravity).sum::<f64>();
    let of_body = |body: &PreparedBody| body.nodes.clone().map(|node| held[node as usize]);
    let wholly: Vec<bool> = bodies.iter().map(|body| of_body(body).all(|held| held)).collect();
    let carried = (0..).zip(bodies).zip(&wholly).any(|((number, body), wholly)| {
        let partly = of_body(body).any(|held| held) && !wholly && deforming::deforms(model, number);
        partly && breaks_under_weight(model, body, gravity * height)
    });
    if !carried && (bodies.len() < 2 || !rests(model, |body| wholly[body as usize])) {
        return;
    }
    let deforming = model.materials.iter().zip(deforming::materials(model)).filter(|(_, deforms)| *deforms);
    let slowest = deforming.map(|(material, _)| material.bar_speed()).fold(f64::INFINITY, f64::min);
    let ramp = PASSAGES * height / slowest;
    let remedy = if ramp < ENDLESS {
        format!("write gravity_ramp = {} in [model], or longer for what rocks", brief(ramp))
    } else {
        "write a gravity_ramp in [model]".to_owned()
    };
    warnings.push(format!(
        "gravity acts at once: what it carries swings to twice its static stress, and can fail where it would stand; \
         {remedy}"
    ));
}

/// Whether each node is held along the direction of gravity.
fn held_nodes<const D: usize, const N: usize>(model: &Model<D, N>) -> Vec<bool> {
    let mut held = vec![false; model.mesh.nodes.len()];
    for boundary in &model.boundaries {
        let holds = match boundary.load {
            Load::Velocity(components) | Load::Displacement(components) => {
                (0..D).any(|axis| components[axis].is_some() && model.gravity[axis] != 0.0)
            }
            Load::Rotation { .. } => true,
            _ => boundary.load.summary().effect == LoadEffect::Support,
        };
        if holds {
            for node in boundary.target.nodes() {
                held[node as usize] = true;
            }
        }
    }
    held
}

/// Whether a body has a material that breaks, and whose strength the weight of a column of this g H is a
/// share of.
fn breaks_under_weight<const D: usize, const N: usize>(
    model: &Model<D, N>,
    body: &PreparedBody,
    potential: f64,
) -> bool {
    body.elements.clone().any(|element| {
        let material = &model.materials[model.mesh.materials[element as usize] as usize];
        material.strength.is_some_and(|strength| material.density * potential > NO_LOAD * strength.tensile)
    })
}

/// Whether two bodies rest on each other at the beginning, of which at least one is not held as a whole, and
/// at least one deforms.
fn rests<const D: usize, const N: usize>(model: &Model<D, N>, wholly: impl Fn(u32) -> bool) -> bool
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mesh = &model.mesh;
    let corners = |element: u32| mesh.elements[element as usize].map(|node| mesh.nodes[node as usize]);
    let (low, high): (Vec<_>, Vec<_>) = (0..mesh.elements.len() as u32)
        .map(|element| bounds(corners(element).into_iter()))
        .map(|[low, high]| (low, high))
        .unzip();
    let edges =
        low.iter().zip(&high).flat_map(|(low, high)| low.iter().zip(high).map(|(low, high)| high - low));
    let gap = RESTING * edges.fold(f64::INFINITY, f64::min);
    let touches = |a: u32, b: u32| corners(a).gap(&corners(b)).is_some_and(|found| found <= gap);
    let mut rests = false;
    let found = Elements::boxes(&low, &high)
        .and_then(|boxes| boxes.with_tolerance(gap))
        .and_then(|boxes| boxes.with_filter(Filter::bodies(&mesh.bodies)))
        .and_then(|boxes| {
            Detector::new().for_each(&boxes, |Couple { i, j }| {
                let held = [i, j].into_iter().all(|element| wholly(mesh.bodies[element as usize]));
                let deforms = [i, j].into_iter().any(|element| !model.is_rigid(element));
                rests = rests || (!held && deforms && touches(i, j));
            })
        });
    // A model that cannot be searched cannot be run either, and is reported there.
    found.is_ok() && rests
}
