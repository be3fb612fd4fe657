//! The analysis of contact networks against lattices, chains, brute force, and changes that must not matter.
//!
//! `python/test_analysis.py` compares the command with numpy, scipy, networkx and freud.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::f64::consts::{PI, SQRT_2};

use fdem_contact::{Couple, Detector, Elements, PeriodicBox, PeriodicSearch, Search};
use fdem_results::analysis::{Analysis, AnalysisError, Options, RadialOptions, analyse};
use fdem_results::network::{Couples, Network, Sizes, Space};

/// Detection, then the analysis.
fn analysed<const D: usize>(
    centres: &[[f64; D]],
    sizes: Sizes<'_>,
    cell: Option<PeriodicBox<f64, D>>,
    tolerance: f64,
    options: &Options<D>,
) -> Result<Analysis, AnalysisError> {
    let elements = match sizes {
        Sizes::Each(radii) => Elements::spheres_with_radii(centres, radii),
        Sizes::All(radius) => Elements::spheres(centres, radius),
        Sizes::Cutoff(cutoff) => Elements::points(centres, cutoff),
        Sizes::Pairs(_) => unreachable!("these networks have one cut-off"),
    };
    let elements = elements.unwrap().with_tolerance(tolerance).unwrap();
    let couples = if let Some(cell) = &cell {
        let mut couples = Vec::new();
        PeriodicSearch::new().couples(&elements, cell, &mut couples).unwrap();
        couples.sort_unstable();
        Couples::Periodic(couples)
    } else {
        let mut couples = Vec::new();
        Detector::new().couples(&elements, &mut couples).unwrap();
        couples.sort_unstable();
        Couples::Plain(couples)
    };
    analyse(&Network { space: Space { centres, cell }, sizes, couples: &couples, forces: None }, options)
}

fn close(a: f64, b: f64, relative: f64) -> bool {
    (a - b).abs() <= relative * b.abs().max(1.0)
}

/// `n` cells of edge `edge` along each axis, each with the sites `basis` in units of the edge.
fn lattice<const D: usize>(n: usize, edge: f64, basis: &[[f64; D]]) -> (Vec<[f64; D]>, PeriodicBox<f64, D>) {
    let mut centres = Vec::new();
    for cell in 0..n.pow(D as u32) {
        for site in basis {
            centres.push(std::array::from_fn(|axis| {
                let place = cell / n.pow(axis as u32) % n;
                (place as f64 + site[axis]) * edge
            }));
        }
    }
    let side = n as f64 * edge;
    (centres, PeriodicBox::orthogonal([0.0; D], [side; D], [true; D]).unwrap())
}

const FCC: [[f64; 3]; 4] = [[0.25; 3], [0.25, 0.75, 0.75], [0.75, 0.25, 0.75], [0.75, 0.75, 0.25]];

/// Coordination, packing fraction, fabric and clusters of touching lattices are those of the books.
#[test]
fn cubic_lattices() {
    let lattices = [
        ("sc", vec![[0.5; 3]], 1.0, 6, PI / 6.0),
        ("bcc", vec![[0.25; 3], [0.75; 3]], 2.0 / 3.0_f64.sqrt(), 8, PI * 3.0_f64.sqrt() / 8.0),
        ("fcc", FCC.to_vec(), SQRT_2, 12, PI * SQRT_2 / 6.0),
    ];
    for (name, basis, edge, contacts, fraction) in lattices {
        let (centres, cell) = lattice(4, edge, &basis);
        // Neighbours touch but for roundings.
        let found = analysed(&centres, Sizes::All(0.5), Some(cell), 1e-12, &Options::default()).unwrap();
        let n = centres.len() as u64;
        assert_eq!(found.coordination.mean, contacts as f64, "{name}");
        assert_eq!(found.coordination.distribution[contacts as usize], n, "{name}");
        assert_eq!(found.without_rattlers.rattlers, 0);
        assert_eq!((found.clusters.count, found.clusters.largest), (1, n));
        assert!(found.clusters.percolation.iter().all(|along| along.percolates && along.periodic));
        let fabric = found.fabric.unwrap();
        for (row, entries) in fabric.tensor.iter().enumerate() {
            for (column, entry) in entries.iter().enumerate() {
                let isotropic = if row == column { 1.0 / 3.0 } else { 0.0 };
                assert!(close(*entry, isotropic, 1e-13), "{name} {:?}", fabric.tensor);
            }
        }
        assert!(fabric.anisotropy < 1e-12, "{name}");
        let packing = found.packing.unwrap();
        assert!(close(packing.fraction, fraction, 1e-13), "{name} {packing:?}");
        assert!(packing.overlap < 1e-12 && packing.overlap_error == 0.0);
        assert_eq!(found.directions.counts.iter().sum::<u64>(), n * contacts);
        assert_eq!(found.directions.counts.iter().filter(|&&count| count > 0).count() as u64, contacts);
    }
}

#[test]
fn flat_lattices() {
    // Hexagonal: two sites in a rectangle.
    let height = 3.0_f64.sqrt();
    let mut centres = Vec::new();
    for row in 0..6 {
        for column in 0..7 {
            let (x, y) = (f64::from(column), f64::from(row) * height);
            centres.extend([[x, y], [x + 0.5, y + height / 2.0]]);
        }
    }
    let cell = PeriodicBox::orthogonal([0.0; 2], [7.0, 6.0 * height], [true; 2]).unwrap();
    let hexagonal = analysed(&centres, Sizes::All(0.5), Some(cell), 1e-12, &Options::default()).unwrap();
    assert_eq!(hexagonal.coordination.mean, 6.0);
    assert!(close(hexagonal.packing.unwrap().fraction, PI / 12.0_f64.sqrt(), 1e-13));
    let fabric = hexagonal.fabric.unwrap();
    assert!(close(fabric.eigenvalues[0], 0.5, 1e-13) && fabric.anisotropy < 1e-12, "{fabric:?}");
    // 0, 60, …, 300 degrees, in sectors of 5 degrees around these.
    let counts = hexagonal.directions.counts;
    assert_eq!(counts.len(), 72);
    assert!(
        counts.iter().enumerate().all(|(k, &count)| count == if k % 12 == 0 { 84 } else { 0 }),
        "{counts:?}"
    );

    let (centres, cell) = lattice(5, 1.0, &[[0.5; 2]]);
    let square = analysed(&centres, Sizes::All(0.5), Some(cell), 1e-12, &Options::default()).unwrap();
    assert_eq!(square.coordination.mean, 4.0);
    assert!(close(square.packing.unwrap().fraction, PI / 4.0, 1e-14));
}

/// A sheared cell of one sphere is the same lattice, with the same numbers.
#[test]
fn a_lattice_in_a_sheared_cell() {
    let half = SQRT_2 / 2.0;
    let edges = [[half, half, 0.0], [0.0, half, half], [half, 0.0, half]];
    let cell = PeriodicBox::triclinic([0.1, 0.2, 0.3], edges, [true; 3]).unwrap();
    let options =
        Options { radial: RadialOptions { r_max: Some(3.1), bins: Some(29) }, ..Options::default() };
    let found = analysed(&[[0.5; 3]], Sizes::All(0.5), Some(cell), 1e-12, &options).unwrap();
    assert_eq!(found.coordination.mean, 12.0);
    assert!(close(found.packing.as_ref().unwrap().fraction, PI * SQRT_2 / 6.0, 1e-13), "{:?}", found.packing);
    assert!(found.clusters.percolation.iter().all(|along| along.percolates));
    let (centres, cell) = lattice(3, SQRT_2, &FCC);
    let many = analysed(&centres, Sizes::All(0.5), Some(cell), 1e-12, &options).unwrap();
    let (one, many) = (found.radial.unwrap(), many.radial.unwrap());
    assert!(close(one.density, many.density, 1e-13));
    assert_eq!(one.counts.iter().map(|count| count * 108).collect::<Vec<_>>(), many.counts);
}

/// Peaks of the face-centred cubic lattice: 12 at 1, 6 at the square root of 2, 24 at that of 3, 12 at 2.
#[test]
fn peaks_of_a_lattice() {
    let (centres, cell) = lattice(3, SQRT_2, &FCC);
    let options =
        Options { radial: RadialOptions { r_max: Some(2.05), bins: Some(41) }, ..Options::default() };
    let radial = analysed(&centres, Sizes::All(0.5), Some(cell), 0.0, &options).unwrap().radial.unwrap();
    let n = centres.len() as u64;
    assert_eq!(radial.references, n);
    assert!(close(radial.density, SQRT_2, 1e-13));
    let mut around: Vec<_> = radial.counts.iter().map(|count| count / n).collect();
    // 1 and 2 are limits of bins, on either side of which roundings may put a centre.
    let at = |around: &mut Vec<u64>, r: f64| {
        let k = (r / 0.05).round() as usize;
        std::mem::take(&mut around[k]) + std::mem::take(&mut around[k - 1])
    };
    let peaks = [1.0, SQRT_2, 3.0_f64.sqrt(), 2.0].map(|r| at(&mut around, r));
    assert_eq!(peaks, [12, 6, 24, 12]);
    assert!(around.iter().all(|&count| count == 0), "{around:?}");
}

/// Numbers between 0 and 1 (a linear congruence with Knuth's numbers).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn points<const D: usize>(&mut self, n: usize, side: f64) -> Vec<[f64; D]> {
        (0..n).map(|_| std::array::from_fn(|_| self.next() * side)).collect()
    }
}

/// The radial distribution of an ideal gas is 1 within its statistical error, in a box that repeats, in one
/// that does not, and in one that does half.
#[test]
fn an_ideal_gas() {
    let centres = Random(1).points::<3>(20_000, 10.0);
    for periodic in [None, Some([true; 3]), Some([true, false, true])] {
        let cell = periodic.map(|axes| PeriodicBox::orthogonal([0.0; 3], [10.0; 3], axes).unwrap());
        let options =
            Options { radial: RadialOptions { r_max: Some(1.0), bins: Some(10) }, ..Options::default() };
        let radial = analysed(&centres, Sizes::Cutoff(0.1), cell, 0.0, &options).unwrap().radial.unwrap();
        assert!(close(radial.density, 20.0, 0.02), "{}", radial.density);
        for (k, (g, count)) in radial.g.iter().zip(&radial.counts).enumerate() {
            // Pairs are counted twice, and the counts are random.
            let error = 5.0 / (*count as f64 / 2.0).sqrt();
            assert!((g - 1.0).abs() < error, "{periodic:?}, bin {k}: {g} ± {error}");
        }
    }
}

/// Chains that go straight around, wind diagonally, end inside, or close inside.
#[test]
fn chains_around_the_box() {
    let cell = PeriodicBox::orthogonal([0.0; 2], [8.0; 2], [true; 2]).unwrap();
    let percolates = |centres: &[[f64; 2]]| {
        let found = analysed(centres, Sizes::All(0.5), Some(cell), 1e-12, &Options::default()).unwrap();
        [0, 1].map(|axis| found.clusters.percolation[axis].percolates)
    };
    let straight: Vec<_> = (0..8).map(|k| [f64::from(k) + 0.25, 3.0]).collect();
    assert_eq!(percolates(&straight), [true, false]);
    assert_eq!(percolates(&straight[1..]), [false, false]);
    // The same, given several periods away.
    let away: Vec<_> = straight
        .iter()
        .enumerate()
        .map(|(k, [x, y])| [x + 8.0 * (k % 3) as f64, y - 8.0 * (k % 2) as f64])
        .collect();
    assert_eq!(percolates(&away), [true, false]);
    // Steps to the right and up in turn: around both edges at once.
    let stairs: Vec<_> = (0..16).map(|k| [f64::from(k / 2 + k % 2) + 0.25, f64::from(k / 2) + 0.5]).collect();
    assert_eq!(percolates(&stairs), [true, true]);
    // A ring across the corner of the box closes without winding.
    let ring: Vec<_> =
        [[7.5, 7.5], [8.5, 7.5], [8.5, 8.5], [7.5, 8.5]].map(|[x, y]| [x % 8.0, y % 8.0]).to_vec();
    assert_eq!(percolates(&ring), [false, false]);
    // One disc as wide as the box touches itself.
    let found = analysed(&[[1.0, 1.0]], Sizes::All(4.0), Some(cell), 0.0, &Options::default()).unwrap();
    assert_eq!(found.coordination.mean, 4.0);
    assert!(found.clusters.percolation.iter().all(|along| along.percolates && along.elements == 1));
}

#[test]
fn chains_from_face_to_face() {
    // A column beside a shorter one.
    let mut centres: Vec<_> = (0..6).map(|k| [0.5, f64::from(k) + 0.5]).collect();
    centres.extend((0..3).map(|k| [3.5, f64::from(k) + 0.5]));
    let found = analysed(&centres, Sizes::All(0.5), None, 1e-12, &Options::default()).unwrap();
    let along: Vec<_> =
        found.clusters.percolation.iter().map(|p| (p.percolates, p.clusters, p.elements)).collect();
    assert_eq!(along, [(false, 0, 0), (true, 1, 6)]);
    assert_eq!((found.clusters.count, found.clusters.largest), (2, 6));
    let sizes: Vec<_> = found.clusters.sizes.iter().map(|size| (size.elements, size.clusters)).collect();
    assert_eq!(sizes, [(3, 1), (6, 1)]);
    // Without one of its links it does not.
    centres.remove(2);
    let found = analysed(&centres, Sizes::All(0.5), None, 1e-12, &Options::default()).unwrap();
    assert!(!found.clusters.percolation[1].percolates);
}

/// A chain of spheres behind a tetrahedron: one rattler makes the next.
#[test]
fn rattlers_make_rattlers() {
    let side = 1.0 / SQRT_2;
    let mut centres = vec![[0.0, 0.0, 0.0], [side, side, 0.0], [side, 0.0, side], [0.0, side, side]];
    centres.extend((1..40).map(|k| [-f64::from(k), 0.0, 0.0]));
    let run = |min_contacts| {
        let options = Options { min_contacts, ..Options::default() };
        analysed(&centres, Sizes::All(0.5), None, 1e-12, &options).unwrap().without_rattlers
    };
    // Spheres of a tetrahedron have three contacts.
    let three = run(Some(3));
    assert_eq!((three.rattlers, three.elements, three.couples, three.mean), (39, 4, 6, 3.0));
    assert_eq!(three.distribution, [0, 0, 0, 4]);
    assert!(three.is_rattler.iter().enumerate().all(|(k, &rattler)| rattler == (k >= 4)));
    let four = run(Some(4));
    assert_eq!((four.min_contacts, four.rattlers, four.elements, four.mean), (4, 43, 0, 0.0));
    // Nothing is left with 4: the packing is one that friction holds.
    let chosen = run(None);
    assert_eq!((chosen.min_contacts, chosen.rattlers, chosen.elements), (2, 39, 4));
    assert_eq!(
        chosen.frictionless,
        Some(fdem_results::analysis::Frictionless { min_contacts: 4, elements: 0 })
    );
    assert_eq!(run(Some(1)).rattlers, 0);
    assert_eq!(run(Some(2)).elements, 4);
}

/// Discs that overlap and discs that are apart.
#[test]
fn overlaps_and_gaps() {
    let centres = [[0.0, 0.0], [1.75, 0.0], [4.0, 0.0], [4.0, 2.5]];
    let found = analysed(&centres, Sizes::All(1.0), None, 0.5, &Options::default()).unwrap();
    let overlaps = found.overlaps.overlaps.unwrap();
    assert_eq!((overlaps.count, overlaps.min, overlaps.mean, overlaps.max), (1, 0.25, 0.25, 0.25));
    assert_eq!(overlaps.histogram.counts[19], 1);
    let gaps = found.overlaps.gaps.unwrap();
    assert_eq!((gaps.count, gaps.min, gaps.mean, gaps.max), (2, 0.25, 0.375, 0.5));
    assert_eq!((gaps.histogram.counts[10], gaps.histogram.counts[19]), (1, 1));
    assert_eq!(found.overlaps.mean_over_radius, Some(0.25));
    let lens = 2.0 * (0.875_f64.acos() - 0.875 * (1.0 - 0.875_f64.powi(2)).sqrt());
    let inner = Some([[-9.0, 9.0], [-9.0, 9.0]]);
    let packing = analysed(&centres, Sizes::All(1.0), None, 0.5, &Options { inner, ..Options::default() })
        .unwrap()
        .packing
        .unwrap();
    assert!(close(packing.solid, 4.0 * PI, 1e-14) && close(packing.overlap, lens, 1e-13), "{packing:?}");
    assert!(close(packing.fraction_without_overlap, (4.0 * PI - lens) / 324.0, 1e-13));
}

/// The packing fraction of a region is the part of random points in it that are in a sphere; also where the
/// region is beyond a face of the box.
#[test]
fn packing_of_a_region_by_random_points() {
    const POINTS: usize = 400_000;
    let mut random = Random(7);
    let centres = random.points::<3>(60, 4.0);
    let radii: Vec<_> = (0..60).map(|_| 0.2 + 0.3 * random.next()).collect();
    let cell = PeriodicBox::orthogonal([0.0; 3], [4.0; 3], [true, true, false]).unwrap();
    let inner = [[-1.5, 3.0], [0.5, 3.75], [1.0, 3.0]];
    for cell in [None, Some(cell)] {
        let options = Options { inner: Some(inner), ..Options::default() };
        let packing = analysed(&centres, Sizes::Each(&radii), cell, 0.0, &options).unwrap().packing.unwrap();
        assert_eq!(packing.measure, 4.5 * 3.25 * 2.0);
        let (mut inside, mut pairs) = (0_u32, 0_u32);
        for _ in 0..POINTS {
            let point: [f64; 3] = std::array::from_fn(|axis| {
                inner[axis][0] + random.next() * (inner[axis][1] - inner[axis][0])
            });
            let mut hits = 0;
            for (centre, radius) in centres.iter().zip(&radii) {
                let squared: f64 = (0..3)
                    .map(|axis| {
                        let apart = point[axis] - centre[axis];
                        let repeats = cell.is_some() && axis < 2;
                        let apart = if repeats { apart - 4.0 * (apart / 4.0).round() } else { apart };
                        apart * apart
                    })
                    .sum();
                hits += u32::from(squared < radius * radius);
            }
            inside += hits;
            pairs += hits * hits.saturating_sub(1) / 2;
        }
        let counted = f64::from(inside) / POINTS as f64;
        assert!(
            (packing.fraction - counted).abs() < 5.0 * (counted / POINTS as f64).sqrt(),
            "{packing:?} {counted}"
        );
        let counted = f64::from(pairs) / POINTS as f64;
        let error = 5.0 * (3.0 * counted / POINTS as f64).sqrt();
        let (overlap, bound) = (packing.overlap / packing.measure, packing.overlap_error / packing.measure);
        assert!((overlap - counted).abs() < bound + error, "{packing:?} {counted}");
        // The bound says something.
        assert!(bound < 3.0 * overlap, "{bound} {overlap}");
    }
}

/// Turned packings have the same eigenvalues, and turned directions.
#[test]
fn turning_keeps_eigenvalues() {
    let mut random = Random(3);
    let centres: Vec<[f64; 3]> =
        random.points::<3>(3000, 9.0).into_iter().map(|[x, y, z]| [x, y, 0.6 * z]).collect();
    let (sin, cos) = 0.7_f64.sin_cos();
    let turn = |[x, y, z]: [f64; 3]| {
        let [x, y] = [cos * x - sin * y, sin * x + cos * y];
        [x, cos * y - sin * z, sin * y + cos * z]
    };
    let turned: Vec<_> = centres.iter().copied().map(turn).collect();
    let fabric = |centres: &[[f64; 3]]| {
        analysed(centres, Sizes::All(0.4), None, 0.0, &Options::default()).unwrap().fabric.unwrap()
    };
    let (before, after) = (fabric(&centres), fabric(&turned));
    assert!(before.anisotropy > 0.01, "{}", before.anisotropy);
    for k in 0..3 {
        assert!(close(before.eigenvalues[k], after.eigenvalues[k], 1e-12));
        let direction: [f64; 3] = std::array::from_fn(|axis| before.principal_directions[k][axis]);
        let expected = turn(direction);
        let product: f64 = expected.iter().zip(&after.principal_directions[k]).map(|(a, b)| a * b).sum();
        assert!((product.abs() - 1.0).abs() < 1e-9);
    }
    assert!(close(before.anisotropy, after.anisotropy, 1e-11));
}

/// Renumbering the elements changes no count, and sums by roundings only.
#[test]
fn numbering_does_not_matter() {
    let centres = Random(5).points::<2>(2000, 30.0);
    let cell = PeriodicBox::triclinic([0.0; 2], [[30.0, 0.0], [7.0, 30.0]], [true, false]).unwrap();
    for cell in [None, Some(cell)] {
        let renumbered: Vec<_> = (0..2000).map(|k| centres[k * 1237 % 2000]).collect();
        let run = |centres: &[[f64; 2]]| {
            analysed(centres, Sizes::All(0.4), cell, 0.1, &Options::default()).unwrap()
        };
        let (a, b) = (run(&centres), run(&renumbered));
        assert_eq!(a.coordination.distribution, b.coordination.distribution);
        assert_eq!(a.without_rattlers.distribution, b.without_rattlers.distribution);
        assert_eq!(a.clusters.sizes, b.clusters.sizes);
        assert_eq!(a.clusters.percolation, b.clusters.percolation);
        assert_eq!(a.directions, b.directions);
        assert_eq!(a.radial.unwrap().counts, b.radial.unwrap().counts);
        assert!(close(a.fabric.unwrap().anisotropy, b.fabric.unwrap().anisotropy, 1e-12));
        let (a, b) = (a.packing.unwrap(), b.packing.unwrap());
        assert!(close(a.fraction, b.fraction, 1e-12) && close(a.overlap, b.overlap, 1e-12));
    }
}

#[test]
fn little_and_nothing() {
    let nothing = analysed::<3>(&[], Sizes::All(1.0), None, 0.0, &Options::default()).unwrap();
    assert_eq!((nothing.coordination.mean, nothing.clusters.count), (0.0, 0));
    assert!(nothing.fabric.is_none() && nothing.packing.is_none() && nothing.radial.is_none());
    assert!(nothing.clusters.percolation.iter().all(|along| !along.percolates));

    let two = analysed(&[[1.0; 3]; 2], Sizes::All(1.0), None, 0.0, &Options::default()).unwrap();
    assert_eq!((two.directions.without_direction, two.fabric), (1, None));
    assert!(two.no_packing.unwrap().contains("nothing is left along x"));
    let away = Options { inner: Some([[-1.0, 1.0], [3.0, 4.0]]), ..Options::default() };
    let away = analysed(&[[0.0, 0.0], [1.0, 0.0]], Sizes::All(1.0), None, 0.0, &away).unwrap();
    assert_eq!(away.packing, None);
    let reason = away.no_packing.unwrap();
    assert_eq!(reason, "the inner region holds no element: along y they are from -1 to 1");
    assert!(two.no_radial.unwrap().contains("no width"));

    let points =
        analysed(&[[0.0; 2], [1.0, 1.0]], Sizes::Cutoff(2.0), None, 0.0, &Options::default()).unwrap();
    assert_eq!(points.no_packing.as_deref(), Some("points fill no space"));
    assert_eq!(points.overlaps.mean_radius, None);
}

#[test]
fn what_cannot_be_is_refused() {
    let centres = [[0.0, 0.0], [1.0, 0.0]];
    let refused =
        |options: Options<2>, cell| analysed(&centres, Sizes::All(0.5), cell, 0.0, &options).unwrap_err();
    let inner = |limits| Options { inner: Some(limits), ..Options::default() };
    for limits in [[2.0, 2.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
        let error = refused(inner([[0.0, 1.0], limits]), None);
        assert!(matches!(error, AnalysisError::Region { axis: 1, .. }), "{error}");
    }
    let sheared = PeriodicBox::triclinic([0.0; 2], [[9.0, 0.0], [1.0, 9.0]], [true; 2]).unwrap();
    assert_eq!(refused(inner([[0.0, 1.0]; 2]), Some(sheared)), AnalysisError::ShearedBox);
    for (r_max, bins) in
        [(Some(0.0), None), (Some(f64::NAN), None), (None, Some(0)), (None, Some(usize::MAX))]
    {
        let error = refused(Options { radial: RadialOptions { r_max, bins }, ..Options::default() }, None);
        assert!(matches!(error, AnalysisError::Radial { .. }), "{error}");
    }
    let far = Options { radial: RadialOptions { r_max: Some(10.0), bins: None }, ..Options::default() };
    assert!(refused(far, None).to_string().contains("no centre is 10 away from all faces"));

    let line = Couples::Plain(vec![Couple::new(0, 1)]);
    let space = Space { centres: &[[0.0], [1.0]], cell: None };
    let network = Network { space, sizes: Sizes::All(0.5), couples: &line, forces: None };
    assert_eq!(analyse(&network, &Options::default()), Err(AnalysisError::Dimensions { dimensions: 1 }));
}

/// Four discs nearly in one place: the overlaps of three are subtracted too often, so that nothing would be
/// left.
#[test]
fn overlaps_of_many_leave_a_lower_bound() {
    let centres = [[0.0, 0.0], [0.1, 0.0], [0.0, 0.1], [0.1, 0.1]];
    let options = Options { inner: Some([[-2.0, 2.0]; 2]), ..Options::default() };
    let packing = analysed(&centres, Sizes::All(1.0), None, 0.0, &options).unwrap().packing.unwrap();
    assert!(close(packing.fraction, 4.0 * PI / 16.0, 1e-14), "{packing:?}");
    assert_eq!(packing.fraction_without_overlap, 0.0);
}

/// Sums that overflow are no packing fraction.
#[test]
fn areas_beyond_all_numbers_are_said() {
    let centres: Vec<_> = (0..40).map(|k| [1e99 * f64::from(k % 7), 1e99 * f64::from(k / 7)]).collect();
    let analysis = analysed(&centres, Sizes::All(0.6e99), None, 0.0, &Options::default()).unwrap();
    let finite = analysis.packing.as_ref().is_none_or(|packing| {
        packing.overlap.is_finite() && packing.fraction_without_overlap <= packing.fraction
    });
    assert!(finite && analysis.packing.is_some() != analysis.no_packing.is_some(), "{analysis:?}");
}

/// Sums run over parts of a fixed length: no bit of the result depends on the number of threads.
#[test]
fn threads_change_nothing() {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let centres: Vec<[f64; 3]> = (0..20_000).map(|_| std::array::from_fn(|_| 27.0 * random())).collect();
    let radii: Vec<f64> = centres.iter().map(|_| 0.5 + 0.25 * random()).collect();
    let cell = PeriodicBox::orthogonal([0.0; 3], [27.0; 3], [true, true, false]).unwrap();
    for cell in [None, Some(cell)] {
        let with = |threads| {
            let options = Options { threads, ..Options::default() };
            analysed(&centres, Sizes::Each(&radii), cell, 0.05, &options).unwrap()
        };
        let one = with(1);
        let couples: u64 = one.overlaps.overlaps.iter().chain(&one.overlaps.gaps).map(|all| all.count).sum();
        assert!(couples > 2 << 15, "several parts: {couples}");
        for threads in [2, 5] {
            assert_eq!(with(threads), one);
        }
    }
}

/// The voids of a network without couples, which they do not need.
fn voids_of<const D: usize>(
    centres: &[[f64; D]],
    sizes: Sizes<'_>,
    cell: Option<PeriodicBox<f64, D>>,
) -> fdem_results::analysis::Voids {
    analysed(centres, sizes, cell, 0.0, &Options { voids: true, ..Options::default() })
        .unwrap()
        .voids
        .unwrap()
}

/// Void ratio and largest pore of lattices: `1/φ - 1` of the packing fraction, and the distance of the middle
/// of the largest hole from the surfaces.
#[test]
fn voids_of_lattices() {
    // Along an edge of these cells one element is its own neighbour; in others all are different.
    for n in [1, 2, 4] {
        let (centres, cell) = lattice(n, 1.0, &[[0.5; 3]]);
        let cubic = voids_of(&centres, Sizes::All(0.5), Some(cell));
        let (centres, cell) = lattice(n, SQRT_2, &FCC);
        let fcc = voids_of(&centres, Sizes::All(0.5), Some(cell));
        let (centres, cell) = lattice(n, 1.0, &[[0.5; 2]]);
        let square = voids_of(&centres, Sizes::All(0.5), Some(cell));
        for (voids, fraction, hole) in [
            (cubic, PI / 6.0, 0.75_f64.sqrt() - 0.5),
            (fcc, PI / (3.0 * SQRT_2), SQRT_2 / 2.0 - 0.5),
            (square, PI / 4.0, 0.5_f64.sqrt() - 0.5),
        ] {
            let ratio = voids.void_ratio.unwrap();
            assert!(close(ratio.min, 1.0 / fraction - 1.0, 1e-12), "{n}: {} {}", ratio.min, 1.0 / fraction);
            assert!(
                close(ratio.max, 1.0 / fraction - 1.0, 1e-12) && ratio.count == voids.of_each.len() as u64
            );
            assert!((voids.porosity - (1.0 - fraction)).abs() < 2e-3, "{n}: {}", voids.porosity);
            let largest = voids.pores.unwrap().max;
            assert!(largest <= hole && largest > hole - 0.03, "{n}: {largest} {hole}");
        }
    }
    // The hexagonal lattice in a sheared box: one disc.
    let cell = PeriodicBox::triclinic([0.0; 2], [[1.0, 0.0], [0.5, 0.75_f64.sqrt()]], [true; 2]).unwrap();
    let hexagonal = voids_of(&[[0.3, 0.2]], Sizes::All(0.5), Some(cell));
    let fraction = PI / 12.0_f64.sqrt();
    assert!(close(hexagonal.of_each[0], 1.0 / fraction - 1.0, 1e-12), "{:?}", hexagonal.of_each);
    assert!((hexagonal.porosity - (1.0 - fraction)).abs() < 2e-3);
    // In open space the cells at the border are no cells.
    let (centres, _) = lattice(4, 1.0, &[[0.5; 3]]);
    let open = voids_of(&centres, Sizes::All(0.5), None);
    assert_eq!((open.at_border, open.hidden), (56, 0));
    let inside = open.void_ratio.unwrap();
    assert!(inside.count == 8 && close(inside.max, 6.0 / PI - 1.0, 1e-12));
}

/// Cells of unlike spheres against points that go to the sphere of the least power, and distances to the
/// nearest surface against all surfaces.
#[test]
fn voids_of_random_packings() {
    fn random<const D: usize>(state: &mut u64) -> [f64; D] {
        std::array::from_fn(|_| {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64
        })
    }
    fn check<const D: usize>(edges: [[f64; D]; D]) {
        const SAMPLES: usize = 40_000;
        let mut state = 99;
        let place = |at: [f64; D]| -> [f64; D] {
            std::array::from_fn(|axis| (0..D).map(|edge| at[edge] * edges[edge][axis]).sum())
        };
        let centres: Vec<[f64; D]> = (0..25).map(|_| place(random(&mut state))).collect();
        let radii: Vec<f64> = (0..25).map(|_| 0.1 + 0.5 * random::<1>(&mut state)[0]).collect();
        let cell = PeriodicBox::triclinic([0.0; D], edges, [true; D]).unwrap();
        let voids = voids_of(&centres, Sizes::Each(&radii), Some(cell));
        let ball = |radius: f64| if D == 2 { PI * radius * radius } else { 4.0 / 3.0 * PI * radius.powi(3) };
        let all: f64 = edges.iter().enumerate().map(|(axis, edge)| edge[axis]).product();
        let mut counts = [0_u32; 25];
        let (mut outside, mut sum) = (0_u32, 0.0);
        for _ in 0..SAMPLES {
            let at = place(random(&mut state));
            let (mut owner, mut least, mut surface) = (0, f64::INFINITY, f64::INFINITY);
            for (element, (centre, radius)) in centres.iter().zip(&radii).enumerate() {
                for image in 0..3_i32.pow(D as u32) {
                    let shift: [i32; D] =
                        std::array::from_fn(|axis| (image / 3_i32.pow(axis as u32)) % 3 - 1);
                    let centre = cell.displaced(centre, &shift);
                    let square: f64 = (0..D).map(|axis| (at[axis] - centre[axis]).powi(2)).sum();
                    surface = surface.min(square.sqrt() - radius);
                    if square - radius * radius < least {
                        (owner, least) = (element, square - radius * radius);
                    }
                }
            }
            counts[owner] += 1;
            if surface > 0.0 {
                outside += 1;
                sum += surface;
            }
        }
        let mut total = 0.0;
        for element in 0..25 {
            let share = f64::from(counts[element]) / SAMPLES as f64;
            let ratio = voids.of_each[element];
            if ratio.is_nan() {
                assert_eq!(counts[element], 0);
                continue;
            }
            let cell = (ratio + 1.0) * ball(radii[element]);
            total += cell;
            let error = 5.0 * (share.max(1e-5) / SAMPLES as f64).sqrt();
            assert!((cell / all - share).abs() < error, "{D}D, {element}: {} {share}", cell / all);
        }
        assert!(close(total, all, 1e-10), "cells fill the box: {total} {all}");
        let pores = voids.pores.unwrap();
        assert!((voids.porosity - f64::from(outside) / SAMPLES as f64).abs() < 1e-2);
        assert!((pores.mean * f64::from(outside) / sum - 1.0).abs() < 0.02, "{} {}", pores.mean, sum);
    }
    check([[4.0, 0.0], [1.0, 5.0]]);
    check([[2.5, 0.0, 0.0], [0.4, 2.0, 0.0], [-0.5, 0.3, 3.0]]);
}
