//! Stages: parts of a run that differ in the elements that are there, in boundaries and in damping.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use fdem_mesh::Mesh;
use fdem_simulation::Schedule;

use crate::bodies::materials;
use crate::prepared::PreparedStage;
use crate::shapes::placed::{self, Placed};
use crate::stages::{fluid, pores};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::{self, ModelFile, Release};

/// Checks stages before anything is meshed.
pub(crate) fn check(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let names: Vec<&str> = file.stage.iter().map(|stage| stage.name.as_str()).collect();
    check_lives(file, document, faults);
    for (index, boundary) in file.boundary.iter().enumerate() {
        let table = Table::of("boundary", index);
        for (entry, name) in boundary.stages.iter().flatten().enumerate() {
            if !names.contains(&name.as_str()) {
                faults.push(
                    Fault::at(
                        document.entry(table, "stages", entry),
                        format!("there is no stage \"{name}\""),
                    )
                    .label("unknown stage")
                    .help(suggestion(name, &names, "[[stage]]")),
                );
            }
        }
        if boundary.stages.as_ref().is_some_and(Vec::is_empty) {
            faults.push(
                Fault::at(
                    document.value(table, "stages"),
                    format!("[[boundary]] \"{}\" acts in no stage", boundary.name),
                )
                .label("empty"),
            );
        }
    }
    for (index, stage) in file.stage.iter().enumerate() {
        let table = Table::of("stage", index);
        let title = format!("[[stage]] \"{}\"", stage.name);
        if index == 0 {
            for (key, given) in [
                ("excavate", !stage.excavate.is_empty()),
                ("excavate_boxes", !stage.excavate_boxes.is_empty()),
                ("activate", !stage.activate.is_empty()),
                ("materials", !stage.materials.is_empty()),
                ("release", stage.release.is_some()),
            ] {
                if given {
                    faults.push(
                        Fault::at(
                            document.key(table, key),
                            format!("{title} is the first: \"{key}\" changes the state at the end of the stage before"),
                        )
                        .label("goes with a later stage")
                        .help("begin with a stage in which the bodies come to rest, with equilibrium = 1e-4 or a duration"),
                    );
                }
            }
        }
        let last = index + 1 == file.stage.len();
        let ends = stage.duration.is_some() || stage.equilibrium.is_some() || stage.until.is_some();
        if !last && !ends {
            faults.push(
                Fault::at(document.key(table, "name"), format!("{title} does not end before the run"))
                    .label("this stage")
                    .help("give it a duration, an equilibrium such as 1e-4, or an until"),
            );
        }
        if let Some(Release::Table(rows)) = &stage.release
            && rows.windows(2).any(|pair| pair[0][0] >= pair[1][0])
        {
            faults.push(
                Fault::at(
                    document.value(table, "release"),
                    format!("{title}: the times of its table do not ascend"),
                )
                .label("out of order"),
            );
        }
        for (body, material) in &stage.materials {
            let key = format!("materials.{body}");
            if !placed::is_body(file, body) {
                faults.push(
                    Fault::at(document.key(table, &key), format!("there is no body \"{body}\""))
                        .label("unknown body")
                        .help(placed::suggestion(file, body)),
                );
            }
            if let Err(help) = materials::number(file, material) {
                faults.push(materials::unknown(document.value(table, &key), material, help));
            }
        }
        for (key, bodies) in [("excavate", &stage.excavate), ("activate", &stage.activate)] {
            for (entry, name) in bodies.iter().enumerate() {
                if !placed::is_body(file, name) {
                    faults.push(
                        Fault::at(document.entry(table, key, entry), format!("there is no body \"{name}\""))
                            .label("unknown body")
                            .help(placed::suggestion(file, name)),
                    );
                }
            }
        }
    }
}

/// The stages in which a body is there, by their numbers.
pub(crate) fn lifetime(file: &ModelFile, body: &str) -> Range<usize> {
    let has = |names: &[String]| names.iter().any(|name| name == body || placed::is_piece(name, body));
    let first = file.stage.iter().position(|stage| has(&stage.activate)).unwrap_or(0);
    let last = file.stage.iter().position(|stage| has(&stage.excavate)).unwrap_or(file.stage.len());
    first..last
}

/// Reports bodies that are removed before they appear, or more than once.
fn check_lives(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let appears = |body: &String| file.stage.iter().any(|stage| stage.activate.contains(body));
    let mut there: BTreeMap<&String, bool> = BTreeMap::new();
    for (index, stage) in file.stage.iter().enumerate() {
        for (key, bodies, comes) in
            [("activate", &stage.activate, true), ("excavate", &stage.excavate, false)]
        {
            for (entry, body) in bodies.iter().enumerate() {
                let is_there = there.entry(body).or_insert_with(|| !appears(body));
                let twice = key == "excavate" && stage.activate.contains(body);
                if *is_there != comes && !twice {
                    *is_there = comes;
                    continue;
                }
                let why = match (twice, comes) {
                    (true, _) => "appears and vanishes in one stage",
                    (false, true) => "appears in a stage before, and does not come back",
                    (false, false) => "is not there before this stage",
                };
                let span = document.entry(Table::of("stage", index), key, entry);
                let message = format!("[[stage]] \"{}\": \"{body}\" {why}", stage.name);
                faults.push(Fault::at(span, message).label("take it out"));
            }
        }
    }
}

/// The elements of each of these bodies.
fn elements_of<const D: usize, const N: usize>(
    file: &ModelFile,
    placed: &[Placed<D, N>],
    names: &[String],
) -> Vec<Range<usize>> {
    let bodies = names.iter().flat_map(|name| placed::named(placed, file, name));
    let elements = |body: usize| {
        let first = placed[body].first[1] as usize;
        first..first + placed[body].piece.elements.len()
    };
    bodies.map(elements).collect()
}

/// The elements of all bodies that appear in a stage.
pub(crate) fn appearing<const D: usize, const N: usize>(
    file: &ModelFile,
    placed: &[Placed<D, N>],
) -> Vec<Range<usize>> {
    file.stage.iter().flat_map(|stage| elements_of(file, placed, &stage.activate)).collect()
}

/// Whether a point is in a box, given by its lower and its upper corner.
fn is_within<const D: usize>(limits: &[f64], point: [f64; D]) -> bool {
    (0..D).all(|axis| limits[axis] <= point[axis] && point[axis] <= limits[D + axis])
}

/// Reports pieces of packings, and copies, that do not exist: which there are is known once they are placed.
fn check_pieces<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    placed: &[Placed<D, N>],
    index: usize,
    faults: &mut Vec<Fault>,
) {
    let (stage, table) = (&file.stage[index], Table::of("stage", index));
    let materials =
        stage.materials.keys().map(|name| (document.key(table, &format!("materials.{name}")), name));
    let lists = [("excavate", &stage.excavate), ("activate", &stage.activate)];
    let entries = lists.into_iter().flat_map(|(key, names)| {
        names.iter().enumerate().map(move |(entry, name)| (document.entry(table, key, entry), name))
    });
    for (span, name) in materials.chain(entries) {
        if !placed::is_body(file, name) || !placed::named(placed, file, name).is_empty() {
            continue;
        }
        let of_table = |body: &&Placed<D, N>| placed::is_piece(&file.body[body.table].name, name);
        let mut names = placed.iter().filter(of_table).map(|body| body.name.as_str());
        let first = names.next().unwrap_or("none");
        let last = names.next_back().unwrap_or(first);
        let message = format!("there is no body \"{name}\"");
        let help = format!("the bodies of this table are \"{first}\" to \"{last}\"");
        faults.push(Fault::at(span, message).label("unknown body").help(help));
    }
}

/// Gives the elements of bodies the materials of a stage.
fn change_materials(
    file: &ModelFile,
    document: &Document<'_>,
    index: usize,
    elements_of: &dyn Fn(&[String]) -> Vec<Range<usize>>,
    of_elements: &mut [u32],
    faults: &mut Vec<Fault>,
) {
    let (stage, table) = (&file.stage[index], Table::of("stage", index));
    for (body, name) in &stage.materials {
        let Ok(material) = materials::number(file, name) else { continue };
        let density = |material: u32| file.material.get(material as usize).map(|material| material.density);
        for range in elements_of(std::slice::from_ref(body)) {
            let part = &mut of_elements[range];
            if let Some(&old) = part.iter().find(|&&old| density(old) != density(material)) {
                let old = &file.material[old as usize].name;
                let message =
                    format!("[[stage]] \"{}\": \"{name}\" has another density than \"{old}\"", stage.name);
                let span = document.value(table, &format!("materials.{body}"));
                faults.push(Fault::at(span, message).label("not this density"));
            }
            let breaks = |material: u32| {
                file.material
                    .get(material as usize)
                    .is_some_and(|material| material.tensile_strength.is_some())
            };
            // Its joints hold whatever happens.
            let holds = |material: u32| {
                let new = &file.material[material as usize];
                new.unbreakable && !materials::is_first(file, &new.name)
            };
            if let Some(&old) = part.iter().find(|&&old| breaks(old) && !breaks(material) && !holds(material))
            {
                let old = &file.material[old as usize].name;
                let message = format!(
                    "[[stage]] \"{}\": \"{name}\" has no strengths, and \"{old}\" has: joints would have no law",
                    stage.name
                );
                let span = document.value(table, &format!("materials.{body}"));
                faults.push(Fault::at(span, message).label("without strengths").help(format!(
                    "give \"{name}\" unbreakable = true, if no body has it from the beginning"
                )));
            }
            part.fill(material);
        }
    }
}

/// The stages of a model; none if its file has none.
pub(crate) fn resolve<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    mesh: &Mesh<D, N>,
    placed: &[Placed<D, N>],
    faults: &mut Vec<Fault>,
) -> Vec<PreparedStage> {
    let of = |names: &[String]| elements_of(file, placed, names);
    let mut there = vec![true; mesh.elements.len()];
    for range in appearing(file, placed) {
        there[range].fill(false);
    }
    let mut of_elements = mesh.materials.clone();
    let changes = file.stage.iter().any(|stage| !stage.materials.is_empty());
    let mut stages: Vec<PreparedStage> = Vec::with_capacity(file.stage.len());
    for (index, stage) in file.stage.iter().enumerate() {
        let table = Table::of("stage", index);
        for range in of(&stage.activate) {
            there[range].fill(true);
        }
        for range in of(&stage.excavate) {
            there[range].fill(false);
        }
        check_pieces(file, document, placed, index, faults);
        change_materials(file, document, index, &of, &mut of_elements, faults);
        for (entry, limits) in stage.excavate_boxes.iter().enumerate() {
            if limits.len() != 2 * D {
                faults.push(
                    Fault::at(
                        document.entry(table, "excavate_boxes", entry),
                        format!("a box in {D} dimensions has {} numbers", 2 * D),
                    )
                    .label(format!("{} numbers", limits.len())),
                );
                continue;
            }
            let mut any = false;
            for (element, there) in there.iter_mut().enumerate() {
                if *there && is_within(limits, mesh.centroid(element)) {
                    (*there, any) = (false, true);
                }
            }
            if let Some(body) = cut_rigid(file, mesh, placed, limits) {
                faults.push(
                    Fault::at(
                        document.entry(table, "excavate_boxes", entry),
                        format!("[[stage]] \"{}\": this box cuts the rigid body \"{body}\"", stage.name),
                    )
                    .label("a part of it")
                    .help("a rigid body appears and vanishes as a whole: take a larger box, or excavate it by its name"),
                );
            }
            if !any {
                faults.push(
                    Fault::at(
                        document.entry(table, "excavate_boxes", entry),
                        format!("[[stage]] \"{}\": no element is in this box", stage.name),
                    )
                    .label("nothing here"),
                );
            }
        }
        if !there.iter().any(|there| *there) {
            faults.push(
                Fault::at(
                    document.key(table, "name"),
                    format!("[[stage]] \"{}\": no element is left", stage.name),
                )
                .label("this stage")
                .help(if file.has_spheres() {
                    "spheres alone are no stage: run them by themselves, and begin the next model with their end, by --from"
                } else {
                    "leave a body in each stage"
                }),
            );
        }
        let acts = |boundary: &file::Boundary| {
            boundary.stages.as_ref().is_none_or(|stages| stages.contains(&stage.name))
        };
        stages.push(PreparedStage {
            name: stage.name.clone(),
            duration: stage.duration,
            equilibrium: stage.equilibrium,
            // Its column is known once the histories are.
            until: None,
            elements: there.clone(),
            materials: if changes { of_elements.clone() } else { Vec::new() },
            boundaries: file.boundary.iter().map(acts).collect(),
            injections: fluid::pumps(file, index),
            pore_surfaces: pores::act(file, index),
            release: stage.release.as_ref().map(|release| match release {
                Release::Within(time) => Schedule::Table(vec![[0.0, 1.0], [*time, 0.0]]),
                Release::Table(rows) => Schedule::Table(rows.clone()),
            }),
            local_damping: stage.local_damping.unwrap_or(file.model.local_damping),
            dynamic_relaxation: stage.dynamic_relaxation.unwrap_or(file.model.dynamic_relaxation),
            resets: stage.reset_displacements,
        });
    }
    stages
}

/// The name of a rigid body of which a box has some elements and leaves others.
fn cut_rigid<'a, const D: usize, const N: usize>(
    file: &ModelFile,
    mesh: &Mesh<D, N>,
    placed: &'a [Placed<D, N>],
    limits: &[f64],
) -> Option<&'a str> {
    let count = mesh.elements.len();
    let is_cut = |element: usize| {
        let body = mesh.bodies[element] as usize;
        let own = || (0..count).filter(move |&other| mesh.bodies[other] as usize == body);
        file.body[placed[body].table].rigid.at_first()
            && own().any(|other| !is_within(limits, mesh.centroid(other)))
    };
    // One element of each body is enough.
    let mut known = BTreeSet::new();
    (0..count)
        .filter(|&element| is_within(limits, mesh.centroid(element)) && known.insert(mesh.bodies[element]))
        .find(|&element| is_cut(element))
        .map(|element| placed[mesh.bodies[element] as usize].name.as_str())
}
