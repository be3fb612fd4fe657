//! How many contacts point where.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::network::Network;

/// Sectors of the full circle in 2D, each around a multiple of 5 degrees.
const SECTORS_2D: usize = 72;
/// Sectors in 3D, each around a multiple of 15 degrees.
const SECTORS_3D: usize = 24;
/// Bands between planes at right angles to z, equally far from each other; an odd number, so that one lies around the equator.
const BANDS: usize = 9;

/// Roundings of the coordinates must not decide where a vertical contact goes.
const ALONG_Z: f64 = 1e-9;

/// A histogram of the directions from centre to centre of the couples: a rose in 2D, cells of equal solid angle in 3D.
///
/// A contact has no first element: each couple counts in its direction and in the opposite one. Sectors lie around the multiples of their width, the first
/// around the axis x, so that the directions of lattices are inside. In 3D bands of equal height in z have equal areas (Archimedes); each is cut
/// into sectors of the angle from x towards y. Contacts along z, up to `1e-9`, have no such angle and count as 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Directions {
    /// Bands in z from -1 to 1; 1 in 2D.
    pub bands: usize,
    /// Sectors of each band.
    pub sectors: usize,
    /// `bands * sectors` numbers, band after band, those of the lowest z first; their sum is twice the number of couples with a direction.
    pub counts: Vec<u64>,
    /// Couples with the same centre twice: they have no direction.
    pub without_direction: u64,
}

impl Directions {
    pub(crate) fn of<const D: usize>(network: &Network<'_, D>) -> Self {
        let (bands, sectors) = if D == 3 { (BANDS, SECTORS_3D) } else { (1, SECTORS_2D) };
        let mut counts = vec![0; bands * sectors];
        let mut without_direction = 0;
        for couple in network.couples.iter() {
            let Some(normal) = unit(network.space.branch(couple)) else {
                without_direction += 1;
                continue;
            };
            let along_z = normal[0].abs().max(normal[1].abs()) < ALONG_Z;
            let turn = if along_z { 0.0 } else { normal[1].atan2(normal[0]) / TAU };
            let angle = turn * sectors as f64;
            let sector = angle.round().rem_euclid(sectors as f64) as usize;
            let band = if D == 3 {
                ((f64::midpoint(normal[2], 1.0) * bands as f64) as usize).min(bands - 1)
            } else {
                0
            };
            counts[band * sectors + sector] += 1;
            // The number of sectors is even.
            let opposite = if along_z { 0 } else { (sector + sectors / 2) % sectors };
            counts[(bands - 1 - band) * sectors + opposite] += 1;
        }
        Self { bands, sectors, counts, without_direction }
    }
}

/// The direction of a vector, if it has one; extremely short and long vectors included.
pub(crate) fn unit<const D: usize>(vector: [f64; D]) -> Option<[f64; D]> {
    let largest = vector.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let scaled = vector.map(|x| x / largest);
    let length = scaled.iter().fold(0.0, |sum, x| sum + x * x).sqrt();
    Some(scaled.map(|x| x / length))
}
