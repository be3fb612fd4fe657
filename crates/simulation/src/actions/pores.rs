//! Liquid in the pores of elements: `fdem-fluid` moves it by Darcy's law, and its pressure pushes the facets
//! of elements apart (Biot).
//!
//! Pressures belong to vertices of the undeformed mesh, which stay the same where nodes split: flow is
//! continuous across cracks, and a crack resists no flow. Elements have effective stresses. The pressure adds
//! the force `α p A/D` of an element's mean pressure on each corner of each of its facets, outwards, with the
//! present area `A`. Both faces of a joint have the mean `α p` of the elements beside it against these, as if
//! the liquid filled it: without that, a joint that begins with the effective stress would not be in
//! equilibrium. Where the joint is a cell of the fluid in cracks, the pressure of the cell acts on it
//! instead, and cracks and pores exchange fluid after each step of the fluid (`exchange` of `fdem-fluid`).
//! These forces are applied forces, so that their work is external work of the balance.
//!
//! # Stability
//!
//! In each step of the solid the contents of vertices stay, and pressures follow the present volumes of
//! elements: the undrained response, a force that is the gradient of an energy. It is as stiff as `α² M`,
//! which `critical.rs` counts. After each [`PoreOptions::steps`] steps the liquid flows, by backward Euler
//! for the time since the last flow while the solid stays: that takes energy of the pressures away. This is
//! the undrained split (the front page of `fdem-fluid` has its source). A mode with the frequency `ω` of the
//! drained solid, `ν² = α² M k/m` of the liquid, and the part `θ` of its pressure that a flow leaves, obeys
//!
//! ```text
//! v += Δt (-ω² x + ν² p),   x += Δt v,   p -= Δt v,   p → θ p at a flow
//! ```
//! With a flow in each step, the criterion of Jury gives stability for `(ω² + ν²) Δt² < 4`, the limit of the
//! undrained solid, at any `θ`. With a flow in each `n` steps a jump of the pressure in front of a full step
//! does work `Δx Δp/2` more than it takes from the energy of the liquid: it is unstable above half of that
//! limit. So the mean of the pressures before and after a flow acts in its step, by which the jump lies
//! between two halves of a step. Spectral radii of random modes are then at most 1 up to that limit, for `n`
//! from 1 to 20, and a test runs a body near it.
//!
//! The fixed-stress split, which adds `α²/K` of the solid to the storage, is made for a solid in equilibrium:
//! `actions/fluid.rs` shows how it feeds vibrations of one that moves.

mod saved;

use std::collections::BTreeSet;

use fdem_fluid::{Drive, FluidError, MatrixState, PoreBoundary, PorousElement, PorousMatrix, exchange};

use crate::action::{Acting, Action, Applied, Record, Scene, on_corners};
use crate::actions::cavity::face::Face;
use crate::actions::fluid::FluidAction;
use crate::actions::pores::saved::{PoreTotals, SavedPores};
use crate::error::{ModelError, Stop};
use crate::model::{Model, PoreOptions, PoreSurface, Schedule};
use crate::simplex::Simplex;
use crate::solid::corners_of;
use crate::topology::NONE;
use crate::vector::{Point, add};

/// The liquid in the pores of a model.
#[derive(Debug)]
pub(crate) struct PoreAction<const D: usize, const N: usize> {
    matrix: Option<PorousMatrix<D, N>>,
    /// The elements with pores, ascending.
    elements: Vec<u32>,
    /// Volume of each of them in the undeformed mesh, m³.
    volumes: Vec<f64>,
    /// Biot's coefficient of each of them.
    biot: Vec<f64>,
    /// Facets of the cells of the fluid in cracks.
    wet: BTreeSet<u32>,
    /// Steps until the next one of the flow.
    left: u32,
    saved: SavedPores,
}

impl<const D: usize, const N: usize> Default for PoreAction<D, N> {
    fn default() -> Self {
        Self {
            matrix: None,
            elements: Vec::new(),
            volumes: Vec::new(),
            biot: Vec::new(),
            wet: BTreeSet::new(),
            left: 0,
            saved: SavedPores::default(),
        }
    }
}

impl<const D: usize, const N: usize> PoreAction<D, N> {
    pub(crate) fn matrix(&self) -> Option<&PorousMatrix<D, N>> {
        self.matrix.as_ref()
    }

    pub(crate) fn elements(&self) -> &[u32] {
        &self.elements
    }
}

impl<const D: usize, const N: usize> PoreAction<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    /// The growth of each element with pores, m³.
    fn growth(&self, scene: &Scene<'_, D, N>) -> Vec<f64> {
        let solid = scene.solid();
        let of = |(&element, before): (&u32, &f64)| solid.shape(element).measure() * solid.thickness - before;
        self.elements.iter().zip(&self.volumes).map(of).collect()
    }

    /// `α p` of each element with pores, Pa.
    pub(crate) fn pushes(&self) -> Vec<f64> {
        let Some(matrix) = &self.matrix else { return Vec::new() };
        self.biot.iter().enumerate().map(|(k, biot)| biot * matrix.pressure_in(k)).collect()
    }

    /// Forces on corners of elements that are pushed so, N.
    fn forces(&self, pushes: &[f64], scene: &Scene<'_, D, N>) -> Vec<(u32, Point<D>)> {
        let (solid, topology) = (scene.solid(), scene.topology);
        let mut forces = Vec::with_capacity(N * pushes.len());
        for (&element, push) in self.elements.iter().zip(pushes) {
            let shape = solid.shape(element);
            let mut of_corners = [[0.0; D]; N];
            for facet in <[[f64; D]; N]>::FACETS {
                let outwards = <[[f64; D]; N]>::facet_normal(&facet.map(|corner| shape[corner]));
                let part = push * solid.thickness / D as f64;
                for corner in facet {
                    add(&mut of_corners[corner], outwards, part);
                }
            }
            forces.extend((element * N as u32..).zip(of_corners));
        }
        let push_of = |element: u32| self.elements.binary_search(&element).map_or(0.0, |place| pushes[place]);
        let joints = scene.joints();
        let all = (0..).zip(&topology.facets).zip(&joints.of_facet);
        for ((_, facet), _) in all.filter(|((facet, _), joint)| **joint != NONE && !self.wet.contains(facet))
        {
            let [a, b] = facet.elements().map(push_of);
            let mean = f64::midpoint(a, b);
            if mean != 0.0 {
                // Both sides list their corners as they go around side 0.
                for (corners, mean) in facet.corners.into_iter().zip([mean, -mean]) {
                    let force = Face::new(corners, solid).force(mean);
                    forces.extend(corners.map(|corner| (corner, force)));
                }
            }
        }
        forces
    }

    /// The pores of a model, with the state that was saved, if there is one.
    fn start(
        &mut self,
        options: &PoreOptions<D>,
        scene: &Scene<'_, D, N>,
    ) -> Result<PorousMatrix<D, N>, ModelError> {
        let model = scene.model;
        let of_materials: Vec<u32> = (0..)
            .zip(&options.materials)
            .filter_map(|(number, pores)| pores.is_some().then_some(number))
            .collect();
        let mut elements = Vec::new();
        for (number, (vertices, material)) in (0..).zip(model.mesh.elements.iter().zip(&model.mesh.materials))
        {
            let (Some(pores), Ok(place)) =
                (options.material(*material), of_materials.binary_search(material))
            else {
                continue;
            };
            self.elements.push(number);
            self.volumes.push(corners_of(&model.mesh, number as usize).measure() * model.thickness);
            self.biot.push(pores.biot);
            elements.push(PorousElement { vertices: *vertices, material: place as u32 });
        }
        let (materials, surfaces) =
            (options.materials.iter().flatten().copied().collect(), surfaces(options, scene)?);
        let initial = &options.initial_pressures;
        let nodes = &model.mesh.nodes;
        let start = |initial| {
            PorousMatrix::new(&options.liquid, model.thickness, nodes, elements, materials, surfaces, initial)
        };
        let mut matrix = start(initial).map_err(ModelError::Fluid)?;
        let growth = self.growth(scene);
        let saved = std::mem::take(&mut self.saved);
        self.left = saved.totals.map_or(options.steps, |totals| totals.left);
        matrix.deform(&growth).map_err(ModelError::Fluid)?;
        let names: Vec<&str> = options.surfaces.iter().map(|surface| &*surface.name).collect();
        let state = saved.state(&matrix, &names).unwrap_or_else(|| {
            // Liquid may come in at a later stage: it has its pressure then.
            let mut state = MatrixState { time: scene.time, initial: 0.0, ..matrix.state().clone() };
            for (vertex, storage) in
                matrix.storages().iter().enumerate().filter(|(_, storage)| **storage > 0.0)
            {
                let pressure = initial.get(vertex).copied().unwrap_or(0.0);
                state.content[vertex] = storage * pressure + matrix.growths()[vertex];
                state.pressure[vertex] = pressure;
            }
            state.initial = state.content.iter().fold(0.0, |sum, content| sum + content);
            state
        });
        matrix.restore(&state).map_err(ModelError::Fluid)?;
        Ok(matrix)
    }

    /// Takes the step of the flow, if it is its time, and exchanges fluid with cracks that have stepped.
    /// Returns `α p` of the elements before both.
    fn flow(
        &mut self,
        options: &PoreOptions<D>,
        fluid: &mut FluidAction<D>,
        scene: &Scene<'_, D, N>,
    ) -> Result<Vec<f64>, FluidError> {
        let growth = self.growth(scene);
        let Some(matrix) = &mut self.matrix else { return Ok(Vec::new()) };
        matrix.deform(&growth)?;
        let before = self.pushes();
        if let (Some(matrix), Some(of_cracks)) = (&mut self.matrix, &scene.model.fluid) {
            self.wet = fluid.facets(scene.topology).collect();
            if let Some(network) = fluid.stepped(of_cracks) {
                exchange(network, matrix)?;
            }
        }
        if self.left == 0 {
            if let Some(matrix) = &mut self.matrix {
                matrix.advance(scene.step * f64::from(options.steps))?;
            }
            self.left = options.steps;
        }
        self.left -= 1;
        Ok(before)
    }

    /// Adds the forces at the present positions, after those of the fluid in cracks.
    pub(crate) fn act_beside(&mut self, fluid: &mut FluidAction<D>, acting: &mut Acting<'_, D, N>) {
        let Some(options) = &acting.scene.model.pores else { return };
        let before = match self.flow(options, fluid, &acting.scene) {
            Ok(before) => before,
            Err(error) => {
                acting.fail(Stop::Fluid(error.to_string()));
                return;
            }
        };
        // In the step of a flow, the mean of the pressures before and after it.
        let after = self.pushes();
        let mean: Vec<f64> =
            before.iter().zip(after).map(|(before, after)| f64::midpoint(*before, after)).collect();
        let forces = self.forces(&mean, &acting.scene);
        let applied = |(corner, force)| Applied { corner, boundary: NONE, force, viscous: [0.0; D] };
        acting.apply(|list| list.extend(forces.into_iter().map(applied)));
    }
}

/// The surfaces of the pores of a model.
fn surfaces<const D: usize, const N: usize>(
    options: &PoreOptions<D>,
    scene: &Scene<'_, D, N>,
) -> Result<Vec<PoreBoundary>, ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut boundaries = Vec::new();
    let mut names = BTreeSet::new();
    for (key, surface) in (0..).zip(&options.surfaces) {
        if surface.target.is_empty() || !names.insert(&surface.name) {
            let needs = "nodes or facets, and a name that no other surface of the pores has";
            return Err(ModelError::Target { boundary: surface.name.clone(), needs });
        }
        let vertices = surface.target.nodes();
        if let Some(&index) = vertices.iter().find(|node| **node as usize >= scene.model.mesh.nodes.len()) {
            let place = format!("surface of pores '{}'", surface.name);
            return Err(ModelError::Missing { what: "node", index, place });
        }
        let factors = match &surface.drive {
            Drive::Pressure(_) => vec![1.0; vertices.len()],
            Drive::Rate(_) => shares(surface, &vertices, scene.model),
        };
        boundaries.push(PoreBoundary { key, vertices, factors, drive: surface.drive.clone() });
    }
    Ok(boundaries)
}

/// The share of each vertex in the flow through a surface.
fn shares<const D: usize, const N: usize>(
    surface: &PoreSurface<D>,
    vertices: &[u32],
    model: &Model<D, N>,
) -> Vec<f64>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let facets = surface.target.facets();
    if facets.is_empty() {
        return vec![1.0 / vertices.len() as f64; vertices.len()];
    }
    let mut shares = vec![0.0; vertices.len()];
    let mut whole = 0.0;
    for facet in facets {
        let area = <[[f64; D]; N]>::facet_measure(&facet.map(|node| model.mesh.nodes[node as usize]));
        whole += area;
        for node in facet {
            let place = vertices.partition_point(|vertex| vertex < node);
            shares[place] += area / D as f64;
        }
    }
    shares.into_iter().map(|share| share / whole).collect()
}

impl<const D: usize, const N: usize> Action<D, N> for PoreAction<D, N>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn begin(&mut self, scene: &Scene<'_, D, N>) -> Result<(), ModelError> {
        let Some(options) = &scene.model.pores else { return Ok(()) };
        if !scene.topology.is_whole() {
            return Err(ModelError::Pores("the run is on many ranks"));
        }
        // A run that continues begins twice: without its records, and with them.
        *self = Self { saved: std::mem::take(&mut self.saved), ..Self::default() };
        self.matrix = Some(self.start(options, scene)?);
        Ok(())
    }

    /// It acts beside the fluid in cracks: [`PoreAction::act_beside`].
    fn act(&mut self, _acting: &mut Acting<'_, D, N>) {}

    fn initial_forces(&self, scene: &Scene<'_, D, N>, _schedules: &[Schedule]) -> Vec<Point<D>> {
        if self.matrix.is_none() {
            return Vec::new();
        }
        on_corners(N * scene.solid().element_count(), self.forces(&self.pushes(), scene).into_iter())
    }

    fn records(&self, scene: &Scene<'_, D, N>) -> Vec<Record> {
        let (Some(matrix), Some(options)) = (&self.matrix, &scene.model.pores) else { return Vec::new() };
        let state = matrix.state();
        let mut records = vec![Record::new([NONE; 2], 0, &PoreTotals::of(state, self.left))];
        for &element in &self.elements {
            let corners: [u32; N] = std::array::from_fn(|k| element * N as u32 + k as u32);
            let of_vertex = |corner: u32| {
                let vertex = scene.topology.vertices[corner as usize] as usize;
                [state.content[vertex], matrix.storages()[vertex], state.pressure[vertex]]
            };
            let code = scene.topology.code_of_corner(corners[0]);
            records.push(Record::new([code; 2], 0, &corners.map(of_vertex)));
        }
        for (surface, inflow) in options.surfaces.iter().zip(&state.inflow) {
            records.push(Record::of_boundary(&surface.name, 0, inflow));
        }
        records
    }

    fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let Some(options) = &scene.model.pores else { return false };
        if !record.is_common() {
            let (corner, value) = (scene.topology.corner(record.codes[0]), record.value(&[[0.0; 3]; N]));
            let (Some(corner), Some(value)) = (corner, value) else { return false };
            let vertices = (corner..).take(N).map(|corner| scene.topology.vertices[corner as usize]);
            self.saved.vertices.extend(vertices.zip(value));
            return true;
        }
        if record.boundary.is_empty() {
            self.saved.totals = record.value(&PoreTotals::LIKE);
            return self.saved.totals.is_some();
        }
        let is_known = options.surfaces.iter().any(|surface| surface.name == record.boundary);
        let inflow = record.value(&0.0).filter(|_| is_known);
        inflow.is_some_and(|inflow| {
            self.saved.surfaces.insert(record.boundary.clone(), inflow);
            true
        })
    }
}
