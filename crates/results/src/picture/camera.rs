//! Projection of the scene onto the drawing.

use crate::picture::scene::Scene;

/// Sine and cosine of the two angles of the view in 3D: turned by 30 degrees, seen 20 degrees from above.
const TURN: [f64; 2] = [0.5, 0.866_025_403_784_438_6];
const TILT: [f64; 2] = [0.342_020_143_325_668_7, 0.939_692_620_785_908_4];

/// Parallel projection, so that sizes and the scale bar hold at every depth.
pub(crate) struct Camera {
    flat: bool,
    /// Pixels per unit of length.
    pub(crate) scale: f64,
    /// Projected point in the middle of the area.
    middle: [f64; 3],
    /// Width and height of the area, pixels.
    pub(crate) area: [f64; 2],
}

impl Camera {
    /// Shows all elements and the box in an area of `least` to `most` pixels. `None` if the extent is not
    /// finite.
    pub(crate) fn new(scene: &Scene, least: [f64; 2], most: [f64; 2]) -> Option<Self> {
        let flat = scene.dimensions == 2;
        let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        let mut include = |point: [f64; 3], radius: f64| {
            for (axis, x) in project(flat, point).into_iter().enumerate() {
                min[axis] = min[axis].min(x - radius);
                max[axis] = max[axis].max(x + radius);
            }
        };
        for (centre, radius) in scene.centres.iter().zip(&scene.radii) {
            include(*centre, *radius);
        }
        for [a, b] in outline(scene) {
            include(a, 0.0);
            include(b, 0.0);
        }
        for (corners, _) in scene.facets() {
            for corner in corners {
                include(corner, 0.0);
            }
        }
        if min[0] > max[0] {
            (min, max) = ([0.0; 3], [1.0; 3]);
        }
        let extent: [f64; 3] = std::array::from_fn(|axis| max[axis] - min[axis]);
        if !extent.iter().all(|x| x.is_finite()) {
            return None;
        }
        let scale = (0..2).map(|axis| most[axis] / extent[axis]).fold(f64::INFINITY, f64::min);
        // For points in one place, the scale is arbitrary.
        let scale = if scale.is_normal() { scale } else { 1.0 };
        Some(Self {
            flat,
            scale,
            middle: std::array::from_fn(|axis| min[axis] + extent[axis] / 2.0),
            area: std::array::from_fn(|axis| (extent[axis] * scale).clamp(least[axis], most[axis]).ceil()),
        })
    }

    /// Returns the position of a point in pixels from the upper left corner of the area, and towards the eye.
    pub(crate) fn place(&self, point: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = project(self.flat, point);
        [
            (x - self.middle[0]) * self.scale + self.area[0] / 2.0,
            (self.middle[1] - y) * self.scale + self.area[1] / 2.0,
            (z - self.middle[2]) * self.scale,
        ]
    }

    /// Names of the axes and their directions in the drawing, with y downwards.
    pub(crate) fn axes(&self) -> Vec<(&'static str, [f64; 2])> {
        let count = if self.flat { 2 } else { 3 };
        let axis = |k: usize| {
            let [x, y, _] = project(self.flat, std::array::from_fn(|axis| f64::from(u8::from(axis == k))));
            (["x", "y", "z"][k], [x, -y])
        };
        (0..count).map(axis).collect()
    }
}

/// Returns coordinates to the right, up and towards the eye. In 3D, z points upwards.
fn project(flat: bool, [x, y, z]: [f64; 3]) -> [f64; 3] {
    if flat {
        return [x, y, 0.0];
    }
    let behind = TURN[1] * y - TURN[0] * x;
    [TURN[1] * x + TURN[0] * y, TILT[1] * z + TILT[0] * behind, TILT[0] * z - TILT[1] * behind]
}

/// The edges of the box.
pub(crate) fn outline(scene: &Scene) -> Vec<[[f64; 3]; 2]> {
    let Some((origin, edges)) = &scene.cell else { return Vec::new() };
    let corner = |bits: usize| {
        let mut point = *origin;
        for (k, edge) in edges.iter().enumerate().filter(|(k, _)| bits >> k & 1 == 1) {
            debug_assert!(k < 3, "boxes have an edge for each axis");
            for axis in 0..3 {
                point[axis] += edge[axis];
            }
        }
        point
    };
    let count = edges.len();
    let mut lines = Vec::new();
    for bits in 0..1_usize << count {
        for k in (0..count).filter(|k| bits >> k & 1 == 0) {
            lines.push([corner(bits), corner(bits | 1 << k)]);
        }
    }
    lines
}
