//! Bodies that are rigid: their nodes move as the body does, by its centre of mass and its rotation.
//!
//! The elements of a rigid body have no stress. They give the body its mass, its moments of inertia and its
//! shape, so that contacts and loads act on it as on any other body. Its nodes are placed after each step:
//! `rigid/nodes.rs`; its motion is `motion/rigid.rs`.

mod balance;
pub(crate) mod nodes;
mod overload;

use std::collections::BTreeSet;
use std::ops::Range;

use fdem_distributed::wire;
use fdem_mesh::Mesh;

use crate::model::Model;
use crate::rotation::{Quaternion, UNTURNED, inverse, lifted, rotation_vector, turned};
use crate::simplex::Simplex;
use crate::topology::NONE;
use crate::vector::{
    Matrix, Point, add, applied, cholesky, cross3, dot, length, matrix, minus, plus, product_transposed,
    transposed,
};

/// All rigid bodies, in the order of [`Model::rigid`].
#[derive(Clone, Debug, Default)]
pub(crate) struct RigidBodies<const D: usize> {
    /// The rigid body of each element, or [`NONE`]; empty if there is none.
    of_element: Vec<u32>,
    /// Whether each node belongs to a rigid body; empty if there is none.
    is_rigid: Vec<bool>,
    /// The nodes of rigid bodies, ascending, each with its body.
    nodes: Vec<[u32; 2]>,
    pub(crate) all: Vec<RigidBody<D>>,
    pub(crate) motions: Vec<RigidMotion<D>>,
}

/// A rigid body, as the mesh has it. On a rank that does not own it, its elements are some of all.
#[derive(Clone, Debug)]
pub(crate) struct RigidBody<const D: usize> {
    /// Ascending.
    pub(crate) elements: Vec<u32>,
    /// Numbers of the materials of the elements, ascending.
    materials: Vec<u32>,
    /// Undeformed volume, m³: in two dimensions area times thickness.
    volume: f64,
    /// Mass, kg.
    pub(crate) mass: f64,
    /// Centre of mass in the undeformed mesh, relative to [`Solid::origin`], m.
    start: Point<D>,
    /// Moments of inertia about that centre, kg m², and their inverse. In the plane only the last counts.
    inertia: Matrix<3>,
    inverse: Matrix<3>,
    /// Largest distance of a node from the centre, m.
    pub(crate) radius: f64,
    /// Prescribed motion of the centre along each axis: the number of the hold of a node, and a corner there.
    pub(crate) holds: [Option<[u32; 2]>; D],
    turns: Turns,
}

/// The rotations that the supports of a body leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turns {
    All,
    /// About this axis.
    About(usize),
    None,
}

/// Motion of a rigid body. Velocity, momentum and spin are half a step before the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RigidMotion<const D: usize> {
    /// Centre of mass relative to [`Solid::origin`], m, and its velocity, m/s.
    pub(crate) centre: Point<D>,
    pub(crate) velocity: Point<D>,
    /// Rotation since the undeformed mesh.
    pub(crate) orientation: Quaternion,
    /// The same as a vector, rad, which does not jump after a turn: see [`rotation_vector`].
    pub(crate) rotation: Point<3>,
    /// Angular momentum, N m s, and angular velocity, rad/s.
    pub(crate) momentum: Point<3>,
    pub(crate) spin: Point<3>,
}

wire!([const D: usize] RigidMotion<D> { centre, velocity, orientation, rotation, momentum, spin });

impl<const D: usize> RigidMotion<D> {
    /// Turns about a vector in space: the angle, in radians, is its length.
    pub(crate) fn turn_by(&mut self, by: Point<3>) {
        self.orientation = turned(self.orientation, by);
        self.rotation = rotation_vector(self.orientation, self.rotation);
    }
}

impl<const D: usize> RigidBodies<D> {
    /// The rigid bodies of a model, or of a part of one, at rest in the undeformed mesh. `origin`: see
    /// [`Solid::origin`].
    pub(crate) fn new<const N: usize>(model: &Model<D, N>, origin: Point<D>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if model.rigid.is_empty() {
            return Self::default();
        }
        let of_body = |body: &u32| model.rigid.binary_search(body).map_or(NONE, |place| place as u32);
        let of_element: Vec<u32> = model.mesh.bodies.iter().map(of_body).collect();
        let mut elements = vec![Vec::new(); model.rigid.len()];
        for (element, &body) in (0..).zip(&of_element) {
            if let Some(elements) = elements.get_mut(body as usize) {
                elements.push(element);
            }
        }
        let all: Vec<RigidBody<D>> =
            elements.into_iter().map(|elements| RigidBody::new(model, elements, origin)).collect();
        let motions = all.iter().map(|body| body.begin(model, origin)).collect();
        Self { of_element, all, motions, ..Self::default() }
    }

    /// Whether there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        let Self { of_element, is_rigid, nodes, all, motions } = self;
        size_of_val(&**of_element)
            + size_of_val(&**is_rigid)
            + size_of_val(&**nodes)
            + size_of_val(&**motions)
            + all
                .iter()
                .map(|body| size_of_val(body) + size_of_val(&*body.elements) + size_of_val(&*body.materials))
                .sum::<usize>()
    }

    /// The rigid body of an element.
    #[inline]
    pub(crate) fn of_element(&self, element: u32) -> Option<u32> {
        self.of_element.get(element as usize).copied().filter(|&body| body != NONE)
    }

    /// The rigid ones of some elements.
    #[inline]
    pub(crate) fn among(&self, elements: Range<usize>) -> impl Iterator<Item = usize> {
        let bodies = self.of_element.get(elements.clone()).unwrap_or_default();
        elements.zip(bodies).filter(|(_, body)| **body != NONE).map(|(element, _)| element)
    }

    /// Whether all of some elements are rigid.
    #[inline]
    pub(crate) fn has_all(&self, elements: Range<usize>) -> bool {
        self.of_element.get(elements).is_some_and(|bodies| bodies.iter().all(|body| *body != NONE))
    }

    /// Whether two elements belong to one rigid body.
    #[inline]
    pub(crate) fn joins(&self, [a, b]: [u32; 2]) -> bool {
        self.of_element(a).is_some_and(|body| self.of_element(b) == Some(body))
    }

    /// Notes a new node that has been split from another.
    pub(crate) fn split(&mut self, old: u32) {
        let Some(&is_rigid) = self.is_rigid.get(old as usize) else { return };
        let new = self.is_rigid.len() as u32;
        self.is_rigid.push(is_rigid);
        // Nodes ascend.
        if let Ok(place) = self.nodes.binary_search_by_key(&old, |[node, _]| *node) {
            let [_, body] = self.nodes[place];
            self.nodes.push([new, body]);
        }
    }

    /// Whether a node belongs to a rigid body.
    #[inline]
    pub(crate) fn has_node(&self, node: usize) -> bool {
        self.is_rigid.get(node).copied().unwrap_or(false)
    }

    /// The nodes of all rigid bodies, ascending.
    pub(crate) fn node_numbers(&self) -> Vec<u32> {
        self.nodes.iter().map(|[node, _]| *node).collect()
    }

    /// Kinetic energy of a body with the velocities half a step before its position, J.
    pub(crate) fn kinetic(&self, body: usize) -> f64 {
        let RigidMotion { velocity, momentum, spin, .. } = self.motions[body];
        0.5 * (self.all[body].mass * dot(velocity, velocity) + dot(momentum, spin))
    }

    /// The whole mass, kg, that an element moves with, if it is rigid.
    pub(crate) fn mass_with(&self, element: u32) -> Option<f64> {
        self.of_element(element).map(|body| self.all[body as usize].mass)
    }
}

impl<const D: usize> RigidBody<D> {
    fn new<const N: usize>(model: &Model<D, N>, elements: Vec<u32>, origin: Point<D>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (mut mass, mut moment) = (0.0, [0.0; D]);
        for (of_element, corners) in masses(model, &elements, origin) {
            mass += of_element;
            for corner in corners {
                add(&mut moment, corner, of_element / N as f64);
            }
        }
        let start = moment.map(|x| x / mass);
        // The integral of r rᵀ over an element of mass m is m/((D+1)(D+2)) (Σ rᵢ rᵢᵀ + Σ rᵢ Σ rᵢᵀ), with the
        // sums over its corners.
        let (mut spread, mut radius) = ([[0.0; 3]; 3], 0.0_f64);
        for (of_element, corners) in masses(model, &elements, origin) {
            let arms = corners.map(|corner| lifted(minus(corner, start)));
            let sum = arms.into_iter().fold([0.0; 3], plus);
            let share = of_element / ((D + 1) * (D + 2)) as f64;
            for arm in arms.iter().chain([&sum]) {
                for (row, x) in spread.iter_mut().zip(arm) {
                    add(row, *arm, share * x);
                }
            }
            radius = arms.into_iter().map(length).fold(radius, f64::max);
        }
        let trace = spread[0][0] + spread[1][1] + spread[2][2];
        let inertia = matrix(|i, k| if i == k { trace - spread[i][i] } else { -spread[i.min(k)][i.max(k)] });
        let Mesh { nodes, elements: all, .. } = &model.mesh;
        let volume = |&element: &u32| {
            all[element as usize].map(|node| nodes[node as usize]).measure() * model.thickness
        };
        let materials: BTreeSet<u32> =
            elements.iter().map(|&element| model.mesh.materials[element as usize]).collect();
        Self {
            volume: elements.iter().map(volume).sum(),
            materials: materials.into_iter().collect(),
            elements,
            mass,
            start,
            inverse: inverse(&inertia),
            inertia,
            radius,
            holds: [None; D],
            turns: Turns::All,
        }
    }

    /// The motion at the beginning: of all rigid ones, that with the momentum and the angular momentum of the
    /// masses at the nodes.
    fn begin<const N: usize>(&self, model: &Model<D, N>, origin: Point<D>) -> RigidMotion<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut motion = RigidMotion {
            centre: self.start,
            velocity: [0.0; D],
            orientation: UNTURNED,
            rotation: [0.0; 3],
            momentum: [0.0; 3],
            spin: [0.0; 3],
        };
        if model.velocities.is_empty() {
            return motion;
        }
        let (mut momentum, mut lumped) = ([0.0; 3], [[0.0; 3]; 3]);
        for (&element, (mass, corners)) in self.elements.iter().zip(masses(model, &self.elements, origin)) {
            let share = mass / N as f64;
            for (node, corner) in model.mesh.elements[element as usize].into_iter().zip(corners) {
                let (arm, velocity) = (lifted(minus(corner, self.start)), model.velocities[node as usize]);
                add(&mut motion.velocity, velocity, share / self.mass);
                add(&mut momentum, cross3(arm, lifted(velocity)), share);
                add_point_mass(&mut lumped, share, arm);
            }
        }
        motion.spin = applied(&inverse(&lumped), momentum);
        motion.momentum = applied(&self.inertia, motion.spin);
        motion
    }

    /// Angular velocity, rad/s, with an angular momentum at an orientation.
    pub(crate) fn spin(&self, turn: &Matrix<3>, momentum: Point<3>) -> Point<3> {
        match self.turns {
            Turns::All => applied(turn, applied(&self.inverse, applied(&transposed(turn), momentum))),
            Turns::About(axis) => along(axis, momentum[axis] / self.inertia[axis][axis]),
            Turns::None => [0.0; 3],
        }
    }

    /// Angular momentum, N m s, with an angular velocity at an orientation, rad/s.
    pub(crate) fn momentum(&self, turn: &Matrix<3>, spin: Point<3>) -> Point<3> {
        applied(turn, applied(&self.inertia, applied(&transposed(turn), spin)))
    }

    /// The integral of density times `r rᵀ` with the arm `r` from the centre, in the undeformed body, kg m².
    fn spread(&self) -> Matrix<3> {
        let [[xx, ..], [_, yy, _], [.., zz]] = self.inertia;
        matrix(|i, k| f64::from(u8::from(i == k)) * 0.5 * (xx + yy + zz) - self.inertia[i][k])
    }

    /// The part of an angular momentum that supports leave, N m s.
    pub(crate) fn left(&self, momentum: Point<3>) -> Point<3> {
        match self.turns {
            Turns::All => momentum,
            Turns::About(axis) => along(axis, momentum[axis]),
            Turns::None => [0.0; 3],
        }
    }

    /// Displacement of the centre along an axis, m.
    pub(crate) fn displacement(&self, motion: &RigidMotion<D>, axis: usize) -> f64 {
        motion.centre[axis] - self.start[axis]
    }

    /// Whether supports hold it.
    pub(crate) fn is_held(&self) -> bool {
        self.turns != Turns::All || self.holds.iter().any(Option::is_some)
    }

    /// The square of a frequency, 1/s², that the motion of this body on springs does not exceed. Each spring
    /// has its place and its unit normal, and a stiffness along it, N/m, of which a share acts aslant.
    pub(crate) fn highest_square(&self, springs: &[(Point<D>, Point<D>, f64)], aslant: f64) -> f64 {
        // With the coordinates √m x, and Cᵀ φ⁻¹ of the rotation with C Cᵀ the inverse of the moments of
        // inertia, the frequencies are the eigenvalues of a matrix of six rows.
        let root = cholesky(&self.inverse);
        let over = 1.0 / self.mass.sqrt();
        let mut whole = [[0.0; 6]; 6];
        for (place, normal, stiffness) in springs {
            let (arm, normal) = (lifted(minus(*place, self.start)), lifted(*normal));
            for axis in 0..D {
                // k (a + (1 - a) n nᵀ) is the sum of springs along the axes and one along the normal.
                let mut unit = [0.0; 3];
                unit[axis] = 1.0;
                add_spring(&mut whole, over, &root, arm, unit, aslant * stiffness);
            }
            add_spring(&mut whole, over, &root, arm, normal, (1.0 - aslant).max(0.0) * stiffness);
        }
        largest_at_most(&whole)
    }
}

/// Adds the spring along a direction to the matrix of [`RigidBody::highest_square`].
fn add_spring(
    whole: &mut [[f64; 6]; 6],
    over: f64,
    root: &Matrix<3>,
    arm: Point<3>,
    direction: Point<3>,
    stiffness: f64,
) {
    let turning = applied(&transposed(root), cross3(arm, direction));
    let row: [f64; 6] = std::array::from_fn(|k| if k < 3 { over * direction[k] } else { turning[k - 3] });
    for (i, of_row) in whole.iter_mut().enumerate() {
        add(of_row, row, stiffness * row[i]);
    }
}

/// A bound of the largest eigenvalue of a matrix whose eigenvalues are not negative, at most 6^(1/16) times
/// as large: the norm of its eighth power.
fn largest_at_most(matrix: &[[f64; 6]; 6]) -> f64 {
    let norm = |a: &[[f64; 6]; 6]| a.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt();
    let (mut power, mut bound) = (*matrix, 1.0);
    // Square roots are the same on every platform.
    let root = |value: f64, times: usize| (0..times).fold(value, |value, _| value.sqrt());
    for times in 0..3 {
        let scale = norm(&power);
        if scale == 0.0 {
            return 0.0;
        }
        bound *= root(scale, times);
        let scaled = power.map(|row| row.map(|x| x / scale));
        power = product_transposed(&scaled, &scaled);
    }
    bound * root(norm(&power), 3)
}

/// Adds the moments of inertia of a mass, kg, at an arm, m.
fn add_point_mass(inertia: &mut Matrix<3>, mass: f64, arm: Point<3>) {
    let square = dot(arm, arm);
    for (i, row) in inertia.iter_mut().enumerate() {
        row[i] += mass * square;
        add(row, arm, -mass * arm[i]);
    }
}

/// The vector along an axis.
fn along(axis: usize, value: f64) -> Point<3> {
    let mut vector = [0.0; 3];
    vector[axis] = value;
    vector
}

/// Mass and corners of some elements, relative to an origin.
fn masses<'a, const D: usize, const N: usize>(
    model: &'a Model<D, N>,
    elements: &'a [u32],
    origin: Point<D>,
) -> impl Iterator<Item = (f64, [Point<D>; N])> + 'a
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let Mesh { nodes, elements: all, materials, .. } = &model.mesh;
    elements.iter().map(move |&element| {
        let corners = all[element as usize].map(|node| minus(nodes[node as usize], origin));
        let density = model.materials[materials[element as usize] as usize].density;
        (density * corners.measure() * model.thickness, corners)
    })
}
