//! The faces of cavities, and the volume that their motion adds.

use crate::action::Scene;
use crate::faces::BrokenSides;
use crate::simplex::Simplex;
use crate::solid::Solid;
use crate::sum::Sum;
use crate::topology::{NONE, corners_of_facet};
use crate::vector::{Point, add, dot, minus};

/// Facets enclose a volume if the sum of their area vectors is less than this share of their area.
const CLOSED: f64 = 1e-9;

/// The boundary of a facet is made of rims: its vertices, in three dimensions its edges. Numbers of vertices
/// in the whole mesh, ascending; [`NONE`] for a missing one.
pub(crate) type Rim = [u32; 2];

/// The rims of a facet with these vertices.
pub(crate) fn rims<const D: usize>(vertices: [u32; D]) -> impl Iterator<Item = Rim> {
    (0..D).map(move |without| {
        let mut rim = [NONE; 2];
        let others = (0..D).filter(|&k| k != without).map(|k| vertices[k]);
        rim.iter_mut().zip(others).for_each(|(place, vertex)| *place = vertex);
        rim.sort_unstable();
        rim
    })
}

/// A face of a cavity that belongs to an element here.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face<const D: usize> {
    /// Corners of the element, in the order in which they go around the face, seen from outside.
    pub(crate) corners: [u32; D],
    /// Area vector along the outward normal, m², and mean position of the corners, m, at the last positions.
    pub(crate) area: Point<D>,
    pub(crate) middle: Point<D>,
}

impl<const D: usize> Face<D> {
    pub(crate) fn new<const N: usize>(corners: [u32; D], solid: &Solid<D, N>) -> Self
    where
        [[f64; D]; N]: Simplex<D, N>,
    {
        let places = corners.map(|corner| solid.position_at(corner));
        let mut middle = [0.0; D];
        for place in places {
            add(&mut middle, place, 1.0 / D as f64);
        }
        let area = <[[f64; D]; N]>::facet_normal(&places).map(|n| n * solid.thickness);
        Self { corners, area, middle }
    }

    /// Force of a pressure on each of the corners, N, against the outward normal.
    pub(crate) fn force(&self, pressure: f64) -> Point<D> {
        self.area.map(|a| -(pressure / D as f64 * a))
    }
}

/// Adds the sides of a joint that belong to elements here. Returns the volume by which it is open, m³, as
/// far as this rank counts it.
pub(crate) fn add_sides<const D: usize, const N: usize>(
    faces: &mut Vec<Face<D>>,
    joint: &BrokenSides<D>,
    scene: &Scene<'_, D, N>,
) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (topology, solid) = (scene.topology, scene.solid());
    let mut open = 0.0;
    for code in joint.sides {
        let Some(element) = topology.element(code / N as u32) else { continue };
        let face = Face::new(corners_of_facet::<D, N>(element as usize, code as usize % N), solid);
        if solid.share().element(element) {
            open -= dot(face.area, moved(&face, scene));
        }
        faces.push(face);
    }
    open
}

/// Mean displacement of the corners of a face, m.
fn moved<const D: usize, const N: usize>(face: &Face<D>, scene: &Scene<'_, D, N>) -> Point<D>
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut mean = [0.0; D];
    for corner in face.corners {
        let node = scene.solid().node_at(corner) as usize;
        add(&mut mean, scene.solid().displacement(node, scene.model), 1.0 / D as f64);
    }
    mean
}

/// The volume that undeformed facets enclose, m³, with that by which their motion has increased it; the
/// second alone if they do not enclose any.
pub(crate) fn volumes<const D: usize, const N: usize>(faces: &[Face<D>], scene: &Scene<'_, D, N>) -> [f64; 2]
where
    [[f64; D]; N]: Simplex<D, N>,
{
    [enclosed(faces, scene), increase(faces, scene).value()]
}

/// The volume that undeformed facets enclose, m³; 0 if they do not enclose any.
pub(crate) fn enclosed<const D: usize, const N: usize>(faces: &[Face<D>], scene: &Scene<'_, D, N>) -> f64
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let (mut enclosed, mut sum, mut whole) = (Sum::default(), [0.0; D], 0.0);
    for face in faces {
        let (place, area) = undeformed(face, scene);
        enclosed.add(-dot(area, place) / D as f64);
        add(&mut sum, area, 1.0);
        whole += dot(area, area).sqrt();
    }
    let is_closed = dot(sum, sum).sqrt() <= CLOSED * whole;
    if is_closed { enclosed.value().max(0.0) } else { 0.0 }
}

/// The volume by which the motion of facets has increased that which they enclose, m³.
pub(crate) fn increase<'a, const D: usize, const N: usize>(
    faces: impl IntoIterator<Item = &'a Face<D>>,
    scene: &Scene<'_, D, N>,
) -> Sum
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let mut increase = Sum::default();
    for face in faces {
        let (_, area) = undeformed(face, scene);
        let mean = std::array::from_fn(|axis| 0.5 * (area[axis] + face.area[axis]));
        increase.add(-dot(mean, moved(face, scene)));
    }
    increase
}

/// The place of the first corner of an undeformed face, m, and its area vector, m².
fn undeformed<const D: usize, const N: usize>(face: &Face<D>, scene: &Scene<'_, D, N>) -> (Point<D>, Point<D>)
where
    [[f64; D]; N]: Simplex<D, N>,
{
    let places = face.corners.map(|corner| {
        let vertex = scene.topology.vertices[corner as usize];
        minus(scene.model.mesh.nodes[vertex as usize], scene.solid().origin)
    });
    (places[0], <[[f64; D]; N]>::facet_normal(&places).map(|n| n * scene.solid().thickness))
}
