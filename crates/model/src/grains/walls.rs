//! Walls of `[[wall]]`.

use std::f64::consts::PI;

use fdem_simulation::grains::{Servo, Wall, WallRotation, WallShape};

use crate::bodies::{materials, mesh_file};
use crate::grains::spheres::in_space;
use crate::shapes::holes;
use crate::text::fault::Problem;
use crate::text::file::{self, ModelFile, Side, WallBox};
use crate::text::included::Load;

/// Distance of the corners of a polygon from its plane over its size from which it is not flat.
const FLAT: f64 = 1e-9;

type Point = [f64; 3];

/// A wall. The table has been checked.
pub(crate) fn wall(
    file: &ModelFile,
    table: &file::Wall,
    discs: bool,
    load: &mut Load<'_>,
) -> Result<Wall, Problem> {
    let shape = shape(table, discs, load).map_err(|problem| Problem {
        message: format!("[[wall]] \"{}\": {}", table.name, problem.message),
        ..problem
    })?;
    let rotation =
        table.rotation.as_ref().map(|of| WallRotation { through: in_space(&of.through), spin: of.spin() });
    let by = table.displacement.as_ref().map_or([0.0; 3], in_space);
    let path = table.table.iter().flatten().map(|&[time, factor]| (time, by.map(|x| factor * x))).collect();
    let servo = table.servo.as_ref().map(|of| {
        let direction = in_space(&of.direction);
        let pressure = of.pressure.unwrap_or(0.0);
        let thickness = if discs { file.model.thickness } else { 1.0 };
        let force = of.force.unwrap_or_else(|| pressure * thickness * area(&shape, direction, discs));
        Servo { direction, force, speed: of.speed }
    });
    Ok(Wall {
        name: table.name.clone(),
        shape,
        material: materials::number(file, &table.material).unwrap_or(0),
        velocity: table.velocity.as_ref().map_or([0.0; 3], in_space),
        rotation,
        path,
        servo,
        from: 0.0,
    })
}

fn shape(table: &file::Wall, discs: bool, load: &mut Load<'_>) -> Result<WallShape, Problem> {
    if let Some(of) = &table.plane {
        return Ok(WallShape::Plane { point: in_space(&of.point), normal: in_space(&of.normal) });
    }
    if let Some(of) = &table.tube {
        return Ok(WallShape::Tube { axis: [of.from, of.to], radius: of.radius });
    }
    if let Some(of) = &table.circle {
        let [x, y] = of.centre;
        return Ok(WallShape::Tube { axis: [[x, y, 0.0], [x, y, 1.0]], radius: of.radius });
    }
    if let Some(of) = &table.cone {
        return Ok(WallShape::Cone { axis: [of.from, of.to], radii: of.radii });
    }
    if let Some(of) = &table.disc {
        return Ok(WallShape::Disc { centre: of.centre, normal: of.normal, radius: of.radius });
    }
    let triangles = if let Some(of) = &table.block {
        block(of, discs)
    } else if let Some(corners) = &table.corners {
        let corners: Vec<Point> = corners.iter().map(in_space).collect();
        if discs {
            corners.windows(2).map(|pair| [pair[0], pair[1], pair[1]]).collect()
        } else {
            polygon(&corners)?
        }
    } else {
        mesh(table, load)?
    };
    let triangles: Vec<[Point; 3]> = triangles.into_iter().filter(|of| has_extent(of, discs)).collect();
    if triangles.is_empty() {
        let (key, _) = table.shapes().first().copied().unwrap_or(("name", 0));
        return Err(Problem::new(key, "it has no extent"));
    }
    Ok(WallShape::Mesh { triangles })
}

/// Whether a triangle has an area, or a segment a length.
fn has_extent(&[a, b, c]: &[Point; 3], discs: bool) -> bool {
    if discs { a != b } else { cross(minus(b, a), minus(c, a)) != [0.0; 3] }
}

/// The sides of a box that are not open.
fn block(of: &WallBox, discs: bool) -> Vec<[Point; 3]> {
    let [low, high] = [in_space(&of.min), in_space(&of.max)];
    let last = if discs { 1 } else { 2 };
    let sides = [
        (0, false, Side::Left),
        (0, true, Side::Right),
        (last, false, Side::Bottom),
        (last, true, Side::Top),
        (1, false, Side::Front),
        (1, true, Side::Back),
    ];
    let count = if discs { 4 } else { 6 };
    let mut triangles = Vec::new();
    for &(axis, is_high, _) in sides[..count].iter().filter(|(.., side)| !of.open.contains(side)) {
        let fixed = if is_high { high[axis] } else { low[axis] };
        let at = |u: f64, v: f64| {
            let mut point = [0.0; 3];
            point[axis] = fixed;
            let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
            (point[one], point[other]) = (u, v);
            point
        };
        if discs {
            let along = 1 - axis;
            let ends = [low[along], high[along]].map(|x| {
                let mut point = [0.0; 3];
                (point[axis], point[along]) = (fixed, x);
                point
            });
            triangles.push([ends[0], ends[1], ends[1]]);
            continue;
        }
        let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
        let [a, b, c, d] = [
            at(low[one], low[other]),
            at(high[one], low[other]),
            at(high[one], high[other]),
            at(low[one], high[other]),
        ];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    triangles
}

/// The triangles of a flat convex polygon.
fn polygon(corners: &[Point]) -> Result<Vec<[Point; 3]>, Problem> {
    let first = corners[0];
    let normal = corners[1..].windows(2).fold([0.0; 3], |sum, pair| {
        let area = cross(minus(pair[0], first), minus(pair[1], first));
        [0, 1, 2].map(|axis| sum[axis] + area[axis])
    });
    let size = corners.iter().map(|&corner| length(minus(corner, first))).fold(0.0, f64::max);
    let off = corners.iter().map(|&corner| dot(normal, minus(corner, first)).abs()).fold(0.0, f64::max);
    if off > FLAT * size * length(normal) {
        let help = "write two walls of three corners, or a mesh".to_owned();
        return Err(Problem {
            help: Some(help),
            ..Problem::new("corners", "its corners are not in one plane")
        });
    }
    let count = corners.len();
    let turns = (0..count).map(|k| {
        let [a, b, c] = [corners[k], corners[(k + 1) % count], corners[(k + 2) % count]];
        dot(normal, cross(minus(b, a), minus(c, b)))
    });
    if turns.into_iter().any(|turn| turn < -FLAT * size * size * length(normal)) {
        let help = "write several walls with convex polygons, or a mesh".to_owned();
        return Err(Problem { help: Some(help), ..Problem::new("corners", "its polygon is not convex") });
    }
    Ok(corners[1..].windows(2).map(|pair| [first, pair[0], pair[1]]).collect())
}

/// The triangles of a file.
fn mesh(table: &file::Wall, load: &mut Load<'_>) -> Result<Vec<[Point; 3]>, Problem> {
    let name = table.mesh.as_deref().unwrap_or_default();
    let triangles = mesh_file::triangles(load, name, table.scale.unwrap_or(1.0))
        .map_err(|problem| Problem { key: "mesh".to_owned(), ..problem })?;
    let by = table.translate.as_ref().map_or([0.0; 3], in_space);
    let moved = |corner: Point| [0, 1, 2].map(|axis| corner[axis] + by[axis]);
    Ok(triangles.into_iter().map(|triangle| triangle.map(moved)).collect())
}

/// Area of a wall as seen along a direction, m²; with discs its length, m.
fn area(shape: &WallShape, direction: Point, discs: bool) -> f64 {
    let long = length(direction);
    let unit = direction.map(|x| x / long);
    match shape {
        WallShape::Disc { normal, radius, .. } => {
            PI * radius * radius * dot(*normal, unit).abs() / length(*normal)
        }
        WallShape::Mesh { triangles } => {
            let of = |&[a, b, c]: &[Point; 3]| {
                if discs {
                    return length(cross(minus(b, a), unit));
                }
                0.5 * dot(cross(minus(b, a), minus(c, a)), unit).abs()
            };
            let sum: f64 = triangles.iter().map(of).sum();
            // A closed surface is seen from two sides.
            if !discs && holes::words(triangles).is_none() { 0.5 * sum } else { sum }
        }
        WallShape::Plane { .. } | WallShape::Tube { .. } | WallShape::Cone { .. } => 0.0,
    }
}

fn minus(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: Point) -> f64 {
    dot(a, a).sqrt()
}
