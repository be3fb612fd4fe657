//! Quality of a mesh.

use fdem_simulation::Mesh;
use serde::Serialize;

use crate::model::outline::{Point, distance, twice_area};

/// Sizes and shapes of the elements of a mesh.
#[derive(Debug, Clone, Serialize)]
pub struct Quality {
    /// Number of elements.
    pub elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Shortest, mean and longest edge of elements, m.
    pub edges: [f64; 3],
    /// Smallest angle of each element: least and mean, degrees. That of an equilateral triangle is 60.
    pub smallest_angle: [f64; 2],
    /// Share of elements whose smallest angle is below 25 degrees.
    pub below_25: f64,
    /// The element with the smallest angle.
    pub worst: u32,
    /// Its centre, m.
    pub worst_at: [f64; 2],
    /// Share of elements whose angles are, within half a degree, 45, 45, 90 or 60, 60, 60 degrees: those of regular meshes.
    pub regular: f64,
    /// Smallest height of an element, m.
    pub smallest_height: f64,
}

impl Quality {
    /// Measures a mesh with at least one element.
    pub fn of(mesh: &Mesh) -> Self {
        let mut quality = Self {
            elements: mesh.elements.len(),
            nodes: mesh.nodes.len(),
            edges: [f64::INFINITY, 0.0, 0.0],
            smallest_angle: [f64::INFINITY, 0.0],
            below_25: 0.0,
            worst: 0,
            worst_at: [0.0; 2],
            regular: 0.0,
            smallest_height: f64::INFINITY,
        };
        for (element, triangle) in (0..).zip(&mesh.elements) {
            let corners = triangle.map(|node| mesh.nodes[node as usize]);
            let edges = edges(corners);
            for edge in edges {
                quality.edges[0] = quality.edges[0].min(edge);
                quality.edges[1] += edge / 3.0;
                quality.edges[2] = quality.edges[2].max(edge);
            }
            let longest = edges.into_iter().fold(0.0, f64::max);
            let height = twice_area(corners[0], corners[1], corners[2]) / longest;
            quality.smallest_height = quality.smallest_height.min(height);
            let mut angles = angles(edges);
            angles.sort_by(f64::total_cmp);
            if angles[0] < quality.smallest_angle[0] {
                quality.smallest_angle[0] = angles[0];
                quality.worst = element;
                quality.worst_at =
                    [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
            }
            quality.smallest_angle[1] += angles[0];
            quality.below_25 += f64::from(u8::from(angles[0] < 25.0));
            let alike =
                |regular: [f64; 3]| angles.iter().zip(regular).all(|(angle, of)| (angle - of).abs() < 0.5);
            quality.regular += f64::from(u8::from(alike([45.0, 45.0, 90.0]) || alike([60.0; 3])));
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

fn edges([a, b, c]: [Point; 3]) -> [f64; 3] {
    [distance(b, c), distance(c, a), distance(a, b)]
}

/// The angles opposite the edges, degrees.
fn angles([a, b, c]: [f64; 3]) -> [f64; 3] {
    let angle = |a: f64, b: f64, c: f64| {
        ((b * b + c * c - a * a) / (2.0 * b * c)).clamp(-1.0, 1.0).acos().to_degrees()
    };
    [angle(a, b, c), angle(b, c, a), angle(c, a, b)]
}
