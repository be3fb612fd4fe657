//! Checks of the numbers of a model, once before anything is computed.

use std::collections::BTreeSet;

use crate::error::ModelError;
use crate::laws::Refusal;
use crate::model::{Insertion, Load, Model, Schedule, Strength, Target};
use crate::simplex::Simplex;
use crate::topology::NONE;

pub(crate) fn check<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    mesh(model)?;
    grains(model)?;
    for material in &model.materials {
        let place = format!("material '{}'", material.name);
        positive(&place, "density", material.density)?;
        positive(&place, "Young's modulus", material.youngs_modulus)?;
        material
            .law
            .check::<D, N>(material.youngs_modulus, material.poissons_ratio, model.plane)
            .map_err(|Refusal { what, value, range }| out_of_range(&place, what, value, range))?;
        not_negative(&place, "damping", material.damping)?;
        not_negative(&place, "friction", material.friction)?;
        material.strength.iter().try_for_each(|strength| strength_of(&place, strength))?;
    }
    for interface in &model.interfaces {
        let [a, b] = interface.materials;
        let place = format!("interface of materials {a} and {b}");
        for index in interface.materials {
            if index as usize >= model.materials.len() {
                return Err(ModelError::Missing { what: "material", index, place });
            }
        }
        not_negative(&place, "friction", interface.friction)?;
        interface.penalty.map_or(Ok(()), |penalty| positive(&place, "penalty", penalty))?;
        interface.strength.iter().try_for_each(|strength| strength_of_joints(&place, strength))?;
    }
    rigid(model)?;
    until_overloaded(model)?;
    joint_sets(model)?;
    boundaries(model)?;
    pores(model)?;
    schedule("gravity", &model.gravity_schedule)?;
    positive("the model", "thickness", model.thickness)?;
    for (what, values) in [("gravity", [model.gravity].as_slice()), ("initial velocity", &model.velocities)] {
        finite("the model", what, values.iter().flatten())?;
    }
    finite("the model", "initial stress", model.stresses.iter().flatten().flatten())?;
    if let Some(&value) = model.mass_factors.iter().find(|factor| !(**factor >= 1.0 && factor.is_finite())) {
        return Err(out_of_range("the model", "factor of a mass", value, "at least 1"));
    }
    let contact = &model.contact;
    positive("contact", "penalty", contact.penalty)?;
    not_negative("contact", "tangential stiffness", contact.tangential_stiffness)?;
    not_negative("contact", "damping", contact.damping)?;
    not_negative("contact", "buffer", contact.buffer)?;
    contact.overlap_time.map_or(Ok(()), |time| positive("contact", "overlap time", time))?;
    positive("fracture", "joint penalty", model.fracture.joint_penalty)?;
    let time = &model.time;
    time.step.map_or(Ok(()), |step| positive("time", "step", step))?;
    if !(time.safety > 0.0 && time.safety <= 1.0) {
        return Err(out_of_range("time", "safety", time.safety, "above 0 and at most 1"));
    }
    if !(0.0..1.0).contains(&time.local_damping) {
        return Err(out_of_range("time", "local damping", time.local_damping, "from 0 to below 1"));
    }
    positive("time", "energy bound", time.energy_bound)
}

/// Spheres and bodies have the same materials, gravity and thickness.
fn grains<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Some(grains) = &model.grains else { return Ok(()) };
    grains.check()?;
    let place = "the spheres";
    if let Some(thickness) = grains.discs {
        if !<[[f64; D]; N]>::IS_TRIANGLE {
            return Err(out_of_range(place, "thickness as discs", thickness, "absent in three dimensions"));
        }
        if thickness != model.thickness {
            return Err(out_of_range(place, "thickness as discs", thickness, "that of the model"));
        }
    }
    // Spheres alone need no numbers of bodies.
    if model.mesh.elements.is_empty() {
        return Ok(());
    }
    if <[[f64; D]; N]>::IS_TRIANGLE && grains.discs.is_none() {
        return Err(out_of_range(
            place,
            "thickness as discs",
            f64::NAN,
            "that of the model among bodies in the plane",
        ));
    }
    if grains.materials.len() != model.materials.len() {
        let (what, found) = ("materials of spheres", grains.materials.len());
        return Err(ModelError::Length { what, found, expected: model.materials.len() });
    }
    for (axis, value) in grains.gravity.into_iter().enumerate() {
        if value != model.gravity.get(axis).copied().unwrap_or(0.0) {
            return Err(out_of_range(place, "gravity", value, "that of the model"));
        }
    }
    Ok(())
}

/// Each material has pores or none, and the flow is in a solid whose volume is known.
fn pores<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Some(pores) = &model.pores else { return Ok(()) };
    let (found, expected) = (pores.materials.len(), model.materials.len());
    if found != expected {
        return Err(ModelError::Length { what: "materials with pores or none", found, expected });
    }
    let (found, expected) = (pores.initial_pressures.len(), model.mesh.nodes.len());
    if found != 0 && found != expected {
        return Err(ModelError::Length { what: "initial pressures of pores", found, expected });
    }
    for (pores, material) in pores.materials.iter().zip(&model.materials) {
        let place = format!("pores of material '{}'", material.name);
        pores.as_ref().map_or(Ok(()), |pores| pores.check(&place).map_err(ModelError::Fluid))?;
    }
    if pores.steps == 0 {
        return Err(out_of_range(
            "pores",
            "number of steps of the solid in one of the flow",
            0.0,
            "at least 1",
        ));
    }
    if <[[f64; D]; N]>::is_plate(model.plane) {
        return Err(ModelError::Pores("the change of volume is not known in plane stress: use plane strain"));
    }
    if model.fluid.as_ref().is_some_and(|fluid| fluid.leak_off != 0.0) {
        return Err(ModelError::Pores(
            "fluid in cracks flows into them: the leak-off by a coefficient must be zero",
        ));
    }
    Ok(())
}

/// Rigid bodies are bodies of the mesh, in order.
fn rigid<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError> {
    let place = || "the rigid bodies".to_owned();
    if let Some(pair) = model.rigid.windows(2).find(|pair| pair[0] >= pair[1]) {
        let what = "ascending number of a body";
        return Err(ModelError::Missing { what, index: pair[1], place: place() });
    }
    if model.rigid.is_empty() {
        return Ok(());
    }
    let bodies: BTreeSet<u32> = model.mesh.bodies.iter().copied().collect();
    match model.rigid.iter().find(|body| !bodies.contains(body)) {
        Some(&index) => Err(ModelError::Missing { what: "body", index, place: place() }),
        None => Ok(()),
    }
}

impl<const D: usize, const N: usize> Model<D, N> {
    /// Checks the bodies that are rigid until they are overloaded.
    ///
    /// # Errors
    /// [`ModelError::UntilOverloaded`] if one cannot deform later, [`ModelError::Missing`] and
    /// [`ModelError::OutOfRange`] if numbers are wrong.
    pub fn check_until_overloaded(&self) -> Result<(), ModelError> {
        until_overloaded(self)
    }
}

/// Bodies that are rigid until they are overloaded are bodies of the mesh, in order, and can break.
fn until_overloaded<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError> {
    let all = &model.until_overloaded;
    if all.is_empty() {
        return Ok(());
    }
    if let Some(pair) = all.windows(2).find(|pair| pair[0].body >= pair[1].body) {
        let place = "the bodies that are rigid until they are overloaded".to_owned();
        return Err(ModelError::Missing { what: "ascending number of a body", index: pair[1].body, place });
    }
    for of in all {
        let place = format!("body {}", of.body);
        if !(of.share > 0.0 && of.share <= 1.0) {
            return Err(out_of_range(&place, "share of its strength", of.share, "above 0 and at most 1"));
        }
    }
    let mesh = &model.mesh;
    let own =
        || (0..mesh.elements.len()).filter(|&element| model.until_overloaded(mesh.bodies[element]).is_some());
    let refused = |body: u32, why| Err(ModelError::UntilOverloaded { body, why });
    if let Some(element) = own().find(|&of| model.materials[mesh.materials[of] as usize].strength.is_none()) {
        return refused(mesh.bodies[element], "its material has no strength");
    }
    let Some(first) = own().next().map(|element| mesh.bodies[element]) else {
        let index = all[0].body;
        return Err(ModelError::Missing { what: "body", index, place: "the rigid bodies".to_owned() });
    };
    if model.fracture.insertion == Insertion::Intrinsic {
        return refused(first, "joints are on all facets from the beginning");
    }
    if !model.stresses.is_empty() {
        return refused(first, "the model begins with a stress");
    }
    if !model.mass_factors.is_empty() {
        return refused(first, "masses are scaled");
    }
    let is_in_set = |&element: &usize| model.joint_facets.get(element).is_some_and(|of| *of != [NONE; N]);
    if let Some(element) = own().find(is_in_set) {
        return refused(mesh.bodies[element], "a joint set is in it");
    }
    let moved: BTreeSet<u32> = model
        .boundaries
        .iter()
        .filter(|boundary| boundary.load.moves_nodes())
        .flat_map(|boundary| boundary.target.nodes())
        .collect();
    match own().find(|&element| mesh.elements[element].iter().any(|node| moved.contains(node))) {
        Some(element) => refused(mesh.bodies[element], "a boundary holds or moves it"),
        None => Ok(()),
    }
}

fn joint_sets<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError> {
    for set in &model.joint_sets {
        let place = format!("joint set '{}'", set.name);
        strength_of_joints(&place, &set.strength)?;
        not_negative(&place, "residual friction", set.residual_friction)?;
        not_negative(&place, "dilation", set.dilation)?;
        if set.dilation > set.residual_friction {
            return Err(out_of_range(&place, "dilation", set.dilation, "at most the residual friction"));
        }
        if let Some(slip) = set.dilation_slip {
            not_negative(&place, "slip of dilation", slip)?;
        }
        for (what, stiffness) in
            [("normal stiffness", set.normal_stiffness), ("shear stiffness", set.shear_stiffness)]
        {
            stiffness.map_or(Ok(()), |stiffness| positive(&place, what, stiffness))?;
        }
    }
    let count = model.joint_sets.len();
    match model.joint_facets.iter().flatten().find(|&&set| set != NONE && set as usize >= count) {
        Some(&index) => {
            Err(ModelError::Missing { what: "joint set", index, place: "the facets of joints".to_owned() })
        }
        None => Ok(()),
    }
}

fn mesh<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mesh = &model.mesh;
    let (nodes, elements) = (mesh.nodes.len(), mesh.elements.len());
    if elements == 0
        && model.grains.as_ref().is_none_or(|of| of.spheres.positions.is_empty() && of.insertions.is_empty())
    {
        return Err(ModelError::Empty);
    }
    if elements > u32::MAX as usize / N - 1 || nodes > u32::MAX as usize / N - 1 {
        return Err(ModelError::TooLarge { elements });
    }
    let lengths = [
        ("bodies", mesh.bodies.len(), elements, false),
        ("materials", mesh.materials.len(), elements, false),
        ("initial velocities", model.velocities.len(), nodes, true),
        ("initial stresses", model.stresses.len(), elements, true),
        ("joint sets of facets", model.joint_facets.len(), elements, true),
        ("factors of masses", model.mass_factors.len(), elements, true),
    ];
    for (what, found, expected, optional) in lengths {
        if found != expected && !(optional && found == 0) {
            return Err(ModelError::Length { what, found, expected });
        }
    }
    for (node, coordinates) in mesh.nodes.iter().enumerate() {
        finite(&format!("node {node}"), "a coordinate", coordinates)?;
    }
    let bonded = bonded_nodes(model);
    let mut body_of = vec![None; nodes];
    for (element, corners) in mesh.elements.iter().enumerate() {
        let place = || format!("element {element}");
        for &node in corners {
            let Some(known) = body_of.get_mut(node as usize) else {
                return Err(ModelError::Missing { what: "node", index: node, place: place() });
            };
            let body = mesh.bodies[element];
            match *known {
                Some(other)
                    if other != body
                        && (!bonded.contains(&node)
                            || [other, body].iter().any(|body| model.rigid.contains(body))) =>
                {
                    return Err(ModelError::SharedNode { node, bodies: [other, body] });
                }
                _ => *known = Some(body),
            }
        }
        let area = corners.map(|node| mesh.nodes[node as usize]).measure();
        if area <= 0.0 || !area.is_finite() {
            return Err(ModelError::Area { element, area });
        }
        let material = mesh.materials[element];
        if material as usize >= model.materials.len() {
            return Err(ModelError::Missing { what: "material", index: material, place: place() });
        }
    }
    Ok(())
}

fn boundaries<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<(), ModelError> {
    for boundary in &model.boundaries {
        let place = format!("boundary '{}'", boundary.name);
        let nodes = boundary.target.nodes();
        if let Some(&index) = nodes.iter().find(|&&node| node as usize >= model.mesh.nodes.len()) {
            return Err(ModelError::Missing { what: "node", index, place });
        }
        let values = match (&boundary.load, &boundary.target) {
            (Load::Held, Target::Held(facets, forces)) if facets.len() == forces.len() => {
                forces.as_flattened().as_flattened().to_vec()
            }
            (Load::Held, _) => {
                return Err(ModelError::Target { boundary: boundary.name.clone(), needs: "held facets" });
            }
            (load, _) => load.summary().components,
        };
        finite(&place, "a value", &values)?;
        schedule(&place, &boundary.schedule)?;
    }
    Ok(())
}

fn schedule(place: &str, of: &Schedule) -> Result<(), ModelError> {
    match of {
        Schedule::Constant => Ok(()),
        Schedule::Ramp(duration) => positive(place, "the duration of the ramp", *duration),
        Schedule::Table(rows) => {
            finite(place, "a value of the table", rows.iter().flatten())?;
            if rows.is_empty() {
                return Err(out_of_range(place, "the number of rows of the table", 0.0, "at least 1"));
            }
            match rows.windows(2).find(|pair| pair[0][0] >= pair[1][0]) {
                Some(pair) => {
                    Err(out_of_range(place, "a time of the table", pair[1][0], "later than the one before"))
                }
                None => Ok(()),
            }
        }
        Schedule::From(start, inner) => {
            finite(place, "the time at which it begins", [start])?;
            schedule(place, inner)
        }
    }
}

fn strength_of(place: &str, strength: &Strength) -> Result<(), ModelError> {
    positive(place, "tensile strength", strength.tensile)?;
    positive(place, "cohesion", strength.cohesion)?;
    not_negative(place, "internal friction", strength.friction)?;
    positive(place, "fracture energy of opening", strength.energy_i)?;
    positive(place, "fracture energy of sliding", strength.energy_ii)?;
    match strength.weibull_modulus {
        // With less, nearly all edges have no strength, and in the limit the mean is no number.
        Some(modulus) if !(modulus >= 1.0 && modulus.is_finite()) => {
            Err(out_of_range(place, "Weibull modulus", modulus, "at least 1"))
        }
        _ => Ok(()),
    }
}

/// Strength of joints, which may be 0 and then needs no fracture energy: that of an open joint.
fn strength_of_joints(place: &str, strength: &Strength) -> Result<(), ModelError> {
    not_negative(place, "tensile strength", strength.tensile)?;
    not_negative(place, "cohesion", strength.cohesion)?;
    let or_one = |strength: f64, energy: f64| if strength == 0.0 && energy >= 0.0 { 1.0 } else { energy };
    let any = |strength: f64| if strength == 0.0 { 1.0 } else { strength };
    strength_of(
        place,
        &Strength {
            tensile: any(strength.tensile),
            cohesion: any(strength.cohesion),
            energy_i: or_one(strength.tensile, strength.energy_i),
            energy_ii: or_one(strength.cohesion, strength.energy_ii),
            ..*strength
        },
    )
}

fn out_of_range(place: &str, what: &'static str, value: f64, range: &'static str) -> ModelError {
    ModelError::OutOfRange { place: place.to_owned(), what, value, range }
}

fn positive(place: &str, what: &'static str, value: f64) -> Result<(), ModelError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(out_of_range(place, what, value, "positive")) }
}

fn not_negative(place: &str, what: &'static str, value: f64) -> Result<(), ModelError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(out_of_range(place, what, value, "0 or positive"))
    }
}

fn finite<'a>(
    place: &str,
    what: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), ModelError> {
    match values.into_iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(out_of_range(place, what, value, "a finite number")),
        None => Ok(()),
    }
}

/// Nodes of facets on joints of joint sets: bodies that are bonded share them.
fn bonded_nodes<const D: usize, const N: usize>(model: &Model<D, N>) -> BTreeSet<u32>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let facets = model.mesh.elements.iter().zip(&model.joint_facets);
    let on_joints = |(element, sets): (&[u32; N], &[u32; N])| {
        let facets = <[[f64; D]; N]>::FACETS.into_iter().zip(*sets).filter(|(_, set)| *set != NONE);
        facets.flat_map(|(facet, _)| facet.map(|corner| element[corner])).collect::<Vec<u32>>()
    };
    facets.flat_map(on_joints).collect()
}
