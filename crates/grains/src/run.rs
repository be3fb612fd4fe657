//! A run: spheres that move under the forces of their contacts.
//!
//! One step:
//!
//! 1. Spheres that come in, and couples of spheres that may touch, when any has moved far enough
//!    ([`lists`]). The spheres are then arranged in memory along a curve through space.
//! 2. Couples that begin to touch become contacts ([`contacts`]), which lie side by side until they end.
//!    Forces of all contacts, each once, in batches ([`press`], [`batch`]), and those with walls
//!    ([`on_walls`]; of triangles: [`on_meshes`]) and bodies ([`on_surface`], [`on_facet`]). Then servos move
//!    walls and the box ([`box_servo`]).
//! 3. Motion: each sphere adds up the forces of its contacts in the order of the numbers of the other
//!    spheres, those of walls after that, and moves ([`motion`]). Velocities are half a step behind
//!    positions; contacts see them at the positions, by the accelerations of the last step.
//!
//! So the sums depend neither on threads nor on places in memory nor on the couples that do not touch.

pub(crate) mod balls;
pub(crate) mod batch;
pub(crate) mod box_servo;
pub(crate) mod by_program;
pub(crate) mod cell;
mod changes;
pub(crate) mod clumps;
pub(crate) mod contacts;
pub(crate) mod depth;
pub(crate) mod energies;
pub(crate) mod laws;
pub(crate) mod level;
pub(crate) mod lists;
pub(crate) mod motion;
pub(crate) mod on_facet;
pub(crate) mod on_meshes;
pub(crate) mod on_surface;
pub(crate) mod on_walls;
pub(crate) mod order;
pub(crate) mod press;
pub(crate) mod report;
pub(crate) mod rows;
pub(crate) mod stability;
pub(crate) mod state;

use std::sync::Arc;

use fdem_contact::{Detector, PeriodicSearch, Simd, keep_awake};

use crate::columns::{GrainContact, GrainPartner, SphereColumns};
use crate::error::GrainError;
use crate::material::ForceLaw;
use crate::model::{GrainModel, Spheres, within};
use crate::run::balls::{ALONE, Balls};
use crate::run::box_servo::virial;
use crate::run::by_program::ByProgram;
use crate::run::cell::RunBox;
use crate::run::clumps::Clumps;
use crate::run::depth::Depth;
use crate::run::energies::{EnergyOf, Gone, GrainEnergies, energies};
use crate::run::laws::Laws;
use crate::run::lists::{Finder, Lists, Remembered};
use crate::run::motion::{Moved, Moving, move_all};
use crate::run::on_facet::SurfaceMotion;
use crate::run::on_meshes::{OnMeshes, force_and_moment};
use crate::run::on_surface::{OnSurface, OnSurfacesOf};
use crate::run::on_walls::{OnWalls, OnWallsOf, Outer};
use crate::run::press::{Pressing, press};
use crate::run::state::GrainState;
use crate::servo::{Answer, ServoMotion};
use crate::sphere_law::{SphereLaw, SphereLawOptions};
use crate::surface::Surface;
use crate::vector::{dot, minus, plus, times};
use crate::wall::Wall;

/// Gap up to which spheres are candidates, as a share of their mean radius.
const SKIN: f64 = 0.3;

/// Searches after which spheres are arranged along the curve again.
const ARRANGE: u64 = 8;

/// Number of steps from one look at the stability of the step to the next one.
const STABLE: u64 = 64;

/// A run of spheres.
///
/// # Example
/// A sphere falls on a plane, and rebounds with half of its speed.
///
/// ```
/// use fdem_grains::*;
///
/// let glass = GrainMaterial { density: 2500.0, youngs_modulus: 50e9, poissons_ratio: 0.2 };
/// let model = GrainModel {
///     spheres: Spheres {
///         positions: vec![[0.0, 0.0, 0.0101]],
///         radii: vec![0.01],
///         velocities: vec![[0.0, 0.0, -1.0]],
///         ..Spheres::default()
///     },
///     walls: vec![Wall::plane([0.0; 3], [0.0, 0.0, 1.0], 0)],
///     materials: vec![glass],
///     surfaces: vec![Surfaces { restitution: 0.5, ..Surfaces::smooth([0, 0]) }],
///     ..GrainModel::default()
/// };
/// let mut run = GrainRun::new(model, 1)?;
/// run.advance(1000)?;
/// assert!((run.velocity(0)[2] - 0.5).abs() < 1e-3);
/// # Ok::<(), GrainError>(())
/// ```
#[derive(Debug)]
pub struct GrainRun {
    /// Without its spheres.
    model: GrainModel,
    laws: Laws,
    /// Laws of two spheres with each other: the same, unless the caller has a law in their place.
    between: Laws,
    by_program: ByProgram,
    balls: Balls,
    lists: Lists,
    finder: Finder,
    cell: Option<RunBox>,
    on_walls: OnWalls,
    clumps: Clumps,
    on_meshes: OnMeshes,
    on_bodies: OnSurface,
    /// The walls in the last step, meshes without their triangles, and how servos move them in the next one.
    walls: Vec<Wall>,
    servos: Vec<ServoMotion>,
    /// Contacts with walls and bodies, and the place of the sphere and the index of each, ascending.
    outer: Vec<Outer>,
    outer_order: Vec<(u32, u32)>,
    gone: Gone,
    deepest: Depth,
    next: u32,
    placed: Vec<u32>,
    moved: Moved,
    /// Number of searches so far.
    searches: u64,
    /// Whether spheres have had other places in memory since the last step.
    is_arranged: bool,
    step: u64,
    time_step: f64,
    /// The longest step for the spheres of the model, s.
    safe_step: f64,
    simd: Simd,
    pool: Arc<rayon::ThreadPool>,
}

impl GrainRun {
    /// Creates a run on `threads` threads; 0 stands for one per processor. Results do not depend on the
    /// number of threads.
    ///
    /// # Errors
    /// The number of the model that is wrong.
    pub fn new(model: GrainModel, threads: usize) -> Result<Self, GrainError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        Self::on_pool(model, Arc::new(pool.map_err(|error| GrainError::Search(error.to_string()))?))
    }

    /// The same on threads that the caller has.
    ///
    /// # Errors
    /// The errors of [`GrainRun::new`].
    pub fn on_pool(mut model: GrainModel, pool: Arc<rayon::ThreadPool>) -> Result<Self, GrainError> {
        model.check()?;
        for clump in 0..model.clumps.len() {
            model.clumps[clump].inertia = Some(model.inertia_of(clump));
        }
        let count = model.spheres.positions.len() as u32;
        let cell = model.domain.map(RunBox::new);
        let finder = if cell.is_some_and(|cell| cell.is_periodic()) {
            Finder::Periodic(Box::new(PeriodicSearch::new()))
        } else {
            Finder::Space(Box::new(Detector::new().on_pool(Arc::clone(&pool))))
        };
        let safe_step = model.safe_step();
        let time_step = model.step.unwrap_or(safe_step);
        let servos = vec![ServoMotion::default(); model.walls.len()];
        let radii = &model.spheres.radii;
        let insertions = model.insertions.iter().flat_map(|of| &of.radii);
        let mean = radii.iter().chain(insertions.clone()).sum::<f64>()
            / (radii.len() + insertions.count()).max(1) as f64;
        let laws = Laws::new(&model);
        let mut run = Self {
            between: laws.clone(),
            laws,
            by_program: ByProgram::default(),
            balls: Balls::new(&model),
            lists: Lists::default(),
            finder,
            cell,
            on_walls: OnWalls::new(model.walls.len()),
            clumps: Clumps::new(&model),
            on_meshes: OnMeshes::new(&model.walls, mean),
            on_bodies: OnSurface::new(true, mean),
            walls: placed(&model.walls, &servos, 0.0).collect(),
            servos,
            outer: Vec::new(),
            outer_order: Vec::new(),
            gone: Gone::default(),
            deepest: Depth::default(),
            next: count,
            placed: vec![0; model.insertions.len()],
            moved: Moved::default(),
            searches: 0,
            is_arranged: true,
            step: 0,
            time_step,
            safe_step,
            simd: Simd::best(),
            pool,
            model: GrainModel::default(),
        };
        model.spheres = Spheres::default();
        run.model = model;
        run.clumps.begin(&mut run.balls);
        run.search(&Vec::new())?;
        Ok(run)
    }

    /// A run that continues from a state of a run of the same model, as if it had never stopped.
    ///
    /// # Errors
    /// The errors of [`GrainRun::new`]; [`GrainError::Length`] if the state belongs to another model.
    pub fn resume(model: GrainModel, state: GrainState, threads: usize) -> Result<Self, GrainError> {
        let mut run = Self::new(model, threads)?;
        run.take(state)?;
        Ok(run)
    }

    /// Takes a state over, of a run of the same model.
    ///
    /// # Errors
    /// [`GrainError::Length`] if it belongs to another model.
    pub fn take(&mut self, state: GrainState) -> Result<(), GrainError> {
        for (what, found, expected) in [
            ("walls", state.on_walls.len(), self.model.walls.len()),
            ("servos", state.servos.len(), self.model.walls.len()),
            ("insertions", state.placed.len(), self.model.insertions.len()),
        ] {
            if found != expected {
                return Err(GrainError::Length { what, found, expected });
            }
        }
        self.clumps.take(state.clumps)?;
        self.step = state.step;
        (self.model.gravity, self.gone, self.deepest) = (state.gravity, state.gone, state.deepest);
        (self.next, self.placed) = (state.next, state.placed);
        self.balls.take(state.spheres);
        self.on_walls.take(state.on_walls);
        let (found, expected) = (state.on_meshes.len(), self.on_meshes.saved().len());
        if !self.on_meshes.take(state.on_meshes) {
            return Err(GrainError::Length { what: "walls that are meshes", found, expected });
        }
        self.on_bodies.take(state.on_bodies);
        self.on_bodies.was_there = state.has_bodies;
        self.by_program.take(state.by_program);
        self.choose_laws();
        self.servos = state.servos;
        if let Some(cell) = &mut self.cell {
            cell.motion = state.cell;
            cell.grow(state.step as f64 * self.time_step);
        }
        self.search(&state.contacts)
    }

    /// The state from which this run can be continued.
    pub fn state(&self) -> GrainState {
        GrainState {
            step: self.step,
            gravity: self.model.gravity,
            spheres: self.balls.saved(),
            next: self.next,
            placed: self.placed.clone(),
            contacts: self.lists.remember(&self.balls),
            on_walls: self.on_walls.saved(),
            on_meshes: self.on_meshes.saved(),
            on_bodies: self.on_bodies.saved(),
            has_bodies: self.on_bodies.was_there,
            servos: self.servos.clone(),
            cell: self.cell.map(|cell| cell.motion).unwrap_or_default(),
            gone: self.gone,
            deepest: self.deepest,
            clumps: self.clumps.saved(),
            by_program: self.by_program.saved(),
        }
    }

    /// Takes these vector instructions in place of the best ones of the processor; results do not depend on
    /// them.
    #[must_use]
    pub fn with_simd(mut self, simd: Simd) -> Self {
        if simd.is_available() {
            self.simd = simd;
        }
        self
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.step
    }

    /// Time step, s.
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Simulated time, s.
    pub fn time(&self) -> f64 {
        self.step as f64 * self.time_step
    }

    /// Number of spheres.
    pub fn count(&self) -> usize {
        self.balls.list.len()
    }

    /// Centre of a sphere, m. Spheres count in the order of their numbers.
    pub fn position(&self, sphere: usize) -> [f64; 3] {
        self.balls.list[self.balls.places[sphere] as usize].position
    }

    /// Velocity of a sphere, m/s, half a step before its position.
    pub fn velocity(&self, sphere: usize) -> [f64; 3] {
        self.balls.drives[self.balls.places[sphere] as usize].velocity
    }

    /// Angular velocity of a sphere, rad/s, half a step before its position.
    pub fn spin(&self, sphere: usize) -> [f64; 3] {
        self.balls.drives[self.balls.places[sphere] as usize].spin
    }

    /// Force of the spheres on a wall in the last step, N.
    pub fn wall_force(&self, wall: usize) -> [f64; 3] {
        self.on_walls.forces[wall][0]
    }

    /// Moment of the spheres on a wall in the last step, N m: about a point of its axis of rotation, or about
    /// the origin if it does not turn.
    pub fn wall_moment(&self, wall: usize) -> [f64; 3] {
        self.on_walls.forces[wall][1]
    }

    /// Lengths of the box in the last step, m, and the pressure along each axis in it, Pa; `None` without a
    /// box.
    ///
    /// # Cost
    /// A pass over all contacts.
    pub fn box_pressure(&self) -> Option<[[f64; 3]; 2]> {
        let cell = self.cell.as_ref()?;
        let work = virial(&self.balls, &self.lists.contacts, &self.between, cell).work;
        let work = plus(work, self.by_program.virial());
        Some([cell.lengths, times(1.0 / cell.lengths.iter().product::<f64>(), work)])
    }

    /// Displacement of a wall now, m, without that of its rotation.
    pub fn wall_displacement(&self, wall: usize) -> [f64; 3] {
        self.model.walls[wall].placement(self.time(), &self.servos[wall]).displacement
    }

    /// The walls in the last step; meshes are without their triangles, which [`GrainRun::columns`] has.
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The deepest overlap so far, over the radius of the smaller of the two, and that sphere; `None` if
    /// nothing has touched.
    pub fn deepest_overlap(&self) -> Option<(f64, u32)> {
        let Depth { share, sphere } = self.deepest;
        (share > 0.0).then_some((share, sphere))
    }

    /// Number of spheres that are due, and find no place.
    pub fn waiting(&self) -> usize {
        let time = self.time();
        let insertions = self.model.insertions.iter().zip(&self.placed);
        insertions.map(|(of, &placed)| of.due(time).saturating_sub(placed as usize)).sum()
    }

    /// Changes gravity, m/s². The change of the potential energy is work from outside.
    pub fn set_gravity(&mut self, gravity: [f64; 3]) {
        let change = minus(gravity, self.model.gravity);
        if change == [0.0; 3] {
            return;
        }
        // The weight does its work with the mean of its values at both ends of a step.
        let half = if self.step == 0 { 0.0 } else { 0.5 * self.time_step };
        for &place in &self.balls.places {
            if self.balls.kinds[place as usize].clump != ALONE {
                continue;
            }
            let (ball, drive) = (&self.balls.list[place as usize], &self.balls.drives[place as usize]);
            let middle = minus(ball.position, times(half, drive.velocity));
            self.gone.external -= ball.mass * dot(change, middle);
        }
        for (mass, centre, velocity) in self.clumps.centres() {
            self.gone.external -= mass * dot(change, minus(centre, times(half, velocity)));
        }
        self.model.gravity = gravity;
    }

    /// Takes `steps` steps.
    ///
    /// # Errors
    /// [`GrainError::Lost`] if a sphere has no place any more, [`GrainError::Outside`] if it has left the
    /// box, [`GrainError::UnknownSurfaces`] if two materials touch whose surfaces are not known.
    pub fn advance(&mut self, steps: u64) -> Result<(), GrainError> {
        let pool = Arc::clone(&self.pool);
        keep_awake(&pool, || (0..steps).try_for_each(|_| self.take_step(None)))
    }

    /// Takes one step in which the spheres touch this surface of bodies, too.
    ///
    /// # Errors
    /// The errors of [`GrainRun::advance`]; [`GrainError::Length`] if the lists of the surface do not fit
    /// each other, [`GrainError::Point`] and [`GrainError::Material`] if a facet has one that does not exist.
    pub fn step_on(&mut self, surface: &Surface<'_>) -> Result<(), GrainError> {
        surface.check(self.model.materials.len())?;
        let pool = Arc::clone(&self.pool);
        pool.install(|| self.take_step(Some(surface)))
    }

    /// Forces of the spheres on points of the surface in the last step, N, in ascending order of the points.
    pub fn surface_forces(&self) -> &[(u32, [f64; 3])] {
        &self.on_bodies.on_points
    }

    /// Sets a law of the caller for couples of spheres, from the next step on. Contacts with walls and bodies
    /// keep the law of the model. Its work is external work, and so is the elastic energy of contacts whose
    /// law it replaces. A run that is continued from a state needs the law again.
    ///
    /// The step must be short enough for the law: nothing checks that.
    ///
    /// # Errors
    /// [`GrainError::OutOfRange`] if the reach is no number of at least 0; [`GrainError::Law`] if the state
    /// that was taken over belongs to another law, or a servo of the box needs the stiffness of the law that
    /// this one replaces.
    ///
    /// # Cost
    /// In each step a pass over all candidates, and the law itself, on one thread.
    ///
    /// # Example
    /// Two spheres attract each other across a gap.
    ///
    /// ```
    /// use fdem_grains::*;
    ///
    /// let model = GrainModel {
    ///     spheres: Spheres {
    ///         positions: vec![[0.0; 3], [0.021, 0.0, 0.0]],
    ///         radii: vec![0.01; 2],
    ///         ..Spheres::default()
    ///     },
    ///     materials: vec![GrainMaterial { density: 2500.0, youngs_modulus: 1e9, poissons_ratio: 0.2 }],
    ///     surfaces: vec![Surfaces::smooth([0, 0])],
    ///     step: Some(1e-6),
    ///     ..GrainModel::default()
    /// };
    /// let mut run = GrainRun::new(model, 1)?;
    /// let law: SphereLaw = Box::new(|pairs| {
    ///     for (force, normal) in pairs.forces.iter_mut().zip(&pairs.normals) {
    ///         *force = normal.map(|n| -1e-3 * n);
    ///     }
    ///     Ok(())
    /// });
    /// run.set_law(law, SphereLawOptions { reach: 0.005, ..SphereLawOptions::default() })?;
    /// run.advance(1000)?;
    /// assert!(run.velocity(0)[0] > 0.0 && run.velocity(1)[0] < 0.0);
    /// # Ok::<(), GrainError>(())
    /// ```
    pub fn set_law(&mut self, law: SphereLaw, options: SphereLawOptions) -> Result<(), GrainError> {
        let reach = options.reach;
        within(|| "law of the program".to_owned(), "reach", reach, reach >= 0.0, "at least 0")?;
        if options.replaces && self.cell.is_some_and(|cell| cell.servo().is_some()) {
            let why =
                "the servo of the box needs the stiffness of the law of the model: let it act besides that";
            return Err(GrainError::Law(why.to_owned()));
        }
        self.by_program.set(law, options)?;
        self.change_laws()
    }

    /// Takes the law of the caller over from a run whose state this one has.
    pub fn keep_law(&mut self, before: &mut Self) {
        self.by_program.keep(&mut before.by_program);
    }

    /// Takes a law of the caller away: contacts of spheres have that of the model from the next step on.
    ///
    /// # Errors
    /// [`GrainError::Search`] if the search for couples fails.
    pub fn clear_law(&mut self) -> Result<(), GrainError> {
        self.by_program.clear();
        self.change_laws()
    }

    /// Gives contacts of spheres their law, and finds the couples in its reach. The elastic energy of
    /// contacts that change their law is work from outside.
    fn change_laws(&mut self) -> Result<(), GrainError> {
        let before = self.energies().elastic;
        if self.choose_laws() {
            self.lists.contacts.relax();
            self.gone.external += self.energies().elastic - before;
        }
        let remembered = self.lists.remember(&self.balls);
        self.search(&remembered)
    }

    /// Chooses the law of two spheres. Returns whether it is another one than before.
    fn choose_laws(&mut self) -> bool {
        let had_none = self.between.are_none();
        self.between = if self.by_program.options.replaces { self.laws.none() } else { self.laws.clone() };
        had_none != self.between.are_none()
    }

    fn take_step(&mut self, surface: Option<&Surface<'_>>) -> Result<(), GrainError> {
        let time = self.time();
        if let Some(cell) = &mut self.cell {
            cell.grow(time);
        }
        self.walls.clear();
        self.walls.extend(placed(&self.model.walls, &self.servos, time));
        // Spheres that come in keep off surfaces where these are now.
        self.on_meshes.place(&self.model.walls, &self.servos, time);
        match surface {
            Some(surface) => self.on_bodies.place(surface.points, surface.facets),
            None => self.on_bodies.leave(),
        }
        self.change()?;
        // Both of two spheres may have moved, and a box that grows brings them together.
        let rate = self.cell.map_or(0.0, |cell| cell.rates().into_iter().map(f64::abs).fold(0.0, f64::max));
        let drift = if rate > 0.0 { 2.0 * rate * self.largest() } else { 0.0 };
        self.lists.travel += self.time_step * (2.0 * self.moved.spread + 2.0 * drift);
        if self.lists.travel > self.lists.skin {
            let remembered = self.lists.remember(&self.balls);
            self.search(&remembered)?;
        }
        let (laws, simd, step) = (&self.laws, self.simd, self.time_step);
        let cell = self.cell.as_ref();
        press(Pressing { balls: &self.balls, laws: &self.between, cell, simd, step }, &mut self.lists)?;
        if self.step.is_multiple_of(STABLE) {
            stability::check(&self.balls, &self.lists.contacts, &self.between, step)?;
        }
        self.outer.clear();
        self.by_program.press((&self.balls, &self.lists, cell), [time, step], &mut self.outer)?;
        let of =
            OnWallsOf { balls: &self.balls, laws, walls: &self.walls, fastest: self.moved.fastest, step };
        self.on_walls.press(of, &mut self.outer)?;
        self.press_on_surfaces(surface)?;
        self.follow_servos();
        self.follow_box();
        let cell = self.cell.as_ref();
        // Those of one sphere stay in their order: by walls.
        self.outer_order.clear();
        self.outer_order.extend((0..).zip(&self.outer).map(|(index, outer)| (outer.place, index)));
        self.outer_order.sort_unstable();
        let moving = Moving {
            contacts: &self.lists.contacts,
            outer: (&self.outer, &self.outer_order),
            cell,
            simd,
            stream: self.lists.stream,
            deepest: self.deepest.share,
            gravity: self.model.gravity,
            step,
            number: self.step,
        };
        self.moved = move_all(&mut self.balls, moving)?;
        if !self.clumps.is_empty() {
            self.moved = self.moved.and(self.clumps.advance(&mut self.balls, moving)?);
        }
        for depth in
            [self.moved.deepest, self.on_walls.deepest, self.on_meshes.deepest(), self.on_bodies.deepest()]
        {
            self.deepest = self.deepest.or(depth);
        }
        self.step += 1;
        Ok(())
    }

    /// Computes the contacts with meshes and bodies, which are in their places.
    fn press_on_surfaces(&mut self, surface: Option<&Surface<'_>>) -> Result<(), GrainError> {
        // In a box spheres are moved by its lengths, too.
        let is_far = self.cell.is_some() || std::mem::take(&mut self.is_arranged);
        let moved = if is_far { f64::INFINITY } else { self.time_step * self.moved.fastest };
        let Self { balls, laws, outer, on_meshes, on_bodies, on_walls, model, walls, gone, .. } = self;
        let of = OnSurfacesOf { balls, laws, moved, step: self.time_step };
        on_meshes.press(of, (&model.walls, walls), outer)?;
        for (wall, totals) in on_meshes.totals() {
            on_walls.forces[wall] = force_and_moment(totals, &walls[wall]);
        }
        let Some(surface) = surface else { return Ok(()) };
        on_bodies.press(of, (SurfaceMotion::Points(surface.velocities), surface.materials), None, outer)?;
        gone.on_bodies += on_bodies.totals.work;
        Ok(())
    }

    /// Moves the servos by the forces on their walls.
    fn follow_servos(&mut self) {
        for number in 0..self.servos.len() {
            let Some(servo) = self.model.walls[number].servo else { continue };
            let mut answer = Answer::default();
            for touch in self.on_walls.touches.iter().filter(|touch| touch.wall as usize == number) {
                let ball = &self.balls.list[touch.outer.place as usize];
                let material = self.walls[number].material;
                if let Ok(law) = self.laws.of([ball.material, material]) {
                    answer.add(law.answer(&touch.history, ball.mass), dot(touch.normal, servo.unit()));
                }
            }
            for (_, totals) in self.on_meshes.totals().filter(|(wall, _)| *wall == number) {
                answer.add(totals.answer, 1.0);
            }
            let force = self.on_walls.forces[number][0];
            servo.follow(&mut self.servos[number], force, answer, self.time_step);
        }
    }

    /// Lets the box follow its servo, and counts its work on the spheres: up to the positions of the step
    /// with the rates before, and from there on with those after.
    fn follow_box(&mut self) {
        let Some(cell) = &mut self.cell else { return };
        let Some(servo) = cell.servo() else { return };
        let virial = virial(&self.balls, &self.lists.contacts, &self.between, cell);
        let half = -0.5 * self.time_step;
        self.gone.external += cell.motion.later + half * dot(cell.rates(), virial.work);
        let volume = cell.lengths.iter().product();
        let own = cell.strain_rates();
        // The work of a law of the caller is counted with its forces.
        let pressing = virial.and_work(self.by_program.virial());
        servo.follow((&mut cell.motion, own), &pressing, volume, self.time_step);
        cell.motion.later = half * dot(cell.rates(), virial.work);
    }

    /// Finds the couples that may touch. `remembered`: contacts that touch.
    fn search(&mut self, remembered: &Remembered) -> Result<(), GrainError> {
        if self.searches.is_multiple_of(ARRANGE) {
            self.balls.sort();
        }
        self.searches += 1;
        let radii = || self.balls.list.iter().map(|ball| ball.radius);
        let mean = radii().sum::<f64>() / self.balls.list.len().max(1) as f64;
        let skin = SKIN * mean;
        let reach = self.between.reach(0.5 * self.largest()).max(self.by_program.options.reach);
        let Self { balls, finder, cell, between, lists, .. } = self;
        lists.renew(balls, finder, skin + reach, cell.as_ref(), (remembered, between.roll()))?;
        self.lists.skin = skin;
        self.lists.lone = self.between.lone(&self.balls.list);
        self.lists.stream = self.balls.mean_velocity();
        self.clumps.find(&self.balls);
        self.on_walls.renew();
        self.is_arranged = true;
        Ok(())
    }

    /// The largest radius, m.
    fn largest(&self) -> f64 {
        self.balls.list.iter().map(|ball| ball.radius).fold(0.0, f64::max)
    }

    /// Energies at the positions of the last step, or at the beginning.
    ///
    /// # Cost
    /// A pass over all spheres and contacts on one thread.
    pub fn energies(&self) -> GrainEnergies {
        energies(EnergyOf {
            balls: &self.balls,
            contacts: &self.lists.contacts,
            laws: &self.laws,
            between: &self.between,
            on_walls: &self.on_walls,
            clumps: &self.clumps,
            on_facets: self.on_meshes.elastic() + self.on_bodies.totals.elastic,
            in_step: self.on_meshes.totals().fold([self.on_bodies.totals.against, 0.0], |sum, (_, of)| {
                [sum[0] + of.against, sum[1] - of.work]
            }),
            by_program: self.by_program.work,
            walls: &self.walls,
            gone: self.gone,
            gravity: self.model.gravity,
            step: if self.step == 0 { 0.0 } else { self.time_step },
        })
    }

    /// Contacts in the last step: those of two spheres in ascending order, then those with walls, those with
    /// walls of triangles, those with bodies. Spheres
    /// count in the order of their numbers.
    pub fn contacts(&self) -> Vec<GrainContact> {
        let mut contacts =
            report::between(&self.balls, &self.lists.contacts, self.cell.as_ref(), self.time_step);
        self.by_program.add_to(&mut contacts, &report::numbers(&self.balls));
        contacts.extend(report::on_walls(&self.balls, &self.on_walls));
        let on_bodies = self.on_bodies.contacts.iter().map(|of| of.named(GrainPartner::Facet(of.facet)));
        contacts.extend(report::on_facets(&self.balls, self.on_meshes.contacts().chain(on_bodies)));
        contacts
    }

    /// Number of the contacts in the last step.
    ///
    /// # Cost
    /// A pass over all contacts on one thread.
    pub fn contact_count(&self) -> usize {
        let contacts = &self.lists.contacts;
        let of_spheres = contacts.all().filter(|&contact| contacts.memories[contact].contact() > 0.0).count();
        of_spheres + self.on_walls.touches.len() + self.on_bodies.contacts.len()
    }

    /// The spheres, their contacts and the walls now.
    ///
    /// # Cost
    /// A pass over all spheres and contacts.
    pub fn columns(&self) -> SphereColumns {
        let period = self.cell.filter(RunBox::is_periodic).map(|cell| {
            let along = |axis: usize| if cell.periodic()[axis] { cell.lengths[axis] } else { f64::INFINITY };
            [cell.low, [along(0), along(1), along(2)]]
        });
        let mut walls = self.walls.clone();
        self.on_meshes.fill(&mut walls);
        SphereColumns {
            group_names: self.model.groups.clone(),
            walls,
            wall_forces: self.on_walls.forces.iter().map(|sums| sums[0]).collect(),
            discs: self.model.discs,
            period,
            ..report::columns(&self.balls, self.contacts())
        }
    }

    /// Number of searches for contacts so far.
    pub fn detections(&self) -> u64 {
        self.searches
    }

    /// The law of all contacts.
    pub fn law(&self) -> ForceLaw {
        self.model.law
    }
}

/// The walls at a time, s, meshes without their triangles.
fn placed<'a>(walls: &'a [Wall], servos: &'a [ServoMotion], time: f64) -> impl Iterator<Item = Wall> + 'a {
    walls.iter().zip(servos).map(move |(wall, servo)| wall.at(time, servo))
}
