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

    fn stress(components: &[f64]) -> [[f64; 3]; 3] {
        let [xx, yy, zz, xy, yz, xz] = components.try_into().unwrap_or([0.0; 6]);
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }
}

fn gap(measure: Measure) -> f64 {
    if let Measure::Gap(distance) = measure { distance } else { 0.0 }
}
