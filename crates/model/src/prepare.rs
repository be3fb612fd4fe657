//! A model file becomes a model that can be run.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use fdem_io::numbers::grouped;
use fdem_mesh::Quality;
use fdem_simulation::{Interface, JointSet, Material, Model, Schedule, TimeOptions};
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::advice::differences::Advised;
use crate::advice::pores::permeable;
use crate::advice::ready::Ready;
use crate::advice::{deforming, extreme, joined, overlaps, plausible, scaling, too_fast};
use crate::bodies::boxes::{self, BodyBox};
use crate::bodies::{build, dimensions, materials, sizes};
use crate::grains::{assemble, checks};
use crate::joints::bonds::Bonds;
use crate::joints::lines::JointLines;
use crate::joints::sets;
use crate::output::curves::{self, columns};
use crate::output::{fluid_columns, probes, settings};
use crate::prepared::{AnyPrepared, Group, Prepared, PreparedBody};
use crate::shapes::piece::Piece;
use crate::shapes::placed::Placed;
use crate::stages::conditions::{self, Resolved};
use crate::stages::injections::InjectionPlaces;
use crate::stages::pore_surfaces::PorePlaces;
use crate::stages::{
    boundaries, cavities, fluid, injections, pore_surfaces, pores, resolve, schedules, supports,
};
use crate::text::document::{Document, Table, line_of};
use crate::text::fault::{Fault, ModelErrors};
use crate::text::file::{self, ModelFile};
use crate::text::included::{Load, Sources};
use crate::text::library::{self, FromLibrary};
use crate::text::partial::Partial;
use crate::text::{schema, values};
use crate::{initial, vectors};

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
    prepare_any_with(text, name, load, memory, &mut |_| {})
}

/// Like [`prepare_any`]. `watch` sees the boxes of the bodies before they are meshed.
///
/// # Errors
/// The errors of [`prepare_within`].
pub fn prepare_any_with(
    text: &str,
    name: &str,
    load: &mut Load<'_>,
    memory: Option<f64>,
    watch: &mut dyn FnMut(&[BodyBox]),
) -> Result<AnyPrepared, ModelErrors> {
    prepare_scaled(text, name, load, (memory, 1.0), watch)
}

/// Like [`prepare_any`], with all sizes of meshes that are made here times `factor`: for a
/// [`Rehearsal`](crate::Rehearsal).
///
/// # Errors
/// The errors of [`prepare_any`].
pub fn prepare_coarse(
    text: &str,
    name: &str,
    load: &mut Load<'_>,
    factor: f64,
) -> Result<AnyPrepared, ModelErrors> {
    prepare_scaled(text, name, load, (None, factor), &mut |_| {})
}

fn prepare_scaled(
    text: &str,
    name: &str,
    load: &mut Load<'_>,
    meshes: (Option<f64>, f64),
    watch: &mut dyn FnMut(&[BodyBox]),
) -> Result<AnyPrepared, ModelErrors> {
    let sources = Sources::gather(text, load);
    prepare_or_faults(&sources, load, meshes, watch)
        .map_err(|faults| ModelErrors::new(name, &sources.text, faults).with_included(sources.included()))
}

/// Triangles, and tetrahedra, up to which bodies are meshed although there are faults, to find those of the
/// meshes too.
const SOON_MESHED: [f64; 2] = [1e5, 3e3];

fn prepare_or_faults(
    sources: &Sources<'_>,
    load: &mut Load<'_>,
    (memory, factor): (Option<f64>, f64),
    watch: &mut dyn FnMut(&[BodyBox]),
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
    let mut file = match &partial {
        Some(partial) => partial.file.clone(),
        None if faults.is_empty() => deserialize(&document)?,
        None => return Err(faults),
    };
    // A thin rigid body may not have larger elements, and has few.
    let all = file.body.iter().all(|body| body.rigid.always());
    file.body.iter_mut().filter(|body| all || !body.rigid.always()).for_each(|body| body.scale_mesh(factor));
    let mut ahead = Ahead::default();
    let dimensions = dimensions::of(&file, &mut |name| ahead.look(name, load));
    ahead.look_again();
    let is_news = |fault: &Fault| partial.as_ref().is_none_or(|partial| partial.is_news(fault));

    let mut found = Vec::new();
    vectors::check(&file, &document, dimensions, &mut found);
    check_names(&file, &document, &mut found);
    let materials = materials::materials(&file, &document, dimensions, &mut found);
    let interfaces = materials::interfaces(&file, &document, &mut found);
    let joint_sets = sets::check(&file, &document, dimensions, &mut found);
    build::check(&file, &document, dimensions, &mut found);
    build::check_overload(&file, &document, &mut found);
    checks::check(&file, &document, dimensions, &mut found);
    boundaries::check(&file, &document, &mut found);
    schedules::check(&file, &document, &mut found);
    cavities::check(&file, &document, &mut found);
    fluid::check(&file, &document, &mut found);
    injections::check(&file, &document, &mut found);
    pores::check(&file, &document, dimensions, &mut found);
    pore_surfaces::check(&file, &document, &mut found);
    settings::check(&file, &document, &mut found);
    resolve::check(&file, &document, &mut found);
    scaling::check(&file, &document, &mut found);
    extreme::check(&file, &document, &mut found);
    conditions::check(&file, &document, &mut found);
    initial::check(&file, &document, dimensions == 3, &mut found);
    let elements = sizes::check(&file, &document, memory, &mut found);
    faults.extend(found.into_iter().filter(is_news));
    if faults.is_empty() {
        watch(&boxes::boxes(&file, &document, &mut |name| ahead.look(name, load), &mut faults));
    }

    let mut load = |name: &str| ahead.take(name, load);
    // Included files may have parameters for other models.
    let unused = evaluated.unused.iter().filter(|(_, span)| sources.is_in_model(span));
    let warnings = unused.map(|(name, _)| format!("the parameter \"{name}\" is not used")).collect();
    let document = &document;
    let checked = Checked {
        sources,
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

/// Files that are looked at before bodies are meshed, and are read once: a run keeps its files in the order
/// in which they are read.
#[derive(Default)]
struct Ahead {
    /// Name and bytes of each file, in order, and whether this look has had it.
    files: Vec<(String, Result<Vec<u8>, String>, bool)>,
}

impl Ahead {
    /// Begins a look at files that may have been looked at before.
    fn look_again(&mut self) {
        self.files.iter_mut().for_each(|(.., had)| *had = false);
    }

    fn look(&mut self, name: &str, load: &mut Load<'_>) -> Result<Vec<u8>, String> {
        if let Some((_, bytes, had)) = self.files.iter_mut().find(|(known, _, had)| known == name && !had) {
            *had = true;
            return bytes.clone();
        }
        let bytes = load(name);
        self.files.push((name.to_owned(), bytes.clone(), true));
        bytes
    }

    /// The bytes of a file that was looked at, once for each look; else those that `load` gives.
    fn take(&mut self, name: &str, load: &mut Load<'_>) -> Result<Vec<u8>, String> {
        match self.files.iter().position(|(known, ..)| known == name) {
            Some(first) => self.files.remove(first).1,
            None => load(name),
        }
    }
}

/// A file whose tables have been checked one by one.
struct Checked<'a> {
    sources: &'a Sources<'a>,
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
        [[f64; D]; N]: Advised<D, N>,
        Model<D, N>: Serialize,
    {
        let Self { sources, file, document, elements, materials, .. } = self;
        let Self { interfaces, joint_sets, from_library, mut warnings, .. } = self;
        // A file with faults is meshed only to find more faults: bodies without faults, and only if that
        // takes little time.
        let mut wrong = document.with_faults("body", file.body.len(), &faults);
        for (wrong, body) in wrong.iter_mut().zip(&file.body) {
            *wrong |= !faults.is_empty() && elements > SOON_MESHED[D - 2] && body.mesh.is_none();
        }
        let skipped = document.with_faults("boundary", file.boundary.len(), &faults);
        let mut found = Vec::new();
        let lines = JointLines::of(D, file, document, load, &mut found);
        let (mesh, placed, missing) = build::build(file, document, (&lines, load), &wrong, &mut found);
        let boundaries =
            boundaries::resolve(file, document, &mesh, &placed, (&missing, &skipped), load, &mut found);
        let (mut stages, mut bonds, mut fluid, mut pores) = (Vec::new(), Bonds::default(), None, None);
        if missing.is_empty() {
            stages = resolve::resolve(file, document, &mesh, &placed, &mut found);
            sets::check_groups(file, document, &placed, &mut found);
            bonds = Bonds::find(file, document, &placed, &mut found);
            let places = InjectionPlaces::of((file, document), (&mesh, &placed), &boundaries, &bonds);
            fluid = places.fluid(gravity(file), faults.is_empty(), load, &mut found);
            let places = PorePlaces { file, document, mesh: &mesh, placed: &placed };
            pores = places.pores(gravity(file), faults.is_empty(), load, &mut found);
        }
        let mut spheres = || assemble::assemble(file, document, (&materials, &placed), load, &mut found);
        let sphere_model = if faults.is_empty() && missing.is_empty() { spheres() } else { None };
        faults.extend(found.into_iter().filter(is_news));
        faults.extend(build::crowded(document, &placed));
        none_or(faults)?;

        let mut histories = settings::histories(file, &mesh.nodes, &placed, &mut warnings);
        let (mut lost, mut unknown, mut idle) = (Vec::new(), Vec::new(), Vec::new());
        let mut probes = probes::probes(file, document, &mesh, &placed, &mut lost);
        none_or(lost)?;
        fluid_columns::add(file, &mut histories, &mut probes);
        let own = columns::<D, N>(&histories, &probes);
        let curves = curves::curves::<D>(file, document, &own, &mut unknown);
        let Resolved { until, of_stages, servos } =
            conditions::resolve::<D>(file, document, &own, &mut unknown);
        for (stage, until) in stages.iter_mut().zip(of_stages) {
            stage.until = until;
        }
        none_or(unknown)?;
        let mut model = Model {
            rigid: build::rigid(file, &placed),
            until_overloaded: build::until_overloaded(file, &placed),
            grains: sphere_model.as_ref().map(|of| of.model.clone()),
            fluid,
            velocities: initial::velocities(file, &placed),
            stresses: initial::stresses(file, &mesh, &placed, pores.as_ref()),
            pores,
            mesh,
            materials,
            interfaces,
            joint_sets,
            boundaries,
            plane: file.model.plane,
            thickness: file.model.thickness,
            gravity: gravity(file),
            gravity_schedule: file.model.gravity_ramp.map_or(Schedule::Constant, Schedule::Ramp),
            contact: file.contact,
            fracture: file.fracture,
            time: time_options(file),
            ..Model::default()
        };
        let joint_sets = sets::put(&mut model, &placed, (file, document, &lines), &mut idle);
        let (quality, bodies) = (Quality::of(&model.mesh), bodies_of(&placed));
        warnings.extend(notes_of(file, &placed));
        warnings.extend(lines.notes);
        warnings.extend(sphere_model.iter().flat_map(|of| of.notes.iter().cloned()));
        sets::vanished(file, &placed, &mut warnings);
        conditions::warnings(file, &model, &servos, &own, &mut warnings);
        let is_in_model = |span: &std::ops::Range<usize>| sources.is_in_model(span);
        let deforming = deforming::quality(&model, &quality);
        let ready = Ready { file, model: &model, placed: &placed, bodies: &bodies, quality: &deforming };
        advise(&ready, document, &is_in_model, &mut warnings, idle)?;
        let mut prepared = Prepared {
            title: file.model.title.clone(),
            end_time: file.model.end_time,
            groups: groups_of(&placed),
            about_files: about_files(&placed),
            grains: grains_of(&placed),
            spheres: sphere_model.map(|of| of.prepared),
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
        finish(file, document, (&bonds, &placed), &mut prepared).map_err(|fault| vec![fault])?;
        prepared.hash = hash_of(&prepared);
        Ok(prepared)
    }
}

/// Joins bonded bodies, and makes the last checks and changes of a model that is complete.
fn finish<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    (bonds, placed): (&Bonds<D>, &[Placed<D, N>]),
    prepared: &mut Prepared<D, N>,
) -> Result<(), Fault>
where
    [[f64; D]; N]: Advised<D, N>,
{
    let joined = bonds.join(prepared);
    joined.map_err(|error| Fault::at(document.key(Table::of("joint_set", 0), "name"), error))?;
    let tables: Vec<usize> = placed.iter().map(|body| body.table).collect();
    if file.stage.is_empty()
        && let Some(name) = pores::settle(&mut prepared.model).first()
    {
        let index = file.pore_surface.iter().position(|surface| surface.name == *name);
        let span = document.value(Table::of("pore_surface", index.unwrap_or(0)), "name");
        let message = format!("[[pore_surface]] \"{name}\" lies between bonded bodies alone");
        return Err(Fault::at(span, message).label("no surface"));
    }
    build::overloaded_fault(file, document, &prepared.model, &tables)?;
    supports::check(file, document, prepared)?;
    extreme::steps(file, document, prepared)?;
    scaling::scale(file, document, prepared)
}

/// Acceleration of gravity, m/s².
fn gravity<const D: usize>(file: &ModelFile) -> [f64; D] {
    match &file.model.gravity {
        file::Gravity::Vector(gravity) => gravity.components(),
        file::Gravity::None(_) => [0.0; D],
    }
}

/// Adds warnings of a whole model. `faults`: parts of it that have no effect.
fn advise<const D: usize, const N: usize>(
    ready: &Ready<'_, D, N>,
    document: &Document<'_>,
    is_in_model: &dyn Fn(&std::ops::Range<usize>) -> bool,
    warnings: &mut Vec<String>,
    mut faults: Vec<Fault>,
) -> Result<(), Vec<Fault>>
where
    [[f64; D]; N]: Advised<D, N>,
{
    let Ready { file, model, placed, .. } = *ready;
    plausible::units(model, warnings);
    permeable(model, warnings);
    plausible::loads(model, warnings);
    too_fast::check((file, document), model, placed, warnings, &mut faults);
    plausible::without_effect(file, (document, is_in_model), model, warnings, &mut faults);
    joined::check((file, document), model, warnings, &mut faults);
    overlaps::check(ready, document, warnings, &mut faults);
    none_or(faults)?;
    warnings.extend(<[[f64; D]; N]>::warnings(ready));
    Ok(())
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
    let line = |fault: &Fault| fault.span.as_ref().map(|span| line_of(text, span.start));
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

/// Refuses names that occur twice, and names with characters that would break the lines in which they are
/// written.
fn check_names(file: &ModelFile, document: &Document<'_>, faults: &mut Vec<Fault>) {
    fn names<'f, T>(items: &'f [T], name: fn(&'f T) -> &'f str) -> Vec<&'f str> {
        items.iter().map(name).collect()
    }
    for (table, names) in [
        ("body", names(&file.body, |body| &body.name)),
        ("grains", names(&file.grains, |grains| &grains.name)),
        ("insertion", names(&file.insertion, |insertion| &insertion.name)),
        ("delete", names(&file.delete, |removal| &removal.name)),
        ("wall", names(&file.wall, |wall| &wall.name)),
        ("material", names(&file.material, |material| &material.name)),
        ("joint_set", names(&file.joint_set, |set| &set.name)),
        ("boundary", names(&file.boundary, |boundary| &boundary.name)),
        ("injection", names(&file.injection, |injection| &injection.name)),
        ("pore_surface", names(&file.pore_surface, |surface| &surface.name)),
        ("history", names(&file.history, |history| &history.name)),
        ("stage", names(&file.stage, |stage| &stage.name)),
        ("curve", names(&file.curve, |curve| &curve.name)),
    ] {
        for (index, name) in names.iter().enumerate().filter(|(_, name)| name.contains(char::is_control)) {
            let message =
                format!("the name of the [[{table}]] \"{}\" is not one line of text", name.escape_debug());
            let span = document.value(Table::of(table, index), "name");
            faults.push(Fault::at(span, message).label("has a control character"));
        }
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
    // Histories take both by their names.
    for (index, name) in file.groups_of_spheres().enumerate() {
        if file.body.iter().any(|body| body.name == name) {
            let table = match index.checked_sub(file.grains.len()) {
                None => Table::of("grains", index),
                Some(insertion) => Table::of("insertion", insertion),
            };
            let message = format!("there is a [[body]] \"{name}\" already");
            faults.push(
                Fault::at(document.value(table, "name"), message)
                    .label("again")
                    .help("bodies and spheres have different names"),
            );
        }
    }
}

fn bodies_of<const D: usize, const N: usize>(placed: &[Placed<D, N>]) -> Vec<PreparedBody> {
    let range = |first: u32, count: usize| first..first + count as u32;
    placed
        .iter()
        .map(|body| PreparedBody {
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

/// The notes of all bodies, with their names.
fn notes_of<const D: usize, const N: usize>(file: &ModelFile, placed: &[Placed<D, N>]) -> Vec<String> {
    let of = |body: &Placed<D, N>| {
        let name = &file.body[body.table].name;
        body.piece.notes.iter().map(|note| format!("[[body]] \"{name}\": {note}")).collect::<Vec<_>>()
    };
    // Copies of one surface have the same notes.
    let mut known = BTreeSet::new();
    placed.iter().flat_map(of).filter(|note| known.insert(note.clone())).collect()
}

fn groups_of<const D: usize, const N: usize>(placed: &[Placed<D, N>]) -> Vec<Group<D>>
where
    [[f64; D]; N]: Advised<D, N>,
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

fn about_files<const D: usize, const N: usize>(placed: &[Placed<D, N>]) -> Vec<String> {
    placed.iter().flat_map(|body| body.piece.about_file.iter().cloned()).collect()
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
