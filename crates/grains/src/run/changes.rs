//! Spheres that come in and spheres that go.

use std::ops::Range;

use crate::error::GrainError;
use crate::insertion::Taken;
use crate::model::Spheres;
use crate::run::GrainRun;
use crate::run::balls::ALONE;
use crate::run::lists::Remembered;
use crate::vector::{Vector, dot};

/// Steps after which spheres come in and are removed.
const CHANGE: u64 = 32;

/// Step of a run over the one for a sphere that is added, from which on its impacts are not resolved.
const TOO_LONG: f64 = 4.0;

impl GrainRun {
    /// Adds spheres between two steps, and returns their numbers. They touch nothing at first. The balance
    /// counts their energy as external work. Groups, if given, are numbers of those of the model.
    ///
    /// # Errors
    /// [`GrainModel::check`](crate::GrainModel::check) has the errors of wrong numbers.
    /// [`GrainError::OutOfRange`]: a sphere is so small or so fast that the run would need a quarter of its
    /// step. [`GrainError::NoRoom`]: a sphere overlaps another one, a wall or a body. After an error no
    /// sphere is added.
    ///
    /// # Cost
    /// A search for couples, as the run makes one every hundred steps or so.
    pub fn add(&mut self, spheres: &Spheres) -> Result<Range<u32>, GrainError> {
        // The model of the run, with these spheres alone.
        let clumps = std::mem::take(&mut self.model.clumps);
        self.model.spheres = spheres.clone();
        let checked = self.model.check().map(|()| self.model.shortest_step(0.0));
        (self.model.spheres, self.model.clumps) = (Spheres::default(), clumps);
        let (longest, sphere) = checked?;
        if TOO_LONG * longest < self.time_step.min(self.safe_step) {
            return Err(GrainError::OutOfRange {
                place: format!("sphere {sphere} of those to add"),
                what: "time step, s,",
                value: longest,
                range: "at least a quarter of that of the run: begin it with a shorter one",
            });
        }
        let all = spheres.positions.iter().zip(&spheres.radii);
        let nothing = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let region = all.clone().fold(nothing, |[low, high], (place, radius)| {
            let down = |k: usize| low[k].min(place[k] - radius);
            let up = |k: usize| high[k].max(place[k] + radius);
            [[down(0), down(1), down(2)], [up(0), up(1), up(2)]]
        });
        if spheres.positions.is_empty() {
            return Ok(self.next..self.next);
        }
        let is_clear = |centre, radius| self.is_clear(centre, radius);
        let mut taken = self.taken(region, &spheres.radii, &is_clear);
        for (sphere, (&place, &radius)) in all.enumerate() {
            if !taken.is_free(place, radius) {
                return Err(GrainError::NoRoom { sphere });
            }
            self.images(place).for_each(|image| taken.add(image, radius));
        }
        let remembered = self.lists.remember(&self.balls);
        let first = self.next;
        self.bring_in(spheres);
        self.search(&remembered)?;
        Ok(first..self.next)
    }

    /// The room that is taken in a box, m, for spheres with these radii, m. `is_clear`: whether a sphere
    /// touches no triangle.
    fn taken<'a>(
        &'a self,
        region: [Vector; 2],
        radii: &[f64],
        is_clear: &'a dyn Fn(Vector, f64) -> bool,
    ) -> Taken<'a> {
        let largest = radii.iter().copied().fold(self.largest(), f64::max);
        // Spheres reach into the region across sides that repeat, too.
        let spheres = self
            .balls
            .list
            .iter()
            .flat_map(|ball| self.images(ball.position).map(|place| (place, ball.radius)));
        Taken::new(region, largest, spheres, (&self.walls, is_clear))
    }

    /// A place and its images in a periodic box.
    fn images(&self, place: Vector) -> impl Iterator<Item = Vector> + use<> {
        let images = self.cell.as_ref().map(|cell| cell.images(place));
        let alone = images.is_none().then_some(place);
        images.into_iter().flatten().chain(alone)
    }

    /// Whether a sphere touches no triangle.
    fn is_clear(&self, centre: Vector, radius: f64) -> bool {
        self.on_meshes.is_clear(centre, radius) && self.on_bodies.is_clear(centre, radius)
    }

    /// Adds spheres with the next numbers, and their energy.
    fn bring_in(&mut self, spheres: &Spheres) {
        let begin = self.balls.list.len();
        self.balls.add(self.next, spheres);
        self.next += spheres.positions.len() as u32;
        for place in begin..self.balls.list.len() {
            let ball = &self.balls.list[place];
            self.gone.external += 0.5 * ball.mass * dot(ball.velocity, ball.velocity)
                + 0.5 * self.balls.inertia(place) * dot(ball.spin, ball.spin)
                - ball.mass * dot(self.model.gravity, ball.position);
        }
    }

    /// Removes spheres, and lets others come in.
    pub(super) fn change(&mut self) -> Result<(), GrainError> {
        let is_due = self.step.is_multiple_of(CHANGE)
            && !(self.model.insertions.is_empty() && self.model.removals.is_empty());
        if !is_due && !self.moved.leaves {
            return Ok(());
        }
        let remembered = self.lists.remember(&self.balls);
        let removed = self.remove();
        let placed = if is_due { self.insert() } else { 0 };
        if removed + placed == 0 {
            return Ok(());
        }
        let numbers: Vec<u32> = {
            let places = self.balls.places.iter();
            places.map(|&place| self.balls.list[place as usize].number).collect()
        };
        let stays = |number: u32| numbers.binary_search(&number).is_ok();
        let remembered: Remembered =
            remembered.into_iter().filter(|([one, two], _)| stays(*one) && stays(*two)).collect();
        self.on_walls.touches.retain(|touch| stays(touch.number));
        self.search(&remembered)
    }

    /// Removes the spheres in boxes that remove them and those that have left the box. Returns how many.
    fn remove(&mut self) -> usize {
        let (time, gravity) = (self.time(), self.model.gravity);
        let Self { balls, model, cell, gone, clumps, .. } = self;
        let goes = |position: Vector| {
            model.removals.iter().any(|of| of.takes(position, time))
                || cell.is_some_and(|cell| cell.outside(position).is_some())
        };
        let (energy, going) = clumps.remove(balls, gravity, goes);
        gone.external -= energy;
        let goes = |place: usize| {
            let clump = going.get(balls.kinds[place].clump as usize);
            clump.copied().unwrap_or_else(|| goes(balls.list[place].position))
        };
        for &place in &balls.places {
            let (ball, drive) = (&balls.list[place as usize], &balls.drives[place as usize]);
            if !goes(place as usize) {
                continue;
            }
            gone.dissipated += drive.dissipated;
            gone.external += drive.external;
            if balls.kinds[place as usize].clump == ALONE {
                let energy = 0.5 * ball.mass * dot(drive.velocity, drive.velocity)
                    + 0.5 * balls.inertia(place as usize) * dot(drive.spin, drive.spin)
                    - ball.mass * dot(gravity, ball.position);
                gone.external -= energy;
            }
        }
        let goes: Vec<bool> = (0..balls.list.len()).map(goes).collect();
        balls.remove(|place, _| goes[place])
    }

    /// Lets the spheres come in that are due and find a place. Returns how many.
    fn insert(&mut self) -> usize {
        let (time, before) = (self.time(), self.balls.list.len());
        for number in 0..self.model.insertions.len() {
            let of = &self.model.insertions[number];
            let (first, due) = (self.placed[number] as usize, of.due(time));
            if first >= due {
                continue;
            }
            let mut spheres = Spheres::default();
            let is_clear = |centre, radius| self.is_clear(centre, radius);
            let mut taken = self.taken(of.region, &of.radii, &is_clear);
            for sphere in first..due {
                let Some(place) = of.place(sphere, self.step, &taken) else { break };
                self.images(place).for_each(|image| taken.add(image, of.radii[sphere]));
                spheres.positions.push(place);
                spheres.radii.push(of.radii[sphere]);
            }
            let count = spheres.positions.len();
            spheres.velocities = vec![of.velocity; count];
            spheres.spins = vec![of.spin; count];
            spheres.materials = vec![of.material; count];
            spheres.groups = vec![of.group; count];
            self.bring_in(&spheres);
            self.placed[number] += count as u32;
        }
        self.balls.list.len() - before
    }
}
