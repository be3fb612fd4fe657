//! The snapshot of a run, its forces and its cracks, for results.

use std::collections::BTreeMap;

use fdem_grains::{GrainRun, SphereColumns};

use crate::compiled::compiled;
use crate::forces::{ContactForce, Forces, OwnForces};
use crate::joints::saved::JointView;
use crate::joints::{Break, Joint};
use crate::machine::{Columns, Wanted};
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::snapshot::{Crack, Mode, Snapshot, WetJoint};
use crate::sum::Sum;
use crate::vector::{Point, add, plus};

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Positions, motion, stress and cracks now.
    pub fn snapshot(&self) -> Snapshot<D, N> {
        let run = self;
        compiled!((run: reference [Simulation<2, 3>, Simulation<3, 4>])
            -> [Snapshot<2, 3>, Snapshot<3, 4>] = Simulation::own_snapshot)
    }

    /// The whole joints now, in the order of their elements: those of joint sets, and all in models that have
    /// a joint on each facet.
    pub fn intact_joints(&self) -> Vec<Crack<D>> {
        let joints = self.joints().in_order().into_iter();
        let joints = joints.map(|joint| self.joints().seen(joint, &self.topology));
        let position = |node: u32| self.solid().position(node as usize);
        intact::<D, N>(joints, position, self.solid().origin)
    }

    /// The spheres now; none if the model has none.
    pub(crate) fn spheres_now(&self) -> SphereColumns {
        self.actions.spheres.run().map_or_else(SphereColumns::default, GrainRun::columns)
    }

    fn own_snapshot(&self) -> Snapshot<D, N> {
        let order = self.solid().order(&self.topology);
        let nodes = || order.iter().map(|&node| node as usize);
        let elements = self.solid().element_count();
        let joints =
            self.joints().in_order().into_iter().map(|joint| self.joints().seen(joint, &self.topology));
        let position = |node: u32| self.solid().position(node as usize);
        let (damage, cracks) = cracks::<D, N>(joints, position, self.solid().origin, elements);
        Snapshot {
            step: self.step,
            time: self.time(),
            positions: nodes().map(|node| self.solid().place(self.solid().position(node))).collect(),
            displacements: nodes().map(|node| self.solid().displacement(node, &self.model)).collect(),
            velocities: nodes().map(|node| self.solid().velocity(node)).collect(),
            elements: self.solid().in_order(&order),
            stresses: (0..elements).map(|element| self.solid().stress_tensor(element)).collect(),
            damage,
            bodies: self.model.mesh.bodies.clone(),
            materials: self.model.mesh.materials.clone(),
            fragments: self.fragments(),
            cracks,
            intact: None,
            strengths: self.model.materials.iter().map(|material| material.strength).collect(),
            laws: self.model.materials.iter().map(|material| material.law.clone()).collect(),
            spheres: self.spheres_now(),
            fluid: self.wet_joints(),
            pore_pressures: self.pore_pressures(&order),
        }
    }

    /// Pressure of the liquid in pores at these nodes; `None` without pores.
    fn pore_pressures(&self, nodes: &[u32]) -> Option<Vec<Option<f64>>> {
        let matrix = self.pores()?;
        let of = |&node: &u32| {
            let vertex = self.solid().vertex(node as usize) as usize;
            (matrix.storages()[vertex] > 0.0).then(|| matrix.pressures()[vertex])
        };
        Some(nodes.iter().map(of).collect())
    }

    /// The joints that fluid can enter now, by ascending elements; `None` without a fluid.
    pub(crate) fn wet_joints(&self) -> Option<Vec<WetJoint>> {
        let network = self.fluid()?;
        let columns = [network.pressures(), network.apertures(), network.saturations()];
        let of = |(cell, [a, b]): (usize, [u32; 2])| {
            let [pressure, aperture, saturation] = columns.each_ref().map(|column| column[cell]);
            WetJoint { elements: [a.min(b), a.max(b)], pressure, aperture, saturation }
        };
        let mut wet: Vec<WetJoint> = self.fluid_joints().into_iter().enumerate().map(of).collect();
        wet.sort_unstable_by_key(|of| of.elements);
        Some(wet)
    }

    /// Total lengths of joints that broke by opening, by sliding, and by both, m. Joints of sets that are
    /// open from the beginning are not among them.
    pub fn crack_lengths(&self) -> [f64; 3] {
        self.lengths_of_cracks(|_| true).map(|length| length.value())
    }

    /// Sums of the lengths of the joints that the run has broken and that are `counted`, by mode.
    pub(crate) fn lengths_of_cracks(&self, counted: impl Fn(u32) -> bool) -> [Sum; 3] {
        let cracked =
            |(number, joint, _): &(u32, &Joint<D>, &Break)| !joint.open_from_start && counted(*number);
        self.looked_at(&Wanted::default(), |Columns { joints, .. }| {
            let mut lengths = [(); 3].map(|()| Sum::default());
            for (_, joint, broken) in joints.breaks().filter(cracked) {
                lengths[mode(broken.modes) as usize].add(joint.measure);
            }
            lengths
        })
    }

    /// Fragment of each element: elements that hang together by facets have one number, from 0 in the order
    /// of the first element of each fragment. The fragments change only when joints part: see
    /// [`Counts::parted`](crate::Counts::parted). Linear in the number of elements.
    pub fn fragments(&self) -> Vec<u32> {
        let run = self;
        compiled!((run: reference [Simulation<2, 3>, Simulation<3, 4>])
            -> [Vec<u32>, Vec<u32>] = Simulation::own_fragments)
    }

    fn own_fragments(&self) -> Vec<u32> {
        self.looked_at(&Wanted::default(), |Columns { joints, .. }| {
            self.topology.pieces(|facet| joints.holds(facet))
        })
    }

    /// Forces of contacts and boundaries at the beginning of the last step.
    pub fn forces(&self) -> Forces<D> {
        let run = self;
        compiled!((run: reference [Simulation<2, 3>, Simulation<3, 4>])
            -> [Forces<2>, Forces<3>] = Simulation::forces_now)
    }

    fn forces_now(&self) -> Forces<D> {
        let order = self.solid().order(&self.topology);
        let codes = order.into_iter().map(|node| self.solid().corners(node as usize)[0]);
        self.own_forces().placed(codes, self.solid().origin)
    }

    /// The forces that this rank counts.
    pub(crate) fn own_forces(&self) -> OwnForces<D> {
        let numbered = |force: ContactForce<D>| ContactForce {
            elements: force.elements.map(|element| self.topology.number(element)),
            ..force
        };
        let counted = |force: &ContactForce<D>| self.solid().share().element(force.elements[0]);
        let contacts = self.contacts().forces(self.solid(), self.joints(), &self.topology);
        let contacts = contacts.into_iter().filter(counted).map(numbered);
        let joints = self.joints().pressing(self.solid(), &self.topology).into_iter().map(numbered);
        let applied = self.actions.applied(self.solid());
        let applied = applied.map(|([_, corner], force)| (self.solid().node_at(corner), force));
        let mut reactions = BTreeMap::new();
        for (node, force) in self.held.iter().copied().chain(applied) {
            add(reactions.entry(node).or_insert([0.0; D]), force, 1.0);
        }
        let code = |node: u32| self.topology.code_of_corner(self.solid().corners(node as usize)[0]);
        OwnForces {
            contacts: contacts.collect(),
            joints: joints.collect(),
            reactions: reactions.into_iter().map(|(node, force)| (code(node), force)).collect(),
        }
    }
}

/// The largest damage of the joints of each element but those of open sets, and the joints that are damaged.
/// `joints`: all of them in order; `position`: of a node that the joints name; `origin`: of these positions.
pub(crate) fn cracks<'a, const D: usize, const N: usize>(
    joints: impl Iterator<Item = JointView<'a, D>>,
    position: impl Fn(u32) -> Point<D> + Copy,
    origin: Point<D>,
    elements: usize,
) -> (Vec<f64>, Vec<Crack<D>>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut damage = vec![0.0_f64; elements];
    let mut cracks = Vec::new();
    for seen in joints {
        let of_joint = seen.joint.damage();
        let open = seen.joint.open_from_start;
        for element in seen.elements.into_iter().filter(|_| !open) {
            let damage = &mut damage[element as usize];
            *damage = damage.max(of_joint);
        }
        if of_joint > 0.0 || open {
            cracks.push(crack::<D, N>(&seen, of_joint, position, origin));
        }
    }
    (damage, cracks)
}

/// The joints that are whole. The arguments are those of [`cracks`].
pub(crate) fn intact<'a, const D: usize, const N: usize>(
    joints: impl Iterator<Item = JointView<'a, D>>,
    position: impl Fn(u32) -> Point<D> + Copy,
    origin: Point<D>,
) -> Vec<Crack<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let whole = joints.filter(|seen| !seen.joint.open_from_start && seen.joint.damage() == 0.0);
    whole.map(|seen| crack::<D, N>(&seen, 0.0, position, origin)).collect()
}

fn crack<const D: usize, const N: usize>(
    seen: &JointView<'_, D>,
    damage: f64,
    position: impl Fn(u32) -> Point<D> + Copy,
    origin: Point<D>,
) -> Crack<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let corner = |end: usize| {
        let [a, b] = seen.joint.nodes[end].map(position);
        plus(std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis])), origin)
    };
    let gap = seen.joint.gap::<N>(position);
    let modes = seen.broken.map_or_else(|| seen.joint.modes(), |(_, modes)| modes);
    Crack {
        corners: std::array::from_fn(corner),
        elements: seen.elements,
        damage,
        mode: mode(modes),
        opening: gap[0],
        sliding: <[[f64; D]; N]>::sliding(&gap),
        time: if seen.joint.open_from_start { Some(0.0) } else { seen.broken.map(|(time, _)| time) },
        softens: Some(seen.joint.softens).filter(|time| time.is_finite() && !seen.joint.open_from_start),
        dissipated: seen.joint.dissipated(),
        measure: seen.measure,
        open_from_start: seen.joint.open_from_start,
    }
}

/// Mode of failure of a joint from its damage by opening and by sliding.
pub(crate) fn mode(damages: [f64; 2]) -> Mode {
    let opening = damages[0] / (damages[0] + damages[1]).max(f64::MIN_POSITIVE);
    if opening >= 0.75 {
        Mode::Tension
    } else if opening <= 0.25 {
        Mode::Shear
    } else {
        Mode::Mixed
    }
}
