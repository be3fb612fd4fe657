//! Cells of a plane on paper.

use super::paper::{FAINT, Paper};

/// A stretch of the plane that is drawn: y upwards in the plane, downwards on paper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    /// The lower left corner, in the plane.
    pub(crate) origin: [f64; 2],
    /// Edges, in the plane.
    pub(crate) size: [f64; 2],
    /// Pixels per length.
    pub(crate) scale: f64,
    /// The upper left corner, on paper.
    pub(crate) at: [f64; 2],
}

impl Frame {
    /// A point of the plane on paper.
    pub(crate) fn point(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (x, y) = (x - self.origin[0], self.size[1] - (y - self.origin[1]));
        [self.at[0] + self.scale * x, self.at[1] + self.scale * y]
    }

    /// A rectangle of the plane, from its lower left corner.
    pub(crate) fn rect(&self, paper: &mut Paper, [x, y]: [f64; 2], [width, height]: [f64; 2], style: &str) {
        paper.rect(self.point([x, y + height]), [width * self.scale, height * self.scale], style);
    }

    pub(crate) fn circle(&self, paper: &mut Paper, centre: [f64; 2], radius: f64, style: &str) {
        paper.circle(self.point(centre), radius * self.scale, style);
    }

    pub(crate) fn line(&self, paper: &mut Paper, from: [f64; 2], to: [f64; 2], style: &str) {
        paper.line(self.point(from), self.point(to), style);
    }

    /// Lines between cells with this edge, along the selected axes.
    pub(crate) fn grid(&self, paper: &mut Paper, edge: f64, along: [bool; 2]) {
        let style = format!("stroke=\"{FAINT}\" stroke-width=\"1\"");
        let [width, height] = self.size;
        let far = [self.origin[0] + width, self.origin[1] + height];
        if along[0] {
            for k in 0..=(width / edge).floor() as u32 {
                let x = self.origin[0] + f64::from(k) * edge;
                self.line(paper, [x, self.origin[1]], [x, far[1]], &style);
            }
        }
        if along[1] {
            for k in 0..=(height / edge).floor() as u32 {
                let y = self.origin[1] + f64::from(k) * edge;
                self.line(paper, [self.origin[0], y], [far[0], y], &style);
            }
        }
    }
}
