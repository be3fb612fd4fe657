//! Models of rock, from model files like those of users.

use fdem_simulation::{Model, Simulation};

use super::models::centroid;
use fdem_model::{AnyPrepared, Load, prepare, prepare_any};

/// The model of a model file.
pub(super) fn prepared(text: &str) -> Result<Model, String> {
    prepared_with(text, &mut |name| Err(format!("{name}: there are no files")))
}

/// The model of a model file that names files.
pub(super) fn prepared_with(text: &str, load: &mut Load<'_>) -> Result<Model, String> {
    let prepared = prepare(text, "case.toml", load);
    prepared.map(|prepared| prepared.model).map_err(|errors| errors.to_string())
}

/// The model of a model file in three dimensions.
pub(super) fn prepared_in_space(text: &str) -> Result<Model<3, 4>, String> {
    let mut load = |name: &str| Err(format!("{name}: there are no files"));
    match prepare_any(text, "case.toml", &mut load, None).map_err(|errors| errors.to_string())? {
        AnyPrepared::Space(prepared) => Ok(prepared.model),
        AnyPrepared::Plane(_) => Err("the model of the case is flat".to_owned()),
    }
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
