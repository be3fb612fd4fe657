//! The model of one stage of a run.
//!
//! A [`Prepared`] model has everything that is there in any stage. [`Prepared::at`] is the model of one of
//! them, with numbers of its own.

use std::ops::Range;

use fdem_simulation::{Boundary, Load, Model, ModelError, Schedule, Simulation, Subset, Target};

use crate::prepared::{Entered, Prepared, PreparedBody, PreparedServo, PreparedStage, Quantity};
use crate::stages::pores;

/// The parts of a model that are present in a stage.
#[derive(Debug)]
pub struct Present<const D: usize, const N: usize> {
    /// The model of the stage.
    pub prepared: Prepared<D, N>,
    /// Number in the whole model of each of its elements.
    pub elements: Vec<u32>,
    /// Number in the whole model of each of its nodes.
    pub nodes: Vec<u32>,
}

impl<const D: usize, const N: usize> Prepared<D, N>
where
    [[f64; D]; N]: fdem_simulation::Element<D, N>,
{
    /// The model with a time step that is stable in all of its stages, and the parts present in the first.
    ///
    /// # Errors
    /// Says which stage cannot be simulated, and why.
    pub fn in_stages(mut self) -> Result<(Self, Present<D, N>), String> {
        let mut least = f64::INFINITY;
        for (number, stage) in self.stages.iter().enumerate() {
            let run = self
                .at(&Entered::alone(number), 0.0)
                .and_then(|present| Simulation::new(present.prepared.model, 1));
            let run = run.map_err(|error| format!("stage \"{}\": {error}", stage.name))?;
            least = least.min(run.critical_step().step);
        }
        if let Some(step) = self.model.time.step.filter(|step| *step > least) {
            return Err(format!(
                "its time_step of {step} s is longer than the critical one of its stages, {least:.4e} s"
            ));
        }
        let step = self.model.time.step.unwrap_or(least * self.model.time.safety);
        self.model.time.step = Some(step);
        let first = self.at(&Entered::first(), step).map_err(|error| error.to_string())?;
        Ok((self, first))
    }

    /// The time since which something acts without a break, s. `acts`: whether it does in a stage.
    fn start(&self, entered: &Entered<D>, step: f64, acts: impl Fn(&PreparedStage) -> bool) -> f64 {
        let so_far = &self.stages[..=entered.stage()];
        let since = so_far.iter().rposition(|stage| !acts(stage)).map_or(0, |before| before + 1);
        // The first stage begins with the run.
        let begun = entered.begun.get(since).filter(|_| since > 0);
        begun.map_or(0.0, |begun| *begun as f64 * step)
    }

    /// Seals the surfaces of pores that do not act in a stage, and lets the times of the others begin.
    fn seal_surfaces(&self, model: &mut Model<D, N>, entered: &Entered<D>, step: f64) {
        let surfaces = model.pores.iter_mut().flat_map(|pores| &mut pores.surfaces);
        for (number, surface) in surfaces.enumerate() {
            let is_on = |stage: &PreparedStage| stage.pore_surfaces.as_ref().is_some_and(|on| on[number]);
            let drive = std::mem::replace(&mut surface.drive, pores::sealed());
            if is_on(&self.stages[entered.stage()]) {
                surface.drive = drive.later(self.start(entered, step, is_on));
            }
        }
    }

    /// The model of the stage that a run has entered. `step`: the time step, s.
    ///
    /// # Errors
    /// [`ModelError`]: the stage cannot be simulated.
    pub fn at(&self, entered: &Entered<D>, step: f64) -> Result<Present<D, N>, ModelError> {
        let stage = &self.stages[entered.stage()];
        let mut model = self.model.clone();
        model.time.local_damping = stage.local_damping;
        model.time.dynamic_relaxation = stage.dynamic_relaxation;
        if !stage.materials.is_empty() {
            let modulus = |material: u32| self.model.materials[material as usize].stiffest_modulus();
            // Initial stress is that of a strain, which stays.
            for (element, stress) in model.stresses.iter_mut().enumerate() {
                let [old, new] = [self.model.mesh.materials[element], stage.materials[element]].map(modulus);
                if old != new {
                    *stress = stress.map(|row| row.map(|part| part * (new / old)));
                }
            }
            model.mesh.materials.clone_from(&stage.materials);
        }
        let all = std::mem::take(&mut model.boundaries);
        for (number, mut boundary) in
            all.into_iter().enumerate().filter(|(number, _)| stage.boundaries[*number])
        {
            let start = self.start(entered, step, |stage| stage.boundaries[number]);
            if start > 0.0 {
                boundary.schedule = Schedule::From(start, Box::new(boundary.schedule));
            }
            model.boundaries.push(boundary);
        }
        model.fluid = model.fluid.filter(|_| stage.injections.is_some());
        let sources = model.fluid.iter_mut().flat_map(|fluid| &mut fluid.sources);
        for (number, source) in sources.enumerate() {
            let is_on = |stage: &PreparedStage| stage.injections.as_ref().is_some_and(|pumps| pumps[number]);
            let start = self.start(entered, step, is_on);
            source.drive = source.drive.take().filter(|_| is_on(stage)).map(|drive| drive.later(start));
        }
        model.pores = model.pores.filter(|_| stage.pore_surfaces.is_some());
        self.seal_surfaces(&mut model, entered, step);
        model.boundaries.extend(entered.held.iter().cloned());
        let Subset { mut model, elements, nodes } = model.keeping(&stage.elements)?;
        // Surfaces come and go with their bodies.
        pores::settle(&mut model);
        let range = |range: &Range<u32>, numbers: &dyn Fn(u32) -> Option<u32>| {
            let mut left = range.clone().filter_map(numbers);
            let first = left.next();
            first.map_or(0..0, |first| first..first + 1 + left.count() as u32)
        };
        let element = |element: u32| elements.binary_search(&element).ok().map(|number| number as u32);
        let bodies = self.bodies.iter().map(|body| PreparedBody {
            name: body.name.clone(),
            nodes: range(&body.nodes, &|node| nodes[node as usize]),
            elements: range(&body.elements, &element),
        });
        let mut histories = self.histories.clone();
        for history in &mut histories {
            match &mut history.quantity {
                Quantity::Node(node) => *node = nodes[*node as usize].unwrap_or(u32::MAX),
                Quantity::Force(boundary) | Quantity::Torque(boundary, _) => {
                    let name = &self.model.boundaries[*boundary].name;
                    let same = model.boundaries.iter().position(|boundary| boundary.name == *name);
                    *boundary = same.unwrap_or(usize::MAX);
                }
                Quantity::Energy | Quantity::CrackLength | Quantity::Probe(_) => {}
            }
        }
        let servos = self.servos.iter().filter_map(|servo| {
            let name = &self.model.boundaries[servo.boundary].name;
            let boundary = model.boundaries.iter().position(|boundary| boundary.name == *name)?;
            Some(PreparedServo { boundary, ..servo.clone() })
        });
        let grains = if self.grains.is_empty() {
            Vec::new()
        } else {
            elements.iter().map(|&element| self.grains[element as usize]).collect()
        };
        let prepared = Self {
            title: self.title.clone(),
            end_time: self.end_time,
            bodies: bodies.collect(),
            groups: Vec::new(),
            about_files: Vec::new(),
            grains,
            spheres: self.spheres.clone(),
            joint_sets: self.joint_sets.clone(),
            from_library: self.from_library.clone(),
            probes: self
                .probes
                .iter()
                .map(|probe| probe.renumbered(element, |node| nodes[node as usize]))
                .collect(),
            curves: self.curves.clone(),
            until: self.until.clone(),
            servos: servos.collect(),
            mass_scaling: self.mass_scaling.clone(),
            output: self.output.clone(),
            histories,
            quality: self.quality.clone(),
            warnings: self.warnings.clone(),
            hash: self.hash.clone(),
            // The parts present in one stage have no further stages.
            stages: Vec::new(),
            model,
        };
        let left = (0..).zip(&nodes).filter(|(_, left)| left.is_some()).map(|(node, _)| node);
        let nodes = left.collect();
        Ok(Present { prepared, elements, nodes })
    }
}

impl<const D: usize, const N: usize> Present<D, N> {
    /// The boundaries that hold removed parts, on nodes of the whole model.
    pub fn held(&self, boundaries: &[Boundary<D>]) -> Vec<Boundary<D>> {
        let whole = |facet: &[u32; D]| facet.map(|node| self.nodes[node as usize]);
        let held = boundaries.iter().filter(|boundary| matches!(boundary.load, Load::Held));
        held.cloned()
            .map(|mut boundary| {
                if let Target::Held(facets, _) = &mut boundary.target {
                    *facets = facets.iter().map(whole).collect();
                }
                boundary
            })
            .collect()
    }
}
