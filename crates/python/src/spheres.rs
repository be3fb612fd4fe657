//! Spheres of a run as arrays.

use fdem::simulation::grains::{GrainContact, GrainPartner, SphereColumns};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::number::array_of_rows;

/// Returns the columns of spheres as arrays; nothing of the spheres is copied. Contacts become columns.
pub(crate) fn spheres(py: Python<'_>, spheres: SphereColumns) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("contacts", contacts(py, &spheres.contacts)?)?;
    dict.set_item("numbers", spheres.numbers.into_pyarray(py))?;
    dict.set_item("positions", array_of_rows(py, spheres.positions)?)?;
    dict.set_item("radii", spheres.radii.into_pyarray(py))?;
    dict.set_item("velocities", array_of_rows(py, spheres.velocities)?)?;
    dict.set_item("spins", array_of_rows(py, spheres.spins)?)?;
    dict.set_item("forces", array_of_rows(py, spheres.forces)?)?;
    dict.set_item("masses", spheres.masses.into_pyarray(py))?;
    dict.set_item("materials", spheres.materials.into_pyarray(py))?;
    dict.set_item("groups", spheres.groups.into_pyarray(py))?;
    dict.set_item("wall_forces", array_of_rows(py, spheres.wall_forces)?)?;
    Ok(dict)
}

/// Returns the names of the groups, and those of the walls.
pub(crate) fn names(spheres: &SphereColumns) -> (Vec<String>, Vec<String>) {
    (spheres.group_names.clone(), spheres.walls.iter().map(|wall| wall.name.clone()).collect())
}

fn contacts<'py>(py: Python<'py>, contacts: &[GrainContact]) -> PyResult<Bound<'py, PyDict>> {
    let other = |contact: &GrainContact| match contact.other {
        GrainPartner::Sphere(other) => (0_u8, other),
        GrainPartner::Wall(other) => (1, other),
        GrainPartner::Facet(other) => (2, other),
    };
    let (kinds, others): (Vec<u8>, Vec<u32>) = contacts.iter().map(other).unzip();
    let dict = PyDict::new(py);
    dict.set_item("sphere", contacts.iter().map(|of| of.sphere).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("other", others.into_pyarray(py))?;
    dict.set_item("kind", kinds.into_pyarray(py))?;
    dict.set_item("point", array_of_rows(py, contacts.iter().map(|of| of.place).collect())?)?;
    dict.set_item("force", array_of_rows(py, contacts.iter().map(|of| of.force).collect())?)?;
    dict.set_item("normal", contacts.iter().map(|of| of.normal).collect::<Vec<_>>().into_pyarray(py))?;
    dict.set_item("overlap", contacts.iter().map(|of| of.overlap).collect::<Vec<_>>().into_pyarray(py))?;
    Ok(dict)
}
