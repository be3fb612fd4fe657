//! `kiddo`: an immutable k-d tree, one radius query per point.

use fdem_contact::Couple;
use kiddo::{Eytzinger, FlatVec, KdTree, SquaredEuclidean};

use super::{Peer, in_pieces};

pub(super) struct Kiddo {
    pub(super) threads: usize,
}

/// Points per leaf, as in the tree that kiddo recommends.
const BUCKET: usize = 32;

type Tree<const D: usize> = KdTree<f64, u32, Eytzinger, FlatVec<f64, u32, D, BUCKET>, D, BUCKET>;

macro_rules! peer {
    ($d:literal) => {
        impl Peer<$d> for Kiddo {
            fn name(&self) -> &'static str {
                "kiddo"
            }

            fn version(&self) -> String {
                super::locked("kiddo")
            }

            fn how(&self) -> String {
                "flat immutable tree, `within().unsorted().visit` per point in the tree's order".to_owned()
            }

            fn couples(
                &mut self,
                points: &[[f64; $d]],
                cutoff: f64,
                couples: &mut Vec<Couple>,
            ) -> Result<(), String> {
                couples.clear();
                let tree = if self.threads == 1 {
                    Tree::<$d>::new_from_slice(points)
                } else {
                    Tree::<$d>::new_from_slice_parallel(points)
                };
                let tree = tree.map_err(|error| error.to_string())?;
                let radius = cutoff * cutoff;
                let order: Vec<(u32, [f64; $d])> = tree.iter().collect();
                in_pieces(&order, self.threads, couples, |piece, found| {
                    for &(i, ref point) in piece {
                        let query = tree.query(point).within::<SquaredEuclidean<f64>>(radius).unsorted();
                        query.visit(|near| {
                            if near.item > i {
                                found.push(Couple::new(i, near.item));
                            }
                        });
                    }
                });
                Ok(())
            }
        }
    };
}

peer!(2);
peer!(3);
