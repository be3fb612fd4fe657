//! The nodes of rigid bodies, their supports, and the records of their motion.

use crate::action::Record;
use crate::actions::prescribed::Hold;
use crate::error::ModelError;
use crate::model::Model;
use crate::rigid::{RigidBodies, RigidBody, RigidMotion, Turns, along};
use crate::rotation::{lifted, lowered, matrix_of, turned};
use crate::simplex::Simplex;
use crate::solid::{Node, Solid};
use crate::team::Team;
use crate::topology::{NONE, Topology};
use crate::vector::{Matrix, Point, add, applied, cholesky, cross3, length, matrix, minus, plus};

/// Place in the list of actions of a record with the motion of a rigid body, which is no action.
pub(crate) const RECORD: u32 = NONE - 1;

impl<const D: usize, const N: usize> Solid<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Lists the nodes of rigid bodies.
    pub(crate) fn list_rigid_nodes(&mut self) {
        if self.rigid.is_empty() {
            return;
        }
        let body = |node: usize| self.rigid.of_element(self.corners(node)[0] / N as u32);
        let bodies: Vec<Option<u32>> = (0..self.node_count()).map(body).collect();
        self.rigid.is_rigid = bodies.iter().map(Option::is_some).collect();
        let rigid = (0..).zip(bodies).filter_map(|(node, body)| body.map(|body| [node, body]));
        self.rigid.nodes = rigid.collect();
    }

    /// Whether this rank moves a rigid body.
    pub(crate) fn moves_rigid(&self, body: usize) -> bool {
        let first = self.rigid.all[body].elements.first();
        first.is_some_and(|&element| self.share().corner(element * N as u32))
    }

    /// Places the nodes of the rigid bodies of this rank. Their velocities are those with which they have
    /// come here in the last step, of length `step`, s.
    pub(crate) fn place_rigid_nodes(&mut self, model: &Model<D, N>, step: f64, team: &Team) {
        let RigidBodies { nodes, all, motions, .. } = &self.rigid;
        let poses: Vec<Pose> = motions.iter().map(|motion| Pose::of(motion, step)).collect();
        let placed = team.list(nodes.len(), |range| {
            let place = |&[node, body]: &[u32; 2]| {
                let (body, vertex) = (body as usize, self.vertex(node as usize) as usize);
                let place = minus(model.mesh.nodes[vertex], self.origin);
                (node, poses[body].node(&motions[body], lifted(minus(place, all[body].start))))
            };
            let own = nodes[range].iter().filter(|[_, body]| self.moves_rigid(*body as usize));
            own.map(place).collect()
        });
        for (node, to) in placed {
            self.set_node(node as usize, to);
        }
    }

    /// Takes the supports of nodes of rigid bodies over. `holds`: the prescribed motions of nodes.
    ///
    /// # Errors
    /// [`ModelError::RigidSupport`] if two motions are prescribed along one axis, or if the supports leave a
    /// rotation about another point than the centre of mass.
    pub(crate) fn hold_rigid_bodies(
        &mut self,
        holds: &[[Option<Hold>; D]],
        model: &Model<D, N>,
    ) -> Result<(), ModelError> {
        let name = |boundary: u32| model.boundaries[boundary as usize].name.clone();
        for body in (0..self.rigid.all.len()).filter(|&body| self.moves_rigid(body)).collect::<Vec<_>>() {
            let held =
                self.holds_of(&self.rigid.all[body], holds, model).map_err(|(boundaries, turns)| {
                    let (body, boundaries) = (model.rigid[body], boundaries.map(name));
                    ModelError::RigidSupport { body, boundaries, turns }
                })?;
            let of_body = &mut self.rigid.all[body];
            (of_body.holds, of_body.turns) = held;
        }
        Ok(())
    }

    /// The supports of a body. Or else the boundaries of an error, and whether they leave a rotation that
    /// cannot be.
    #[allow(clippy::type_complexity, reason = "two fields of a body")]
    fn holds_of(
        &self,
        body: &RigidBody<D>,
        holds: &[[Option<Hold>; D]],
        model: &Model<D, N>,
    ) -> Result<([Option<[u32; 2]>; D], Turns), ([u32; 2], bool)> {
        let mut found: [Option<(Hold, [u32; 2])>; D] = [None; D];
        // Vectors across which the axis of a rotation must be, so that nodes move alike along an axis; and so
        // that one node moves as the centre does.
        let (mut rows, mut of_centre) = ([[0.0; 3]; 3], Vec::new());
        let mut first: [Point<3>; D] = [[0.0; 3]; D];
        let corners =
            body.elements.iter().flat_map(|element| (0..N as u32).map(move |k| element * N as u32 + k));
        for corner in corners.filter(|&corner| self.hold_at(corner) != NONE) {
            let place = model.mesh.nodes[self.vertex(self.node_at(corner) as usize) as usize];
            let arm = lifted(minus(minus(place, self.origin), body.start)).map(|x| x / body.radius);
            for axis in 0..D {
                let Some(hold) = holds[self.hold_at(corner) as usize][axis] else { continue };
                let along_axis = along(axis, 1.0);
                match found[axis] {
                    None => {
                        (found[axis], first[axis]) = (Some((hold, [self.hold_at(corner), corner])), arm);
                        of_centre.push(cross3(arm, along_axis));
                    }
                    Some((other, _)) if other == hold => {
                        let row = cross3(minus(arm, first[axis]), along_axis);
                        for (of_rows, x) in rows.iter_mut().zip(row) {
                            add(of_rows, row, x);
                        }
                    }
                    Some((other, _)) => {
                        return Err(([other.boundary, hold.boundary], false));
                    }
                }
            }
        }
        if found[0].is_some_and(|(hold, _)| hold.is_rotation()) {
            return Ok((found.map(|hold| hold.map(|(_, place)| place)), Turns::None));
        }
        // In the plane a body turns about the third axis.
        let first_axis = 3 - D * (D - 1) / 2;
        let free: Vec<usize> = (first_axis..3).filter(|&axis| rows[axis][axis] <= STRAIGHT).collect();
        let turns = match free.as_slice() {
            [] => Turns::None,
            [axis] if first_axis == 0 => Turns::About(*axis),
            _ => Turns::All,
        };
        let blocked: Vec<usize> = (first_axis..3).filter(|axis| !free.contains(axis)).collect();
        let mut of_blocked: Matrix<3> = matrix(|i, k| f64::from(u8::from(i == k)));
        for (&i, &k) in blocked.iter().flat_map(|i| blocked.iter().map(move |k| (i, k))) {
            of_blocked[i][k] = rows[i][k];
        }
        let is_whole = cholesky(&of_blocked).iter().enumerate().all(|(k, row)| row[k] * row[k] > STRAIGHT);
        let all_or_some = free.len() < 2 || blocked.is_empty();
        let about_centre = free
            .iter()
            .all(|&axis| of_centre.iter().all(|row: &Point<3>| row[axis].abs() <= STRAIGHT.sqrt()));
        let boundary = found.iter().flatten().map(|(hold, _)| hold.boundary).next();
        match boundary {
            Some(boundary) if !(is_whole && all_or_some && about_centre) => Err(([boundary; 2], true)),
            _ => Ok((found.map(|hold| hold.map(|(_, place)| place)), turns)),
        }
    }

    /// The motions of the rigid bodies that this rank moves, for states that are saved and for other ranks.
    pub(crate) fn rigid_records(&self, topology: &Topology<D, N>) -> Vec<Record> {
        let own = (0..self.rigid.all.len()).filter(|&body| self.moves_rigid(body));
        let record = |body: usize| {
            let code = topology.code_of_corner(self.rigid.all[body].elements[0] * N as u32);
            let mut record = Record::new([code; 2], 0, &self.rigid.motions[body]);
            record.action = RECORD;
            record
        };
        own.map(record).collect()
    }

    /// Takes the motion of a rigid body over. Returns `false` if it does not fit.
    pub(crate) fn take_rigid(&mut self, record: &Record, topology: &Topology<D, N>) -> bool {
        let Some(corner) = topology.corner(record.codes[0]) else { return false };
        let Some(body) = self.rigid.of_element(corner / N as u32) else { return false };
        let Some(motion) = self.rigid.motions.get_mut(body as usize) else { return false };
        record.value(motion).map(|value| *motion = value).is_some()
    }
}

/// Square of an angle, or of a length over the radius of a body, that is nothing.
const STRAIGHT: f64 = 1e-18;

/// A rigid body between two places: the rotation at the second, that half a step earlier, and the velocity of
/// turning with which nodes go from one to the other.
struct Pose {
    turn: Matrix<3>,
    half: Matrix<3>,
    spin: Point<3>,
}

impl Pose {
    fn of<const D: usize>(motion: &RigidMotion<D>, step: f64) -> Self {
        let RigidMotion { orientation, spin, .. } = *motion;
        let angle = step * length(spin);
        // A node moves along a chord.
        let chord = if angle > 1e-100 { 2.0 * libm::sin(0.5 * angle) / angle } else { 1.0 };
        Self {
            turn: matrix_of(orientation),
            half: matrix_of(turned(orientation, spin.map(|x| -0.5 * step * x))),
            spin: spin.map(|x| chord * x),
        }
    }

    /// A node with this arm in the undeformed body, m.
    fn node<const D: usize>(&self, motion: &RigidMotion<D>, arm: Point<3>) -> Node<D> {
        let turning = cross3(self.spin, applied(&self.half, arm));
        Node {
            position: plus(motion.centre, lowered(applied(&self.turn, arm))),
            velocity: plus(motion.velocity, lowered(turning)),
        }
    }
}
