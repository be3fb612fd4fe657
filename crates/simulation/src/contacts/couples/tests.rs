//! A second kind of bodies goes through the same couples and moves in the same way: spheres that turn, with a
//! linear contact and friction, among each other and on spheres that are fixed.

use std::ops::Range;

use super::*;
use crate::bodies::PartProperties;
use crate::contacts::pair::BatchWorks;
use crate::contacts::places::HistoryBatch;
use crate::lanes::{LANES, Lanes, set_row};
use crate::motion::{Freedoms, MotionSums, MovedNow};
use crate::random::uniform;
use crate::vector::{Point, add, at_most, cross3, dot, length, plus};

/// Normal and tangential stiffness of contacts, N/m, coefficient of friction, and time step, s.
const STIFFNESS: [f64; 2] = [1e5, 4e4];
const FRICTION: f64 = 0.3;
const STEP: f64 = 2e-5;
/// Number of spheres along an edge of the packing.
const EDGE: u32 = 11;

/// Motion of a sphere: position, m, velocity, m/s, and angular velocity, 1/s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sphere {
    centre: Point<3>,
    velocity: Point<3>,
    spin: Point<3>,
}

/// Spheres of one radius, m, and mass, kg.
#[derive(Clone, Debug, PartialEq)]
struct Spheres {
    radius: f64,
    mass: f64,
    all: Vec<Sphere>,
}

impl Bodies<3> for Spheres {
    /// The vector from the centre, m.
    type Place = Point<3>;

    fn bounds(&self, part: u32) -> [Point<3>; 2] {
        let centre = self.all[part as usize].centre;
        [centre.map(|x| x - self.radius), centre.map(|x| x + self.radius)]
    }

    fn velocity_on(&self, part: u32, arm: &Point<3>) -> Point<3> {
        let sphere = &self.all[part as usize];
        plus(sphere.velocity, cross3(sphere.spin, *arm))
    }

    fn properties(&self, _: u32) -> PartProperties {
        PartProperties { material: 0, length: self.radius, mass: self.mass }
    }

    fn acts(&self, _: u32) -> bool {
        true
    }

    fn counts(&self, _: u32) -> bool {
        true
    }
}

/// History and force of two spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SphereContact {
    overlap: f64,
    /// Tangential, and whole force on the first sphere, N.
    friction: Point<3>,
    force: Point<3>,
    /// From the centre of each sphere to the contact, m.
    arms: [Point<3>; 2],
}

const APART: SphereContact =
    SphereContact { overlap: 0.0, friction: [0.0; 3], force: [0.0; 3], arms: [[0.0; 3]; 2] };

impl HistoryBatch for [SphereContact; LANES] {
    type History = SphereContact;

    const NONE: Self = [APART; LANES];
    const NEW: SphereContact = APART;

    fn get(&self, lane: usize) -> SphereContact {
        self[lane]
    }

    fn set(&mut self, lane: usize, history: &SphereContact) {
        self[lane] = *history;
    }
}

#[derive(Clone, Debug)]
struct SpherePair;

impl Pair for SpherePair {
    type Between = ();
    type Histories = [SphereContact; LANES];
    type Forces = [SphereContact; LANES];

    const NO_FORCES: Self::Forces = [APART; LANES];
    const COST: u64 = 10;
}

/// Spheres among each other if they are `ALIKE`, or of two lists.
struct SpherePass<'a, const ALIKE: bool> {
    one: &'a Spheres,
    other: &'a Spheres,
    lists: [Vec<u32>; 2],
}

impl<'a, const ALIKE: bool> SpherePass<'a, ALIKE> {
    fn new(one: &'a Spheres, other: &'a Spheres) -> Self {
        let all = |spheres: &Spheres| (0..spheres.all.len() as u32).collect();
        Self { one, other, lists: [all(one), if ALIKE { Vec::new() } else { all(other) }] }
    }

    /// The vector between two centres, and the gap, m; negative if the spheres overlap.
    fn gap(&self, [a, b]: [u32; 2]) -> (Point<3>, f64) {
        let line = minus(self.one.all[a as usize].centre, self.other.all[b as usize].centre);
        (line, length(line) - self.one.radius - self.other.radius)
    }

    /// Relative velocity where a contact is, m/s.
    fn rate(&self, [a, b]: [u32; 2], contact: &SphereContact) -> Point<3> {
        let [arm, other] = &contact.arms;
        minus(self.one.velocity_on(a, arm), self.other.velocity_on(b, other))
    }
}

impl<const ALIKE: bool> PairPass<3> for SpherePass<'_, ALIKE> {
    type Pair = SpherePair;
    type One = Spheres;
    type Other = Spheres;
    /// Force and moment on each sphere of the first kind.
    type Target = [[Point<3>; 2]];
    type Work = Vec<f64>;

    const ALIKE: bool = ALIKE;
    const GROUP: usize = 1;

    fn one(&self) -> &Spheres {
        self.one
    }

    fn other(&self) -> &Spheres {
        self.other
    }

    fn searched(&self) -> [&[u32]; 2] {
        self.lists.each_ref().map(|list| &list[..])
    }

    fn couple(&self, parts: [u32; 2]) -> Option<Couple<()>> {
        Some(Couple::new(parts, (), Overlap::Counts))
    }

    fn distance(&self, couple: &Couple<()>, _: f64) -> Option<f64> {
        Some(self.gap(couple.parts).1).filter(|gap| *gap >= 0.0)
    }

    /// Gaps of the last batch.
    fn work(&self, _: f64) -> Vec<f64> {
        vec![0.0; LANES]
    }

    fn distances(&self, couples: &[Couple<()>], near: &[usize], _: &mut Vec<f64>, distances: &mut Lanes) {
        for (lane, &number) in near.iter().take(LANES).enumerate() {
            distances.set(lane, self.gap(couples[number].parts).1);
        }
    }

    fn press(
        &self,
        couples: &[Couple<()>],
        histories: &mut Histories<[SphereContact; LANES]>,
        batches: Range<usize>,
        found: &mut [[SphereContact; LANES]],
        works: &mut [BatchWorks],
        gaps: &mut Vec<f64>,
    ) {
        for lane in 0..LANES {
            let Some(number) = histories.couple(batches.start * LANES + lane) else { continue };
            let parts = couples[number].parts;
            let before = histories.batches[batches.start][lane];
            let (line, gap) = self.gap(parts);
            gaps[lane] = gap;
            let (normal, overlap) = (line.map(|x| x / length(line)), (-gap).max(0.0));
            let arms = [normal.map(|x| -self.one.radius * x), normal.map(|x| self.other.radius * x)];
            let mut now = SphereContact { overlap, arms, ..APART };
            let rate = self.rate(parts, &now);
            let push = STIFFNESS[0] * overlap;
            let mut tried = before.friction;
            add(&mut tried, rate, -STIFFNESS[1] * STEP);
            let across = dot(tried, normal);
            add(&mut tried, normal, -across);
            now.friction = at_most(tried, FRICTION * push);
            now.force = plus(normal.map(|x| push * x), now.friction);
            let [last, _] = self.last_works(parts, &before, STEP);
            let work = last - 0.5 * STEP * dot(now.friction, rate);
            set_row(&mut works[0], lane, &[0.5 * push * overlap, work, 0.0, 0.0, 0.0]);
            histories.batches[batches.start][lane] = now;
            found[0][lane] = now;
        }
    }

    fn overlaps(found: &[SphereContact; LANES], lane: usize) -> bool {
        found[lane].overlap > 0.0
    }

    fn distance_in(&self, gaps: &Vec<f64>, _: usize, lane: usize) -> f64 {
        gaps[lane]
    }

    fn last_works(&self, parts: [u32; 2], history: &SphereContact, step: f64) -> [f64; 2] {
        [-0.5 * step * dot(history.friction, self.rate(parts, history)), 0.0]
    }

    fn add(
        found: &[SphereContact; LANES],
        lane: usize,
        parts: [u32; 2],
        target: &mut [[Point<3>; 2]],
    ) -> bool {
        let SphereContact { force, arms, .. } = found[lane];
        for side in 0..if ALIKE { 2 } else { 1 } {
            let [sum, moment] = &mut target[parts[side] as usize];
            let sign = if side == 0 { 1.0 } else { -1.0 };
            add(sum, force, sign);
            add(moment, cross3(arms[side], force), sign);
        }
        false
    }

    fn force(history: &SphereContact) -> [Point<3>; 2] {
        [history.force, history.friction]
    }

    fn points(&self, couples: &[[u32; 2]]) -> Vec<Point<3>> {
        couples.iter().map(|&[a, _]| self.one.all[a as usize].centre).collect()
    }
}

/// Spheres that move under forces and moments.
struct SphereFreedoms<'a> {
    radius: f64,
    mass: f64,
    forces: &'a [[Point<3>; 2]],
}

impl Freedoms<3> for SphereFreedoms<'_> {
    type Moving<'m> = &'m mut Sphere;
    type Force = [Point<3>; 2];

    fn is_own(&self, _: usize) -> bool {
        true
    }

    fn force(&self, member: usize) -> [Point<3>; 2] {
        self.forces[member]
    }

    fn advance(
        &self,
        _: usize,
        sphere: &mut Sphere,
        [force, moment]: [Point<3>; 2],
        sum: &mut MotionSums<Pile, 3>,
    ) -> f64 {
        let inertia = 0.4 * self.mass * self.radius * self.radius;
        let before = *sphere;
        add(&mut sphere.velocity, force, STEP / self.mass);
        add(&mut sphere.spin, moment, STEP / inertia);
        add(&mut sphere.centre, sphere.velocity, STEP);
        let squares = [dot(before.velocity, sphere.velocity), dot(before.spin, sphere.spin)];
        sum.kinetic.add(0.5 * (self.mass * squares[0] + inertia * squares[1]), Grains::of(1.0));
        // Points of a sphere that turns in place do not come nearer to others.
        dot(sphere.velocity, sphere.velocity)
    }

    fn element(&self, member: usize) -> u32 {
        member as u32
    }
}

/// A run of spheres that move, on spheres that do not.
struct Heap {
    spheres: Spheres,
    floor: Spheres,
    team: Team,
    among: Couples<3, SpherePair>,
    on_floor: Couples<3, SpherePair>,
    /// Kinetic energy, and energy in contacts, at the beginning of the last step, and all work against
    /// friction until then, J.
    energies: [f64; 2],
    friction: Sum,
}

impl Heap {
    fn new(buffer: f64, threads: usize) -> Self {
        let team = Team::new(threads).unwrap();
        let grid = |count: [u32; 3], width: f64, corner: Point<3>| -> Vec<Sphere> {
            let all = 0..count[0] * count[1] * count[2];
            let at = |k: u32| [k % count[0], k / count[0] % count[1], k / count[0] / count[1]];
            let place = |k: u32| plus(corner, at(k).map(|x| width * f64::from(x)));
            all.map(|k| Sphere { centre: place(k), ..Sphere::default() }).collect()
        };
        let mut all = grid([EDGE; 3], 0.0201, [0.0; 3]);
        for (k, sphere) in (0..).zip(&mut all) {
            let random = |seed: u64| [0, 1, 2].map(|axis| uniform(seed, 3 * k + axis) - 0.5);
            sphere.velocity = plus(random(1), [0.0, 0.0, -1.0]);
            sphere.spin = random(2).map(|x| 100.0 * x);
        }
        let floor = grid([8, 8, 1], 0.06, [-0.1, -0.1, -0.062]);
        Self {
            spheres: Spheres { radius: 0.01, mass: 0.01, all },
            floor: Spheres { radius: 0.05, mass: 1.0, all: floor },
            among: Couples::new(buffer, &team).unwrap(),
            on_floor: Couples::new(buffer, &team).unwrap(),
            team,
            energies: [0.0; 2],
            friction: Sum::default(),
        }
    }

    /// Advances some steps. `check`: whether to compare the couples that touch with all pairs of spheres.
    fn run(&mut self, steps: usize, check: bool) {
        for step in 0..steps {
            let mut forces = vec![[[0.0; 3]; 2]; self.spheres.all.len()];
            let Self { spheres, floor, team, among, on_floor, .. } = self;
            let pass = SpherePass::<true>::new(spheres, spheres);
            let fixed = SpherePass::<false>::new(spheres, floor);
            if among.look(&pass, team).unwrap() {
                among.choose_near(&pass, team);
            }
            if on_floor.look(&fixed, team).unwrap() {
                on_floor.choose_near(&fixed, team);
            }
            let grains = Grains::of(1.0);
            let found = [
                among.press(&pass, &mut forces[..], STEP, grains, true, team),
                on_floor.press(&fixed, &mut forces[..], STEP, grains, true, team),
            ];
            if check && step % 50 == 0 {
                let [count, fixed_count] = [&*spheres, floor].map(|spheres| spheres.all.len() as u32);
                let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
                assert_eq!(found[0].count, pairs.filter(|pair| pass.gap(*pair).1 < 0.0).count());
                let pairs = (0..count).flat_map(|a| (0..fixed_count).map(move |b| [a, b]));
                assert_eq!(found[1].count, pairs.filter(|pair| fixed.gap(*pair).1 < 0.0).count());
            }
            for found in &found {
                self.friction.add_sum(&found.friction);
            }
            let stored = found.iter().flat_map(|found| &found.energy).map(Sum::value).sum();
            let Spheres { radius, mass, ref mut all } = *spheres;
            let freedoms = SphereFreedoms { radius, mass, forces: &forces };
            let now = MovedNow { moves: |_| true, speed_limit: 100.0 };
            let mut moved = MotionSums::<Sum, 3>::default();
            moved.add_chunks(team.change_lanes::<1, _, _>(all, |first, chunk| {
                now.advance_chunk(&freedoms, first, chunk.iter_mut())
            }));
            assert_eq!(moved.runaway, None);
            for couples in [among, on_floor] {
                couples.note_motion(STEP * moved.fastest);
            }
            self.energies = [moved.kinetic.value(), stored];
        }
    }
}

#[test]
fn couples_are_found_and_energy_is_accounted_for() {
    let mut heap = Heap::new(0.004, 1);
    heap.run(1, true);
    let first: f64 = heap.energies.iter().sum();
    heap.run(1500, true);
    let [kinetic, stored] = heap.energies;
    let friction = heap.friction.value();
    assert!(friction > 0.05 * first && stored > 1e-4 * first, "{friction} {stored} of {first}");
    assert!((kinetic + stored + friction - first).abs() < 1e-3 * first, "{kinetic} {stored} {friction}");
    assert!(heap.among.detections > 3, "{} detections", heap.among.detections);
    assert!(heap.among.all.len() > 3 * CHUNK, "{} couples", heap.among.all.len());
    let fixed = SpherePass::<false>::new(&heap.spheres, &heap.floor);
    assert_eq!(heap.on_floor.forces(&fixed).len(), heap.on_floor.touching().count());
}

/// Neither threads, nor when couples are found again and how long they sleep, nor a resume change a bit:
/// histories stay with their couples.
#[test]
fn results_depend_on_the_spheres_alone() {
    let mut heap = Heap::new(0.004, 1);
    heap.run(1000, false);
    for (buffer, threads) in [(0.004, 3), (0.001, 1), (0.02, 2)] {
        let mut other = Heap::new(buffer, threads);
        other.run(500, false);
        let touching: Vec<_> = other.among.touching().collect();
        assert!(touching.iter().filter(|(_, contact)| contact.friction != [0.0; 3]).count() > 100);
        let mut resumed = Heap::new(buffer, threads);
        resumed.among.restore(touching.into_iter().rev().collect(), ());
        resumed.on_floor.restore(other.on_floor.touching().collect(), ());
        (resumed.spheres, resumed.friction) = (other.spheres, other.friction);
        resumed.run(500, false);
        assert_eq!(heap.spheres, resumed.spheres, "buffer {buffer}, {threads} threads");
        assert_eq!(heap.friction, resumed.friction, "buffer {buffer}, {threads} threads");
    }
}
