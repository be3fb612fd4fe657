//! `rstar`: an R*-tree loaded in bulk, one radius query per point.

use fdem_contact::Couple;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::{Peer, in_pieces};

pub(super) struct Rstar {
    pub(super) threads: usize,
}

impl<const D: usize> Peer<D> for Rstar {
    fn name(&self) -> &'static str {
        "rstar"
    }

    fn version(&self) -> String {
        super::locked("rstar")
    }

    fn how(&self) -> String {
        "`RTree::bulk_load` on one thread, `locate_within_distance` per point in the tree's order".to_owned()
    }

    fn couples(&mut self, points: &[[f64; D]], cutoff: f64, couples: &mut Vec<Couple>) -> Result<(), String> {
        couples.clear();
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
        Ok(())
    }
}
