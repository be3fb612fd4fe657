//! Joint sets: their keys, their laws, and the facets on which they are.

use std::collections::BTreeSet;
use std::fmt;

use fdem_io::numbers::{brief, grouped};
use fdem_mesh::Simplex;
use fdem_simulation::{Element, JointSet, Model, Strength};
use serde::Serialize;

use crate::model::document::{Document, Table};
use crate::model::fault::Fault;
use crate::model::file::{self, ModelFile};
use crate::model::joint_lines::has_joints;
use crate::model::placed::{self, Placed};
use crate::model::polylines;

/// Keys of statistical sets.
const STATISTICAL: [&str; 8] = [
    "spacing",
    "persistence",
    "trace_length",
    "dip_deviation",
    "spacing_deviation",
    "trace_deviation",
    "origin",
    "seed",
];

/// The joints of a set in the mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Joints {
    /// Name of the set.
    pub name: String,
    /// Number of joints in the bodies.
    pub joints: usize,
    /// Number of edges of elements on them.
    pub edges: usize,
    /// Their length, m.
    pub length: f64,
}

impl fmt::Display for Joints {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, joints, edges, length } = self;
        let [joints, edges] = [*joints, *edges].map(|count| grouped(count as u64));
        write!(out, "{name}: {joints}, {} m long together, along {edges} edges", brief(*length))
    }
}

/// Checks the keys of all joint sets, and returns their laws.
pub(crate) fn check(
    file: &ModelFile,
    document: &Document<'_>,
    dimensions: u8,
    faults: &mut Vec<Fault>,
) -> Vec<JointSet> {
    for (index, set) in file.joint_set.iter().enumerate() {
        let check = Check { file, document, set, table: Table::of("joint_set", index) };
        if dimensions == 3 {
            let message = "joint sets are for models in two dimensions so far";
            faults.push(check.fault("name", message).label("not in three dimensions").help(
                "in three dimensions, give bodies or grains materials of their own, and the joints between them an [[interface]] with a strength",
            ));
            continue;
        }
        check.lines(faults);
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
}

impl Check<'_> {
    /// A fault at the value of a key.
    fn fault(&self, key: &str, message: &str) -> Fault {
        let message = format!("[[joint_set]] \"{}\": {message}", self.set.name);
        Fault::at(self.document.value(self.table, key), message)
    }

    /// Where the lines come from.
    fn lines(&self, faults: &mut Vec<Fault>) {
        let set = self.set;
        let sources =
            [("lines", set.lines.is_some()), ("file", set.file.is_some()), ("dip", set.dip.is_some())];
        let given: Vec<&str> = sources.iter().filter(|(_, given)| *given).map(|(key, _)| *key).collect();
        match given[..] {
            [_] => {}
            [] => {
                faults
                    .push(self.fault("name", "it has no joints").help("give it one of lines, file and dip"));
            }
            [first, second, ..] => faults.push(
                self.fault(second, &format!("its joints are given twice, by {first} and {second}"))
                    .help("write a second [[joint_set]]"),
            ),
        }
        if let Some(wrong) =
            set.lines.iter().flatten().position(|numbers| polylines::points(numbers).is_none())
        {
            let fault = self.fault("lines", &format!("line {} is not [x1, y1, x2, y2, …]", wrong + 1));
            let span = self.document.entry(self.table, "lines", wrong);
            faults.push(Fault { span: Some(span), ..fault }.label("this line"));
        }
        if set.dip.is_none() {
            for key in STATISTICAL.into_iter().filter(|key| self.document.has(self.table, key)) {
                faults.push(
                    self.fault(key, &format!("\"{key}\" is for statistical sets, which have a dip"))
                        .label("take it out"),
                );
            }
            return;
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
        for (place, name) in self.set.bodies.iter().flatten().enumerate() {
            let span = self.document.entry(self.table, "bodies", place);
            match self.file.body.iter().find(|body| body.name == *name) {
                None => faults.push(
                    Fault::at(span, format!("there is no body \"{name}\""))
                        .label("unknown body")
                        .help(placed::suggestion(self.file, name)),
                ),
                Some(body) if body.mesh.is_some() => faults.push(
                    Fault::at(
                        span,
                        format!(
                            "[[joint_set]] \"{}\": the body \"{name}\" has a mesh from a file, into which no joints can be put",
                            self.set.name
                        ),
                    )
                    .help("give the body a shape; or give its parts materials of their own by groups, and the joints between them an [[interface]] with a strength"),
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

/// Puts the joints of all bodies into the model. Returns how many each set has.
pub(crate) fn put<const D: usize, const N: usize>(
    model: &mut Model<D, N>,
    placed: &[Placed<D, N>],
    warnings: &mut Vec<String>,
) -> Vec<Joints>
where
    [[f64; D]; N]: Simplex<D, N> + Element<D, N>,
{
    let mut all = Vec::new();
    for number in 0..model.joint_sets.len() as u32 {
        let mut traces = BTreeSet::new();
        let (mut facets, mut length) = (Vec::new(), 0.0);
        for (body, Placed { piece, first, .. }) in placed.iter().enumerate() {
            for joint in piece.joints.iter().filter(|joint| joint.set == number) {
                traces.insert((body, joint.trace));
                facets.push(joint.facet.map(|node| node + first[0]));
                let corners = joint.facet.map(|node| piece.nodes[node as usize]);
                length += <[[f64; D]; N]>::facet_measure(&corners);
            }
        }
        let name = model.joint_sets[number as usize].name.clone();
        if facets.is_empty() {
            warnings.push(format!("[[joint_set]] \"{name}\" has no joint in any body"));
        } else {
            model.add_joints(number, &facets);
        }
        all.push(Joints { name, joints: traces.len(), edges: facets.len(), length });
    }
    all
}
