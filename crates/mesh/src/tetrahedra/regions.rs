//! Which tetrahedra are in which region: found from facet to facet, so that no rounding decides.

use super::delaunay::{Delaunay, FACETS, NONE};
use super::error::MeshError;
use super::predicates::side;
use super::recover::Hits;
use super::skin::Skin;
use super::surface::{INNER, OUTSIDE};
use super::vector::{Point, distance, plus, times};

/// Not yet known.
const UNKNOWN: u32 = NONE - 1;

/// Gives each tetrahedron its region, or [`OUTSIDE`].
///
/// # Errors
/// [`MeshError::Sides`] where facets contradict each other.
pub(crate) fn classify(mesh: &mut Delaunay, skin: &Skin, hits: &Hits) -> Result<(), MeshError> {
    mesh.regions.fill(UNKNOWN);
    let mut open = Vec::new();
    for t in 0..mesh.corners.len() {
        if mesh.is_used(t) && !mesh.is_solid(t) {
            mesh.regions[t] = OUTSIDE;
            open.push(t as u32);
        }
    }
    // Facets inside of a region are no end of it.
    let mut walls = mesh.locked.clone();
    for &(facet, triangle) in hits {
        let (t, place) = ((facet / 4) as usize, (facet % 4) as usize);
        if skin.patches[skin.of[triangle as usize] as usize].sides[0] == INNER {
            walls[t] &= !(1 << place);
            continue;
        }
        let [a, b, c] = FACETS[place].map(|k| mesh.corners[t][k]);
        let corners = skin.triangles[triangle as usize];
        let behind = [[a, b, c], [b, c, a], [c, a, b]].contains(&corners);
        let region = skin.patches[skin.of[triangle as usize] as usize].sides[usize::from(!behind)];
        if mesh.regions[t] == UNKNOWN {
            mesh.regions[t] = region;
            open.push(t as u32);
        } else if mesh.regions[t] != region {
            return Err(MeshError::Sides { place: middle(skin.corners(triangle as usize)) });
        }
    }
    while let Some(t) = open.pop() {
        let t = t as usize;
        let region = mesh.regions[t];
        for place in (0..4).filter(|place| walls[t] >> place & 1 == 0) {
            let u = (mesh.across[t][place] / 4) as usize;
            if mesh.regions[u] == UNKNOWN {
                mesh.regions[u] = region;
                open.push(u as u32);
            } else if mesh.regions[u] != region {
                let corners = FACETS[place].map(|k| mesh.corners[t][k]);
                let corner = corners.into_iter().find_map(|corner| skin.points.get(corner as usize));
                return Err(MeshError::Sides { place: corner.copied().unwrap_or([0.0; 3]) });
            }
        }
    }
    Ok(())
}

/// Turns over pairs of triangles of one plane below which there is a flat tetrahedron: it is outside then.
/// Returns whether there was any.
///
/// Points in a plane that is not along the axes are in it only up to rounding, and four of them may be
/// corners of a tetrahedron.
pub(crate) fn peel(mesh: &Delaunay, skin: &mut Skin, hits: &Hits) -> bool {
    let mut of: Vec<(u32, u32)> = hits.clone();
    of.sort_unstable();
    let mut peeled = false;
    for pair in of.windows(2).filter(|pair| pair[0].0 / 4 == pair[1].0 / 4) {
        let t = (pair[0].0 / 4) as usize;
        let [one, other] = [pair[0], pair[1]].map(|(_, triangle)| triangle as usize);
        let outer = |&(facet, _): &(u32, u32)| {
            mesh.regions[(mesh.across[t][(facet % 4) as usize] / 4) as usize] == OUTSIDE
        };
        let corners = mesh.corners[t];
        if mesh.regions[t] == OUTSIDE || skin.of[one] != skin.of[other] || !pair.iter().all(outer) {
            continue;
        }
        let [a, b, c, d] = corners.map(|corner| skin.points[corner as usize]);
        let longest = [b, c, d].map(|point| distance(a, point)).into_iter().fold(0.0, f64::max);
        if side(a, b, c, d) > FLAT * longest * longest * longest {
            continue;
        }
        // The other two facets, seen from outside of the tetrahedron, become the surface: turned round.
        let mut rest = (0..4_u32).filter(|place| pair.iter().all(|(facet, _)| facet % 4 != *place));
        for triangle in [one, other] {
            if let Some(place) = rest.next() {
                let [a, b, c] = FACETS[place as usize].map(|k| corners[k]);
                let behind = skin.patches[skin.of[triangle] as usize].sides[0] != OUTSIDE;
                skin.triangles[triangle] = if behind { [a, c, b] } else { [a, b, c] };
            }
        }
        peeled = true;
    }
    peeled
}

/// Six times the volume over the cube of an edge, below which a tetrahedron is flat.
const FLAT: f64 = 1e-9;

fn middle([a, b, c]: [Point; 3]) -> Point {
    times(plus(plus(a, b), c), 1.0 / 3.0)
}
