//! Model files: from TOML to a [`Model`] that can be run.
//!
//! [`prepare`] takes the text of a model file and a function that gives the bytes of the files it names;
//! there are no paths and no terminal here. Errors come back as [`ModelErrors`], all of them together, each
//! with its place in the text. The keys of model files are the types in [`file`](mod@file); [`schema`] is
//! their JSON schema, and [`STARTER`] a model to start from.
//!
//! # How it is built
//!
//! ```text
//! text ── included ── document ── library ── values ── schema ── file ──> extent, materials, bodies ── mesher ──> mesh ── boundaries, settings ──> Prepared ── preflight
//! ```
//!
//! `Document` finds the place of every key for messages. The types of `src/file.rs` define the keys; their
//! comments become the descriptions of the schema and the page of the book that lists every key. [`prepare`]
//! checks, meshes and numbers, and returns a `fdem_simulation::Model`. A model is generic in the dimensions:
//! `src/dimensions/differences.rs` holds the differences.
//!
//! # Layers
//!
//! Files import only from the layers below. From the bottom: the document, its faults and its keys (`fault`,
//! `document`, `file`); shapes and their sizes (`outline`, `limits`, `extent`); meshes of bodies
//! (`mesh_file`, `plane`, `space`); bodies put together (`bodies`, `boundaries`, `sizes`); warnings;
//! `prepare`. A test in `crates/fdem/tests/docs/layers.rs` finds circles.
//!
//! # To change X, open Y
//!
//! | to change | open |
//! |---|---|
//! | a key of the model file | `src/file.rs` and the files below `src/file`; then `BLESS=1 cargo test -p fdem --test docs` |
//! | expressions, units, parameters | `src/values.rs`; the unit of a key is `x-unit` beside it in `src/file` |
//! | the library of materials | `src/library.toml`, `src/library.rs`, `crates/fdem/src/command/materials.rs`; then `BLESS=1 cargo test -p fdem --test docs` |
//! | values that are set from outside, `--set` | `src/set.rs` |
//! | included files; copies of a body | `src/included.rs`; `src/repeat.rs` |
//! | bounds on numbers, size and memory before meshing | `src/limits.rs`, `src/far.rs`, `src/sizes.rs`, `src/extent.rs`, `crates/fdem/src/command/memory.rs` |
//! | warnings of `check` | `src/warnings.rs`, `locking.rs`, `plausible.rs`, `joined.rs`, `connected.rs`, `slivers.rs`, `equilibrium.rs` beside it; advice for quasi-static runs: `src/quasi_static.rs` |
//! | mass scaling | `src/scaling.rs`, `src/scaled.rs`, `crates/fdem/src/command/run/quasi_static.rs`; how much a node needs: `crates/simulation/src/mass.rs` |
//! | joint sets: keys and laws, lines, files of lines | `src/joint_sets.rs`, `src/joint_lines.rs`, `src/polylines.rs` |
//! | joint sets in space: polygons, files of polygons | `src/joint_planes.rs`, `src/polygons.rs` |
//! | errors in a model file | `src/fault.rs`, `src/document.rs` |
//! | shapes of bodies, and their meshes | `src/bodies.rs`; flat ones: `src/plane.rs`, `src/packing.rs`, `crates/mesh/src/triangles.rs`; in space: `src/space.rs`, `crates/mesh/src/shapes.rs`, `crates/mesh/src/tetrahedra.rs`; smaller elements near places: `src/refine.rs`, `crates/mesh/src/grading.rs` |
//! | output and warnings of `fdem check` | `src/preflight.rs`, `src/warnings.rs`; with `--ranks`: `src/on_ranks.rs` |
//! | stages of a run | `src/stages.rs`, `crates/fdem/src/command/run/stages.rs` |
//! | conditions that end a run or a stage, servos | `src/conditions.rs` |
//! | bonds between bodies | `src/bonds.rs` |
//! | histories of probes, curves | `src/probes.rs`, `src/curves.rs` |

#![allow(private_bounds, reason = "bodies are of triangles or of tetrahedra; nobody else can make others")]

mod document;
mod fault;
pub mod file;
mod library;
mod partial;
mod schema;
mod values;

mod shapes;
mod limits;
mod extent;
mod far;
mod near;
mod outline;
mod refine;
mod repeat;
mod set;
mod packing;
mod mesh_file;
mod gmsh;
mod included;
mod parts;
mod piece;
mod placed;
mod scaled;
mod prepared;
mod probes;

mod dimensions;
mod plane;
mod space;
mod crowded;
mod sizes;
mod bodies;
mod bonds;
mod boundaries;
mod materials;
mod settings;
mod stages;

mod polygons;
mod polylines;
mod joint_lines;
mod joint_planes;
mod joint_sets;

mod connected;
mod conditions;
mod curves;
mod joined;
pub mod locking;
mod amounts;
mod on_ranks;
mod plausible;
mod quasi_static;
mod scaling;
mod preflight;
mod slivers;
mod warnings;
mod equilibrium;

use std::collections::BTreeMap;
use std::io;

use fdem_io::numbers::grouped;
use fdem_mesh::Mesh;
use fdem_simulation::{Interface, JointSet, Material, Model, Schedule, TimeOptions};
use serde::Serialize;
use sha2::{Digest, Sha256};
use toml::Spanned;
use toml::de::DeTable;

pub use conditions::{Bound, Reached, Servo, Until};
pub use fault::{Drawing, Fault, ModelErrors};
pub use fdem_mesh::Quality;
pub use gmsh::stop as stop_gmsh;
pub use library::{FromLibrary, LibraryMaterial, library};
pub use mesh_file::Load;
pub use on_ranks::OnRanks;
pub use preflight::{Critical, Preflight};
pub use preflight::{check, steps};
pub use prepared::{AnyPrepared, Body, Entered, Group, Origin, Prepared, Stage};
pub use scaled::Scaled;
pub use schema::schema;
pub use set::{Setting, with_end_time, with_values};
pub use settings::{Checkpoint, History, OutputSettings, Quantity};
pub use stages::Present;

use bonds::Bonds;
use conditions::Resolved;
pub use curves::columns;
pub use dimensions::Modelled;
use dimensions::{Dimensions, Ready};
pub use document::number;
use document::{Document, Table};
pub use fault::nearest;
use file::{ModelFile, Vector};
use included::Sources;
use joint_lines::JointLines;
pub use joint_sets::Joints;
use partial::Partial;
use piece::Piece;
use placed::Placed;
pub use values::constant;

/// A small and complete model to start from, with a comment on every part.
pub const STARTER: &str = include_str!("starter.toml");

/// Like [`STARTER`], in three dimensions.
pub const STARTER_3D: &str = include_str!("starter_3d.toml");

/// Reads, checks and meshes a model in two dimensions. [`prepare_any`] does the same for any model.
///
/// # Shapes
/// `text`: a model file; `name`: its name, for messages. `load`: returns the bytes of a file under the name
/// in the model, or the reason why it cannot be read.
///
/// # Cost
/// Mostly that of the meshes: about 20 µs an element.
///
/// # Errors
/// [`ModelErrors`]: everything that is wrong, also if the model is in three dimensions. If there is an error,
/// large meshes are not made, and parts that depend on it are not checked.
///
/// # Example
/// ```
/// let model = r#"
///     [model]
///     end_time = 1e-3
///     [[body]]
///     name = "bar"
///     material = "steel"
///     rectangle = { min = [0, 0], max = [1.0, 0.1] }
///     mesh_size = 0.05
///     [[material]]
///     name = "steel"
///     density = 7800
///     youngs_modulus = 210e9
///     poissons_ratio = 0.3
/// "#;
/// let prepared = fdem_model::prepare(model, "bar.toml", &mut |_| Err("no files".into()))?;
/// assert_eq!(prepared.bodies[0].name, "bar");
///
/// let wrong = model.replace("density", "densty");
/// let errors = fdem_model::prepare(&wrong, "bar.toml", &mut |_| Err("no files".into())).unwrap_err();
/// assert!(errors.to_string().contains("did you mean \"density\"?"));
/// # Ok::<(), fdem_model::ModelErrors>(())
/// ```
pub fn prepare(text: &str, name: &str, load: &mut Load<'_>) -> Result<Prepared, ModelErrors> {
    prepare_within(text, name, load, None)
}

/// Like [`prepare`], and refuses meshes that need more than `memory` (bytes) before it makes them.
///
/// # Errors
/// The errors of [`prepare`], and mesh sizes for which there is not enough memory.
pub fn prepare_within(
    text: &str,
    name: &str,
    load: &mut Load<'_>,
    memory: Option<f64>,
) -> Result<Prepared, ModelErrors> {
    match prepare_any(text, name, load, memory)? {
        AnyPrepared::Plane(prepared) => Ok(*prepared),
        AnyPrepared::Space(_) => {
            let end = text.len();
            let fault =
                Fault::at(end..end, "the model is in three dimensions, where one in two is asked for");
            Err(ModelErrors::new(name, text, vec![fault]))
        }
    }
}

/// Reads, checks and meshes a model in two or three dimensions. `memory`: as for [`prepare_within`].
///
/// # Errors
/// The errors of [`prepare_within`].
///
/// # Example
/// ```
/// use fdem_model::{AnyPrepared, prepare_any};
///
/// let model = r#"
///     [model]
///     end_time = 1e-3
///     [[body]]
///     name = "block"
///     material = "granite"
///     box = { min = [0, 0, 0], max = [0.1, 0.1, 0.2] }
///     mesh_size = 0.05
///     [[material]]
///     name = "granite"
///     density = 2700
///     youngs_modulus = 50e9
///     poissons_ratio = 0.25
/// "#;
/// let AnyPrepared::Space(prepared) = prepare_any(model, "block.toml", &mut |_| Err("no files".into()), None)? else {
///     panic!("a box is a body in space");
/// };
/// assert!(prepared.quality.elements > 10);
/// # Ok::<(), fdem_model::ModelErrors>(())
/// ```
pub fn prepare_any(
    text: &str,
    name: &str,
    load: &mut Load<'_>,
    memory: Option<f64>,
) -> Result<AnyPrepared, ModelErrors> {
    let sources = Sources::gather(text, load);
    prepare_or_faults(&sources, load, memory)
        .map_err(|faults| ModelErrors::new(name, &sources.text, faults).with_included(sources.included()))
}

/// Elements up to which bodies are meshed although there are faults, to find those of the meshes too.
const SOON_MESHED: f64 = 1e5;

fn prepare_or_faults(
    sources: &Sources<'_>,
    load: &mut Load<'_>,
    memory: Option<f64>,
) -> Result<AnyPrepared, Vec<Fault>> {
    let mut document = parse(&sources.text, sources.parse())?;
    let from_library = library::resolve(&mut document);
    let evaluated = values::evaluate(&document, &sources.text, schema::evaluated());
    let document = values::replace(document, &evaluated);
    let mut faults = evaluated.faults.clone();
    // An expression without a value is still a text, and needs no second fault.
    let is_told = |fault: &Fault| evaluated.is_wrong(fault.span.as_ref());
    faults.extend(schema::check(document.root()).into_iter().filter(|fault| !is_told(fault)));
    let partial = if faults.is_empty() { None } else { Partial::read(&document, &faults) };
    let file = match &partial {
        Some(partial) => partial.file.clone(),
        None if faults.is_empty() => deserialize(&document)?,
        None => return Err(faults),
    };
    // A file that determines the dimensions is read once.
    let mut read: Option<(String, Result<Vec<u8>, String>)> = None;
    let dimensions = dimensions::of(&file, &mut |name| {
        let bytes = load(name);
        read = Some((name.to_owned(), bytes.clone()));
        bytes
    });
    let mut load = |name: &str| match read.take_if(|(known, _)| known == name) {
        Some((_, bytes)) => bytes,
        None => load(name),
    };
    let is_news = |fault: &Fault| partial.as_ref().is_none_or(|partial| partial.is_news(fault));

    let mut found = Vec::new();
    dimensions::check(&file, &document, dimensions, &mut found);
    check_names(&file, &document, &mut found);
    let materials = materials::materials(&file, &document, dimensions, &mut found);
    let interfaces = materials::interfaces(&file, &document, &mut found);
    let joint_sets = joint_sets::check(&file, &document, dimensions, &mut found);
    bodies::check(&file, &document, dimensions, &mut found);
    boundaries::check(&file, &document, &mut found);
    settings::check(&file, &document, &mut found);
    stages::check(&file, &document, &mut found);
    scaling::check(&file, &document, &mut found);
    conditions::check(&file, &document, &mut found);
    check_initial(&file, &document, dimensions == 3, &mut found);
    let elements = sizes::check(&file, &document, memory, &mut found);
    faults.extend(found.into_iter().filter(is_news));

    // Included files may have parameters for other models.
    let unused = evaluated.unused.iter().filter(|(_, span)| sources.is_in_model(span));
    let warnings = unused.map(|(name, _)| format!("the parameter \"{name}\" is not used")).collect();
    let document = &document;
    let checked = Checked {
        file: &file,
        document,
        elements,
        materials,
        interfaces,
        joint_sets,
        from_library,
        warnings,
    };
    if dimensions == 3 {
        let prepared = checked.prepared(&mut load, faults, &is_news)?;
        Ok(AnyPrepared::Space(Box::new(prepared)))
    } else {
        let prepared = checked.prepared(&mut load, faults, &is_news)?;
        Ok(AnyPrepared::Plane(Box::new(prepared)))
    }
}

/// A file whose tables have been checked one by one.
struct Checked<'a> {
    file: &'a ModelFile,
    document: &'a Document<'a>,
    /// Number of elements of the bodies that are meshed here, about.
    elements: f64,
    materials: Vec<Material>,
    interfaces: Vec<Interface>,
    joint_sets: Vec<JointSet>,
    from_library: Vec<FromLibrary>,
    /// Warnings about the text of the file.
    warnings: Vec<String>,
}

impl Checked<'_> {
    /// Meshes the bodies, and puts the model together. `faults`: those of the tables.
    fn prepared<const D: usize, const N: usize>(
        self,
        load: &mut Load<'_>,
        mut faults: Vec<Fault>,
        is_news: &dyn Fn(&Fault) -> bool,
    ) -> Result<Prepared<D, N>, Vec<Fault>>
    where
        [[f64; D]; N]: Dimensions<D, N>,
        Model<D, N>: Serialize,
    {
        let Self { file, document, elements, materials, interfaces, joint_sets, from_library, mut warnings } =
            self;
        // A file with faults is meshed only to find more faults: bodies without faults, and only if that
        // takes little time.
        let mut wrong = document.with_faults("body", file.body.len(), &faults);
        for (wrong, body) in wrong.iter_mut().zip(&file.body) {
            *wrong |= !faults.is_empty() && elements > SOON_MESHED && body.mesh.is_none();
        }
        let skipped = document.with_faults("boundary", file.boundary.len(), &faults);
        let mut found = Vec::new();
        let lines = JointLines::of(D, file, document, load, &mut found);
        let (mesh, placed, missing) = bodies::build(file, document, (&lines, load), &wrong, &mut found);
        let boundaries =
            boundaries::resolve(file, document, &mesh, &placed, (&missing, &skipped), &mut found);
        let mut stages = if missing.is_empty() {
            stages::resolve(file, document, &mesh, &placed, &mut found)
        } else {
            Vec::new()
        };
        let bonds = if missing.is_empty() {
            Bonds::find(file, document, &placed, &mut found)
        } else {
            Bonds::default()
        };
        faults.extend(found.into_iter().filter(is_news));
        faults.extend(bodies::crowded(document, &placed));
        none_or(faults)?;

        let histories = settings::histories(file, &mesh.nodes, &placed, &mut warnings);
        let mut lost = Vec::new();
        let probes = probes::probes(file, document, &mesh, &placed, &mut lost);
        none_or(lost)?;
        let mut unknown = Vec::new();
        let own = columns::<D, N>(&histories, &probes);
        let curves = curves::curves::<D>(file, document, &own, &mut unknown);
        let Resolved { until, of_stages, servos } =
            conditions::resolve::<D>(file, document, &own, &mut unknown);
        for (stage, until) in stages.iter_mut().zip(of_stages) {
            stage.until = until;
        }
        none_or(unknown)?;
        let mut model = Model {
            mass_factors: Vec::new(),
            velocities: velocities(file, &placed),
            stresses: stresses(file, &mesh, &placed),
            mesh,
            materials,
            interfaces,
            joint_sets,
            joint_facets: Vec::new(),
            boundaries,
            plane: file.model.plane,
            thickness: file.model.thickness,
            gravity: match &file.model.gravity {
                file::Gravity::Vector(gravity) => gravity.components(),
                file::Gravity::None(_) => [0.0; D],
            },
            gravity_schedule: file.model.gravity_ramp.map_or(Schedule::Constant, Schedule::Ramp),
            contact: file.contact,
            fracture: file.fracture,
            time: time_options(file),
        };
        let between: Vec<bool> = file.joint_set.iter().map(|set| set.between.is_some()).collect();
        let joint_sets = joint_sets::put(&mut model, &placed, &between, &mut warnings);
        let quality = Quality::of(&model.mesh);
        let bodies = bodies_of(&placed);
        for body in &placed {
            let name = &file.body[body.table].name;
            warnings.extend(body.piece.notes.iter().map(|note| format!("[[body]] \"{name}\": {note}")));
        }
        plausible::units(&model, &mut warnings);
        plausible::loads(&model, &mut warnings);
        conditions::warnings(&model, &servos, &own, &mut warnings);
        plausible::without_effect(file, document, &model, &mut warnings);
        let ready = Ready { file, model: &model, placed: &placed, bodies: &bodies, quality: &quality };
        warnings.extend(<[[f64; D]; N]>::warnings(&ready));
        let mut prepared = Prepared {
            title: file.model.title.clone(),
            end_time: file.model.end_time,
            groups: groups_of(&placed),
            grains: grains_of(&placed),
            joint_sets,
            from_library,
            output: settings::settings(file, &placed),
            histories,
            hash: String::new(),
            stages,
            until,
            servos,
            mass_scaling: None,
            probes,
            curves,
            model,
            quality,
            bodies,
            warnings,
        };
        let joined = bonds.join(&mut prepared);
        joined.map_err(|error| vec![Fault::at(document.key(Table::of("joint_set", 0), "name"), error)])?;
        scaling::scale(file, document, &mut prepared).map_err(|fault| vec![fault])?;
        prepared.hash = hash_of(&prepared);
        Ok(prepared)
    }
}

/// A text of TOML as a tree with the place of every key and value. Also returns the lines that are not TOML.
pub fn toml_tree(text: &str) -> (Spanned<DeTable<'_>>, Vec<Fault>) {
    let (document, faults) = Document::parse(text);
    (document.into_root(), faults)
}

/// Options of the integration in time.
fn time_options(file: &ModelFile) -> TimeOptions {
    TimeOptions {
        step: match file.model.time_step {
            file::TimeStep::Seconds(step) => Some(step),
            file::TimeStep::Auto(_) => None,
        },
        safety: file.model.safety,
        local_damping: file.model.local_damping,
        dynamic_relaxation: file.model.dynamic_relaxation,
        energy_bound: file.model.energy_bound,
    }
}

/// The hash of a model, and of everything that changes it during a run.
fn hash_of<const D: usize, const N: usize>(prepared: &Prepared<D, N>) -> String
where
    Model<D, N>: Serialize,
{
    let Prepared { model, stages, until, servos, .. } = prepared;
    if stages.is_empty() && until.is_none() && servos.is_empty() {
        hash(model)
    } else {
        hash(&(model, stages, until, servos))
    }
}

/// The document, if it is TOML. If not, also reports unknown keys and values out of range in the valid lines.
fn parse<'a>(
    text: &str,
    (document, mut faults): (Document<'a>, Vec<Fault>),
) -> Result<Document<'a>, Vec<Fault>> {
    if faults.is_empty() {
        return Ok(document);
    }
    let line = |fault: &Fault| fault.span.as_ref().map(|span| document::line_of(text, span.start));
    let wrong: Vec<_> = faults.iter().map(line).collect();
    let is_heading = |line: &Option<usize>| {
        line.is_some_and(|line| text.lines().nth(line).is_some_and(|line| line.trim_start().starts_with('[')))
    };
    // Without its heading nobody knows which table a key is in.
    if wrong.iter().any(is_heading) {
        return Err(faults);
    }
    faults.extend(schema::check(document.root()).into_iter().filter(|fault| {
        // A value that the parser made up for one that it could not read is nowhere in the text.
        let is_written = fault.span.as_ref().is_some_and(|span| !span.is_empty());
        is_written
            && ["unknown key", "out of range"].contains(&fault.label.as_str())
            && !wrong.contains(&line(fault))
    }));
    Err(faults)
}

/// The file as its types have it.
fn deserialize(document: &Document<'_>) -> Result<ModelFile, Vec<Fault>> {
    // The schema check finds the usual mistakes; the deserializer reports the others.
    document.read().map_err(|error| {
        let end = document.root().span().end;
        vec![Fault::at(error.span().unwrap_or(end..end), error.message().to_owned())]
    })
}

fn none_or(faults: Vec<Fault>) -> Result<(), Vec<Fault>> {
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Refuses names that occur twice.
fn check_names(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    fn names<'f, T>(items: &'f [T], name: fn(&'f T) -> &'f str) -> Vec<&'f str> {
        items.iter().map(name).collect()
    }
    for (table, names) in [
        ("body", names(&file.body, |body| &body.name)),
        ("material", names(&file.material, |material| &material.name)),
        ("joint_set", names(&file.joint_set, |set| &set.name)),
        ("boundary", names(&file.boundary, |boundary| &boundary.name)),
        ("history", names(&file.history, |history| &history.name)),
        ("stage", names(&file.stage, |stage| &stage.name)),
        ("curve", names(&file.curve, |curve| &curve.name)),
    ] {
        let mut again: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (index, name) in names.iter().enumerate() {
            again.entry(name).or_default().push(index);
        }
        for (name, places) in again {
            let [_, second, more @ ..] = &places[..] else { continue };
            let times = match more.len() {
                0 => String::new(),
                1 => ", and once more".to_owned(),
                count => format!(", and {} times more", grouped(count as u64)),
            };
            faults.push(
                Fault::at(
                    document.value(Table::of(table, *second), "name"),
                    format!("there is a [[{table}]] \"{name}\" already{times}"),
                )
                .label("again")
                .help("names come once"),
            );
        }
    }
}

fn check_initial(file: &ModelFile, document: &Document<'_>, is_in_space: bool, faults: &mut Vec<Fault>) {
    let table = Table::one("initial");
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

/// Velocity of each node at the start; empty if all nodes rest.
fn velocities<const D: usize, const N: usize>(file: &ModelFile, placed: &[Placed<D, N>]) -> Vec<[f64; D]> {
    let mut velocities = Vec::new();
    for body in placed {
        let table = &file.body[body.table];
        let velocity = table.velocity.as_ref().or_else(|| file.initial.velocity.get(&table.name));
        let velocity = velocity.map_or([0.0; D], Vector::components);
        velocities.extend(std::iter::repeat_n(velocity, body.piece.nodes.len()));
    }
    if velocities.iter().all(|velocity| *velocity == [0.0; D]) {
        velocities.clear();
    }
    velocities
}

/// Initial stress of each element, that of its centroid; empty for none. Bodies that appear later have none.
fn stresses<const D: usize, const N: usize>(
    file: &ModelFile,
    mesh: &Mesh<D, N>,
    placed: &[Placed<D, N>],
) -> Vec<[[f64; D]; D]>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let (stress, gradient) = (&file.initial.stress, &file.initial.stress_gradient);
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
    let of = |nodes: &[u32; N]| {
        let height = nodes.iter().map(|&node| mesh.nodes[node as usize][D - 1]).sum::<f64>() / N as f64;
        let mut components: Vec<f64> =
            stress.iter().zip(gradient).map(|(stress, gradient)| stress + gradient * height).collect();
        if let Some(ground) = ground {
            let density =
                ground.density.unwrap_or_else(|| file.material.first().map_or(0.0, |first| first.density));
            let vertical = -density * gravity * (ground.surface - height).max(0.0);
            let (k0, tectonic) = (ground.k0.along(), ground.tectonic.map_or([0.0; 2], file::Ratio::along));
            components[D - 1] += vertical;
            for axis in 0..D - 1 {
                components[axis] +=
                    k0[axis] * vertical + if height < ground.surface { tectonic[axis] } else { 0.0 };
            }
        }
        <[[f64; D]; N]>::stress(&components)
    };
    let mut stresses: Vec<[[f64; D]; D]> = mesh.elements.iter().map(of).collect();
    for range in stages::appearing(file, placed) {
        stresses[range].fill([[0.0; D]; D]);
    }
    stresses
}

fn bodies_of<const D: usize, const N: usize>(placed: &[Placed<D, N>]) -> Vec<Body> {
    let range = |first: u32, count: usize| first..first + count as u32;
    placed
        .iter()
        .map(|body| Body {
            name: body.name.clone(),
            nodes: range(body.first[0], body.piece.nodes.len()),
            elements: range(body.first[1], body.piece.elements.len()),
        })
        .collect()
}

fn grains_of<const D: usize, const N: usize>(placed: &[Placed<D, N>]) -> Vec<u32> {
    if placed.iter().all(|body| body.piece.grains.is_empty()) {
        return Vec::new();
    }
    let of_body = |body: &Placed<D, N>| {
        let Piece { grains, elements, .. } = &body.piece;
        if grains.is_empty() { vec![0; elements.len()] } else { grains.clone() }
    };
    placed.iter().flat_map(of_body).collect()
}

fn groups_of<const D: usize, const N: usize>(placed: &[Placed<D, N>]) -> Vec<Group<D>>
where
    [[f64; D]; N]: Dimensions<D, N>,
{
    let mut groups = Vec::new();
    for (body, Placed { piece, first, .. }) in (0..).zip(placed) {
        for (name, group) in &piece.groups {
            groups.push(Group {
                body,
                name: name.clone(),
                nodes: piece.nodes_of(group).into_iter().map(|node| node + first[0]).collect(),
                facets: piece
                    .facets_of(group)
                    .into_iter()
                    .map(|facet| facet.map(|node| node + first[0]))
                    .collect(),
            });
        }
    }
    groups
}

/// SHA-256 of the model as JSON. JSON numbers are written so that they are read back exactly.
fn hash(model: &impl Serialize) -> String {
    struct Sink(Sha256);
    impl io::Write for Sink {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.update(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let mut sink = io::BufWriter::new(Sink(Sha256::new()));
    let written = serde_json::to_writer(&mut sink, model);
    debug_assert!(written.is_ok(), "a model has no keys but text");
    let digest = sink.into_inner().map(|sink| sink.0.finalize()).unwrap_or_default();
    format!("{digest:x}")
}
