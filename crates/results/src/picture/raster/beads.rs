//! Spheres and rods among the triangles of a picture that is drawn in bands.

use crate::picture::colour::Rgb;
use crate::picture::raster::buffer::Raster;

/// A sphere in pixels: x to the right and y down from the upper left corner, z towards the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bead {
    pub(crate) centre: [f64; 3],
    pub(crate) radius: f64,
    pub(crate) colour: Rgb,
}

/// A rod with round ends in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rod {
    pub(crate) ends: [[f64; 3]; 2],
    pub(crate) radius: f64,
    pub(crate) colour: Rgb,
}

/// Spheres and rods of the first layer of a picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Beads {
    pub(crate) spheres: Vec<Bead>,
    pub(crate) rods: Vec<Rod>,
}

/// Beads in the order of their first rows.
pub(super) struct BeadSweep<'a> {
    beads: &'a Beads,
    /// First row, end of the rows, and number: of spheres, and of rods after them.
    rows: Vec<[usize; 3]>,
    started: usize,
    active: Vec<[usize; 3]>,
}

impl<'a> BeadSweep<'a> {
    pub(super) fn new(beads: &'a Beads, [width, height]: [usize; 2]) -> Self {
        let of_spheres = beads.spheres.iter().map(|bead| ([bead.centre; 2], bead.radius));
        let of_rods = beads.rods.iter().map(|rod| (rod.ends, rod.radius));
        let mut rows: Vec<[usize; 3]> = of_spheres
            .chain(of_rods)
            .enumerate()
            .filter_map(|(number, (ends, radius))| {
                let [[left, right], [top, bottom]] = [0, 1].map(|axis| {
                    let [a, b] = ends.map(|end| end[axis]);
                    // A pixel more on each side: small ones are drawn larger.
                    [a.min(b) - radius - 1.0, a.max(b) + radius + 1.0]
                });
                let is_seen = right >= 0.0 && left <= width as f64 && bottom >= 0.0 && top <= height as f64;
                let is_finite = ends.as_flattened().iter().all(|x| x.is_finite()) && radius.is_finite();
                (is_seen && is_finite).then(|| [top.max(0.0) as usize, bottom.ceil() as usize + 1, number])
            })
            .collect();
        rows.sort_unstable();
        Self { beads, rows, started: 0, active: Vec::new() }
    }

    /// Draws the beads in the first `rows` rows of a band.
    pub(super) fn draw<const S: usize>(&mut self, band: &mut Raster<S>, rows: usize) {
        let end = band.top + rows;
        while let Some(&row) = self.rows.get(self.started).filter(|row| row[0] < end) {
            self.active.push(row);
            self.started += 1;
        }
        for &[_, _, number] in &self.active {
            if let Some(bead) = self.beads.spheres.get(number) {
                band.sphere(bead.centre, bead.radius, bead.colour);
            } else {
                let rod = &self.beads.rods[number - self.beads.spheres.len()];
                band.rod(rod.ends, rod.radius, rod.colour);
            }
        }
        self.active.retain(|row| row[1] > end);
    }
}
