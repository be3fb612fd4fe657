//! Searches on any number of ranks, whose couples are compared with those of one process.

use fdem_contact::{Couple, Detector, Elements, PeriodicBox, PeriodicCouple, PeriodicSearch, Real, Search};
use fdem_distributed::{Communicator, DistributedSearch, Shapes};
use fdem_scenes::random::Random;
use fdem_scenes::{Cloud, Sizes, boxes, clusters, gas, lattice};

/// All elements of a test. Every rank makes them, and takes its own.
#[derive(Clone, Debug)]
pub(crate) struct Scene<T, const D: usize> {
    pub(crate) points: Vec<[T; D]>,
    pub(crate) sizes: SceneSizes<T, D>,
    pub(crate) tolerance: T,
}

#[derive(Clone, Debug)]
pub(crate) enum SceneSizes<T, const D: usize> {
    Equal(T),
    Radii(Vec<T>),
    Far(Vec<[T; D]>),
}

/// The rank that has an element at first.
pub(crate) const SPREADS: [fn(usize, usize) -> usize; 3] =
    [|place, ranks| place % ranks, |_, ranks| ranks - 1, |place, ranks| place / 97 % ranks];

impl<T: Real, const D: usize> Scene<T, D> {
    pub(crate) fn spheres(points: Vec<[T; D]>, radii: Vec<T>) -> Self {
        Self { points, sizes: SceneSizes::Radii(radii), tolerance: T::ZERO }
    }

    fn picked(&self, places: &[usize]) -> Self {
        let sizes = match &self.sizes {
            SceneSizes::Equal(radius) => SceneSizes::Equal(*radius),
            SceneSizes::Radii(radii) => SceneSizes::Radii(places.iter().map(|&k| radii[k]).collect()),
            SceneSizes::Far(far) => SceneSizes::Far(places.iter().map(|&k| far[k]).collect()),
        };
        Self { points: places.iter().map(|&k| self.points[k]).collect(), sizes, tolerance: self.tolerance }
    }

    fn shapes(&self) -> Shapes<'_, T, D> {
        match &self.sizes {
            SceneSizes::Equal(radius) => Shapes::Equal { centres: &self.points, radius: *radius },
            SceneSizes::Radii(radii) => Shapes::Spheres { centres: &self.points, radii },
            SceneSizes::Far(far) => Shapes::Boxes { min: &self.points, max: far },
        }
    }

    fn elements(&self) -> Elements<'_, T, D> {
        let elements = match &self.sizes {
            SceneSizes::Equal(radius) => Elements::spheres(&self.points, *radius),
            SceneSizes::Radii(radii) => Elements::spheres_with_radii(&self.points, radii),
            SceneSizes::Far(far) => Elements::boxes(&self.points, far),
        };
        elements.unwrap().with_tolerance(self.tolerance).unwrap()
    }
}

/// Ids in ascending order of places, with gaps.
fn id(place: usize) -> u32 {
    3 * place as u32 + 7
}

/// The places of the elements that a rank has, in no order.
fn share(n: usize, spread: fn(usize, usize) -> usize, communicator: &dyn Communicator) -> Vec<usize> {
    let (rank, size) = (communicator.rank(), communicator.size());
    let mut places: Vec<usize> = (0..n).filter(|&place| spread(place, size) == rank).collect();
    places.sort_unstable_by_key(|place| place.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    places
}

/// The couples of all ranks, one rank after the other, and a check that all have similar numbers of couples.
/// Among few elements, those of two may be a large share.
fn gathered<C>(
    communicator: &dyn Communicator,
    elements: usize,
    couples: &[C],
    numbers: impl Fn(&C) -> Vec<i64>,
) -> Vec<Vec<i64>> {
    let bytes: Vec<u8> = couples.iter().flat_map(&numbers).flat_map(i64::to_le_bytes).collect();
    let all = communicator.all_gather(&bytes);
    let mean = all.iter().map(Vec::len).sum::<usize>() / all.len();
    if mean > 8 * 3 * 2000 && elements >= 500 {
        assert!(all.iter().all(|run| run.len().abs_diff(mean) * 20 < mean), "even runs");
    }
    let width = couples.first().map_or(0, |couple| numbers(couple).len());
    let mut widths = [-(width as f64), width as f64];
    communicator.all_max(&mut widths);
    let all: Vec<i64> =
        all.concat().as_chunks::<8>().0.iter().map(|bytes| i64::from_le_bytes(*bytes)).collect();
    all.chunks((widths[1] as usize).max(1)).map(<[i64]>::to_vec).collect()
}

/// Compares a distributed search in open space with a search by one process.
pub(crate) fn check_open<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    scene: &Scene<T, D>,
    spread: fn(usize, usize) -> usize,
) {
    let mut expected = Vec::new();
    Detector::new().couples(&scene.elements(), &mut expected).unwrap();
    expected.sort_unstable();
    let expected: Vec<Vec<i64>> = expected
        .iter()
        .map(|couple| [couple.i, couple.j].map(|k| i64::from(id(k as usize))).to_vec())
        .collect();

    let places = share(scene.points.len(), spread, communicator);
    let own = scene.picked(&places);
    let ids: Vec<u32> = places.iter().map(|&place| id(place)).collect();
    let mut search = DistributedSearch::new(communicator);
    let found = search.couples(&ids, &own.shapes(), own.tolerance).unwrap();
    let numbers = |couple: &Couple| vec![i64::from(couple.i), i64::from(couple.j)];
    assert!(
        gathered(communicator, scene.points.len(), &found, numbers) == expected,
        "{} couples expected",
        expected.len()
    );
}

/// Compares a distributed search in a periodic box with a search by one process.
pub(crate) fn check_periodic<T: Real, const D: usize>(
    communicator: &dyn Communicator,
    scene: &Scene<T, D>,
    cell: &PeriodicBox<T, D>,
    spread: fn(usize, usize) -> usize,
) -> usize {
    let mut expected = Vec::new();
    PeriodicSearch::new().couples(&scene.elements(), cell, &mut expected).unwrap();
    expected.sort_unstable();
    let numbers = |couple: &PeriodicCouple<D>| {
        let shift = couple.shift.into_iter().map(i64::from);
        [i64::from(couple.i), i64::from(couple.j)].into_iter().chain(shift).collect::<Vec<_>>()
    };
    let across = expected.iter().filter(|couple| couple.shift != [0; D]).count();
    let with_ids = |couple: &PeriodicCouple<D>| {
        let [i, j] = [couple.i, couple.j].map(|k| id(k as usize));
        numbers(&PeriodicCouple { i, j, shift: couple.shift })
    };
    let expected: Vec<Vec<i64>> = expected.iter().map(with_ids).collect();

    let places = share(scene.points.len(), spread, communicator);
    let own = scene.picked(&places);
    let ids: Vec<u32> = places.iter().map(|&place| id(place)).collect();
    let mut search = DistributedSearch::new(communicator);
    let found = search.periodic_couples(&ids, &own.shapes(), own.tolerance, cell).unwrap();
    let found = gathered(communicator, scene.points.len(), &found, numbers);
    let missing = expected.iter().find(|couple| found.binary_search(couple).is_err());
    let extra = found.iter().find(|couple| expected.binary_search(couple).is_err());
    assert!(
        found == expected,
        "{} of {} couples, {missing:?} missing, {extra:?} too many",
        found.len(),
        expected.len()
    );
    across
}

fn of_cloud<const D: usize>(cloud: Cloud<D>) -> Scene<f64, D> {
    Scene::spheres(cloud.centres, cloud.radii)
}

/// Radii over four decades, the smaller the more frequent, at random places.
pub(crate) fn power_law<const D: usize>(n: usize, seed: u64, edge: f64) -> Scene<f64, D> {
    let mut random = Random::new(seed);
    let points = (0..n).map(|_| std::array::from_fn(|_| random.between(0.0, edge))).collect();
    let radii =
        (0..n).map(|k| if k == n / 2 { 1e3 } else { 0.1 * 1e4_f64.powf(random.uniform().powi(4)) }).collect();
    Scene::spheres(points, radii)
}

/// Scenes of both dimensions, kinds and floats.
pub(crate) fn open(communicator: &dyn Communicator, spread: fn(usize, usize) -> usize) {
    scenes::<2>(communicator, spread);
    scenes::<3>(communicator, spread);
}

fn scenes<const D: usize>(communicator: &dyn Communicator, spread: fn(usize, usize) -> usize) {
    let check = |scene: &Scene<f64, D>| check_open(communicator, scene, spread);
    let unlike = Sizes::Lognormal { median: 0.5, sigma: 0.5 };
    let dense = of_cloud(gas::<D>(6000, 1, 12.0, unlike).unwrap());
    check(&dense);
    check(&of_cloud(gas::<D>(3000, 2, 0.2, Sizes::Equal { radius: 0.5 }).unwrap()));
    check(&of_cloud(clusters::<D>(2000, 3, 400, 1e4, 6.0, unlike).unwrap()));
    check(&power_law::<D>(2000, 4, 400.0));

    // Neighbours touch exactly.
    let grid = lattice::<D>(if D == 2 { 900 } else { 1000 }, 1.0, 0.5).unwrap();
    check(&Scene { points: grid.centres, sizes: SceneSizes::Equal(0.5), tolerance: 0.0 });
    let equal = Scene { points: dense.points.clone(), sizes: SceneSizes::Equal(0.3), tolerance: 0.25 };
    check(&equal);

    let mixed = boxes::<D>(2000, 5, 6.0, 8.0).unwrap();
    check(&Scene { points: mixed.min, sizes: SceneSizes::Far(mixed.max), tolerance: 0.125 });

    // One element is so far away that all others are in one cell of every grid, or in two.
    let mut far = of_cloud(gas::<D>(3000, 6, 8.0, Sizes::Equal { radius: 0.5 }).unwrap());
    far.points.push([1e5; D]);
    let SceneSizes::Radii(radii) = &mut far.sizes else { return };
    radii.push(0.5);
    check(&far);
    far.points[3000] = [1e12; D];
    check(&far);

    // All in one place, two places, and points without size.
    let same = Scene { points: vec![[0.5; D]; 100], sizes: SceneSizes::Equal(0.0), tolerance: 0.0 };
    check(&same);
    let two = (0..100).map(|k| [f64::from(k % 2); D]).collect();
    check(&Scene { points: two, sizes: SceneSizes::Equal(0.25), tolerance: 0.0 });

    // Fewer elements than ranks.
    for n in 0..4 {
        let points = (0..n).map(|k| [f64::from(k); D]).collect();
        check(&Scene { points, sizes: SceneSizes::Equal(1.0), tolerance: 0.0 });
    }

    let single = |x: f64| x as f32;
    let SceneSizes::Radii(radii) = &dense.sizes else { return };
    let points = dense.points.iter().map(|point| point.map(single)).collect();
    check_open(communicator, &Scene::spheres(points, radii.iter().map(|r| single(*r)).collect()), spread);
}

/// Boxes of all kinds, small and large compared with the elements, with elements outside.
pub(crate) fn periodic(communicator: &dyn Communicator, spread: fn(usize, usize) -> usize) {
    let unlike = Sizes::Lognormal { median: 0.5, sigma: 0.5 };
    let flat = of_cloud(gas::<2>(1500, 11, 6.0, unlike).unwrap());
    let solid = of_cloud(gas::<3>(1500, 12, 6.0, unlike).unwrap());
    let edge = |points: &[[f64; 2]]| points.iter().map(|x| x[0].max(x[1])).fold(0.0, f64::max);
    let width = edge(&flat.points);
    let mut across = 0;

    // Some elements are outside, by several periods and in both directions.
    let mut away = flat.clone();
    for (k, point) in away.points.iter_mut().enumerate() {
        point[0] += width * ((k % 5) as f64 - 2.0);
        point[1] -= width * (k % 3) as f64;
    }
    for axes in [[true, true], [true, false], [false, true]] {
        let cell = PeriodicBox::orthogonal([0.0, 0.0], [width, width], axes).unwrap();
        across += check_periodic(communicator, &flat, &cell, spread);
        across += check_periodic(communicator, &away, &cell, spread);
    }
    let sheared =
        PeriodicBox::triclinic([0.3, -0.7], [[width, 0.0], [1.7 * width, width]], [true, true]).unwrap();
    across += check_periodic(communicator, &flat, &sheared, spread);
    across += check_periodic(communicator, &away, &sheared, spread);
    let skewed =
        PeriodicBox::triclinic([0.3, -0.7], [[width, 0.0], [97.3 * width, width]], [true, true]).unwrap();
    across += check_periodic(communicator, &flat, &skewed, spread);
    across += check_periodic(communicator, &away, &skewed, spread);

    let width = solid.points.iter().flatten().copied().fold(0.0, f64::max);
    let cube = PeriodicBox::orthogonal([0.0; 3], [width; 3], [true; 3]).unwrap();
    across += check_periodic(communicator, &solid, &cube, spread);
    let edges = [[width, 0.1, -0.2], [0.4 * width, width, 0.0], [-0.3 * width, 0.6 * width, width]];
    let tilted = PeriodicBox::triclinic([1.0, 2.0, 3.0], edges, [true; 3]).unwrap();
    across += check_periodic(communicator, &solid, &tilted, spread);
    let single = |x: f64| x as f32;
    if let SceneSizes::Radii(radii) = &solid.sizes {
        let points = solid.points.iter().map(|point| point.map(single)).collect();
        let scene = Scene::spheres(points, radii.iter().map(|r| single(*r)).collect());
        let cell =
            PeriodicBox::triclinic([1.0, 2.0, 3.0], edges.map(|edge| edge.map(single)), [true; 3]).unwrap();
        across += check_periodic(communicator, &scene, &cell, spread);
    }

    // Neighbours touch exactly, across the faces too; the sums are exact.
    let grid = lattice::<3>(512, 1.0, 0.5).unwrap();
    let cell = PeriodicBox::orthogonal([0.0; 3], [8.0; 3], [true; 3]).unwrap();
    let scene = Scene { points: grid.centres, sizes: SceneSizes::Equal(0.5), tolerance: 0.0 };
    across += check_periodic(communicator, &scene, &cell, spread);

    // Sizes over four decades, the largest of which span the box several times.
    let unlike = power_law::<2>(300, 13, 400.0);
    let cell = PeriodicBox::orthogonal([0.0; 2], [400.0; 2], [true; 2]).unwrap();
    across += check_periodic(communicator, &unlike, &cell, spread);

    // A box smaller than its elements, and one element that touches its own images.
    let mut random = Random::new(14);
    let points = (0..20).map(|_| [random.between(-3.0, 3.0), random.between(-3.0, 3.0)]).collect();
    let crowd = Scene { points, sizes: SceneSizes::Equal(0.75), tolerance: 0.125 };
    let cell = PeriodicBox::triclinic([0.0; 2], [[1.0, 0.25], [0.5, 1.0]], [true; 2]).unwrap();
    across += check_periodic(communicator, &crowd, &cell, spread);
    across += check_periodic(communicator, &crowd.picked(&[3]), &cell, spread);
    check_periodic(communicator, &crowd.picked(&[]), &cell, spread);

    let mixed = boxes::<3>(800, 15, 4.0, 6.0).unwrap();
    let width = mixed.max.iter().flatten().copied().fold(0.0, f64::max);
    let cell = PeriodicBox::orthogonal([0.0; 3], [width; 3], [true, true, false]).unwrap();
    let scene = Scene { points: mixed.min, sizes: SceneSizes::Far(mixed.max), tolerance: 0.0625 };
    across += check_periodic(communicator, &scene, &cell, spread);
    assert!(across > 1000, "{across} couples across faces");
}
