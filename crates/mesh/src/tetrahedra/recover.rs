//! Makes every triangle of a skin a facet of Delaunay's tetrahedra.
//!
//! A triangle is a facet if some sphere through its corners is empty. Where none is, edges of the skin are
//! split, and the patches around them flipped, until all are there. Nothing is moved, so the skin still
//! covers the same surface.
//!
//! # Source
//! J. Ruppert, "A Delaunay refinement algorithm for quality 2-dimensional mesh generation", J. Algorithms 18
//! (1995), for the circles around corners on which edges with a sharp angle between them are split; J. R.
//! Shewchuk, "Tetrahedral mesh generation by Delaunay refinement", `SoCG` 1998.

use super::delaunay::{Delaunay, FACETS, GHOST, NONE};
use super::error::MeshError;
use super::order;
use super::plane::{Plane, Point2};
use super::skin::Skin;
use super::surface::INNER;
use super::vector::{distance, dot, minus, plus, times};

/// Rounds of splitting.
const ROUNDS: usize = 60;

/// Facets of the skin in the tetrahedra: four times the tetrahedron, plus the place of the opposite corner;
/// and the triangle. Each twice, from both sides.
pub(crate) type Hits = Vec<(u32, u32)>;

/// Corners in order of their numbers.
fn key(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Facets that are looked for.
struct Wanted {
    /// The facets by their corners.
    all: Vec<([u32; 3], u32)>,
    /// Whether a point is a corner of any.
    corner: Vec<bool>,
}

impl Wanted {
    fn new(facets: impl Iterator<Item = [u32; 3]>, points: usize) -> Self {
        let mut corner = vec![false; points];
        let mut all: Vec<_> = facets.map(key).zip(0..).collect();
        for &node in all.iter().flat_map(|(corners, _)| corners) {
            corner[node as usize] = true;
        }
        all.sort_unstable();
        Self { all, corner }
    }

    /// Calls `hit` with each facet of the tetrahedra that is looked for, from either side.
    fn look(&self, mesh: &Delaunay, mut hit: impl FnMut(u32, u32)) {
        let is_corner = |node: u32| self.corner.get(node as usize).is_some_and(|&is| is);
        for (t, corners) in mesh.corners.iter().enumerate() {
            let wanted = corners.map(is_corner);
            if wanted.iter().filter(|&&is| is).count() < 3 {
                continue;
            }
            for (place, facet) in FACETS.iter().enumerate() {
                if facet.iter().all(|&k| wanted[k]) {
                    let key = key(facet.map(|k| corners[k]));
                    if let Ok(found) = self.all.binary_search_by_key(&key, |(corners, _)| *corners) {
                        hit((4 * t + place) as u32, self.all[found].1);
                    }
                }
            }
        }
    }
}

/// Locks the facets that are triangles of the skin. Returns them, and the triangles that are missing.
pub(crate) fn lock(mesh: &mut Delaunay, skin: &Skin) -> (Hits, Vec<u32>) {
    let wanted = Wanted::new(skin.triangles.iter().copied(), skin.points.len());
    let mut hits = Hits::new();
    wanted.look(mesh, |facet, triangle| hits.push((facet, triangle)));
    let mut found = vec![false; skin.triangles.len()];
    mesh.locked.fill(0);
    for &(facet, triangle) in &hits {
        found[triangle as usize] = true;
        mesh.locked[(facet / 4) as usize] |= 1 << (facet % 4);
    }
    let missing = (0..).zip(found).filter(|(_, found)| !found).map(|(triangle, _)| triangle).collect();
    (hits, missing)
}

/// Delaunay's tetrahedra of the points of the skin. Splits triangles until all are facets.
///
/// # Errors
/// [`MeshError::Flat`]; [`MeshError::NotRecovered`] where triangles are missing after a reasonable number of
/// added points.
pub(crate) fn recover(skin: &mut Skin) -> Result<(Delaunay, Hits), MeshError> {
    let order = order::rounds(&order::along_curve(&skin.points));
    let mut mesh = Delaunay::new(&skin.points, &order).ok_or(MeshError::Flat)?;
    let most = 6 * skin.points.len() + 20_000;
    let nodes = skin.inside.iter().take_while(|&&patch| patch == NONE).count();
    for _ in 0..ROUNDS {
        let (hits, missing) = lock(&mut mesh, skin);
        let Some(&first) = missing.first() else { return Ok((mesh, hits)) };
        let before = skin.points.len();
        if before > most {
            return Err(not_recovered(skin, first));
        }
        mend(skin, &mesh, &missing, nodes);
        for vertex in before..skin.points.len() {
            if !mesh.insert(&skin.points, vertex as u32) {
                return Err(not_recovered(skin, first));
            }
        }
    }
    let (hits, missing) = lock(&mut mesh, skin);
    missing.first().map_or(Ok((mesh, hits)), |&first| Err(not_recovered(skin, first)))
}

fn not_recovered(skin: &Skin, triangle: u32) -> MeshError {
    let [a, b, c] = skin.corners(triangle as usize);
    MeshError::NotRecovered { place: times(plus(plus(a, b), c), 1.0 / 3.0) }
}

/// The triangles with each edge.
struct Edges(Vec<([u32; 2], u32)>);

impl Edges {
    fn new(triangles: &[[u32; 3]]) -> Self {
        let mut all = Vec::with_capacity(3 * triangles.len());
        for (triangle, corners) in (0..).zip(triangles) {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                all.push(([a.min(b), a.max(b)], triangle));
            }
        }
        all.sort_unstable();
        Self(all)
    }

    fn around(&self, a: u32, b: u32) -> &[([u32; 2], u32)] {
        let edge = [a.min(b), a.max(b)];
        let first = self.0.partition_point(|(ends, _)| *ends < edge);
        let count = self.0[first..].iter().take_while(|(ends, _)| *ends == edge).count();
        &self.0[first..first + count]
    }
}

/// Flips or splits each missing triangle.
fn mend(skin: &mut Skin, mesh: &Delaunay, missing: &[u32], nodes: usize) {
    let edges = Edges::new(&skin.triangles);
    let flips: Vec<Option<[[u32; 3]; 2]>> = missing
        .iter()
        .flat_map(|&triangle| [0, 1, 2].map(|k| (triangle, k)))
        .map(|(triangle, k)| flipped(skin, &edges, triangle, k))
        .collect();
    let facets = flips.iter().flat_map(|flip| flip.unwrap_or([[NONE; 3]; 2]));
    let facets: Vec<[u32; 3]> = facets.collect();
    let mut there = vec![false; facets.len()];
    // A triangle that is searched for twice is found once.
    let mut unique: Vec<([u32; 3], usize)> = facets.iter().map(|&facet| key(facet)).zip(0..).collect();
    unique.sort_unstable();
    let keys: Vec<[u32; 3]> = unique.chunk_by(|a, b| a.0 == b.0).map(|same| same[0].0).collect();
    let real = keys.iter().copied().filter(|corners| corners[2] != NONE);
    let wanted = Wanted::new(real, skin.points.len());
    let mut found = vec![false; keys.len()];
    wanted.look(mesh, |_, number| found[number as usize] = true);
    for (is, (corners, number)) in
        unique.iter().filter_map(|entry| keys.binary_search(&entry.0).ok().map(|at| (found[at], entry)))
    {
        there[*number] = is && corners[2] != NONE;
    }
    let segments = present_edges(skin, mesh, missing);
    let mut touched = vec![false; skin.triangles.len()];
    let mut patches = Vec::new();
    for (number, &triangle) in missing.iter().enumerate() {
        if touched[triangle as usize] {
            continue;
        }
        let corners = skin.triangles[triangle as usize];
        if let Some(k) = (0..3).find(|k| there[2 * (3 * number + k)] && there[2 * (3 * number + k) + 1])
            && let Some(flip) = flips[3 * number + k]
        {
            let pair = edges.around(corners[(k + 1) % 3], corners[(k + 2) % 3]);
            if pair.iter().all(|&(_, t)| !touched[t as usize]) {
                for (&(_, t), flip) in pair.iter().zip(flip) {
                    touched[t as usize] = true;
                    skin.triangles[t as usize] = flip;
                }
            }
            continue;
        }
        let lost = (0..3).find(|&k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            segments.binary_search(&[a.min(b), a.max(b)]).is_err()
        });
        let long = |k: usize| {
            let [a, b] = [corners[k], corners[(k + 1) % 3]].map(|node| skin.points[node as usize]);
            distance(a, b)
        };
        let longest = if long(0) >= long(1).max(long(2)) { 0 } else { 1 + usize::from(long(2) > long(1)) };
        let k =
            lost.filter(|&k| is_border(skin, &edges, corners[k], corners[(k + 1) % 3])).unwrap_or(longest);
        split(skin, &edges, [corners[k], corners[(k + 1) % 3]], nodes, &mut touched, &mut patches);
    }
    patches.sort_unstable();
    patches.dedup();
    // Only facets inside of a region meet a patch within it.
    let has_inner = skin.patches.iter().any(|patch| patch.sides[0] == INNER);
    let edges = if has_inner { Edges::new(&skin.triangles) } else { Edges(Vec::new()) };
    let groups = edges.0.chunk_by(|one, other| one.0 == other.0);
    let shared: Vec<[u32; 2]> = groups.filter(|group| group.len() > 2).map(|group| group[0].0).collect();
    for patch in patches {
        flip_patch(skin, &shared, patch);
    }
}

/// Whether an edge is between patches.
fn is_border(skin: &Skin, edges: &Edges, a: u32, b: u32) -> bool {
    let around = edges.around(a, b);
    around.len() != 2 || skin.of[around[0].1 as usize] != skin.of[around[1].1 as usize]
}

/// The two triangles that an edge's two would be flipped to, in the order of [`Edges::around`]; `None` at
/// edges between patches.
fn flipped(skin: &Skin, edges: &Edges, triangle: u32, k: usize) -> Option<[[u32; 3]; 2]> {
    let corners = skin.triangles[triangle as usize];
    let (a, b) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
    if is_border(skin, edges, a, b) {
        return None;
    }
    let around = edges.around(a, b);
    let apex = |t: u32| skin.triangles[t as usize].into_iter().find(|&corner| corner != a && corner != b);
    let other = if around[0].1 == triangle { around[1].1 } else { around[0].1 };
    let (c, d) = (corners[k], apex(other)?);
    Some([[c, a, d], [c, d, b]])
}

/// Which edges of the missing triangles are edges of tetrahedra: sorted.
fn present_edges(skin: &Skin, mesh: &Delaunay, missing: &[u32]) -> Vec<[u32; 2]> {
    let mut wanted: Vec<[u32; 2]> = Vec::new();
    for &triangle in missing {
        let corners = skin.triangles[triangle as usize];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            wanted.push([a.min(b), a.max(b)]);
        }
    }
    wanted.sort_unstable();
    wanted.dedup();
    let mut found = vec![false; wanted.len()];
    for corners in mesh.corners.iter().filter(|corners| corners[0] != corners[1]) {
        for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            let (a, b) = (corners[i], corners[j]);
            if a != GHOST
                && b != GHOST
                && let Ok(at) = wanted.binary_search(&[a.min(b), a.max(b)])
            {
                found[at] = true;
            }
        }
    }
    wanted.into_iter().zip(found).filter(|(_, found)| *found).map(|(edge, _)| edge).collect()
}

/// Splits an edge, and all triangles with it.
fn split(
    skin: &mut Skin,
    edges: &Edges,
    [a, b]: [u32; 2],
    nodes: usize,
    touched: &mut Vec<bool>,
    patches: &mut Vec<u32>,
) {
    let around = edges.around(a, b);
    if around.iter().any(|&(_, t)| touched[t as usize]) {
        return;
    }
    let (a, b) = (a.min(b), a.max(b));
    let [from, to] = [a, b].map(|node| skin.points[node as usize]);
    let span = distance(from, to);
    // Pieces at a corner of the surface have lengths that are powers of 2: those of neighbouring edges then
    // do not split each other without end.
    let part = match ((a as usize) < nodes, (b as usize) < nodes) {
        (true, false) => power(span) / span,
        (false, true) => 1.0 - power(span) / span,
        _ => 0.5,
    };
    let vertex = skin.points.len() as u32;
    let border = is_border(skin, edges, a, b);
    skin.points.push(plus(from, times(minus(to, from), part)));
    skin.inside.push(if border { NONE } else { skin.of[around[0].1 as usize] });
    for &(_, t) in around {
        let t = t as usize;
        let corners = skin.triangles[t];
        touched[t] = true;
        touched.push(true);
        patches.push(skin.of[t]);
        skin.of.push(skin.of[t]);
        skin.triangles.push(corners.map(|corner| if corner == a { vertex } else { corner }));
        skin.triangles[t] = corners.map(|corner| if corner == b { vertex } else { corner });
    }
}

/// The power of 2 between a third and two thirds of a length.
fn power(span: f64) -> f64 {
    let mut power = 1.0;
    while power > span / 1.5 {
        power *= 0.5;
    }
    while power < span / 3.0 {
        power *= 2.0;
    }
    power
}

/// Flips the edges of a patch until its triangles are Delaunay's in its plane; the `shared` ones, which have
/// more than two, stay.
fn flip_patch(skin: &mut Skin, shared: &[[u32; 2]], patch: u32) {
    let all: Vec<usize> = (0..skin.triangles.len()).filter(|&t| skin.of[t] == patch).collect();
    let mut used: Vec<u32> = all.iter().flat_map(|&t| skin.triangles[t]).collect();
    used.sort_unstable();
    used.dedup();
    let local = |node: u32| used.binary_search(&node).unwrap_or(0) as u32;
    let axes = skin.patches[patch as usize].axes;
    let origin = skin.points[used[0] as usize];
    let points: Vec<Point2> = used
        .iter()
        .map(|&node| axes.map(|axis| dot(axis, minus(skin.points[node as usize], origin))))
        .collect();
    let triangles: Vec<[u32; 3]> = all.iter().map(|&t| skin.triangles[t].map(local)).collect();
    let is_used = |ends: &&[u32; 2]| ends.iter().all(|end| used.binary_search(end).is_ok());
    let walls: Vec<[u32; 2]> = shared.iter().filter(is_used).map(|ends| ends.map(local)).collect();
    let mut plane = Plane::with_walls(points, triangles, 0.0, &walls);
    plane.make_delaunay();
    for (&t, corners) in all.iter().zip(&plane.triangles) {
        skin.triangles[t] = corners.map(|node| used[node as usize]);
    }
}
