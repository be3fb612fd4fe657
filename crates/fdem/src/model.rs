//! Model files: from TOML to a [`Model`] that can be run.
//!
//! [`prepare`] takes the text of a model file and a function that gives the bytes of the files it names; there are no paths and no terminal here. What is wrong
//! comes back as [`ModelErrors`], all of it at once, with the place of each in the text. The keys of model files are the types in [`file`](mod@file); [`schema`] is
//! their JSON schema, and [`STARTER`] a model to start from.
//!
//! ```text
//! text ── document ── schema ── file ──> materials, bodies ── mesher ──> mesh ── boundaries, settings ──> Prepared ── preflight
//! ```

mod document;
mod fault;
pub mod file;
mod schema;

mod outline;
mod mesher;
mod voronoi;
mod packing;
mod mesh_file;
mod piece;

mod bodies;
mod boundaries;
mod materials;
mod settings;

mod preflight;
mod quality;
mod warnings;

use std::io;
use std::ops::Range;

use fdem_simulation::{ContactOptions, CriticalOpening, FractureOptions, Insertion, Model, TimeOptions};
use sha2::{Digest, Sha256};

pub use bodies::Load;
pub use fault::{Drawing, Fault, ModelErrors};
pub use preflight::{Critical, Preflight};
pub use quality::Quality;
pub use schema::schema;
pub use settings::{Checkpoint, History, OutputSettings, Quantity};

use bodies::Placed;
use document::{Document, Table};
use fault::nearest;
use file::ModelFile;

/// A model to start from: small, complete, with a word on every part.
pub const STARTER: &str = include_str!("model/starter.toml");

/// All that a run needs.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// What is simulated.
    pub model: Model,
    /// For people; empty if there is none.
    pub title: String,
    /// When the run ends, s.
    pub end_time: f64,
    /// The bodies, by their numbers in [`Mesh::bodies`](fdem_simulation::Mesh).
    pub bodies: Vec<Body>,
    /// Named parts of bodies: physical groups of mesh files; the outline and the holes of other shapes.
    pub groups: Vec<Group>,
    /// What is written.
    pub output: OutputSettings,
    /// What is recorded over time.
    pub histories: Vec<History>,
    /// Sizes and shapes of the elements.
    pub quality: Quality,
    /// What may not be meant, for people; the run is possible all the same.
    pub warnings: Vec<String>,
    /// SHA-256 of the model in hexadecimal digits: equal models, and only these, have equal ones.
    pub hash: String,
}

/// A body of the mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Body {
    /// Its name; of a piece of a packing with its number from 1: `heap-7`.
    pub name: String,
    /// Its nodes.
    pub nodes: Range<u32>,
    /// Its elements.
    pub elements: Range<u32>,
}

/// A named part of a body.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Number of its body.
    pub body: u32,
    /// Its name in the mesh file, or `outer`, `holes`, `hole-1`, ….
    pub name: String,
    /// Its nodes, ascending.
    pub nodes: Vec<u32>,
    /// What it has of the outline: nodes in the direction in which their element has them, counter-clockwise.
    pub edges: Vec<[u32; 2]>,
}

/// Reads, checks and meshes a model.
///
/// # Shapes
/// `text`: a model file; `name`: its name, for messages. `load`: the bytes of a file that the model names, as the model names it, or why there are none.
///
/// # Cost
/// Mostly that of the meshes: about 20 µs an element.
///
/// # Errors
/// [`ModelErrors`]: everything that is wrong. Meshes are made, and what depends on them is checked, only if the rest is right.
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
/// let prepared = fdem::model::prepare(model, "bar.toml", &mut |_| Err("no files".into()))?;
/// assert_eq!(prepared.bodies[0].name, "bar");
///
/// let wrong = model.replace("density", "densty");
/// let errors = fdem::model::prepare(&wrong, "bar.toml", &mut |_| Err("no files".into())).unwrap_err();
/// assert!(errors.to_string().contains("did you mean \"density\"?"));
/// # Ok::<(), fdem::model::ModelErrors>(())
/// ```
pub fn prepare(text: &str, name: &str, load: &mut Load<'_>) -> Result<Prepared, ModelErrors> {
    prepare_or_faults(text, load).map_err(|faults| ModelErrors::new(name, text, faults))
}

fn prepare_or_faults(text: &str, load: &mut Load<'_>) -> Result<Prepared, Vec<Fault>> {
    let document = Document::parse(text)?;
    let file = parse(text, &document)?;

    let mut faults = Vec::new();
    check_names(&file, &document, &mut faults);
    let materials = materials::materials(&file, &document, &mut faults);
    let interfaces = materials::interfaces(&file, &document, &mut faults);
    bodies::check(&file, &document, &mut faults);
    boundaries::check(&file, &document, &mut faults);
    settings::check(&file, &document, &mut faults);
    check_initial(&file, &document, &mut faults);
    none_or(faults)?;

    let (mesh, placed) = bodies::build(&file, &document, load)?;
    let mut faults = Vec::new();
    let boundaries = boundaries::resolve(&file, &document, &mesh, &placed, &mut faults);
    none_or(faults)?;

    let mut warnings = Vec::new();
    let histories = settings::histories(&file, &mesh.nodes, &placed, &mut warnings);
    let model = Model {
        velocities: velocities(&file, &placed),
        stresses: file.initial.stress.map(|stress| vec![stress; mesh.triangles.len()]).unwrap_or_default(),
        mesh,
        materials,
        interfaces,
        boundaries,
        plane: materials::plane(&file),
        thickness: file.model.thickness,
        gravity: match file.model.gravity {
            file::Gravity::Vector(gravity) => gravity,
            file::Gravity::None(_) => [0.0; 2],
        },
        contact: contact(&file),
        fracture: fracture(&file),
        time: TimeOptions {
            step: match file.model.time_step {
                file::TimeStep::Seconds(step) => Some(step),
                file::TimeStep::Auto(_) => None,
            },
            safety: file.model.safety,
            local_damping: file.model.local_damping,
            energy_bound: file.model.energy_bound,
        },
    };
    let quality = Quality::of(&model.mesh);
    let bodies = bodies_of(&placed);
    warnings.extend(warnings::warnings(&model, &bodies, &quality));
    Ok(Prepared {
        title: file.model.title.clone(),
        end_time: file.model.end_time,
        groups: groups_of(&placed),
        output: settings::settings(&file),
        histories,
        hash: hash(&model),
        model,
        quality,
        bodies,
        warnings,
    })
}

/// The file as its types have it.
fn parse(text: &str, document: &Document<'_>) -> Result<ModelFile, Vec<Fault>> {
    none_or(schema::check(document.root()))?;
    // The schema has seen all that people do; what it has not seen is told by the deserializer.
    toml::from_str(text).map_err(|error| {
        let end = text.len();
        vec![Fault::at(error.span().unwrap_or(end..end), error.message().to_owned())]
    })
}

fn none_or(faults: Vec<Fault>) -> Result<(), Vec<Fault>> {
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Names come once: of two alike nobody could say which is meant.
fn check_names(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    fn names<'f, T>(items: &'f [T], name: fn(&'f T) -> &'f str) -> Vec<&'f str> {
        items.iter().map(name).collect()
    }
    for (table, names) in [
        ("body", names(&file.body, |body| &body.name)),
        ("material", names(&file.material, |material| &material.name)),
        ("boundary", names(&file.boundary, |boundary| &boundary.name)),
        ("history", names(&file.history, |history| &history.name)),
    ] {
        for (index, name) in names.iter().enumerate() {
            if names[..index].contains(name) {
                faults.push(
                    Fault::at(
                        document.value(Table::of(table, index), "name"),
                        format!("there is a [[{table}]] \"{name}\" already"),
                    )
                    .label("again")
                    .help("names come once"),
                );
            }
        }
    }
}

fn check_initial(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let table = Table::one("initial");
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

/// Of each node; empty if all are at rest.
fn velocities(file: &ModelFile, placed: &[Placed]) -> Vec<[f64; 2]> {
    let mut velocities = Vec::new();
    for body in placed {
        let table = &file.body[body.table];
        let velocity = table.velocity.or_else(|| file.initial.velocity.get(&table.name).copied());
        velocities.extend(std::iter::repeat_n(velocity.unwrap_or([0.0; 2]), body.piece.nodes.len()));
    }
    if velocities.iter().all(|velocity| *velocity == [0.0; 2]) {
        velocities.clear();
    }
    velocities
}

fn contact(file: &ModelFile) -> ContactOptions {
    ContactOptions {
        penalty: file.contact.penalty,
        tangential_stiffness: file.contact.tangential_stiffness,
        damping: file.contact.damping,
        buffer: file.contact.buffer,
    }
}

fn fracture(file: &ModelFile) -> FractureOptions {
    FractureOptions {
        insertion: match file.fracture.insertion {
            file::Insertion::Adaptive => Insertion::Adaptive,
            file::Insertion::Intrinsic => Insertion::Intrinsic,
        },
        joint_penalty: file.fracture.joint_penalty,
        critical_opening: match file.fracture.critical_opening {
            file::CriticalOpening::Exact => CriticalOpening::Exact,
            file::CriticalOpening::Customary => CriticalOpening::Customary,
        },
    }
}

fn bodies_of(placed: &[Placed]) -> Vec<Body> {
    let range = |first: u32, count: usize| first..first + count as u32;
    placed
        .iter()
        .map(|body| Body {
            name: body.name.clone(),
            nodes: range(body.first[0], body.piece.nodes.len()),
            elements: range(body.first[1], body.piece.triangles.len()),
        })
        .collect()
}

fn groups_of(placed: &[Placed]) -> Vec<Group> {
    let mut groups = Vec::new();
    for (body, Placed { piece, first, .. }) in (0..).zip(placed) {
        for (name, group) in &piece.groups {
            groups.push(Group {
                body,
                name: name.clone(),
                nodes: piece.nodes_of(group).into_iter().map(|node| node + first[0]).collect(),
                edges: piece
                    .edges_of(group)
                    .into_iter()
                    .map(|edge| edge.map(|node| node + first[0]))
                    .collect(),
            });
        }
    }
    groups
}

/// SHA-256 of the model as JSON, whose numbers are written so that they read back to the last bit.
fn hash(model: &Model) -> String {
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
    // Hexadecimal digits, two for each byte.
    digest
        .iter()
        .flat_map(|byte| [byte >> 4, byte & 15])
        .filter_map(|digit| char::from_digit(u32::from(digit), 16))
        .collect()
}
