//! Probes: means of stress, strain and velocity, strain gauges, forces between bodies, reactions, joint sets,
//! rigid bodies, fluid, liquid in pores, spheres and walls.
//!
//! A probe is a short list of exact sums over the counted elements of a rank, and a rule that turns them into
//! values. Ranks add their sums up before the rule, so that neither ranks nor threads change a bit.

mod fluid;
pub(crate) mod joints;
mod pores;
mod spheres;
pub(crate) mod touching;

use fdem_distributed::wire;
use fdem_distributed::wire::Wire;
use fdem_mesh::Mesh;

use crate::actions::cavity::CavityState;
use crate::machine::{Columns, Wanted};
use crate::probe::touching::TouchingSide;
use crate::rigid::RigidMotion;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::solid::{Solid, corners_of};
use crate::sum::Sum;
use crate::topology::NONE;
use crate::vector::{Point, dot, length, plus, product, product_transposed, transposed};

/// A point may lie outside of its element by this share of the element's height: bodies with curved outlines
/// have straight edges.
const OUTSIDE: f64 = 0.25;

/// Components of a stress in the plane, which has one across it, and in space.
const STRESS: [&[&str]; 2] = [&["sxx", "syy", "szz", "sxy"], &["sxx", "syy", "szz", "sxy", "syz", "sxz"]];

/// Measures of softening joints in the plane and in space.
const SOFTENING: [[(&str, &str); 2]; 2] = [
    [("softening_length", "m"), ("damaged_length", "m")],
    [("softening_area", "m²"), ("damaged_area", "m²")],
];

/// Motion of a rigid body in the plane and in space.
const RIGID: [&[(&str, &str)]; 2] = [
    &[("ux", "m"), ("uy", "m"), ("vx", "m/s"), ("vy", "m/s"), ("rz", "rad"), ("wz", "rad/s")],
    &[
        ("ux", "m"),
        ("uy", "m"),
        ("uz", "m"),
        ("vx", "m/s"),
        ("vy", "m/s"),
        ("vz", "m/s"),
        ("rx", "rad"),
        ("ry", "rad"),
        ("rz", "rad"),
        ("wx", "rad/s"),
        ("wy", "rad/s"),
        ("wz", "rad/s"),
    ],
];

/// Components of a strain in the plane and in space.
const STRAIN: [&[&str]; 2] = [&["exx", "eyy", "exy"], &["exx", "eyy", "ezz", "exy", "eyz", "exz"]];

/// A point that moves with its body: an element, and the barycentric coordinates of the point in the
/// undeformed element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPoint<const D: usize = 2, const N: usize = 3> {
    /// Number of the element.
    pub element: u32,
    /// Share of each of its corners in the motion of the point; the sum is 1.
    pub weights: [f64; N],
}

wire!([const D: usize, const N: usize] MaterialPoint<D, N> { element, weights });

impl<const D: usize, const N: usize> MaterialPoint<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Finds the point of the undeformed mesh at some coordinates, m, among the elements for which `among` is
    /// true. `None` if the point is outside of all of them by more than a quarter of an element. On a common
    /// corner or facet it belongs to the element with the lowest number.
    pub fn at(mesh: &Mesh<D, N>, point: [f64; D], among: impl Fn(u32) -> bool) -> Option<Self> {
        let mut found: Option<(f64, Self)> = None;
        for element in (0..mesh.elements.len() as u32).filter(|&element| among(element)) {
            let weights = corners_of(mesh, element as usize).coordinates(point);
            // Rounding must not decide between two elements that share the point.
            let inside = weights.iter().copied().fold(f64::INFINITY, f64::min).min(0.0);
            if found.is_none_or(|(most, _)| inside > most + 1e-9) {
                found = Some((inside, Self { element, weights }));
            }
        }
        found.filter(|(inside, _)| *inside >= -OUTSIDE).map(|(_, point)| point)
    }
}

/// A quantity of a run at one instant: see [`Simulation::measure`].
///
/// Elements, bodies and nodes have their numbers in the mesh. Lists ascend.
#[derive(Clone, Debug, PartialEq)]
pub enum Probe<const D: usize = 2, const N: usize = 3> {
    /// Mean Cauchy stress of these elements, weighted by their undeformed volumes, Pa, tension positive, as
    /// it acts at the beginning of the last step: `[xx, yy, zz, xy]` in two dimensions,
    /// `[xx, yy, zz, xy, yz, xz]` in three.
    Stress(Vec<u32>),
    /// Mean Green-Lagrange strain `(FᵀF - 1)/2` of these elements, with the same weights: `[xx, yy, xy]` in
    /// two dimensions, `[xx, yy, zz, xy, yz, xz]` in three. A shear strain is half of the change of an angle.
    Strain(Vec<u32>),
    /// Mean velocity of these elements, weighted by mass, m/s.
    Velocity(Vec<u32>),
    /// Velocity of a point, linear within its element, m/s.
    PointVelocity(MaterialPoint<D, N>),
    /// Strain gauge: change of the distance of two points over their distance in the undeformed mesh,
    /// `(l - l₀)/l₀`.
    Gauge {
        /// The two points.
        ends: [MaterialPoint<D, N>; 2],
        /// From the first to the second in the undeformed mesh, m.
        span: Vec<f64>,
    },
    /// Force that the bodies of the first list exert by contact on those of the second, N, at the beginning
    /// of the last step. Joints that hold are not contacts.
    ContactForce([Vec<u32>; 2]),
    /// The same where one of the two, or both, are spheres.
    ForceOfSpheres([TouchingSide; 2]),
    /// Force of all boundaries on these nodes of the mesh, N, at the beginning of the last step.
    Reaction(Vec<u32>),
    /// Motion of the rigid body with this number: displacement of its centre of mass, m, and its velocity,
    /// m/s; its rotation, rad, and its angular velocity, rad/s. Displacement and rotation are those since the
    /// undeformed mesh. In space the rotation is a vector along its axis, as long as its angle; whole turns
    /// add up. The values are not numbers if there is no such body, or if it is not rigid.
    RigidBody(u32),
    /// Pressure at the beginning of the last step, Pa, volume, m³, area of the faces, m², work of the
    /// pressure and energy of a gas, J, of the cavity of the boundary with this name.
    Cavity(String),
    /// The fluid as a whole: volumes at the reference density, m³, that were there at the beginning, have
    /// been injected, have leaked off, were drained with joints that are no more, are stored, and could not
    /// be taken out; the length, m, or area, m², of the joints times their saturations; the error of the
    /// balance of the mass, kg. The values are those at the last step of the fluid, and not numbers without a
    /// fluid.
    Fluid,
    /// Pressure, Pa, rate, m³/s, and injected volume, m³, of the source of the fluid with this name. The
    /// values are not numbers if there is no such source.
    Injection(String),
    /// Pressure of the liquid in pores at a point, linear within its element, Pa. The value is not a number
    /// if the element has no pores.
    PorePressure(MaterialPoint<D, N>),
    /// The liquid in pores as a whole: volumes at the reference density, m³, that were there at the
    /// beginning, have come in through all surfaces, have come out of cracks, and are stored; and the error
    /// of their balance. Zero is the content of the undeformed body without pressure. The values are those at
    /// the last step of the flow, and not numbers without pores.
    Pores,
    /// Volume that has come in through the surface of pores with this name, m³. The value is not a number if
    /// there is no such surface.
    PoreSurface(String),
    /// Mean opening and slip now, m, and mean normal and shear stress at the beginning of the last step, Pa,
    /// tension positive, of the joints of the set with this name, weighted by their undeformed length or
    /// area.
    ///
    /// The corners of the two sides of a joint give its opening and slip. Its stresses are the mean of its
    /// two elements, on the plane half way between the sides. This holds in every state of the joint, also
    /// after it has handed over to contact. In two dimensions slip and shear stress are positive if each side
    /// moves to the left, as seen from the other; in three they are magnitudes. The values are not numbers if
    /// the set has no joints.
    JointSet(String),
    /// Length, m, in two dimensions, or area, m², in three, of all joints past their strength, whether they
    /// soften or are broken, and the same with the damage of each joint as a factor. Joints that are open
    /// from the beginning are left out.
    Softening,
    /// Force of the spheres on a wall, N, and its moment, N m, at the beginning of the last step, and the
    /// displacement of the wall now, m, without that of its rotation. The moment is about the point through
    /// which the axis of its rotation passes, or about the origin if it does not turn. The values are not
    /// numbers if there is no such wall.
    Wall {
        /// Number of the wall.
        wall: u32,
    },
    /// Number, coordination, solid fraction, kinetic energy, J, mean stress, Pa, tension positive,
    /// `[xx, yy, zz, xy, yz, xz]`, and fabric of the spheres whose centres are in a region, and the lengths
    /// of its sides, m: the third is the thickness of discs.
    ///
    /// Contacts are those at the beginning of the last step. The coordination is their mean number for each
    /// of these spheres, with walls and bodies. The stress is `Σ r f / V` over the contacts of these spheres
    /// (Love and Weber), with the arm `r` from the centre, the force `f` and the volume `V` of the region.
    /// The fabric is the mean of `n n` over the same contacts, with the normal `n`. The kinetic energy is
    /// that of the velocities half a step before the positions, with rotations.
    Spheres {
        /// A box, by its lowest and its highest corner, m; in the plane without its third axis. `None` for
        /// the box around all spheres; along axes that repeat it is one period.
        region: Option<[[f64; 3]; 2]>,
    },
}

impl<const D: usize, const N: usize> Probe<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Names and units of the values: `("sxx", "Pa")`.
    pub fn columns(&self) -> Vec<(&'static str, &'static str)> {
        let of = |names: &[&'static str], unit| names.iter().map(|&name| (name, unit)).collect();
        match self {
            Self::Stress(_) => of(STRESS[D - 2], "Pa"),
            Self::Strain(_) => of(STRAIN[D - 2], "m/m"),
            Self::Velocity(_) | Self::PointVelocity(_) => of(&["vx", "vy", "vz"][..D], "m/s"),
            Self::Gauge { .. } => of(&["strain"], "m/m"),
            Self::ContactForce(_) | Self::ForceOfSpheres(_) | Self::Reaction(_) => {
                of(&["fx", "fy", "fz"][..D], "N")
            }
            Self::RigidBody(_) => RIGID[D - 2].to_vec(),
            Self::Cavity(_) => {
                vec![("pressure", "Pa"), ("volume", "m³"), ("area", "m²"), ("work", "J"), ("energy", "J")]
            }
            Self::Fluid => fluid::COLUMNS[D - 2].to_vec(),
            Self::Injection(_) => fluid::OF_SOURCE.to_vec(),
            Self::PorePressure(_) => pores::AT_POINT.to_vec(),
            Self::Pores => pores::COLUMNS.to_vec(),
            Self::PoreSurface(_) => pores::OF_SURFACE.to_vec(),
            Self::JointSet(_) => joints::COLUMNS.to_vec(),
            Self::Softening => SOFTENING[D - 2].to_vec(),
            Self::Wall { .. } => spheres::WALL.to_vec(),
            Self::Spheres { .. } => spheres::SPHERES.to_vec(),
        }
    }

    /// The probe in another mesh: `element` and `node` give the numbers there; missing elements and nodes are
    /// left out. A probe at a point that is not there has no values: they are not numbers.
    #[must_use]
    pub fn renumbered(
        &self,
        element: impl Fn(u32) -> Option<u32>,
        node: impl Fn(u32) -> Option<u32>,
    ) -> Self {
        let point = |point: &MaterialPoint<D, N>| MaterialPoint {
            element: element(point.element).unwrap_or(NONE),
            weights: point.weights,
        };
        let elements = |all: &[u32]| all.iter().filter_map(|&number| element(number)).collect();
        match self {
            Self::Stress(all) => Self::Stress(elements(all)),
            Self::Strain(all) => Self::Strain(elements(all)),
            Self::Velocity(all) => Self::Velocity(elements(all)),
            Self::PointVelocity(at) => Self::PointVelocity(point(at)),
            Self::Gauge { ends, span } => {
                Self::Gauge { ends: ends.each_ref().map(point), span: span.clone() }
            }
            Self::ContactForce(bodies) => Self::ContactForce(bodies.clone()),
            Self::RigidBody(body) => Self::RigidBody(*body),
            Self::Cavity(name) => Self::Cavity(name.clone()),
            Self::Fluid => Self::Fluid,
            Self::Injection(name) => Self::Injection(name.clone()),
            Self::PorePressure(at) => Self::PorePressure(point(at)),
            Self::Pores => Self::Pores,
            Self::PoreSurface(name) => Self::PoreSurface(name.clone()),
            Self::JointSet(name) => Self::JointSet(name.clone()),
            Self::Softening => Self::Softening,
            Self::ForceOfSpheres(_) | Self::Wall { .. } | Self::Spheres { .. } => self.clone(),
            Self::Reaction(nodes) => {
                Self::Reaction(nodes.iter().filter_map(|&number| node(number)).collect())
            }
        }
    }

    /// Whether it is at a point that is not in the mesh.
    fn is_gone(&self) -> bool {
        match self {
            Self::PointVelocity(point) | Self::PorePressure(point) => point.element == NONE,
            Self::Gauge { ends, .. } => ends.iter().any(|point| point.element == NONE),
            _ => false,
        }
    }

    /// Whether values, all or some, are those at the beginning of the last step, and are known only after the
    /// first one.
    pub fn follows_a_step(&self) -> bool {
        match self {
            Self::Stress(_)
            | Self::ContactForce(_)
            | Self::ForceOfSpheres(_)
            | Self::Reaction(_)
            | Self::Cavity(_)
            | Self::JointSet(_)
            | Self::Wall { .. }
            | Self::Spheres { .. } => true,
            Self::Strain(_)
            | Self::Velocity(_)
            | Self::PointVelocity(_)
            | Self::Gauge { .. }
            | Self::RigidBody(_)
            | Self::Fluid
            | Self::Injection(_)
            | Self::PorePressure(_)
            | Self::Pores
            | Self::PoreSurface(_)
            | Self::Softening => false,
        }
    }

    /// Number of sums.
    fn sums(&self) -> usize {
        match self {
            // The last is that of the weights.
            Self::Stress(_) | Self::Strain(_) => 7,
            Self::Velocity(_) => D + 1,
            Self::Gauge { .. } => 2 * D,
            Self::PointVelocity(_) | Self::ContactForce(_) | Self::ForceOfSpheres(_) | Self::Reaction(_) => D,
            // The last counts the bodies of this number: 0 in a stage that has none.
            Self::RigidBody(_) => RIGID[D - 2].len() + 1,
            // The last counts the cavities of this name: 0 in a stage that has none.
            Self::Cavity(_) => 6,
            // The last counts the fluids, and the sources of this name.
            Self::Fluid => fluid::COLUMNS[D - 2].len() + 1,
            Self::Injection(_) => fluid::OF_SOURCE.len() + 1,
            // The last counts the points in pores, the pores, and the surfaces of this name.
            Self::PorePressure(_) => pores::AT_POINT.len() + 1,
            Self::Pores => pores::COLUMNS.len() + 1,
            Self::PoreSurface(_) => pores::OF_SURFACE.len() + 1,
            // The last is that of the lengths or areas.
            Self::JointSet(_) => 5,
            Self::Softening => 2,
            // The last counts the walls of this number.
            Self::Wall { .. } => spheres::WALL.len() + 1,
            Self::Spheres { .. } => spheres::SUMS,
        }
    }

    /// The values, from the sums over the whole run.
    pub(crate) fn values(&self, sums: &[Sum]) -> Vec<f64> {
        if self.is_gone() {
            return vec![f64::NAN; self.columns().len()];
        }
        let sums: Vec<f64> = sums.iter().map(Sum::value).collect();
        let mean = |place: usize| sums[place] / sums[sums.len() - 1];
        let tensor = |zz: bool| {
            (0..6).filter(move |&k| spheres::PLACES[k].iter().all(|&axis| axis < D) || zz && k == 2)
        };
        match self {
            Self::Stress(_) => tensor(true).map(mean).collect(),
            Self::Strain(_) => tensor(false).map(mean).collect(),
            Self::Velocity(_) => (0..D).map(mean).collect(),
            Self::Gauge { span, .. } => {
                let span: Point<D> = std::array::from_fn(|axis| span[axis]);
                let moved = std::array::from_fn(|axis| sums[D + axis] - sums[axis]);
                let [before, now] = [length(span), length(plus(span, moved))];
                // l² - l₀² without the loss of digits in a difference.
                vec![dot(plus(span, plus(span, moved)), moved) / (before * (before + now))]
            }
            Self::PointVelocity(_)
            | Self::ContactForce(_)
            | Self::ForceOfSpheres(_)
            | Self::Reaction(_)
            | Self::Softening => sums,
            Self::RigidBody(_) => (0..RIGID[D - 2].len()).map(mean).collect(),
            Self::Cavity(_) => (0..5).map(mean).collect(),
            Self::Fluid => (0..fluid::COLUMNS[D - 2].len()).map(mean).collect(),
            Self::Injection(_) => (0..fluid::OF_SOURCE.len()).map(mean).collect(),
            Self::PorePressure(_) => (0..pores::AT_POINT.len()).map(mean).collect(),
            Self::Pores => (0..pores::COLUMNS.len()).map(mean).collect(),
            Self::PoreSurface(_) => (0..pores::OF_SURFACE.len()).map(mean).collect(),
            Self::JointSet(_) => (0..4).map(mean).collect(),
            Self::Wall { .. } => (0..spheres::WALL.len()).map(mean).collect(),
            Self::Spheres { .. } => spheres::means(&sums),
        }
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Measures quantities of the run now: the values of each probe, whose names and units are
    /// [`Probe::columns`]. Numbers of elements, bodies and nodes that are not in the mesh count for nothing.
    ///
    /// # Cost
    /// Proportional to the number of elements, and for contact forces to that of the contacts. Of a run on a
    /// device, values of these elements and their nodes are read; all for contact forces and joints.
    pub fn measure(&self, probes: &[Probe<D, N>]) -> Vec<Vec<f64>> {
        probes.iter().map(|probe| probe.values(&self.sums(probe))).collect()
    }

    /// The sums of a probe over the elements that this rank counts.
    pub(crate) fn sums(&self, probe: &Probe<D, N>) -> Vec<Sum> {
        let Some(wanted) = self.wanted_by(probe) else {
            return self.sums_in(probe, self.machine.columns());
        };
        self.looked_at(&wanted, |columns| self.sums_in(probe, columns))
    }

    /// The values of nodes and elements that a probe reads; `None` if it reads any others.
    fn wanted_by(&self, probe: &Probe<D, N>) -> Option<Wanted> {
        let here = |numbers: &[u32]| -> Vec<u32> {
            numbers.iter().filter_map(|&number| self.topology.element(number)).collect()
        };
        let of_points = |points: &[MaterialPoint<D, N>]| {
            here(&points.iter().map(|point| point.element).collect::<Vec<_>>())
        };
        let none = Wanted::default;
        let nodes_of = |elements: Vec<u32>| {
            self.looked_at(&none(), |Columns { solid, .. }| solid.nodes_of_all(&elements))
        };
        Some(match probe {
            Probe::Stress(elements) => Wanted { elements: here(elements), ..none() },
            Probe::Strain(elements) => Wanted { positions: nodes_of(here(elements)), ..none() },
            Probe::Velocity(elements) => Wanted { nodes: nodes_of(here(elements)), ..none() },
            Probe::PointVelocity(point) => Wanted { nodes: nodes_of(of_points(&[*point])), ..none() },
            Probe::Gauge { ends, .. } => Wanted { positions: nodes_of(of_points(ends)), ..none() },
            Probe::ContactForce(_) | Probe::Softening | Probe::JointSet(_) => return None,
            Probe::ForceOfSpheres(_)
            | Probe::Reaction(_)
            | Probe::RigidBody(_)
            | Probe::Cavity(_)
            | Probe::Fluid
            | Probe::Injection(_)
            | Probe::PorePressure(_)
            | Probe::Pores
            | Probe::PoreSurface(_)
            | Probe::Wall { .. }
            | Probe::Spheres { .. } => none(),
        })
    }

    /// [`Simulation::sums`] with these columns. Probes that [`Simulation::wanted_by`] knows read no others.
    fn sums_in(&self, probe: &Probe<D, N>, Columns { solid, .. }: &Columns<D, N>) -> Vec<Sum> {
        let mut sums = vec![Sum::default(); probe.sums()];
        let mut add = |terms: &[f64], weight: f64| {
            for (sum, term) in sums.iter_mut().zip(terms) {
                sum.add(weight * term);
            }
        };
        match probe {
            Probe::Stress(elements) => self.weighed(solid, elements, |element, weight| {
                let [a, b, c, d, e, f] = solid.stress_tensor(element);
                add(&[a, b, c, d, e, f, 1.0], weight);
            }),
            Probe::Strain(elements) => self.weighed(solid, elements, |element, weight| {
                let [a, b, c, d, e, f] = self.strain(solid, element);
                add(&[a, b, c, d, e, f, 1.0], weight);
            }),
            Probe::Velocity(elements) => self.weighed(solid, elements, |element, weight| {
                let density = self.model.materials[solid.element(element).material as usize].density;
                for node in solid.nodes_of(element as u32) {
                    let velocity = solid.velocity(node as usize);
                    add(&velocity, weight * density);
                }
                // The weight is the same at all corners, and a mean does not depend on their number once it
                // is counted.
                let mut last = [0.0; 4];
                last[D] = N as f64;
                add(&last[..=D], weight * density);
            }),
            Probe::PointVelocity(point) => {
                if let Some(velocity) = self.at(solid, point, |node| solid.velocity(node)) {
                    add(&velocity, 1.0);
                }
            }
            Probe::Gauge { ends, .. } => {
                for (end, point) in ends.iter().enumerate() {
                    let moved = self.at(solid, point, |node| solid.displacement(node, &self.model));
                    if let Some(moved) = moved {
                        let mut terms = vec![0.0; 2 * D];
                        terms[end * D..(end + 1) * D].copy_from_slice(&moved);
                        add(&terms, 1.0);
                    }
                }
            }
            Probe::ContactForce([by, on]) => {
                self.each_contact(|[first, second], force| {
                    let has = |list: &[u32], element: u32| {
                        list.binary_search(&self.model.mesh.bodies[element as usize]).is_ok()
                    };
                    // The force is that on the first element.
                    if has(by, second) && has(on, first) {
                        add(&force, 1.0);
                    } else if has(by, first) && has(on, second) {
                        add(&force, -1.0);
                    }
                });
            }
            Probe::ForceOfSpheres(sides) => {
                self.visit_forces_of_spheres(sides, |force, sign| add(&force[..D], sign));
            }
            Probe::RigidBody(body) => {
                if let Some(motion) = self.motion_of(solid, *body) {
                    add(&motion, 1.0);
                }
            }
            Probe::Cavity(name) => {
                let number = self.model.boundaries.iter().position(|boundary| boundary.name == *name);
                let state = number.and_then(|number| self.cavity(number));
                if let Some(state) = state.filter(|_| self.scene().counts_common()) {
                    let CavityState { pressure, volume, area, work, stored } = state;
                    add(&[pressure, volume, area, work, stored, 1.0], 1.0);
                }
            }
            Probe::Fluid => self.visit_fluid(|terms| add(terms, 1.0)),
            Probe::Injection(name) => self.visit_injection(name, |terms| add(terms, 1.0)),
            Probe::PorePressure(MaterialPoint { element, weights }) => {
                self.visit_pore_pressure(*element, *weights, |terms| add(terms, 1.0));
            }
            Probe::Pores => self.visit_pores(|terms| add(terms, 1.0)),
            Probe::PoreSurface(name) => self.visit_pore_surface(name, |terms| add(terms, 1.0)),
            Probe::Softening => self.damaged_lengths(|lengths| add(&lengths, 1.0)),
            Probe::JointSet(name) => self.each_joint_of(name, |terms| add(&terms, 1.0)),
            Probe::Wall { wall } => self.visit_wall(*wall, |terms| add(terms, 1.0)),
            Probe::Spheres { region } => self.visit_spheres(*region, |terms| add(terms, 1.0)),
            Probe::Reaction(nodes) => {
                let applied = self.actions.applied(solid);
                let applied = applied.map(|([_, corner], force)| (solid.node_at(corner), force));
                let own = self.held.iter().copied().filter(|(node, _)| solid.share().node(*node as usize));
                for (node, force) in own.chain(applied) {
                    let vertex = self.vertex(solid.vertex(node as usize));
                    if nodes.binary_search(&vertex).is_ok() {
                        add(&force, 1.0);
                    }
                }
            }
        }
        sums
    }

    /// Motion of the rigid body with this number, if this rank moves it: see [`Probe::RigidBody`]. The last
    /// value is 1.
    fn motion_of(&self, solid: &Solid<D, N>, number: u32) -> Option<Vec<f64>> {
        let body = self.model.rigid.binary_search(&number).ok().filter(|&body| solid.moves_rigid(body))?;
        let motion = &solid.rigid.motions[body];
        let RigidMotion { velocity, rotation, spin, .. } = motion;
        let moved: Point<D> = std::array::from_fn(|axis| solid.rigid.all[body].displacement(motion, axis));
        // In the plane a body turns about the third axis.
        let first = 3 - D * (D - 1) / 2;
        Some([&moved[..], velocity, &rotation[first..], &spin[first..], &[1.0]].concat())
    }

    /// Visits those of these elements that this rank counts, each with its undeformed volume, m³. The weight
    /// of one element alone is 1, so that its mean is exact.
    fn weighed(&self, solid: &Solid<D, N>, elements: &[u32], mut visit: impl FnMut(usize, f64)) {
        for &number in elements {
            let element = self.topology.element(number);
            if let Some(element) = element.filter(|&element| solid.share().element(element)) {
                let element = element as usize;
                let volume = if elements.len() == 1 { 1.0 } else { solid.element(element).volume };
                visit(element, volume);
            }
        }
    }

    /// Green-Lagrange strain of an element, `[xx, yy, zz, xy, yz, xz]`.
    fn strain(&self, solid: &Solid<D, N>, element: usize) -> [f64; 6] {
        // The gradient H of the displacement: FᵀF - 1 = H + Hᵀ + HᵀH, without the loss of digits in a
        // difference from 1.
        let moved = solid.nodes_of(element as u32).map(|node| solid.displacement(node as usize, &self.model));
        let gradient = product(&<[[f64; D]; N]>::edges(&moved), &solid.inverse_edges(element));
        let turned = transposed(&gradient);
        let squared = product_transposed(&turned, &turned);
        spheres::PLACES.map(|[i, k]| {
            if i.max(k) >= D { 0.0 } else { 0.5 * (gradient[i][k] + gradient[k][i] + squared[i][k]) }
        })
    }

    /// A quantity of nodes at a point, if this rank counts its element.
    fn at(
        &self,
        solid: &Solid<D, N>,
        point: &MaterialPoint<D, N>,
        of: impl Fn(usize) -> Point<D>,
    ) -> Option<Point<D>> {
        let element = self.topology.element(point.element)?;
        if !solid.share().element(element) {
            return None;
        }
        let mut sum = [0.0; D];
        for (node, weight) in solid.nodes_of(element).into_iter().zip(point.weights) {
            crate::vector::add(&mut sum, of(node as usize), weight);
        }
        Some(sum)
    }

    /// Visits the contacts that this rank counts: two elements, and the force on the first, N. Closed cracks
    /// and surfaces that touch under initial stress are contacts too.
    fn each_contact(&self, mut visit: impl FnMut([u32; 2], Point<D>)) {
        for (elements, force) in self.contacts().pushes() {
            if self.solid().share().element(elements[0]) {
                visit(elements, force);
            }
        }
        for contact in self.joints().pressing(self.solid(), &self.topology) {
            visit(contact.elements, contact.normal);
            visit(contact.elements, contact.tangential);
        }
        for (elements, force) in self.actions.seams.pushes::<N>() {
            if self.solid().share().element(elements[0]) {
                visit(elements, force);
            }
        }
    }
}

impl<const D: usize, const N: usize> Wire for Probe<D, N> {
    fn put(&self, out: &mut Vec<u8>) {
        match self {
            Self::Stress(elements) => (0_u8, elements.clone()).put(out),
            Self::Strain(elements) => (1_u8, elements.clone()).put(out),
            Self::Velocity(elements) => (2_u8, elements.clone()).put(out),
            Self::PointVelocity(point) => (3_u8, *point).put(out),
            Self::Gauge { ends, span } => (4_u8, (*ends, span.clone())).put(out),
            Self::ContactForce(bodies) => (5_u8, bodies.clone()).put(out),
            Self::Reaction(nodes) => (6_u8, nodes.clone()).put(out),
            Self::Cavity(name) => (7_u8, name.clone()).put(out),
            Self::JointSet(name) => (8_u8, name.clone()).put(out),
            Self::Softening => 9_u8.put(out),
            Self::RigidBody(body) => (10_u8, *body).put(out),
            Self::Wall { wall } => (11_u8, *wall).put(out),
            Self::Spheres { region } => {
                (12_u8, region.map_or_else(Vec::new, |corners| corners.as_flattened().to_vec())).put(out);
            }
            Self::ForceOfSpheres([by, on]) => (13_u8, (by.parts(), on.parts())).put(out),
            Self::Fluid => 14_u8.put(out),
            Self::Injection(name) => (15_u8, name.clone()).put(out),
            Self::PorePressure(point) => (16_u8, *point).put(out),
            Self::Pores => 17_u8.put(out),
            Self::PoreSurface(name) => (18_u8, name.clone()).put(out),
        }
    }

    fn take(bytes: &mut &[u8]) -> Self {
        match u8::take(bytes) {
            0 => Self::Stress(Vec::take(bytes)),
            1 => Self::Strain(Vec::take(bytes)),
            2 => Self::Velocity(Vec::take(bytes)),
            3 => Self::PointVelocity(MaterialPoint::take(bytes)),
            4 => {
                let (ends, span) = <([MaterialPoint<D, N>; 2], Vec<f64>)>::take(bytes);
                Self::Gauge { ends, span }
            }
            5 => Self::ContactForce(<[Vec<u32>; 2]>::take(bytes)),
            6 => Self::Reaction(Vec::take(bytes)),
            7 => Self::Cavity(String::take(bytes)),
            8 => Self::JointSet(String::take(bytes)),
            9 => Self::Softening,
            10 => Self::RigidBody(u32::take(bytes)),
            11 => Self::Wall { wall: u32::take(bytes) },
            13 => {
                let (by, on) = <((String, Vec<u32>), (String, Vec<u32>))>::take(bytes);
                Self::ForceOfSpheres([by, on].map(TouchingSide::of_parts))
            }
            14 => Self::Fluid,
            15 => Self::Injection(String::take(bytes)),
            16 => Self::PorePressure(MaterialPoint::take(bytes)),
            17 => Self::Pores,
            18 => Self::PoreSurface(String::take(bytes)),
            _ => {
                let corners = Vec::<f64>::take(bytes);
                let corner = |first: usize| std::array::from_fn(|axis| corners[first + axis]);
                Self::Spheres { region: (corners.len() == 6).then(|| [corner(0), corner(3)]) }
            }
        }
    }
}
