//! The state of a run, which is saved and from which it is resumed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::action::Record;
use crate::actions::spheres::SavedSpheres;
use crate::compiled::compiled;
use crate::contacts::SavedContacts;
use crate::energy::Energies;
use crate::error::ModelError;
use crate::forces::Reaction;
use crate::joints::Joint;
use crate::joints::saved::SavedJoints;
use crate::machine::Columns;
use crate::machine::list::Machines;
use crate::model::Model;
use crate::simplex::Simplex;
use crate::simulation::run::Simulation;
use crate::simulation::totals::Totals;
use crate::solid::Node;
use crate::team::Team;
use crate::vector::Matrix;

/// State of a run, without its model. A run that is resumed from it continues as if it had never stopped.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[f64; D]: Serialize, [u32; N]: Serialize, [[f64; D]; D]: Serialize, Joint<D>: Serialize, [f64; N]: Serialize, SavedContacts<D, N>: Serialize, SavedJoints<D>: Serialize, SavedSpheres<D>: Serialize",
    deserialize = "[f64; D]: Deserialize<'de>, [u32; N]: Deserialize<'de>, [[f64; D]; D]: Deserialize<'de>, Joint<D>: Deserialize<'de>, [f64; N]: Deserialize<'de>, SavedContacts<D, N>: Deserialize<'de>, SavedJoints<D>: Deserialize<'de>, SavedSpheres<D>: Deserialize<'de>"
))]
pub struct State<const D: usize = 2, const N: usize = 3> {
    pub(crate) step: u64,
    pub(crate) totals: Totals,
    pub(crate) energies: Energies,
    pub(crate) reactions: Vec<Reaction<D>>,
    /// In the order of results: see [`Snapshot`](crate::Snapshot).
    pub(crate) nodes: Vec<Node<D>>,
    pub(crate) of_corner: Vec<[u32; N]>,
    pub(crate) stresses: Vec<Matrix<D>>,
    pub(crate) viscous: Vec<Matrix<D>>,
    pub(crate) dissipated: Vec<f64>,
    /// Memories of the laws of the material in the elements, one after the other; empty if no law keeps
    /// anything.
    pub(crate) memories: Vec<f64>,
    pub(crate) joints: SavedJoints<D>,
    pub(crate) contacts: SavedContacts<D, N>,
    /// Factors of boundaries that the caller has set.
    pub(crate) factors: BTreeMap<u32, f64>,
    pub(crate) records: Vec<Record>,
    /// See [`Simulation::released`].
    pub(crate) released: Vec<(u32, Matrix<D>)>,
    pub(crate) spheres: Option<SavedSpheres<D>>,
}

impl<const D: usize, const N: usize> State<D, N> {
    /// Number of steps done.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Number of spheres.
    pub fn spheres(&self) -> usize {
        self.spheres.as_ref().map_or(0, SavedSpheres::count)
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// State from which the run can be resumed.
    pub fn state(&self) -> State<D, N> {
        let run = self;
        compiled!((run: reference [Simulation<2, 3>, Simulation<3, 4>])
            -> [State<2, 3>, State<3, 4>] = Simulation::own_state)
    }

    fn own_state(&self) -> State<D, N> {
        let order = self.solid().order(&self.topology);
        State {
            step: self.step,
            totals: self.totals.clone(),
            energies: self.energies,
            reactions: self.reactions.clone(),
            nodes: order.iter().map(|&node| self.solid().node(node as usize)).collect(),
            of_corner: self.solid().in_order(&order),
            stresses: (0..self.solid().element_count()).map(|element| self.solid().stress(element)).collect(),
            viscous: self.solid().viscous(),
            dissipated: self.solid().dissipated(),
            memories: self.solid().memories(),
            joints: self.joints().save(&self.topology),
            contacts: self.contacts().save(),
            factors: self.actions.factors.clone(),
            records: self.records(),
            released: self.released.clone(),
            spheres: self.actions.spheres.save(),
        }
    }
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    [[f64; D]; N]: Machines<D, N>,
{
    /// Creates a run that continues from a state of a run of the same model.
    ///
    /// # Errors
    /// An error that says why the model cannot be simulated; [`ModelError::Length`] or
    /// [`ModelError::Missing`] if the state belongs to another model.
    pub fn resume(model: Model<D, N>, state: State<D, N>, threads: usize) -> Result<Self, ModelError> {
        compiled!((model: value [Model<2, 3>, Model<3, 4>], state: value [State<2, 3>, State<3, 4>], threads: as_is [usize, usize])
            -> [Result<Simulation<2, 3>, ModelError>, Result<Simulation<3, 4>, ModelError>] = Simulation::continued)
    }

    fn continued(model: Model<D, N>, state: State<D, N>, threads: usize) -> Result<Self, ModelError> {
        Self::continued_on(model, state, Team::new(threads)?)
    }

    pub(super) fn continued_on(
        model: Model<D, N>,
        state: State<D, N>,
        team: Team,
    ) -> Result<Self, ModelError> {
        let released = state.released.iter().map(|(element, _)| *element);
        let mut run = Self::begin_on(model.releasing(released), team)?;
        let elements = run.solid().element_count();
        let lengths = [
            ("stresses", state.stresses.len(), elements),
            ("viscous stresses", state.viscous.len(), elements),
            ("elements", state.of_corner.len(), elements),
            ("dissipated energies", state.dissipated.len(), run.solid().dissipated().len()),
            ("memories of laws", state.memories.len(), run.solid().memories().len()),
            ("boundaries", state.reactions.len(), run.reactions.len()),
        ];
        for (what, found, expected) in lengths {
            if found != expected {
                return Err(ModelError::Length { what, found, expected });
            }
        }
        let missing =
            |index| ModelError::Missing { what: "node", index, place: "the saved state".to_owned() };
        if let Some(&node) =
            state.of_corner.iter().flatten().find(|&&node| node as usize >= state.nodes.len())
        {
            return Err(missing(node));
        }
        if let Some((index, _)) = state.released.iter().find(|(element, _)| *element as usize >= elements) {
            let place = "the released bodies of the saved state".to_owned();
            return Err(ModelError::Missing { what: "element", index: *index, place });
        }
        let Columns { solid, joints, contacts } = run.machine.columns_mut();
        solid.take_stresses(&state.released);
        solid.set_nodes(&state.nodes, state.of_corner, &run.model);
        solid.restore(&state.stresses, &state.viscous, &state.dissipated, &state.memories);
        joints.restore(state.joints, &run.model, &run.topology, solid)?;
        contacts.restore(state.contacts.without_forces(), joints, &run.topology);
        for (boundary, factor) in state.factors {
            run.set_factor(boundary as usize, Some(factor))?;
        }
        for record in &state.records {
            if !run.take_record(record) {
                let [index, _] = record.codes;
                let place = "the actions of the saved state".to_owned();
                return Err(ModelError::Missing { what: "corner or facet", index, place });
            }
        }
        if let Some(saved) = state.spheres {
            run.actions.spheres.restore(saved)?;
        }
        run.step = state.step;
        run.released = state.released;
        run.begin_actions()?;
        run.totals = state.totals;
        run.energies = state.energies;
        run.reactions = state.reactions;
        Ok(run)
    }
}
