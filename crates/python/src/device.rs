//! Searches on graphics processors.

use fdem::DeviceName;
use fdem_contact::PeriodicBox;

use crate::elements::Set;
use crate::interrupt::Stop;
use crate::number::Number;
use crate::problem::Problem;
use crate::shifted::ShiftedCouples;

/// The number of the graphics processor with this name; `None` for the processor. `engine`: the one that is
/// asked for.
pub(crate) fn device_of(name: &str, engine: &str) -> Result<Option<usize>, Problem> {
    let wrong = |help: String| Problem::Arguments(format!("there is no device '{name}': {help}"));
    let DeviceName::Gpu(number) = name.parse().map_err(wrong)? else { return Ok(None) };
    if engine != "auto" && engine != "rows" {
        return Err(Problem::Arguments(format!("a device has the engine rows only, not {engine}")));
    }
    Ok(Some(number))
}

/// The couples that a graphics processor finds.
#[cfg(feature = "gpu")]
pub(crate) fn search_on<T: Number, const D: usize>(
    number: usize,
    set: Set<'_, T, D>,
    cell: Option<&PeriodicBox<T, D>>,
    threads: usize,
    stop: &Stop,
) -> Result<ShiftedCouples<D>, Problem> {
    use fdem_contact::{PeriodicSearch, Search};

    let elements = set.checked()?;
    let device = fdem_gpu::opened(number).map_err(|error| Problem::System(format!("device: {error}")))?;
    let mut search = fdem_gpu::DeviceRows::new(&*device);
    let Some(cell) = cell else {
        let mut couples = Vec::new();
        search.couples(&elements, &mut couples)?;
        return Ok((couples, Vec::new()));
    };
    let mut images = PeriodicSearch::new().with_threads(threads)?.stopped_by(stop.clone());
    let mut couples = Vec::new();
    images.couples_by(&mut search, &elements, cell, &mut couples)?;
    crate::shifted::by_shift(couples)
}

/// The package is built without graphics processors.
#[cfg(not(feature = "gpu"))]
pub(crate) fn search_on<T: Number, const D: usize>(
    _: usize,
    _: Set<'_, T, D>,
    _: Option<&PeriodicBox<T, D>>,
    _: usize,
    _: &Stop,
) -> Result<ShiftedCouples<D>, Problem> {
    Err(Problem::System("device: this package is built without graphics processors".to_owned()))
}
