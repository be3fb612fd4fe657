//! Contacts of meshed bodies.

use fdem_contact::discretised::{
    BodyContact, ElementContact, MeshElement, MeshSearch, MeshView, SphereContact, body_contacts,
};
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::interrupt::{self, Stop};
use crate::number::{entries_of, rows_of};
use crate::problem::Problem;

/// The contacts of elements and those of bodies, as columns.
type ContactColumns<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>);

/// The contacts of the elements `cells` between `nodes`.
#[pyfunction]
pub(crate) fn mesh<'py>(
    py: Python<'py>,
    nodes: PyReadonlyArray2<'py, f64>,
    cells: PyReadonlyArray2<'py, u32>,
    bodies: PyReadonlyArray1<'py, u32>,
    self_contact: bool,
    threads: usize,
) -> PyResult<ContactColumns<'py>> {
    let arrays = (&nodes, &cells, &bodies);
    match (nodes.shape()[1], cells.shape()[1]) {
        (2, 3) => find::<2, 3>(py, arrays, self_contact, threads),
        (3, 3) => find::<3, 3>(py, arrays, self_contact, threads),
        (3, 4) => find::<3, 4>(py, arrays, self_contact, threads),
        (dimensions, corners) => Err(Problem::Arguments(format!(
            "cells are triangles in 2D or 3D, or tetrahedra in 3D: 3 or 4 nodes each, not {corners} in {dimensions}D"
        ))
        .into()),
    }
}

type Arrays<'a, 'py> =
    (&'a PyReadonlyArray2<'py, f64>, &'a PyReadonlyArray2<'py, u32>, &'a PyReadonlyArray1<'py, u32>);

fn find<'py, const D: usize, const N: usize>(
    py: Python<'py>,
    (nodes, cells, bodies): Arrays<'_, 'py>,
    self_contact: bool,
    threads: usize,
) -> PyResult<ContactColumns<'py>>
where
    [[f64; D]; N]: MeshElement<D>,
{
    let (nodes, cells, bodies) = (rows_of::<f64, D>(nodes)?, rows_of::<u32, N>(cells)?, entries_of(bodies)?);
    let (elements, of_bodies) = interrupt::run(py, false, &Stop::default(), || {
        let mesh = MeshView::new(nodes, cells, bodies)?;
        let search = MeshSearch::new().with_threads(threads)?;
        let mut contacts = Vec::new();
        search.with_self_contact(self_contact).contacts(&mesh, &mut contacts)?;
        let of_bodies = body_contacts(&mesh, &contacts)?;
        Ok::<_, Problem>((contacts, of_bodies))
    })?;
    Ok((element_columns(py, &elements)?, body_columns(py, &of_bodies)?))
}

/// The contacts of spheres with the triangles `cells` between `nodes`, as columns.
#[pyfunction]
pub(crate) fn walls<'py>(
    py: Python<'py>,
    centres: PyReadonlyArray2<'py, f64>,
    radii: PyReadonlyArray1<'py, f64>,
    nodes: PyReadonlyArray2<'py, f64>,
    cells: PyReadonlyArray2<'py, u32>,
    bodies: PyReadonlyArray1<'py, u32>,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let (centres, radii) = (rows_of::<f64, 3>(&centres)?, entries_of(&radii)?);
    let (nodes, cells, bodies) =
        (rows_of::<f64, 3>(&nodes)?, rows_of::<u32, 3>(&cells)?, entries_of(&bodies)?);
    let contacts = interrupt::run(py, false, &Stop::default(), || {
        let surface = MeshView::new(nodes, cells, bodies)?;
        let mut search = MeshSearch::new().with_threads(threads)?;
        let mut contacts = Vec::new();
        search.sphere_contacts(centres, radii, &surface, &mut contacts)?;
        Ok::<_, Problem>(contacts)
    })?;
    let columns = PyDict::new(py);
    let numbers =
        |of: fn(&SphereContact) -> u32| contacts.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    columns.set_item("i", numbers(|contact| contact.sphere))?;
    columns.set_item("triangle", numbers(|contact| contact.contact.triangle))?;
    columns.set_item("body", numbers(|contact| contact.body))?;
    let depths: Vec<f64> = contacts.iter().map(|contact| contact.contact.contact.measure.value()).collect();
    columns.set_item("overlap", depths.into_pyarray(py))?;
    let rows = |of: fn(&SphereContact) -> [f64; 3]| {
        let rows: Vec<[f64; 3]> = contacts.iter().map(of).collect();
        rows.into_flattened().into_pyarray(py).reshape([contacts.len(), 3])
    };
    columns.set_item("point", rows(|contact| contact.contact.contact.point)?)?;
    columns.set_item("normal", rows(|contact| contact.contact.contact.normal)?)?;
    Ok(columns)
}

fn element_columns<'py, const D: usize>(
    py: Python<'py>,
    contacts: &[ElementContact<D>],
) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let numbers =
        |of: fn(&ElementContact<D>) -> u32| contacts.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    columns.set_item("i", numbers(|contact| contact.i))?;
    columns.set_item("j", numbers(|contact| contact.j))?;
    let measures: Vec<f64> = contacts.iter().map(|contact| contact.contact.measure.value()).collect();
    columns.set_item("measure", measures.into_pyarray(py))?;
    let rows = |of: fn(&ElementContact<D>) -> [f64; D]| {
        let rows: Vec<[f64; D]> = contacts.iter().map(of).collect();
        rows.into_flattened().into_pyarray(py).reshape([contacts.len(), D])
    };
    columns.set_item("point", rows(|contact| contact.contact.point)?)?;
    columns.set_item("normal", rows(|contact| contact.contact.normal)?)?;
    Ok(columns)
}

fn body_columns<'py, const D: usize>(
    py: Python<'py>,
    contacts: &[BodyContact<D>],
) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let bodies =
        |of: fn(&BodyContact<D>) -> u32| contacts.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    columns.set_item("i", bodies(|contact| contact.bodies[0]))?;
    columns.set_item("j", bodies(|contact| contact.bodies[1]))?;
    let couples: Vec<u64> = contacts.iter().map(|contact| contact.couples).collect();
    columns.set_item("couples", couples.into_pyarray(py))?;
    let sizes = |of: fn(&BodyContact<D>) -> f64| contacts.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
    columns.set_item("overlap", sizes(|contact| contact.overlap))?;
    columns.set_item("shared", sizes(|contact| contact.shared))?;
    let rows = |of: fn(&BodyContact<D>) -> [f64; D]| {
        let rows: Vec<[f64; D]> = contacts.iter().map(of).collect();
        rows.into_flattened().into_pyarray(py).reshape([contacts.len(), D])
    };
    columns.set_item("point", rows(|contact| contact.point)?)?;
    columns.set_item("normal", rows(|contact| contact.normal)?)?;
    Ok(columns)
}
