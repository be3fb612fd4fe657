//! Gases that are far apart.

use crate::cloud::Cloud;
use crate::error::{Error, positive, reserved};
use crate::gas::edge_for;
use crate::random::{CENTRES, CLUSTERS, Random};
use crate::sizes::Sizes;

/// Clusters: small gases scattered uniformly over a wide cube that is empty otherwise.
///
/// Each cluster is a cube of `per_cluster` elements (the last one may have fewer) in which an element has
/// `neighbours` contacts on average, not counting the effect of faces: see [`gas_edge`](crate::gas_edge).
/// Clusters may overlap. For equal spheres `neighbours` is eight times the packing fraction, for equal discs
/// four times.
///
/// # Shapes
/// `n` centres and radii, cluster after cluster; all centres in `[0, L]^D`, `L` being `domain` mean
/// diameters.
///
/// # Units
/// The unit of `sizes`. `domain` counts mean diameters, which are twice the mean of the drawn radii;
/// `neighbours` is a number.
///
/// # Cost
/// Time and memory proportional to `n`.
///
/// # Errors
/// [`Error::OutOfRange`] if `per_cluster` is zero, or if `domain`, `neighbours` or a length that follows from
/// them is not positive and finite; [`Error::TooNarrow`] if a cluster is wider than the domain; the errors of
/// [`Sizes::radii`]; [`Error::OutOfMemory`].
///
/// # Example
/// ```
/// use fdem_scenes::{Sizes, clusters};
///
/// let cloud = clusters::<3>(5_000, 1, 1_000, 1e5, 0.8, Sizes::Equal { radius: 0.5 })?;
/// assert!(cloud.centres.iter().flatten().all(|x| (0.0..=1e5).contains(x)));
/// # Ok::<(), fdem_scenes::Error>(())
/// ```
pub fn clusters<const D: usize>(
    n: usize,
    seed: u64,
    per_cluster: usize,
    domain: f64,
    neighbours: f64,
    sizes: Sizes,
) -> Result<Cloud<D>, Error> {
    positive("number of elements per cluster", per_cluster as f64)?;
    positive("domain", domain)?;
    positive("number of neighbours", neighbours)?;
    let radii = sizes.radii(n, seed)?;
    if n == 0 {
        return Ok(Cloud { centres: Vec::new(), radii });
    }
    let room = positive("edge of the domain", domain * sizes.mean_diameter(&radii)?)?;
    let edge = edge_for::<D>(&radii, per_cluster, neighbours)?;
    if edge > room {
        return Err(Error::TooNarrow { what: "a cluster", required: edge, room });
    }
    let mut places = Random::with_stream(seed, CLUSTERS);
    let mut random = Random::with_stream(seed, CENTRES);
    let mut centres = reserved(n)?;
    while centres.len() < n {
        let corner: [f64; D] = std::array::from_fn(|_| (room - edge) * places.uniform());
        for _ in 0..per_cluster.min(n - centres.len()) {
            centres.push(corner.map(|low| (low + edge * random.uniform()).min(room)));
        }
    }
    Ok(Cloud { centres, radii })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gas::gas_edge;

    const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

    #[test]
    fn clusters_are_narrow_and_spread_over_the_domain() {
        let (domain, per_cluster) = (1e4, 50);
        let cloud = clusters::<3>(5_020, 31, per_cluster, domain, 0.8, EQUAL).unwrap();
        let edge = gas_edge::<3>(&[0.5; 50], 0.8).unwrap();
        assert!(cloud.centres.iter().flatten().all(|x| (0.0..=domain).contains(x)));
        for axis in 0..3 {
            let mut corners = Vec::new();
            for cluster in cloud.centres.chunks(per_cluster) {
                let low = cluster.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
                let high = cluster.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
                assert!(high - low <= edge * (1.0 + 1e-9), "{} > {edge}", high - low);
                corners.push(low);
            }
            assert_eq!(corners.len(), 101);
            let mean = corners.iter().sum::<f64>() / 101.0 / domain;
            assert!((mean - 0.5).abs() < 0.145, "{mean}");
            assert!(corners.iter().any(|&x| x < 0.1 * domain) && corners.iter().any(|&x| x > 0.9 * domain));
        }
    }

    #[test]
    fn clusters_have_the_contacts_asked_for() {
        let (per_cluster, neighbours) = (400, 2.0);
        let cloud = clusters::<2>(8_000, 32, per_cluster, 1e6, neighbours, EQUAL).unwrap();
        let mut found = 0;
        for cluster in cloud.centres.chunks(per_cluster) {
            for (i, a) in cluster.iter().enumerate() {
                found += cluster[..i].iter().filter(|b| (a[0] - b[0]).hypot(a[1] - b[1]) <= 1.0).count();
            }
        }
        let t = 1.0 / gas_edge::<2>(&[0.5; 400], neighbours).unwrap();
        let chance = std::f64::consts::PI * t * t - 8.0 / 3.0 * t.powi(3) + 0.5 * t.powi(4);
        let expected = 20.0 * 400.0 * 399.0 / 2.0 * chance;
        assert!((found as f64 / expected - 1.0).abs() < 0.06, "{found} for {expected}");
    }

    #[test]
    fn one_cluster_may_fill_its_domain() {
        let edge = gas_edge::<2>(&[0.5; 64], 4.0).unwrap();
        let cloud = clusters::<2>(64, 3, 64, edge, 4.0, EQUAL).unwrap();
        assert!(cloud.centres.iter().flatten().all(|x| (0.0..=edge).contains(x)));
        let refused = clusters::<2>(64, 3, 64, 0.999 * edge, 4.0, EQUAL);
        assert!(matches!(refused, Err(Error::TooNarrow { what: "a cluster", .. })), "{refused:?}");
    }

    #[test]
    fn none_and_one_are_fine() {
        assert!(clusters::<3>(0, 1, 10, 1e3, 1.0, EQUAL).unwrap().is_empty());
        assert_eq!(clusters::<3>(1, 1, 10, 1e3, 1.0, EQUAL).unwrap().len(), 1);
    }

    #[test]
    fn bad_parameters_are_refused() {
        assert!(clusters::<2>(9, 1, 0, 1e3, 1.0, EQUAL).is_err());
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(clusters::<2>(9, 1, 3, bad, 1.0, EQUAL).is_err(), "{bad}");
            assert!(clusters::<2>(9, 1, 3, 1e3, bad, EQUAL).is_err(), "{bad}");
        }
        assert!(clusters::<2>(9, 1, 3, 1e308, 1.0, Sizes::Equal { radius: 1e300 }).is_err());
    }
}
