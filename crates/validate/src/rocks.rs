//! Models of rock, from model files like those of users.

use fdem_simulation::{Model, Simulation};

use super::models::centroid;
use fdem_model::{AnyPrepared, prepare, prepare_any};

/// The model of a model file, which may name the meshes of [`mesh_file`].
pub(super) fn prepared(text: &str) -> Result<Model, String> {
    let prepared = prepare(text, "case.toml", &mut mesh_file);
    prepared.map(|prepared| prepared.model).map_err(|errors| errors.to_string())
}

/// The model of a model file in three dimensions, which may name the meshes of [`mesh_file`].
pub(super) fn prepared_in_space(text: &str) -> Result<Model<3, 4>, String> {
    match prepare_any(text, "case.toml", &mut mesh_file, None).map_err(|errors| errors.to_string())? {
        AnyPrepared::Space(prepared) => Ok(prepared.model),
        AnyPrepared::Plane(_) => Err("the model of the case is flat".to_owned()),
    }
}

/// A mesh of Gmsh, by the name of its file.
fn mesh_file(name: &str) -> Result<Vec<u8>, String> {
    let text: &[u8] = match name {
        "delaunay-3.msh" => include_bytes!("meshes/delaunay-3.msh"),
        "delaunay-6.msh" => include_bytes!("meshes/delaunay-6.msh"),
        "delaunay-12.msh" => include_bytes!("meshes/delaunay-12.msh"),
        "frontal-3.msh" => include_bytes!("meshes/frontal-3.msh"),
        "frontal-6.msh" => include_bytes!("meshes/frontal-6.msh"),
        "frontal-12.msh" => include_bytes!("meshes/frontal-12.msh"),
        "plate-6.msh" => include_bytes!("meshes/plate-6.msh"),
        _ => return Err(format!("{name}: there is no such mesh")),
    };
    Ok(text.to_vec())
}

/// Mean stress of the elements whose centroids were within a distance of a point, `[xx, yy, xy]` in Pa.
pub(super) fn stress_near(run: &Simulation, [x, y]: [f64; 2], distance: f64) -> [f64; 3] {
    let mesh = &run.model().mesh;
    let near = |element: &usize| {
        let [u, v] = centroid(mesh, *element);
        (u - x).hypot(v - y) <= distance
    };
    let stresses = run.snapshot().stresses;
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for element in (0..mesh.elements.len()).filter(near) {
        let [xx, yy, _, xy, ..] = stresses[element];
        for (total, stress) in sum.iter_mut().zip([xx, yy, xy]) {
            *total += stress;
        }
        count += 1.0;
    }
    sum.map(|total| total / f64::max(count, 1.0))
}
