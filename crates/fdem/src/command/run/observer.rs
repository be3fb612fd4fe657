//! Looks at a run between its steps: rows of the history, and fragments.

use fdem_results::{ElementMasses, FragmentCount, Fragments, Row};

use crate::command::failure::Failure;
use crate::command::run::engine::Engine;
use crate::command::run::folder::{FRAGMENTS, MODEL};
use crate::command::run::recorder::broken;
use crate::command::run::results::Results;
use fdem_model::{Origin, Prepared, PreparedHistory, Quantity};

/// Looks at a run. It writes nothing.
pub(crate) struct Observer<const D: usize> {
    masses: ElementMasses,
    /// Number of joints that had parted at the last count of fragments, and that count.
    counted: Option<(usize, FragmentCount)>,
    /// Nodes of the boundary of each history of a force; empty for other histories.
    targets: Vec<Vec<u32>>,
    /// Displacements from which those of results count; `None` for none.
    pub(crate) origin: Option<Origin<D>>,
}

impl<const D: usize> Observer<D> {
    pub(crate) fn new<const N: usize>(
        prepared: &Prepared<D, N>,
        origin: Option<Origin<D>>,
    ) -> Result<Self, Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let mut masses = ElementMasses::of(&prepared.model).map_err(|error| broken(MODEL, &error))?;
        if let Some(bodies) = &prepared.output.fragments {
            masses = masses.counting(bodies);
        }
        Ok(Self {
            masses,
            counted: None,
            targets: prepared.histories.iter().map(|history| target(history, prepared)).collect(),
            origin,
        })
    }

    /// Returns the present values of each `[[history]]`.
    pub(crate) fn values<const N: usize>(
        &self,
        run: &(impl Engine<D, N> + ?Sized),
        prepared: &Prepared<D, N>,
    ) -> Vec<Vec<f64>>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let measured = run.measure(&prepared.probes);
        let values = |(history, target): (&PreparedHistory, &Vec<u32>)| match history.quantity {
            Quantity::Probe(probe) => measured[probe].clone(),
            Quantity::Node(node) => {
                let moved = run.nodes(&[node]).into_iter();
                moved.flat_map(|(moved, velocity)| [self.counted(node, moved), velocity].concat()).collect()
            }
            Quantity::Force(boundary) => {
                [run.force(boundary).unwrap_or([0.0; D]), self.mean_displacement(run, target)].concat()
            }
            Quantity::Torque(boundary, axis) => {
                let force = run.force(boundary).unwrap_or([0.0; D]);
                let moved = self.mean_displacement(run, target);
                [&force[..], &moved, &[torque(run, boundary, axis)]].concat()
            }
            Quantity::Energy | Quantity::CrackLength => Vec::new(),
        };
        prepared.histories.iter().zip(&self.targets).map(values).collect()
    }

    /// Returns the row of t = 0 after the first step. `values`: values before that step. Forces and energies
    /// are those at its beginning, known only after it.
    pub(crate) fn first_row<const N: usize>(
        &self,
        run: &(impl Engine<D, N> + ?Sized),
        prepared: &Prepared<D, N>,
        mut values: Vec<Vec<f64>>,
    ) -> Row
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let measured = run.measure(&prepared.probes);
        for (number, history) in prepared.histories.iter().enumerate() {
            if let Quantity::Probe(probe) = history.quantity
                && prepared.probes[probe].follows_a_step()
            {
                values[number].clone_from(&measured[probe]);
            }
            if let Quantity::Force(boundary) | Quantity::Torque(boundary, _) = history.quantity {
                values[number][..D].copy_from_slice(&run.force(boundary).unwrap_or([0.0; D]));
            }
            if let Quantity::Torque(boundary, axis) = history.quantity {
                values[number][2 * D] = torque(run, boundary, axis);
            }
        }
        Row {
            energies: run.energies(),
            fragments: self.masses.count(&run.fragments()),
            values: values.concat(),
            ..Row::default()
        }
    }

    /// Returns the present row of the history.
    pub(crate) fn row<const N: usize>(
        &mut self,
        run: &(impl Engine<D, N> + ?Sized),
        prepared: &Prepared<D, N>,
    ) -> Row
    where
        [[f64; D]; N]: Results<D, N>,
    {
        Row {
            step: run.steps(),
            time: run.time(),
            energies: run.energies(),
            broken: run.counts().broken as u64,
            lengths: run.crack_lengths(),
            fragments: self.count(run),
            values: self.values(run, prepared).concat(),
        }
    }

    /// Counts the fragments. They are found again only if joints have parted since the last count.
    fn count<const N: usize>(&mut self, run: &(impl Engine<D, N> + ?Sized)) -> FragmentCount
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let parted = run.counts().parted;
        match self.counted {
            Some((before, count)) if before == parted => count,
            _ => {
                let count = self.masses.count(&run.fragments());
                self.counted = Some((parted, count));
                count
            }
        }
    }

    /// The fragments of a run now.
    pub(crate) fn fragments<const N: usize>(
        &self,
        run: &(impl Engine<D, N> + ?Sized),
    ) -> Result<Fragments<D>, Failure>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        // The snapshot of a run is consistent. An error would be a bug.
        Fragments::of(&run.snapshot(), &self.masses).map_err(|error| broken(FRAGMENTS, &error))
    }

    /// The mean displacement of some nodes, m; not a number without any.
    fn mean_displacement<const N: usize>(&self, run: &(impl Engine<D, N> + ?Sized), nodes: &[u32]) -> [f64; D]
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let mut sum = [0.0; D];
        for (&node, (moved, _)) in nodes.iter().zip(run.nodes(nodes)) {
            let moved = self.counted(node, moved);
            sum = std::array::from_fn(|axis| sum[axis] + moved[axis]);
        }
        sum.map(|sum| sum / nodes.len() as f64)
    }

    /// The displacement of a node as results count it, m.
    fn counted(&self, node: u32, moved: [f64; D]) -> [f64; D] {
        let origin = self.origin.as_ref().and_then(|origin| origin.nodes.get(node as usize));
        origin.map_or(moved, |origin| std::array::from_fn(|axis| moved[axis] - origin[axis]))
    }
}

/// The moment of a boundary about an axis through its point, N m; 0 where it does not act.
fn torque<const D: usize, const N: usize>(
    run: &(impl Engine<D, N> + ?Sized),
    boundary: usize,
    axis: [f64; 3],
) -> f64
where
    [[f64; D]; N]: Results<D, N>,
{
    let moment = run.moment(boundary).unwrap_or([0.0; 3]);
    (0..3).map(|k| axis[k] * moment[k]).sum()
}

/// The nodes of the boundary whose force a history records, each once.
fn target<const D: usize, const N: usize>(history: &PreparedHistory, prepared: &Prepared<D, N>) -> Vec<u32> {
    let (Quantity::Force(boundary) | Quantity::Torque(boundary, _)) = history.quantity else {
        return Vec::new();
    };
    // It need not act in this stage.
    prepared.model.boundaries.get(boundary).map_or_else(Vec::new, |boundary| boundary.target.nodes())
}
