//! `rstar`: an R*-tree loaded in bulk, one query per point or box.

use fdem_contact::Couple;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{RTree, RTreeObject};

use super::bodies::Bodies;
use super::peer::{Peer, in_pieces};

pub(super) struct Rstar {
    pub(super) threads: usize,
}

impl Rstar {
    fn of_points<const D: usize>(&self, points: &[[f64; D]], cutoff: f64, couples: &mut Vec<Couple>) {
        let numbered = points.iter().zip(0_u32..).map(|(&point, i)| GeomWithData::new(point, i));
        let tree = RTree::bulk_load(numbered.collect());
        let order: Vec<_> = tree.iter().copied().collect();
        in_pieces(&order, self.threads, couples, |piece, found| {
            for point in piece {
                let i = point.data;
                for near in tree.locate_within_distance(*point.geom(), cutoff * cutoff) {
                    if near.data > i {
                        found.push(Couple::new(i, near.data));
                    }
                }
            }
        });
    }

    fn of_bounds<const D: usize>(&self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) {
        let numbered = (0..bodies.len()).zip(0_u32..).map(|(i, number)| {
            let [min, max] = bodies.bounds(i);
            GeomWithData::new(Rectangle::from_corners(min, max), number)
        });
        let tree = RTree::bulk_load(numbered.collect());
        let order: Vec<_> = tree.iter().copied().collect();
        in_pieces(&order, self.threads, couples, |piece, found| {
            for body in piece {
                let i = body.data;
                for near in tree.locate_in_envelope_intersecting(body.envelope()) {
                    if near.data > i && bodies.touch(i, near.data) {
                        found.push(Couple::new(i, near.data));
                    }
                }
            }
        });
    }
}

impl<const D: usize> Peer<D> for Rstar {
    fn name(&self) -> &'static str {
        "rstar"
    }

    fn version(&self) -> String {
        super::peer::locked("rstar")
    }

    fn how(&self) -> String {
        "`RTree::bulk_load` on one thread, `locate_within_distance` per point in the tree's order; of unlike spheres and boxes \
         `locate_in_envelope_intersecting`"
            .to_owned()
    }

    fn couples(&mut self, bodies: Bodies<'_, D>, couples: &mut Vec<Couple>) -> Result<(), String> {
        couples.clear();
        match bodies {
            Bodies::Points { points, cutoff } => self.of_points(points, cutoff, couples),
            _ => self.of_bounds(bodies, couples),
        }
        Ok(())
    }
}
