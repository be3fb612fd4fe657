//! Every search equals `Direct`: dimensions 1 to 6, both floats, all shapes, with and without tolerance.

use fdem_contact::{CGrid, Detector, Direct, Elements, Multilevel, Nbs, Real, Rows, Simd};
use fdem_scenes::{Cloud, Sizes, clusters, gas, jittered_lattice, lattice};

use crate::ascending;

/// Test clouds are made in `f64` and rounded to the type under test.
pub(crate) trait FromF64: Real {
    fn from_f64(x: f64) -> Self;
}

impl FromF64 for f64 {
    fn from_f64(x: f64) -> Self {
        x
    }
}

impl FromF64 for f32 {
    fn from_f64(x: f64) -> Self {
        x as f32
    }
}

/// Compares the searches on spheres of one radius, spheres with radii and boxes from the same cloud. Returns
/// the number of couples, so that a caller can require some.
fn compare<T: FromF64, const D: usize>(scene: &str, cloud: &Cloud<D>) -> usize {
    let centres: Vec<[T; D]> = cloud.centres.iter().map(|centre| centre.map(T::from_f64)).collect();
    let radii: Vec<T> = cloud.radii.iter().copied().map(T::from_f64).collect();
    let corner = |side: f64| -> Vec<[T; D]> {
        let corners = cloud.centres.iter().zip(&cloud.radii);
        // Edges of different lengths: the box of element k is flattened along axis k mod D.
        corners
            .enumerate()
            .map(|(k, (centre, radius))| {
                std::array::from_fn(|axis| {
                    let half = if axis == k % D { radius / 2.0 } else { *radius };
                    T::from_f64(centre[axis] + side * half)
                })
            })
            .collect()
    };
    let (min, max) = (corner(-1.0), corner(1.0));
    let radius = radii.first().copied().unwrap_or(T::from_f64(0.5));

    let mut couples = 0;
    for tolerance in [0.0, 0.05, 1.5] {
        let shapes = [
            ("equal", Elements::spheres(&centres, radius)),
            ("radii", Elements::spheres_with_radii(&centres, &radii)),
            ("boxes", Elements::boxes(&min, &max)),
        ];
        for (shape, elements) in shapes {
            let elements = elements.unwrap().with_tolerance(T::from_f64(tolerance)).unwrap();
            let expected = ascending(Direct, &elements);
            let context =
                || format!("{scene}, {shape}, D = {D}, n = {}, tolerance {tolerance}", centres.len());
            assert!(ascending(Nbs::new(), &elements) == expected, "nbs: {}", context());
            assert!(ascending(CGrid::new(), &elements) == expected, "cgrid: {}", context());
            for (simd, threads) in
                Simd::available().into_iter().map(|simd| (simd, 1)).chain([(Simd::best(), 3)])
            {
                let rows = Rows::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
                assert!(ascending(rows, &elements) == expected, "rows, {simd}, {threads}: {}", context());
                let levels = Multilevel::new().with_simd(simd).unwrap().with_threads(threads).unwrap();
                let levels = levels.with_limits(&[0.5, 0.9, 1.1, 2.0]);
                assert!(ascending(levels, &elements) == expected, "levels, {simd}, {threads}: {}", context());
            }
            assert!(ascending(Detector::new(), &elements) == expected, "auto: {}", context());
            couples += expected.len();
        }
    }
    couples
}

const EQUAL: Sizes = Sizes::Equal { radius: 0.5 };

fn all_scenes<T: FromF64, const D: usize>() {
    // In many dimensions a search looks at hundreds of cells around each element.
    let many = if D < 5 || crate::thorough() { 1000 } else { 300 };
    for n in [0, 1, 2, 10, many] {
        let uniform = gas::<D>(n, 1, 8.0, EQUAL).unwrap();
        let found = compare::<T, D>("uniform", &uniform);
        assert!(n < many || found > many, "the scene has couples to lose");

        // The spacing is exactly the diameter: all neighbours touch, to the last bit.
        let touching = lattice::<D>(n, 1.0, 0.5).unwrap();
        let found = compare::<T, D>("lattice", &touching);
        assert!(n < 10 || found >= n, "neighbours on the lattice touch");

        let mut shifted = uniform.clone();
        shifted.centres.iter_mut().flatten().for_each(|x| *x -= 1234.5);
        compare::<T, D>("negative coordinates", &shifted);

        let mut collinear = uniform.clone();
        collinear.centres.iter_mut().enumerate().for_each(|(k, centre)| *centre = [k as f64 * 0.5; D]);
        compare::<T, D>("collinear, diagonal", &collinear);
        collinear.centres.iter_mut().for_each(|centre| centre[1..].fill(3.0));
        compare::<T, D>("collinear, along x", &collinear);
    }
    // n² couples each: fewer elements.
    let mut coincident = gas::<D>(60, 1, 8.0, EQUAL).unwrap();
    coincident.centres.fill([0.25; D]);
    assert!(compare::<T, D>("coincident", &coincident) >= 60 * 59 / 2);

    let sizes = Sizes::PowerLaw { min: 0.2, max: 1.0, exponent: -2.5 };
    compare::<T, D>("unlike sizes", &gas::<D>(500, 3, 4.0, sizes).unwrap());
    compare::<T, D>("jittered", &jittered_lattice::<D>(500, 4, 1.0, 0.3, EQUAL).unwrap());
    compare::<T, D>("clusters", &clusters::<D>(300, 5, 30, 1000.0, 6.0, EQUAL).unwrap());
    let far = Cloud { centres: vec![[-5e5; D], [5e5; D]], radii: vec![0.5; 2] };
    compare::<T, D>("two, 1e6 diameters apart", &far);
}

for_all_types! { all_scenes }
