//! A run that continues with a changed model: elements vanish or appear, boundaries and materials change.
//!
//! The vanishing elements or boundaries have held the rest. The forces are the difference between those on
//! each node in the model before and in the model from now on, at the same state. They continue to act on the
//! surface, with a factor in time: at 1 the rest stays unchanged, and as the factor falls to 0 they are
//! released.
//!
//! The energy of vanishing parts leaves the balance: it counts as external work, with its sign.

use std::collections::BTreeMap;

use crate::compiled::compiled;
use crate::contacts::Touching;
use crate::critical::{Cause, CriticalStep};
use crate::energy::Ledger;
use crate::error::ModelError;
use crate::forces::Reaction;
use crate::joints::saved::{MovingJoint, SavedJoints};
use crate::machine::Columns;
use crate::machine::list::Machines;
use crate::model::{Boundary, Load, Model, Schedule, Target};
use crate::motion::nodes::force_on;
use crate::peers::Alone;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::simulation::saved::State;
use crate::subset::Subset;
use crate::sum::Sum;
use crate::topology::NONE;
use crate::vector::{Point, add, dot, minus};

/// How a run continues: see [`State::changed`].
#[derive(Clone, Debug)]
pub struct Change<const D: usize = 2, const N: usize = 3> {
    /// The model from now on. Its time step is that of the run so far, whatever its options say.
    pub model: Model<D, N>,
    /// For each element of the model, its number in the model before; `None` for one that appears. The
    /// numbers ascend.
    pub elements: Vec<Option<u32>>,
    /// Name and factor in time, from now on, of a boundary with the forces of all vanishing parts; `None` if
    /// they vanish in one step.
    pub release: Option<(String, Schedule)>,
}

impl<const D: usize, const N: usize> Change<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The change in which elements vanish: those of `model` for which `keep` is not true.
    ///
    /// # Errors
    /// The errors of [`Model::keeping`].
    pub fn excavating(
        model: &Model<D, N>,
        keep: &[bool],
        release: Option<(String, Schedule)>,
    ) -> Result<Self, ModelError> {
        let Subset { model, elements, .. } = model.keeping(keep)?;
        Ok(Self { model, elements: elements.into_iter().map(Some).collect(), release })
    }
}

impl<const D: usize, const N: usize> State<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// The model and the state with which a run of the model `before` continues after a change. `threads`:
    /// see [`Simulation::new`].
    ///
    /// An element that appears is in the state in which a run of the new model would begin. It has no node in
    /// common with one that stays.
    ///
    /// # Cost
    /// Four times the cost of [`Simulation::new`].
    ///
    /// # Errors
    /// The errors of [`Simulation::new`]; [`ModelError::Length`] and [`ModelError::Missing`] if the elements
    /// are not those of the two models; [`ModelError::OutOfRange`] if the time step is too long for the new
    /// model.
    pub fn changed(
        self,
        before: &Model<D, N>,
        change: Change<D, N>,
        threads: usize,
    ) -> Result<(Model<D, N>, Self), ModelError> {
        let state = self;
        compiled!((state: value [State<2, 3>, State<3, 4>], before: reference [Model<2, 3>, Model<3, 4>],
            change: value [Change<2, 3>, Change<3, 4>], threads: as_is [usize, usize])
            -> [Result<(Model<2, 3>, State<2, 3>), ModelError>, Result<(Model<3, 4>, State<3, 4>), ModelError>]
            = State::after)
    }

    fn after(
        self,
        before: &Model<D, N>,
        change: Change<D, N>,
        threads: usize,
    ) -> Result<(Model<D, N>, Self), ModelError> {
        let Change { mut model, elements, release } = change;
        let mut old = Simulation::resume(before.clone(), self.clone(), threads)?;
        let numbers = Numbers::new(elements, before.mesh.elements.len(), &model)?;
        model.time.step = Some(old.time_step());
        let released: Vec<_> = self
            .released
            .iter()
            .filter_map(|&(element, stress)| Some((numbers.now(element)?, stress)))
            .collect();
        let mut bodies = released.iter().map(|(element, _)| model.mesh.bodies[*element as usize]);
        if let Some(body) = bodies.find(|&body| model.stays_rigid(body)) {
            return Err(ModelError::UntilOverloaded {
                body,
                why: "it has been overloaded, and cannot be rigid now",
            });
        }
        let now = model.clone().releasing(released.iter().map(|(element, _)| *element));
        let fresh = Simulation::new(now, threads)?;
        numbers.check_rigid(&old, &fresh)?;
        let CriticalStep { step, cause, .. } = fresh.critical_step();
        // The step of spheres follows their impacts; a run stops where it is not stable.
        let longest = if cause == Cause::Sphere { 2.0 * step } else { step };
        if longest < old.time_step() {
            return Err(ModelError::OutOfRange {
                place: "the changed model".to_owned(),
                what: "time step",
                value: old.time_step(),
                range: "at most the critical one",
            });
        }
        let state = State { released, ..numbers.carry(self, &old, &fresh)? };
        let mut new = Simulation::resume(model.clone(), state, threads)?;
        // Places that the new model does not have keep nothing.
        for record in old.records() {
            if let Some(record) = record.renumbered::<N>(|element| numbers.now(element)) {
                new.take_record(&record);
            }
        }
        new.begin_actions()?;
        // Elements may have hung together by vanished ones alone.
        let vertices: Vec<u32> = (0..new.topology.vertex_count() as u32).collect();
        let Columns { solid, joints, .. } = new.machine.columns_mut();
        joints.part(&vertices, solid, false, &new.model, &new.topology, &new.team);
        // The energies of joints that vanish and appear stay where the balance has them: in no column of the
        // dissipated energy.
        let elastic = |run: &Simulation<D, N>| run.joints().elastic(run.solid(), &run.team);
        new.machine.columns_mut().joints.take_inserted();
        new.totals.inserted.add_sum(&elastic(&new));
        new.totals.inserted.subtract(&elastic(&old));
        let mut state = new.state();
        let (had, has) = (old.look(), new.look());
        state.totals.external.add_sum(&has.energy);
        state.totals.external.subtract(&had.energy);
        if let Some((name, schedule)) = release {
            let lost = numbers.lost(&old, &had.forces, &new, &has.forces);
            let (facets, forces) = new.spread_over_surface(&lost);
            if !facets.is_empty() {
                model.boundaries.push(Boundary {
                    name,
                    target: Target::Held(facets, forces),
                    load: Load::Held,
                    schedule: Schedule::From(new.time(), Box::new(schedule)),
                });
                state.reactions.push(Reaction::default());
            }
        }
        Ok((model, state))
    }
}

/// Forces on nodes, and energies, at a state.
pub(super) struct ForcesAndEnergy<const D: usize> {
    /// Force on each node, without the reaction of its supports, N.
    forces: Vec<Point<D>>,
    /// Energies that are not summed up over the steps, J.
    pub(super) energy: Sum,
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// Looks at the forces of the next step. The run must not continue after that.
    pub(super) fn look(&mut self) -> ForcesAndEnergy<D> {
        let kinetic = self.kinetic_of_half_step();
        // A reason to stop is found again in the next step.
        let _ = self.press(true, &Alone);
        // At the time of the positions, the velocity of a node has changed by half a step of its forces;
        // those of loads have their work of that half step.
        let impulses = self.impulses_of_half_step();
        let factor = self.model.gravity_schedule.factor(self.time());
        let Columns { solid, joints, .. } = self.machine.columns();
        let force = |node: usize| {
            let mut force = force_on(node, solid, joints);
            let weight = factor * solid.true_mass(node);
            add(&mut force, self.model.gravity, weight);
            force
        };
        let forces = (0..solid.node_count()).map(force).collect();
        let [mut energy, viscous] = self.machine.energies();
        let mut of_actions = Ledger::default();
        self.actions.add_energies(&self.scene(), &mut of_actions);
        let contact = self.touching.energy.clone().unwrap_or_default();
        // The next step has the first half of the works of the forces now: another mass changes the damping.
        let Touching { friction, damping, handed_over, relaxed, .. } = &self.touching;
        for part in [&kinetic, &impulses, &viscous, &contact, &of_actions.used(), friction, damping] {
            energy.add_sum(part);
        }
        energy.subtract(handed_over);
        energy.subtract(relaxed);
        ForcesAndEnergy { forces, energy }
    }

    /// Works in half a step of the forces on nodes, without those of loads, J.
    fn impulses_of_half_step(&self) -> Sum {
        let mut by_loads: BTreeMap<u32, Point<D>> = BTreeMap::new();
        for ([_, corner], force) in self.actions.applied(self.solid()) {
            let node = self.solid().node_at(corner);
            add(by_loads.entry(node).or_insert([0.0; D]), force, 1.0);
        }
        let of = |node: usize| {
            let force = force_on(node, self.solid(), self.joints());
            let loads = by_loads.get(&(node as u32)).copied().unwrap_or([0.0; D]);
            0.5 * self.scales.time_step * dot(minus(force, loads), self.solid().velocity(node))
        };
        (0..self.solid().node_count()).map(of).collect()
    }

    /// Forces on nodes, as forces on the nodes of facets on the surface, which share them by their sizes. A
    /// node that is not on the surface has none.
    #[allow(clippy::type_complexity, reason = "two columns, named where they are used")]
    fn spread_over_surface(&self, forces: &[Point<D>]) -> (Vec<[u32; D]>, Vec<[Point<D>; D]>) {
        let vertices = |side: &[u32; D]| side.map(|corner| self.topology.vertices[corner as usize]);
        let measure = |side: &[u32; D]| {
            let places = vertices(side).map(|vertex| self.model.mesh.nodes[vertex as usize]);
            <[[f64; D]; N]>::facet_measure(&places)
        };
        let nodes = |side: &[u32; D]| side.map(|corner| self.solid().node_at(corner) as usize);
        let mut widths = vec![0.0; forces.len()];
        let outer = &self.joints().faces.outer;
        for &side in outer {
            for node in nodes(&side) {
                widths[node] += measure(&side);
            }
        }
        let shares = |side: [u32; D]| {
            let part = |node: usize| forces[node].map(|force| force * measure(&side) / widths[node]);
            (vertices(&side), nodes(&side).map(part))
        };
        let all = outer.iter().copied().map(shares);
        all.filter(|(_, forces)| forces.as_flattened().iter().any(|force| *force != 0.0)).unzip()
    }
}

/// The numbers of elements before and after a change.
struct Numbers {
    /// Number of each element before the change; `None` for one that appears.
    before: Vec<Option<u32>>,
    /// Number of each earlier element after the change; `None` for one that has vanished.
    after: Vec<Option<u32>>,
}

impl Numbers {
    fn new<const D: usize, const N: usize>(
        before: Vec<Option<u32>>,
        count: usize,
        model: &Model<D, N>,
    ) -> Result<Self, ModelError> {
        let expected = model.mesh.elements.len();
        if before.len() != expected {
            return Err(ModelError::Length { what: "elements before", found: before.len(), expected });
        }
        let mut after = vec![None; count];
        let mut next = 0;
        for (new, old) in (0..).zip(&before).filter_map(|(new, old)| Some((new, (*old)?))) {
            if old < next || old as usize >= count {
                let place = "the elements before, which ascend".to_owned();
                return Err(ModelError::Missing { what: "element", index: old, place });
            }
            next = old + 1;
            after[old as usize] = Some(new);
        }
        let mut stays = vec![None; model.mesh.nodes.len()];
        for (nodes, old) in model.mesh.elements.iter().zip(&before) {
            for &node in nodes {
                if *stays[node as usize].get_or_insert(old.is_some()) != old.is_some() {
                    let place = "both an element that stays and one that appears".to_owned();
                    return Err(ModelError::Missing {
                        what: "node of its own instead of",
                        index: node,
                        place,
                    });
                }
            }
        }
        Ok(Self { before, after })
    }

    /// A rigid body appears, stays or vanishes as a whole.
    fn check_rigid<const D: usize, const N: usize>(
        &self,
        old: &Simulation<D, N>,
        fresh: &Simulation<D, N>,
    ) -> Result<(), ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let known = &old.solid().rigid;
        for body in &fresh.solid().rigid.all {
            let before = |element: &u32| self.before[*element as usize];
            let of = body.elements.iter().map(|element| before(element).map(|old| known.of_element(old)));
            let mut of = of.collect::<Vec<_>>();
            of.dedup();
            let stays =
                |body_before: u32| known.all[body_before as usize].elements.len() == body.elements.len();
            match of[..] {
                [None] => {}
                [Some(Some(body_before))] if stays(body_before) => {}
                _ => {
                    let place = "the changed model, in which it was another body before".to_owned();
                    return Err(ModelError::Missing {
                        what: "rigid body with element",
                        index: body.elements[0],
                        place,
                    });
                }
            }
        }
        Ok(())
    }

    /// The number now of an element before.
    fn now(&self, element: u32) -> Option<u32> {
        self.after[element as usize]
    }

    /// The state of the elements that stay, and that of the others at the beginning of a run of the new
    /// model, `fresh`.
    fn carry<const D: usize, const N: usize>(
        &self,
        state: State<D, N>,
        old: &Simulation<D, N>,
        fresh: &Simulation<D, N>,
    ) -> Result<State<D, N>, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut new = fresh.state();
        let mut nodes = Vec::new();
        let mut numbers = [vec![NONE; state.nodes.len()], vec![NONE; new.nodes.len()]];
        for (element, before) in self.before.iter().enumerate() {
            let (from, corners, numbers) = match before {
                Some(old) => (&state.nodes, state.of_corner[*old as usize], &mut numbers[0]),
                None => (&new.nodes, new.of_corner[element], &mut numbers[1]),
            };
            new.of_corner[element] = corners.map(|node| {
                let number = &mut numbers[node as usize];
                if *number == NONE {
                    *number = nodes.len() as u32;
                    nodes.push(from[node as usize]);
                }
                *number
            });
            let Some(number) = before.map(|old| old as usize) else { continue };
            new.stresses[element] = state.stresses[number];
            new.viscous[element] = state.viscous[number];
            if let (Some(new), Some(old)) = (new.dissipated.get_mut(element), state.dissipated.get(number)) {
                *new = *old;
            }
            // An element of another material begins with a memory of its law.
            let materials = [old.model.mesh.materials[number], fresh.model.mesh.materials[element]];
            if old.solid().memory == fresh.solid().memory && materials[0] == materials[1] {
                let length = old.solid().memory;
                let from = &state.memories[number * length..][..length];
                new.memories[element * length..][..length].copy_from_slice(from);
            }
        }
        let of = |run: &Simulation<D, N>| -> Vec<MovingJoint<D>> {
            run.joints()
                .in_order()
                .into_iter()
                .map(|joint| run.joints().moving(joint, &run.topology))
                .collect()
        };
        let appears = |element: u32| self.before[element as usize].is_none().then_some(element);
        let stay = of(old).into_iter().filter_map(|joint| joint.renumbered::<N>(|element| self.now(element)));
        let appear = of(fresh).into_iter().filter_map(|joint| joint.renumbered::<N>(appears));
        let reaction = |boundary: &Boundary<D>| {
            let same = old.model.boundaries.iter().position(|other| other.name == boundary.name);
            same.map_or_else(Reaction::default, |same| state.reactions[same])
        };
        let factor = |(boundary, factor): (u32, f64)| {
            let name = &old.model.boundaries[boundary as usize].name;
            let same = fresh.model.boundaries.iter().position(|other| other.name == *name);
            same.map(|same| (same as u32, factor))
        };
        let mut contacts = state.contacts.renumbered(|element| self.now(element));
        contacts.add_new(&new.contacts, |element| self.before[element as usize].is_none());
        let material = |number: u32| {
            let name = &old.model.materials.get(number as usize)?.name;
            let same = fresh.model.materials.iter().position(|other| other.name == *name)?;
            Some(same as u32)
        };
        let spheres = match (state.spheres, &old.model.grains, &fresh.model.grains) {
            // Spheres that are there already continue, and others begin.
            (Some(spheres), Some(before), Some(now)) => {
                let spheres = spheres.in_model(before, now, material)?;
                Some(spheres.renumbered::<N>(|element| self.now(element)))
            }
            _ => new.spheres,
        };
        Ok(State {
            factors: state.factors.into_iter().filter_map(factor).collect(),
            records: Vec::new(),
            spheres,
            step: state.step,
            totals: state.totals,
            energies: state.energies,
            reactions: fresh.model.boundaries.iter().map(reaction).collect(),
            nodes,
            joints: SavedJoints::of(stay.chain(appear).collect()),
            contacts,
            ..new
        })
    }

    /// The forces that the nodes of the new model have lost, N: with them they would be accelerated as
    /// before. `had`, `has`: forces on the nodes of the two.
    fn lost<const D: usize, const N: usize>(
        &self,
        old: &Simulation<D, N>,
        had: &[Point<D>],
        new: &Simulation<D, N>,
        has: &[Point<D>],
    ) -> Vec<Point<D>>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let holds = |run: &Simulation<D, N>, node: usize| match run.solid().hold(node) {
            NONE => [false; D],
            hold => run.actions.prescribed.holds[hold as usize].map(|hold| hold.is_some()),
        };
        let lost = |node: usize| {
            let corner = new.solid().corners(node)[0];
            let Some(element) = self.before[corner as usize / N] else { return [0.0; D] };
            let before = old.solid().node_at(element * N as u32 + corner % N as u32) as usize;
            let share = new.solid().true_mass(node) / old.solid().true_mass(before);
            let (held, holds) = (holds(old, before), holds(new, node));
            let whole = share == 1.0;
            let had: Point<D> = std::array::from_fn(|axis| match held[axis] {
                // Its support had the opposite force, as long as it was not accelerated.
                true if !holds[axis] => 0.0,
                _ if whole => had[before][axis],
                _ => share * had[before][axis],
            });
            let lost = minus(had, has[node]);
            std::array::from_fn(|axis| if holds[axis] { 0.0 } else { lost[axis] })
        };
        (0..new.solid().node_count()).map(lost).collect()
    }
}
