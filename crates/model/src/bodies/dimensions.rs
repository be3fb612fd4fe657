//! The dimensions of a model: how they are found, and the meshing that differs between them.

mod differences;

use fdem_mesh::Corners;
use fdem_simulation::Element;

use crate::bodies::{gmsh, mesh_file};
use crate::joints::lines::JointLines;
use crate::shapes::piece::Piece;
use crate::shapes::{of_body, packing};
use crate::text::fault::Problem;
use crate::text::file::{self, Grains, Gravity, ModelFile, Side, Wall};
use crate::text::included::Load;

/// The differences between two- and three-dimensional models before they are simulated.
pub(crate) trait Dimensions<const D: usize, const N: usize>:
    Element<D, N> + Corners<D, N> + AsRef<[[f64; D]]> + Copy
{
    /// A facet of one element only, in messages.
    const OUTER_FACET: &'static str;

    /// The meshed pieces of a body, with joints in them: one piece, unless it is a packing.
    fn pieces(
        file: &ModelFile,
        body: &file::Body,
        joints: &JointLines<'_>,
        load: &mut Load<'_>,
    ) -> Result<Vec<Piece<D, N>>, Problem>;

    /// Distance of two elements, m; 0 if they touch. `None` for elements without area or volume.
    fn gap(&self, other: &Self) -> Option<f64>;

    /// The rotation by an angle, degrees, about an axis.
    fn turn(angle: f64, axis: Option<[f64; 3]>) -> [[f64; D]; D];

    /// Share of the full angle under which a facet is seen from the origin, negative from its outer side.
    fn seen(facet: [[f64; D]; D]) -> f64;

    /// The stress with these components, as the model file has them.
    fn stress(components: &[f64]) -> [[f64; D]; D];
}

/// The dimensions of a model: those that it says, or that its bodies have. If a file that would determine
/// them cannot be read, vectors and supports determine them.
pub(crate) fn of(file: &ModelFile, load: &mut Load<'_>) -> u8 {
    let of_insertions = || file.insertion.first().map(|of| of.within.dimensions());
    let of_spheres = || file.grains.iter().find_map(Grains::dimensions).or_else(of_insertions);
    let of_walls = || file.wall.iter().find_map(Wall::dimensions);
    let of_bodies = || file.body.iter().find_map(of_body::dimensions);
    let told = || of_bodies().or_else(of_spheres).or_else(of_walls);
    let vectors = || match &file.model.gravity {
        Gravity::Vector(gravity) => Some(gravity.0.len() as u8),
        Gravity::None(_) => None,
    };
    let mut from_files = || {
        let Some(name) = file.body.iter().find_map(|body| body.mesh.as_ref()) else {
            let of_spheres = || file.grains.iter().find_map(|grains| grains.file.as_ref());
            let of_bodies = file.body.iter().find_map(|body| body.packing.as_ref()?.file.as_ref());
            let name = of_bodies.or_else(of_spheres)?;
            return Some(if packing::read_space(&load(name).ok()?, name, None).is_ok() { 3 } else { 2 });
        };
        if gmsh::is_geometry(name) {
            return Some(3);
        }
        Some(if mesh_file::is_in_space(name, load)? { 3 } else { 2 })
    };
    let boundaries = || file.boundary.iter().any(is_in_space);
    let injections = || file.injection.iter().any(|of| of.at.as_ref().is_some_and(|at| at.0.len() == 3));
    let surfaces = || file.pore_surface.iter().any(is_surface_in_space);
    let in_space = || (boundaries() || injections() || surfaces()).then_some(3);
    let said = file.model.dimensions.filter(|said| [2, 3].contains(said));
    said.or_else(told).or_else(vectors).or_else(&mut from_files).or_else(in_space).unwrap_or(2)
}

/// Whether a surface of pores can only be meant for three dimensions.
fn is_surface_in_space(surface: &file::PoreSurface) -> bool {
    surface.all_sides().any(|side| matches!(side, Side::Front | Side::Back))
        || surface.limits.as_ref().is_some_and(|limits| limits.len() == 6)
        || surface.at.as_ref().is_some_and(|at| at.0.len() == 3)
}

/// Whether a boundary can only be meant for three dimensions.
fn is_in_space(boundary: &file::Boundary) -> bool {
    let holds_z = boundary.fixed.is_some_and(|fixed| fixed.axes()[2]);
    let on_side = boundary.all_sides().any(|side| matches!(side, Side::Front | Side::Back));
    let motions = [&boundary.velocity, &boundary.displacement];
    let loads = [&boundary.force, &boundary.traction, &boundary.at];
    holds_z
        || on_side
        || boundary.limits.as_ref().is_some_and(|limits| limits.len() == 6)
        || motions.into_iter().flatten().any(|motion| motion.len() == 3)
        || loads.into_iter().flatten().any(|load| load.0.len() == 3)
}
