//! One joint: its state, and the forces that it has while it holds, softens, and is handed over to contact.

use fdem_distributed::wire::Wire;
use serde::{Deserialize, Serialize};

use crate::cohesive::{JointLaw, JointPlane, Memory, across, dissipated_at};
use crate::joints::plane::{mean_stress_of, plane_of};
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::topology::Facet;
use crate::vector::{Matrix, Point, add, dot, length, minus, plus};

/// Sliding of a broken joint over its length at which it begins to hand over to the contact of its two
/// elements, and at which the handover is complete.
const FADE: [f64; 2] = [0.1, 0.3];

/// An end is detached if it is broken and its two sides are farther apart than this, over the length of the
/// joint: the two elements turn about the other end as about a hinge. Half way round, the joint has no
/// direction any more; farther round, an open joint looks closed.
///
/// If all other ends have two nodes, they break together with the detached end: their fracture process is
/// long over, and they seem to hold only because a joint is evaluated at few points. If another end is still
/// a single node, the detached end has no force. It presses again only after it was found open at a smaller
/// distance, so that its force begins at zero.
pub(super) const APART: f64 = 0.5;

/// Share of a broken joint of this length, m, that has been handed over to contact after this sliding, m;
/// beyond 0 and 1 before and after.
#[inline(always)]
pub(super) fn faded_at<const D: usize>(slid: [f64; D], long: f64) -> f64 {
    (length(slid) / long - FADE[0]) / (FADE[1] - FADE[0])
}

/// State of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum JointState {
    /// Elastic or softening.
    Holding,
    /// Transmits pressure and friction only.
    Broken,
    /// Has handed over to the contact of the two elements.
    Removed,
}

/// A joint on the facet between two elements.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, JointPlane<D>: Serialize, [Memory<D>; D]: Serialize, [bool; D]: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, JointPlane<D>: Deserialize<'de>, [Memory<D>; D]: Deserialize<'de>, [bool; D]: Deserialize<'de>"
))]
pub(crate) struct Joint<const D: usize = 2> {
    /// Number of its facet; in a saved run the code of the facet.
    pub(crate) facet: u32,
    pub(crate) state: JointState,
    /// The plane that the joint represents.
    pub(crate) plane: JointPlane<D>,
    #[serde(skip, default = "no_law")]
    pub(crate) law: JointLaw<D>,
    /// Length of the undeformed edge, m, or area of the undeformed face, m².
    #[serde(skip)]
    pub(crate) measure: f64,
    /// Whether this rank counts it.
    #[serde(skip)]
    pub(crate) counted: bool,
    /// Whether it is of a joint set that is open from the beginning, so that it is no crack of the run.
    #[serde(skip)]
    pub(crate) open_from_start: bool,
    /// The elements on its two sides, if it is intrinsic and may represent another plane than its own.
    #[serde(skip)]
    pub(crate) beside: Option<[u32; 2]>,
    /// Its length, or that of the edges of an even face of this area, m.
    #[serde(skip)]
    pub(super) length: f64,
    /// Nodes of each end, on side 0 and on side 1.
    #[serde(skip, default = "no_nodes")]
    pub(crate) nodes: [[u32; 2]; D],
    pub(crate) ends: [Memory<D>; D],
    /// Share of the strength that is left at the damage of each end, 0 where it is not known: see
    /// [`Memory::rests`].
    #[serde(skip, default = "nothing_left")]
    pub(super) left: [f64; D],
    /// Whether each end has two nodes.
    pub(crate) open: [bool; D],
    /// Whether each end is detached: see [`APART`].
    pub(crate) detached: [bool; D],
    /// Share of the joint that has been handed over to contact, 0 to 1.
    pub(crate) faded: f64,
    /// Increase of `faded` in the last step.
    pub(crate) fading: f64,
    /// Time at which it began to soften, s; infinite while it is whole.
    pub(crate) softens: f64,
}

impl<const D: usize> Wire for Joint<D> {
    fn put(&self, out: &mut Vec<u8>) {
        let Self {
            facet, state, plane, ends, open, detached, faded, fading, softens, open_from_start, ..
        } = self;
        facet.put(out);
        (*state as u8).put(out);
        plane.put(out);
        ends.put(out);
        [*open, *detached].put(out);
        [*faded, *fading, *softens].put(out);
        open_from_start.put(out);
    }

    fn take(bytes: &mut &[u8]) -> Self {
        let facet = u32::take(bytes);
        let state = [JointState::Holding, JointState::Broken, JointState::Removed][u8::take(bytes) as usize];
        let (plane, ends) = (JointPlane::take(bytes), Wire::take(bytes));
        let ([open, detached], [faded, fading, softens]) = (Wire::take(bytes), Wire::take(bytes));
        let open_from_start = bool::take(bytes);
        let nodes = no_nodes();
        Self {
            facet,
            state,
            plane,
            law: no_law(),
            measure: 0.0,
            counted: false,
            open_from_start,
            beside: None,
            length: 0.0,
            nodes,
            ends,
            left: [0.0; D],
            open,
            detached,
            faded,
            fading,
            softens,
        }
    }
}

fn no_law<const D: usize>() -> JointLaw<D> {
    JointLaw {
        normal: across(),
        penalty: 0.0,
        tensile: 0.0,
        cohesion: 0.0,
        friction: 0.0,
        residual: 0.0,
        shear: 1.0,
        critical: [1.0; 2],
        dilation: 0.0,
        dilated: 0.0,
    }
}

fn nothing_left<const D: usize>() -> [f64; D] {
    [0.0; D]
}

fn no_nodes<const D: usize>() -> [[u32; 2]; D] {
    [[0; 2]; D]
}

impl<const D: usize> Joint<D> {
    /// A joint that nothing has loaded yet. Its nodes are found by [`find_nodes`](Self::find_nodes).
    pub(super) fn new(
        facet: u32,
        law: JointLaw<D>,
        plane: JointPlane<D>,
        [measure, length]: [f64; 2],
    ) -> Self {
        Self {
            facet,
            state: JointState::Holding,
            plane,
            law: law.on(plane),
            measure,
            counted: true,
            open_from_start: false,
            beside: None,
            length,
            nodes: no_nodes(),
            ends: [Memory::default(); D],
            left: [0.0; D],
            open: [false; D],
            detached: [false; D],
            faded: 0.0,
            fading: 0.0,
            softens: f64::INFINITY,
        }
    }

    /// Looks up its nodes.
    pub(super) fn find_nodes<const N: usize>(&mut self, facet: &Facet<D>, solid: &Solid<D, N>) {
        self.nodes = std::array::from_fn(|end| facet.corners.map(|side| solid.node_at(side[end])));
    }

    /// The joint of a saved run, with the fields that are not saved.
    pub(super) fn restored(&self, saved: Self) -> Self {
        Self {
            facet: self.facet,
            law: self.law,
            measure: self.measure,
            counted: self.counted,
            open_from_start: self.open_from_start,
            beside: self.beside,
            length: self.length,
            ..saved
        }
    }

    /// Whether it is elastic or softening.
    pub(crate) fn holds(&self) -> bool {
        self.state == JointState::Holding
    }

    /// Damage from 0 (whole) to 1 (broken): the mean of its ends while the joint holds.
    pub(crate) fn damage(&self) -> f64 {
        if self.state == JointState::Holding {
            self.ends.iter().map(Memory::damage).sum::<f64>() / D as f64
        } else {
            1.0
        }
    }

    /// Share of its fracture energy that it has dissipated, the mean of its ends while the joint holds.
    pub(crate) fn dissipated(&self) -> f64 {
        if self.state == JointState::Holding {
            self.ends.iter().map(|end| dissipated_at(end.damage())).sum::<f64>() / D as f64
        } else {
            1.0
        }
    }

    /// Area of each of its ends that has not been handed over to contact, m².
    #[inline]
    pub(super) fn share(&self, thickness: f64) -> f64 {
        self.measure / D as f64 * thickness * (1.0 - self.faded)
    }

    /// Damage by opening and by sliding: the mean of its ends.
    pub(crate) fn modes(&self) -> [f64; 2] {
        [0, 1].map(|mode| self.ends.iter().map(|end| end.damages[mode]).sum::<f64>() / D as f64)
    }

    /// Mean opening and sliding, m: across it, then along it.
    /// `position`: of a node.
    pub(crate) fn gap<const N: usize>(&self, position: impl Fn(u32) -> Point<D>) -> [f64; D]
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        JointAxes::of::<N>(self.ends_at(position)).mean_gap()
    }

    /// Updates the joint and its forces. Returns the work since the last pass and, if the joint broke, the
    /// modes of its damage.
    #[inline]
    pub(super) fn pull<const N: usize>(
        &mut self,
        forces: &mut [Point<D>; D],
        solid: &Solid<D, N>,
        step: f64,
    ) -> (f64, Option<[f64; 2]>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let frame = JointAxes::new::<N>(self, solid);
        self.turn(&frame, solid);
        let share = self.share(solid.thickness);
        let (mut work, mut slid, mut least, mut whole) = (0.0, [0.0; D], f64::INFINITY, false);
        let mut pressed = false;
        for (end, [a, b]) in frame.ends.into_iter().enumerate() {
            if !self.open[end] {
                whole = true;
                continue;
            }
            let apart = minus(b, a);
            let rate = self.rate(end, solid);
            let gap = frame.components(apart);
            if self.ends[end].damage() >= 1.0 {
                let far = dot(apart, apart) > (APART * self.length) * (APART * self.length);
                self.detached[end] = far || (self.detached[end] && gap[0] < 0.0);
            }
            let traction = if self.detached[end] {
                [0.0; D]
            } else {
                least = least.min(gap[0]);
                let traction = self.ends[end].traction(&self.law, gap);
                // The damage may have grown.
                self.left[end] = 0.0;
                pressed |= traction[0] < 0.0;
                traction
            };
            let force = frame.vector(traction).map(|x| share * x);
            // Work of the last force in the second half of its step, and of the new force in the first half
            // of its step.
            work += 0.5 * step * (dot(forces[end], rate) + dot(force, rate));
            forces[end] = force;
            for axis in 1..D {
                slid[axis] += gap[axis] / D as f64;
            }
        }
        let is_detached = self.detached != [false; D] && !whole;
        let broken = self.ends.iter().all(|end| end.damage() >= 1.0) && !whole;
        let before = self.faded;
        let mut modes = None;
        match self.state {
            JointState::Holding if is_detached || broken => {
                self.state = JointState::Broken;
                modes = Some(self.modes());
                if is_detached {
                    work -= self.leave(forces, solid, step);
                }
            }
            JointState::Broken => {
                self.faded = self.faded.max(faded_at(slid, self.length).clamp(0.0, 1.0));
                // Neither the joint nor the contact has a force while the joint is open, so it can hand over
                // in one step. One that was inserted under pressure still presses when its gap is 0: it waits
                // until it does not.
                if (least >= 0.0 && !pressed) || self.faded >= 1.0 || is_detached {
                    work -= self.leave(forces, solid, step);
                }
            }
            JointState::Holding | JointState::Removed => {}
        }
        let fading = self.faded - before;
        // Joints seldom fade: an unchanged value is not written, so that whole joints are only read.
        if fading != self.fading {
            self.fading = fading;
        }
        (work, modes)
    }

    /// Lets an intrinsic joint that leaves its elastic range represent the plane that its elements fail on:
    /// see `joints/plane.rs`. It softens from the traction that it has, so that no force jumps.
    fn turn<const N: usize>(&mut self, frame: &JointAxes<D>, solid: &Solid<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Some(elements) = self.beside else { return };
        let law = self.law;
        if !self.holds() || law.normal[0] != 1.0 || !self.ends.iter().all(|end| end.is_whole(&law)) {
            return;
        }
        let bonds = |end: usize| {
            let [a, b] = frame.ends[end];
            minus(frame.components(minus(b, a)), self.ends[end].origin)
        };
        let loaded: Vec<[f64; D]> =
            (0..D).filter(|&end| self.open[end]).map(bonds).filter(|bond| !law.of_whole(*bond).1).collect();
        if loaded.is_empty() {
            return;
        }
        let facet = frame.ends.map(|[a, b]| plus(a, b));
        let plane = plane_of::<D, N>(&facet, &mean_stress_of(solid, elements), &law.strength());
        if plane.normal[0] == 1.0 {
            return;
        }
        let on_plane = law.on(JointPlane { excess: 1.0, ..plane });
        let used = loaded.iter().map(|bond| on_plane.use_of_bond(*bond)).fold(0.0, f64::max);
        if used > 0.0 {
            self.plane = JointPlane { excess: 1.0 / used, ..plane };
            self.law = law.on(self.plane);
        }
    }

    /// Elastic energy, J, of its ends that can open, at the positions of the last [`Joint::pull`].
    pub(super) fn elastic<const N: usize>(&self, solid: &Solid<D, N>) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if self.state == JointState::Removed {
            return 0.0;
        }
        let frame = JointAxes::new::<N>(self, solid);
        let share = self.share(solid.thickness);
        let of_end = |(end, [a, b]): (usize, [Point<D>; 2])| {
            if self.open[end] && !self.detached[end] {
                share * self.ends[end].elastic(&self.law, frame.components(minus(b, a)))
            } else {
                0.0
            }
        };
        frame.ends.into_iter().enumerate().map(of_end).sum()
    }

    /// Hands over to the contact of the two elements. Returns the work, J, in the first half of the step of
    /// the forces that end here.
    fn leave<const N: usize>(&mut self, forces: &mut [Point<D>; D], solid: &Solid<D, N>, step: f64) -> f64
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.faded = 1.0;
        self.state = JointState::Removed;
        let dropped = std::mem::replace(forces, [[0.0; D]; D]);
        let work = |(end, force): (usize, &Point<D>)| dot(*force, self.rate(end, solid));
        0.5 * step * dropped.iter().enumerate().map(work).sum::<f64>()
    }

    /// The positions of the nodes of its ends, m. `position`: of a node.
    #[inline]
    fn ends_at(&self, position: impl Fn(u32) -> Point<D>) -> [[Point<D>; 2]; D] {
        self.nodes.map(|end| end.map(&position))
    }

    /// Velocity of side 1 of an end less that of side 0, m/s.
    #[inline]
    fn rate<const N: usize>(&self, end: usize, solid: &Solid<D, N>) -> Point<D>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let [a, b] = self.nodes[end].map(|node| solid.velocity(node as usize));
        minus(b, a)
    }
}

/// Position and direction of a joint.
pub(crate) struct JointAxes<const D: usize> {
    /// Positions of the nodes of each end, m.
    pub(super) ends: [[Point<D>; 2]; D],
    /// Unit vectors: the outward normal of side 0, and directions along the joint.
    pub(crate) axes: Matrix<D>,
}

impl<const D: usize> JointAxes<D> {
    #[inline]
    pub(super) fn new<const N: usize>(joint: &Joint<D>, solid: &Solid<D, N>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        Self::of::<N>(joint.ends_at(|node| solid.position(node as usize)))
    }

    /// The axes of a joint with these positions of the nodes of its ends, m.
    #[inline]
    pub(crate) fn of<const N: usize>(ends: [[Point<D>; 2]; D]) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        // The facet half way between the two sides, in twice its size.
        let sum = ends.map(|[a, b]| std::array::from_fn(|axis| a[axis] + b[axis]));
        Self { ends, axes: <[[f64; D]; N]>::unit_axes(&sum) }
    }

    /// Mean opening and sliding of the ends, m: across the joint, then along it.
    pub(crate) fn mean_gap(&self) -> [f64; D] {
        let mut mean = [0.0; D];
        for [a, b] in self.ends {
            add(&mut mean, self.components(minus(b, a)), 1.0 / D as f64);
        }
        mean
    }

    /// Components of a vector across the joint and along it.
    #[inline]
    pub(super) fn components(&self, vector: Point<D>) -> [f64; D] {
        self.axes.map(|axis| dot(vector, axis))
    }

    /// The vector with these components.
    #[inline]
    pub(super) fn vector(&self, components: [f64; D]) -> Point<D> {
        std::array::from_fn(|axis| {
            let mut sum = components[0] * self.axes[0][axis];
            for k in 1..D {
                sum += components[k] * self.axes[k][axis];
            }
            sum
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cohesive::tests::ROCK;
    use crate::joints::Joints;
    use crate::laws::MaterialLaw;
    use crate::model::{Material, Model};
    use crate::team::Team;
    use crate::topology::Topology;
    use fdem_mesh::Mesh;

    fn two_triangles() -> (Model, Topology) {
        let material = Material {
            name: String::new(),
            density: 2700.0,
            youngs_modulus: 30e9,
            poissons_ratio: 0.2,
            law: MaterialLaw::NeoHookean,
            damping: 0.0,
            strength: Some(ROCK),
            friction: 0.0,
        };
        let mesh = Mesh {
            nodes: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]],
            elements: vec![[0, 1, 2], [0, 2, 3]],
            bodies: vec![0; 2],
            materials: vec![0; 2],
        };
        let model = Model { mesh, materials: vec![material], ..Model::default() };
        let topology = Topology::of(&model.mesh).expect("a mesh");
        (model, topology)
    }

    /// Two elements that turn about one end of a joint, while its other end is broken, may turn so far that
    /// the frame of the joint is reversed.
    #[test]
    fn a_broken_end_that_came_round_does_not_press() {
        let (model, topology) = two_triangles();
        let mut solid = Solid::new(&model);
        let mut joints = Joints::new(&model, &topology, solid.share());
        joints.everywhere(&model, &topology).expect("enough energy");
        joints.part(&[0, 1, 2, 3], &mut solid, false, &model, &topology, &Team::ALONE);
        // The upper end has turned far; the lower end is like a hinge.
        let joint = &mut joints.all[0];
        let end = usize::from(solid.vertex(joint.nodes[0][0] as usize) != 2);
        joint.open[1 - end] = false;
        joint.ends[end] = Memory::broken();
        let [a, b] = joint.nodes[end];
        for (node, place) in [(a, [0.9, -0.5]), (b, [-0.9, -0.5])] {
            solid.set_position(node as usize, place);
        }
        let mut forces = [[0.0; 2]; 2];
        let (_, modes) = joint.pull(&mut forces, &solid, 1e-6);
        assert_eq!((forces, modes), ([[0.0; 2]; 2], None));
        // At a small distance the end presses only if it was open before.
        let mut at = |x: f64| {
            for (node, place) in [(a, [x, 1.0]), (b, [-x, 1.0])] {
                solid.set_position(node as usize, place);
            }
            let mut forces = [[0.0; 2]; 2];
            joints.all[0].pull(&mut forces, &solid, 1e-6);
            forces
        };
        assert_eq!([at(-0.01), at(0.01)], [[[0.0; 2]; 2]; 2]);
        let forces = at(-0.01);
        assert!(forces[end].iter().any(|force| force.abs() > 1.0), "{forces:?}");
    }

    /// If both ends have two nodes, a joint breaks as a whole when one end has opened far, and hands over to
    /// contact.
    #[test]
    fn a_joint_that_opens_as_a_hinge_is_broken_at_both_ends() {
        let (model, topology) = two_triangles();
        let mut solid = Solid::new(&model);
        let mut joints = Joints::new(&model, &topology, solid.share());
        joints.everywhere(&model, &topology).expect("enough energy");
        joints.part(&[0, 1, 2, 3], &mut solid, false, &model, &topology, &Team::ALONE);
        let joint = &mut joints.all[0];
        joint.ends[0] = Memory::broken();
        let [a, b] = joint.nodes[0];
        let [x, y] = solid.position(a as usize);
        for (node, shift) in [(a, 0.3), (b, -0.3)] {
            solid.set_position(node as usize, [x + shift, y]);
        }
        let mut forces = [[1.0; 2]; 2];
        let (_, modes) = joint.pull(&mut forces, &solid, 1e-6);
        assert!(modes.is_some());
        assert_eq!(
            (joint.state, joint.faded, joint.fading, forces),
            (JointState::Removed, 1.0, 1.0, [[0.0; 2]; 2])
        );
    }
}
