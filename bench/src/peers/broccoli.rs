//! `broccoli`: a tree of sweeps over the boxes around discs, in 2D only, followed by the exact test.

use broccoli::aabb::BBox;
use broccoli::{Tree, bbox, rect};
use fdem_contact::Couple;

use super::bodies::Bodies;
use super::peer::Peer;

pub(super) struct Broccoli {
    boxes: Vec<BBox<f64, u32>>,
}

impl Broccoli {
    pub(super) fn new() -> Self {
        Self { boxes: Vec::new() }
    }
}

impl Peer<2> for Broccoli {
    fn name(&self) -> &'static str {
        "broccoli"
    }

    fn version(&self) -> String {
        super::peer::locked("broccoli")
    }

    fn how(&self) -> String {
        "`Tree::new`, `find_colliding_pairs`, exact test; one thread".to_owned()
    }

    fn couples(&mut self, bodies: Bodies<'_, 2>, couples: &mut Vec<Couple>) -> Result<(), String> {
        let (points, cutoff) = bodies.points()?;
        couples.clear();
        // Slightly more than half, so that rounding loses no couple.
        let half = 0.5 * cutoff * (1.0 + 1e-12) + 1e-12;
        self.boxes.clear();
        self.boxes.extend(
            points
                .iter()
                .zip(0_u32..)
                .map(|(&[x, y], i)| bbox(rect(x - half, x + half, y - half, y + half), i)),
        );
        let mut tree = Tree::new(&mut self.boxes);
        tree.find_colliding_pairs(|a, b| {
            let (i, j) = (*a.unpack_inner(), *b.unpack_inner());
            if bodies.touch(i, j) {
                couples.push(Couple::new(i, j));
            }
        });
        Ok(())
    }
}
