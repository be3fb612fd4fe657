//! The differences between models in two and in three dimensions.

use fdem_contact::narrow::{Measure, Tetrahedron, Triangle, tetrahedron_tetrahedron, triangle_triangle_2d};

use crate::bodies::dimensions::Dimensions;
use crate::bodies::{plane, space};
use crate::joints::lines::JointLines;
use crate::shapes::piece::Piece;
use crate::text::fault::Problem;
use crate::text::file::{Body, ModelFile};
use crate::text::included::Load;

impl Dimensions<2, 3> for [[f64; 2]; 3] {
    const OUTER_FACET: &'static str = "edge of an outline";

    fn pieces(
        file: &ModelFile,
        body: &Body,
        joints: &JointLines<'_>,
        load: &mut Load<'_>,
    ) -> Result<Vec<Piece>, Problem> {
        plane::pieces(file, body, joints, load)
    }

    fn gap(&self, other: &Self) -> Option<f64> {
        let [Ok(one), Ok(other)] = [self, other].map(|corners| Triangle::new(*corners)) else { return None };
        Some(gap(triangle_triangle_2d(&one, &other, &mut Vec::new()).measure))
    }

    fn turn(angle: f64, _: Option<[f64; 3]>) -> [[f64; 2]; 2] {
        let (sine, cosine) = libm::sincos(angle.to_radians());
        [[cosine, -sine], [sine, cosine]]
    }

    fn seen([a, b]: [[f64; 2]; 2]) -> f64 {
        let (cross, dot) = (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
        libm::atan2(cross, dot) / (2.0 * std::f64::consts::PI)
    }

    fn stress(components: &[f64]) -> [[f64; 2]; 2] {
        let [xx, yy, xy] = components.try_into().unwrap_or([0.0; 3]);
        [[xx, xy], [xy, yy]]
    }
}

impl Dimensions<3, 4> for [[f64; 3]; 4] {
    const OUTER_FACET: &'static str = "outer face";

    fn pieces(
        file: &ModelFile,
        body: &Body,
        joints: &JointLines<'_>,
        load: &mut Load<'_>,
    ) -> Result<Vec<Piece<3, 4>>, Problem> {
        space::pieces(file, body, joints, load)
    }

    fn gap(&self, other: &Self) -> Option<f64> {
        let [Ok(one), Ok(other)] = [self, other].map(|corners| Tetrahedron::new(*corners)) else {
            return None;
        };
        Some(gap(tetrahedron_tetrahedron(&one, &other).measure))
    }

    /// Rodrigues' formula.
    fn turn(angle: f64, axis: Option<[f64; 3]>) -> [[f64; 3]; 3] {
        let (sine, cosine) = libm::sincos(angle.to_radians());
        let axis = axis.unwrap_or([0.0, 0.0, 1.0]);
        let length = axis.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [x, y, z] = axis.map(|component| component / length);
        let across = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
        let along = [x, y, z];
        std::array::from_fn(|i| {
            std::array::from_fn(|k| {
                let one = f64::from(u8::from(i == k));
                one * cosine + sine * across[i][k] + (1.0 - cosine) * along[i] * along[k]
            })
        })
    }

    /// A. Van Oosterom and J. Strackee, *The solid angle of a plane triangle*, IEEE Trans. Biomed. Eng. 30
    /// (1983) 125.
    fn seen([a, b, c]: [[f64; 3]; 3]) -> f64 {
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        let [la, lb, lc] = [a, b, c].map(|x| dot(x, x).sqrt());
        let under = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        libm::atan2(dot(a, cross), under) / (2.0 * std::f64::consts::PI)
    }

    fn stress(components: &[f64]) -> [[f64; 3]; 3] {
        let [xx, yy, zz, xy, yz, xz] = components.try_into().unwrap_or([0.0; 6]);
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }
}

fn gap(measure: Measure) -> f64 {
    if let Measure::Gap(distance) = measure { distance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen from within, a closed surface fills the full angle; with its outer sides inwards, that of a hole,
    /// it is negative; from outside its two sides cancel.
    #[test]
    fn a_closed_surface_is_seen_all_around_from_within() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let from = |[x, y]: [f64; 2]| -> f64 {
            let place = |k: usize| [square[k % 4][0] - x, square[k % 4][1] - y];
            (0..4).map(|k| <[[f64; 2]; 3]>::seen([place(k), place(k + 1)])).sum()
        };
        assert!((from([0.3, 0.9]) - 1.0).abs() < 1e-12 && from([1.5, 0.2]).abs() < 1e-12);
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let from = |at: [f64; 3], turned: bool| -> f64 {
            let of = |mut face: [usize; 3]| {
                if turned {
                    face.swap(0, 1);
                }
                <[[f64; 3]; 4]>::seen(face.map(|k| std::array::from_fn(|axis| corners[k][axis] - at[axis])))
            };
            faces.into_iter().map(of).sum()
        };
        assert!((from([0.1, 0.3, 0.2], false) - 1.0).abs() < 1e-12);
        assert!((from([0.1, 0.3, 0.2], true) + 1.0).abs() < 1e-12);
        assert!(from([0.9, 0.9, 0.2], false).abs() < 1e-12);
    }
}
