//! Forces and velocities that a program sets between steps. How it sets them: `src/simulation/program.rs`.
//!
//! A change of velocities is an impulse `m (v' - v)`, whose work the next step adds, once its forces are
//! known:
//!
//! ```text
//! W = m (v'² - v²) / 2 + h F·(v' - v) / 2
//! ```
//! with the force `F` of elements, joints and contacts on the node, and the time step `h`. The second term is
//! there because velocities stand half a step before positions (`motion.rs`): with it, the balance of a
//! linear system stays exact however often velocities are set.

use std::collections::BTreeMap;

use crate::action::{Acting, Action, Applied, Record, Scene};
use crate::simplex::Simplex;
use crate::topology::NONE;
use crate::vector::{Point, add, dot, minus};

/// Number of a record with a force, and of one with a velocity.
const FORCE: u32 = 0;
const VELOCITY: u32 = 1;

/// All that a program has set.
#[derive(Clone, Debug, Default)]
pub(crate) struct Program<const D: usize> {
    /// Forces on corners of elements, N.
    pub(crate) forces: BTreeMap<u32, Point<D>>,
    /// Velocities, m/s, that the program has replaced since the last step, by the first corner of the node.
    pub(crate) replaced: BTreeMap<u32, Point<D>>,
}

impl<const D: usize, const N: usize> Action<D, N> for Program<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        let on = |(&corner, &force)| Applied { corner, boundary: NONE, force, viscous: [0.0; D] };
        acting.apply(|applied| applied.extend(self.forces.iter().map(on)));
    }

    fn works(&mut self, scene: &Scene<'_, D, N>, applied: &[Applied<D>]) -> Vec<f64> {
        if self.replaced.is_empty() {
            return Vec::new();
        }
        let (solid, joints, step) = (scene.solid(), scene.joints(), scene.step);
        // Works of loads are counted with the new velocities, so that the forces of loads have no part in the
        // second term.
        let mut by_loads: BTreeMap<u32, Point<D>> = BTreeMap::new();
        for &Applied { corner, force, .. } in applied {
            add(by_loads.entry(corner).or_insert([0.0; D]), force, -1.0);
        }
        let work = |(corner, before): (u32, Point<D>)| {
            let node = solid.node_at(corner) as usize;
            let constants = solid.constants(node);
            let velocity = solid.velocity(node);
            let mut force = [0.0; D];
            for &corner in solid.corners(node) {
                add(&mut force, solid.force(corner), 1.0);
                add(&mut force, by_loads.get(&corner).copied().unwrap_or([0.0; D]), 1.0);
                if joints.at_vertex[constants.vertex as usize] {
                    joints.add_force(corner, &mut force);
                }
            }
            let impulse = 0.5 * constants.mass * (dot(velocity, velocity) - dot(before, before));
            impulse + 0.5 * step * dot(force, minus(velocity, before))
        };
        let own = std::mem::take(&mut self.replaced);
        own.into_iter().filter(|(corner, _)| solid.share().corner(*corner)).map(work).collect()
    }

    fn records(&self, scene: &Scene<'_, D, N>) -> Vec<Record> {
        let of = |place: u32, vectors: &BTreeMap<u32, Point<D>>| -> Vec<Record> {
            let own = vectors.iter().filter(|(corner, _)| scene.solid().share().corner(**corner));
            own.map(|(&corner, vector)| {
                Record::new([scene.topology.code_of_corner(corner); 2], place, vector)
            })
            .collect()
        };
        let mut records = of(FORCE, &self.forces);
        records.extend(of(VELOCITY, &self.replaced));
        records
    }

    fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let (corner, vector) = (scene.topology.corner(record.codes[0]), record.value(&[0.0; D]));
        let (Some(corner), Some(vector)) = (corner, vector) else { return false };
        let vectors = if record.place == VELOCITY { &mut self.replaced } else { &mut self.forces };
        vectors.insert(corner, vector);
        true
    }
}
