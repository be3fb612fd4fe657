//! `fdem contacts` for meshes: one or several files, and spheres against surfaces.

use std::sync::atomic::Ordering;
use std::time::Instant;

use fdem_contact::discretised::{
    BodyContact, DiscretisedError, MeshElement, MeshSearch, MeshView, SphereContact, body_contacts, gather,
};
use fdem_contact::narrow::{Contact, Measure, Sphere, sphere_sphere};
use fdem_contact::{Couple, Detector, Elements, Engine, Error, Search, verify};
use fdem_io::numbers::grouped;
use fdem_io::{Centres, MeshFormat, MeshGroup, Table, Values};
use fdem_results::network::Sizes;
use fdem_results::picture::MeshDrawing;

use crate::command::args::{ContactsArguments, PeriodicArguments};
use crate::command::cut_elements::{combined, count_couples};
use crate::command::drawings::BodiesDrawing;
use crate::command::failure::Failure;
use crate::command::input::{self, Input, Opened, id, sizes};
use crate::command::mesh_summary::{BodyOf, Couples, FileOf, LeftOut, MeshSummary};
use crate::command::output::TableFormat;
use crate::command::outputs::Outputs;
use crate::command::progress::{Position, Progress};
use crate::command::shapes::{BodyParts, Branches, Shapes};
use crate::command::summary::Seconds;
use crate::command::tables::{normal, point, write_table};

pub(crate) fn run(
    arguments: &ContactsArguments,
    first: Opened,
    progress: &Progress,
    mut outputs: Outputs,
) -> Result<(), Failure> {
    refuse_options_of_packings(arguments, &first.name)?;
    if outputs.table != TableFormat::Vtp {
        outputs.table.is_table("elements of meshes or of several files")?;
    }
    let mut seconds = Seconds::default();
    let mut files = vec![read(arguments, first, progress, &mut seconds)?];
    for file in &arguments.more {
        files.push(read(
            arguments,
            input::open(file, None, arguments.input.max_memory, progress)?,
            progress,
            &mut seconds,
        )?);
    }
    if files.iter().all(|file| matches!(file.content, Content::Mesh(_))) {
        let of_spheres = [
            ("--radius", arguments.input.radius.is_some()),
            ("--columns", arguments.input.columns.is_some()),
        ];
        if let Some((option, _)) = of_spheres.into_iter().find(|(_, given)| *given) {
            return Err(Failure::Unusable(format!(
                "{}: {option} is for packings, these are meshes",
                files[0].name
            )));
        }
    }
    let task = MeshTask { arguments, progress, files: &files };
    let mut summary = task.find(&mut outputs, seconds)?;
    summary.measure_peak();
    outputs.finish(&summary, arguments.quiet)
}

/// Refuses options that have no meaning for meshes.
fn refuse_options_of_packings(arguments: &ContactsArguments, name: &str) -> Result<(), Failure> {
    let given = [
        ("--cutoff", arguments.input.cutoff.is_some()),
        ("--tolerance", arguments.input.tolerance > 0.0),
        ("--bodies", arguments.bodies.is_some()),
        ("--periodic", arguments.periodic.periodic.is_some_and(|axes| axes.0 != [false; 3])),
        ("--explain", arguments.explain),
        ("--analyse", arguments.analysis.analyse),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Failure::Unusable(format!(
            "{name}: {option} is for one packing, not for meshes or several files"
        ))),
        None => Ok(()),
    }
}

/// Refuses a packing whose file has a periodic box, unless `--periodic` is given.
fn refuse_periodic(input: &Input, arguments: &PeriodicArguments) -> Result<(), Failure> {
    let repeats = input.packing.cell.is_some_and(|cell| cell.repeats.contains(&true));
    if repeats && arguments.periodic.is_none() {
        return Err(Failure::Unusable(format!(
            "{}: its box is periodic, which is not possible with several files: --periodic none ignores the box",
            input.name
        )));
    }
    Ok(())
}

/// A file with bodies.
struct BodyFile {
    name: String,
    content: Content,
}

enum Content {
    Mesh(fdem_io::MeshFile),
    Spheres { input: Input, centres: Vec<[f64; 3]>, radii: Vec<f64> },
}

fn read(
    arguments: &ContactsArguments,
    opened: Opened,
    progress: &Progress,
    seconds: &mut Seconds,
) -> Result<BodyFile, Failure> {
    let name = opened.name.clone();
    if opened.is_mesh() {
        let mut load = |path: &str| std::fs::read(path).map_err(|error| error.to_string());
        let (mesh, reading) =
            progress.step("reading", None, |_| fdem_io::read_mesh_with(&opened.bytes, &name, &mut load));
        seconds.read += opened.seconds + reading;
        let mesh = mesh.map_err(|error| Failure::Unusable(error.to_string()))?;
        if mesh.triangles.is_empty() && mesh.tetrahedra.is_empty() {
            return Err(Failure::Unusable(format!(
                "{name}: the mesh has only segments, but triangles or tetrahedra are needed"
            )));
        }
        return Ok(BodyFile { name, content: Content::Mesh(mesh) });
    }
    let mut input = input::understand(opened, &arguments.input, progress)?;
    refuse_periodic(&input, &arguments.periodic)?;
    seconds.read += input.seconds;
    let radii = match sizes(&arguments.input, &input)? {
        Sizes::Each(radii) => radii.to_vec(),
        Sizes::All(radius) => vec![radius; input.packing.centres.len()],
        Sizes::Cutoff(_) | Sizes::Pairs(_) => {
            return Err(Failure::Unusable(format!(
                "{name}: --cutoff is for one packing, not for several files"
            )));
        }
    };
    match std::mem::replace(&mut input.packing.centres, Centres::Three(Vec::new())) {
        Centres::Three(centres) => Ok(BodyFile { name, content: Content::Spheres { input, centres, radii } }),
        Centres::Two(_) => Err(Failure::Unusable(format!(
            "{name}: discs in 2D can only be compared within one file; several files need spheres in 3D"
        ))),
    }
}

/// Element sets that a note names; the rest is counted.
const NAMED_SETS: usize = 6;

/// Differences between a mesh and its file, and sets that are no bodies because they overlap.
fn notes_of(mesh: &fdem_io::MeshFile) -> Vec<String> {
    let mut notes = mesh.source.notes();
    let is_solid = !mesh.tetrahedra.is_empty();
    let elements = |group: &MeshGroup| if is_solid { group.tetrahedra.len() } else { group.triangles.len() };
    let whole = if is_solid { mesh.tetrahedra.len() } else { mesh.triangles.len() };
    let sets = mesh.groups.iter().filter(|group| elements(group) > 0);
    let names: Vec<&str> = sets.clone().filter_map(|group| group.name.as_deref()).collect();
    // One set of all elements is no other body.
    let has_parts = sets.clone().any(|group| elements(group) < whole);
    if mesh.source.format == MeshFormat::Abaqus && mesh.bodies.len() == 1 && has_parts {
        // Files of grains have thousands of sets.
        let (some, more) = names.split_at(names.len().min(NAMED_SETS));
        let more = match more.len() {
            0 => String::new(),
            count => format!(" and {} more", grouped(count as u64)),
        };
        let some = some.join(", ");
        notes.push(format!("the element sets {some}{more} overlap: the elements are one body"));
    }
    notes
}

/// Elements of all files with one numbering, in the order of the files. Meshes and spheres are stored
/// separately.
struct Model<const D: usize, const N: usize> {
    points: Vec<[f64; D]>,
    elements: Vec<[u32; N]>,
    /// Body of each element of the meshes; `mesh_numbers` has its number among all elements. Parts of an
    /// element that was cut when it was read have one number.
    mesh_bodies: Vec<u32>,
    mesh_numbers: Vec<u32>,
    centres: Vec<[f64; D]>,
    radii: Vec<f64>,
    sphere_numbers: Vec<u32>,
    sphere_bodies: Vec<u32>,
    /// Id of each element in its file; `bodies` has its body.
    ids: Vec<i64>,
    bodies: Vec<u32>,
    /// Whether an element of a mesh was cut.
    is_cut: bool,
    /// Number of the first node or the first sphere of each file.
    starts: Vec<usize>,
    described: Vec<FileOf>,
    named: Vec<BodyOf>,
    body_count: u32,
}

/// Result of a search. Elements have the numbers of the model; contacts are sorted by `i`, then `j`.
struct MeshResult<const D: usize> {
    contacts: Vec<(Couple, Contact<D>)>,
    bodies: Vec<BodyContact<D>>,
    couples: Couples,
    verified: Option<usize>,
    /// Time for verifying, s.
    verifying: f64,
}

struct MeshTask<'a> {
    arguments: &'a ContactsArguments,
    progress: &'a Progress,
    files: &'a [BodyFile],
}

impl MeshTask<'_> {
    fn find(&self, outputs: &mut Outputs, seconds: Seconds) -> Result<MeshSummary, Failure> {
        let meshes = || {
            self.files.iter().filter_map(|file| match &file.content {
                Content::Mesh(mesh) => Some((&file.name, mesh)),
                Content::Spheres { .. } => None,
            })
        };
        let spheres = self.files.iter().find(|file| matches!(file.content, Content::Spheres { .. }));
        let solid = meshes().find(|(_, mesh)| !mesh.tetrahedra.is_empty());
        let flat = spheres.is_none() && meshes().all(|(_, mesh)| mesh.dimensions == 2);
        match (spheres, solid) {
            (Some(spheres), Some((solid, _))) => Err(Failure::Unusable(format!(
                "{solid} has tetrahedra, {} has spheres: spheres can only be compared with triangles; give the surface of the body",
                spheres.name
            ))),
            (None, Some(_)) => {
                let model = self.model(
                    |p| p,
                    |nodes: [u32; 3]| [nodes[0], nodes[1], nodes[2], nodes[2]],
                    |nodes| nodes,
                )?;
                self.finish(&model, self.search(&model, |_, _, _| Ok(()), seconds)?, outputs)
            }
            (None, None) if flat => {
                let model = self.model(
                    |[x, y, _]| [x, y],
                    |nodes: [u32; 3]| nodes,
                    |_| unreachable!("no tetrahedra"),
                )?;
                let (found, seconds) = self.search(&model, |_, _, _| Ok(()), seconds)?;
                let drawing = MeshDrawing {
                    points: &model.points,
                    triangles: &model.elements,
                    bodies: &model.mesh_bodies,
                    contacts: &found.bodies,
                };
                outputs.drawings.write_mesh(&self.files[0].name, &drawing)?;
                self.finish(&model, (found, seconds), outputs)
            }
            (_, None) => {
                let model = self.model(|p| p, |nodes: [u32; 3]| nodes, |_| unreachable!("no tetrahedra"))?;
                let with_spheres =
                    |search: &mut MeshSearch<3>, mesh: &MeshView<'_, 3, 3>, found: &mut MeshResult<3>| {
                        self.with_spheres(&model, search, mesh, found)
                    };
                self.finish(&model, self.search(&model, with_spheres, seconds)?, outputs)
            }
        }
    }

    fn model<const D: usize, const N: usize>(
        &self,
        point: impl Fn([f64; 3]) -> [f64; D],
        triangle: impl Fn([u32; 3]) -> [u32; N],
        tetrahedron: impl Fn([u32; 4]) -> [u32; N],
    ) -> Result<Model<D, N>, Failure> {
        let mut model = Model {
            points: Vec::new(),
            elements: Vec::new(),
            mesh_bodies: Vec::new(),
            mesh_numbers: Vec::new(),
            centres: Vec::new(),
            radii: Vec::new(),
            sphere_numbers: Vec::new(),
            sphere_bodies: Vec::new(),
            ids: Vec::new(),
            bodies: Vec::new(),
            is_cut: false,
            starts: Vec::new(),
            described: Vec::new(),
            named: Vec::new(),
            body_count: 0,
        };
        for (file, source) in self.files.iter().enumerate() {
            match &source.content {
                Content::Mesh(mesh) => {
                    model.starts.push(model.points.len());
                    let first = model.points.len() as u32;
                    model.points.extend(mesh.points.iter().map(|&p| point(p)));
                    if u32::try_from(model.points.len()).is_err() {
                        return Err(Failure::Unusable(format!(
                            "{}: with this file there are more than 4294967295 nodes",
                            source.name
                        )));
                    }
                    if mesh.tetrahedra.is_empty() {
                        let cells = &mesh.triangles;
                        let nodes = cells.nodes.iter().map(|nodes| triangle(nodes.map(|node| node + first)));
                        model.elements.extend(nodes);
                        model.add_mesh(file, source, mesh, "triangles", &cells.bodies, &cells.numbers)?;
                    } else {
                        let cells = &mesh.tetrahedra;
                        let nodes =
                            cells.nodes.iter().map(|nodes| tetrahedron(nodes.map(|node| node + first)));
                        model.elements.extend(nodes);
                        model.add_mesh(file, source, mesh, "tetrahedra", &cells.bodies, &cells.numbers)?;
                    }
                }
                Content::Spheres { input, centres, radii } => {
                    model.starts.push(model.centres.len());
                    model.centres.extend(centres.iter().map(|&p| point(p)));
                    model.radii.extend(radii);
                    let n = centres.len() as u32;
                    let first = model.ids.len() as u32;
                    model.sphere_numbers.extend(first..first + n);
                    model.ids.extend((0..centres.len()).map(|row| id(&input.packing, row)));
                    model.bodies.extend(model.body_count..model.body_count + n);
                    model.sphere_bodies.extend(model.body_count..model.body_count + n);
                    model.described.push(FileOf {
                        file: source.name.clone(),
                        format: input.packing.source.format.to_string(),
                        elements: centres.len(),
                        kind: "spheres",
                        bodies: n,
                        first_body: model.body_count,
                        bodies_from: "each sphere".to_owned(),
                        left_out: None,
                        notes: Vec::new(),
                    });
                    model.body_count += n;
                }
            }
            if u32::try_from(model.ids.len()).is_err() {
                return Err(Failure::Unusable(format!(
                    "{}: with this file there are more than 4294967295 elements",
                    source.name
                )));
            }
        }
        Ok(model)
    }

    /// Finds the contacts of the meshes, and further contacts by `more`.
    fn search<const D: usize, const N: usize>(
        &self,
        model: &Model<D, N>,
        more: impl FnOnce(&mut MeshSearch<D>, &MeshView<'_, D, N>, &mut MeshResult<D>) -> Result<(), MeshStop>,
        mut seconds: Seconds,
    ) -> Result<(MeshResult<D>, Seconds), Failure>
    where
        [[f64; D]; N]: MeshElement<D>,
    {
        let start = Instant::now();
        let (found, _) = self.progress.step("detecting", None, |_| self.contacts_of(model, more));
        let found = found.map_err(|stop| self.told(model, stop))?;
        seconds.detect = start.elapsed().as_secs_f64() - found.verifying;
        seconds.verify = self.arguments.verify.map(|_| found.verifying);
        Ok((found, seconds))
    }

    fn contacts_of<const D: usize, const N: usize>(
        &self,
        model: &Model<D, N>,
        more: impl FnOnce(&mut MeshSearch<D>, &MeshView<'_, D, N>, &mut MeshResult<D>) -> Result<(), MeshStop>,
    ) -> Result<MeshResult<D>, MeshStop>
    where
        [[f64; D]; N]: MeshElement<D>,
    {
        let mesh = MeshView::new(&model.points, &model.elements, &model.mesh_bodies)?;
        let mut search = MeshSearch::new()
            .with_engine(self.arguments.engine.engine())
            .with_threads(self.arguments.threads)?
            .with_self_contact(self.arguments.meshes.self_contact);
        let mut elements = Vec::new();
        search.contacts(&mesh, &mut elements)?;
        let mut bodies = body_contacts(&mesh, &elements)?;
        let number = |k: u32| model.mesh_numbers[k as usize];
        let mut contacts: Vec<_> =
            elements.iter().map(|c| (Couple { i: number(c.i), j: number(c.j) }, c.contact)).collect();
        if model.is_cut {
            let by_number = MeshView::new(&model.points, &model.elements, &model.mesh_numbers)?;
            contacts = combined(contacts, &body_contacts(&by_number, &elements)?);
            count_couples(&mut bodies, &contacts, |couple| model.bodies_of(couple));
        }
        let couples = Couples { meshes: contacts.len(), ..Couples::default() };
        let mut found = MeshResult { contacts, bodies, couples, verified: None, verifying: 0.0 };
        if let Some(sample) = self.arguments.verify {
            let start = Instant::now();
            let checked = search
                .verify(&mesh, &elements, sample, 0)
                .map_err(|mismatch| MeshStop::Wrong(mismatch.to_string()))?;
            found.verified = Some(checked);
            found.verifying = start.elapsed().as_secs_f64();
        }
        drop(elements);
        more(&mut search, &mesh, &mut found)?;
        Ok(found)
    }

    /// Adds couples of spheres, and couples of spheres with triangles.
    fn with_spheres(
        &self,
        model: &Model<3, 3>,
        search: &mut MeshSearch<3>,
        mesh: &MeshView<'_, 3, 3>,
        found: &mut MeshResult<3>,
    ) -> Result<(), MeshStop> {
        if model.centres.is_empty() {
            return Ok(());
        }
        let (centres, radii) = (&model.centres, &model.radii);
        let mut walls = Vec::new();
        search.sphere_contacts(centres, radii, mesh, &mut walls)?;
        let spheres = Elements::spheres_with_radii(centres, radii)?;
        let mut couples = Vec::new();
        Detector::new()
            .with_engine(self.arguments.engine.engine())
            .with_threads(self.arguments.threads)?
            .couples(&spheres, &mut couples)?;
        if let Some(sample) = self.arguments.verify {
            let start = Instant::now();
            let wrong = |mismatch: fdem_contact::Mismatch| MeshStop::Wrong(mismatch.to_string());
            let spheres = verify(&spheres, &couples, sample, 0).map_err(wrong)?;
            MeshSearch::verify_spheres(centres, radii, mesh, &walls, sample, 0)?.map_err(wrong)?;
            found.verified = Some(found.verified.unwrap_or(0) + spheres);
            found.verifying += start.elapsed().as_secs_f64();
        }
        found.couples.spheres = couples.len();

        let sphere = |k: u32| Sphere::new(centres[k as usize], radii[k as usize]);
        for Couple { i, j } in couples {
            let refused = |problem| DiscretisedError::Sphere { index: i as usize, problem };
            let contact = sphere_sphere(&sphere(i).map_err(refused)?, &sphere(j).map_err(refused)?);
            let [i, j] = [i, j].map(|k| model.sphere_numbers[k as usize]);
            found.contacts.push((Couple { i, j }, contact));
        }
        let with_wall = |wall: SphereContact| {
            let sphere = model.sphere_numbers[wall.sphere as usize];
            let triangle = model.mesh_numbers[wall.contact.triangle as usize];
            let mut contact = wall.contact.contact;
            if triangle < sphere {
                contact.normal = contact.normal.map(|x| -x);
            }
            (Couple::new(sphere, triangle), contact)
        };
        let mut walls: Vec<_> = walls.into_iter().map(with_wall).collect();
        if model.is_cut {
            walls = combined(walls, &[]);
        }
        found.couples.spheres_and_meshes = walls.len();
        found.contacts.extend(walls);
        found.contacts.sort_unstable_by_key(|(couple, _)| *couple);
        // The contacts of bodies are gathered from those of elements alone, because surfaces share no further
        // boundary.
        let with_bodies: Vec<_> =
            found.contacts.iter().map(|(couple, contact)| (model.bodies_of(*couple), *contact)).collect();
        found.bodies = gather(&with_bodies)?;
        Ok(())
    }

    fn finish<const D: usize, const N: usize>(
        &self,
        model: &Model<D, N>,
        (found, mut seconds): (MeshResult<D>, Seconds),
        outputs: &mut Outputs,
    ) -> Result<MeshSummary, Failure> {
        let (written, writing) =
            self.progress.step("writing", Some(found.contacts.len() as u64), |position| {
                if self.arguments.count {
                    outputs.count(found.contacts.len() as u64)?;
                } else if let Some(couples) = &mut outputs.couples {
                    if outputs.table == TableFormat::Vtp {
                        let lines = Branches::new(&model.parts(), &found.contacts);
                        let points = lines.points(&model.ids, &model.bodies);
                        let table = lines.table(&found.contacts);
                        couples.write(|mut out| fdem_io::write_vtp(&mut out, &points, &table))?;
                    } else {
                        write_table(couples, outputs.table, &model.table(&found.contacts, position))?;
                    }
                }
                match &mut outputs.bodies {
                    Some((format, output)) => write_table(output, *format, &body_table(&found.bodies)),
                    None => Ok(()),
                }
            });
        written?;
        seconds.write = writing;

        let mut in_contact = vec![false; model.body_count as usize];
        let mut between = 0;
        for contact in &found.bodies {
            let [a, b] = contact.bodies;
            in_contact[a as usize] = true;
            in_contact[b as usize] = true;
            between += usize::from(a != b);
        }
        let bodies = model.body_count as usize;
        let summary = MeshSummary {
            files: model.described.clone(),
            bodies_of_meshes: model.named.clone(),
            dimensions: D,
            elements: model.described.iter().map(|file| file.elements).sum(),
            bodies,
            engine: self.arguments.engine.engine().map_or("auto", Engine::name),
            threads: self.arguments.threads,
            couples: found.contacts.len(),
            couples_by_kind: found.couples,
            body_contacts: found.bodies.len(),
            mean_coordination: if bodies == 0 { 0.0 } else { 2.0 * between as f64 / bodies as f64 },
            without_contact: in_contact.iter().filter(|&&touched| !touched).count(),
            overlap: found.bodies.iter().fold(0.0, |sum, contact| sum + contact.overlap),
            shared: found.bodies.iter().fold(0.0, |sum, contact| sum + contact.shared),
            verified: found.verified,
            seconds,
            peak_bytes: None,
        };
        if self.arguments.drawings.any() {
            let (drawn, _) = self.progress.step("drawing", None, |_| {
                let shapes = Shapes::new(&model.parts(), &found.bodies);
                outputs.drawings.write_bodies(&BodiesDrawing {
                    name: &self.files[0].name,
                    bodies: shapes.bodies(),
                    unit: self.unit(),
                    ids: None,
                    columns: &shapes.columns(),
                    summary: &summary.to_string(),
                })
            });
            drawn?;
        }
        Ok(summary)
    }

    /// Unit of the first file of spheres, if there is one.
    fn unit(&self) -> Option<&str> {
        self.files.iter().find_map(|file| match &file.content {
            Content::Spheres { input, .. } => input.packing.source.unit.as_deref(),
            Content::Mesh(_) => None,
        })
    }

    /// The failure with the message of the command, which names the file.
    fn told<const D: usize, const N: usize>(&self, model: &Model<D, N>, stop: MeshStop) -> Failure {
        let names: Vec<_> = self.files.iter().map(|file| file.name.as_str()).collect();
        let all = names.join(", ");
        // The last file of this kind whose first number is not above `number`.
        let file_of = |spheres: bool, number: usize| {
            let of_kind =
                |file: &usize| matches!(self.files[*file].content, Content::Spheres { .. }) == spheres;
            let file = (0..names.len())
                .rev()
                .filter(of_kind)
                .find(|&file| model.starts[file] <= number)
                .unwrap_or(0);
            (names[file], number - model.starts[file].min(number))
        };
        match stop {
            MeshStop::Wrong(mismatch) => Failure::of_couples(&all, &mismatch),
            MeshStop::Refused(DiscretisedError::Coordinate { node, axis, value }) => {
                let (name, node) = file_of(false, node);
                let error = DiscretisedError::Coordinate { node, axis, value };
                Failure::Unusable(format!("{name}: {error} (nodes are counted from 0)"))
            }
            MeshStop::Refused(DiscretisedError::Sphere { index, problem }) => {
                let (name, index) = file_of(true, index);
                Failure::Unusable(format!("{name}: sphere {index} (counted from 0): {problem}"))
            }
            MeshStop::Refused(DiscretisedError::Search(error @ Error::NoThreads { .. })) => {
                Failure::Unusable(format!("{all}: --threads: {error}"))
            }
            MeshStop::Refused(error) => Failure::Unusable(format!("{all}: {error}")),
        }
    }
}

/// Why a search stopped.
enum MeshStop {
    Refused(DiscretisedError),
    Wrong(String),
}

impl From<DiscretisedError> for MeshStop {
    fn from(error: DiscretisedError) -> Self {
        Self::Refused(error)
    }
}

impl From<Error> for MeshStop {
    fn from(error: Error) -> Self {
        Self::Refused(error.into())
    }
}

impl<const D: usize, const N: usize> Model<D, N> {
    /// Adds numbers, bodies and description of the elements of a mesh.
    fn add_mesh(
        &mut self,
        file: usize,
        source: &BodyFile,
        mesh: &fdem_io::MeshFile,
        kind: &'static str,
        bodies: &[u32],
        numbers: &[u64],
    ) -> Result<(), Failure> {
        // Bodies that have elements of this kind, in the order of the file.
        let mut elements = vec![0_usize; mesh.bodies.len()];
        for &body in bodies {
            elements[body as usize] += 1;
        }
        let mut global = vec![0; mesh.bodies.len()];
        let first_body = self.body_count;
        for (body, &elements) in elements.iter().enumerate().filter(|(_, elements)| **elements > 0) {
            global[body] = self.body_count;
            let fdem_io::MeshBody { number, name } = mesh.bodies[body].clone();
            self.named.push(BodyOf { body: self.body_count, file, number, name, elements });
            self.body_count += 1;
        }
        let fdem_io::MeshSource { quadrilaterals, polygons, cut_solids, .. } = mesh.source;
        let is_cut = quadrilaterals + polygons + cut_solids > 0;
        self.is_cut |= is_cut;
        let mut before = None;
        for (&number, &body) in numbers.iter().zip(bodies) {
            let body = global[body as usize];
            // The parts of an element follow each other.
            if !is_cut || before.replace((number, body)) != Some((number, body)) {
                let id = i64::try_from(number);
                self.ids.push(id.map_err(|_| {
                    Failure::Unusable(format!(
                        "{}: the element number {number} needs more than 63 bits",
                        source.name
                    ))
                })?);
                self.bodies.push(body);
            }
            self.mesh_bodies.push(body);
            self.mesh_numbers.push(self.ids.len() as u32 - 1);
        }
        let triangles = if kind == "tetrahedra" { mesh.triangles.len() } else { 0 };
        let left_out = LeftOut {
            triangles,
            segments: mesh.segments.len(),
            points: mesh.source.point_elements,
            collapsed_facets: mesh.source.collapsed_facets,
        };
        self.described.push(FileOf {
            file: source.name.clone(),
            format: mesh.source.format.to_string(),
            elements: elements.iter().sum(),
            kind,
            bodies: self.body_count - first_body,
            first_body,
            bodies_from: mesh.source.bodies_from.to_string(),
            left_out: Some(left_out),
            notes: notes_of(mesh),
        });
        Ok(())
    }

    /// The elements and spheres, for drawing.
    fn parts(&self) -> BodyParts<'_, D, N> {
        BodyParts {
            points: &self.points,
            elements: &self.elements,
            bodies: &self.mesh_bodies,
            numbers: &self.mesh_numbers,
            centres: &self.centres,
            radii: &self.radii,
            sphere_bodies: &self.sphere_bodies,
            sphere_numbers: &self.sphere_numbers,
            body_count: self.body_count as usize,
        }
    }

    fn bodies_of(&self, couple: Couple) -> [u32; 2] {
        [couple.i, couple.j].map(|k| self.bodies[k as usize])
    }

    /// Table with a row per contact of elements, which have their numbers in the files. `position` counts the
    /// rows.
    fn table<'a>(&'a self, contacts: &'a [(Couple, Contact<D>)], position: &'a Position) -> Table<'a> {
        let bodies = move |k: usize| self.bodies_of(contacts[k].0).map(i64::from);
        let first = move |k: usize| {
            position.store(k as u64, Ordering::Relaxed);
            self.ids[contacts[k].0.i as usize]
        };
        // Adding 0.0 turns -0.0 into 0.0.
        Table::new(contacts.len())
            .with("i", Values::i64(first))
            .with("j", Values::i64(move |k| self.ids[contacts[k].0.j as usize]))
            .with("body_i", Values::i64(move |k| bodies(k)[0]))
            .with("body_j", Values::i64(move |k| bodies(k)[1]))
            .with("kind", Values::text(LONGEST_KIND, move |k| kind(contacts[k].1.measure)))
            .with("measure", Values::f64(move |k| contacts[k].1.measure.value()))
            .with_components(
                "point",
                point::<D>(),
                Values::f64(move |k| contacts[k / D].1.point[k % D] + 0.0),
            )
            .with_components(
                "normal",
                normal::<D>(),
                Values::f64(move |k| contacts[k / D].1.normal[k % D] + 0.0),
            )
    }
}

/// Length of the longest word of [`kind`], bytes.
const LONGEST_KIND: usize = 6;

fn kind(measure: Measure) -> &'static str {
    match measure {
        Measure::Gap(_) => "gap",
        Measure::Depth(_) => "depth",
        Measure::Length(_) => "length",
        Measure::Area(_) => "area",
        Measure::Volume(_) => "volume",
    }
}

/// Table with a row per contact of bodies.
fn body_table<const D: usize>(contacts: &[BodyContact<D>]) -> Table<'_> {
    Table::new(contacts.len())
        .with("i", Values::i64(|k| contacts[k].bodies[0].into()))
        .with("j", Values::i64(|k| contacts[k].bodies[1].into()))
        .with("couples", Values::i64(|k| contacts[k].couples.cast_signed()))
        .with("overlap", Values::f64(|k| contacts[k].overlap))
        .with("shared", Values::f64(|k| contacts[k].shared))
        .with_components("point", point::<D>(), Values::f64(|k| contacts[k / D].point[k % D] + 0.0))
        .with_components("normal", normal::<D>(), Values::f64(|k| contacts[k / D].normal[k % D] + 0.0))
}
