//! Histories of probes: stress, strain and velocity at points and in regions, strain gauges, forces between
//! bodies, reactions of groups, joint sets, rigid bodies.

use std::collections::BTreeSet;

use fdem_io::numbers::brief;
use fdem_mesh::{Corners, Mesh};
use fdem_simulation::{Element, MaterialPoint, Probe, TouchingSide};

use crate::shapes::placed::{self, Placed, is_body};
use crate::text::document::{Document, Table};
use crate::text::fault::{Fault, suggestion};
use crate::text::file::{History, Measured, ModelFile};

/// The quantities that a table has; one, if it is right.
pub(crate) fn quantities(history: &History) -> Vec<&'static str> {
    [
        ("node", history.node.is_some()),
        ("force", history.force.is_some()),
        ("stress", history.stress.is_some()),
        ("strain", history.strain.is_some()),
        ("velocity", history.velocity.is_some()),
        ("pore_pressure", history.pore_pressure.is_some()),
        ("gauge", history.gauge.is_some()),
        ("contact_force", history.contact_force.is_some()),
        ("reaction", history.reaction.is_some()),
        ("cavity", history.cavity.is_some()),
        ("joint_set", history.joint_set.is_some()),
        ("motion", history.motion.is_some()),
        ("wall", history.wall.is_some()),
        ("grains", history.grains),
        ("softening", history.softening),
        ("energy", history.energy),
        ("crack_length", history.crack_length),
    ]
    .into_iter()
    .filter(|(_, given)| *given)
    .map(|(key, _)| key)
    .collect()
}

/// Whether a history is that of a probe.
pub(crate) fn is_probe(history: &History) -> bool {
    let others = ["node", "force", "energy", "crack_length"];
    quantities(history).first().is_some_and(|key| !others.contains(key))
}

/// Whether the key `body` restricts a probe.
pub(crate) fn takes_body(history: &History) -> bool {
    let keys = ["stress", "strain", "velocity", "pore_pressure", "gauge", "reaction"];
    quantities(history).first().is_some_and(|key| keys.contains(key))
}

/// The key of a stress, strain or velocity, and where it is measured.
fn measured(history: &History) -> Option<(&'static str, &Measured)> {
    let all = [("stress", &history.stress), ("strain", &history.strain), ("velocity", &history.velocity)];
    all.into_iter().find_map(|(key, measured)| Some((key, measured.as_ref()?)))
}

/// Keys of a history with lists of coordinates: the number of their components, and the number that a model
/// in `d` dimensions has.
pub(crate) fn lengths(history: &History, d: usize) -> Vec<(&'static str, usize, usize)> {
    let mut lengths = Vec::new();
    if let Some((key, Measured::Point(point))) = measured(history) {
        lengths.push((key, point.0.len(), d));
    }
    lengths.extend(history.pore_pressure.as_ref().map(|point| ("pore_pressure", point.0.len(), d)));
    if let Some(wrong) = history.gauge.iter().flatten().find(|point| point.0.len() != d) {
        lengths.push(("gauge", wrong.0.len(), d));
    }
    lengths.extend(history.limits.as_ref().map(|limits| ("box", limits.len(), 2 * d)));
    lengths
}

/// Checks the history of a probe before anything is meshed.
pub(crate) fn check(file: &ModelFile, index: usize, document: &Document<'_>, faults: &mut Vec<Fault>) {
    let (history, table) = (&file.history[index], Table::of("history", index));
    if let Some(limits) = &history.limits {
        let (least, most) = limits.split_at(limits.len() / 2);
        if !history.grains && !matches!(measured(history), Some((_, Measured::Mean(_)))) {
            faults.push(
                Fault::at(
                    document.key(table, "box"),
                    "\"box\" goes with grains, and with the \"mean\" of stress, strain or velocity",
                )
                .label("take it out"),
            );
        } else if least.iter().zip(most).any(|(least, most)| most < least) {
            faults.push(
                Fault::at(
                    document.value(table, "box"),
                    format!("[[history]] \"{}\": its box is turned inside out", history.name),
                )
                .help("a box is [xmin, ymin, xmax, ymax], in three dimensions [xmin, ymin, zmin, xmax, ymax, zmax]"),
            );
        }
    }
    if let Some([one, other]) = history.gauge.as_deref()
        && one == other
    {
        faults.push(
            Fault::at(
                document.value(table, "gauge"),
                format!("[[history]] \"{}\": the two points of its gauge are the same", history.name),
            )
            .label("no length"),
        );
    }
    if let Some(name) = &history.wall
        && !file.wall.iter().any(|wall| wall.name == *name)
    {
        let names: Vec<&str> = file.wall.iter().map(|wall| wall.name.as_str()).collect();
        faults.push(
            Fault::at(document.value(table, "wall"), format!("there is no wall \"{name}\""))
                .label("unknown wall")
                .help(suggestion(name, &names, "[[wall]]")),
        );
    }
    if history.pore_pressure.is_some() && file.pores.is_none() {
        faults.push(
            Fault::at(
                document.key(table, "pore_pressure"),
                format!("[[history]] \"{}\": there is no liquid in pores", history.name),
            )
            .label("no [pores]")
            .help("add a table [pores], or take it out"),
        );
    }
    if history.grains && !file.has_spheres() {
        faults.push(
            Fault::at(
                document.key(table, "grains"),
                format!("[[history]] \"{}\": there are no spheres", history.name),
            )
            .label("no [[grains]] or [[insertion]]"),
        );
    }
    for (place, name) in history.contact_force.iter().flatten().enumerate() {
        if !is_body(file, name) && !are_spheres(file, name) {
            faults.push(
                Fault::at(
                    document.entry(table, "contact_force", place),
                    format!("there is no body \"{name}\", and no spheres have this name"),
                )
                .label("unknown name")
                .help(of_all(file, name)),
            );
        }
    }
}

/// The probes of the histories, in their order. `file` has been checked.
pub(crate) fn probes<const D: usize, const N: usize>(
    file: &ModelFile,
    document: &Document<'_>,
    mesh: &Mesh<D, N>,
    placed: &[Placed<D, N>],
    faults: &mut Vec<Fault>,
) -> Vec<Probe<D, N>>
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    let mut probes = Vec::new();
    for (index, history) in file.history.iter().enumerate().filter(|(_, history)| is_probe(history)) {
        let bodies = match &history.body {
            Some(name) => placed::named(placed, file, name),
            None => (0..placed.len()).collect(),
        };
        let table = Table::of("history", index);
        let places = Places { file, mesh, placed, history, bodies };
        match places.probe() {
            Ok(probe) => probes.push(probe),
            Err((key, message, help)) => faults.push(
                Fault::at(document.value(table, key), format!("[[history]] \"{}\": {message}", history.name))
                    .maybe_help(help),
            ),
        }
    }
    probes
}

/// Whether a name is that of a group of spheres.
fn are_spheres(file: &ModelFile, name: &str) -> bool {
    file.groups_of_spheres().any(|group| group == name)
}

/// Advice on a name that is neither that of a body nor that of spheres.
fn of_all(file: &ModelFile, name: &str) -> String {
    if file.wall.iter().any(|wall| wall.name == name) {
        return format!("the force of all spheres on that wall is the history wall = \"{name}\"");
    }
    let bodies = file.body.iter().map(|body| body.name.as_str());
    let names: Vec<&str> = bodies.chain(file.groups_of_spheres()).collect();
    suggestion(name, &names, "[[body]], [[grains]] or [[insertion]]")
}

/// The error of a history: the key, a message, and advice.
type ProbeFault = (&'static str, String, Option<String>);

/// A history, and the bodies on which it is measured.
struct Places<'a, const D: usize, const N: usize> {
    file: &'a ModelFile,
    mesh: &'a Mesh<D, N>,
    placed: &'a [Placed<D, N>],
    history: &'a History,
    bodies: Vec<usize>,
}

impl<const D: usize, const N: usize> Places<'_, D, N>
where
    [[f64; D]; N]: Element<D, N> + Corners<D, N>,
{
    fn probe(&self) -> Result<Probe<D, N>, ProbeFault> {
        let history = self.history;
        if let Some(probe) = self.of_spheres() {
            return Ok(probe);
        }
        if let Some([by, on]) = history.contact_force.as_deref() {
            return self.contact_force([by, on]);
        }
        if self.bodies.is_empty() {
            let name = history.body.as_deref().unwrap_or("");
            let help = placed::suggestion(self.file, name);
            return Err(("body", format!("there is no body \"{name}\""), Some(help)));
        }
        if let Some((key, measured)) = measured(history) {
            return Ok(match (key, measured) {
                ("stress", Measured::Point(point)) => {
                    Probe::Stress(vec![self.point(key, point.components())?.element])
                }
                ("strain", Measured::Point(point)) => {
                    Probe::Strain(vec![self.point(key, point.components())?.element])
                }
                (_, Measured::Point(point)) => Probe::PointVelocity(self.point(key, point.components())?),
                ("stress", Measured::Mean(_)) => Probe::Stress(self.elements()?),
                ("strain", Measured::Mean(_)) => Probe::Strain(self.elements()?),
                (_, Measured::Mean(_)) => Probe::Velocity(self.elements()?),
            });
        }
        if let Some(point) = &history.pore_pressure {
            return Ok(Probe::PorePressure(self.point_in_pores(point.components())?));
        }
        if let Some([one, other]) = history.gauge.as_deref() {
            let ends: [[f64; D]; 2] = [one.components(), other.components()];
            let span = (0..D).map(|axis| ends[1][axis] - ends[0][axis]).collect();
            return Ok(Probe::Gauge {
                ends: [self.point("gauge", ends[0])?, self.point("gauge", ends[1])?],
                span,
            });
        }
        if let Some(name) = &history.cavity {
            return self.cavity(name);
        }
        if let Some(name) = &history.joint_set {
            return self.joint_set(name);
        }
        if let Some(name) = &history.motion {
            return self.motion(name);
        }
        if history.softening {
            return Ok(Probe::Softening);
        }
        self.reaction(history.reaction.as_deref().unwrap_or(""))
    }

    /// The probe of a wall or of spheres.
    fn of_spheres(&self) -> Option<Probe<D, N>> {
        let history = self.history;
        if let Some(name) = &history.wall {
            // A name that is unknown is a fault that has been found before.
            let wall = self.file.wall.iter().position(|wall| wall.name == *name)?;
            return Some(Probe::Wall { wall: wall as u32 });
        }
        let corner = |limits: &[f64]| [0, 1, 2].map(|axis| limits.get(axis).copied().unwrap_or(0.0));
        let region = history.limits.as_ref().map(|limits| {
            let (low, high) = limits.split_at(limits.len() / 2);
            [corner(low), corner(high)]
        });
        history.grains.then_some(Probe::Spheres { region })
    }

    /// The point of the bodies at some coordinates, m.
    fn point(&self, key: &'static str, point: [f64; D]) -> Result<MaterialPoint<D, N>, ProbeFault> {
        let bodies = &self.mesh.bodies;
        let among = |element: u32| self.bodies.binary_search(&(bodies[element as usize] as usize)).is_ok();
        MaterialPoint::at(self.mesh, point, among).ok_or_else(|| {
            let gap = |body: usize| {
                let nodes = self.placed[body].piece.nodes.iter();
                nodes.map(|&node| distance(node, point)).fold(f64::INFINITY, f64::min)
            };
            let nearest =
                self.bodies.iter().map(|&body| (gap(body), body)).min_by(|a, b| a.0.total_cmp(&b.0));
            let nearest = nearest.map(|(gap, body)| {
                let name = &self.placed[body].name;
                format!("the nearest body is \"{name}\", with a node at a distance of {} m", brief(gap))
            });
            let place = if self.history.body.is_some() { "the body" } else { "all bodies" };
            (key, format!("the point {point:?} is outside of {place}"), nearest)
        })
    }

    /// The point of the elements with pores at some coordinates, m.
    fn point_in_pores(&self, point: [f64; D]) -> Result<MaterialPoint<D, N>, ProbeFault> {
        let (key, mesh) = ("pore_pressure", self.mesh);
        let has_pores =
            |element: u32| self.file.material[mesh.materials[element as usize] as usize].pores.is_some();
        let found = self.point(key, point)?;
        if has_pores(found.element) {
            return Ok(found);
        }
        // On the facet or the corner of two elements it belongs to the one with pores.
        let among = |element: u32| {
            self.bodies.binary_search(&(mesh.bodies[element as usize] as usize)).is_ok() && has_pores(element)
        };
        let on_facet = MaterialPoint::at(mesh, point, among);
        on_facet.filter(|found| found.weights.iter().all(|weight| *weight > -1e-9)).ok_or_else(|| {
            let help = "take a point in a body whose [[material]] has \"pores\"".to_owned();
            (key, format!("there are no pores at the point {point:?}"), Some(help))
        })
    }

    /// Elements of the bodies whose centroids are in the box.
    fn elements(&self) -> Result<Vec<u32>, ProbeFault> {
        let limits = self.history.limits.as_ref();
        let inside = |element: u32| {
            let centroid = self.mesh.centroid(element as usize);
            limits.is_none_or(|limits| {
                (0..D).all(|axis| limits[axis] <= centroid[axis] && centroid[axis] <= limits[D + axis])
            })
        };
        let of_body = |&body: &usize| {
            let Placed { piece, first, .. } = &self.placed[body];
            first[1]..first[1] + piece.elements.len() as u32
        };
        let elements: Vec<u32> =
            self.bodies.iter().flat_map(of_body).filter(|&element| inside(element)).collect();
        if elements.is_empty() {
            let help = "make the box larger, or the elements smaller".to_owned();
            return Err(("box", "no element has its centroid in the box".to_owned(), Some(help)));
        }
        Ok(elements)
    }

    /// The force between two bodies, groups of spheres, or a body and spheres.
    fn contact_force(&self, names: [&String; 2]) -> Result<Probe<D, N>, ProbeFault> {
        let sides = names.map(|name| {
            let bodies = placed::named(self.placed, self.file, name);
            if bodies.is_empty() && are_spheres(self.file, name) {
                return TouchingSide::Spheres(name.clone());
            }
            TouchingSide::Bodies(bodies.into_iter().map(|body| body as u32).collect())
        });
        for (side, name) in sides.iter().zip(names) {
            if *side == TouchingSide::Bodies(Vec::new()) {
                let help = of_all(self.file, name);
                return Err(("contact_force", format!("there is no body \"{name}\""), Some(help)));
            }
        }
        let twice = |name: &str| {
            let help = "take two that are not the same".to_owned();
            Err(("contact_force", format!("\"{name}\" is on both sides"), Some(help)))
        };
        match sides {
            [TouchingSide::Bodies(by), TouchingSide::Bodies(on)] => {
                match by.iter().find(|body| on.binary_search(body).is_ok()) {
                    Some(&both) => twice(&self.placed[both as usize].name),
                    None => Ok(Probe::ContactForce([by, on])),
                }
            }
            sides if sides[0] == sides[1] => twice(names[0]),
            sides => Ok(Probe::ForceOfSpheres(sides)),
        }
    }

    /// The cavity of a boundary.
    fn cavity(&self, name: &str) -> Result<Probe<D, N>, ProbeFault> {
        let cavities = self.file.boundary.iter().filter(|boundary| boundary.cavity);
        let all: Vec<&str> = cavities.map(|boundary| boundary.name.as_str()).collect();
        if all.contains(&name) {
            return Ok(Probe::Cavity(name.to_owned()));
        }
        let help = suggestion(name, &all, "boundary with cavity = true");
        Err(("cavity", format!("there is no cavity \"{name}\""), Some(help)))
    }

    /// The joints of a set.
    fn joint_set(&self, name: &str) -> Result<Probe<D, N>, ProbeFault> {
        let all: Vec<&str> = self.file.joint_set.iter().map(|set| set.name.as_str()).collect();
        if all.contains(&name) {
            return Ok(Probe::JointSet(name.to_owned()));
        }
        let help = suggestion(name, &all, "[[joint_set]]");
        Err(("joint_set", format!("there is no joint set \"{name}\""), Some(help)))
    }

    /// The motion of a rigid body.
    fn motion(&self, name: &str) -> Result<Probe<D, N>, ProbeFault> {
        let rigid = |body: &&Placed<D, N>| self.file.body[body.table].rigid.always();
        match *placed::named(self.placed, self.file, name) {
            [] => {
                let rigid: Vec<&str> =
                    self.placed.iter().filter(rigid).map(|body| body.name.as_str()).collect();
                let help = suggestion(name, &rigid, "rigid body");
                Err(("motion", format!("there is no body \"{name}\""), Some(help)))
            }
            [body] if rigid(&&self.placed[body]) => Ok(Probe::RigidBody(body as u32)),
            [_] => {
                let help = "measure velocity = \"mean\" of it, or make it rigid with rigid = true";
                Err((
                    "motion",
                    format!("the body \"{name}\" is not rigid for the whole run"),
                    Some(help.to_owned()),
                ))
            }
            [first, ..] => {
                let help = format!("name one of them, such as \"{}\"", self.placed[first].name);
                Err(("motion", format!("\"{name}\" is several bodies"), Some(help)))
            }
        }
    }

    /// The reaction of a group of nodes.
    fn reaction(&self, name: &str) -> Result<Probe<D, N>, ProbeFault> {
        let mut nodes = Vec::new();
        for &body in &self.bodies {
            let Placed { piece, first, .. } = &self.placed[body];
            let group = piece.groups.get(name).map(|group| piece.nodes_of(group)).unwrap_or_default();
            nodes.extend(group.into_iter().map(|node| node + first[0]));
        }
        if nodes.is_empty() {
            let all: BTreeSet<&str> = self
                .bodies
                .iter()
                .flat_map(|&body| self.placed[body].piece.groups.keys())
                .map(String::as_str)
                .collect();
            let all: Vec<&str> = all.into_iter().collect();
            let help = suggestion(name, &all, "group");
            return Err(("reaction", format!("no body here has a group \"{name}\""), Some(help)));
        }
        nodes.sort_unstable();
        nodes.dedup();
        Ok(Probe::Reaction(nodes))
    }
}

fn distance<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}
