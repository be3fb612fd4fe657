//! Joint sets: their keys, their laws, and the facets on which they are.

use std::collections::BTreeSet;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Corners;
use fdem_mesh::triangles::SNAP;
use fdem_simulation::{Element, JointSet, Model, Strength};

use crate::joints::lines::{JointLines, has_joints, is_between_groups, may_have_group};
use crate::joints::planes::PERSISTENT;
use crate::joints::{polygons, polylines};
use crate::prepared::Joints;
use crate::shapes::placed::{self, Placed};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::{self, ModelFile};

/// Keys of statistical sets.
const STATISTICAL: [&str; 10] = [
    "dip_direction",
    "dip_direction_deviation",
    "spacing",
    "persistence",
    "trace_length",
    "dip_deviation",
    "spacing_deviation",
    "trace_deviation",
    "origin",
    "seed",
];

/// Help for joints in a mesh from a file.
const FROM_FILES: &str = "embed the joints in the mesh as a group of the file, and name it by group = \"…\" instead; or give the body a shape";

/// Help for a set without joints.
const MISSES: &str = "its lines or planes miss the bodies, lie along their outlines or other joints, or are short; \
     with optional = true a set may be without joints";

/// Checks the keys of all joint sets, and returns their laws.
pub(crate) fn check(
    file: &ModelFile,
    document: &Document<'_>,
    dimensions: u8,
    faults: &mut Vec<Fault>,
) -> Vec<JointSet> {
    for (index, set) in file.joint_set.iter().enumerate() {
        let check = Check { file, document, set, table: Table::of("joint_set", index), dimensions };
        check.sources(faults);
        check.numbers(faults);
        check.fits(faults);
        if set.dip.is_some() {
            check.statistics(faults);
        }
        check.bodies(faults);
        check.law(faults);
    }
    file.joint_set.iter().map(law).collect()
}

/// The law of a set.
fn law(set: &file::JointSet) -> JointSet {
    let tangent = |angle: f64| libm::tan(angle.to_radians());
    JointSet {
        name: set.name.clone(),
        strength: Strength {
            tensile: set.tensile_strength.unwrap_or(0.0),
            cohesion: set.cohesion.unwrap_or(0.0),
            friction: tangent(set.friction_angle),
            energy_i: set.fracture_energy_i.unwrap_or(0.0),
            energy_ii: set.fracture_energy_ii.unwrap_or(0.0),
            weibull_modulus: None,
            seed: 0,
        },
        residual_friction: tangent(set.residual_friction_angle.unwrap_or(set.friction_angle)),
        dilation: tangent(set.dilation_angle),
        dilation_slip: set.dilation_slip,
        normal_stiffness: set.normal_stiffness,
        shear_stiffness: set.shear_stiffness,
        open: set.open,
    }
}

struct Check<'a> {
    file: &'a ModelFile,
    document: &'a Document<'a>,
    set: &'a file::JointSet,
    table: Table,
    dimensions: u8,
}

impl Check<'_> {
    /// A fault at the value of a key.
    fn fault(&self, key: &str, message: &str) -> Fault {
        let message = format!("[[joint_set]] \"{}\": {message}", self.set.name);
        Fault::at(self.document.value(self.table, key), message)
    }

    /// Where the joints come from.
    fn sources(&self, faults: &mut Vec<Fault>) {
        let set = self.set;
        let sources = [
            ("lines", set.lines.is_some()),
            ("polygons", set.polygons.is_some()),
            ("file", set.file.is_some()),
            ("dip", set.dip.is_some()),
            ("group", set.group.is_some()),
            ("between", set.between.is_some()),
        ];
        let given: Vec<&str> = sources.iter().filter(|(_, given)| *given).map(|(key, _)| *key).collect();
        match given[..] {
            [_] => {}
            [] => {
                faults.push(
                    self.fault("name", "it has no joints")
                        .help(format!("give it one of {}, file, dip, group and between", self.list())),
                );
            }
            [first, second, ..] => faults.push(
                self.fault(second, &format!("its joints are given twice, by {first} and {second}"))
                    .help("write a second [[joint_set]]"),
            ),
        }
        if set.between.is_some() && set.bodies.is_some() {
            faults.push(self.fault("bodies", "\"between\" names the bodies").label("take it out"));
        }
        if set.scale.is_some() && set.file.is_none() {
            faults.push(self.fault("scale", "\"scale\" is the unit of a file").label("take it out"));
        }
        if set.dip.is_none() {
            for key in STATISTICAL.into_iter().filter(|key| self.document.has(self.table, key)) {
                faults.push(
                    self.fault(key, &format!("\"{key}\" is for statistical sets, which have a dip"))
                        .label("take it out"),
                );
            }
        }
    }

    /// The key of a list of joints.
    fn list(&self) -> &'static str {
        if self.dimensions == 2 { "lines" } else { "polygons" }
    }

    /// Keys that are for the other number of dimensions.
    fn fits(&self, faults: &mut Vec<Fault>) {
        let flat = self.dimensions == 2;
        let in_space = ["polygons", "dip_direction", "dip_direction_deviation"];
        let others = if flat { &in_space[..] } else { &["lines"][..] };
        for key in others.iter().filter(|key| self.document.has(self.table, key)) {
            let message =
                format!("\"{key}\" is for models in {} dimensions", if flat { "three" } else { "two" });
            let fault = self.fault(key, &message).label("not in this model");
            let instead = format!("give the joints by \"{}\"", self.list());
            let is_list = ["lines", "polygons"].contains(key);
            faults.push(if is_list { fault.help(instead) } else { fault });
        }
        let found = self.set.origin.as_ref().map_or(usize::from(self.dimensions), |origin| origin.0.len());
        if found != usize::from(self.dimensions) {
            let message = format!(
                "\"origin\" has {found} numbers, where a model in {0} dimensions has {0}",
                self.dimensions
            );
            faults.push(self.fault("origin", &message).label(format!("{found} numbers")));
        }
    }

    /// The numbers of lists.
    fn numbers(&self, faults: &mut Vec<Fault>) {
        let set = self.set;
        for (place, numbers) in set.lines.iter().flatten().enumerate() {
            let wrong = match polylines::points(numbers) {
                None => "is not [x1, y1, x2, y2, …]",
                Some(chain) if !polylines::extends(&chain) => "has no length",
                Some(_) => continue,
            };
            let fault = self.fault("lines", &format!("line {} {wrong}", place + 1));
            let span = self.document.entry(self.table, "lines", place);
            faults.push(Fault { span: Some(span), ..fault }.label("this line"));
            break;
        }
        if let Some(wrong) =
            set.polygons.iter().flatten().position(|numbers| polygons::corners(numbers).is_none())
        {
            let message = format!("polygon {} is not [x1, y1, z1, x2, y2, z2, x3, y3, z3, …]", wrong + 1);
            let span = self.document.entry(self.table, "polygons", wrong);
            faults.push(Fault { span: Some(span), ..self.fault("polygons", &message) }.label("this polygon"));
        }
    }

    /// The keys of a statistical set.
    fn statistics(&self, faults: &mut Vec<Fault>) {
        let set = self.set;
        if self.dimensions == 3 && set.dip_direction.is_none() {
            faults.push(
                self.fault("dip", "in three dimensions a dip needs a dip_direction")
                    .label("needs dip_direction"),
            );
        }
        if self.dimensions == 3 && set.dip.is_some_and(|dip| dip < 0.0) {
            let help = "turn the dip_direction by 180 degrees";
            faults.push(
                self.fault("dip", "in three dimensions a dip is 0 to 90 degrees").label("below 0").help(help),
            );
        }
        let Some(spacing) = set.spacing else {
            faults.push(self.fault("dip", "a set with a dip needs a spacing").label("needs spacing"));
            return;
        };
        let bodies = self.file.body.iter().filter(|body| has_joints(set, body));
        let coarse = bodies
            .filter(|body| body.refine.is_empty())
            .find_map(|body| body.mesh_size.filter(|size| *size > spacing).map(|size| (body, size)));
        if let Some((body, size)) = coarse {
            let message =
                format!("the spacing is below the mesh_size of {size} m of the body \"{}\"", body.name);
            faults.push(
                self.fault("spacing", &message)
                    .help("take a smaller mesh_size: some elements across a spacing"),
            );
        }
        let persistence = set.persistence.unwrap_or(1.0);
        match set.trace_length {
            None if persistence < 1.0 => faults.push(
                self.fault("persistence", "a persistence below 1 needs a trace_length")
                    .label("needs trace_length"),
            ),
            Some(_) if self.dimensions == 3 && persistence > PERSISTENT && persistence < 1.0 => {
                let message = format!("a persistence in three dimensions is at most {PERSISTENT}, or 1");
                faults.push(self.fault("persistence", &message).label("too large"));
            }
            Some(_) if persistence >= 1.0 => faults.push(
                self.fault("trace_length", "joints with a persistence of 1 have no end, and no trace_length")
                    .help("give it a persistence below 1, or take trace_length out"),
            ),
            _ => {}
        }
        let length = set.trace_length.unwrap_or(0.0);
        if set.trace_deviation.is_some_and(|most| most > 0.0 && most >= length) {
            faults.push(self.fault("trace_deviation", "it is not below the trace_length").label("too large"));
        }
    }

    /// The bodies that are named.
    fn bodies(&self, faults: &mut Vec<Fault>) {
        let mut all = self.file.body.iter();
        let grains =
            all.find(|body| self.dimensions == 3 && body.voronoi.is_some() && has_joints(self.set, body));
        if let Some(body) = grains {
            let key = if self.set.bodies.is_some() { "bodies" } else { "name" };
            let message = format!(
                "the body \"{}\" has grains, into which no joints can be put in three dimensions",
                body.name
            );
            faults.push(
                self.fault(key, &message).label("not for grains").help("name other bodies in \"bodies\""),
            );
        }
        let from_files = self.file.body.iter().all(|body| body.mesh.is_some());
        let no_file = self.file.body.iter().all(|body| body.mesh.is_none());
        let set = self.set;
        if set.bodies.is_none() && !self.file.body.is_empty() {
            if set.group.is_some() && no_file {
                let message = "no body has a mesh from a file, whose groups \"group\" names";
                let help = format!("give its joints by {}, file or dip", self.list());
                faults.push(self.fault("group", message).help(help));
            } else if set.group.is_none() && set.between.is_none() && from_files {
                let message = "all bodies have meshes from files, into which no joints can be put";
                faults.push(self.fault("name", message).help(FROM_FILES));
            }
        }
        for (place, name) in self.set.between.iter().flatten().enumerate() {
            if !placed::may_fit_body(self.file, name) && !is_between_groups(set, self.file) {
                let span = self.document.entry(self.table, "between", place);
                faults.push(
                    Fault::at(span, format!("there is no body \"{name}\""))
                        .label("unknown body")
                        .help(placed::suggestion(self.file, name)),
                );
            }
        }
        for (place, name) in self.set.bodies.iter().flatten().enumerate() {
            let span = self.document.entry(self.table, "bodies", place);
            match self.file.body.iter().find(|body| body.name == *name) {
                None => faults.push(
                    Fault::at(span, format!("there is no body \"{name}\""))
                        .label("unknown body")
                        .help(placed::suggestion(self.file, name)),
                ),
                Some(body) if self.set.group.is_some() && body.mesh.is_none() => faults.push(
                    Fault::at(
                        span,
                        format!(
                            "[[joint_set]] \"{}\": the body \"{name}\" has no mesh from a file, whose groups \"group\" names",
                            self.set.name
                        ),
                    )
                    .help(format!("give its joints by {}, file or dip", self.list())),
                ),
                Some(body) if body.mesh.is_some() && self.set.group.is_none() => faults.push(
                    Fault::at(
                        span,
                        format!(
                            "[[joint_set]] \"{}\": the body \"{name}\" has a mesh from a file, into which no joints can be put",
                            self.set.name
                        ),
                    )
                    .help(FROM_FILES),
                ),
                Some(_) => {}
            }
        }
    }

    /// Strengths and energies.
    fn law(&self, faults: &mut Vec<Fault>) {
        let set = self.set;
        for (strength_key, strength, energy_key, energy) in [
            ("tensile_strength", set.tensile_strength, "fracture_energy_i", set.fracture_energy_i),
            ("cohesion", set.cohesion, "fracture_energy_ii", set.fracture_energy_ii),
        ] {
            let has = strength.is_some_and(|strength| strength > 0.0);
            if set.open && has {
                faults.push(
                    self.fault(strength_key, &format!("open joints have no {strength_key}"))
                        .help("take it out, or open = true"),
                );
            } else if has && energy.is_none() {
                faults.push(
                    self.fault(strength_key, &format!("a {strength_key} needs a {energy_key}"))
                        .label(format!("needs {energy_key}")),
                );
            } else if !has && energy.is_some() {
                faults.push(
                    self.fault(energy_key, &format!("\"{energy_key}\" is for sets with a {strength_key}"))
                        .label("take it out"),
                );
            }
        }
        if set.dilation_angle > set.residual_friction_angle.unwrap_or(set.friction_angle) {
            let message = "the dilation angle is above the residual friction angle: joints would give back more energy than they take";
            faults.push(self.fault("dilation_angle", message).label("too large"));
        }
        if set.open && set.dilation_angle > 0.0 {
            let message = "open joints leave their sides to contacts, which do not dilate";
            faults.push(self.fault("dilation_angle", message).label("take it out"));
        }
        if set.dilation_slip.is_some() && set.dilation_angle == 0.0 {
            let message = "\"dilation_slip\" goes with a dilation_angle";
            faults.push(self.fault("dilation_slip", message).label("take it out"));
        }
        if set.residual_friction_angle.is_some_and(|residual| residual > set.friction_angle) {
            faults.push(
                self.fault(
                    "residual_friction_angle",
                    "the residual friction angle is above the friction angle",
                )
                .label("too large"),
            );
        }
    }
}

/// Reports sets of groups that no body has.
pub(crate) fn check_groups<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    placed: &[Placed<D, N>],
    faults: &mut Vec<Fault>,
) {
    for (index, set) in file.joint_set.iter().enumerate() {
        if is_between_groups(set, file) {
            check_between(set, (index, document), placed, faults);
        }
        let Some(name) = &set.group else { continue };
        let bodies = placed.iter().filter(|body| may_have_group(set, &file.body[body.table]));
        let known: BTreeSet<&str> =
            bodies.flat_map(|body| body.piece.groups.keys()).map(String::as_str).collect();
        if !known.contains(name.as_str()) {
            let known: Vec<&str> = known.into_iter().collect();
            let message = format!("[[joint_set]] \"{}\": no body has a group \"{name}\"", set.name);
            let fault = Fault::at(document.value(Table::of("joint_set", index), "group"), message);
            faults.push(fault.label("unknown group").help(suggestion(name, &known, "group")));
        }
    }
}

/// Share of the length of the lines of a set that may vanish without a warning: lines across corners of
/// bodies are shorter than elements. Lines of statistics also lie by chance where others are.
const VANISHED: [f64; 2] = [0.01, 0.05];

/// Warns of lines that lie so near to an outline, or to other lines, that the mesh does not have them.
pub(crate) fn vanished<const D: usize, const N: usize>(
    file: &ModelFile,
    placed: &[Placed<D, N>],
    warnings: &mut Vec<String>,
) {
    for (number, set) in (0..).zip(&file.joint_set) {
        let (mut lines, mut length, mut all) = (0, 0.0, 0.0);
        for of in placed.iter().flat_map(|body| &body.piece.lines).filter(|of| of.set == number) {
            lines += of.vanished;
            length += of.vanished_length;
            all += of.length;
        }
        if lines > 0 && length > VANISHED[usize::from(set.dip.is_some())] * all {
            let noun = if lines == 1 { "line vanishes" } else { "lines vanish" };
            warnings.push(format!(
                "[[joint_set]] \"{}\": {} {noun}, or a part of them: {} of {} m in the bodies lie along outlines or other lines, or nearer to them than {SNAP} of mesh_size; move them or take a smaller mesh_size",
                set.name,
                grouped(lines as u64),
                brief(length),
                brief(all)
            ));
        }
    }
}

/// Reports names and patterns of `between` that no group of elements has.
fn check_between<const D: usize, const N: usize>(
    set: &file::JointSet,
    (index, document): (usize, &Document<'_>),
    placed: &[Placed<D, N>],
    faults: &mut Vec<Fault>,
) {
    let groups = placed.iter().flat_map(|body| &body.piece.groups);
    let known: BTreeSet<&str> =
        groups.filter(|(_, group)| !group.elements.is_empty()).map(|(name, _)| name.as_str()).collect();
    for (place, name) in set.between.iter().flatten().enumerate() {
        if !known.iter().any(|group| placed::fits(name, group)) {
            let span = document.entry(Table::of("joint_set", index), "between", place);
            let message = format!(
                "[[joint_set]] \"{}\": there is no body and no group of elements \"{name}\"",
                set.name
            );
            let known: Vec<&str> = known.iter().copied().collect();
            faults
                .push(Fault::at(span, message).label("unknown name").help(suggestion(name, &known, "group")));
        }
    }
}

/// Puts the joints of all bodies into the model. Returns how many each set has. A set without joints is a
/// fault, unless it is `optional`, or its joints are between bodies, which come later.
pub(crate) fn put<const D: usize, const N: usize>(
    model: &mut Model<D, N>,
    placed: &[Placed<D, N>],
    (file, document, lines): (&ModelFile, &Document<'_>, &JointLines<'_>),
    faults: &mut Vec<Fault>,
) -> Vec<Joints>
where
    [[f64; D]; N]: Corners<D, N> + Element<D, N>,
{
    let mut all = Vec::new();
    for number in 0..model.joint_sets.len() as u32 {
        let mut traces = BTreeSet::new();
        let (mut facets, mut measure) = (Vec::new(), 0.0);
        for (body, Placed { piece, first, .. }) in placed.iter().enumerate() {
            for joint in piece.joints.iter().filter(|joint| joint.set == number) {
                traces.insert((body, joint.trace));
                facets.push(joint.facet.map(|node| node + first[0]));
                let corners = joint.facet.map(|node| piece.nodes[node as usize]);
                measure += <[[f64; D]; N]>::facet_measure(&corners);
            }
        }
        let name = model.joint_sets[number as usize].name.clone();
        let set = &file.joint_set[number as usize];
        let between_groups = is_between_groups(set, file);
        if facets.is_empty() && (set.between.is_none() || between_groups) && !set.optional {
            let span = document.value(Table::of("joint_set", number as usize), "name");
            let message = format!("[[joint_set]] \"{name}\" has no joint in any body");
            let help = if between_groups {
                "no element of the first group shares an edge or face with one of the second; groups whose elements \
                 have nodes of their own do not touch"
                    .to_owned()
            } else {
                let bodies = placed.iter().filter(|body| has_joints(set, &file.body[body.table]));
                let nodes = bodies.flat_map(|body| body.piece.nodes.iter().copied());
                lines.advice(number as usize, nodes).unwrap_or_else(|| MISSES.to_owned())
            };
            faults.push(Fault::at(span, message).label("no joint").help(help));
        } else if !facets.is_empty() {
            model.add_joints(number, &facets);
        }
        let [length, area] = if D == 2 { [Some(measure), None] } else { [None, Some(measure)] };
        let polygons = placed.iter().flat_map(|body| &body.piece.polygons).filter(|of| of.set == number);
        let polygons = polygons.fold(None, |sum: Option<[usize; 2]>, of| {
            let [count, left_out] = sum.unwrap_or_default();
            Some([count + of.count, left_out + of.left_out])
        });
        let (joints, facets) = (traces.len(), facets.len());
        all.push(Joints { name, joints, facets, length, area, polygons, open: set.open });
    }
    all
}
