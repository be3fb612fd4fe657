//! The fabric tensor.

use serde::Serialize;

use crate::arrays::each;

/// Fabric tensor `F = 1/m Σ n ⊗ n` over the `m` couples with a direction, where `n` is the unit vector from
/// centre to centre.
///
/// Its trace is 1. For isotropic contacts, `F = 1/D` in every direction. The second-order density of
/// directions with this fabric is `E(n) = (1 + a n·F'n) / (area of the unit sphere)` with `F' = F - 1/D` and
/// `a = D (D + 2) / 2`; in 2D this is `(1 + a_c cos 2(θ - θ_1)) / 2π`.
///
/// # Source
/// M. Satake, "Fabric tensor in granular materials", IUTAM Conf. on Deformation and Failure of Granular
/// Materials (1982) 63–68; M. Oda, Soils Found. 22 (4) (1982) 96–108; K. Kanatani, Int. J. Engng Sci. 22
/// (1984) 149–164. `a_c`: L. Rothenburg, R.J. Bathurst, Géotechnique 39 (1989) 601–614 in 2D; N. Guo, J.
/// Zhao, Comput. Geotech. 47 (2013) 1–15 in 3D, `√(3/2 a:a)` of `a = 15/2 F'`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fabric {
    /// `F`, row by row.
    pub tensor: Vec<Vec<f64>>,
    /// Eigenvalues, the largest first.
    pub eigenvalues: Vec<f64>,
    /// Principal directions in the same order, as unit vectors whose largest component is positive.
    pub principal_directions: Vec<Vec<f64>>,
    /// Size of the deviator, `√(D / (D - 1) F':F')`: 0 for isotropic contacts, 1 for contacts in one
    /// direction. In 2D it is the difference of the eigenvalues.
    pub deviator: f64,
    /// Anisotropy `a_c`: `2 deviator` in 2D, `15/2 deviator` in 3D.
    pub anisotropy: f64,
}

/// `Σ n ⊗ n` and the number of couples with a direction, for a part of the couples.
#[derive(Clone, Copy)]
pub(crate) struct FabricSum<const D: usize> {
    sum: [[f64; D]; D],
    couples: u64,
}

impl<const D: usize> FabricSum<D> {
    pub(crate) const NONE: Self = Self { sum: [[0.0; D]; D], couples: 0 };

    /// Adds a couple by its unit vector.
    #[inline]
    pub(crate) fn add(&mut self, normal: Option<[f64; D]>) {
        let Some(normal) = normal else { return };
        self.couples += 1;
        for row in 0..D {
            for column in 0..D {
                self.sum[row][column] += normal[row] * normal[column];
            }
        }
    }
}

impl Fabric {
    /// Returns the fabric tensor, or `None` if no couple has a direction.
    pub(crate) fn of<'a, const D: usize>(parts: impl Iterator<Item = &'a FabricSum<D>>) -> Option<Self> {
        let mut sum = [[0.0; D]; D];
        let mut couples = 0;
        for part in parts {
            couples += part.couples;
            for (row, more) in sum.iter_mut().zip(part.sum) {
                for (entry, more) in row.iter_mut().zip(more) {
                    *entry += more;
                }
            }
        }
        if couples == 0 {
            return None;
        }
        let tensor = sum.map(|row| row.map(|entry| entry / couples as f64));
        let (eigenvalues, directions) = eigen(tensor);
        let d = D as f64;
        let mut squares = 0.0;
        for (row, entries) in tensor.iter().enumerate() {
            for (column, entry) in entries.iter().enumerate() {
                let part = if row == column { entry - 1.0 / d } else { *entry };
                squares += part * part;
            }
        }
        let deviator = (d / (d - 1.0) * squares).sqrt();
        let anisotropy = deviator * if D == 2 { 2.0 } else { 7.5 };
        Some(Self {
            tensor: tensor.iter().map(|row| row.to_vec()).collect(),
            eigenvalues: eigenvalues.to_vec(),
            principal_directions: directions.iter().map(|row| row.to_vec()).collect(),
            deviator,
            anisotropy,
        })
    }
}

/// Returns the eigenvalues of a symmetric matrix, the largest first, and its unit eigenvectors, by Jacobi
/// rotations (1846).
fn eigen<const D: usize>(mut matrix: [[f64; D]; D]) -> ([f64; D], [[f64; D]; D]) {
    /// Convergence is quadratic: 3 x 3 matrices take some 6 sweeps.
    const MOST_SWEEPS: usize = 50;
    let mut vectors: [[f64; D]; D] = each(|row| each(|column| f64::from(u8::from(row == column))));
    for _ in 0..MOST_SWEEPS {
        let mut rotated = false;
        for p in 0..D {
            for q in p + 1..D {
                let off = matrix[p][q];
                // The entry is too small to change the eigenvalues.
                if matrix[p][p].abs() + off == matrix[p][p].abs()
                    && matrix[q][q].abs() + off == matrix[q][q].abs()
                {
                    continue;
                }
                rotated = true;
                let cot = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
                let tan = cot.signum() / (cot.abs() + cot.hypot(1.0));
                let cos = 1.0 / tan.hypot(1.0);
                let sin = tan * cos;
                for row in &mut matrix {
                    (row[p], row[q]) = (cos * row[p] - sin * row[q], sin * row[p] + cos * row[q]);
                }
                for column in 0..D {
                    let (a, b) = (matrix[p][column], matrix[q][column]);
                    (matrix[p][column], matrix[q][column]) = (cos * a - sin * b, sin * a + cos * b);
                    let (a, b) = (vectors[p][column], vectors[q][column]);
                    (vectors[p][column], vectors[q][column]) = (cos * a - sin * b, sin * a + cos * b);
                }
            }
        }
        if !rotated {
            break;
        }
    }
    let mut order: [usize; D] = each(|k| k);
    order.sort_by(|&a, &b| matrix[b][b].total_cmp(&matrix[a][a]));
    let signed = |vector: [f64; D]| {
        let largest =
            vector.iter().fold(0.0_f64, |largest, &x| if x.abs() > largest.abs() { x } else { largest });
        // Adding 0.0 turns -0.0 into 0.0.
        if largest < 0.0 { vector.map(|x| -x + 0.0) } else { vector.map(|x| x + 0.0) }
    };
    (order.map(|k| matrix[k][k]), order.map(|k| signed(vectors[k])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_make_the_matrix() {
        let matrix = [[2.0, -1.0, 0.25], [-1.0, 0.5, 3.0], [0.25, 3.0, -1.5]];
        let (values, vectors) = eigen(matrix);
        assert!(values[0] > values[1] && values[1] > values[2], "{values:?}");
        for row in 0..3 {
            for column in 0..3 {
                let sum: f64 = (0..3).map(|k| values[k] * vectors[k][row] * vectors[k][column]).sum();
                assert!((sum - matrix[row][column]).abs() < 1e-14);
                let product: f64 = (0..3).map(|k| vectors[row][k] * vectors[column][k]).sum();
                assert!((product - f64::from(u8::from(row == column))).abs() < 1e-14);
            }
        }
        assert_eq!(eigen([[0.0, 0.0], [0.0, 1.0]]), ([1.0, 0.0], [[0.0, 1.0], [1.0, 0.0]]));
        let (values, _) = eigen([[0.5, 0.5], [0.5, 0.5]]);
        assert!((values[0] - 1.0).abs() < 1e-15 && values[1].abs() < 1e-15);
    }
}
