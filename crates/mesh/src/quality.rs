//! Quality of a mesh.

use serde::Serialize;

use crate::{Corners, Mesh};

/// Sizes and shapes of the elements of a mesh.
#[derive(Debug, Clone, Serialize)]
pub struct Quality {
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Shortest, mean and longest edge of elements, m.
    pub edges: [f64; 3],
    /// Smallest angle of each element: least and mean, degrees. An equilateral triangle has 60. Angles of
    /// tetrahedra are those between their faces; those of an even one are 70.5.
    pub smallest_angle: [f64; 2],
    /// Share of elements whose smallest angle is below 25 degrees.
    pub below_25: f64,
    /// The element with the smallest angle.
    pub worst: u32,
    /// Centre of that element, m.
    pub worst_at: Vec<f64>,
    /// Share of triangles whose angles are, within half a degree, 45, 45, 90 or 60, 60, 60 degrees: those of
    /// regular meshes.
    pub regular: f64,
    /// Smallest height of an element, m.
    pub smallest_height: f64,
}

impl Quality {
    /// Measures a mesh. Without elements all numbers are 0.
    pub fn of<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> Self
    where
        [[f64; D]; N]: Corners<D, N>,
    {
        let mut quality = Self {
            elements: mesh.elements.len(),
            nodes: mesh.nodes.len(),
            edges: [f64::INFINITY, 0.0, 0.0],
            smallest_angle: [f64::INFINITY, 0.0],
            below_25: 0.0,
            worst: 0,
            worst_at: Vec::new(),
            regular: 0.0,
            smallest_height: f64::INFINITY,
        };
        for (number, element) in (0..).zip(&mesh.elements) {
            let corners = element.map(|node| mesh.nodes[node as usize]);
            let edges = edges(&corners);
            for edge in &edges {
                quality.edges[0] = quality.edges[0].min(*edge);
                quality.edges[1] += edge / edges.len() as f64;
                quality.edges[2] = quality.edges[2].max(*edge);
            }
            quality.smallest_height = quality.smallest_height.min(corners.least_height());
            let mut angles = corners.angles();
            angles.sort_by(f64::total_cmp);
            if angles[0] < quality.smallest_angle[0] {
                quality.smallest_angle[0] = angles[0];
                quality.worst = number;
                let centre = |axis: usize| corners.iter().map(|corner| corner[axis]).sum::<f64>() / N as f64;
                quality.worst_at = (0..D).map(centre).collect();
            }
            quality.smallest_angle[1] += angles[0];
            quality.below_25 += f64::from(u8::from(angles[0] < 25.0));
            let alike = |regular: [f64; 3]| {
                angles.len() == 3 && angles.iter().zip(regular).all(|(angle, of)| (angle - of).abs() < 0.5)
            };
            quality.regular += f64::from(u8::from(alike([45.0, 45.0, 90.0]) || alike([60.0; 3])));
        }
        if mesh.elements.is_empty() {
            (quality.edges[0], quality.smallest_angle[0], quality.smallest_height) = (0.0, 0.0, 0.0);
        }
        let count = quality.elements.max(1) as f64;
        for sum in [
            &mut quality.edges[1],
            &mut quality.smallest_angle[1],
            &mut quality.below_25,
            &mut quality.regular,
        ] {
            *sum /= count;
        }
        quality
    }
}

/// Lengths of all edges of an element.
pub fn edges<const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> Vec<f64> {
    let mut edges = Vec::with_capacity(N * (N - 1) / 2);
    for (k, a) in corners.iter().enumerate() {
        for b in &corners[k + 1..] {
            edges.push(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt());
        }
    }
    edges
}
