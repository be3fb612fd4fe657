//! Fluid in cracks and holes: `fdem-fluid` moves it, and its pressure acts on both faces of each crack and on
//! the walls of holes.
//!
//! Cells of the fluid are joints, named by the codes of their facets. They are connected over vertices of the
//! undeformed mesh (edges in three dimensions), which stay the same where nodes split. The opening of a cell
//! is the mean of the openings of its corners, each at least 0. A step of the fluid takes the shapes as they
//! are, advances by [`FluidOptions::steps`] steps of the solid, and its pressures act unchanged until the
//! next one: `A p/D` on each corner of a face with the present area `A`, against the present outward normal.
//! These forces are applied forces, so that their work is external work of the balance.
//!
//! # Stability
//!
//! Fluid in a thin crack is a spring between its walls, `K/a` per area, much stiffer than the rock: with
//! water in 1 µm no explicit step would be stable. A wall follows a pressure within a step by `Δt² A/m`, with
//! its mass `m`. So each cell has a spring of the flexibility
//!
//! ```text
//! c = Δt² Σ A/m,   Δt: step of the fluid,   Σ: both sides, the mean of the corners
//! ```
//! in series with its fluid: its aperture is `w + c (p - p_cavitation)`. Fluid and spring add at most 1 to
//! `ω² Δt²` of the step, whose limit is 4. The additional aperture is an error of `c p/w`; with 1e6 Pa,
//! elements of 3 mm and a step of the fluid in each step of the solid it is some 0.05 µm. It grows with the
//! square of the number of steps of the solid in one of the fluid. With more than one, openings are those in
//! the middle of that time, by the present velocities; otherwise pressures would come late and feed
//! vibrations.
//!
//! The fixed-stress split, with the flexibility of the whole crack against the *last* pressure, is made for a
//! solid that is in equilibrium after each step. In one that moves it sums up the error of the volume over
//! the steps, an integral that feeds vibrations: `s³ + ω² s + 1/(m c Δt) = 0` has no damping in `s²`.
//!
//! A hole is as stiff as its fluid, without such a spring: `4 K Δt²/(R ρ h)` of a round one with the radius
//! `R` among elements of the size `h` has to be below 1.

mod cells;
mod saved;

use std::collections::BTreeSet;

use fdem_fluid::{Cell, FlowModel, FluidError, Network, Shape, Source};

use crate::action::{Acting, Action, Applied, Record, Scene, on_corners};
use crate::actions::cavity::face::{Face, Rim, rims, volumes};
use crate::actions::fluid::cells::{FluidCell, law_of, shape_of, soften, wet_joints};
use crate::actions::fluid::saved::{SavedCell, SavedFluid, SavedSource, SavedTotals};
use crate::error::{ModelError, Stop};
use crate::model::{FluidOptions, Model, Schedule};
use crate::outer_side::outer_side;
use crate::simplex::Simplex;
use crate::topology::{NONE, Topology};
use crate::vector::Point;

/// The fluid of a model.
#[derive(Debug, Default)]
pub(crate) struct FluidAction<const D: usize> {
    network: Option<Network<D>>,
    /// In the order of their keys.
    cells: Vec<FluidCell>,
    /// The last shapes of the cells.
    shapes: Vec<Shape<D>>,
    /// In the order of the model.
    places: Vec<SourcePlace<D>>,
    /// Numbers of joints that are wet and of nodes at which the cells are those of the network.
    known: Option<[usize; 2]>,
    /// Steps until the next one of the fluid.
    left: u32,
    saved: SavedFluid<D>,
}

/// The place of a source.
#[derive(Debug)]
struct SourcePlace<const D: usize> {
    /// The wall of its hole, by corners; empty for joints.
    walls: Vec<[u32; D]>,
    /// Rims of the wall: cells that have one of them are connected with the hole.
    rims: BTreeSet<Rim>,
    /// Facets with joints, by ascending vertices.
    joints: BTreeSet<[u32; D]>,
    /// Volume of the hole, m³.
    volume: f64,
}

impl<const D: usize> FluidAction<D> {
    pub(crate) fn network(&self) -> Option<&Network<D>> {
        self.network.as_ref()
    }

    /// The two elements beside each cell.
    pub(crate) fn elements<const N: usize>(&self, topology: &Topology<D, N>) -> Vec<[u32; 2]> {
        self.cells.iter().map(|cell| topology.facets[cell.facet as usize].elements()).collect()
    }

    /// Forces of the pressures on corners, N.
    fn forces<const N: usize>(&self, scene: &Scene<'_, D, N>) -> Vec<(u32, Point<D>)>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Some(network) = &self.network else { return Vec::new() };
        let mut forces = Vec::new();
        let mut press = |corners: [u32; D], pressure: f64| {
            if pressure != 0.0 {
                let force = Face::new(corners, scene.solid()).force(pressure);
                forces.extend(corners.map(|corner| (corner, force)));
            }
        };
        for (cell, pressure) in self.cells.iter().zip(network.pressures()) {
            // Both sides list their corners as they go around side 0.
            let [first, second] = scene.topology.facets[cell.facet as usize].corners;
            press(first, pressure);
            press(second, -pressure);
        }
        for (key, place) in (0..).zip(&self.places).filter(|(_, place)| !place.walls.is_empty()) {
            let pressure = network.injection(key).map_or(0.0, |state| state.pressure);
            place.walls.iter().for_each(|corners| press(*corners, pressure));
        }
        forces
    }

    /// Takes a step of the fluid.
    fn flow<const N: usize>(
        &mut self,
        options: &FluidOptions<D>,
        scene: &Scene<'_, D, N>,
    ) -> Result<(), FluidError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let Some(network) = &mut self.network else { return Ok(()) };
        for (key, place) in (0..).zip(&mut self.places).filter(|(_, place)| !place.walls.is_empty()) {
            place.volume = volumes_of(&place.walls, scene).into_iter().sum();
            network.set_source_volume(key, place.volume)?;
        }
        let cells = wet_joints(options, scene);
        let known = Some([cells.len(), scene.solid().node_count()]);
        let is_new = self.known != known;
        let lowest = options.flow.fluid.state.lowest_pressure();
        let pressures = network.pressures();
        if is_new {
            let before = std::mem::replace(&mut self.cells, cells);
            soften(&mut self.cells, options, self.places.iter().flat_map(|place| &place.walls), scene);
            let above = |cell: &FluidCell| {
                let place = before.binary_search_by_key(&cell.key, |of| of.key);
                place.map_or(0.0, |place| pressures[place] - lowest)
            };
            self.shapes = self.cells.iter().map(|cell| shape_of(cell, above(cell), options, scene)).collect();
            for (key, place) in (0..).zip(&self.places) {
                network.set_source_cells(key, place.keys(&self.cells, scene))?;
            }
            network.renew(&fluid_cells(&self.cells, options, scene), &self.shapes)?;
            self.known = known;
        } else {
            let above = self.cells.iter().zip(&pressures);
            self.shapes =
                above.map(|(cell, pressure)| shape_of(cell, pressure - lowest, options, scene)).collect();
            network.update(&self.shapes)?;
        }
        network.advance(scene.step * f64::from(options.steps)).map(|_| ())
    }

    /// A network of these cells, with the state that was saved, if there is one.
    fn start<const N: usize>(
        &mut self,
        options: &FluidOptions<D>,
        scene: &Scene<'_, D, N>,
    ) -> Result<Network<D>, FluidError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let saved = std::mem::take(&mut self.saved);
        self.cells = wet_joints(options, scene);
        self.left = saved.totals.map_or(0, |totals| totals.left);
        if saved.totals.is_some() {
            self.cells.retain(|cell| saved.cells.contains_key(&cell.key));
        }
        let shape = |cell: &FluidCell| match saved.cells.get(&cell.key) {
            Some(of) => of.shape(),
            None => shape_of(cell, 0.0, options, scene),
        };
        self.shapes = self.cells.iter().map(shape).collect();
        let mut sources = Vec::new();
        for ((key, place), of) in (0..).zip(&mut self.places).zip(&options.sources) {
            place.volume = match saved.sources.get(&of.name) {
                Some(source) => source.volume(),
                None if place.walls.is_empty() => 0.0,
                None => volumes_of(&place.walls, scene).into_iter().sum(),
            };
            sources.push(Source {
                key,
                cells: place.keys(&self.cells, scene),
                volume: place.volume,
                drive: of.drive.clone(),
                initial_pressure: of.initial_pressure,
            });
        }
        let flow = FlowModel { thickness: scene.model.thickness, ..options.flow };
        let mut network =
            Network::new(flow, sources, &fluid_cells(&self.cells, options, scene), &self.shapes)?;
        let keys: Vec<u64> = self.cells.iter().map(|cell| cell.key).collect();
        let names: Vec<&str> = options.sources.iter().map(|source| &*source.name).collect();
        let state = match saved.state(&keys, &names, flow.fluid.state.lowest_pressure()) {
            Some(state) => state,
            // Fluid may come in at a later stage.
            None => fdem_fluid::NetworkState { time: scene.time, ..network.state().clone() },
        };
        network.restore(&state)?;
        Ok(network)
    }
}

impl<const D: usize> SourcePlace<D> {
    /// Keys of the cells that a source is connected with.
    fn keys<const N: usize>(&self, cells: &[FluidCell], scene: &Scene<'_, D, N>) -> Vec<u64>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let is_of = |cell: &&FluidCell| {
            let mut vertices = vertices_of(cell, scene);
            vertices.sort_unstable();
            self.joints.contains(&vertices) || rims(vertices).any(|rim| self.rims.contains(&rim))
        };
        cells.iter().filter(is_of).map(|cell| cell.key).collect()
    }
}

/// The cells, as the network has them.
fn fluid_cells<const D: usize, const N: usize>(
    cells: &[FluidCell],
    options: &FluidOptions<D>,
    scene: &Scene<'_, D, N>,
) -> Vec<Cell<D>>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let of = |cell: &FluidCell| Cell {
        key: cell.key,
        corners: vertices_of(cell, scene),
        law: law_of(cell, options, scene),
        leak_off: options.leak_off,
        initial_pressure: options.initial_pressure,
    };
    cells.iter().map(of).collect()
}

/// The vertices of the facet of a cell.
fn vertices_of<const D: usize, const N: usize>(cell: &FluidCell, scene: &Scene<'_, D, N>) -> [u32; D]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let topology = scene.topology;
    topology.facets[cell.facet as usize].corners[0].map(|corner| topology.vertices[corner as usize])
}

/// Volume of an undeformed hole, and its increase, m³.
fn volumes_of<const D: usize, const N: usize>(walls: &[[u32; D]], scene: &Scene<'_, D, N>) -> [f64; 2]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let faces: Vec<Face<D>> = walls.iter().map(|corners| Face::new(*corners, scene.solid())).collect();
    volumes(&faces, scene)
}

/// The places of the sources of a model.
fn places_of<const D: usize, const N: usize>(
    options: &FluidOptions<D>,
    model: &Model<D, N>,
    scene: &Scene<'_, D, N>,
) -> Result<Vec<SourcePlace<D>>, ModelError>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut places: Vec<SourcePlace<D>> = Vec::new();
    let mut names = BTreeSet::new();
    for source in &options.sources {
        let needs = "facets, and a name that no other source of the fluid has";
        if source.facets.is_empty() || !names.insert(&source.name) {
            return Err(ModelError::Target { boundary: source.name.clone(), needs });
        }
        let (mut walls, mut rims_of, mut joints) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
        for &facet in &source.facets {
            if let Some(&index) = facet.iter().find(|node| **node as usize >= model.mesh.nodes.len()) {
                let place = format!("source of fluid '{}'", source.name);
                return Err(ModelError::Missing { what: "node", index, place });
            }
            match outer_side(model, scene.topology, facet, &source.name) {
                Ok(side) => {
                    walls.push(side.corners);
                    rims_of.extend(rims(facet));
                }
                Err(_) if scene.topology.has_facet(&facet) => {
                    let mut vertices = facet;
                    vertices.sort_unstable();
                    joints.insert(vertices);
                }
                Err(error) => return Err(error),
            }
        }
        let [value, _] = volumes_of(&walls, scene);
        if !walls.is_empty() && value <= 0.0 {
            let place = format!("source of fluid '{}'", source.name);
            let range = "above 0: the facets of its hole enclose it";
            return Err(ModelError::OutOfRange { place, what: "the volume", value, range });
        }
        places.push(SourcePlace { walls, rims: rims_of, joints, volume: 0.0 });
    }
    Ok(places)
}

impl<const D: usize, const N: usize> Action<D, N> for FluidAction<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn begin(&mut self, scene: &Scene<'_, D, N>) -> Result<(), ModelError> {
        let Some(options) = &scene.model.fluid else { return Ok(()) };
        if !scene.topology.is_whole() {
            return Err(ModelError::FluidOnRanks);
        }
        if options.steps == 0 {
            let (place, what) = ("fluid".to_owned(), "number of steps of the solid in one of the fluid");
            return Err(ModelError::OutOfRange { place, what, value: 0.0, range: "at least 1" });
        }
        let (found, expected) = (options.set_apertures.len(), scene.model.joint_sets.len());
        if found != 0 && found != expected {
            return Err(ModelError::Length { what: "apertures of joint sets", found, expected });
        }
        self.places = places_of(options, scene.model, scene)?;
        self.network = Some(self.start(options, scene)?);
        // The first step of the fluid looks for all cells: of a new run, and of one that continues.
        self.known = None;
        Ok(())
    }

    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        let Some(options) = &acting.scene.model.fluid else { return };
        if self.left == 0 {
            if let Err(error) = self.flow(options, &acting.scene) {
                acting.fail(Stop::Fluid(error));
                return;
            }
            self.left = options.steps;
        }
        self.left -= 1;
        let forces = self.forces(&acting.scene);
        let applied = |(corner, force)| Applied { corner, boundary: NONE, force, viscous: [0.0; D] };
        acting.apply(|list| list.extend(forces.into_iter().map(applied)));
    }

    fn initial_forces(&self, scene: &Scene<'_, D, N>, _schedules: &[Schedule]) -> Vec<Point<D>> {
        if self.network.is_none() {
            return Vec::new();
        }
        on_corners(N * scene.solid().element_count(), self.forces(scene).into_iter())
    }

    fn records(&self, scene: &Scene<'_, D, N>) -> Vec<Record> {
        let (Some(network), Some(options)) = (&self.network, &scene.model.fluid) else { return Vec::new() };
        let state = network.state();
        let mut records = vec![Record::new([NONE; 2], 0, &SavedTotals::of(state, self.left))];
        for (row, (cell, shape)) in self.cells.iter().zip(&self.shapes).enumerate() {
            let sides = scene.topology.facets[cell.facet as usize].corners;
            let codes = sides.map(|side| scene.topology.code_of_side(&side));
            records.push(Record::new(codes, 0, &SavedCell::of(state, row, shape)));
        }
        for (key, (place, source)) in self.places.iter().zip(&options.sources).enumerate() {
            let saved = SavedSource::of(state, key, place.volume);
            records.push(Record::of_boundary(&source.name, 0, &saved));
        }
        records
    }

    fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let Some(options) = &scene.model.fluid else { return false };
        if !record.is_common() {
            let code = record.codes[0];
            let cell = record.value(&SavedCell::<D>::LIKE);
            let found = cell.filter(|_| scene.topology.facet_with(code).is_some());
            return found.is_some_and(|cell| {
                self.saved.cells.insert(u64::from(code), cell);
                true
            });
        }
        if record.boundary.is_empty() {
            self.saved.totals = record.value(&SavedTotals::LIKE);
            return self.saved.totals.is_some();
        }
        let is_known = options.sources.iter().any(|source| source.name == record.boundary);
        let source = record.value(&SavedSource::LIKE).filter(|_| is_known);
        source.is_some_and(|source| {
            self.saved.sources.insert(record.boundary.clone(), source);
            true
        })
    }
}
