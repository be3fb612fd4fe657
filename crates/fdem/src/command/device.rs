//! Where a search or a run is computed: on the processor or on a graphics processor.

use fdem_contact::{Couple, Elements, Error, Simd};
use fdem_results::detection::DeviceSearch;

use crate::command::args::ContactsArguments;
use crate::command::device_name::DeviceName;
use crate::command::failure::Failure;
use crate::command::output::print;

/// A search that keeps its memory from one list of couples to the next.
pub(crate) type KeptSearch<const D: usize> =
    Box<dyn FnMut(&Elements<'_, f64, D>, &mut Vec<Couple>) -> Result<(), Error>>;

/// The device of a search for contacts; `None` for the processor.
pub(crate) fn of(arguments: &ContactsArguments) -> Result<Option<Box<dyn DeviceSearch>>, Failure> {
    let DeviceName::Gpu(number) = arguments.device else { return Ok(None) };
    opened(number).map(Some).map_err(|reason| unusable(&reason))
}

/// Refuses a device that is not there.
pub(crate) fn check(number: usize) -> Result<(), Failure> {
    opened(number).map(drop).map_err(|reason| unusable(&reason))
}

pub(crate) fn unusable(reason: &str) -> Failure {
    Failure::Unusable(format!("--device gpu: {reason}"))
}

/// Refuses options that do not go with a device, and a device that is not there.
pub(crate) fn refuse(arguments: &ContactsArguments) -> Result<(), Failure> {
    if arguments.device == DeviceName::Cpu {
        return Ok(());
    }
    for (option, given) in [
        ("--labels", arguments.labels.labels),
        ("--explain", arguments.explain),
        ("--couples", arguments.couples.couples.is_some()),
        ("more than one file", !arguments.more.is_empty()),
    ] {
        if given {
            return Err(Failure::Unusable(format!("--device gpu does not go with {option}")));
        }
    }
    if !matches!(arguments.engine.engine(), None | Some(fdem_contact::Engine::Rows)) {
        return Err(Failure::Unusable("--device gpu has the engine rows only".to_owned()));
    }
    of(arguments).map(drop)
}

/// `fdem devices`.
pub(crate) fn list() -> Result<(), Failure> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let mut lines = vec![format!("cpu    {processors} processors, {}", Simd::best())];
    match graphics_processors() {
        Ok(found) if found.is_empty() => lines.push("No graphics processor: the driver has none.".to_owned()),
        Ok(found) => lines.extend(found),
        Err(reason) => lines.push(format!("No graphics processor: {reason}.")),
    }
    print(&(lines.join("\n") + "\n"))
}

#[cfg(not(feature = "gpu"))]
mod without {
    use fdem_model::Card;
    use fdem_results::detection::DeviceSearch;
    use fdem_simulation::Simulation;

    use super::KeptSearch;

    const WITHOUT: &str =
        "this fdem is built without graphics processors (cargo install --path crates/fdem --features gpu)";

    pub(super) fn opened(_: usize) -> Result<Box<dyn DeviceSearch>, String> {
        Err(WITHOUT.to_owned())
    }

    pub(crate) fn search<const D: usize>(_: usize) -> Result<KeptSearch<D>, String> {
        Err(WITHOUT.to_owned())
    }

    pub(crate) fn put_on<const D: usize, const N: usize>(
        _: usize,
        _: &mut Simulation<D, N>,
    ) -> Result<(), String> {
        Err(WITHOUT.to_owned())
    }

    pub(crate) fn memory_of<const D: usize, const N: usize>(
        _: &mut Simulation<D, N>,
    ) -> Result<usize, String> {
        Err(WITHOUT.to_owned())
    }

    pub(crate) fn card(_: usize) -> Result<Card, String> {
        Err(WITHOUT.to_owned())
    }

    pub(super) fn graphics_processors() -> Result<Vec<String>, String> {
        Err(WITHOUT.to_owned())
    }
}

#[cfg(not(feature = "gpu"))]
pub(crate) use without::{card, memory_of, put_on, search};
#[cfg(not(feature = "gpu"))]
use without::{graphics_processors, opened};

#[cfg(feature = "gpu")]
mod with {
    use std::sync::Arc;

    use fdem_contact::{Couple, Elements, Search};
    use fdem_gpu::{Cuda, DeviceRows, DeviceSolid, GpuError, devices};
    use fdem_model::{Card, too_little_memory};
    use fdem_results::detection::{DeviceSearch, SearchOfDevice};
    use fdem_simulation::Simulation;

    use super::KeptSearch;
    use crate::command::run::results::Results;

    #[derive(Debug)]
    struct Opened(Arc<Cuda>);

    impl SearchOfDevice for Opened {
        type In<'d, const D: usize> = DeviceRows<'d, Cuda, f64, D>;

        fn search<const D: usize>(&self) -> DeviceRows<'_, Cuda, f64, D> {
            DeviceRows::new(&self.0)
        }
    }

    pub(super) fn opened(number: usize) -> Result<Box<dyn DeviceSearch>, String> {
        match fdem_gpu::opened(number) {
            Ok(device) => Ok(Box::new(Opened(device))),
            Err(error) => Err(error.to_string()),
        }
    }

    /// A search on a device.
    pub(crate) fn search<const D: usize>(number: usize) -> Result<KeptSearch<D>, String> {
        let device = fdem_gpu::opened(number).map_err(|error| error.to_string())?;
        // A device stays open to the end of the program.
        let device: &'static Cuda = Box::leak(Box::new(device));
        let mut search = DeviceRows::<Cuda, f64, D>::new(device);
        let couples = move |elements: &Elements<'_, f64, D>, couples: &mut Vec<Couple>| {
            search.couples(elements, couples)
        };
        Ok(Box::new(couples))
    }

    /// Puts a run on a device. The error of a device with too little memory says how much would fit.
    pub(crate) fn put_on<const D: usize, const N: usize>(
        number: usize,
        run: &mut Simulation<D, N>,
    ) -> Result<(), String>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        let words = |error: GpuError| error.to_string();
        let device = fdem_gpu::opened(number).map_err(words)?;
        let Err(refused) = run.put_on(Box::new(DeviceSolid::new(Arc::clone(&device)))) else { return Ok(()) };
        let (free, elements) = (device.free_memory().map_err(words)?, run.model().mesh.elements.len());
        let needed = memory_of(run)?;
        if needed <= free {
            return Err(refused.to_string());
        }
        Err(too_little_memory(&device.info().name, [needed as f64, free as f64], elements))
    }

    /// The memory of a run on a device, bytes, or why no device computes it.
    pub(crate) fn memory_of<const D: usize, const N: usize>(
        run: &mut Simulation<D, N>,
    ) -> Result<usize, String>
    where
        [[f64; D]; N]: Results<D, N>,
    {
        fdem_gpu::memory_of(run).map_err(|error| error.to_string())
    }

    /// The graphics processor with a number, or why there is none.
    pub(crate) fn card(number: usize) -> Result<Card, String> {
        let found = devices().map_err(|error| error.to_string())?;
        let none = GpuError::NoDevice { number, count: found.len() };
        let card = found.into_iter().nth(number).ok_or_else(|| none.to_string())?;
        Ok(Card { name: card.name, memory: card.memory as f64 })
    }

    pub(super) fn graphics_processors() -> Result<Vec<String>, String> {
        let found = devices().map_err(|error| error.to_string())?;
        let line = |device: &fdem_gpu::DeviceInfo| {
            let memory = device.memory as f64 / f64::from(1 << 30);
            let [major, minor] = [device.architecture / 10, device.architecture % 10];
            format!(
                "gpu:{}  {}, {memory:.1} GiB, compute capability {major}.{minor}",
                device.number, device.name
            )
        };
        Ok(found.iter().map(line).collect())
    }
}

#[cfg(feature = "gpu")]
pub(crate) use with::{card, memory_of, put_on, search};
#[cfg(feature = "gpu")]
use with::{graphics_processors, opened};
