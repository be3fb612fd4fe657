//! How much too stiff tetrahedra of constant strain are in bending.
//!
//! A prism, free in space, carries the moment of tractions `σ = E κ y` on its two ends. Its exact stress is
//! that everywhere, for any Poisson's ratio, and the work of the tractions is `M² L/(E I)` (Timoshenko and
//! Goodier, 102). The stiffness of the mesh, which is that of the simulation at small strains, is too high by
//! the ratio of that work to the work of the same tractions on the mesh. The static equations are solved by
//! conjugate gradients.

use super::bodies::{Body, Point, cross, cuboid, dot, faces_where, jittered, length, minus, on_box, volume};
use crate::{Outcome, Size};
use fdem_model::locking::{CELLS, EXCESS_IN_SPACE, RATIOS_IN_SPACE};

/// Length of the prism over its width.
const SLENDERNESS: usize = 4;

pub(crate) fn run(size: Size) -> Result<Vec<Outcome>, String> {
    let columns = size.choose(2, 4);
    let mut outcomes = Vec::new();
    for (row, &nu) in RATIOS_IN_SPACE.iter().enumerate() {
        for (column, &cells) in CELLS[..columns].iter().enumerate() {
            let found = 0.5 * (excess(nu, cells, 1)? + excess(nu, cells, 2)?);
            let name = format!("stiffness in bending over the true one, ν = {nu}, {cells} cells");
            outcomes.push(Outcome::relative(name, 1.0 + EXCESS_IN_SPACE[row][column], 1.0 + found, 0.02, ""));
        }
    }
    Ok(outcomes)
}

/// Stiffness of a prism of `cells` cells through its width in bending over the true one, less 1.
fn excess(nu: f64, cells: usize, seed: u64) -> Result<f64, String> {
    let long = SLENDERNESS as f64;
    let (min, max) = ([-0.5, -0.5, 0.0], [0.5, 0.5, long]);
    let mesh = cuboid(min, max, [cells, cells, SLENDERNESS * cells]);
    let mesh = jittered(&mesh, 0.15 / cells as f64, seed, on_box(min, max));
    let mut force = vec![[0.0; 3]; mesh.nodes.len()];
    for (at, sign) in [(0.0, -1.0), (long, 1.0)] {
        for face in faces_where(&mesh, |p| (p[2] - at).abs() < 1e-9) {
            let corners = face.map(|node| mesh.nodes[node as usize]);
            let area = 0.5 * length(cross(minus(corners[1], corners[0]), minus(corners[2], corners[0])));
            let sum: f64 = corners.iter().map(|corner| corner[1]).sum();
            // ∫ y β over a triangle, with β linear.
            for (node, corner) in face.into_iter().zip(corners) {
                force[node as usize][2] += sign * area / 12.0 * (sum + corner[1]);
            }
        }
    }
    // E = 1 and κ = 1, so that M = I = 1/12.
    Ok(long / 12.0 / compliance(&mesh, nu, &force)? - 1.0)
}

/// Gradients of the shape functions of an element, and its volume.
fn gradients(corners: [Point; 4]) -> ([Point; 4], f64) {
    let [a, b, c, d] = corners;
    let (e, f, g) = (minus(b, a), minus(c, a), minus(d, a));
    let size = volume(corners);
    let [one, two, three] = [cross(f, g), cross(g, e), cross(e, f)].map(|v| v.map(|x| x / (6.0 * size)));
    ([std::array::from_fn(|axis| -one[axis] - two[axis] - three[axis]), one, two, three], size)
}

/// Work of the forces on the displacements that they cause, for a Young's modulus of 1.
fn compliance(mesh: &Body, nu: f64, force: &[Point]) -> Result<f64, String> {
    let shear = 0.5 / (1.0 + nu);
    let lambda = nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
    let elements: Vec<([u32; 4], [Point; 4], f64)> = mesh
        .elements
        .iter()
        .map(|nodes| {
            let (gradients, size) = gradients(nodes.map(|node| mesh.nodes[node as usize]));
            (*nodes, gradients, size)
        })
        .collect();
    let times = |x: &[Point]| {
        let mut sum = vec![[0.0; 3]; x.len()];
        for (nodes, gradients, size) in &elements {
            let mut h = [[0.0; 3]; 3];
            for (node, gradient) in nodes.iter().zip(gradients) {
                let u = x[*node as usize];
                for i in 0..3 {
                    for k in 0..3 {
                        h[i][k] += u[i] * gradient[k];
                    }
                }
            }
            let pressure = lambda * (h[0][0] + h[1][1] + h[2][2]);
            let stress: [Point; 3] = std::array::from_fn(|i| {
                std::array::from_fn(|k| shear * (h[i][k] + h[k][i]) + if i == k { pressure } else { 0.0 })
            });
            for (node, gradient) in nodes.iter().zip(gradients) {
                for i in 0..3 {
                    let row = stress[i];
                    sum[*node as usize][i] +=
                        size * (row[0] * gradient[0] + row[1] * gradient[1] + row[2] * gradient[2]);
                }
            }
        }
        sum
    };
    let mut diagonal = vec![[0.0; 3]; force.len()];
    for (nodes, gradients, size) in &elements {
        for (node, gradient) in nodes.iter().zip(gradients) {
            let squared: f64 = gradient.iter().map(|g| g * g).sum();
            for i in 0..3 {
                diagonal[*node as usize][i] +=
                    size * (shear * squared + (lambda + shear) * gradient[i] * gradient[i]);
            }
        }
    }
    let work = |a: &[Point], b: &[Point]| a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum::<f64>();
    let scaled = |r: &[Point]| -> Vec<Point> {
        r.iter().zip(&diagonal).map(|(r, d)| std::array::from_fn(|k| r[k] / d[k])).collect()
    };
    let mut found = vec![[0.0; 3]; force.len()];
    let mut rest = force.to_vec();
    let mut direction = scaled(&rest);
    let mut product = work(&rest, &direction);
    let enough = 1e-10 * product;
    let mut rounds = 0;
    while product > enough {
        rounds += 1;
        if rounds > 20_000 {
            return Err("the displacements of the prism were not found".to_owned());
        }
        let image = times(&direction);
        let step = product / work(&direction, &image);
        for node in 0..found.len() {
            for k in 0..3 {
                found[node][k] += step * direction[node][k];
                rest[node][k] -= step * image[node][k];
            }
        }
        let next = scaled(&rest);
        let now = work(&rest, &next);
        for (direction, next) in direction.iter_mut().zip(next) {
            *direction = std::array::from_fn(|k| next[k] + now / product * direction[k]);
        }
        product = now;
    }
    Ok(work(force, &found))
}
