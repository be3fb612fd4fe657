//! Overlaps at the beginning of a run, for messages.

use fdem_contact::{Detector, Elements, Search};

use crate::clump::Clump;
use crate::pack::closed::ClosedSurface;
use crate::vector::{Vector, dot, length, minus, plus, times};
use crate::wall::WallShape;

/// The pair of spheres that overlap the most: their numbers, and the depth over the smaller radius; `None`
/// without overlaps. Spheres of one of these clumps may overlap.
///
/// # Errors
/// The reason why the search failed.
pub fn worst_overlap(
    positions: &[[f64; 3]],
    radii: &[f64],
    clumps: &[Clump],
    threads: usize,
) -> Result<Option<([u32; 2], f64)>, String> {
    let elements = Elements::spheres_with_radii(positions, radii).map_err(|error| error.to_string())?;
    let mut detector = Detector::new().with_threads(threads).map_err(|error| error.to_string())?;
    let mut clump_of: Vec<Option<usize>> = vec![None; radii.len()];
    for (number, clump) in clumps.iter().enumerate() {
        for &sphere in &clump.spheres {
            clump_of[sphere as usize] = Some(number);
        }
    }
    let mut couples = Vec::new();
    detector.couples(&elements, &mut couples).map_err(|error| error.to_string())?;
    let mut worst: Option<([u32; 2], f64)> = None;
    for couple in couples {
        let pair = [couple.i.min(couple.j), couple.i.max(couple.j)];
        let [a, b] = pair.map(|of| of as usize);
        if clump_of[a].is_some() && clump_of[a] == clump_of[b] {
            continue;
        }
        let depth = radii[a] + radii[b] - length(minus(positions[b], positions[a]));
        let share = depth / radii[a].min(radii[b]);
        // Equal overlaps are those of the first pair, whatever the order of the search is.
        let is_worse = worst.is_none_or(|(known, most)| share > most || (share >= most && pair < known));
        if share > 0.0 && is_worse {
            worst = Some((pair, share));
        }
    }
    Ok(worst)
}

/// The sphere that lies deepest in a wall, and the depth over its radius; `None` if none touches it. A sphere
/// behind a plane or outside of a tube lies in it with more than its radius.
pub fn worst_on_wall(shape: &WallShape, positions: &[[f64; 3]], radii: &[f64]) -> Option<(u32, f64)> {
    let WallShape::Mesh { triangles } = shape else {
        return worst(positions, radii, |point, _| distance(shape, point));
    };
    let surface = prepared(triangles.clone(), radii);
    worst(positions, radii, |point, _| from_triangles(&surface, point))
}

/// The sphere that lies deepest in a body, and the depth over its radius; `None` if none touches it. A sphere
/// whose centre is inside lies in it with more than its radius. `triangles`: the closed surface of the body.
pub fn worst_in_body(
    triangles: Vec<[[f64; 3]; 3]>,
    positions: &[[f64; 3]],
    radii: &[f64],
) -> Option<(u32, f64)> {
    let surface = prepared(triangles, radii);
    worst(positions, radii, |point, radius| {
        let away = from_triangles(&surface, point);
        if surface.contains(point) { -away.min(radius) } else { away }
    })
}

/// Numbers of the spheres that reach into a box, ascending.
pub fn spheres_in_box([low, high]: [[f64; 3]; 2], positions: &[[f64; 3]], radii: &[f64]) -> Vec<u32> {
    let reaches = |at: &[f64; 3], radius: f64| {
        (0..3).all(|axis| at[axis] + radius > low[axis] && at[axis] - radius < high[axis])
    };
    let spheres = (0..).zip(positions).zip(radii);
    spheres.filter(|((_, at), radius)| reaches(at, **radius)).map(|((number, _), _)| number).collect()
}

/// A surface that knows its triangles near spheres.
fn prepared(triangles: Vec<[Vector; 3]>, radii: &[f64]) -> ClosedSurface {
    let mut surface = ClosedSurface::new(triangles);
    surface.prepare(radii.iter().copied().fold(0.0, f64::max));
    surface
}

/// Distance from triangles, m; infinite if none is near.
fn from_triangles(surface: &ClosedSurface, point: Vector) -> f64 {
    let mut least = f64::INFINITY;
    surface.near(point, &mut |nearest| least = least.min(length(minus(point, nearest))));
    least
}

/// The sphere that is deepest in something, by the distance of a point from it and a radius.
fn worst(positions: &[Vector], radii: &[f64], distance: impl Fn(Vector, f64) -> f64) -> Option<(u32, f64)> {
    let mut worst: Option<(u32, f64)> = None;
    for ((number, &point), &radius) in (0..).zip(positions).zip(radii) {
        let share = (radius - distance(point, radius)) / radius;
        if share > 0.0 && worst.is_none_or(|(_, most)| share > most) {
            worst = Some((number, share));
        }
    }
    worst
}

/// Distance of a point from a wall that is no mesh, m; negative behind a plane and outside of a tube.
fn distance(shape: &WallShape, point: Vector) -> f64 {
    match shape {
        WallShape::Plane { point: on, normal } => dot(minus(point, *on), *normal) / length(*normal),
        WallShape::Tube { axis, radius } => radius - from_axis(point, *axis)[1],
        WallShape::Cone { axis, radii } => {
            let [along, out] = from_axis(point, *axis);
            let long = length(minus(axis[1], axis[0]));
            from_segment([along, out, 0.0], [[0.0, radii[0], 0.0], [long, radii[1], 0.0]])
        }
        WallShape::Disc { centre, normal, radius } => {
            let arm = minus(point, *centre);
            let away = dot(arm, *normal) / length(*normal);
            let out = (dot(arm, arm) - away * away).max(0.0).sqrt();
            let beyond = (out - radius).max(0.0);
            (away * away + beyond * beyond).sqrt()
        }
        WallShape::Mesh { .. } => f64::INFINITY,
    }
}

/// Distance of a point from a segment.
fn from_segment(point: Vector, [a, b]: [Vector; 2]) -> f64 {
    let along = minus(b, a);
    let share = (dot(minus(point, a), along) / dot(along, along)).clamp(0.0, 1.0);
    length(minus(point, plus(a, times(share, along))))
}

/// Distances of a point along an axis and from it, m.
fn from_axis(point: Vector, [from, to]: [Vector; 2]) -> [f64; 2] {
    let along = minus(to, from);
    let unit = times(1.0 / length(along), along);
    let arm = minus(point, from);
    let far = dot(arm, unit);
    [far, length(minus(arm, times(far, unit)))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_sphere_in_walls_of_all_shapes() {
        let axis = [[0.0; 3], [0.0, 0.0, 2.0]];
        let triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let segment = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        for (shape, point, distance) in [
            (WallShape::Plane { point: [0.0; 3], normal: [0.0, 0.0, 2.0] }, [5.0, 1.0, -0.5], -0.5),
            (WallShape::Tube { axis, radius: 1.0 }, [0.0, 0.75, 9.0], 0.25),
            (WallShape::Tube { axis, radius: 1.0 }, [0.0, 1.5, 9.0], -0.5),
            (WallShape::Cone { axis, radii: [1.0, 1.0] }, [0.75, 0.0, 1.0], 0.25),
            (WallShape::Cone { axis, radii: [1.0, 1.0] }, [1.0, 0.0, 3.0], 1.0),
            (
                WallShape::Disc { centre: [0.0; 3], normal: [0.0, 0.0, 3.0], radius: 1.0 },
                [4.0, 0.0, 4.0],
                5.0,
            ),
            (WallShape::Mesh { triangles: vec![triangle] }, [0.25, 0.25, -0.5], 0.5),
            (WallShape::Mesh { triangles: vec![segment] }, [4.0, 4.0, 0.0], 5.0),
        ] {
            let (number, share) = worst_on_wall(&shape, &[[0.0, 0.0, 50.0], point], &[0.0, 6.0]).unwrap();
            assert_eq!(number, 1);
            assert!((share - (6.0 - distance) / 6.0).abs() < 1e-15, "{shape:?} {point:?}");
        }
    }

    #[test]
    fn a_sphere_inside_a_body_is_deeper_than_one_at_its_surface() {
        let [a, b, c, d] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let body = vec![[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
        let of = |point| worst_in_body(body.clone(), &[point], &[0.02]);
        assert_eq!(of([0.1, 0.1, -0.03]), None);
        assert!(of([0.1, 0.1, -0.01]).is_some_and(|(_, share)| (share - 0.5).abs() < 1e-12));
        assert_eq!(of([0.1, 0.1, 0.1]), Some((0, 2.0)));
    }
}
