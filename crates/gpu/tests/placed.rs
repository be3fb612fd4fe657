//! Elements that are on a device already: the couples, the order and the errors of elements that come from
//! the host.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used, reason = "tests")]

use bytemuck::{Pod, cast_slice};
use fdem_contact::{Elements, Error, Real, Rows, Search};
use fdem_gpu::{Device, DeviceRows, Host, HostBuild, PlacedElements, PlacedRadii};
use fdem_scenes::random::Random;

fn placed<T: Pod>(host: Host, numbers: &[T]) -> <Host as Device>::Memory {
    let mut memory = host.allocate(size_of_val(numbers)).unwrap();
    host.write(&mut memory, cast_slice(numbers)).unwrap();
    memory
}

/// The couples of points on the device, or the error, which are compared with those of the processor. `Err`
/// is a radius of all.
fn same<T: Real + Pod, const D: usize>(
    what: &str,
    points: &[[T; D]],
    radii: Result<&[T], T>,
    tolerance: T,
) -> Result<usize, Error> {
    let elements = match radii {
        Ok(radii) => Elements::spheres_with_radii(points, radii),
        Err(radius) => Elements::spheres(points, radius),
    };
    let expected = elements.and_then(|elements| elements.with_tolerance(tolerance)).and_then(|elements| {
        let mut couples = Vec::new();
        Rows::new().couples(&elements, &mut couples).map(|()| couples)
    });
    for build in [HostBuild::Ascending, HostBuild::Descending] {
        let host = Host(build);
        let memory = placed(host, points.as_flattened());
        let of_radii = placed(host, radii.unwrap_or_default());
        let elements = PlacedElements {
            count: points.len(),
            points: &memory,
            radii: radii.map_or_else(PlacedRadii::One, |_| PlacedRadii::Each(&of_radii)),
            tolerance,
        };
        let mut search = DeviceRows::<_, T, D>::new(&host);
        for _ in 0..2 {
            let found = search.find_placed(&elements).and_then(|found| {
                let couples = found.read()?;
                assert_eq!((found.len(), found.is_empty()), (couples.len(), couples.is_empty()));
                if let Some(memory) = found.memory() {
                    // The couples are at the beginning of the memory.
                    let mut first = [0; 8];
                    host.read(memory, 0, &mut first).unwrap();
                    let first: [u32; 2] = bytemuck::cast(first);
                    assert!(couples.first().is_none_or(|couple| [couple.i, couple.j] == first));
                }
                Ok(couples)
            });
            // NaN differs from itself, so errors are compared by their words.
            match (&found, &expected) {
                (Err(found), Err(expected)) => assert_eq!(found.to_string(), expected.to_string(), "{what}"),
                _ => assert!(found == expected, "{what}: {build:?}"),
            }
        }
    }
    expected.map(|couples| couples.len())
}

fn gases<T: Real + Pod, const D: usize>() {
    let mut random = Random::new(21);
    let of = T::nearest;
    let mut couples = 0;
    for n in [1, 2, 255, 4096, 4097, 20_000] {
        // The sparse ones have wider cells, by a sample.
        for density in [8.0, 1.0, 0.05, 0.002] {
            let width = (f64::from(n) / density).powf(1.0 / D as f64);
            let place = random.between(-2.0, 1.0) * width;
            let points: Vec<[T; D]> =
                (0..n).map(|_| std::array::from_fn(|_| of(place + random.between(0.0, width)))).collect();
            let what = format!("{n} elements, {density}");
            couples += same(&what, &points, Err(of(0.5)), of(0.0)).unwrap();
            let radii: Vec<T> = (0..n).map(|_| of(random.between(0.1, 0.5))).collect();
            couples += same(&what, &points, Ok(&radii), of(0.02)).unwrap();
            couples += same(&what, &points, Ok(&vec![of(0.4); n as usize]), of(0.1)).unwrap();
        }
        // Without size: about one cell each.
        let points: Vec<[T; D]> =
            (0..n).map(|_| std::array::from_fn(|_| of(random.below(30) as f64))).collect();
        couples += same("points without size", &points, Err(of(0.0)), of(0.0)).unwrap();
    }
    assert!(couples > 200_000, "{couples}");
}

#[test]
fn gases_on_the_device_in_the_plane() {
    gases::<f64, 2>();
    gases::<f32, 2>();
}

#[test]
fn gases_on_the_device_in_space() {
    gases::<f64, 3>();
    gases::<f32, 3>();
}

#[test]
fn zeros_of_both_signs_and_no_elements() {
    let points: Vec<[f64; 3]> = (0..600).map(|k| [[0.0, -0.0, 3.0], [-0.0, 0.0, 2.5]][k % 2]).collect();
    assert_eq!(same("zeros", &points, Err(0.25), 0.0), Ok(600 * 599 / 2));
    assert_eq!(same("radii", &points, Ok(&[[0.0, -0.0]; 300].concat()), 1.0), Ok(600 * 599 / 2));
    assert_eq!(same::<f64, 2>("none", &[], Err(1.0), 0.0), Ok(0));
    assert_eq!(same::<f64, 2>("none", &[], Ok(&[]), 0.0), Ok(0));
}

/// The first number that is refused is named, wherever it is, as on the processor.
#[test]
fn numbers_that_are_refused_are_named() {
    fn of_type<T: Real + Pod>() {
        let mut random = Random::new(22);
        let huge = T::MAX_MAGNITUDE + T::MAX_MAGNITUDE;
        for wrong in [T::nearest(f64::NAN), T::nearest(f64::INFINITY), T::ZERO - huge, huge] {
            let mut points: Vec<[T; 3]> =
                (0..9000).map(|_| std::array::from_fn(|_| T::nearest(random.uniform()))).collect();
            for (index, axis) in [(8999, 2), (4100, 0), (4100, 2), (0, 1)] {
                points[index][axis] = wrong;
                let error = same("a coordinate", &points, Err(T::HALF), T::ZERO).unwrap_err();
                let named = matches!(error, Error::NonFiniteCoordinate { index: i, .. } | Error::CoordinateTooLarge { index: i, .. } if i == index);
                assert!(named, "{error}");
            }
            let mut radii = vec![T::HALF; 9000];
            for index in [8999, 5000, 0] {
                radii[index] = wrong;
                let error = same("a radius", &points, Ok(&radii), T::ZERO).unwrap_err();
                assert!(
                    matches!(error, Error::InvalidRadius { index: Some(i), .. } if i == index),
                    "{error}"
                );
            }
            let one = points[0];
            assert!(same("one radius", &[one], Err(wrong), T::ZERO).is_err());
            assert!(same("radii that are equal", &points, Ok(&[wrong; 9000]), T::ZERO).is_err());
            assert!(same("a tolerance", &points[1..4000], Err(T::HALF), wrong).is_err());
        }
    }
    of_type::<f64>();
    of_type::<f32>();
}

#[test]
fn memory_that_is_too_short_is_refused() {
    let host = Host(HostBuild::Ascending);
    let (points, radii) = (placed(host, &[0.0_f64; 12]), placed(host, &[1.0_f64; 3]));
    let mut search = DeviceRows::<_, f64, 3>::new(&host);
    let mut message = |count, radii| {
        let elements = PlacedElements { count, points: &points, radii, tolerance: 0.0 };
        search.find_placed(&elements).err().unwrap().to_string()
    };
    assert_eq!(message(5, PlacedRadii::One(1.0)), "the memory for points has 96 bytes, and 120 are needed");
    assert_eq!(message(4, PlacedRadii::Each(&radii)), "the memory for radii has 24 bytes, and 32 are needed");
}

/// The memory of the couples outlives the search.
#[test]
fn couples_are_taken_out_of_a_search() {
    let host = Host(HostBuild::Ascending);
    let memory = placed(host, &[0.0_f64, 0.0, 1.0, 0.0, 5.0, 0.0, 5.5, 0.0]);
    let mut search = DeviceRows::<_, f64, 2>::new(&host);
    let elements = PlacedElements { count: 4, points: &memory, radii: PlacedRadii::One(0.5), tolerance: 0.0 };
    assert_eq!(search.find_placed(&elements).unwrap().len(), 2);
    let couples = search.into_couples().unwrap();
    assert_eq!(host.bytes(&couples), 16);
    let mut bytes = [0; 16];
    host.read(&couples, 0, &mut bytes).unwrap();
    assert_eq!(bytemuck::cast::<_, [u32; 4]>(bytes), [0, 1, 2, 3]);
    assert!(DeviceRows::<_, f64, 2>::new(&host).into_couples().is_none());
}
