//! Spheres that overlap push each other apart until they do not.
//!
//! The overlaps of all pairs are springs. Their energy is minimised by the fast inertial relaxation engine
//! (Bitzek, Koskinen, Gähler, Moseler and Gumbsch 2006): spheres move under the forces, are slowed where they
//! move against them, and sped up along them. Below the density of random close packing, about 0.64 for equal
//! spheres (O'Hern, Silbert, Liu and Nagel 2003), the energy falls to 0.

use std::sync::Arc;

use fdem_contact::{Buffered, Detector, Elements};
use fdem_scenes::random::Random;
use rayon::prelude::*;

use crate::pack::region::PackRegion;
use crate::vector::{Vector, dot, length, minus, plus, times};

/// Gap up to which spheres are candidates, as a share of their mean radius.
const BUFFER: f64 = 0.25;

/// Spheres that a thread computes at a time; sums are added up in the order of these chunks.
const CHUNK: usize = 1024;

/// Share by which springs are longer than the radii are together, so that they end without overlap.
pub(crate) const MARGIN: f64 = 5e-4;

/// Stream of a seed from which the first shake is drawn.
const SHAKES: u64 = 64;

/// Numbers of the relaxation engine: time steps at the beginning and at most over the period of a spring, the
/// share of the velocity that is turned along the forces, factors, and the steps before they act.
const STEPS: [f64; 2] = [0.1, 0.5];
const TURNED: f64 = 0.1;
const LONGER: f64 = 1.1;
const SHORTER: f64 = 0.5;
const LESS_TURNED: f64 = 0.99;
const PATIENCE: u32 = 5;

/// Largest way of a sphere in a step over its radius.
const STRIDE: f64 = 0.1;

/// Share of its radius within which the gap between spheres that are jammed is not counted.
const JAMMED: f64 = 1e-3;

/// Spheres in a region.
pub(crate) struct Relaxing<'a> {
    pub(crate) region: &'a PackRegion,
    pub(crate) discs: bool,
    pub(crate) positions: Vec<Vector>,
    /// m. The first `free` of them move.
    pub(crate) radii: Vec<f64>,
    pub(crate) free: usize,
    pub(crate) gap: f64,
    pub(crate) pool: Arc<rayon::ThreadPool>,
}

/// Sums over all spheres in one step.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Work of the forces in a unit of time.
    power: f64,
    /// Squares of velocities and forces, weighted by mass.
    velocity: f64,
    force: f64,
    /// Largest overlap, as a share of the sum of the radii.
    overlap: f64,
    /// Largest force on a sphere, over the length of the longest spring on it.
    unbalanced: f64,
}

impl Sums {
    fn with(self, other: Self) -> Self {
        Self {
            power: self.power + other.power,
            velocity: self.velocity + other.velocity,
            force: self.force + other.force,
            overlap: self.overlap.max(other.overlap),
            unbalanced: self.unbalanced.max(other.unbalanced),
        }
    }
}

/// Candidates of each sphere, ascending.
#[derive(Default)]
struct PackLists {
    first: Vec<u32>,
    others: Vec<u32>,
}

impl PackLists {
    /// The lists of both spheres of each couple.
    fn of(couples: &[fdem_contact::Couple], count: usize) -> Self {
        let mut first = vec![0_u32; count + 1];
        for couple in couples {
            first[couple.i as usize + 1] += 1;
            first[couple.j as usize + 1] += 1;
        }
        for sphere in 0..count {
            first[sphere + 1] += first[sphere];
        }
        let mut next = first.clone();
        let mut others = vec![0; 2 * couples.len()];
        for couple in couples {
            let [i, j] = [couple.i, couple.j];
            for (of, other) in [(i, j), (j, i)] {
                others[next[of as usize] as usize] = other;
                next[of as usize] += 1;
            }
        }
        for sphere in 0..count {
            others[first[sphere] as usize..first[sphere + 1] as usize].sort_unstable();
        }
        Self { first, others }
    }

    fn at(&self, sphere: usize) -> &[u32] {
        &self.others[self.first[sphere] as usize..self.first[sphere + 1] as usize]
    }
}

impl Relaxing<'_> {
    /// Moves each sphere at random by up to a share of its radius. Jammed spheres get denser by it.
    pub(crate) fn shake(&mut self, share: f64, seed: u64, number: u64) {
        let mut random = Random::with_stream(seed, SHAKES + number);
        for (position, radius) in self.positions[..self.free].iter_mut().zip(&self.radii) {
            for x in position.iter_mut().take(if self.discs { 2 } else { 3 }) {
                *x += share * radius * random.between(-1.0, 1.0);
            }
        }
    }

    /// Moves the spheres until none overlap, for `most` steps at most; returns whether that is so.
    ///
    /// # Errors
    /// The reason why the search for overlaps failed.
    pub(crate) fn relax(&mut self, most: u32) -> Result<bool, String> {
        let pool = Arc::clone(&self.pool);
        pool.install(|| self.relaxed(most))
    }

    fn relaxed(&mut self, most: u32) -> Result<bool, String> {
        let count = self.positions.len();
        let mean = self.radii.iter().sum::<f64>() / count.max(1) as f64;
        let detector = Detector::new().on_pool(Arc::clone(&self.pool));
        let mut search = Buffered::with_search(detector, BUFFER * mean).map_err(|error| error.to_string())?;
        // Springs of two spheres are as long as their reaches are together.
        let reaches: Vec<f64> =
            self.radii.iter().map(|radius| radius * (1.0 + MARGIN) + 0.5 * self.gap).collect();
        let least = self.radii[..self.free].iter().copied().fold(f64::INFINITY, f64::min);
        let masses: Vec<f64> = self.radii[..self.free]
            .iter()
            .map(|radius| if self.discs { radius / least } else { (radius / least).powi(2) })
            .collect();
        let mut velocities = vec![[0.0; 3]; self.free];
        let mut forces = vec![[0.0; 3]; self.free];
        let mut lists = PackLists::default();
        let (mut step, mut turned, mut downhill) = (STEPS[0], TURNED, 0);
        for _ in 0..most {
            let elements = Elements::spheres_with_radii(&self.positions, &reaches);
            let update = elements.and_then(|elements| {
                search.update(&elements).map(|update| {
                    if update.redetected() {
                        lists = PackLists::of(update.candidates(), count);
                    }
                })
            });
            update.map_err(|error| error.to_string())?;
            let sums = self.push(&lists, &reaches, &masses, &velocities, &mut forces);
            if sums.overlap <= 0.5 * MARGIN {
                return Ok(true);
            }
            if sums.unbalanced < JAMMED * sums.overlap {
                return Ok(false);
            }
            if sums.power > 0.0 {
                downhill += 1;
                if downhill > PATIENCE {
                    step = (LONGER * step).min(STEPS[1]);
                    turned *= LESS_TURNED;
                }
            } else {
                (step, turned, downhill) = (SHORTER * step, TURNED, 0);
                velocities.fill([0.0; 3]);
            }
            let along = if sums.power > 0.0 && sums.force > 0.0 {
                turned * (sums.velocity / sums.force).sqrt()
            } else {
                0.0
            };
            let kept = if sums.power > 0.0 { 1.0 - turned } else { 1.0 };
            self.go(&masses, &forces, &mut velocities, [step, kept, along]);
        }
        Ok(false)
    }

    /// Computes the forces of all springs.
    fn push(
        &self,
        lists: &PackLists,
        reaches: &[f64],
        masses: &[f64],
        velocities: &[Vector],
        forces: &mut [Vector],
    ) -> Sums {
        let chunks: Vec<Sums> = forces
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map(|(chunk, forces)| {
                let mut sums = Sums::default();
                for (place, force) in forces.iter_mut().enumerate() {
                    let sphere = chunk * CHUNK + place;
                    let (total, overlap) = self.push_on(sphere, lists.at(sphere), reaches);
                    *force = total;
                    let size = dot(total, total);
                    sums = sums.with(Sums {
                        power: dot(total, velocities[sphere]),
                        velocity: masses[sphere] * dot(velocities[sphere], velocities[sphere]),
                        force: size / masses[sphere],
                        overlap,
                        unbalanced: size.sqrt() / reaches[sphere],
                    });
                }
                sums
            })
            .collect();
        chunks.into_iter().fold(Sums::default(), Sums::with)
    }

    /// The force on a sphere, and its largest overlap as a share of the radii.
    fn push_on(&self, sphere: usize, others: &[u32], reaches: &[f64]) -> (Vector, f64) {
        let (centre, reach) = (self.positions[sphere], reaches[sphere]);
        let (mut total, mut most) = ([0.0; 3], 0.0_f64);
        for &other in others {
            let arm = minus(centre, self.positions[other as usize]);
            let long = reach + reaches[other as usize];
            let squared = dot(arm, arm);
            if squared >= long * long {
                continue;
            }
            let distance = squared.sqrt();
            // Two centres at one place part along x, in the order of their numbers.
            let normal = if distance > 0.0 {
                times(1.0 / distance, arm)
            } else {
                [if (sphere as u32) < other { -1.0 } else { 1.0 }, 0.0, 0.0]
            };
            let overlap = long - distance;
            total = plus(total, times(overlap, normal));
            most = most.max(overlap / long);
        }
        // As wide as the spring of two spheres.
        let wide = reach + 0.5 * self.gap;
        self.region.near_sides(centre, wide, self.discs, &mut |distance, inward| {
            total = plus(total, times(wide - distance, inward));
            most = most.max((wide - distance) / wide);
        });
        (total, most)
    }

    /// Moves all spheres by a step. `[step, kept, along]`: its length, the share of the velocity that is
    /// kept, and the factor of the acceleration that is added to it.
    fn go(
        &mut self,
        masses: &[f64],
        forces: &[Vector],
        velocities: &mut [Vector],
        [step, kept, along]: [f64; 3],
    ) {
        let radii = &self.radii;
        let free = &mut self.positions[..self.free];
        free.par_chunks_mut(CHUNK).zip(velocities.par_chunks_mut(CHUNK)).enumerate().for_each(
            |(chunk, (positions, velocities))| {
                for (place, (position, velocity)) in positions.iter_mut().zip(velocities).enumerate() {
                    let sphere = chunk * CHUNK + place;
                    let acceleration = times(1.0 / masses[sphere], forces[sphere]);
                    let next = plus(times(kept, *velocity), times(along + step, acceleration));
                    let (way, most) = (step * length(next), STRIDE * radii[sphere]);
                    *velocity = if way > most { times(most / way, next) } else { next };
                    *position = plus(*position, times(step, *velocity));
                }
            },
        );
    }
}
