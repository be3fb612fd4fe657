//! Contacts in `f64`, as the crate `fdem` analyses, draws and writes them.

use std::path::PathBuf;

use fdem::analysis::{Analysis, Options, RadialOptions, analyse as analysed};
use fdem::command::network_file;
use fdem::network::{Couples, Network, PairCutoffs, Sizes, Space};
use fdem::picture::{self, Caption};
use fdem::report::{NetworkReport, html};
use fdem_contact::{Couple, PeriodicCouple};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::elements::{Elements, Set, SetSizes};
use crate::interrupt::{self, Stop};
use crate::number::{Number, rows_of, with_kind};
use crate::problem::Problem;

/// The arrays that a network borrows.
struct Owned<const D: usize> {
    centres: Vec<[f64; D]>,
    sizes: OwnedSizes,
    couples: Couples<D>,
}

enum OwnedSizes {
    Each(Vec<f64>),
    All(f64),
    Cutoff(f64),
    Pairs(PairCutoffs),
}

impl<const D: usize> Owned<D> {
    /// `shifts` are those of the last of the `pairs`.
    fn new<T: Number>(
        set: &Set<'_, T, D>,
        pairs: &[[u32; 2]],
        shifts: &[[i32; D]],
        periodic: bool,
    ) -> Result<Self, Problem> {
        let n = set.points.len();
        if pairs.as_flattened().iter().any(|&element| element as usize >= n) || shifts.len() > pairs.len() {
            return Err(Problem::Arguments("couples of other elements".to_owned()));
        }
        let sizes = match set.sizes {
            SetSizes::Each(radii) => OwnedSizes::Each(radii.iter().map(|radius| radius.to_f64()).collect()),
            SetSizes::All(radius) => OwnedSizes::All(radius.to_f64()),
            SetSizes::Cutoff(cutoff) => OwnedSizes::Cutoff(cutoff.to_f64()),
            SetSizes::Pairs(cutoffs) => OwnedSizes::Pairs(cutoffs.clone()),
            SetSizes::Upper(_) => {
                return Err(Problem::Arguments(
                    "boxes have no centres and radii: only contacts of spheres, discs and points are analysed, drawn and written".to_owned(),
                ));
            }
        };
        let first = pairs.len() - shifts.len();
        let shift = |couple: usize| couple.checked_sub(first).map_or([0; D], |place| shifts[place]);
        let couples = if periodic {
            let couple =
                |(couple, &[i, j]): (usize, &[u32; 2])| PeriodicCouple { i, j, shift: shift(couple) };
            Couples::Periodic(pairs.iter().enumerate().map(couple).collect())
        } else {
            Couples::Plain(pairs.iter().map(|&[i, j]| Couple { i, j }).collect())
        };
        let centres = set.points.iter().map(|point| point.map(T::to_f64)).collect();
        Ok(Self { centres, sizes, couples })
    }

    fn sizes(&self) -> Sizes<'_> {
        match &self.sizes {
            OwnedSizes::Each(radii) => Sizes::Each(radii),
            OwnedSizes::All(radius) => Sizes::All(*radius),
            OwnedSizes::Cutoff(cutoff) => Sizes::Cutoff(*cutoff),
            OwnedSizes::Pairs(cutoffs) => Sizes::Pairs(cutoffs),
        }
    }
}

/// Does `work` on a copy of the network of these contacts, without the interpreter's lock.
fn on_network<T: Number, const D: usize, R: Send + 'static>(
    py: Python<'_>,
    elements: &Elements,
    pairs: &PyReadonlyArray2<'_, u32>,
    shifts: &PyReadonlyArray2<'_, i32>,
    work: impl FnOnce(&Network<'_, D>) -> Result<R, Problem> + Send + 'static,
) -> PyResult<R> {
    let held = elements.hold::<T>(py)?;
    elements.check_unchanged(&held)?;
    let set = held.set::<D>(elements)?;
    let cell = elements.cell::<f64, D>()?;
    let (pairs, shifts) = (rows_of(pairs)?, rows_of(shifts)?);
    let copy = || Owned::new(&set, pairs, shifts, cell.is_some());
    let owned = interrupt::run(py, false, &Stop::default(), copy)?;
    let done = interrupt::leave(py, move || {
        let space = Space { centres: &owned.centres, cell };
        work(&Network { space, sizes: owned.sizes(), couples: &owned.couples, forces: None })
    })?;
    Ok(done?)
}

/// The analysis as JSON; the number of contacts, the cluster, whether it is a rattler, and the void ratio if
/// voids were measured, for each element.
type Analysed<'py> = (
    String,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<bool>>,
    Option<Bound<'py, PyArray1<f64>>>,
);

/// Analyses the network. `inner` has two limits for each axis.
#[pyfunction]
#[pyo3(signature = (elements, pairs, shifts, min_contacts, inner, r_max, bins, voids))]
#[allow(clippy::too_many_arguments, reason = "one for each thing that can be asked for")]
pub(crate) fn analyse<'py>(
    py: Python<'py>,
    elements: &Elements,
    pairs: PyReadonlyArray2<'py, u32>,
    shifts: PyReadonlyArray2<'py, i32>,
    min_contacts: Option<u32>,
    inner: Option<Vec<[f64; 2]>>,
    r_max: Option<f64>,
    bins: Option<usize>,
    voids: bool,
) -> PyResult<Analysed<'py>> {
    let radial = RadialOptions { r_max, bins };
    let (json, contacts, clusters, rattlers, ratios) = with_kind!(elements.kind, T, D => {
        let inner = inner.map(<[[f64; 2]; D]>::try_from).transpose();
        let inner = inner.map_err(|_| Problem::Arguments(format!("inner must have two limits for each of {D} axes")))?;
        let options = Options { min_contacts, inner, radial, voids, threads: 0 };
        on_network::<T, D, _>(py, elements, &pairs, &shifts, move |network| {
            let analysis = analysed(network, &options).map_err(|error| Problem::Arguments(error.to_string()))?;
            let json = serde_json::to_string(&analysis).map_err(|error| Problem::System(error.to_string()))?;
            let Analysis { coordination, clusters, without_rattlers, voids, .. } = analysis;
            let ratios = voids.map(|voids| voids.of_each);
            Ok((json, coordination.of_each, clusters.of_each, without_rattlers.is_rattler, ratios))
        })?
    });
    let ratios = ratios.map(|ratios| ratios.into_pyarray(py));
    Ok((json, contacts.into_pyarray(py), clusters.into_pyarray(py), rattlers.into_pyarray(py), ratios))
}

/// The bytes of a file of couples and elements, in the format given by the end of `name`.
#[pyfunction]
pub(crate) fn file<'py>(
    py: Python<'py>,
    elements: &Elements,
    pairs: PyReadonlyArray2<'py, u32>,
    shifts: PyReadonlyArray2<'py, i32>,
    name: PathBuf,
) -> PyResult<Bound<'py, PyBytes>> {
    let bytes = with_kind!(elements.kind, T, D => {
        on_network::<T, D, _>(py, elements, &pairs, &shifts, move |network| {
            network_file(network, &name).map_err(Problem::Arguments)
        })?
    });
    Ok(PyBytes::new(py, &bytes))
}

/// The bytes of a drawing: "picture" or "plots" in the form "svg" or "png", or the "report", whose form is
/// "html".
#[pyfunction]
#[pyo3(signature = (elements, pairs, shifts, what, form, title, width))]
#[allow(clippy::too_many_arguments, reason = "one for each thing that can be asked for")]
pub(crate) fn draw<'py>(
    py: Python<'py>,
    elements: &Elements,
    pairs: PyReadonlyArray2<'py, u32>,
    shifts: PyReadonlyArray2<'py, i32>,
    what: String,
    form: String,
    title: String,
    width: Option<u32>,
) -> PyResult<Bound<'py, PyBytes>> {
    let bytes = with_kind!(elements.kind, T, D => {
        on_network::<T, D, _>(py, elements, &pairs, &shifts, move |network| {
            let caption = Caption { title: &title, unit: None };
            match (&what[..], &form[..]) {
                ("picture", "svg") => picture::svg(network, &caption).map(String::into_bytes),
                ("picture", "png") => picture::png(network, &caption, width),
                ("plots", "svg") => picture::plots_svg(network, &caption).map(String::into_bytes),
                ("plots", "png") => picture::plots_png(network, &caption, width),
                ("report", "html") => {
                    let report = NetworkReport { network: *network, caption, ids: None, facts: &[] };
                    html(&report).map(String::into_bytes)
                }
                _ => return Err(Problem::Arguments(format!("there is no {what} in the form {form}"))),
            }
            .map_err(|error| Problem::Arguments(error.to_string()))
        })?
    });
    Ok(PyBytes::new(py, &bytes))
}
