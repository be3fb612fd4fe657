//! Velocities and stresses at the start of a run.

use fdem_mesh::{Corners, Mesh};
use fdem_simulation::PoreOptions;

use crate::bodies::dimensions::Dimensions;
use crate::shapes::piece::Piece;
use crate::shapes::placed::Placed;
use crate::stages::pores;
use crate::stages::resolve::appearing;
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, nearest};
use crate::text::file::{self, ModelFile, Vector};

/// Checks `[initial]` before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, is_in_space: bool, faults: &mut Vec<Fault>) {
    let table = Table::one("initial");
    if let Some(principal) = &file.initial.principal {
        check_principal(principal, (document, table), is_in_space, faults);
        if file.initial.stress.is_some() {
            faults.push(
                Fault::at(document.key(table, "principal"), "[initial] has both stress and principal")
                    .label("a second stress")
                    .help("take one of the two out"),
            );
        }
    }
    if let Some(ground) = &file.initial.ground {
        let down = match &file.model.gravity {
            file::Gravity::Vector(gravity) => {
                let (last, others) = gravity.0.split_last().unwrap_or((&0.0, &[]));
                *last < 0.0 && others.iter().all(|across| *across == 0.0)
            }
            file::Gravity::None(_) => false,
        };
        if !down {
            faults.push(
                Fault::at(document.key(table, "ground"), "\"ground\" goes with gravity along the last axis")
                    .label("no gravity down")
                    .help("write gravity = [0, -9.81], in three dimensions [0, 0, -9.81], or give stress and stress_gradient"),
            );
        }
        if !is_in_space && file.model.plane == fdem_simulation::Plane::Stress {
            faults.push(
                Fault::at(
                    document.key(table, "ground"),
                    "\"ground\" has a stress across the plane, and plane stress has none",
                )
                .label("a thin plate is no ground")
                .help("write plane = \"strain\" in [model]: a slice of the ground"),
            );
        }
        if file.model.gravity_ramp.is_some() {
            faults.push(
                Fault::at(document.key(table, "ground"), "\"ground\" is at rest under the whole of gravity")
                    .label("gravity_ramp begins without it")
                    .help("take gravity_ramp out"),
            );
        }
        let one_axis = [Some(ground.k0), ground.tectonic];
        for (key, ratio) in ["ground.k0", "ground.tectonic"].into_iter().zip(one_axis) {
            if matches!(ratio, Some(file::Ratio::Each(_))) && !is_in_space {
                faults.push(
                    Fault::at(document.value(table, key), "two dimensions have one horizontal axis")
                        .label("one number is enough"),
                );
            }
        }
    }
    for name in file.initial.velocity.keys() {
        let span = || document.key(table, &format!("velocity.{name}"));
        match file.body.iter().find(|body| body.name == *name) {
            Some(body) if body.velocity.is_some() => faults.push(
                Fault::at(span(), format!("the body \"{name}\" has a velocity of its own"))
                    .label("a second velocity"),
            ),
            Some(_) => {}
            None => {
                let near = nearest(name, file.body.iter().map(|body| body.name.as_str()));
                faults.push(
                    Fault::at(span(), format!("there is no body \"{name}\""))
                        .label("unknown body")
                        .maybe_help(near.map(|near| format!("did you mean \"{near}\"?"))),
                );
            }
        }
    }
}

/// Checks the keys of principal stresses, and their order.
fn check_principal(
    principal: &file::Principal,
    (document, table): (&Document<'_>, Table),
    is_in_space: bool,
    faults: &mut Vec<Fault>,
) {
    let [flat, space] = principal.of_dimensions();
    let (own, others, place) =
        if is_in_space { (&space, &flat, "three dimensions") } else { (&flat, &space, "two dimensions") };
    for (key, _) in others.iter().filter(|(_, given)| *given) {
        let span = document.key(table, &format!("principal.{key}"));
        faults.push(
            Fault::at(span, format!("a principal stress in {place} has no \"{key}\"")).label("take it out"),
        );
    }
    let missing: Vec<&str> =
        own.iter().filter(|(key, given)| !given && *key != "rake").map(|(key, _)| *key).collect();
    if !missing.is_empty() {
        let text = format!("a principal stress in {place} needs {}", missing.join(", "));
        faults.push(Fault::at(document.key(table, "principal"), text).label("is not complete"));
        return;
    }
    let values = [principal.sigma1, principal.sigma2.unwrap_or(principal.sigma3), principal.sigma3];
    if !values.is_sorted() {
        faults.push(
            Fault::at(document.key(table, "principal"), "the principal stresses are not in their order")
                .label("out of order")
                .help("tension is positive: sigma1, the largest compression, is the least number, sigma3 the largest"),
        );
    }
}

/// Velocity of each node at the start; empty if all nodes rest.
pub(crate) fn velocities<const D: usize, const N: usize>(
    file: &ModelFile,
    placed: &[Placed<D, N>],
) -> Vec<[f64; D]>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mut velocities = Vec::new();
    for body in placed {
        let table = &file.body[body.table];
        let velocity = table.velocity.as_ref().or_else(|| file.initial.velocity.get(&table.name));
        let velocity: [f64; D] = velocity.map_or([0.0; D], Vector::components);
        let Some(spin) = table.spin else {
            velocities.extend(std::iter::repeat_n(velocity, body.piece.nodes.len()));
            continue;
        };
        let ([a, b, c], middle) = (spin.vector(), centroid(&body.piece));
        velocities.extend(body.piece.nodes.iter().map(|node| {
            let arm = |axis: usize| if axis < D { node[axis] - middle[axis] } else { 0.0 };
            let [x, y, z] = [arm(0), arm(1), arm(2)];
            let turning = [b * z - c * y, c * x - a * z, a * y - b * x];
            std::array::from_fn(|axis| velocity[axis] + turning[axis])
        }));
    }
    if velocities.iter().all(|velocity| *velocity == [0.0; D]) {
        velocities.clear();
    }
    velocities
}

/// Centroid of a body.
fn centroid<const D: usize, const N: usize>(piece: &Piece<D, N>) -> [f64; D]
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let (mut measure, mut moment) = (0.0, [0.0; D]);
    for element in &piece.elements {
        let corners = piece.corners(element);
        let of_element = corners.measure();
        measure += of_element;
        for axis in 0..D {
            moment[axis] += of_element * corners.iter().map(|corner| corner[axis]).sum::<f64>() / N as f64;
        }
    }
    moment.map(|x| x / measure)
}

/// Initial stress of each element, that of its centroid; empty for none. Bodies that appear later have none.
pub(crate) fn stresses<const D: usize, const N: usize>(
    file: &ModelFile,
    mesh: &Mesh<D, N>,
    placed: &[Placed<D, N>],
    pores: Option<&PoreOptions<D>>,
) -> Vec<[[f64; D]; D]>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let (stress, gradient) = (&file.initial.components(D), &file.initial.stress_gradient);
    let ground = file.initial.ground.as_ref();
    if stress.is_none() && gradient.is_none() && ground.is_none() {
        return Vec::new();
    }
    let none = vec![0.0; D * (D + 1) / 2];
    if stress.is_none() && ground.is_none() && gradient.as_ref() == Some(&none) {
        return Vec::new();
    }
    let [stress, gradient] = [stress, gradient].map(|given| given.as_ref().unwrap_or(&none));
    let gravity = match &file.model.gravity {
        file::Gravity::Vector(gravity) => -gravity.components::<D>()[D - 1],
        file::Gravity::None(_) => 0.0,
    };
    let pores = pores::at_first(file, pores);
    let of = |(nodes, material): (&[u32; N], &u32)| {
        let height = nodes.iter().map(|&node| mesh.nodes[node as usize][D - 1]).sum::<f64>() / N as f64;
        let mut components: Vec<f64> =
            stress.iter().zip(gradient).map(|(stress, gradient)| stress + gradient * height).collect();
        if let Some(ground) = ground {
            let density =
                ground.density.unwrap_or_else(|| file.material.first().map_or(0.0, |first| first.density));
            // Water stands on ground below its level, and the liquid in pores bears its part of the weight.
            let vertical = -density * gravity * (ground.surface - height).max(0.0)
                - gravity * pores::standing(file, pores, ground.surface)
                + pores::push(pores, nodes, *material);
            let (k0, tectonic) = (ground.k0.along(), ground.tectonic.map_or([0.0; 2], file::Ratio::along));
            components[D - 1] += vertical;
            for axis in 0..D - 1 {
                components[axis] +=
                    k0[axis] * vertical + if height < ground.surface { tectonic[axis] } else { 0.0 };
            }
        }
        <[[f64; D]; N]>::stress(&components)
    };
    let mut stresses: Vec<[[f64; D]; D]> = mesh.elements.iter().zip(&mesh.materials).map(of).collect();
    for range in appearing(file, placed) {
        stresses[range].fill([[0.0; D]; D]);
    }
    stresses
}
