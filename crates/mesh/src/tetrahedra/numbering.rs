//! The numbers of nodes and elements: neighbours in the body are near in memory.

use super::delaunay::{FACETS, NONE};
use super::improve::body::{BORDER, Body};
use super::mesh::Tetrahedra;
use super::order;
use super::skin::Skin;
use super::surface::{INNER, OUTSIDE};
use super::vector::{Point, plus, times};

/// The mesh without unused nodes and elements, in order along a space-filling curve.
pub(super) fn number(body: &Body, skin: &Skin) -> Tetrahedra {
    let mut new = Tetrahedra::default();
    let used: Vec<usize> = (0..body.points.len()).filter(|&node| body.at[node] != NONE).collect();
    let points: Vec<Point> = used.iter().map(|&node| body.points[node]).collect();
    let mut numbers = vec![NONE; body.points.len()];
    for (number, &place) in (0..).zip(&order::along_curve(&points)) {
        numbers[used[place as usize]] = number;
        new.nodes.push(points[place as usize]);
    }
    let all: Vec<usize> = (0..body.corners.len()).filter(|&t| body.is_used(t)).collect();
    let middle = |&t: &usize| {
        let [a, b, c, d] = body.corners[t].map(|corner| body.points[corner as usize]);
        times(plus(plus(a, b), plus(c, d)), 0.25)
    };
    let middles: Vec<Point> = all.iter().map(middle).collect();
    let faces = between(skin, false);
    let inner = between(skin, true);
    for place in order::along_curve(&middles) {
        let t = all[place as usize];
        let corners = body.corners[t];
        new.elements.push(corners.map(|corner| numbers[corner as usize]));
        new.regions.push(body.regions[t]);
        for (place, facet) in FACETS.iter().enumerate() {
            let code = body.across[t][place];
            let facet = facet.map(|k| corners[k]);
            let mut key = facet;
            key.sort_unstable();
            if body.walls[t] >> place & 1 == 1 && (t as u32) < code / 4 {
                let Ok(found) = inner.binary_search_by_key(&key, |(corners, _)| *corners) else { continue };
                new.inner.push(facet.map(|corner| numbers[corner as usize]));
                new.inner_faces.push(inner[found].1);
                continue;
            }
            let face = if code >= BORDER {
                skin.patches[(code - BORDER) as usize].face
            } else if body.regions[t] < body.regions[(code / 4) as usize] {
                let Ok(found) = faces.binary_search_by_key(&key, |(corners, _)| *corners) else { continue };
                faces[found].1
            } else {
                continue;
            };
            new.facets.push(facet.map(|corner| numbers[corner as usize]));
            new.faces.push(face);
        }
    }
    new
}

/// Triangles of the skin between regions, or those inside of regions, by their corners, with their faces.
fn between(skin: &Skin, inner: bool) -> Vec<([u32; 3], u32)> {
    let mut faces = Vec::new();
    for (&triangle, &patch) in skin.triangles.iter().zip(&skin.of) {
        let patch = &skin.patches[patch as usize];
        if !patch.sides.contains(&OUTSIDE) && (patch.sides[0] == INNER) == inner {
            let mut key = triangle;
            key.sort_unstable();
            faces.push((key, patch.face));
        }
    }
    faces.sort_unstable();
    faces
}
