//! `parry3d`: a hierarchy of the boxes, or of those around spheres, traversed against itself, followed by the
//! exact test.

use fdem_contact::Couple;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Vector;
use parry3d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};

use super::bodies::Bodies;
use super::peer::Peer;

pub(super) struct Parry {
    boxes: Vec<Aabb>,
    workspace: BvhWorkspace,
}

impl Parry {
    pub(super) fn new() -> Self {
        Self { boxes: Vec::new(), workspace: BvhWorkspace::default() }
    }
}

impl Peer<3> for Parry {
    fn name(&self) -> &'static str {
        "parry3d"
    }

    fn version(&self) -> String {
        super::peer::locked("parry3d")
    }

    fn how(&self) -> String {
        "`Bvh::from_leaves`, binned, f32 boxes rounded outwards; `traverse_bvtt_single_tree`; exact test in f64; one thread"
            .to_owned()
    }

    fn couples(&mut self, bodies: Bodies<'_, 3>, couples: &mut Vec<Couple>) -> Result<(), String> {
        couples.clear();
        self.boxes.clear();
        self.boxes.extend((0..bodies.len()).map(|i| {
            let [min, max] = bodies.bounds(i);
            let [x, y, z] = min.map(|x| (x as f32).next_down());
            let min = Vector::new(x, y, z);
            let [x, y, z] = max.map(|x| (x as f32).next_up());
            Aabb::new(min, Vector::new(x, y, z))
        }));
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &self.boxes);
        tree.traverse_bvtt_single_tree::<false>(&mut self.workspace, &mut |i, j| {
            if bodies.touch(i, j) {
                couples.push(Couple::new(i, j));
            }
        });
        Ok(())
    }
}
