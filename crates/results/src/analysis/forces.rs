//! Forces of the couples, and the stress that follows from them.

use serde::Serialize;

use crate::analysis::placed::Placed;
use crate::arrays::each;

/// Forces of the couples, and the mean stress `σ_ab = 1/V Σ f_a l_b` over the couples.
///
/// `f` is the force on the first element of a couple by the second, `l` the vector from the first centre to
/// the second, or to its image. Tension is positive. `V` is the area or volume of the domain: of the box
/// along periodic axes, and from the outermost surfaces of the elements along the others. Contacts with walls
/// and moving elements contribute to the stress of a granular body too; they are not in this sum.
///
/// A couple is strong if its force exceeds the mean: strong couples carry the deviator of the stress in
/// chains.
///
/// # Units
/// Forces are in the unit of the file, stresses in that unit over the length unit of the centres squared, in
/// 2D over the length unit.
///
/// # Source
/// A.E.H. Love, A Treatise on the Mathematical Theory of Elasticity (1927), Note B; J. Weber, Bull. Liais.
/// Ponts Chauss. 20 (1966) 1–20; strong couples: F. Radjai, D.E. Wolf, M. Jean, J.J. Moreau, Phys. Rev. Lett.
/// 80 (1998) 61–64.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forces {
    /// Mean magnitude; `None` without couples.
    pub mean: Option<f64>,
    /// Largest magnitude; `None` without couples.
    pub largest: Option<f64>,
    /// Number of couples whose magnitude exceeds the mean.
    pub strong: u64,
    /// Strong couples over all couples; `None` without couples.
    pub strong_share: Option<f64>,
    /// Part of the pressure that the strong couples carry; `None` if there is no pressure.
    pub strong_pressure_share: Option<f64>,
    /// Area or volume of the domain.
    pub measure: f64,
    /// `σ`, row by row; `None` if the domain has no area or volume.
    pub stress: Option<Vec<Vec<f64>>>,
    /// Minus the trace of `σ` over the number of dimensions: compression is positive.
    pub pressure: Option<f64>,
}

impl Forces {
    /// Returns the analysis of the forces, or `None` if they are not known.
    pub(crate) fn of<const D: usize>(placed: &Placed<'_, D>) -> Option<Self> {
        let forces = placed.network.forces?;
        let couples = placed.network.couples;
        let count = forces.len();
        let magnitudes = placed.network.magnitudes()?;
        // Divided first, so that the sum of large forces does not overflow.
        let mean = (count > 0).then(|| magnitudes.iter().map(|force| force / count as f64).sum::<f64>());
        let is_strong = |k: usize| mean.is_some_and(|mean| magnitudes[k] > mean);
        let mut sum = [[0.0; D]; D];
        let (mut trace, mut strong_trace) = (0.0, 0.0);
        for (k, force) in forces.iter().enumerate() {
            let [a, b] = placed.ends(couples.get(k));
            let branch: [f64; D] = each(|axis| b[axis] - a[axis]);
            for (row, force) in sum.iter_mut().zip(force) {
                for (entry, length) in row.iter_mut().zip(branch) {
                    *entry += force * length;
                }
            }
            let part: f64 = force.iter().zip(branch).map(|(force, length)| force * length).sum();
            trace += part;
            strong_trace += if is_strong(k) { part } else { 0.0 };
        }
        let strong = (0..count).filter(|&k| is_strong(k)).count() as u64;
        let measure = placed.frame.measure(&placed.frame.domain);
        let has_measure = measure > 0.0 && measure.is_finite();
        Some(Self {
            mean,
            largest: magnitudes.iter().copied().reduce(f64::max),
            strong,
            strong_share: (count > 0).then(|| strong as f64 / count as f64),
            strong_pressure_share: (trace != 0.0).then(|| strong_trace / trace),
            measure: if has_measure { measure } else { 0.0 },
            stress: has_measure.then(|| sum.map(|row| row.map(|entry| entry / measure).to_vec()).to_vec()),
            pressure: has_measure.then(|| -trace / (D as f64 * measure)),
        })
    }
}

#[cfg(test)]
mod tests {
    use fdem_contact::{Couple, PeriodicBox, PeriodicCouple};

    use crate::analysis::{Options, analyse};
    use crate::network::{Couples, Network, Sizes, Space};

    /// Two discs along x press each other with 6 and a third, above, with 2: by hand, in a domain of 4 x 4.
    #[test]
    fn the_stress_of_three_discs_is_that_by_hand() {
        let centres = [[1.0, 1.0], [3.0, 1.0], [1.0, 3.0]];
        let couples = Couples::Plain(vec![Couple::new(0, 1), Couple::new(0, 2)]);
        let forces = [[-6.0, 0.0], [0.5, -2.0]];
        let space = Space { centres: &centres, cell: None };
        let network = Network { space, sizes: Sizes::All(1.0), couples: &couples, forces: Some(&forces) };
        let found = analyse(&network, &Options::default()).unwrap().forces.unwrap();
        assert_eq!(found.measure, 16.0);
        // -6 * 2 / 16 along x; 0.5 * 2 / 16 and -2 * 2 / 16 for the second couple along y.
        assert_eq!(found.stress, Some(vec![vec![-0.75, 0.0625], vec![0.0, -0.25]]));
        assert_eq!(found.pressure, Some(0.5));
        assert_eq!(found.largest, Some(6.0));
        assert_eq!(found.mean, Some(3.0 + 4.25_f64.sqrt() / 2.0));
        assert_eq!((found.strong, found.strong_share), (1, Some(0.5)));
        assert_eq!(found.strong_pressure_share, Some(0.75));
        let network = Network { forces: None, ..network };
        assert_eq!(analyse(&network, &Options::default()).unwrap().forces, None);
    }

    /// Across the face of a periodic cube the branch leads to the image.
    #[test]
    fn branches_lead_to_images() {
        let centres = [[0.5, 2.0, 2.0], [3.5, 2.0, 2.0]];
        let cell = PeriodicBox::orthogonal([0.0; 3], [4.0; 3], [true; 3]).unwrap();
        let couples = Couples::Periodic(vec![PeriodicCouple { i: 0, j: 1, shift: [-1, 0, 0] }]);
        let forces = [[8.0, 0.0, 0.0]];
        let space = Space { centres: &centres, cell: Some(cell) };
        let network = Network { space, sizes: Sizes::All(0.5), couples: &couples, forces: Some(&forces) };
        let found = analyse(&network, &Options::default()).unwrap().forces.unwrap();
        // 8 * (-1) over 4 cubed.
        assert_eq!(found.stress.unwrap()[0], [-0.125, 0.0, 0.0]);
        assert_eq!((found.measure, found.strong, found.strong_pressure_share), (64.0, 0, Some(0.0)));
    }

    #[test]
    fn no_couples_have_no_mean() {
        let couples = Couples::Plain(vec![]);
        let space = Space { centres: &[[0.0, 0.0]], cell: None };
        let network = Network { space, sizes: Sizes::All(1.0), couples: &couples, forces: Some(&[]) };
        let found = analyse(&network, &Options::default()).unwrap().forces.unwrap();
        assert_eq!((found.mean, found.largest, found.strong_pressure_share), (None, None, None));
        assert_eq!(found.stress, Some(vec![vec![0.0, 0.0], vec![0.0, 0.0]]));
    }
}
