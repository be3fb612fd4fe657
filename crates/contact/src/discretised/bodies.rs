//! Gathers contacts of elements to contacts of bodies.

use crate::discretised::element::sealed::Sealed as _;
use crate::discretised::{DiscretisedError, ElementContact, MeshElement, MeshView};
use crate::error::Error;
use crate::image::unit;
use crate::memory::{reserve, resize};
use crate::narrow::{Contact, Measure};

/// Two touching bodies, and the sums and means over all of their contacts.
///
/// `point` and `normal` are means weighted by the overlap; without overlap, by the shared boundary; without
/// either, every couple of elements has the same weight.
///
/// # Shapes
/// `D` is the dimension of the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyContact<const D: usize> {
    /// The numbers of the bodies, the smaller first; the same number twice for a body that touches itself.
    pub bodies: [u32; 2],
    /// Number of couples of touching elements, one of each body.
    pub couples: u64,
    /// Total overlap: the area of triangles in 2D, the volume of tetrahedra, the length of the lines in which
    /// surfaces cross, or the sum of the depths of spheres.
    pub overlap: f64,
    /// Size of the shared boundary: the length of common edges of triangles in 2D, the area of common faces
    /// of tetrahedra, or the area in which surfaces are coplanar and overlap. 0 for bodies that meet only at
    /// nodes (in 3D also at edges).
    pub shared: f64,
    /// The weighted mean of the contact points.
    pub point: [f64; D],
    /// The weighted mean of the contact normals, from the first body to the second, of length 1; zeros if
    /// they cancel out.
    pub normal: [f64; D],
}

/// Sums over one kind of contact.
#[derive(Clone, Copy)]
struct Sums<const D: usize> {
    weight: f64,
    point: [f64; D],
    normal: [f64; D],
}

impl<const D: usize> Sums<D> {
    const ZERO: Self = Self { weight: 0.0, point: [0.0; D], normal: [0.0; D] };

    /// Adds a point and a normal with a weight.
    fn add(&mut self, weight: f64, point: [f64; D], normal: [f64; D]) {
        self.weight += weight;
        for k in 0..D {
            self.point[k] += weight * point[k];
            self.normal[k] += weight * normal[k];
        }
    }
}

/// A contact of bodies whose sums are not complete yet.
struct Gathered<const D: usize> {
    bodies: [u32; 2],
    couples: u64,
    overlap: Sums<D>,
    shared: Sums<D>,
    plain: Sums<D>,
}

impl<const D: usize> Gathered<D> {
    fn new(bodies: [u32; 2]) -> Self {
        Self { bodies, couples: 0, overlap: Sums::ZERO, shared: Sums::ZERO, plain: Sums::ZERO }
    }

    fn add(&mut self, contact: &Contact<D>, turned: bool) {
        let normal = if turned { contact.normal.map(|x| -x) } else { contact.normal };
        self.couples += 1;
        self.plain.add(1.0, contact.point, normal);
        match contact.measure {
            Measure::Area(area) if D > 2 => self.shared.add(area, contact.point, normal),
            measure => self.overlap.add(measure.value(), contact.point, normal),
        }
    }

    fn finish(&self) -> BodyContact<D> {
        let sums =
            [&self.overlap, &self.shared].into_iter().find(|sums| sums.weight > 0.0).unwrap_or(&self.plain);
        BodyContact {
            bodies: self.bodies,
            couples: self.couples,
            overlap: self.overlap.weight,
            shared: self.shared.weight,
            point: sums.point.map(|x| x / sums.weight),
            normal: unit(sums.normal),
        }
    }
}

/// Gathers contacts to contacts of bodies. Each contact comes with the bodies of its first and its second
/// element.
///
/// Sums run over the contacts in their order, so the result is a function of the list alone. Gaps are left
/// out. For meshes, [`body_contacts`] also finds the boundary that triangles in 2D and tetrahedra share.
///
/// # Shapes
/// `m` contacts of elements; result: the contacts of bodies, each pair of bodies once, sorted by the smaller,
/// then the larger number.
///
/// # Cost
/// Time proportional to `m log m`, 16 bytes for each contact and 200 for each pair of bodies.
///
/// # Errors
/// [`DiscretisedError::Search`] if there is no memory.
///
/// # Example
/// ```
/// use fdem_contact::discretised::gather;
/// use fdem_contact::narrow::{Sphere, sphere_sphere};
///
/// let contact = sphere_sphere(&Sphere::new([0.0, 0.0], 2.0)?, &Sphere::new([3.0, 0.0], 2.0)?);
/// let bodies = gather(&[([9, 4], contact)])?;
/// assert_eq!((bodies[0].bodies, bodies[0].overlap), ([4, 9], 1.0));
/// assert_eq!(bodies[0].normal, [-1.0, 0.0]); // from body 4 to body 9
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn gather<const D: usize>(
    contacts: &[([u32; 2], Contact<D>)],
) -> Result<Vec<BodyContact<D>>, DiscretisedError> {
    let gathered = sum_up(contacts.len(), |k| (contacts[k].0, &contacts[k].1))?;
    finish(&gathered)
}

/// Gathers the contacts of the elements of a mesh to contacts of its bodies, including the shared boundary.
///
/// Two bodies share an edge (2D) or a face (tetrahedra) if each has exactly one element with that edge or
/// face. Edges and faces are compared by the coordinates of their nodes, so bodies whose meshes have separate
/// nodes share boundary too. The length or area is the same to the last bit from both sides.
///
/// # Shapes
/// `contacts`: those of [`MeshSearch::contacts`](super::MeshSearch::contacts), or some of them. Pairs of
/// bodies without a contact are left out. Result: see [`gather`].
///
/// # Cost
/// Cost of [`gather`]; for meshes that are not surfaces, also the sorting of all nodes and facets.
///
/// # Errors
/// [`DiscretisedError::MalformedContact`]; [`DiscretisedError::Search`] if there is no memory.
///
/// # Example
/// ```
/// use fdem_contact::discretised::{MeshView, body_contacts, contacts};
///
/// // Two tetrahedra with a face in common.
/// let points = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
/// let mesh = MeshView::new(&points, &[[0, 1, 2, 3], [0, 1, 2, 4]], &[5, 3])?;
/// let [contact] = body_contacts(&mesh, &contacts(&mesh)?)?[..] else { panic!() };
/// assert_eq!((contact.bodies, contact.shared), ([3, 5], 2.0));
/// assert_eq!(contact.normal, [0.0, 0.0, 1.0]);
/// # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
/// ```
pub fn body_contacts<const D: usize, const N: usize>(
    mesh: &MeshView<'_, D, N>,
    contacts: &[ElementContact<D>],
) -> Result<Vec<BodyContact<D>>, DiscretisedError>
where
    [[f64; D]; N]: MeshElement<D>,
{
    for (index, &ElementContact { i, j, .. }) in contacts.iter().enumerate() {
        if i >= j || j as usize >= mesh.len() {
            return Err(DiscretisedError::MalformedContact { index, i, j, elements: mesh.len() });
        }
    }
    let mut gathered = sum_up(contacts.len(), |k| {
        let ElementContact { i, j, contact } = &contacts[k];
        ([*i, *j].map(|element| mesh.bodies[element as usize]), contact)
    })?;
    add_shared_facets(mesh, &mut gathered)?;
    finish(&gathered)
}

fn finish<const D: usize>(gathered: &[Gathered<D>]) -> Result<Vec<BodyContact<D>>, DiscretisedError> {
    let mut bodies = Vec::new();
    reserve(&mut bodies, gathered.len())?;
    bodies.extend(gathered.iter().map(Gathered::finish));
    Ok(bodies)
}

fn sum_up<'a, const D: usize>(
    contacts: usize,
    contact: impl Fn(usize) -> ([u32; 2], &'a Contact<D>),
) -> Result<Vec<Gathered<D>>, Error> {
    let mut order: Vec<([u32; 2], usize)> = Vec::new();
    reserve(&mut order, contacts)?;
    for k in 0..contacts {
        let ([a, b], contact) = contact(k);
        if contact.touches() {
            order.push(([a.min(b), a.max(b)], k));
        }
    }
    order.sort_unstable();
    let pairs = order.chunk_by(|a, b| a.0 == b.0);
    let mut all = Vec::new();
    reserve(&mut all, pairs.clone().count())?;
    for pair in pairs {
        let mut sums = Gathered::new(pair[0].0);
        for &(_, k) in pair {
            let ([a, b], contact) = contact(k);
            sums.add(contact, a > b);
        }
        all.push(sums);
    }
    Ok(all)
}

/// A facet of an element: an edge in 2D or a face in 3D.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Facet<const D: usize> {
    /// The places of its nodes in ascending order.
    places: [u32; D],
    body: u32,
    element: u32,
    /// The number of the facet in its element.
    local: u32,
}

fn add_shared_facets<const D: usize, const N: usize>(
    mesh: &MeshView<'_, D, N>,
    gathered: &mut [Gathered<D>],
) -> Result<(), Error>
where
    [[f64; D]; N]: MeshElement<D>,
{
    let kinds = <[[f64; D]; N]>::FACETS;
    if kinds.is_empty() || gathered.is_empty() {
        return Ok(());
    }
    let places = places(mesh.points)?;
    let mut facets: Vec<Facet<D>> = Vec::new();
    reserve(&mut facets, mesh.len().saturating_mul(kinds.len()))?;
    for (element, nodes) in mesh.elements.iter().enumerate() {
        for (local, (nodes_of, _)) in kinds.iter().enumerate() {
            let mut places = nodes_of.map(|k| places[nodes[k] as usize]);
            places.sort_unstable();
            // A facet without length or area shares nothing.
            if places.windows(2).all(|pair| pair[0] != pair[1]) {
                let body = mesh.bodies[element];
                facets.push(Facet { places, body, element: element as u32, local: local as u32 });
            }
        }
    }
    facets.sort_unstable();
    let mut outer = Vec::new();
    for same in facets.chunk_by(|a, b| a.places == b.places) {
        outer.clear();
        // Inside a body, two elements have the facet.
        outer.extend(
            same.chunk_by(|a, b| a.body == b.body).filter(|of_body| of_body.len() == 1).map(|one| one[0]),
        );
        for (k, a) in outer.iter().enumerate() {
            for b in &outer[k + 1..] {
                if let Ok(pair) = gathered.binary_search_by_key(&[a.body, b.body], |pair| pair.bodies) {
                    let (area, centre, normal) = outwards(mesh, a);
                    gathered[pair].shared.add(area, centre, normal);
                }
            }
        }
    }
    Ok(())
}

/// Size, centre and outward unit normal of a facet.
fn outwards<const D: usize, const N: usize>(
    mesh: &MeshView<'_, D, N>,
    facet: &Facet<D>,
) -> (f64, [f64; D], [f64; D])
where
    [[f64; D]; N]: MeshElement<D>,
{
    let (locals, opposite) = <[[f64; D]; N]>::FACETS[facet.local as usize];
    let vertices = mesh.vertices(facet.element as usize);
    // The order does not depend on the element, so both sides give the same numbers.
    let mut corners = locals.map(|k| vertices.vertex(k));
    corners.sort_unstable_by(|a, b| {
        a.iter()
            .zip(b)
            .map(|(x, y)| x.total_cmp(y))
            .find(|order| order.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let centre: [f64; D] = std::array::from_fn(|k| corners.iter().map(|p| p[k]).sum::<f64>() / D as f64);
    let across = <[[f64; D]; N]>::across(&corners);
    let inside = vertices.vertex(opposite);
    let side: f64 = (0..D).map(|k| across[k] * (corners[0][k] - inside[k])).sum();
    let area = across.iter().map(|x| x * x).sum::<f64>().sqrt();
    let normal = unit(across);
    (area, centre, if side < 0.0 { normal.map(|x| -x) } else { normal })
}

/// A number for each point, equal for points with equal coordinates.
fn places<const D: usize>(points: &[[f64; D]]) -> Result<Vec<u32>, Error> {
    // Adding zero makes both zeros equal.
    let key = |node: u32| points[node as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = Vec::new();
    reserve(&mut order, points.len())?;
    order.extend(0..points.len() as u32);
    order.sort_unstable_by_key(|&node| (key(node), node));
    let mut places = Vec::new();
    resize(&mut places, points.len(), 0)?;
    for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &node in same {
            places[node as usize] = same[0];
        }
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discretised::contacts;

    #[test]
    fn inner_facets_are_not_shared() {
        // A square of two triangles, twice at the same place: the sides are shared, the diagonals are not.
        let points = [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
            [-0.0, 0.0],
            [1.0, -0.0],
            [1.0, 1.0],
            [0.0, 1.0],
        ];
        let elements = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        let mesh = MeshView::new(&points, &elements, &[0, 0, 1, 1]).unwrap();
        let found = body_contacts(&mesh, &contacts(&mesh).unwrap()).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].couples, found[0].overlap, found[0].shared), (4, 1.0, 4.0));
        let [x, y] = found[0].point;
        assert!((x - 0.5).abs() < 1e-15 && (y - 0.5).abs() < 1e-15, "{x} {y}");
    }

    #[test]
    fn contacts_of_nothing_that_is_there_are_refused() {
        let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mesh = MeshView::new(&points, &[[0, 1, 2], [0, 1, 2]], &[0, 1]).unwrap();
        let good = contacts(&mesh).unwrap()[0];
        for (i, j) in [(1, 0), (0, 0), (0, 2)] {
            let error = body_contacts(&mesh, &[good, ElementContact { i, j, ..good }]).unwrap_err();
            assert_eq!(error, DiscretisedError::MalformedContact { index: 1, i, j, elements: 2 });
        }
    }

    #[test]
    fn gaps_are_left_out() {
        let gap = Contact { point: [0.0; 2], normal: [1.0, 0.0], measure: Measure::Gap(1.0) };
        assert_eq!(gather(&[([0, 1], gap)]).unwrap(), []);
    }
}
