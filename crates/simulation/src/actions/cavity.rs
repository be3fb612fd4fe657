//! Cavities: a pressure on the facets of a hole, and on the faces of all broken joints that are connected
//! with it.
//!
//! A cavity begins with the facets of its boundary. A broken joint joins it if it has a vertex (in three
//! dimensions an edge) in common with a facet of the boundary or with a joint that has joined before. One
//! pressure acts on all of its faces against their present outward normals. It is that of the boundary times
//! the factor of its schedule, or that of a gas without exchange of heat,
//!
//! ```text
//! p = p₀ (V₀/V)^γ,   U = p₀ V₀^γ V^(1-γ)/(γ-1)
//! ```
//! whose stored energy `U` is a term of the balance. The work of a prescribed pressure is work of loads.
//!
//! The volume follows from the motion of the faces, from step to step: `dV = -Σ n·dx` with the mean of the
//! area vectors `n` before and after the step, which is exact in two dimensions and of third order in the
//! motion in three. So it needs only one side of a joint, however far its elements have parted, and the work
//! is the sum of `p dV` by construction. A joint that joins adds the volume by which it is open then. The
//! energy that a gas loses when it fills that volume is dissipated.
//!
//! Each rank has the faces of its own elements, and knows all joints that have broken anywhere, so that all
//! ranks find the same connections.

pub(super) mod face;
mod state;

use std::collections::{BTreeMap, BTreeSet};

use crate::action::{Acting, Action, Applied, Event, Record, Scene, on_corners};
use crate::actions::cavity::face::{Face, add_sides, rims, volumes};
pub use crate::actions::cavity::state::CavityState;
use crate::actions::cavity::state::{Cavity, CavityNumbers};
use crate::energy::Ledger;
use crate::error::ModelError;
use crate::faces::BrokenSides;
use crate::model::{Load, Model, Schedule, Stored};
use crate::outer_side::outer_side;
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::topology::NONE;
use crate::vector::{Point, dot, minus};

/// All cavities of a model.
#[derive(Debug, Default)]
pub(crate) struct Cavities<const D: usize> {
    all: Vec<Cavity<D>>,
    /// All joints that have broken anywhere, by the codes of their first sides; empty without cavities.
    broken: BTreeMap<u32, BrokenSides<D>>,
}

impl<const D: usize> Cavities<D> {
    /// Adds the cavity of a boundary. Returns `false` for another boundary.
    pub(crate) fn add<const N: usize>(
        &mut self,
        number: u32,
        model: &Model<D, N>,
        is_part: bool,
    ) -> Result<bool, ModelError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let boundary = &model.boundaries[number as usize];
        let Load::Cavity { pressure, gas } = boundary.load else { return Ok(false) };
        if boundary.target.facets().is_empty() && !is_part {
            let needs = <[[f64; D]; N]>::FACETS_ARE;
            return Err(ModelError::Target { boundary: boundary.name.clone(), needs });
        }
        if let Some(value) = gas.filter(|exponent| !(*exponent > 1.0 && exponent.is_finite())) {
            let place = format!("boundary '{}'", boundary.name);
            let what = "the ratio of the specific heats";
            return Err(ModelError::OutOfRange { place, what, value, range: "above 1" });
        }
        self.all.push(Cavity {
            boundary: number,
            name: boundary.name.clone(),
            pressure,
            gas,
            rims: BTreeSet::new(),
            joined: BTreeSet::new(),
            elsewhere: BTreeMap::new(),
            faces: Vec::new(),
            numbers: None,
        });
        Ok(true)
    }

    /// Pressure, volume and work of the cavity of a boundary.
    pub(crate) fn state(&self, boundary: u32) -> Option<CavityState> {
        let cavity = self.all.iter().find(|cavity| cavity.boundary == boundary)?;
        let CavityNumbers { volume, work, swept, area, pressure, stored, .. } = cavity.numbers?;
        // Until the next pressure is known, the last one stands for it.
        Some(CavityState { pressure, volume, area, work: work + 0.5 * pressure * swept, stored })
    }
}

/// A hole is another one if its volume has changed by more than this share.
const SAME: f64 = 1e-9;

impl<const D: usize, const N: usize> Action<D, N> for Cavities<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn begin(&mut self, scene: &Scene<'_, D, N>) -> Result<(), ModelError> {
        if self.all.is_empty() {
            return Ok(());
        }
        let Scene { model, topology, .. } = *scene;
        let (solid, joints) = (scene.solid(), scene.joints());
        let is_whole = topology.is_whole();
        if is_whole {
            self.broken = joints.broken_sides(topology).map(|joint| (joint.sides[0], joint)).collect();
        }
        let known = &self.broken;
        for cavity in &mut self.all {
            let boundary = &model.boundaries[cavity.boundary as usize];
            cavity.joined.clear();
            cavity.elsewhere.clear();
            if is_whole {
                cavity.rims.clear();
            }
            let mut faces = Vec::new();
            for &facet in boundary.target.facets() {
                match outer_side(model, topology, facet, &boundary.name) {
                    Ok(side) => faces.push(Face::new(side.corners, solid)),
                    // The cavity may begin with joints that are open.
                    Err(_) if topology.has_facet(&facet) => {}
                    Err(error) => return Err(error),
                }
                if is_whole {
                    cavity.rims.extend(rims(facet));
                }
            }
            let [hole, increase] = volumes(&faces, scene);
            let mut opened = Sum::default();
            let mut joined = Vec::new();
            for joint in known.values() {
                joined.extend(cavity.reach(joint, known));
            }
            for code in joined {
                if let Some(joint) = known.get(&code) {
                    opened.add(add_sides(&mut faces, joint, scene));
                }
            }
            faces.sort_unstable_by_key(|face| face.corners);
            cavity.faces = faces;
            if is_whole && cavity.numbers.is_none_or(|numbers| (numbers.hole - hole).abs() > SAME * hole) {
                let volume = hole + increase + opened.value().max(0.0);
                if cavity.gas.is_some() && (volume <= 0.0 || volume.is_nan()) {
                    let place = format!("boundary '{}'", boundary.name);
                    let range = "above 0: a gas begins in a closed hole";
                    return Err(ModelError::OutOfRange { place, what: "the volume", value: volume, range });
                }
                let area = cavity.faces.iter().map(|face| dot(face.area, face.area).sqrt()).sum();
                let work = cavity.numbers.map_or(0.0, |numbers| numbers.work);
                cavity.numbers = Some(CavityNumbers {
                    hole,
                    first: volume,
                    volume,
                    area,
                    work,
                    ..CavityNumbers::default()
                });
            }
        }
        Ok(())
    }

    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        for cavity in &mut self.all {
            let Some(mut numbers) = cavity.numbers else { continue };
            let factor = acting.schedules[cavity.boundary as usize].factor(acting.scene.time);
            numbers.pressure = cavity.pressure_at(&numbers, factor);
            numbers.stored = cavity.stored(&numbers);
            numbers.work += 0.5 * numbers.pressure * numbers.swept;
            numbers.swept = 0.0;
            cavity.numbers = Some(numbers);
            if cavity.gas.is_some() {
                for face in &cavity.faces {
                    let force = face.force(numbers.pressure);
                    face.corners.into_iter().for_each(|corner| acting.add_force(corner, force));
                }
                continue;
            }
            let on = |face: &Face<D>| {
                let (force, boundary) = (face.force(numbers.pressure), cavity.boundary);
                face.corners.map(|corner| Applied { corner, boundary, force, viscous: [0.0; D] })
            };
            acting.apply(|applied| applied.extend(cavity.faces.iter().flat_map(on)));
        }
    }

    fn initial_forces(&self, scene: &Scene<'_, D, N>, schedules: &[Schedule]) -> Vec<Point<D>> {
        if self.all.is_empty() {
            return Vec::new();
        }
        let on = |cavity: &Cavity<D>| {
            let factor = schedules[cavity.boundary as usize].factor(0.0);
            let pressure = cavity.numbers.map_or(0.0, |numbers| cavity.pressure_at(&numbers, factor));
            let forces = cavity.faces.iter().flat_map(move |face| {
                let force = face.force(pressure);
                face.corners.map(|corner| (corner, force))
            });
            forces.collect::<Vec<_>>()
        };
        on_corners(N * scene.solid().element_count(), self.all.iter().flat_map(on))
    }

    fn measure(&mut self, event: &Event<'_, D>, scene: &Scene<'_, D, N>) -> Vec<Sum> {
        let solid = scene.solid();
        let known = &mut self.broken;
        if let Event::Broke(joints) = event {
            known.extend(joints.iter().map(|joint| (joint.sides[0], *joint)));
        }
        let mut sums = Vec::new();
        for cavity in &mut self.all {
            match event {
                Event::Moved => {
                    let mut of = [(); 3].map(|()| Sum::default());
                    for face in &mut cavity.faces {
                        let now = Face::new(face.corners, solid);
                        if solid.share().element(face.corners[0] / N as u32) {
                            let motion = minus(now.middle, face.middle);
                            of[0].add(-dot(face.area, motion));
                            of[1].add(-dot(now.area, motion));
                            of[2].add(dot(now.area, now.area).sqrt());
                        }
                        *face = now;
                    }
                    sums.extend(of);
                }
                Event::Broke(joints) => {
                    let mut opened = Sum::default();
                    for joint in *joints {
                        for code in cavity.reach(joint, known) {
                            if let Some(joint) = known.get(&code) {
                                opened.add(add_sides(&mut cavity.faces, joint, scene));
                            }
                        }
                    }
                    cavity.faces.sort_unstable_by_key(|face| face.corners);
                    sums.push(opened);
                }
            }
        }
        sums
    }

    fn settle(&mut self, event: &Event<'_, D>, sums: &[Sum]) -> f64 {
        let mut lost = 0.0;
        let of_each = sums.len() / self.all.len().max(1);
        for (cavity, sums) in self.all.iter_mut().zip(sums.chunks(of_each.max(1))) {
            let Some(mut numbers) = cavity.numbers else { continue };
            match (event, sums) {
                (Event::Moved, [before, after, area]) => {
                    let (before, after) = (before.value(), after.value());
                    numbers.volume += 0.5 * (before + after);
                    numbers.work += 0.5 * numbers.pressure * before;
                    (numbers.swept, numbers.area) = (after, area.value());
                }
                (Event::Broke(_), [opened]) => {
                    let had = cavity.stored(&numbers);
                    numbers.volume += opened.value().max(0.0);
                    lost += had - cavity.stored(&numbers);
                }
                _ => {}
            }
            cavity.numbers = Some(numbers);
        }
        lost
    }

    fn follows_events(&self) -> bool {
        !self.all.is_empty()
    }

    fn add_energies(&self, scene: &Scene<'_, D, N>, ledger: &mut Ledger) {
        let mut gases = self.all.iter().filter(|cavity| cavity.gas.is_some()).peekable();
        if gases.peek().is_none() {
            return;
        }
        // All ranks know the numbers, and one counts them.
        let counted = scene.counts_common();
        let stored = |cavity: &Cavity<D>| cavity.numbers.filter(|_| counted).map(|numbers| numbers.stored);
        ledger.store(Stored::Gas, &gases.filter_map(stored).collect());
    }

    fn records(&self, _scene: &Scene<'_, D, N>) -> Vec<Record> {
        let mut records = Vec::new();
        for cavity in &self.all {
            records.extend(cavity.numbers.map(|numbers| Record::of_boundary(&cavity.name, 0, &numbers)));
            let rims = (1..).zip(&cavity.rims);
            records.extend(rims.map(|(place, rim)| Record::of_boundary(&cavity.name, place, rim)));
        }
        let joints = (0..).zip(self.broken.values());
        records.extend(joints.map(|(place, joint)| Record::new([NONE; 2], place, joint)));
        records
    }

    fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let is_whole = scene.topology.is_whole();
        let is_of = |cavity: &&mut Cavity<D>| cavity.name == record.boundary;
        let Some(cavity) = self.all.iter_mut().find(is_of) else {
            let like = BrokenSides { sides: [0; 2], vertices: [0; D] };
            let Some(joint) = record.value(&like).filter(|_| record.boundary.is_empty()) else {
                return false;
            };
            // A whole run knows its joints itself, by the numbers that they have now.
            if !is_whole {
                self.broken.insert(joint.sides[0], joint);
            }
            return true;
        };
        if let Some(numbers) = record.value(&CavityNumbers::default()) {
            cavity.numbers = Some(numbers);
            return true;
        }
        let rim = record.value(&[0; 2]);
        cavity.rims.extend(rim.filter(|_| !is_whole));
        rim.is_some()
    }
}
