//! `zelll`: cell lists in a hash map. It returns candidates; the caller tests the distance.

use fdem_contact::Couple;
use rayon::iter::ParallelIterator;
use zelll::{CellGrid, ParticleLike};

use super::bodies::Bodies;
use super::bodies::within;
use super::peer::Peer;

pub(super) struct Zelll<const D: usize> {
    threads: usize,
    grid: CellGrid<Point<D>, D, f64>,
}

impl<const D: usize> Zelll<D> {
    pub(super) fn new(threads: usize) -> Self {
        Self { threads, grid: CellGrid::default() }
    }
}

/// A point with its number.
#[derive(Clone, Copy, Debug)]
struct Point<const D: usize> {
    id: u32,
    at: [f64; D],
}

impl<const D: usize> Default for Point<D> {
    fn default() -> Self {
        Self { id: 0, at: [0.0; D] }
    }
}

impl<const D: usize> ParticleLike<[f64; D]> for Point<D> {
    fn coords(&self) -> [f64; D] {
        self.at
    }
}

impl<const D: usize> Peer<D> for Zelll<D> {
    fn name(&self) -> &'static str {
        "zelll"
    }

    fn version(&self) -> String {
        super::peer::locked("zelll")
    }

    fn how(&self) -> String {
        "`CellGrid::rebuild_mut` with the largest distance, `particle_pairs` of the cells filtered".to_owned()
    }

    fn couples(&mut self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) -> Result<(), String> {
        let (points, cutoff) = match bodies {
            Bodies::Spheres { centres, radii } => (centres, 2.0 * radii.iter().copied().fold(0.0, f64::max)),
            _ => bodies.points()?,
        };
        couples.clear();
        let numbered = points.iter().zip(0..).map(|(&at, id)| Point { id, at });
        self.grid.rebuild_mut(numbered, Some(cutoff));
        let touch = |a: &Point<D>, b: &Point<D>| match bodies {
            // The coordinates are already available.
            Bodies::Points { .. } => within(&a.at, &b.at, cutoff),
            _ => bodies.touch(a.id, b.id),
        };
        if self.threads == 1 {
            for cell in self.grid.iter() {
                cell.particle_pairs().for_each(|(a, b)| {
                    if touch(a, b) {
                        couples.push(Couple::new(a.id, b.id));
                    }
                });
            }
            return Ok(());
        }
        let pieces = self.grid.par_iter().fold(Vec::new, |mut found, cell| {
            cell.particle_pairs().for_each(|(a, b)| {
                if touch(a, b) {
                    found.push(Couple::new(a.id, b.id));
                }
            });
            found
        });
        for piece in pieces.collect::<Vec<_>>() {
            couples.extend_from_slice(&piece);
        }
        Ok(())
    }
}
