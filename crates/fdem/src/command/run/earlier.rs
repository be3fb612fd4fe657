//! A run that begins with the state at the end of an earlier run.
//!
//! Its model is another one: materials, loads, contacts and stages may differ, and bodies may be missing or
//! new. Bodies of the same name have the same mesh. Time continues: a boundary that the earlier model has too
//! continues its schedule, and one that is new or different begins now.

use std::ops::Range;
use std::path::Path;

use fdem_io::numbers::{brief, grouped};
use fdem_simulation::grains::{Insertion, Wall};
use fdem_simulation::{Boundary, Change, Model, State};

use crate::command::failure::{Failure, display_name};
use crate::command::model_file::{read_text, refused};
use crate::command::run::beginning::Beginning;
use crate::command::run::checkpoint::Checkpoint;
use crate::command::run::folder::{Folder, MODEL};
use crate::command::run::intact::check_inputs;
use crate::command::run::results::Results;
use crate::command::run::stages::Stages;
use fdem_model::{Prepared, PreparedBody};

/// The end of an earlier run.
pub(crate) struct EarlierRun<const D: usize, const N: usize> {
    /// Name of its folder.
    place: String,
    /// All of its model.
    whole: Prepared<D, N>,
    /// The part of its model that was there at its end.
    present: Prepared<D, N>,
    state: State<D, N>,
    time_step: f64,
    /// Whether one of its stages has set displacements back.
    sets_back: bool,
}

impl<const D: usize, const N: usize> EarlierRun<D, N>
where
    [[f64; D]; N]: Results<D, N>,
{
    /// Opens the last checkpoint in a folder of results. The folder is only read.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let place = display_name(path);
        let (folder, saved) = Folder::open_to_read(path)?;
        check_inputs(&folder, &saved.manifest)?;
        let text = read_text(&folder.path(MODEL))?;
        let (prepared, _) = folder.prepared(&text).map_err(|errors| refused(&errors))?;
        let unusable = |why: &str| Failure::Unusable(format!("{place} cannot be begun from: {why}"));
        let Some(mut whole) = <[[f64; D]; N]>::of_any(prepared) else {
            return Err(unusable("its model has another number of dimensions"));
        };
        let Checkpoint::<D, N> { model: hash, entered, begun, state, .. } = saved.open()?;
        if whole.hash != hash {
            return Err(unusable("its model.toml has changed since that run"));
        }
        if let Some(begun) = &begun {
            begun.apply(&mut whole.model);
        }
        let sets_back = entered.origin.is_some();
        let (stages, present) = Stages::new(whole.clone(), entered).map_err(|why| unusable(&why))?;
        let time_step = match &stages {
            Some(stages) => stages.time_step(),
            None => fdem_simulation::Simulation::new(present.model.clone(), 1)
                .map_err(|error| unusable(&error.to_string()))?
                .time_step(),
        };
        let now = state.step() as f64 * time_step;
        let holds = |boundary: &Boundary<D>| boundary.schedule.factor(now) != 0.0;
        if stages.is_some_and(|stages| stages.entered.held.iter().any(holds)) {
            return Err(unusable(
                "a stage still holds forces of parts that have vanished; release them there, with a release that ends at 0",
            ));
        }
        Ok(Self { place, whole, present, state, time_step, sets_back })
    }

    /// Time at its end, s.
    pub(crate) fn time(&self) -> f64 {
        self.state.step() as f64 * self.time_step
    }

    /// Step and schedules with which the run of a model begins now.
    pub(crate) fn begun(&self, prepared: &Prepared<D, N>) -> Result<Beginning, String> {
        let (model, before) = (&prepared.model, &self.whole.model);
        if let Some(step) = model.time.step.filter(|step| *step != self.time_step) {
            return Err(format!(
                "its time step of {step} s is not that of {}, {} s: take time_step, or mass_scaling, out",
                self.place, self.time_step
            ));
        }
        if prepared.end_time <= self.time() {
            return Err(format!(
                "its end_time is {} s, and the run in {} has reached {} s: time continues from there",
                brief(prepared.end_time),
                self.place,
                brief(self.time())
            ));
        }
        let same = |boundary: &Boundary<D>| {
            before.boundaries.iter().any(|other| {
                other.name == boundary.name
                    && other.load == boundary.load
                    && other.schedule == boundary.schedule
            })
        };
        let grains = |of: &Model<D, N>| of.grains.clone().unwrap_or_default();
        let (of_model, earlier) = (grains(model), grains(before));
        let from = |wall: &Wall| {
            let same = earlier.walls.iter().find(|other| Wall { from: 0.0, ..(*other).clone() } == *wall);
            same.map_or(self.time(), |same| same.from)
        };
        // An insertion that began with an earlier run counts from then.
        let is_known = |of: &Insertion| {
            earlier.insertions.iter().any(|other| Insertion { from: of.from, ..other.clone() } == *of)
        };
        Ok(Beginning {
            walls: of_model.walls.iter().map(from).collect(),
            insertions: of_model.insertions.iter().map(|of| !is_known(of)).collect(),
            step: self.state.step(),
            time_step: self.time_step,
            boundaries: model.boundaries.iter().map(|boundary| !same(boundary)).collect(),
            gravity: model.gravity != before.gravity || model.gravity_schedule != before.gravity_schedule,
        })
    }

    /// Refuses a model whose dimensions, joints, masses or strengths do not continue those of the earlier
    /// run.
    fn check_laws(&self, model: &Model<D, N>) -> Result<(), String> {
        let before = &self.present.model;
        for (what, same) in [
            ("plane or thickness", model.plane == before.plane && model.thickness == before.thickness),
            ("[fracture] insertion", model.fracture.insertion == before.fracture.insertion),
            ("the list of [[joint_set]] tables", names(&model.joint_sets) == names(&before.joint_sets)),
        ] {
            if !same {
                return Err(format!("{what} differs from that of the run in {}", self.place));
            }
        }
        if !before.mass_factors.is_empty() && model.mass_factors.is_empty() {
            return Err(format!(
                "the run in {} has [model] mass_scaling, and its time step needs the added mass: give this model the same mass_scaling",
                self.place
            ));
        }
        let had = |name: &str| {
            before
                .materials
                .iter()
                .find(|other| other.name == name)
                .is_some_and(|other| other.strength.is_some())
        };
        if let Some(lost) = model.materials.iter().find(|now| now.strength.is_none() && had(&now.name)) {
            return Err(format!(
                "the material \"{}\" has lost its strengths: joints of the run in {} would have no law; keep strengths that nothing reaches",
                lost.name, self.place
            ));
        }
        Ok(())
    }

    /// The model and the state with which a run begins, and the parts that it takes over, in words.
    /// `prepared`: the parts that are present at its beginning.
    pub(crate) fn taken_over(
        self,
        prepared: &Prepared<D, N>,
        threads: usize,
    ) -> Result<(Model<D, N>, State<D, N>, Vec<String>), String> {
        let (model, before) = (&prepared.model, &self.present.model);
        self.check_laws(model)?;
        let mut elements = vec![None; model.mesh.elements.len()];
        let mut told = Vec::new();
        let mut kept = Vec::new();
        for body in prepared.bodies.iter().filter(|body| !body.elements.is_empty()) {
            let Some(earlier) = self.whole.bodies.iter().find(|other| other.name == body.name) else {
                told.push(format!("the body \"{}\" is new", body.name));
                continue;
            };
            let there = self.present.bodies.iter().find(|other| other.name == body.name);
            let there = there.filter(|there| !there.elements.is_empty());
            let Some(there) = there else {
                return Err(format!(
                    "the body \"{}\" was not there any more at the end of the run in {}: take it out, or give it another name",
                    body.name, self.place
                ));
            };
            if there.elements.len() != earlier.elements.len() || !same_mesh((model, body), (before, there)) {
                return Err(format!(
                    "the body \"{}\" has another mesh than in {}: keep its shape, mesh_size and seed",
                    body.name, self.place
                ));
            }
            if stresses(model, body.elements.clone()) != stresses(before, there.elements.clone()) {
                return Err(format!(
                    "the initial stress of the body \"{}\" is not that of {}: its stress comes from there, and counts from the same [initial]",
                    body.name, self.place
                ));
            }
            for (now, before) in body.elements.clone().zip(there.elements.clone()) {
                elements[now as usize] = Some(before);
            }
            kept.push(body.name.as_str());
        }
        let takes_spheres = model.grains.is_some() && before.grains.is_some();
        if kept.is_empty() && !takes_spheres {
            let what = if model.grains.is_some() {
                "none of its bodies, and no spheres, are"
            } else {
                "none of its bodies is"
            };
            return Err(format!("{what} in {}", self.place));
        }
        let taken = elements.iter().flatten();
        if taken.clone().zip(taken.skip(1)).any(|(one, next)| one >= next) {
            return Err(format!("its bodies are in another order than those of {}", self.place));
        }
        let is_gone = |body: &&PreparedBody| !body.elements.is_empty() && !kept.contains(&body.name.as_str());
        let gone = self.present.bodies.iter().filter(is_gone);
        told.extend(gone.map(|body| format!("the body \"{}\" is gone", body.name)));
        told.extend(changes(model, before));
        if self.sets_back {
            told.push(format!(
                "displacements count from the beginning of the run in {} again, or from a stage that sets them back",
                self.place
            ));
        }
        let mut parts = Vec::new();
        if !kept.is_empty() {
            let count = elements.iter().flatten().count() as u64;
            parts.push(format!("{} elements of {}", grouped(count), list(&kept)));
        }
        if takes_spheres {
            parts.push(format!("{} spheres", grouped(self.state.spheres() as u64)));
            told.extend(changed_walls(model, before));
        }
        told.insert(
            0,
            format!(
                "begins with {} at {} s: the state of {}",
                self.place,
                brief(self.time()),
                parts.join(" and ")
            ),
        );
        let change = Change { model: model.clone(), elements, release: None };
        let changed = self.state.changed(before, change, threads).map_err(|error| error.to_string())?;
        Ok((changed.0, changed.1, told))
    }
}

/// Walls that differ between two models, in words.
fn changed_walls<const D: usize, const N: usize>(model: &Model<D, N>, before: &Model<D, N>) -> Vec<String> {
    let walls = |of: &Model<D, N>| of.grains.clone().unwrap_or_default().walls;
    let (now, earlier) = (walls(model), walls(before));
    let mut told = Vec::new();
    for wall in &now {
        match earlier.iter().find(|other| other.name == wall.name) {
            None => told.push(format!("the wall \"{}\" is new", wall.name)),
            Some(other) if other != wall => {
                told.push(format!("the wall \"{}\" has changed, and moves from now on", wall.name));
            }
            Some(_) => {}
        }
    }
    let gone = earlier.iter().filter(|other| !now.iter().any(|wall| wall.name == other.name));
    told.extend(gone.map(|wall| format!("the wall \"{}\" is gone", wall.name)));
    told
}

fn names(sets: &[fdem_simulation::JointSet]) -> Vec<&str> {
    sets.iter().map(|set| set.name.as_str()).collect()
}

/// A few names, or their number.
fn list(names: &[&str]) -> String {
    if names.len() > 5 { format!("{} bodies", grouped(names.len() as u64)) } else { names.join(", ") }
}

/// Whether a body has the same mesh in two models: elements in the same places.
fn same_mesh<const D: usize, const N: usize>(
    (model, body): (&Model<D, N>, &PreparedBody),
    (other, there): (&Model<D, N>, &PreparedBody),
) -> bool {
    let corners = |model: &Model<D, N>, body: &PreparedBody| -> Vec<[[f64; D]; N]> {
        let range = body.elements.start as usize..body.elements.end as usize;
        let of = |nodes: &[u32; N]| nodes.map(|node| model.mesh.nodes[node as usize]);
        model.mesh.elements[range].iter().map(of).collect()
    };
    corners(model, body) == corners(other, there)
}

/// The initial stresses of some elements; zeros are as none.
fn stresses<const D: usize, const N: usize>(model: &Model<D, N>, range: Range<u32>) -> Vec<[[f64; D]; D]> {
    let of = |element: u32| model.stresses.get(element as usize).copied().unwrap_or([[0.0; D]; D]);
    range.map(of).collect()
}

/// Materials and boundaries that differ between two models, in words.
fn changes<const D: usize, const N: usize>(model: &Model<D, N>, before: &Model<D, N>) -> Vec<String> {
    let mut told = Vec::new();
    for material in &model.materials {
        match before.materials.iter().find(|other| other.name == material.name) {
            None => told.push(format!("the material \"{}\" is new", material.name)),
            Some(other) if other != material => {
                told.push(format!("the material \"{}\" has changed", material.name));
            }
            Some(_) => {}
        }
    }
    for boundary in &model.boundaries {
        match before.boundaries.iter().find(|other| other.name == boundary.name) {
            None => told.push(format!("the boundary \"{}\" is new", boundary.name)),
            Some(other) if other.load != boundary.load || other.schedule != boundary.schedule => {
                told.push(format!("the boundary \"{}\" has changed, and begins now", boundary.name));
            }
            Some(_) => told.push(format!("the boundary \"{}\" goes on", boundary.name)),
        }
    }
    let ends = |other: &&Boundary<D>| !model.boundaries.iter().any(|boundary| boundary.name == other.name);
    told.extend(
        before
            .boundaries
            .iter()
            .filter(ends)
            .map(|other| format!("the boundary \"{}\" has ended", other.name)),
    );
    told
}
