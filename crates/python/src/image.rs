//! Contacts of bodies in labelled images.

use std::sync::atomic::Ordering;

use fdem_contact::image::{ImageContact, ImageContacts, Label, Neighbourhood, Spacing};
use numpy::{Element, IntoPyArray, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::interrupt::{self, Stop};
use crate::problem::Problem;

/// Pixels that are read between two looks at the stop flag.
const SLAB: usize = 1 << 22;

/// The contacts as columns.
#[pyfunction]
pub(crate) fn labels<'py>(
    py: Python<'py>,
    image: &Bound<'py, PyAny>,
    neighbourhood: &str,
    background: Option<i128>,
    spacing: Vec<f64>,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let neighbourhood = match neighbourhood {
        "face" => Neighbourhood::Face,
        "edge" => Neighbourhood::Edge,
        "vertex" => Neighbourhood::Vertex,
        other => {
            let text = format!("there is no neighbourhood '{other}': choose one of face, edge, vertex");
            return Err(Problem::Arguments(text).into());
        }
    };
    macro_rules! try_as {
        ($($number:ty)*) => {$(
            if let Ok(image) = image.extract::<PyReadonlyArrayDyn<'py, $number>>() {
                // A number outside of the range of the labels is the background of none.
                let background = background.and_then(|label| <$number>::try_from(label).ok());
                return match image.shape() {
                    [_, _] => find::<$number, 2>(py, &image, neighbourhood, background, &spacing, threads),
                    [_, _, _] => find::<$number, 3>(py, &image, neighbourhood, background, &spacing, threads),
                    shape => {
                        let text = format!("an image has 2 or 3 axes, not {}", shape.len());
                        Err(Problem::Arguments(text).into())
                    }
                };
            }
        )*};
    }
    try_as!(u8 u16 u32 u64 i32 i64);
    Err(PyTypeError::new_err("labels are whole numbers of 8 to 64 bits"))
}

fn find<'py, L: Label + Element, const D: usize>(
    py: Python<'py>,
    image: &PyReadonlyArrayDyn<'py, L>,
    neighbourhood: Neighbourhood,
    background: Option<L>,
    spacing: &[f64],
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let wrong = |text: &str| PyErr::from(Problem::Arguments(text.to_owned()));
    let shape: [usize; D] = image.shape().try_into().map_err(|_| wrong("the image has other axes"))?;
    let spacing =
        spacing.try_into().map_err(|_| wrong(&format!("spacing has one number for each of {D} axes")))?;
    let spacing = Spacing::<D>::new(spacing).map_err(Problem::from)?;
    let labels = image.as_slice().map_err(|_| wrong("an image must be aligned and in C order"))?;
    let stop = Stop::default();
    let (contacts, bodies) = interrupt::run(py, labels.len() > SLAB, &stop, || {
        let mut image =
            ImageContacts::new(shape, neighbourhood)?.with_background(background).with_threads(threads)?;
        let plane = shape[1..].iter().product::<usize>().max(1);
        for slab in labels.chunks(SLAB.div_ceil(plane) * plane) {
            if stop.load(Ordering::Relaxed) {
                return Err(fdem_contact::Error::Stopped.into());
            }
            image.add(slab)?;
        }
        let bodies = image.labels();
        Ok((image.finish()?, bodies))
    })?;
    let columns = PyDict::new(py);
    let of =
        |k: usize| contacts.iter().map(|contact| contact.labels()[k]).collect::<Vec<L>>().into_pyarray(py);
    columns.set_item("i", of(0))?;
    columns.set_item("j", of(1))?;
    let counts = |count: fn(&ImageContact<L, D>) -> u64| {
        contacts.iter().map(count).collect::<Vec<_>>().into_pyarray(py)
    };
    columns.set_item("faces", counts(ImageContact::faces))?;
    columns.set_item("edges", counts(ImageContact::edges))?;
    columns.set_item("vertices", counts(ImageContact::vertices))?;
    let areas: Vec<f64> = contacts.iter().map(|contact| contact.area(&spacing)).collect();
    columns.set_item("area", areas.into_pyarray(py))?;
    let rows =
        |vectors: Vec<[f64; D]>| vectors.into_flattened().into_pyarray(py).reshape([contacts.len(), D]);
    columns.set_item("point", rows(contacts.iter().map(|contact| contact.centroid(&spacing)).collect())?)?;
    columns.set_item("normal", rows(contacts.iter().map(|contact| contact.normal(&spacing)).collect())?)?;
    columns.set_item("bodies", bodies)?;
    Ok(columns)
}
