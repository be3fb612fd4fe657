//! Spheres against surfaces: the walls of drums, boxes and silos.

use std::collections::BTreeSet;

use crate::couple::Couple;
use crate::discretised::search::{PART, reserve_one};
use crate::discretised::{DiscretisedError, MeshSearch, MeshView};
use crate::error::Error;
use crate::filter::Filter;
use crate::memory::{reserve, resize};
use crate::narrow::{MeshContact, ShapeError, Sphere, Triangle, sphere_mesh};
use crate::verify::{Mismatch, pick};

/// A sphere that touches a triangle of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereContact {
    /// Zero-based number of the sphere.
    pub sphere: u32,
    /// The body of the triangle.
    pub body: u32,
    /// The triangle of the mesh, the feature of the triangle, and the contact, whose normal leads from the
    /// sphere to the triangle.
    pub contact: MeshContact,
}

/// The categories of spheres and of triangles in the search: each sees only the other.
const CATEGORIES: [u32; 2] = [1, 2];
const MASKS: [u32; 2] = [2, 1];

/// The candidates of one sphere: the triangles of one body whose boxes it touches.
type Candidates<'a> = &'a [(u32, u32, u32)];

impl MeshSearch<3> {
    /// Writes the contacts of spheres with the surfaces of bodies into `contacts`, which is cleared first.
    ///
    /// Within each body every face, edge and vertex counts once, as in [`sphere_mesh`]: a sphere on a flat
    /// wall has one contact with it at any position.
    ///
    /// # Shapes
    /// `centres`, `radii` `[n]`. Result: `m` contacts, sorted by sphere, then body, then triangle. A sphere
    /// has at most one contact with each triangle.
    ///
    /// # Units
    /// One length unit for everything.
    ///
    /// # Cost
    /// Cost of [`MeshSearch`] for spheres and triangles together.
    ///
    /// # Errors
    /// [`DiscretisedError::Radii`], [`DiscretisedError::Sphere`], and [`DiscretisedError::Search`], which
    /// numbers the spheres first, then the triangles. `contacts` is empty after an error.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::Engine;
    /// use fdem_contact::discretised::{MeshView, MeshSearch};
    ///
    /// // A floor of two triangles, and a ball above the edge between them.
    /// let points = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]];
    /// let floor = MeshView::new(&points, &[[0, 1, 2], [0, 2, 3]], &[0, 0])?;
    /// let mut contacts = Vec::new();
    /// MeshSearch::new().sphere_contacts(&[[2.0, 2.0, 0.9]], &[1.0], &floor, &mut contacts)?;
    /// assert_eq!(contacts.len(), 1);
    /// assert_eq!(contacts[0].contact.contact.normal, [0.0, 0.0, -1.0]);
    /// # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
    /// ```
    #[doc(alias = "walls")]
    pub fn sphere_contacts(
        &mut self,
        centres: &[[f64; 3]],
        radii: &[f64],
        surface: &MeshView<'_, 3, 3>,
        contacts: &mut Vec<SphereContact>,
    ) -> Result<(), DiscretisedError> {
        contacts.clear();
        let spheres = spheres(centres, radii)?;
        let walls = triangles(surface)?;
        let n = spheres.len();
        self.clear_boxes(n + walls.len())?;
        let margin = Margin::new(centres, radii, surface);
        for (centre, &radius) in centres.iter().zip(radii) {
            let reach = margin.reach(radius);
            self.min.push(centre.map(|x| x - reach));
            self.max.push(centre.map(|x| x + reach));
        }
        for triangle in 0..walls.len() {
            let [min, max] = surface.bounds(triangle);
            self.min.push(min);
            self.max.push(max);
        }
        let numbers = |[of_spheres, of_walls]: [u32; 2]| {
            let mut numbers = Vec::new();
            resize(&mut numbers, n, of_spheres)?;
            resize(&mut numbers, n + walls.len(), of_walls)?;
            Ok::<_, Error>(numbers)
        };
        let (categories, masks) = (numbers(CATEGORIES)?, numbers(MASKS)?);
        self.find_couples(Some(Filter::masks(&categories, &masks)))?;

        // A sphere has a smaller number than any triangle.
        let mut near: Vec<(u32, u32, u32)> = Vec::new();
        reserve(&mut near, self.couples.len())?;
        near.extend(self.couples.iter().map(|&Couple { i, j }| {
            let triangle = j - n as u32;
            (i, surface.bodies()[triangle as usize], triangle)
        }));
        near.sort_unstable();
        let mut groups: Vec<Candidates<'_>> = Vec::new();
        let chunks = near.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        reserve(&mut groups, chunks.clone().count())?;
        groups.extend(chunks);
        self.in_parts(groups.chunks(PART), contacts, |groups, out| {
            let (mut candidates, mut found) = (Vec::new(), Vec::new());
            for group in groups {
                let (sphere, body, _) = group[0];
                candidates.clear();
                reserve(&mut candidates, group.len())?;
                candidates.extend(group.iter().map(|&(.., triangle)| triangle));
                if sphere_mesh(&spheres[sphere as usize], &walls, &candidates, &mut found).is_err() {
                    unreachable!("candidates are numbers of triangles");
                }
                for &contact in &found {
                    reserve_one(out)?;
                    out.push(SphereContact { sphere, body, contact });
                }
            }
            Ok(())
        })
    }

    /// Checks the contacts of `sample` random spheres against all triangles, by the narrow phase alone.
    ///
    /// Returns the number of spheres checked: `sample`, or all of them if there are fewer. The same `seed`
    /// picks the same spheres.
    ///
    /// # Cost
    /// `sample` tests per triangle.
    ///
    /// # Errors
    /// The errors of [`MeshSearch::sphere_contacts`]. The inner result is the first [`Mismatch`] found, which
    /// numbers the spheres first, then the triangles.
    ///
    /// # Example
    /// ```
    /// use fdem_contact::Engine;
    /// use fdem_contact::discretised::{MeshView, MeshSearch};
    ///
    /// let points = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0]];
    /// let floor = MeshView::new(&points, &[[0, 1, 2]], &[0])?;
    /// let checked = MeshSearch::verify_spheres(&[[3.0, 1.0, 1.0]], &[1.0], &floor, &[], 10, 0)?;
    /// assert!(checked.is_err(), "they touch");
    /// # Ok::<(), fdem_contact::discretised::DiscretisedError>(())
    /// ```
    pub fn verify_spheres(
        centres: &[[f64; 3]],
        radii: &[f64],
        surface: &MeshView<'_, 3, 3>,
        contacts: &[SphereContact],
        sample: usize,
        seed: u64,
    ) -> Result<Result<usize, Mismatch>, DiscretisedError> {
        let spheres = spheres(centres, radii)?;
        let walls = triangles(surface)?;
        let n = spheres.len() as u32;
        let picked = pick(spheres.len(), sample, seed);
        let mut listed = BTreeSet::new();
        for found in contacts {
            let couple = Couple { i: found.sphere, j: n.saturating_add(found.contact.triangle) };
            if found.sphere >= n || found.contact.triangle as usize >= walls.len() {
                return Ok(Err(Mismatch::Malformed(couple)));
            }
            if picked.binary_search(&found.sphere).is_ok() && !listed.insert(couple) {
                return Ok(Err(Mismatch::Repeated(couple)));
            }
        }
        let mut of_bodies: Vec<u32> = (0..walls.len() as u32).collect();
        of_bodies.sort_by_key(|&triangle| surface.bodies()[triangle as usize]);
        let mut touching = Vec::new();
        for &sphere in &picked {
            for body in
                of_bodies.chunk_by(|&a, &b| surface.bodies()[a as usize] == surface.bodies()[b as usize])
            {
                let done = sphere_mesh(&spheres[sphere as usize], &walls, body, &mut touching);
                done.map_err(|problem| DiscretisedError::Sphere { index: sphere as usize, problem })?;
                for contact in &touching {
                    let couple = Couple { i: sphere, j: n + contact.triangle };
                    if !listed.remove(&couple) {
                        return Ok(Err(Mismatch::Missing(couple)));
                    }
                }
            }
        }
        Ok(listed.first().map_or(Ok(picked.len()), |&couple| Err(Mismatch::Extra(couple))))
    }
}

fn spheres(centres: &[[f64; 3]], radii: &[f64]) -> Result<Vec<Sphere<3>>, DiscretisedError> {
    if centres.len() != radii.len() {
        return Err(DiscretisedError::Radii { spheres: centres.len(), found: radii.len() });
    }
    let mut spheres = Vec::new();
    reserve(&mut spheres, centres.len())?;
    for (index, (&centre, &radius)) in centres.iter().zip(radii).enumerate() {
        let sphere: Result<_, ShapeError> = Sphere::new(centre, radius);
        spheres.push(sphere.map_err(|problem| DiscretisedError::Sphere { index, problem })?);
    }
    Ok(spheres)
}

fn triangles(surface: &MeshView<'_, 3, 3>) -> Result<Vec<Triangle<3>>, Error> {
    let mut triangles = Vec::new();
    reserve(&mut triangles, surface.len())?;
    triangles.extend((0..surface.len()).map(|k| Triangle { vertices: surface.vertices(k) }));
    Ok(triangles)
}

/// How far beyond its radius a sphere may still touch because of rounding.
///
/// A sphere touches if `d² <= r²`, where `d²` has an error of 32 rounding steps of the square of the largest
/// difference of coordinates ([`sphere_triangle`](crate::narrow::sphere_triangle)). The closest points on
/// edges, and the corners of the box, are rounded like coordinates. The margin is twice the sum of all these.
struct Margin {
    squared: f64,
    plain: f64,
}

impl Margin {
    fn new(centres: &[[f64; 3]], radii: &[f64], surface: &MeshView<'_, 3, 3>) -> Self {
        let [mut low, mut high] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for point in centres.iter().chain(surface.points) {
            for axis in 0..3 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let [mut widest, mut farthest] = [0.0_f64; 2];
        for axis in 0..3 {
            widest = widest.max(high[axis] - low[axis]);
            farthest = farthest.max(low[axis].abs()).max(high[axis].abs());
        }
        farthest += radii.iter().fold(0.0, |largest: f64, &r| largest.max(r));
        if centres.is_empty() || surface.points.is_empty() {
            return Self { squared: 0.0, plain: 0.0 };
        }
        Self { squared: 64.0 * f64::EPSILON * widest * widest, plain: 16.0 * f64::EPSILON * farthest }
    }

    fn reach(&self, radius: f64) -> f64 {
        (radius * radius + self.squared).sqrt() + self.plain
    }
}
