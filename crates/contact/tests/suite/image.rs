//! Contacts in labelled images, compared with a brute force that uses neither rows nor runs, and with the
//! Voronoi diagram of a disc.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;

use fdem_contact::Error;
use fdem_contact::image::{ImageContact, ImageContacts, Label, Neighbourhood, Spacing, contacts};

use crate::random::SplitMix64;

/// A contact by definition: the list of its pairs of grid squares.
#[derive(Debug, Default)]
struct Pairs<const D: usize> {
    /// For pairs at a face, at an edge, and at a vertex: the centre, and the step to the grid square of the
    /// larger label.
    by_share: [Vec<([f64; D], [f64; D])>; 3],
}

/// Looks at all neighbours of each grid square.
fn brute_force<L: Label, const D: usize>(
    labels: &[L],
    shape: [usize; D],
    neighbourhood: Neighbourhood,
    background: Option<L>,
) -> BTreeMap<[L; 2], Pairs<D>> {
    let index = |mut at: usize| {
        let mut index = [0_i64; D];
        for axis in (0..D).rev() {
            index[axis] = (at % shape[axis]).cast_signed() as i64;
            at /= shape[axis];
        }
        index
    };
    let at = |index: [i64; D]| {
        let inside = (0..D).all(|axis| (0..shape[axis].cast_signed() as i64).contains(&index[axis]));
        inside.then(|| (0..D).fold(0, |at, axis| at * shape[axis] + index[axis] as usize))
    };
    let mut found: BTreeMap<[L; 2], Pairs<D>> = BTreeMap::new();
    for (here, &small) in labels.iter().enumerate() {
        for code in 0..3_usize.pow(D as u32) {
            let step: [i64; D] =
                std::array::from_fn(|axis| (code / 3_usize.pow(axis as u32) % 3).cast_signed() as i64 - 1);
            let axes = step.iter().filter(|step| **step != 0).count();
            let share = match axes {
                0 => continue,
                1 => 0,
                axes if axes == D => 2,
                _ => 1,
            };
            let from = index(here);
            let Some(there) = at(std::array::from_fn(|axis| from[axis] + step[axis])) else { continue };
            let large = labels[there];
            // Looks from the smaller to the larger label only, so that each pair counts once.
            if share > neighbourhood as usize
                || small >= large
                || [small, large].map(Some).contains(&background)
            {
                continue;
            }
            let middle = std::array::from_fn(|axis| from[axis] as f64 + step[axis] as f64 / 2.0);
            let pairs = &mut found.entry([small, large]).or_default().by_share[share];
            pairs.push((middle, step.map(|step| step as f64)));
        }
    }
    found
}

impl<const D: usize> Pairs<D> {
    /// Compares counts exactly, and means to rounding.
    #[track_caller]
    fn agree_with<L: Label>(&self, contact: &ImageContact<L, D>, spacing: &Spacing<D>) {
        let [faces, edges, vertices] = self.by_share.each_ref().map(|pairs| pairs.len() as u64);
        assert_eq!([contact.faces(), contact.edges(), contact.vertices()], [faces, edges, vertices]);
        let edge = spacing.edges();
        let volume: f64 = edge.iter().product();
        let (mut area, mut weights) = (0.0, 0.0);
        let (mut centre, mut normal) = ([0.0; D], [0.0; D]);
        let [at_faces, at_edges, at_vertices] = &self.by_share;
        for (middle, step) in at_faces {
            let across = (0..D).find(|&axis| step[axis] != 0.0).unwrap();
            let face = volume / edge[across];
            area += face;
            for axis in 0..D {
                centre[axis] += face * middle[axis] * edge[axis];
                normal[axis] += face * step[axis];
            }
        }
        weights += area;
        if at_faces.is_empty() {
            for (middle, step) in at_edges.iter().chain(at_vertices) {
                weights += 1.0;
                let length = (0..D).map(|axis| (step[axis] * edge[axis]).powi(2)).sum::<f64>().sqrt();
                for axis in 0..D {
                    centre[axis] += middle[axis] * edge[axis];
                    normal[axis] += step[axis] * edge[axis] / length;
                }
            }
        }
        let near = |found: f64, expected: f64, scale: f64| {
            assert!((found - expected).abs() <= 1e-12 * scale, "{found} is not {expected}");
        };
        near(contact.area(spacing), area, area);
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let vanishes = length < 1e-9;
        for axis in 0..D {
            let centre = centre[axis] / weights;
            near(contact.centroid(spacing)[axis], centre, 1.0 + centre.abs());
            near(contact.normal(spacing)[axis], if vanishes { 0.0 } else { normal[axis] / length }, 10.0);
        }
    }
}

/// Adds the planes in slabs of random thickness.
fn in_slabs<L: Label, const D: usize>(
    mut image: ImageContacts<L, D>,
    labels: &[L],
    shape: [usize; D],
    random: &mut SplitMix64,
) -> (Vec<ImageContact<L, D>>, usize) {
    let plane: usize = shape[1..].iter().product();
    let mut rest = labels;
    while !rest.is_empty() {
        let planes = random.index(rest.len() / plane + 1);
        let (slab, behind) = rest.split_at(planes * plane);
        image.add(slab).unwrap();
        rest = behind;
    }
    let labels = image.labels();
    (image.finish().unwrap(), labels)
}

/// SplitMix64 images with few labels in clumps: blocks, then single grid squares changed.
fn image<L: Copy, const D: usize>(shape: [usize; D], palette: &[L], random: &mut SplitMix64) -> Vec<L> {
    let plane: usize = shape[1..].iter().product();
    let (block, noise) = (1 + random.index(4), random.index(4));
    let salt = random.next();
    let squares = 0..shape[0] * plane;
    squares
        .map(|at| {
            let mut code = salt;
            let mut rest = at;
            for &length in shape.iter().rev() {
                code = SplitMix64(code ^ (rest % length / block) as u64).next();
                rest /= length;
            }
            let chosen = if random.index(10) < noise {
                random.index(palette.len())
            } else {
                code as usize % palette.len()
            };
            palette[chosen]
        })
        .collect()
}

fn equals_brute_force<L: Label + Debug, const D: usize>(
    palette: &[L],
    most: usize,
    random: &mut SplitMix64,
) -> usize {
    let shape: [usize; D] = std::array::from_fn(|_| 1 + random.index(most));
    let labels = image(shape, palette, random);
    let mut pairs = 0;
    let spacing = Spacing::new(std::array::from_fn(|_| 0.5 + random.unit())).unwrap();
    for neighbourhood in [Neighbourhood::Face, Neighbourhood::Edge, Neighbourhood::Vertex] {
        if D == 2 && neighbourhood == Neighbourhood::Edge {
            continue;
        }
        for background in [None, Some(palette[0])] {
            let expected = brute_force(&labels, shape, neighbourhood, background);
            let new = || ImageContacts::new(shape, neighbourhood).unwrap().with_background(background);
            let (whole, bodies) = in_slabs(new(), &labels, shape, random);
            assert_eq!(
                whole.iter().map(ImageContact::labels).collect::<Vec<_>>(),
                expected.keys().copied().collect::<Vec<_>>(),
                "{neighbourhood:?} {shape:?} {background:?}"
            );
            for (contact, pairs) in whole.iter().zip(expected.values()) {
                pairs.agree_with(contact, &spacing);
                pairs.agree_with(contact, &Spacing::UNIT);
            }
            let distinct: BTreeSet<_> =
                labels.iter().copied().filter(|&label| Some(label) != background).collect();
            assert_eq!(bodies, distinct.len());
            for threads in [1, 2, 5] {
                let image = new().with_threads(threads).unwrap();
                assert_eq!(
                    in_slabs(image, &labels, shape, random),
                    (whole.clone(), bodies),
                    "{threads} threads"
                );
            }
            pairs += expected
                .values()
                .map(|pairs| pairs.by_share.iter().map(Vec::len).sum::<usize>())
                .sum::<usize>();
        }
    }
    pairs
}

/// Images of every type of label, with its extremes, and with numbers that differ in their highest bits only.
/// The first label is the background.
fn of_all_types<const D: usize>(most: usize, random: &mut SplitMix64) -> usize {
    equals_brute_force::<_, D>(&[0_u8, 1, 2, 127, 128, u8::MAX], most, random)
        + equals_brute_force::<_, D>(&[0_u16, 1, 2, 256, 1 << 15, u16::MAX], most, random)
        + equals_brute_force::<_, D>(&[7_u32, 0, 1, 1 << 16, 1 << 31, u32::MAX], most, random)
        + equals_brute_force::<_, D>(&[0_u64, 1, 1 << 32, 1 << 63, u64::MAX - 1, u64::MAX], most, random)
        + equals_brute_force::<_, D>(&[-1_i32, i32::MIN, 0, 1, 2, i32::MAX], most, random)
        + equals_brute_force::<_, D>(&[0_i64, i64::MIN, -1, 1, 1 << 32, i64::MAX], most, random)
}

#[test]
fn images_in_2d_equal_brute_force() {
    let mut random = SplitMix64(2);
    let pairs: usize = (0..60).map(|round| of_all_types::<2>([12, 40][round % 2], &mut random)).sum();
    assert!(pairs > 100_000, "{pairs}");
}

#[test]
fn images_in_3d_equal_brute_force() {
    let mut random = SplitMix64(3);
    let pairs: usize = (0..24).map(|round| of_all_types::<3>([6, 16][round % 2], &mut random)).sum();
    assert!(pairs > 100_000, "{pairs}");
}

/// Grains of a disc: the rasterised cells of a Voronoi diagram. Two grains touch if their cells share a side;
/// the contact is at its middle, in the direction of their sites.
#[test]
fn grains_of_a_disc_touch_as_their_cells_do() {
    const GRAINS: usize = 40;
    const PIXELS: usize = 1200;
    const RADIUS: f64 = 1.0;
    let pixel = 2.0 * RADIUS / PIXELS as f64;
    let mut random = SplitMix64(5);
    let mut sites: Vec<[f64; 2]> = Vec::new();
    while sites.len() < GRAINS {
        let site = [0; 2].map(|_| (2.0 * random.unit() - 1.0) * RADIUS);
        let apart = |other: &[f64; 2]| (site[0] - other[0]).hypot(site[1] - other[1]) > 0.2;
        if site[0].hypot(site[1]) < 0.95 * RADIUS && sites.iter().all(apart) {
            sites.push(site);
        }
    }
    // The side of two cells: their bisector, clipped to the disc and to the region nearer to these sites than
    // to others.
    let mut sides = BTreeMap::new();
    for j in 0..GRAINS {
        for i in 0..j {
            let [a, b] = [sites[i], sites[j]];
            let middle = [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])];
            let distance = (b[0] - a[0]).hypot(b[1] - a[1]);
            let normal = [(b[0] - a[0]) / distance, (b[1] - a[1]) / distance];
            let along = [-normal[1], normal[0]];
            let dot = |u: [f64; 2], v: [f64; 2]| u[0] * v[0] + u[1] * v[1];
            let half = (RADIUS * RADIUS - dot(middle, normal).powi(2)).max(0.0).sqrt();
            let [mut low, mut high] = [-half, half].map(|t| t - dot(middle, along));
            for (k, site) in sites.iter().enumerate() {
                if k != i && k != j {
                    // |p - a|² <= |p - site|² for p = middle + t * along.
                    let to = [site[0] - a[0], site[1] - a[1]];
                    let (slope, limit) =
                        (2.0 * dot(along, to), dot(*site, *site) - dot(a, a) - 2.0 * dot(middle, to));
                    if slope > 0.0 { high = high.min(limit / slope) } else { low = low.max(limit / slope) }
                }
            }
            if low < high {
                let t = f64::midpoint(low, high);
                let centre = [middle[0] + t * along[0], middle[1] + t * along[1]];
                sides.insert([i as u16 + 1, j as u16 + 1], (high - low, centre, normal));
            }
        }
    }
    let shortest = sides.values().map(|side| side.0).fold(f64::INFINITY, f64::min);
    assert!(shortest > 2.0 * pixel, "a side of {} pixels may be lost: take other sites", shortest / pixel);

    let place = |index: usize| (index as f64 + 0.5) * pixel - RADIUS;
    let label = |at: usize| {
        let p = [place(at / PIXELS), place(at % PIXELS)];
        if p[0].hypot(p[1]) > RADIUS {
            return 0;
        }
        let distance = |k: &usize| (p[0] - sites[*k][0]).hypot(p[1] - sites[*k][1]);
        (0..GRAINS).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap() as u16 + 1
    };
    let labels: Vec<u16> = (0..PIXELS * PIXELS).map(label).collect();
    let found = contacts(&labels, [PIXELS; 2], Neighbourhood::Face).unwrap();
    assert_eq!(
        found.iter().map(ImageContact::labels).collect::<Vec<_>>(),
        sides.keys().copied().collect::<Vec<_>>()
    );
    assert!(found.len() > 80, "{}", found.len());
    let spacing = Spacing::new([pixel; 2]).unwrap();
    for (contact, (length, centre, normal)) in found.iter().zip(sides.values()) {
        let (at, direction) = (contact.centroid(&spacing), contact.normal(&spacing));
        let off = (at[0] - RADIUS + pixel / 2.0 - centre[0]).hypot(at[1] - RADIUS + pixel / 2.0 - centre[1]);
        // A side is off by up to a pixel at either end, and is drawn in steps.
        assert!(off < 2.0 * pixel, "{contact:?} is {} pixels off", off / pixel);
        let cosine = direction[0] * normal[0] + direction[1] * normal[1];
        assert!(1.0 - cosine < 4.0 * (pixel / length).powi(2), "{contact:?}: cosine {cosine}");
        // Because of steps along both axes, its length lies between the true length and the sum of its
        // projections.
        let steps = length * (normal[0].abs() + normal[1].abs());
        assert!((contact.area(&spacing) - steps).abs() < 5.0 * pixel, "{contact:?}: {steps}");
    }
}

#[test]
fn images_without_grid_squares_have_no_contacts() {
    for shape in [[0, 3, 3], [3, 0, 3], [3, 3, 0]] {
        let mut image = ImageContacts::<u8, 3>::new(shape, Neighbourhood::Vertex).unwrap();
        image.add(&[]).unwrap();
        assert!(shape[0] == 0 || image.labels() == 0);
        assert_eq!(image.finish(), Ok(vec![]));
    }
    assert_eq!(contacts::<u8, 2>(&[], [0, 0], Neighbourhood::Face), Ok(vec![]));
}

#[test]
fn what_is_no_image_is_refused() {
    let two = |shape| ImageContacts::<u8, 2>::new(shape, Neighbourhood::Face);
    assert_eq!(ImageContacts::<u8, 2>::new([2, 2], Neighbourhood::Edge).unwrap_err(), Error::NoEdgesIn2D);
    for shape in [[usize::MAX, 2], [1 << 31, 1 << 32], [1, usize::MAX]] {
        assert_eq!(two(shape).unwrap_err(), Error::ImageTooLarge { shape: shape.to_vec() });
    }
    let mut image = two([2, 3]).unwrap();
    assert_eq!(image.add(&[1, 2]), Err(Error::PartialPlane { squares: 2, plane: 3 }));
    assert_eq!(image.add(&[1; 9]), Err(Error::TooManyPlanes { found: 3, expected: 2 }));
    // None of the failed slabs was added.
    image.add(&[1, 1, 2]).unwrap();
    assert_eq!(image.clone().finish(), Err(Error::MissingPlanes { found: 1, expected: 2 }));
    image.add(&[2, 2, 2]).unwrap();
    assert_eq!(image.add(&[1; 3]), Err(Error::TooManyPlanes { found: 3, expected: 2 }));
    assert_eq!(image.finish().unwrap()[0].faces(), 3);
    assert_eq!(two([3, 0]).unwrap().add(&[1]), Err(Error::PartialPlane { squares: 1, plane: 0 }));
    assert!(matches!(two([1, 1]).unwrap().with_threads(1 << 20), Err(Error::NoThreads { .. })));
}
