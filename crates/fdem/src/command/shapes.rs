//! Bodies of meshes, with or without spheres, for drawings and for ParaView.

use fdem_contact::Couple;
use fdem_contact::discretised::BodyContact;
use fdem_contact::narrow::{Contact, Measure};
use fdem_io::{Table, Values};

use fdem_results::picture::{Bodies, BodyJoint};

/// Elements of meshes and spheres with their bodies.
#[derive(Clone, Copy)]
pub(crate) struct BodyParts<'a, const D: usize, const N: usize> {
    pub(crate) points: &'a [[f64; D]],
    pub(crate) elements: &'a [[u32; N]],
    /// Body of each element; `numbers` has its number among all elements and spheres, which parts of one
    /// element share.
    pub(crate) bodies: &'a [u32],
    pub(crate) numbers: &'a [u32],
    pub(crate) centres: &'a [[f64; D]],
    pub(crate) radii: &'a [f64],
    pub(crate) sphere_bodies: &'a [u32],
    pub(crate) sphere_numbers: &'a [u32],
    pub(crate) body_count: usize,
}

/// Bodies and contacts as they are drawn.
pub(crate) struct Shapes {
    centres: Vec<[f64; 3]>,
    radii: Vec<f64>,
    points: Vec<[f64; 3]>,
    facets: Vec<[u32; 3]>,
    owners: Vec<u32>,
    joints: Vec<BodyJoint>,
    /// Overlap of each contact; `shared` and `couples` have its shared boundary and its number of couples of
    /// elements.
    overlap: Vec<f64>,
    shared: Vec<f64>,
    couples: Vec<f64>,
    dimensions: usize,
}

fn in_three<const D: usize>(point: [f64; D]) -> [f64; 3] {
    std::array::from_fn(|axis| point.get(axis).copied().unwrap_or(0.0))
}

impl Shapes {
    pub(crate) fn new<const D: usize, const N: usize>(
        parts: &BodyParts<'_, D, N>,
        contacts: &[BodyContact<D>],
    ) -> Self {
        let mut centres = middles(parts);
        let mut radii = vec![0.0; parts.body_count];
        for ((&body, &centre), &radius) in parts.sphere_bodies.iter().zip(parts.centres).zip(parts.radii) {
            centres[body as usize] = in_three(centre);
            radii[body as usize] = radius;
        }
        let (facets, owners) = surface(parts);
        let overlap: Vec<f64> = contacts.iter().map(|contact| contact.overlap).collect();
        let shared: Vec<f64> = contacts.iter().map(|contact| contact.shared).collect();
        let mut shapes = Self {
            centres,
            radii,
            points: parts.points.iter().map(|&point| in_three(point)).collect(),
            facets,
            owners,
            joints: Vec::new(),
            overlap,
            shared,
            couples: contacts.iter().map(|contact| contact.couples as f64).collect(),
            dimensions: D,
        };
        let values = shapes.columns()[0].1;
        let joint = |(contact, &value): (&BodyContact<D>, &f64)| BodyJoint {
            bodies: contact.bodies,
            point: in_three(contact.point),
            normal: in_three(contact.normal),
            value,
        };
        shapes.joints = contacts.iter().zip(values).map(joint).collect();
        shapes
    }

    /// Columns of the contacts: a name and a value per contact. The first column colours the contacts. It is
    /// the overlap, or the shared boundary if nothing overlaps.
    pub(crate) fn columns(&self) -> [(&'static str, &[f64]); 3] {
        let spheres = self.radii.iter().any(|&radius| radius > 0.0);
        let overlap = (if spheres { "depth" } else { "overlap" }, &self.overlap[..]);
        let shared = ("shared boundary", &self.shared[..]);
        let couples = ("couples of elements", &self.couples[..]);
        let is_some = |values: &[f64]| values.iter().any(|&value| value > 0.0);
        if is_some(&self.shared) && !is_some(&self.overlap) {
            [shared, overlap, couples]
        } else {
            [overlap, shared, couples]
        }
    }

    pub(crate) fn bodies(&self) -> Bodies<'_> {
        Bodies {
            dimensions: self.dimensions,
            centres: &self.centres,
            radii: &self.radii,
            points: &self.points,
            facets: &self.facets,
            owners: &self.owners,
            walls: self.radii.iter().any(|&radius| radius > 0.0),
            joints: &self.joints,
            value: self.columns()[0].0,
        }
    }
}

/// Centre of each meshed body: the mean of the centres of its elements, weighted by their areas or volumes.
/// Without any area or volume, the weights are equal.
fn middles<const D: usize, const N: usize>(parts: &BodyParts<'_, D, N>) -> Vec<[f64; 3]> {
    let mut weighted = vec![[0.0; 4]; parts.body_count];
    let mut plain = weighted.clone();
    for (nodes, &body) in parts.elements.iter().zip(parts.bodies) {
        let corners = nodes.map(|node| in_three(parts.points[node as usize]));
        let middle = mean(&corners);
        for (sums, weight) in [(&mut weighted, measure(&corners)), (&mut plain, 1.0)] {
            let sum = &mut sums[body as usize];
            for axis in 0..3 {
                sum[axis] += weight * middle[axis];
            }
            sum[3] += weight;
        }
    }
    let divided = |[x, y, z, weight]: [f64; 4]| (weight > 0.0).then(|| [x / weight, y / weight, z / weight]);
    weighted
        .into_iter()
        .zip(plain)
        .map(|(weighted, plain)| divided(weighted).or_else(|| divided(plain)).unwrap_or([0.0; 3]))
        .collect()
}

fn mean<const N: usize>(corners: &[[f64; 3]; N]) -> [f64; 3] {
    std::array::from_fn(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / N as f64)
}

/// Twice the area of a triangle, six times the volume of a tetrahedron.
fn measure<const N: usize>(corners: &[[f64; 3]; N]) -> f64 {
    let edge = |k: usize| -> [f64; 3] { std::array::from_fn(|axis| corners[k][axis] - corners[0][axis]) };
    let [a, b] = [edge(1), edge(2)];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    if N == 3 {
        return cross.iter().map(|x| x * x).sum::<f64>().sqrt();
    }
    cross.iter().zip(edge(3)).map(|(n, x)| n * x).sum::<f64>().abs()
}

/// Triangles of the surface and their bodies: all triangles, and the faces that only one tetrahedron of a
/// body has.
fn surface<const D: usize, const N: usize>(parts: &BodyParts<'_, D, N>) -> (Vec<[u32; 3]>, Vec<u32>) {
    let mut facets: Vec<(u32, [u32; 3])> = Vec::new();
    let mut faces: Vec<(u32, [u32; 3])> = Vec::new();
    for (nodes, &body) in parts.elements.iter().zip(parts.bodies) {
        // A triangle beside tetrahedra names its last node twice.
        if N == 3 || nodes[2] == nodes[3] {
            facets.push((body, [nodes[0], nodes[1], nodes[2]]));
            continue;
        }
        for without in 0..4 {
            let mut face = [0, 1, 2].map(|k| nodes[if k < without { k } else { k + 1 }]);
            face.sort_unstable();
            faces.push((body, face));
        }
    }
    faces.sort_unstable();
    facets.extend(faces.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]));
    facets.into_iter().map(|(body, nodes)| (nodes, body)).unzip()
}

/// Lines from the centres of elements to contact points, for ParaView.
pub(crate) struct Branches {
    /// Centres of the elements in the order of their numbers, then the contact points.
    places: Vec<[f64; 3]>,
    radii: Vec<f64>,
    contacts: Vec<i32>,
    /// The two points of each line, and its contact.
    lines: Vec<([i64; 2], u32)>,
}

impl Branches {
    /// Makes a line from the centre of each element of a couple to the contact point, but none from the
    /// centre of a wall that a sphere touches.
    pub(crate) fn new<const D: usize, const N: usize>(
        parts: &BodyParts<'_, D, N>,
        contacts: &[(Couple, Contact<D>)],
    ) -> Self {
        let numbers = parts.numbers.iter().chain(parts.sphere_numbers);
        let count = numbers.max().map_or(0, |&last| last as usize + 1);
        let mut places = vec![[0.0; 3]; count];
        let mut radii = vec![0.0; count];
        let mut is_sphere = vec![false; count];
        // The centre of an element of several parts is the mean of theirs.
        let mut sizes = vec![0.0; count];
        for (nodes, &number) in parts.elements.iter().zip(parts.numbers) {
            let corners = nodes.map(|node| in_three(parts.points[node as usize]));
            let (size, whole) = (measure(&corners), &mut sizes[number as usize]);
            *whole += size;
            let share = if *whole > size { size / *whole } else { 1.0 };
            for (x, now) in places[number as usize].iter_mut().zip(mean(&corners)) {
                *x = if share < 1.0 { *x + share * (now - *x) } else { now };
            }
        }
        for ((&number, &centre), &radius) in parts.sphere_numbers.iter().zip(parts.centres).zip(parts.radii) {
            places[number as usize] = in_three(centre);
            radii[number as usize] = radius;
            is_sphere[number as usize] = true;
        }
        let mut coordination = vec![0; count];
        let mut lines = Vec::new();
        for (k, (Couple { i, j }, contact)) in contacts.iter().enumerate() {
            let at = (count + k).cast_signed() as i64;
            places.push(in_three(contact.point));
            let [i, j] = [*i, *j].map(|element| element as usize);
            coordination[i] += 1;
            coordination[j] += 1;
            if is_sphere[i] || !is_sphere[j] {
                lines.push(([i.cast_signed() as i64, at], k as u32));
            }
            if is_sphere[j] || !is_sphere[i] {
                lines.push(([at, j.cast_signed() as i64], k as u32));
            }
        }
        Self { places, radii, contacts: coordination, lines }
    }

    /// Table of the points. `ids` and `bodies` are those of the elements; contact points have -1.
    pub(crate) fn points<'a>(&'a self, ids: &'a [i64], bodies: &'a [u32]) -> Table<'a> {
        let n = self.radii.len();
        Table::new(self.places.len())
            .with_components("positions", &["x", "y", "z"], Values::f64(|k| self.places[k / 3][k % 3]))
            .with("id", Values::i64(move |k| if k < n { ids[k] } else { -1 }))
            .with("body", Values::i64(move |k| if k < n { bodies[k].into() } else { -1 }))
            .with("radius", Values::f64(move |k| if k < n { self.radii[k] } else { 0.0 }))
            .with("coordination", Values::i32(move |k| if k < n { self.contacts[k] } else { 0 }))
            .with("contact", Values::i32(move |k| i32::from(k >= n)))
    }

    /// Table of the lines with the values of their contacts.
    pub(crate) fn table<'a, const D: usize>(&'a self, contacts: &'a [(Couple, Contact<D>)]) -> Table<'a> {
        let contact = move |k: usize| &contacts[self.lines[k].1 as usize].1;
        Table::new(self.lines.len())
            .with_components("ends", &["first", "second"], Values::i64(|k| self.lines[k / 2].0[k % 2]))
            .with("couple", Values::i64(|k| self.lines[k].1.into()))
            .with("kind", Values::i32(move |k| kind(contact(k).measure)))
            .with("measure", Values::f64(move |k| contact(k).measure.value()))
            .with_components(
                "normal",
                &["nx", "ny", "nz"],
                // Adding 0.0 turns -0.0 into 0.0.
                Values::f64(move |k| contact(k / 3).normal.get(k % 3).copied().unwrap_or(0.0) + 0.0),
            )
    }
}

/// Number for the kind of measure of a contact, in formats without text.
fn kind(measure: Measure) -> i32 {
    match measure {
        Measure::Gap(_) => 0,
        Measure::Depth(_) => 1,
        Measure::Length(_) => 2,
        Measure::Area(_) => 3,
        Measure::Volume(_) => 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tetrahedra of one body, one of another body, and a triangle beside them.
    #[test]
    fn the_surface_of_tetrahedra_has_no_faces_inside() {
        let points =
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 9.0]];
        let parts = BodyParts {
            points: &points,
            elements: &[[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 4, 5], [0, 1, 5, 5]],
            bodies: &[0, 0, 1, 2],
            numbers: &[0, 1, 2, 3],
            centres: &[],
            radii: &[],
            sphere_bodies: &[],
            sphere_numbers: &[],
            body_count: 3,
        };
        let (facets, owners) = surface(&parts);
        assert_eq!([0, 1, 2].map(|body| owners.iter().filter(|owner| **owner == body).count()), [6, 4, 1]);
        assert!(!facets.contains(&[1, 2, 3]) && facets[0] == [0, 1, 5]);
        let middles = middles(&parts);
        // Volumes of 1/6 and 2/6.
        let x = (0.25 / 6.0 + 0.5 / 3.0) / 0.5;
        assert!(middles[0].iter().all(|found| (found - x).abs() < 1e-15), "{middles:?}");
        // The triangle counts its node at 9 twice.
        assert_eq!(middles[2][1], 4.5, "a body without volume has the mean of its elements");
    }

    /// The two halves of a square have one centre, that of the square.
    #[test]
    fn lines_begin_at_the_middle_of_an_element_that_was_cut() {
        let parts = BodyParts {
            points: &[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [3.0, 1.0]],
            elements: &[[0, 1, 2], [0, 2, 3], [1, 4, 2]],
            bodies: &[0, 0, 1],
            numbers: &[0, 0, 1],
            centres: &[],
            radii: &[],
            sphere_bodies: &[],
            sphere_numbers: &[],
            body_count: 2,
        };
        let contact = Contact { point: [2.0, 1.0], normal: [1.0, 0.0], measure: Measure::Area(0.0) };
        let branches = Branches::new(&parts, &[(Couple::new(0, 1), contact)]);
        let [x, y, z] = branches.places[0];
        assert!((x - 1.0).abs() < 1e-15 && (y - 1.0).abs() < 1e-15 && z == 0.0, "{:?}", branches.places);
        assert_eq!(branches.lines, [([0, 2], 0), ([2, 1], 0)]);
    }

    /// The line to a wall ends at the contact point.
    #[test]
    fn lines_lead_to_contacts() {
        let parts = BodyParts {
            points: &[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
            elements: &[[0, 1, 2]],
            bodies: &[0],
            numbers: &[0],
            centres: &[[1.0, 1.0, 0.5], [1.0, 1.0, 1.5]],
            radii: &[0.5, 0.5],
            sphere_bodies: &[1, 2],
            sphere_numbers: &[1, 2],
            body_count: 3,
        };
        let contact = |point| Contact { point, normal: [0.0, 0.0, 1.0], measure: Measure::Depth(0.0) };
        let contacts =
            [(Couple::new(0, 1), contact([1.0, 1.0, 0.0])), (Couple::new(1, 2), contact([1.0, 1.0, 1.0]))];
        let branches = Branches::new(&parts, &contacts);
        assert_eq!(branches.lines, [([3, 1], 0), ([1, 4], 1), ([4, 2], 1)]);
        assert_eq!(branches.places[0], [1.0, 1.0, 0.0]);
        assert_eq!(branches.contacts, [1, 2, 1]);
    }
}
