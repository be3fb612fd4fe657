//! `kiddo`: an immutable k-d tree, one radius query per point.

use fdem_contact::Couple;
use kiddo::{Eytzinger, FlatVec, KdTree, SquaredEuclidean};

use super::bodies::Bodies;
use super::peer::{Peer, in_pieces};

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
                super::peer::locked("kiddo")
            }

            fn how(&self) -> String {
                "flat immutable tree, `within().unsorted().visit` per point in the tree's order; of unlike spheres within the \
                 diameter of each, for those that are not larger"
                    .to_owned()
            }

            fn couples(
                &mut self,
                bodies: Bodies<'_, $d>,
                couples: &mut Vec<Couple>,
            ) -> Result<(), String> {
                let (points, sizes) = match bodies {
                    Bodies::Spheres { centres, radii } => (centres, Err(radii)),
                    _ => bodies.points().map(|(points, cutoff)| (points, Ok(cutoff)))?,
                };
                couples.clear();
                let tree = if self.threads == 1 {
                    Tree::<$d>::new_from_slice(points)
                } else {
                    Tree::<$d>::new_from_slice_parallel(points)
                };
                let tree = tree.map_err(|error| error.to_string())?;
                let order: Vec<(u32, [f64; $d])> = tree.iter().collect();
                in_pieces(&order, self.threads, couples, |piece, found| {
                    for &(i, ref point) in piece {
                        let radius = match sizes {
                            Ok(cutoff) => cutoff,
                            Err(radii) => 2.0 * radii[i as usize],
                        };
                        let query = tree.query(point).within::<SquaredEuclidean<f64>>(radius * radius).unsorted();
                        query.visit(|near| {
                            let j = near.item;
                            let found_here = match sizes {
                                Ok(_) => j > i,
                                // The larger sphere finds the smaller one.
                                Err(radii) => {
                                    let own = (radii[i as usize], i);
                                    (radii[j as usize], j) < own && bodies.touch(i, j)
                                }
                            };
                            if found_here {
                                found.push(Couple::new(i, j));
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
