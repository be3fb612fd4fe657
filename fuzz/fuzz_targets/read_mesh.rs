//! Any bytes are read as a mesh or refused without a panic; a mesh that is read has the documented properties
//! of `MeshFile`.

#![no_main]

use fdem_io::{Cells, MeshFile, read_mesh};
use libfuzzer_sys::fuzz_target;

/// Names for content that does not show its format.
const NAMES: [&str; 8] = ["a.msh", "a.stl", "a.obj", "a.ply", "a.vtk", "a.vtu", "a.inp", "a"];

fuzz_target!(|bytes: &[u8]| {
    let Some((&first, file)) = bytes.split_first() else { return };
    match read_mesh(file, NAMES[usize::from(first % 8)]) {
        Ok(mesh) => {
            assert!(mesh.points.as_flattened().iter().all(|x| x.is_finite()));
            assert!(!(mesh.segments.is_empty() && mesh.triangles.is_empty() && mesh.tetrahedra.is_empty()));
            check(&mesh.segments, &mesh);
            check(&mesh.triangles, &mesh);
            check(&mesh.tetrahedra, &mesh);
        }
        // Every error can be printed.
        Err(error) => assert!(!error.to_string().is_empty()),
    }
});

fn check<const N: usize>(cells: &Cells<N>, mesh: &MeshFile) {
    assert_eq!((cells.bodies.len(), cells.numbers.len()), (cells.len(), cells.len()));
    assert!(cells.bodies.iter().all(|&body| (body as usize) < mesh.bodies.len()));
    for nodes in &cells.nodes {
        assert!(nodes.iter().all(|&node| (node as usize) < mesh.points.len()));
        assert!((1..N).all(|at| !nodes[..at].contains(&nodes[at])), "a node twice");
    }
}
