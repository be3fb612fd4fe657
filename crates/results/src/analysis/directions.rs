//! Histogram of the directions of contacts.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::arrays::each;

/// Number of sectors in 2D, each around a multiple of 5 degrees.
const SECTORS_2D: usize = 72;
/// Number of sectors in 3D, each around a multiple of 15 degrees.
const SECTORS_3D: usize = 24;
/// Number of bands of equal height in z. It is odd, so that one band lies around the equator.
const BANDS: usize = 9;

/// Contacts this close to z count as vertical, so that rounding errors do not decide their sector.
const ALONG_Z: f64 = 1e-9;

/// Histogram of the directions from centre to centre of the couples: a rose in 2D, cells of equal solid angle
/// in 3D.
///
/// Each couple counts in its direction and in the opposite one. The sectors are centred on multiples of their
/// width, the first on the axis x, so that the directions of lattices lie inside of sectors. In 3D, bands of
/// equal height in z have equal areas (Archimedes); each band is divided into sectors by the angle from x
/// towards y. Contacts along z, up to `1e-9`, have no such angle and count as angle 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Directions {
    /// Number of bands in z from -1 to 1; 1 in 2D.
    pub bands: usize,
    /// Number of sectors of each band.
    pub sectors: usize,
    /// Counts of the `bands * sectors` cells, band by band from the lowest z. Their sum is twice the number
    /// of couples with a direction.
    pub counts: Vec<u64>,
    /// Number of couples whose centres coincide, which have no direction.
    pub without_direction: u64,
}

/// Counts of the cells, and the number of couples without a direction, for a part of the couples.
pub(crate) struct DirectionCounts {
    counts: Vec<u64>,
    without_direction: u64,
}

/// Number of bands, and of sectors of each band, in `D` dimensions.
const fn cells<const D: usize>() -> (usize, usize) {
    if D == 3 { (BANDS, SECTORS_3D) } else { (1, SECTORS_2D) }
}

impl DirectionCounts {
    pub(crate) fn new<const D: usize>() -> Self {
        let (bands, sectors) = cells::<D>();
        Self { counts: vec![0; bands * sectors], without_direction: 0 }
    }

    /// Counts a couple by its unit vector.
    #[inline]
    pub(crate) fn add<const D: usize>(&mut self, normal: Option<[f64; D]>) {
        let Some(normal) = normal else {
            self.without_direction += 1;
            return;
        };
        let (bands, sectors) = const { cells::<D>() };
        let along_z = normal[0].abs().max(normal[1].abs()) < ALONG_Z;
        let turn = if along_z { 0.0 } else { normal[1].atan2(normal[0]) / TAU };
        let angle = turn * sectors as f64;
        let sector = angle.round().rem_euclid(sectors as f64) as usize;
        let band =
            if D == 3 { ((f64::midpoint(normal[2], 1.0) * bands as f64) as usize).min(bands - 1) } else { 0 };
        self.counts[band * sectors + sector] += 1;
        // The number of sectors is even.
        let opposite = if along_z { 0 } else { (sector + sectors / 2) % sectors };
        self.counts[(bands - 1 - band) * sectors + opposite] += 1;
    }
}

impl Directions {
    pub(crate) fn of<'a, const D: usize>(parts: impl Iterator<Item = &'a DirectionCounts>) -> Self {
        let (bands, sectors) = cells::<D>();
        let mut counts = vec![0; bands * sectors];
        let mut without_direction = 0;
        for part in parts {
            counts.iter_mut().zip(&part.counts).for_each(|(count, more)| *count += more);
            without_direction += part.without_direction;
        }
        Self { bands, sectors, counts, without_direction }
    }
}

/// Returns the unit vector of a vector, also of an extremely short or long one; `None` if it has no
/// direction.
#[inline]
pub(crate) fn unit<const D: usize>(vector: [f64; D]) -> Option<[f64; D]> {
    let largest = vector.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let scaled: [f64; D] = each(|axis| vector[axis] / largest);
    let length = scaled.iter().fold(0.0, |sum, x| sum + x * x).sqrt();
    Some(each(|axis| scaled[axis] / length))
}
