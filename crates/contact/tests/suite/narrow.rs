//! The narrow phase against independent answers, at least 20,000 pairs for each kind of pair,
//! 40,000 under `just thorough`.
//!
//! | section | compared with |
//! |---|---|
//! | exact numbers | (the reference in case of differences) separating axes in exact arithmetic |
//! | round bodies | `parry`: distances, depths |
//! | segments | exact arithmetic, `parry` |
//! | plane figures | exact arithmetic, `geo`; areas: columns |
//! | triangles, tetrahedra in 3D | exact arithmetic, `parry`; volumes: slices and columns |
//! | boxes | `parry`: distance; depth: the corners along all axes |
//!
//! Half of the pairs have coordinates 0 to 4, some of them shifted by 2^-50, the step between floats at 4.
//! Therefore shared vertices, collinear and coplanar figures, and figures one step off, are common. The other
//! half are random.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]
#![allow(clippy::cast_possible_wrap, reason = "the numbers of the grid are below 8")]

use std::ops::{Add, Mul, Sub};

use fdem_contact::narrow::{
    Capsule, Contact, ConvexPolygon, Measure, OrientedBox, Plane, Segment, Sphere, Tetrahedron, Triangle,
    box_box, capsule_capsule, polygon_polygon, segment_segment, sphere_mesh, sphere_plane, sphere_sphere,
    sphere_triangle, tetrahedron_tetrahedron, triangle_triangle, triangle_triangle_2d,
};
use geo::{Area, BooleanOps, ConvexHull, Intersects};
use num_rational::BigRational;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{self, PointQuery};
use parry3d_f64::shape;

use crate::random::SplitMix64;

fn number_of_pairs() -> usize {
    if crate::thorough() { 40_000 } else { 8_000 }
}

// ---------------------------------------------------------------- points

impl SplitMix64 {
    fn point<const D: usize>(&mut self, scale: f64) -> [f64; D] {
        std::array::from_fn(|_| scale * self.unit())
    }

    /// Points of the grid 0 to `size`; every fourth coordinate is shifted if `shifts`.
    fn grid<const D: usize, const N: usize>(&mut self, size: u64, shifts: bool) -> [[Near; D]; N] {
        std::array::from_fn(|_| {
            std::array::from_fn(|_| {
                let shift = if shifts && self.below(4) == 0 { self.below(3) as i64 - 1 } else { 0 };
                Near([self.below(size + 1) as i64, shift, 0, 0, 0])
            })
        })
    }
}

/// The step between floats at 4.
const STEP: f64 = 1.0 / (1_u64 << 50) as f64;

fn floats<const D: usize, const N: usize>(points: &[[Near; D]; N]) -> [[f64; D]; N] {
    points.map(|p| p.map(|Near([whole, steps, ..])| whole as f64 + steps as f64 * STEP))
}

// ---------------------------------------------------------------- exact numbers

trait Number: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    fn sign(&self) -> i32;
}

/// A polynomial in [`STEP`] whose coefficients are far below the inverse of it: the first nonzero coefficient
/// has the sign.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Near([i64; 5]);

impl Add for Near {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Near {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul for Near {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self(std::array::from_fn(|k| (0..=k).map(|j| self.0[j] * other.0[k - j]).sum()))
    }
}

impl Number for Near {
    fn sign(&self) -> i32 {
        self.0.iter().find(|&&x| x != 0).map_or(0, |&x| x.signum() as i32)
    }
}

impl Number for BigRational {
    fn sign(&self) -> i32 {
        let zero = Self::from_integer(0.into());
        i32::from(*self > zero) - i32::from(*self < zero)
    }
}

fn rational<const D: usize>(points: &[[f64; D]]) -> Vec<[BigRational; D]> {
    points.iter().map(|p| p.map(|x| BigRational::from_float(x).unwrap())).collect()
}

fn minus<N: Number, const D: usize>(a: &[N; D], b: &[N; D]) -> [N; D] {
    std::array::from_fn(|k| a[k].clone() - b[k].clone())
}

fn times<N: Number, const D: usize>(a: &[N; D], b: &[N; D]) -> N {
    (1..D).fold(a[0].clone() * b[0].clone(), |sum, k| sum + a[k].clone() * b[k].clone())
}

fn across<N: Number>(a: &[N; 3], b: &[N; 3]) -> [N; 3] {
    let part = |i: usize, j: usize| a[i].clone() * b[j].clone() - a[j].clone() * b[i].clone();
    [part(1, 2), part(2, 0), part(0, 1)]
}

/// Whether all points of one set are strictly before all of the other along an axis.
fn separates<N: Number, const D: usize>(axis: &[N; D], a: &[[N; D]], b: &[[N; D]]) -> bool {
    let range = |points: &[[N; D]]| {
        let mut heights = points.iter().map(|p| times(axis, p));
        let first = heights.next().unwrap();
        heights.fold((first.clone(), first), |(low, high), h| {
            let low = if (h.clone() - low.clone()).sign() < 0 { h.clone() } else { low };
            let high = if (h.clone() - high.clone()).sign() > 0 { h } else { high };
            (low, high)
        })
    };
    let ((low_a, high_a), (low_b, high_b)) = (range(a), range(b));
    (low_b - high_a).sign() > 0 || (low_a - high_b).sign() > 0
}

fn edges<N: Number, const D: usize>(points: &[[N; D]]) -> Vec<[N; D]> {
    (0..points.len()).flat_map(|i| (0..i).map(move |j| minus(&points[i], &points[j]))).collect()
}

/// Whether the hulls of two sets in 2D have a point in common: their difference is a polygon, segment or
/// point that contains the origin.
fn exact_touch_2d<N: Number>(a: &[[N; 2]], b: &[[N; 2]]) -> bool {
    let w = minus(&a[0], &b[0]);
    let zero = w[0].clone() - w[0].clone();
    let mut axes = vec![w];
    for e in edges(a).into_iter().chain(edges(b)) {
        axes.push([zero.clone() - e[1].clone(), e[0].clone()]);
        axes.push(e);
    }
    !axes.iter().any(|axis| separates(axis, a, b))
}

/// The same in 3D. The normals of the difference are cross products of edges; a flat difference has others
/// too.
fn exact_touch_3d<N: Number>(a: &[[N; 3]], b: &[[N; 3]]) -> bool {
    let edges: Vec<_> = edges(a).into_iter().chain(edges(b)).collect();
    let mut normals = Vec::new();
    for (k, e) in edges.iter().enumerate() {
        for f in &edges[..k] {
            let n = across(e, f);
            if n.iter().any(|x| x.sign() != 0) {
                if separates(&n, a, b) {
                    return false;
                }
                normals.push(n);
            }
        }
    }
    if normals.iter().any(|n| edges.iter().any(|e| times(n, e).sign() != 0)) {
        return true;
    }
    let w = minus(&a[0], &b[0]);
    let mut axes = vec![w.clone()];
    for e in &edges {
        axes.push(across(&across(e, &w), e));
        axes.push(e.clone());
        axes.extend(normals.first().map(|n| across(n, e)));
    }
    !axes.iter().any(|axis| separates(axis, a, b))
}

// ---------------------------------------------------------------- measures

fn dot<const D: usize>(a: [f64; D], b: [f64; D]) -> f64 {
    (0..D).map(|k| a[k] * b[k]).sum()
}

/// A gap is right if the bodies are that far apart along the normal, because then no two of their points are
/// closer, and if the point is in the middle of it. Along the normal of a touch the bodies overlap.
fn check_direction<const D: usize>(contact: &Contact<D>, a: &[[f64; D]], b: &[[f64; D]], tolerance: f64) {
    let n = contact.normal;
    assert!((dot(n, n) - 1.0).abs() < 1e-14, "{contact:?} of {a:?} and {b:?}");
    let high = a.iter().map(|&p| dot(n, p)).fold(f64::NEG_INFINITY, f64::max);
    let low = b.iter().map(|&p| dot(n, p)).fold(f64::INFINITY, f64::min);
    match contact.measure {
        // The distance of convex bodies is the width of the widest slab between them.
        Measure::Gap(gap) if gap > tolerance.sqrt() => {
            // The direction of a short gap is as inaccurate as its ends.
            let tolerance = tolerance + 2e-14 / gap;
            assert!((low - high - gap).abs() < tolerance, "{contact:?}: {} of {a:?} and {b:?}", low - high);
            let middle = dot(n, contact.point);
            assert!((middle - 0.5 * (low + high)).abs() < tolerance, "{contact:?} of {a:?} and {b:?}");
        }
        Measure::Gap(gap) => assert!(gap < 2.0 * tolerance.sqrt()),
        _ => assert!(high - low > -tolerance, "{contact:?} of {a:?} and {b:?}"),
    }
}

/// The heights of the hull of some points above a given x: the lowest and the highest chord.
fn column(points: &[[f64; 2]], x: f64) -> (f64, f64) {
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for (k, p) in points.iter().enumerate() {
        for q in &points[..k] {
            if (p[0] - x) * (q[0] - x) < 0.0 {
                let y = p[1] + (x - p[0]) / (q[0] - p[0]) * (q[1] - p[1]);
                range = (range.0.min(y), range.1.max(y));
            }
        }
    }
    range
}

/// The common area of two hulls: between the places where their chords end or cross, the common height is
/// linear in x.
fn area_in_common(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let mut places: Vec<f64> = a.iter().chain(b).map(|p| p[0]).collect();
    for (i, p) in a.iter().enumerate() {
        for q in &a[..i] {
            for (j, r) in b.iter().enumerate() {
                for s in &b[..j] {
                    let (u, v) = ([q[0] - p[0], q[1] - p[1]], [s[0] - r[0], s[1] - r[1]]);
                    let turn = u[0] * v[1] - u[1] * v[0];
                    if turn != 0.0 {
                        let t = ((r[0] - p[0]) * v[1] - (r[1] - p[1]) * v[0]) / turn;
                        if t > 0.0 && t < 1.0 {
                            places.push(p[0] + t * u[0]);
                        }
                    }
                }
            }
        }
    }
    places.sort_by(f64::total_cmp);
    let mut area = 0.0;
    for pair in places.windows(2) {
        let x = 0.5 * (pair[0] + pair[1]);
        let ((low_a, high_a), (low_b, high_b)) = (column(a, x), column(b, x));
        area += (pair[1] - pair[0]) * (high_a.min(high_b) - low_a.max(low_b)).max(0.0);
    }
    area
}

/// The cut of a tetrahedron at a height: the points where its edges pass it.
fn slice(t: &[[f64; 3]; 4], z: f64) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for i in 0..4 {
        for j in 0..i {
            let (p, q) = (t[i], t[j]);
            if (p[2] - z) * (q[2] - z) < 0.0 {
                let s = (z - p[2]) / (q[2] - p[2]);
                points.push([p[0] + s * (q[0] - p[0]), p[1] + s * (q[1] - p[1])]);
            }
        }
    }
    points
}

/// The common volume of two tetrahedra: between the heights of vertices, and of edges through faces, the
/// common area is quadratic in z, and two Gauss points give its integral.
fn volume_in_common(a: &[[f64; 3]; 4], b: &[[f64; 3]; 4]) -> f64 {
    let mut places: Vec<f64> = a.iter().chain(b).map(|p| p[2]).collect();
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    for (own, other) in [(a, b), (b, a)] {
        for k in 0..4 {
            let face = [other[(k + 1) % 4], other[(k + 2) % 4], other[(k + 3) % 4]];
            let n = cross(minus(face[1], face[0]), minus(face[2], face[0]));
            for i in 0..4 {
                for j in 0..i {
                    let (from, to) = (dot(n, minus(own[i], face[0])), dot(n, minus(own[j], face[0])));
                    if from * to < 0.0 {
                        places.push(own[i][2] + from / (from - to) * (own[j][2] - own[i][2]));
                    }
                }
            }
        }
    }
    places.sort_by(f64::total_cmp);
    let offset = 1.0 / 12.0_f64.sqrt();
    let mut volume = 0.0;
    for pair in places.windows(2) {
        let width = pair[1] - pair[0];
        if width > 1e-13 {
            for z in [0.5 - offset, 0.5 + offset].map(|s| pair[0] + s * width) {
                volume += 0.5 * width * area_in_common(&slice(a, z), &slice(b, z));
            }
        }
    }
    volume
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// The gap, or minus the depth.
fn signed<const D: usize>(contact: &Contact<D>) -> f64 {
    if contact.touches() { -contact.measure.value() } else { contact.measure.value() }
}

fn vector(p: [f64; 3]) -> Vector {
    Vector::new(p[0], p[1], p[2])
}

fn array(p: Vector) -> [f64; 3] {
    [p.x, p.y, p.z]
}

// ---------------------------------------------------------------- round bodies

#[test]
fn spheres_and_planes_agree_with_parry() {
    let mut rng = SplitMix64(1);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        let (c, d): ([f64; 3], [f64; 3]) = if grid {
            let [c, d] = floats(&rng.grid::<3, 2>(4, true));
            (c, d)
        } else {
            (rng.point(4.0), rng.point(4.0))
        };
        let (r, s) =
            if grid { (rng.below(4) as f64, 1.0 + rng.below(3) as f64) } else { (rng.unit(), rng.unit()) };
        let (a, b) = (Sphere::new(c, r).unwrap(), Sphere::new(d, s).unwrap());
        let contact = sphere_sphere(&a, &b);
        let there = query::contact(
            &Pose::from_translation(vector(c)),
            &shape::Ball::new(r),
            &Pose::from_translation(vector(d)),
            &shape::Ball::new(s),
            100.0,
        );
        assert!(close(signed(&contact), there.unwrap().unwrap().dist, 1e-14), "{a:?} {b:?}");
        let squared: f64 =
            (c[0] - d[0]) * (c[0] - d[0]) + (c[1] - d[1]) * (c[1] - d[1]) + (c[2] - d[2]) * (c[2] - d[2]);
        assert_eq!(contact.touches(), squared <= (r + s) * (r + s), "{a:?} {b:?}");
        if c == d {
            continue;
        }
        // The plane perpendicular to the line of the centres, seen from the side of its normal, where it is
        // the half-space of parry.
        let n = std::array::from_fn(|k| c[k] - d[k]);
        let contact = sphere_plane(&a, &Plane::new(d, n).unwrap());
        let wall = shape::HalfSpace::new(vector(n).normalize());
        let there = wall.distance_to_local_point(vector(std::array::from_fn(|k| c[k] - d[k])), false) - r;
        assert!(close(signed(&contact), there, 1e-13), "{a:?}, plane at {d:?}");
    }
}

#[test]
fn spheres_against_triangles_agree_with_parry() {
    let mut rng = SplitMix64(2);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        let [a, b, c, p]: [[f64; 3]; 4] =
            if grid { floats(&rng.grid(4, case % 4 == 0)) } else { std::array::from_fn(|_| rng.point(4.0)) };
        let sphere = Sphere::new(p, 1.0).unwrap();
        let (contact, _) = sphere_triangle(&sphere, &Triangle::new([a, b, c]).unwrap());
        let area = cross(std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
        let there = shape::Triangle::new(vector(a), vector(b), vector(c));
        let distance = if dot(area, area) > 1e-12 {
            there.distance_to_local_point(vector(p), false)
        } else {
            // parry divides by the area.
            [[a, b], [b, c], [c, a]]
                .map(|[a, b]| {
                    shape::Segment::new(vector(a), vector(b)).distance_to_local_point(vector(p), false)
                })
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        };
        assert!(
            close(signed(&contact), distance - 1.0, 1e-12),
            "{a:?} {b:?} {c:?} {p:?}: {contact:?} {distance}"
        );
        assert!((dot(contact.normal, contact.normal) - 1.0).abs() < 1e-14);
        // The point is on the triangle, at that distance from the centre, in the direction of the normal.
        let way: [f64; 3] = std::array::from_fn(|k| contact.point[k] - p[k]);
        assert!(close(dot(way, contact.normal), distance, 1e-12), "{a:?} {b:?} {c:?} {p:?}: {contact:?}");
    }
}

#[test]
fn a_sphere_outside_of_a_convex_mesh_has_one_contact_and_parry_its_distance() {
    // The cube from 0 to 2, each face of eight triangles.
    let mut mesh = Vec::new();
    for axis in 0..3 {
        for side in [0.0, 2.0] {
            for cell in 0..4 {
                let at = |u: u32, v: u32| {
                    let mut p = [side; 3];
                    p[(axis + 1) % 3] = f64::from(cell % 2 + u);
                    p[(axis + 2) % 3] = f64::from(cell / 2 + v);
                    p
                };
                for corners in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                    mesh.push(Triangle::new(corners).unwrap());
                }
            }
        }
    }
    let cube = shape::Cuboid::new(Vector::new(1.0, 1.0, 1.0));
    let all: Vec<u32> = (0..mesh.len() as u32).collect();
    let mut contacts = Vec::new();
    let (mut rng, mut pairs) = (SplitMix64(3), 0);
    while pairs < number_of_pairs() {
        // A point on a grid of quarters, one step off it, or anywhere.
        let p: [f64; 3] = std::array::from_fn(|_| match rng.below(4) {
            0 => -1.0 + 4.0 * rng.unit(),
            1 => -1.0 + 0.25 * rng.below(17) as f64 + STEP,
            _ => -1.0 + 0.25 * rng.below(17) as f64,
        });
        let there = cube.distance_to_local_point(vector(p) - Vector::new(1.0, 1.0, 1.0), true);
        if there == 0.0 || there >= 1.0 {
            continue;
        }
        pairs += 1;
        sphere_mesh(&Sphere::new(p, 1.0).unwrap(), &mesh, &all, &mut contacts).unwrap();
        assert_eq!(contacts.len(), 1, "{p:?}: {contacts:?}");
        assert!(close(signed(&contacts[0].contact), there - 1.0, 1e-14), "{p:?}");
    }
}

// ---------------------------------------------------------------- segments

/// The squared distance between two segments, from ends and feet, exact.
fn exact_distance_squared(a: &[[f64; 3]; 2], b: &[[f64; 3]; 2]) -> BigRational {
    let (a, b) = (rational(a), rational(b));
    let (zero, one) = (BigRational::from_integer(0.into()), BigRational::from_integer(1.into()));
    let along = |p: &[BigRational; 3], u: &[BigRational; 3], t: &BigRational| -> [BigRational; 3] {
        std::array::from_fn(|k| p[k].clone() + t.clone() * u[k].clone())
    };
    let squared = |p: &[BigRational; 3], q: &[BigRational; 3]| {
        let d = minus(p, q);
        times(&d, &d)
    };
    let (u, v) = (minus(&a[1], &a[0]), minus(&b[1], &b[0]));
    let mut found = Vec::new();
    for (ends, from, direction) in [(&a, &b[0], &v), (&b, &a[0], &u)] {
        let length = times(direction, direction);
        for p in ends {
            let mut t = times(&minus(p, from), direction);
            t = if length == zero { zero.clone() } else { t / length.clone() };
            let t = t.max(zero.clone()).min(one.clone());
            found.push(squared(p, &along(from, direction, &t)));
        }
    }
    let n = across(&u, &v);
    let nn = times(&n, &n);
    if nn != zero {
        let w = minus(&b[0], &a[0]);
        let s = times(&across(&w, &v), &n) / nn.clone();
        let t = times(&across(&w, &u), &n) / nn;
        if s >= zero && s <= one && t >= zero && t <= one {
            found.push(squared(&along(&a[0], &u, &s), &along(&b[0], &v, &t)));
        }
    }
    found.into_iter().min().unwrap()
}

#[test]
fn segments_and_capsules_agree_with_exact_numbers_and_parry() {
    let (mut rng, mut decided) = (SplitMix64(4), 0);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        let exact: [[Near; 3]; 4] = rng.grid(4, case % 4 == 0);
        let [a, b, c, d]: [[f64; 3]; 4] =
            if grid { floats(&exact) } else { std::array::from_fn(|_| rng.point(4.0)) };
        let contact = segment_segment(&Segment::new([a, b]).unwrap(), &Segment::new([c, d]).unwrap());
        check_direction(&contact, &[a, b], &[c, d], 1e-12);
        if grid {
            assert_eq!(
                contact.touches(),
                exact_touch_3d(&exact[..2], &exact[2..]),
                "{a:?} {b:?} {c:?} {d:?}"
            );
        }
        let gap = if contact.touches() { 0.0 } else { contact.measure.value() };
        let (one, two) =
            (shape::Segment::new(vector(a), vector(b)), shape::Segment::new(vector(c), vector(d)));
        let there = query::details::closest_points_segment_segment(&Pose::IDENTITY, &one, &two, f64::MAX);
        let query::ClosestPoints::WithinMargin(p, q) = there else { panic!("{there:?}") };
        let distance = (p - q).length();
        if !close(gap, distance, 1e-13) {
            // Nearly parallel segments: exact numbers show that parry is wrong and this library is right.
            decided += 1;
            let ours = BigRational::from_float(gap * gap).unwrap();
            let exact = exact_distance_squared(&[a, b], &[c, d]);
            let error = num_rational::Ratio::from_float(1e-13).unwrap();
            assert!(ours.clone() - exact.clone() < error && exact - ours < error, "{a:?} {b:?} {c:?} {d:?}");
        }
        let (r, s) = if grid { (rng.below(3) as f64, 1.0) } else { (rng.unit(), rng.unit()) };
        let capsule = capsule_capsule(&Capsule::new([a, b], r).unwrap(), &Capsule::new([c, d], s).unwrap());
        assert!(close(signed(&capsule), gap - (r + s), 1e-15 * 16.0));
        assert_eq!(capsule.touches(), gap * gap <= (r + s) * (r + s));
        assert_eq!(capsule.normal, contact.normal);
        // The point is equally deep in both.
        let deep = |p: &shape::Segment, r: f64| p.distance_to_local_point(vector(capsule.point), false) - r;
        if !contact.touches() && signed(&capsule) > 1e-6 {
            assert!(close(deep(&one, r), deep(&two, s), 1e-9), "{a:?} {b:?} {c:?} {d:?}");
        }
    }
    println!("segments: exact numbers decided {decided} of {} pairs", 2 * number_of_pairs());
}

// ---------------------------------------------------------------- plane figures

fn geo_polygon(points: &[[f64; 2]]) -> geo::Polygon {
    geo::Polygon::new(points.iter().map(|p| (p[0], p[1])).collect(), vec![])
}

fn check_plane(contact: &Contact<2>, overlap: &[[f64; 2]], a: &[[f64; 2]], b: &[[f64; 2]]) {
    check_direction(contact, a, b, 1e-12);
    if let Measure::Area(area) = contact.measure {
        assert!(close(area, area_in_common(a, b), 1e-12), "{a:?} {b:?}: {area}");
        // The area and the point belong to the overlap.
        let polygon = geo_polygon(overlap);
        assert!(close(area, polygon.unsigned_area(), 1e-13), "{a:?} {b:?}");
        for axis in 0..2 {
            let low = overlap.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            let high = overlap.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
            assert!(contact.point[axis] >= low - 1e-13 && contact.point[axis] <= high + 1e-13, "{a:?} {b:?}");
        }
    } else {
        assert!(overlap.is_empty());
    }
}

#[test]
fn triangles_in_the_plane_agree_with_exact_numbers_and_geo() {
    let (mut rng, mut overlap, mut geo_differs) = (SplitMix64(5), Vec::new(), 0);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        let (one, two): ([[Near; 2]; 3], [[Near; 2]; 3]) =
            (rng.grid(4, case % 4 == 0), rng.grid(4, case % 4 == 0));
        let (p, q): ([[f64; 2]; 3], [[f64; 2]; 3]) = if grid {
            (floats(&one), floats(&two))
        } else {
            (std::array::from_fn(|_| rng.point(4.0)), std::array::from_fn(|_| rng.point(4.0)))
        };
        let (a, b) = (Triangle::new(p).unwrap(), Triangle::new(q).unwrap());
        let contact = triangle_triangle_2d(&a, &b, &mut overlap);
        assert_eq!(contact.touches(), a.touches(&b));
        check_plane(&contact, &overlap, &p, &q);
        if grid {
            assert_eq!(contact.touches(), exact_touch_2d(&one, &two), "{p:?} {q:?}");
        }
        let (there, other) = (geo_polygon(&p), geo_polygon(&q));
        if there.intersects(&other) != contact.touches() {
            // Exact numbers decide.
            geo_differs += 1;
            assert_eq!(contact.touches(), exact_touch_2d(&rational(&p), &rational(&q)), "{p:?} {q:?}");
        }
        if case % 8 < 2 && there.unsigned_area() > 1e-6 && other.unsigned_area() > 1e-6 {
            let area = if contact.touches() { contact.measure.value() } else { 0.0 };
            assert!(close(area, there.intersection(&other).unsigned_area(), 1e-6), "{p:?} {q:?}: {area}");
        }
    }
    println!("triangles in 2D: geo was wrong about {geo_differs} of {} pairs", 2 * number_of_pairs());
}

#[test]
fn convex_polygons_agree_with_exact_numbers_and_geo() {
    let (mut rng, mut overlap, mut geo_differs) = (SplitMix64(6), Vec::new(), 0);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        // The hull of seven points, some of which coincide or lie on its sides.
        let mut polygon = |shift: f64| -> Vec<[f64; 2]> {
            let points: [[f64; 2]; 7] =
                if grid { floats(&rng.grid(3, false)) } else { std::array::from_fn(|_| rng.point(3.0)) };
            let points: geo::MultiPoint =
                points.iter().map(|p| (p[0] + shift, p[1])).collect::<Vec<_>>().into();
            points.convex_hull().exterior().points().map(|p| [p.x(), p.y()]).collect()
        };
        let (p, q) = (polygon(0.0), polygon(if grid { 2.0 } else { 2.5 }));
        let (a, b) = (ConvexPolygon::new(&p).unwrap(), ConvexPolygon::new(&q).unwrap());
        let contact = polygon_polygon(&a, &b, &mut overlap);
        assert_eq!(contact.touches(), a.touches(&b));
        check_plane(&contact, &overlap, &p, &q);
        let near = |points: &[[f64; 2]]| -> Vec<[Near; 2]> {
            points.iter().map(|p| p.map(|x| Near([x as i64, 0, 0, 0, 0]))).collect()
        };
        if grid {
            assert_eq!(contact.touches(), exact_touch_2d(&near(&p), &near(&q)), "{p:?} {q:?}");
        }
        if geo_polygon(&p).intersects(&geo_polygon(&q)) != contact.touches() {
            geo_differs += 1;
            assert_eq!(contact.touches(), exact_touch_2d(&rational(&p), &rational(&q)), "{p:?} {q:?}");
        }
    }
    println!("convex polygons: geo was wrong about {geo_differs} of {} pairs", 2 * number_of_pairs());
}

// ---------------------------------------------------------------- triangles and tetrahedra in 3D

#[test]
fn triangles_in_space_agree_with_exact_numbers_and_parry() {
    let (mut rng, mut decided) = (SplitMix64(7), 0);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        let (one, two): ([[Near; 3]; 3], [[Near; 3]; 3]) =
            (rng.grid(3, case % 4 == 0), rng.grid(3, case % 4 == 0));
        let (p, q): ([[f64; 3]; 3], [[f64; 3]; 3]) = if grid {
            (floats(&one), floats(&two))
        } else {
            (std::array::from_fn(|_| rng.point(4.0)), std::array::from_fn(|_| rng.point(4.0)))
        };
        let (a, b) = (Triangle::new(p).unwrap(), Triangle::new(q).unwrap());
        let contact = triangle_triangle(&a, &b);
        assert_eq!(contact.touches(), a.touches(&b));
        assert_eq!(contact.touches(), b.touches(&a));
        check_direction(&contact, &p, &q, 1e-11);
        if grid {
            assert_eq!(contact.touches(), exact_touch_3d(&one, &two), "{p:?} {q:?}");
            continue;
        }
        let shape = |t: [[f64; 3]; 3]| shape::Triangle::new(vector(t[0]), vector(t[1]), vector(t[2]));
        let there = query::intersection_test(&Pose::IDENTITY, &shape(p), &Pose::IDENTITY, &shape(q)).unwrap();
        if there.intersecting != contact.touches() || case < 2000 {
            decided += 1;
            assert_eq!(contact.touches(), exact_touch_3d(&rational(&p), &rational(&q)), "{p:?} {q:?}");
        }
        if contact.touches() {
            // The point is on both triangles.
            for t in [p, q] {
                assert!(shape(t).distance_to_local_point(vector(contact.point), false) < 1e-9, "{p:?} {q:?}");
            }
        }
    }
    println!("triangles in 3D: exact numbers decided {decided} of {} random pairs", number_of_pairs());
}

#[test]
fn tetrahedra_on_a_grid_agree_with_exact_numbers_and_slices() {
    compare_tetrahedra(true, 8);
}

#[test]
fn any_tetrahedra_agree_with_exact_numbers_and_slices() {
    compare_tetrahedra(false, 18);
}

/// Compares pairs of tetrahedra, with corners on a grid or anywhere.
fn compare_tetrahedra(grid: bool, seed: u64) {
    let mut rng = SplitMix64(seed);
    let mut touching = 0;
    for case in 0..number_of_pairs() {
        let (one, two): ([[Near; 3]; 4], [[Near; 3]; 4]) =
            (rng.grid(3, case % 2 == 0), rng.grid(3, case % 2 == 0));
        let (p, q): ([[f64; 3]; 4], [[f64; 3]; 4]) = if grid {
            (floats(&one), floats(&two))
        } else {
            (std::array::from_fn(|_| rng.point(4.0)), std::array::from_fn(|_| rng.point(4.0)))
        };
        let (a, b) = (Tetrahedron::new(p).unwrap(), Tetrahedron::new(q).unwrap());
        let contact = tetrahedron_tetrahedron(&a, &b);
        assert_eq!(contact.touches(), a.touches(&b));
        check_direction(&contact, &p, &q, 1e-11);
        if grid {
            assert_eq!(contact.touches(), exact_touch_3d(&one, &two), "{p:?} {q:?}");
        } else if case < 500 {
            assert_eq!(contact.touches(), exact_touch_3d(&rational(&p), &rational(&q)), "{p:?} {q:?}");
        }
        if let Measure::Volume(volume) = contact.measure {
            touching += 1;
            assert!(close(volume, volume_in_common(&p, &q), 1e-10), "{p:?} {q:?}: {volume}");
            for vertices in [&p, &q] {
                for axis in 0..3 {
                    let low = vertices.iter().map(|x| x[axis]).fold(f64::INFINITY, f64::min);
                    let high = vertices.iter().map(|x| x[axis]).fold(f64::NEG_INFINITY, f64::max);
                    let x = contact.point[axis];
                    assert!(x >= low - 1e-9 && x <= high + 1e-9, "{p:?} {q:?}: {contact:?}");
                }
            }
        }
    }
    assert!(
        2 * touching >= number_of_pairs(),
        "{touching} of {} pairs have a volume to compare",
        number_of_pairs()
    );
}

#[test]
fn parts_of_a_tetrahedron_add_up_to_it() {
    let mut rng = SplitMix64(9);
    for _ in 0..2000 {
        let p: [[f64; 3]; 4] = std::array::from_fn(|_| rng.point(2.0));
        let q: [[f64; 3]; 4] = std::array::from_fn(|_| rng.point(2.0));
        let x: [f64; 3] = rng.point(2.0);
        // The four cones from a point inside of q divide its volume.
        let weights: [f64; 4] = std::array::from_fn(|_| 0.1 + x[0] * rng.unit());
        let total: f64 = weights.iter().sum();
        let inside = std::array::from_fn(|k| (0..4).map(|v| q[v][k] * weights[v]).sum::<f64>() / total);
        let a = Tetrahedron::new(p).unwrap();
        let volume = |q: [[f64; 3]; 4]| {
            let contact = tetrahedron_tetrahedron(&a, &Tetrahedron::new(q).unwrap());
            if contact.touches() { contact.measure.value() } else { 0.0 }
        };
        let parts: f64 = (0..4)
            .map(|k| {
                let mut part = q;
                part[k] = inside;
                volume(part)
            })
            .sum();
        assert!(close(parts, volume(q), 1e-13), "{p:?} {q:?}: {parts}");
    }
}

// ---------------------------------------------------------------- boxes

#[test]
fn boxes_agree_with_parry() {
    let mut rng = SplitMix64(10);
    let (mut touching, mut parry_differs) = (0, 0);
    for case in 0..2 * number_of_pairs() {
        let grid = case % 2 == 0;
        let mut oriented = || {
            let quarter = std::f64::consts::FRAC_PI_2;
            let turn = if grid {
                let mut turn = [0.0; 3];
                turn[rng.below(3) as usize] = quarter * 0.5 * rng.below(5) as f64;
                turn
            } else {
                rng.point(3.0)
            };
            let (centre, half): ([f64; 3], [f64; 3]) = if grid {
                let [centre, half] = floats(&rng.grid::<3, 2>(3, false));
                (centre, half.map(|x| 0.5 * (x + 1.0)))
            } else {
                (rng.point(5.0), rng.point(2.0))
            };
            let pose = Pose::new(vector(centre), vector(turn));
            let axes = [Vector::X, Vector::Y, Vector::Z].map(|axis| array(pose.rotation * axis));
            let corners: Vec<[f64; 3]> = (0..8_u32)
                .map(|k| {
                    let parts: [f64; 3] =
                        std::array::from_fn(|bit| if k >> bit & 1 == 1 { half[bit] } else { -half[bit] });
                    array(pose * vector(parts))
                })
                .collect();
            (OrientedBox::new(centre, axes, half).unwrap(), pose, shape::Cuboid::new(vector(half)), corners)
        };
        let ((a, pose_a, cuboid_a, corners_a), (b, pose_b, cuboid_b, corners_b)) = (oriented(), oriented());
        let contact = box_box(&a, &b);
        check_direction(&contact, &corners_a, &corners_b, 1e-11);
        let apart = query::distance(&pose_a, &cuboid_a, &pose_b, &cuboid_b).unwrap().distance;
        let n = contact.normal;
        let outside = |p: [f64; 3]| {
            let p = vector(p);
            [cuboid_a.distance_to_point(&pose_a, p, true), cuboid_b.distance_to_point(&pose_b, p, true)]
        };
        if let Measure::Gap(gap) = contact.measure {
            // The ends of the gap are on the boxes, and `check_direction` has shown that nothing is closer;
            // so where parry differs, it is wrong.
            let [from, to] = [-0.5, 0.5].map(|t| std::array::from_fn(|k| contact.point[k] + t * gap * n[k]));
            assert!(outside(from)[0] < 1e-9 && outside(to)[1] < 1e-9, "{a:?} {b:?}: {contact:?}");
            assert!(gap < apart + 1e-6, "{a:?} {b:?}: {gap} {apart}");
        }
        parry_differs += usize::from(!close(signed(&contact).max(0.0), apart, 1e-6));
        if let Measure::Depth(depth) = contact.measure {
            touching += 1;
            // The depth equals the overlap of the corners along the normal.
            let high = corners_a.iter().map(|&p| dot(n, p)).fold(f64::NEG_INFINITY, f64::max);
            let low = corners_b.iter().map(|&p| dot(n, p)).fold(f64::INFINITY, f64::min);
            assert!(close(depth, high - low, 1e-12), "{a:?} {b:?}: {contact:?}");
            // No face and no two edges separate them with a shorter move.
            let sides: Vec<_> = [&corners_a, &corners_b]
                .into_iter()
                .flat_map(|c| {
                    [1, 2, 4].map(|k| -> [f64; 3] { std::array::from_fn(|axis| c[k][axis] - c[0][axis]) })
                })
                .collect();
            let crossed = sides[..3].iter().flat_map(|&u| sides[3..].iter().map(move |&v| cross(u, v)));
            for axis in sides.iter().copied().chain(crossed) {
                let length = dot(axis, axis).sqrt();
                if length > 1e-3 {
                    let range = |corners: &[[f64; 3]]| {
                        let heights = corners.iter().map(|&p| dot(axis, p) / length);
                        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
                    };
                    let ((low_a, high_a), (low_b, high_b)) = (range(&corners_a), range(&corners_b));
                    assert!(depth < (high_a - low_b).min(high_b - low_a) + 1e-10, "{a:?} {b:?}: {contact:?}");
                }
            }
            // A point on a face is inside both boxes, unless one box is pushed through.
            let edge = |axis: &[f64; 3]| dot(*axis, *axis).sqrt();
            let shortest = sides.iter().map(edge).fold(f64::INFINITY, f64::min);
            let on_face = sides.iter().any(|side| dot(n, *side).abs() > (1.0 - 1e-9) * edge(side));
            if on_face && depth < shortest {
                assert!(outside(contact.point).iter().all(|&out| out < 1e-9), "{a:?} {b:?}: {contact:?}");
            }
        }
    }
    println!(
        "boxes: {touching} of {} pairs touch; parry has {parry_differs} distances wrong",
        2 * number_of_pairs()
    );
}
