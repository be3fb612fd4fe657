//! The longest stable time step.
//!
//! Central differences are stable up to a time step of 2/ω, with ω the highest angular frequency of the
//! elastic system (book, (5.34)). The following bound holds for any mesh. λ is the square of the highest
//! angular frequency of a free element, mₑ its mass at the node, and a spring k between two nodes is at most
//! as stiff as 2 k on each:
//!
//! ```text
//! ω² ≤ max over nodes of (Σ λ mₑ + 2 Σ k) / Σ mₑ
//! ```
//! The sums are over the elements and *all* springs at the node: for every facet that is, or may become,
//! free, the stiffer of its joint and its contact. Each node is as small as it can become, as if all facets
//! around it that can separate had separated. Elements whose pores are full count with the stiffness of the
//! liquid, `α² M`, as long as none of it flows. `mass.rs` adds mass where the bound is too large.

use std::collections::BTreeSet;

use fdem_distributed::wire;
use fdem_distributed::wire::Wire;

use crate::actions::ground::Ground;
use crate::compiled::compiled;
use crate::contacts;
use crate::error::ModelError;
use crate::joints::{Joints, penalty};
use crate::model::Model;
use crate::rigid::{RigidBodies, RigidBody};
use crate::share::Share;
use crate::simplex::Simplex;
use crate::solid::corners_of;
use crate::topology::Facet;
use crate::topology::{NONE, Topology};
use crate::vector::{Point, dot, unit};

/// The longest stable time step, and the part that sets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalStep {
    /// Time step, s: for a sphere, its step over the model's [`safety`](crate::TimeOptions::safety).
    pub step: f64,
    /// An element at the node that sets the step; the number of the sphere if [`Cause::Sphere`] does.
    pub element: u32,
    /// Largest stiffness at this node.
    pub cause: Cause,
}

/// Origin of the stiffness at a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Elements, and the ground beyond absorbing facets.
    Bulk,
    /// Joints.
    Joint,
    /// Contacts.
    Contact,
    /// Contacts of a sphere, which are followed by more steps than stability needs.
    Sphere,
}

wire!([] CriticalStep { step, element, cause });

impl Wire for Cause {
    fn put(&self, out: &mut Vec<u8>) {
        (*self as u8).put(out);
    }

    fn take(bytes: &mut &[u8]) -> Self {
        [Self::Bulk, Self::Joint, Self::Contact, Self::Sphere][u8::take(bytes) as usize]
    }
}

impl std::fmt::Display for Cause {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Bulk => "bulk",
            Self::Joint => "joint",
            Self::Contact => "contact",
            Self::Sphere => "sphere",
        })
    }
}

/// The greatest speed with which bodies begin, or that boundaries prescribe, m/s.
fn fastest_body<const D: usize, const N: usize>(model: &Model<D, N>) -> f64 {
    let at_first = model.velocities.iter().map(|velocity| dot(*velocity, *velocity).sqrt());
    let nodes = &model.mesh.nodes;
    let prescribed = model.boundaries.iter().map(|boundary| boundary.greatest_speed(nodes, f64::INFINITY));
    // A jump has no speed.
    at_first.chain(prescribed).filter(|speed| speed.is_finite()).fold(0.0, f64::max)
}

impl CriticalStep {
    /// The critical time step of a model, with all joints and contacts that it may get.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated.
    pub fn of<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        compiled!((model: reference [Model<2, 3>, Model<3, 4>])
            -> [Result<CriticalStep, ModelError>, Result<CriticalStep, ModelError>] = CriticalStep::of_model)
    }

    fn of_model<const D: usize, const N: usize>(model: &Model<D, N>) -> Result<Self, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        crate::checks::check(model)?;
        let topology = Topology::of(&model.mesh)?;
        let joints = Joints::new(model, &topology, &Share::default());
        Ok(Self::new(model, &topology, &joints))
    }

    /// The critical time step of a model, with its topology and its joints.
    pub(crate) fn new<const D: usize, const N: usize>(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        joints: &Joints<D>,
    ) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let of_bodies = Self::of_bodies(model, topology, joints);
        let Some(grains) = &model.grains else { return of_bodies };
        // The step of the spheres needs no further safety.
        let (step, element) = grains.shortest_step(fastest_body(model));
        let step = step / model.time.safety;
        if step < of_bodies.step { Self { step, element, cause: Cause::Sphere } } else { of_bodies }
    }

    /// The critical time step of a model without its spheres.
    fn of_bodies<const D: usize, const N: usize>(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        joints: &Joints<D>,
    ) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if model.until_overloaded.is_empty() {
            return Self::with(model, topology, joints, rigid_squares(model, topology));
        }
        // One step for the whole run: these bodies are rigid at first, and deform later. Bodies that have
        // been released already count as both, too.
        let until = || model.until_overloaded.iter().map(|of| of.body);
        let mut rigid: BTreeSet<u32> = model.rigid.iter().copied().chain(until()).collect();
        let all = Model { rigid: rigid.iter().copied().collect(), ..model.clone() };
        until().for_each(|body| {
            rigid.remove(&body);
        });
        let loose = Model { rigid: rigid.into_iter().collect(), ..model.clone() };
        let joints = Joints::new(&loose, topology, &Share::default());
        Self::with(&loose, topology, &joints, rigid_squares(&all, topology))
    }

    /// The critical time step of a model whose rigid bodies have these squares of a frequency, 1/s².
    fn with<const D: usize, const N: usize>(
        model: &Model<D, N>,
        topology: &Topology<D, N>,
        joints: &Joints<D>,
        of_rigid: Vec<(f64, u32)>,
    ) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (mut worst, mut element, mut cause) = (0.0, 0, Cause::Bulk);
        least_nodes(model, topology, joints, |corners| {
            let mut sum = CornerStiffness::default();
            let mut own = 0;
            for (corner, of_corner) in corners {
                sum.mass += of_corner.mass;
                sum.bulk += of_corner.bulk;
                sum.joint += of_corner.joint;
                sum.contact += of_corner.contact;
                own = corner / N as u32;
            }
            let square = sum.stiffness() / sum.mass;
            if sum.mass > 0.0 && square > worst {
                (worst, element) = (square, own);
                cause = if sum.bulk >= 2.0 * sum.joint.max(sum.contact) {
                    Cause::Bulk
                } else if sum.joint >= sum.contact {
                    Cause::Joint
                } else {
                    Cause::Contact
                };
            }
        });
        for (square, own) in of_rigid {
            if square > worst {
                (worst, element, cause) = (square, own, Cause::Contact);
            }
        }
        Self { step: 2.0 / f64::sqrt(worst) * reduction(model), element, cause }
    }
}

/// The longest stable time step over that without damping.
pub(crate) fn reduction<const D: usize, const N: usize>(model: &Model<D, N>) -> f64 {
    let damping = model.materials.iter().map(|material| material.damping).fold(0.0, f64::max);
    let damping = damping.max(model.contact.damping);
    // Reduction for a share ξ of critical damping, with velocities that are half a step old.
    (1.0 + damping * damping).sqrt() - damping
}

/// Calls `visit` with the corners of each node that the model may get, where each is as small as it can
/// become.
pub(crate) fn least_nodes<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
    joints: &Joints<D>,
    mut visit: impl FnMut(&[(u32, CornerStiffness)]),
) where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mesh = &model.mesh;
    let mut corners: Vec<CornerStiffness> = Vec::with_capacity(N * mesh.elements.len());
    corners.extend(
        (0..mesh.elements.len()).flat_map(|element| element_corners(model, topology, joints, element)),
    );
    // Absorbing facets that are not outer facets are refused when the loads are made.
    for (corner, stiffness) in Ground::new(model, topology, None).unwrap_or_default().springs() {
        corners[corner as usize].bulk += stiffness;
    }
    let (mut groups, mut own) = (Vec::new(), Vec::new());
    for vertex in 0..topology.vertex_count() as u32 {
        topology.groups(vertex, |facet| !joints.may_part(facet), &mut groups);
        let at = topology.corners_of(vertex);
        for leader in 0..at.len() as u32 {
            own.clear();
            let of_group = at.iter().zip(&groups).filter(|(_, group)| **group == leader);
            own.extend(of_group.map(|(&corner, _)| (corner, corners[corner as usize])));
            // The nodes of a rigid body move together.
            if own.first().is_some_and(|(corner, _)| !model.is_rigid(corner / N as u32)) {
                visit(&own);
            }
        }
    }
}

/// Share of the longest stable time step that rigid bodies allow. Where nothing else is compressed, contacts
/// must be followed by more steps than stability needs: an impact of flush faces then changes the energy by
/// up to 1.5 %.
const OF_RIGID: f64 = 0.5;

/// The square of the frequency that the motion of each rigid body does not exceed, with all of its outer
/// facets in contact, for steps of that share, 1/s²; and the first element of the body.
fn rigid_squares<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
) -> Vec<(f64, u32)>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let bodies = RigidBodies::new(model, [0.0; D]);
    let of_body = |body: &RigidBody<D>| {
        let mut springs = Vec::new();
        for &element in &body.elements {
            let (element, number) = (element as usize, model.mesh.materials[element as usize]);
            let shape = corners_of(&model.mesh, element);
            for k in (0..N).filter(|&k| topology.facet_of[element][k] == NONE) {
                let facet = <[[f64; D]; N]>::FACETS[k].map(|corner| shape[corner]);
                let normal = unit(<[[f64; D]; N]>::facet_normal(&facet));
                let stiffness = 2.0 * contacts::stiffness(model, &shape, k, number);
                springs.extend(facet.map(|place| (place, normal, stiffness)));
            }
        }
        let square = body.highest_square(&springs, model.contact.tangential_stiffness);
        (square / (OF_RIGID * OF_RIGID), body.elements[0])
    };
    bodies.all.iter().map(of_body).collect()
}

/// Mass in motion, kg, and stiffness, N/m, that a corner of an element adds to its node.
#[derive(Clone, Copy, Default)]
pub(crate) struct CornerStiffness {
    pub(crate) mass: f64,
    bulk: f64,
    joint: f64,
    contact: f64,
}

impl CornerStiffness {
    /// The stiffness in the bound of the frequency, N/m.
    pub(crate) fn stiffness(&self) -> f64 {
        self.bulk + 2.0 * (self.joint + self.contact)
    }
}

fn element_corners<const D: usize, const N: usize>(
    model: &Model<D, N>,
    topology: &Topology<D, N>,
    joints: &Joints<D>,
    element: usize,
) -> [CornerStiffness; N]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let shape = corners_of(&model.mesh, element);
    let number = model.mesh.materials[element];
    let material = &model.materials[number as usize];
    let mass = material.density * shape.measure() * model.thickness / N as f64;
    let law = material.in_elements::<D, N>(model.plane);
    let bulk = law.highest_square(&shape, material.density) * mass;
    let bulk = bulk + liquid_stiffness(model, &shape, number);
    let mass = model.mass_factor(element) * mass;
    let mut corners = [CornerStiffness { mass, bulk, ..CornerStiffness::default() }; N];
    for k in 0..N {
        let facet = topology.facet_of[element][k];
        if facet != NONE && !joints.may_part(facet) {
            continue;
        }
        let contact = contacts::stiffness(model, &shape, k, number);
        let at = <[[f64; D]; N]>::FACETS[k];
        let joint = if facet == NONE {
            0.0
        } else {
            let measure = <[[f64; D]; N]>::facet_measure(&at.map(|corner| shape[corner]));
            1.0 / D as f64
                * measure
                * model.thickness
                * stiffest(model, joints.set(facet), &topology.facets[facet as usize])
        };
        for corner in at {
            if joint >= contact {
                corners[corner].joint += joint;
            } else {
                corners[corner].contact += contact;
            }
        }
    }
    corners
}

/// Stiffness of the liquid in the pores of an element while none of it flows, N/m: an upper bound of its
/// share at each corner.
///
/// At constant contents the pressures of vertices store `Σ (Σ α V ε/N)²/(2 S)`, with the storage `S = Σ
/// V/(N M)` of a vertex. By Cauchy's inequality that is at most `Σ α² M V ε²/2` over the elements, whatever
/// vertices they share. In one element it has one mode, `V ε = Σ u·A/D` with the area vectors `A` opposite to
/// the corners, and the stiffness `α² M Σ A²/(D² V)`.
fn liquid_stiffness<const D: usize, const N: usize>(
    model: &Model<D, N>,
    shape: &[Point<D>; N],
    material: u32,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Some(pores) = model.pores.as_ref().and_then(|pores| pores.material(material)) else { return 0.0 };
    let area =
        |k: usize| <[[f64; D]; N]>::facet_measure(&<[[f64; D]; N]>::FACETS[k].map(|corner| shape[corner]));
    let squares: f64 = (0..N).map(|k| area(k) * area(k)).sum();
    pores.undrained_modulus() * model.thickness * squares / ((D * D) as f64 * shape.measure())
}

/// Greatest stiffness of the joint on a facet in any direction, Pa/m.
fn stiffest<const D: usize, const N: usize>(model: &Model<D, N>, set: Option<u32>, facet: &Facet<D>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let penalty = penalty(model, facet);
    let set = set.and_then(|set| model.joint_sets.get(set as usize));
    set.map_or(penalty, |set| {
        let [normal, shear] = set.stiffness(penalty);
        normal.max(set.shear_stiffness.unwrap_or(normal * shear * shear))
    })
}
