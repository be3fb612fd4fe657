//! Where a search or a run is computed: on the processor or on a graphics processor.

use fdem_contact::Simd;
use fdem_results::detection::DeviceSearch;

use crate::command::args::ContactsArguments;
use crate::command::device_name::DeviceName;
use crate::command::failure::Failure;
use crate::command::output::print;

/// The device of a search for contacts; `None` for the processor.
pub(crate) fn of(arguments: &ContactsArguments) -> Result<Option<Box<dyn DeviceSearch>>, Failure> {
    let DeviceName::Gpu(number) = arguments.device else { return Ok(None) };
    opened(number).map(Some).map_err(|reason| unusable(&reason))
}

/// Refuses a device that is not there.
pub(crate) fn check(number: usize) -> Result<(), Failure> {
    opened(number).map(drop).map_err(|reason| unusable(&reason))
}

fn unusable(reason: &str) -> Failure {
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
    use fdem_results::detection::DeviceSearch;
    use fdem_simulation::Accelerator;

    const WITHOUT: &str =
        "this fdem is built without graphics processors (cargo install --path crates/fdem --features gpu)";

    pub(super) fn opened(_: usize) -> Result<Box<dyn DeviceSearch>, String> {
        Err(WITHOUT.to_owned())
    }

    pub(crate) fn accelerator<const D: usize, const N: usize>(
        _: usize,
    ) -> Result<Box<dyn Accelerator<D, N>>, String> {
        Err(WITHOUT.to_owned())
    }

    pub(super) fn graphics_processors() -> Result<Vec<String>, String> {
        Err(WITHOUT.to_owned())
    }
}

#[cfg(not(feature = "gpu"))]
pub(crate) use without::accelerator;
#[cfg(not(feature = "gpu"))]
use without::{graphics_processors, opened};

#[cfg(feature = "gpu")]
mod with {
    use std::sync::Arc;

    use fdem_gpu::{Cuda, DeviceRows, DeviceSolid, devices};
    use fdem_results::detection::{DeviceSearch, SearchOfDevice};
    use fdem_simulation::Accelerator;

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

    /// A device for the phases of a run.
    pub(crate) fn accelerator<const D: usize, const N: usize>(
        number: usize,
    ) -> Result<Box<dyn Accelerator<D, N>>, String> {
        let device = fdem_gpu::opened(number).map_err(|error| error.to_string())?;
        Ok(Box::new(DeviceSolid::new(device)))
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
pub(crate) use with::accelerator;
#[cfg(feature = "gpu")]
use with::{graphics_processors, opened};
