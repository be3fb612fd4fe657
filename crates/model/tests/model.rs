//! Model files: reading, refusals and their messages, and the meshes.
//!
//! - `anisotropy`: bedding of materials.
//! - `mistakes`: every kind of error, with its line, its key and the suggestion.
//! - `bonds`: joint sets between bodies.
//! - `cavities`: pressures in holes and cracks, schedules of loads.
//! - `coming`: spheres that come in and boxes that remove them, clumps.
//! - `fluid`: fluid in cracks, injections.
//! - `grains`: spheres and walls.
//! - `ground`: the surface of ground at rest.
//! - `joint_sets`: joints in the mesh, and their laws.
//! - `joint_planes`: the same in three dimensions.
//! - `included`: files that a model includes, and copies of a body.
//! - `library`: materials of the library.
//! - `limits`: models that would take more memory or time than there is.
//! - `locking`: how much too stiff elements are in bending.
//! - `meshes`: shapes, sizes, angles, grains, packings, mesh files.
//! - `packings`: packings in three dimensions, and copies of a shape.
//! - `refine`: places near which elements are smaller.
//! - `prepared`: the result of a model file: boundaries, materials, histories, warnings.
//! - `pores`: liquid in pores, their surfaces.
//! - `probes`: histories of stress, strain, velocity, gauges and forces between bodies.
//! - `scaling`: mass scaling, and advice for quasi-static runs.
//! - `set`: values that are set from outside.
//! - `space`, `space_warned`: the same in three dimensions.
//! - `values`: parameters, arithmetic and units.
//! - `warned`: settings that are allowed, and probably not meant.
//! - `examples`: the examples, the starter and the schema.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed unwrap is a failed test")]

#[path = "model/anisotropy.rs"]
mod anisotropy;
#[path = "model/bonds.rs"]
mod bonds;
#[path = "model/cavities.rs"]
mod cavities;
#[path = "model/coming.rs"]
mod coming;
#[path = "model/examples.rs"]
mod examples;
#[path = "model/fluid.rs"]
mod fluid;
#[path = "model/grains.rs"]
mod grains;
#[path = "model/ground.rs"]
mod ground;
#[path = "model/joint_sets.rs"]
mod joint_sets;
#[path = "model/joint_planes.rs"]
mod joint_planes;
#[path = "model/included.rs"]
mod included;
#[path = "model/library.rs"]
mod library;
#[path = "model/limits.rs"]
mod limits;
#[path = "model/loading.rs"]
mod loading;
#[path = "model/locking.rs"]
mod locking;
#[path = "model/meshes.rs"]
mod meshes;
#[path = "model/mistakes.rs"]
mod mistakes;
#[path = "model/packings.rs"]
mod packings;
#[path = "model/pores.rs"]
mod pores;
#[path = "model/prepared.rs"]
mod prepared;
#[path = "model/probes.rs"]
mod probes;
#[path = "model/refine.rs"]
mod refine;
#[path = "model/scaling.rs"]
mod scaling;
#[path = "model/set.rs"]
mod set;
#[path = "model/space.rs"]
mod space;
#[path = "model/space_warned.rs"]
mod space_warned;
#[path = "model/values.rs"]
mod values;
#[path = "model/warned.rs"]
mod warned;

use fdem_model::{ModelErrors, Prepared, prepare};

/// A small model that is right.
const SMALL: &str = r#"[model]
end_time = 1e-3

[[body]]
name = "block"
material = "rock"
rectangle = { min = [0, 0], max = [1.0, 0.5] }
mesh_size = 0.1

[[material]]
name = "rock"
density = 2700
youngs_modulus = 30e9
poissons_ratio = 0.25
"#;

/// Reads a model that names no files.
fn read(text: &str) -> Result<Prepared, ModelErrors> {
    prepare(text, "model.toml", &mut |_| Err("there is no such file".to_owned()))
}

#[track_caller]
fn right(text: &str) -> Prepared {
    read(text).unwrap_or_else(|errors| panic!("{errors}"))
}
