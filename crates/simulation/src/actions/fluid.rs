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
//!
//! # Ranks
//!
//! All ranks have all cells, and compute the same network. Each step of the fluid they exchange the motion of
//! the sides of cells, from the ranks that count their elements, and the volumes of holes. A rank adds the
//! forces on the sides that it has.

mod cells;
mod places;
mod saved;

use fdem_fluid::{Cell, FlowModel, FluidError, Network, NetworkState, Scheme, Shape, Source};

use crate::action::{Acting, Action, Applied, Record, Scene, on_corners};
use crate::actions::cavity::face::Face;
use crate::actions::fluid::cells::{FluidCell, Located, motion_of, new_cells, sides_of, soften, yields};
use crate::actions::fluid::places::{SourcePlace, places_of};
use crate::actions::fluid::saved::{SavedCell, SavedFluid, SavedSource, SavedTotals};
use crate::error::{ModelError, Stop};
use crate::model::{FluidOptions, Schedule};
use crate::peers::{Alone, Peers, all};
use crate::simplex::Simplex;
use crate::sum::Sum;
use crate::topology::{NONE, Topology};
use crate::vector::Point;

pub(crate) use crate::actions::fluid::saved::SharedFluid;

/// The fluid of a model.
#[derive(Debug, Default)]
pub(crate) struct FluidAction<const D: usize> {
    network: Option<Network<D>>,
    /// In the order of their keys.
    cells: Vec<FluidCell<D>>,
    /// Cells that are not in the network yet.
    waiting: Vec<FluidCell<D>>,
    /// The last shapes of the cells.
    shapes: Vec<Shape<D>>,
    /// In the order of the model.
    places: Vec<SourcePlace<D>>,
    /// Where the cells are among the elements here; `None` after these have changed.
    located: Option<Vec<Located<D>>>,
    /// Number of nodes here for which the softness of cells holds.
    known: Option<usize>,
    /// Steps until the next one of the fluid.
    left: u32,
    /// `α p` of elements with liquid in their pores, Pa, by their numbers, ascending.
    pushes: Vec<(u32, f64)>,
    saved: SavedFluid<D>,
}

impl<const D: usize> FluidAction<D> {
    /// Whether this step depends on the pressures in the pores of elements: the fluid takes a step, and
    /// stress closes joints.
    pub(crate) fn needs_pores(&self, options: Option<&FluidOptions<D>>) -> bool {
        self.left == 0 && options.is_some_and(|options| options.closing_stress().is_some())
    }

    /// Takes over `α p` of the elements with liquid in their pores, Pa, ascending.
    pub(crate) fn know_pores(&mut self, pushes: impl Iterator<Item = (u32, f64)>) {
        self.pushes = pushes.collect();
    }

    pub(crate) fn network(&self) -> Option<&Network<D>> {
        self.network.as_ref()
    }

    /// The two elements beside each cell, in the whole mesh.
    pub(crate) fn elements<const N: usize>(&self) -> Vec<[u32; 2]> {
        self.cells.iter().map(|cell| cell.sides.map(|code| code / N as u32)).collect()
    }

    /// Notes the cells that the joints here make, before the elements here change.
    pub(crate) fn note<const N: usize>(&mut self, scene: &Scene<'_, D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if let (Some(_), Some(options)) = (&self.network, &scene.model.fluid) {
            self.waiting.extend(new_cells(&self.cells, options, scene));
        }
    }

    /// The same fluid among other elements.
    pub(crate) fn among_others(self) -> Self {
        Self { located: None, known: None, ..self }
    }

    /// The fluid of a whole run, as all ranks have it.
    pub(crate) fn shared(&self) -> Option<SharedFluid<D>> {
        let network = self.network.as_ref()?;
        let places = self.places.iter().map(SourcePlace::shared).collect();
        Some(SharedFluid::new(self.cells.clone(), &self.shapes, places, self.left, network.state()))
    }

    /// The fluid of a rank. `thickness`: of the model, m.
    ///
    /// # Errors
    /// The network refuses them.
    pub(crate) fn of_rank(
        shared: SharedFluid<D>,
        options: &FluidOptions<D>,
        thickness: f64,
    ) -> Result<Self, ModelError> {
        let shapes = shared.shapes();
        let (state, cells, left) = (shared.state(), shared.cells, shared.left);
        let places = shared.places.into_iter().map(SourcePlace::of_shared).collect();
        let mut this = Self { cells, shapes, places, left, ..Self::default() };
        this.network = Some(this.restored(options, thickness, &state)?);
        Ok(this)
    }

    /// A network of the cells with a state.
    fn restored(
        &self,
        options: &FluidOptions<D>,
        thickness: f64,
        state: &NetworkState,
    ) -> Result<Network<D>, FluidError> {
        let mut network = self.fresh(options, thickness)?;
        network.restore(state)?;
        Ok(network)
    }

    /// A network of the cells at its beginning.
    fn fresh(&self, options: &FluidOptions<D>, thickness: f64) -> Result<Network<D>, FluidError> {
        let source = |((key, place), of): ((u64, &SourcePlace<D>), &crate::model::FluidSource<D>)| Source {
            key,
            cells: place.keys(&self.cells),
            volume: place.volume,
            drive: of.drive.clone(),
            initial_pressure: of.initial_pressure,
        };
        let sources = (0..).zip(&self.places).zip(&options.sources).map(source).collect();
        Network::new(
            FlowModel { thickness, ..options.flow },
            sources,
            &fluid_cells(&self.cells, options),
            &self.shapes,
        )
    }

    /// The network to exchange fluid with, if a step of the fluid has just been taken. Asked for after
    /// [`Action::act`].
    pub(crate) fn stepped(&mut self, options: &FluidOptions<D>) -> Option<&mut Network<D>> {
        self.network.as_mut().filter(|_| self.left + 1 == options.steps)
    }

    /// The facets of the cells here, by the keys of these.
    pub(crate) fn facets<'a, const N: usize>(
        &'a self,
        topology: &'a Topology<D, N>,
    ) -> impl Iterator<Item = u32> + 'a
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.cells.iter().filter_map(|cell| topology.facet_with(cell.sides[0]))
    }

    /// Forces of the pressures on corners here, N.
    fn forces<const N: usize>(&self, scene: &Scene<'_, D, N>) -> Vec<(u32, Point<D>)>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let (Some(network), Some(located)) = (&self.network, &self.located) else { return Vec::new() };
        let mut forces = Vec::new();
        let mut press = |corners: [u32; D], pressure: f64| {
            if pressure != 0.0 {
                let force = Face::new(corners, scene.solid()).force(pressure);
                forces.extend(corners.map(|corner| (corner, force)));
            }
        };
        for (sides, pressure) in located.iter().zip(network.pressures()) {
            // Both sides list their corners as they go around side 0.
            for (corners, sign) in sides.iter().zip([1.0, -1.0]) {
                if let Some(corners) = corners {
                    press(*corners, sign * pressure);
                }
            }
        }
        for (key, place) in (0..).zip(&self.places).filter(|(_, place)| place.is_hole()) {
            let pressure = network.injection(key).map_or(0.0, |state| state.pressure);
            for corners in &place.here {
                press(*corners, pressure);
            }
        }
        forces
    }

    /// Finds the cells and the walls of holes among the elements here.
    fn locate<const N: usize>(&mut self, topology: &Topology<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        if self.located.is_none() {
            self.located = Some(self.cells.iter().map(|cell| cell.located(topology)).collect());
            self.places.iter_mut().for_each(|place| place.locate(topology));
        }
    }

    /// Takes a step of the fluid.
    fn flow<const N: usize>(
        &mut self,
        options: &FluidOptions<D>,
        scene: &Scene<'_, D, N>,
        peers: &dyn Peers<D, N>,
    ) -> Result<(), FluidError>
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let is_renewed = self.renew(options, scene, peers);
        self.measure_holes(scene, peers);
        let Some(network) = &mut self.network else { return Ok(()) };
        for (key, place) in (0..).zip(&self.places).filter(|(_, place)| place.is_hole()) {
            network.set_source_volume(key, place.volume)?;
        }
        let located = self.located.as_deref().unwrap_or_default();
        let push = |element: u32| {
            let place = self.pushes.binary_search_by_key(&element, |of| of.0);
            place.map_or(0.0, |place| self.pushes[place].1)
        };
        let sides = sides_of(self.cells.len(), all(peers, motion_of(located, scene, &push)));
        let pressures = network.pressures();
        let before = &network.state().cells;
        let pressure = |cell: &FluidCell<D>| {
            before
                .binary_search(&cell.key())
                .map_or_else(|_| first_pressure(options), |place| pressures[place])
        };
        let shape = |(cell, sides): (&FluidCell<D>, &[_; 2])| {
            cell.shape::<N>(sides, pressure(cell), options, scene.step)
        };
        self.shapes = self.cells.iter().zip(&sides).map(shape).collect();
        if is_renewed {
            for (key, place) in (0..).zip(&self.places) {
                network.set_source_cells(key, place.keys(&self.cells))?;
            }
            network.renew(&fluid_cells(&self.cells, options), &self.shapes)?;
        } else {
            network.update(&self.shapes)?;
        }
        network.advance(scene.step * f64::from(options.steps)).map(|_| ())
    }

    /// Adds new cells of all ranks, and computes the softness of all if cells or nodes are new. Returns
    /// whether they are.
    fn renew<const N: usize>(
        &mut self,
        options: &FluidOptions<D>,
        scene: &Scene<'_, D, N>,
        peers: &dyn Peers<D, N>,
    ) -> bool
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        self.note(scene);
        let is_new = !self.waiting.is_empty() || self.known != Some(scene.solid().node_count());
        let new = all(peers, (is_new, std::mem::take(&mut self.waiting)));
        if new.iter().all(|(is_new, _)| !is_new) {
            return false;
        }
        self.cells.extend(new.into_iter().flat_map(|(_, cells)| cells));
        // A known cell is the first one of its key.
        self.cells.sort_by_key(FluidCell::key);
        self.cells.dedup_by_key(|cell| cell.key());
        self.located = None;
        self.locate(scene.topology);
        let located = self.located.as_deref().unwrap_or_default();
        let walls = self.places.iter().flat_map(|place| &place.here);
        let yields = all(peers, yields(&self.cells, located, walls, scene));
        let step = scene.step * f64::from(options.steps);
        soften(&mut self.cells, options, yields.into_iter().flatten(), step);
        self.known = Some(scene.solid().node_count());
        true
    }

    /// Finds the present volumes of holes.
    fn measure_holes<const N: usize>(&mut self, scene: &Scene<'_, D, N>, peers: &dyn Peers<D, N>)
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let mut increases: Vec<Sum> = self.places.iter().map(|place| place.increase(scene)).collect();
        peers.add_up(&mut increases.iter_mut().collect::<Vec<_>>());
        for (place, increase) in self.places.iter_mut().zip(increases).filter(|(place, _)| place.is_hole()) {
            place.volume = place.enclosed + increase.value();
        }
    }

    /// The places of the cells and sources that an error names by their keys.
    fn places_in_words(&self, error: &FluidError, options: &FluidOptions<D>) -> String {
        let word = |(what, key): (&'static str, u64)| {
            if what == "source" {
                let source = options.sources.get(usize::try_from(key).ok()?)?;
                Some(format!("; source {key} is \"{}\"", source.name))
            } else {
                let place = self.cells.binary_search_by_key(&key, FluidCell::key).ok()?;
                let corners = self.shapes.get(place)?.corners;
                let middle: Point<D> = std::array::from_fn(|axis| {
                    corners.iter().map(|corner| corner[axis]).sum::<f64>() / D as f64
                });
                Some(format!("; cell {key} is near {middle:?} m"))
            }
        };
        error.places().into_iter().filter_map(word).collect()
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
        self.left = saved.totals.map_or(0, |totals| totals.left);
        self.cells = new_cells(&[], options, scene);
        if saved.totals.is_some() {
            self.cells.retain_mut(|cell| {
                let known = saved.cells.get(&cell.key());
                known.inspect(|of| cell.slack = of.slack).is_some()
            });
        }
        self.located = None;
        self.locate(scene.topology);
        let located = self.located.as_deref().unwrap_or_default();
        // Cells of a run that continues have the shapes that were saved.
        let push = |element: u32| {
            scene.model.pores.as_ref().map_or(0.0, |pores| {
                let mesh = &scene.model.mesh;
                pores.first_push(&mesh.elements[element as usize], mesh.materials[element as usize])
            })
        };
        let sides = sides_of(self.cells.len(), vec![motion_of(located, scene, &push)]);
        let shape = |(cell, sides): (&FluidCell<D>, &[_; 2])| match saved.cells.get(&cell.key()) {
            Some(of) => of.shape(),
            None => cell.shape::<N>(sides, first_pressure(options), options, scene.step),
        };
        self.shapes = self.cells.iter().zip(&sides).map(shape).collect();
        self.measure_holes(scene, &Alone);
        for place in &mut self.places {
            if let Some(source) = saved.sources.get(&place.name) {
                place.volume = source.volume();
            }
        }
        let keys: Vec<u64> = self.cells.iter().map(FluidCell::key).collect();
        let names: Vec<&str> = self.places.iter().map(|place| &*place.name).collect();
        if let Some(state) = saved.state(&keys, &names, options.flow.fluid.state.lowest_pressure()) {
            return self.restored(options, scene.model.thickness, &state);
        }
        let mut network = self.fresh(options, scene.model.thickness)?;
        // Fluid may come in at a later stage.
        network.restore(&NetworkState { time: scene.time, ..network.state().clone() })?;
        Ok(network)
    }
}

/// Pressure, Pa, of a cell that fluid has not entered before.
fn first_pressure<const D: usize>(options: &FluidOptions<D>) -> f64 {
    options.initial_pressure.unwrap_or_else(|| options.flow.fluid.state.lowest_pressure())
}

/// The cells, as the network has them.
fn fluid_cells<const D: usize>(cells: &[FluidCell<D>], options: &FluidOptions<D>) -> Vec<Cell<D>> {
    let of = |cell: &FluidCell<D>| Cell {
        key: cell.key(),
        corners: cell.vertices,
        law: cell.law(options),
        leak_off: options.leak_off,
        initial_pressure: options.initial_pressure,
    };
    cells.iter().map(of).collect()
}

impl<const D: usize, const N: usize> Action<D, N> for FluidAction<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    fn begin(&mut self, scene: &Scene<'_, D, N>) -> Result<(), ModelError> {
        let Some(options) = &scene.model.fluid else { return Ok(()) };
        if !scene.topology.is_whole() {
            // Ranks get the fluid of the whole run.
            return Ok(());
        }
        if options.steps == 0 {
            let (place, what) = ("fluid".to_owned(), "number of steps of the solid in one of the fluid");
            return Err(ModelError::OutOfRange { place, what, value: 0.0, range: "at least 1" });
        }
        let (found, expected) = (options.set_apertures.len(), scene.model.joint_sets.len());
        if found != 0 && found != expected {
            return Err(ModelError::Length { what: "apertures of joint sets", found, expected });
        }
        if let Some(value) = options.closing_stress()
            && options.flow.scheme == Scheme::Explicit
        {
            // The pressure of the step before would close and open joints in turn.
            let (place, what) = ("fluid".to_owned(), "reference stress of an aperture");
            return Err(ModelError::OutOfRange {
                place,
                what,
                value,
                range: "absent in the explicit scheme",
            });
        }
        self.places = places_of(options, scene.model, scene)?;
        self.network = Some(self.start(options, scene)?);
        // The first step of the fluid computes the softness: of a new run, and of one that continues.
        self.known = None;
        Ok(())
    }

    fn act(&mut self, acting: &mut Acting<'_, D, N>) {
        let (Some(_), Some(options)) = (&self.network, &acting.scene.model.fluid) else { return };
        self.locate(acting.scene.topology);
        if self.left == 0 {
            if let Err(error) = self.flow(options, &acting.scene, acting.peers) {
                let places = self.places_in_words(&error, options);
                acting.fail(Stop::Fluid(format!("{error}{places}")));
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
        let Some(network) = &self.network else { return Vec::new() };
        let state = network.state();
        let mut records = Vec::new();
        for (row, (cell, shape)) in self.cells.iter().zip(&self.shapes).enumerate() {
            let element = scene.topology.element(cell.sides[0] / N as u32);
            if element.is_some_and(|element| scene.solid().share().element(element)) {
                records.push(Record::new(cell.sides, 0, &SavedCell::of(state, row, shape, cell.slack)));
            }
        }
        if scene.counts_common() {
            records.push(Record::new([NONE; 2], 0, &SavedTotals::of(state, self.left)));
            for (key, place) in self.places.iter().enumerate() {
                let saved = SavedSource::of(state, key, place.volume);
                records.push(Record::of_boundary(&place.name, 0, &saved));
            }
        }
        records
    }

    fn take(&mut self, record: &Record, scene: &Scene<'_, D, N>) -> bool {
        let Some(options) = &scene.model.fluid else { return false };
        if !scene.topology.is_whole() {
            // Ranks get the fluid of the whole run.
            return true;
        }
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
