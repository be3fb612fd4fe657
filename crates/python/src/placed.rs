//! Searches over arrays that are on a graphics processor, and couples that stay there.

use pyo3::prelude::*;

#[cfg(feature = "gpu")]
pub(crate) use with::{DeviceCouples, contacts_on_device};
#[cfg(not(feature = "gpu"))]
pub(crate) use without::contacts_on_device;

/// Elements on a graphics processor.
#[derive(Clone, Copy, Debug, FromPyObject)]
#[pyo3(from_item_all)]
#[cfg_attr(not(feature = "gpu"), allow(dead_code, reason = "only a device reads them"))]
pub(crate) struct PlacedArgument {
    /// Number of the graphics processor.
    device: usize,
    count: usize,
    dimensions: usize,
    /// Whether their numbers have 64 bits, and not 32.
    is_double: bool,
    /// Address of the centres.
    points: u64,
    /// Address of the radii; none for one radius.
    radii: Option<u64>,
    radius: f64,
    tolerance: f64,
}

#[cfg(not(feature = "gpu"))]
mod without {
    use pyo3::prelude::*;

    use super::PlacedArgument;
    use crate::problem::Problem;

    /// The package is built without graphics processors.
    #[pyfunction]
    pub(crate) fn contacts_on_device(elements: PlacedArgument, waits: bool) -> PyResult<()> {
        let _ = (elements, waits);
        let why = "device: this package is built without graphics processors";
        Err(Problem::System(why.to_owned()).into())
    }
}

#[cfg(feature = "gpu")]
mod with {
    #![allow(unsafe_code, reason = "memory of other libraries is known by its address")]

    use std::sync::Arc;

    use fdem_gpu::{Cuda, CudaMemory, Device, DeviceRows, GpuError, PlacedElements, PlacedRadii};
    use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
    use pyo3::exceptions::PyBufferError;
    use pyo3::prelude::*;
    use pyo3::types::PyDict;

    use super::PlacedArgument;
    use crate::dlpack;
    use crate::interrupt::{self, Stop};
    use crate::number::Number;
    use crate::problem::{Problem, zeros};

    /// Couples in the memory of a graphics processor: rows of two whole numbers of 32 bits, the smaller one
    /// first.
    #[pyclass(frozen, module = "fdem._fdem")]
    #[derive(Debug)]
    pub(crate) struct DeviceCouples {
        device: Arc<Cuda>,
        memory: Option<Arc<CudaMemory>>,
        count: usize,
    }

    impl DeviceCouples {
        /// Where the couples are; 0 if there are none.
        fn address(&self) -> u64 {
            let memory = self.memory.as_ref().filter(|_| self.count > 0);
            memory.map_or(0, |memory| self.device.address(memory))
        }
    }

    #[pymethods]
    impl DeviceCouples {
        fn __len__(&self) -> usize {
            self.count
        }

        /// Number of the graphics processor.
        #[getter]
        fn device(&self) -> usize {
            self.device.info().number
        }

        #[getter]
        fn __cuda_array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
            let interface = PyDict::new(py);
            interface.set_item("shape", (self.count, 2))?;
            interface.set_item("typestr", "<i4")?;
            interface.set_item("data", (self.address(), false))?;
            interface.set_item("strides", py.None())?;
            interface.set_item("version", 3)?;
            // All work was done before these couples were returned.
            interface.set_item("stream", py.None())?;
            Ok(interface)
        }

        fn __dlpack_device__(&self) -> (i32, usize) {
            (dlpack::CUDA, self.device())
        }

        #[pyo3(signature = (*, stream=None, max_version=None, dl_device=None, copy=None))]
        fn __dlpack__(
            &self,
            py: Python<'_>,
            stream: Option<i64>,
            max_version: Option<(u32, u32)>,
            dl_device: Option<(i32, usize)>,
            copy: Option<bool>,
        ) -> PyResult<Py<PyAny>> {
            // The couples are ready for any stream, and every consumer takes the first version.
            let _ = (stream, max_version);
            if copy == Some(true) {
                return Err(PyBufferError::new_err(
                    "these couples are not copied: copy the array that you make of them",
                ));
            }
            if dl_device.is_some_and(|device| device != self.__dlpack_device__()) {
                return Err(PyBufferError::new_err(format!("these couples are on gpu:{}", self.device())));
            }
            dlpack::capsule(py, (self.address(), self.count), self.device(), self.memory.clone())
        }

        /// Copies the couples from the device.
        fn numpy<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
            let mut couples = zeros::<i32>(2 * self.count)?;
            if let Some(memory) = self.memory.as_ref().filter(|_| self.count > 0) {
                let read = self.device.read(memory, 0, bytemuck::cast_slice_mut(&mut couples));
                read.map_err(problem)?;
            }
            couples.into_pyarray(py).reshape([self.count, 2])
        }
    }

    /// All couples of elements that are on a graphics processor. `waits`: whether work on it may still write
    /// to their arrays.
    #[pyfunction]
    pub(crate) fn contacts_on_device(
        py: Python<'_>,
        elements: PlacedArgument,
        waits: bool,
    ) -> PyResult<DeviceCouples> {
        let PlacedArgument { device: number, dimensions, is_double, .. } = elements;
        // A search cannot be stopped midway; it takes less than a second.
        interrupt::run(py, true, &Stop::default(), || {
            let device = fdem_gpu::opened(number).map_err(problem)?;
            if waits {
                device.synchronize().map_err(problem)?;
            }
            let (memory, count) = match (is_double, dimensions) {
                (true, 2) => find::<f64, 2>(&device, elements),
                (true, _) => find::<f64, 3>(&device, elements),
                (false, 2) => find::<f32, 2>(&device, elements),
                (false, _) => find::<f32, 3>(&device, elements),
            }?;
            // Whoever takes the couples need not wait.
            device.synchronize().map_err(problem)?;
            Ok(DeviceCouples { device, memory: memory.map(Arc::new), count })
        })
    }

    /// The memory of the couples, and their number.
    fn find<T: Number, const D: usize>(
        device: &Arc<Cuda>,
        PlacedArgument { count, points, radii, radius, tolerance, .. }: PlacedArgument,
    ) -> Result<(Option<CudaMemory>, usize), Problem> {
        let borrow = |what, address, numbers: Option<usize>| {
            let bytes = numbers.and_then(|numbers| numbers.checked_mul(size_of::<T>())).unwrap_or(usize::MAX);
            if count > 0 {
                device.check_address(what, address, bytes).map_err(problem)?;
            }
            // SAFETY: the driver has memory of this size there, the caller holds the arrays during the
            // search, and work that writes to them is done.
            Ok::<_, Problem>(unsafe { device.borrow(address, bytes) })
        };
        let points = borrow("points", points, count.checked_mul(D))?;
        let each = radii.map(|radii| borrow("radii", radii, Some(count))).transpose()?;
        let elements = PlacedElements {
            count,
            points: &points,
            radii: each.as_ref().map_or_else(|| PlacedRadii::One(T::nearest(radius)), PlacedRadii::Each),
            tolerance: T::nearest(tolerance),
        };
        let mut search = DeviceRows::<_, T, D>::new(&**device);
        let found = search.find_placed(&elements)?.len();
        Ok((search.into_couples(), found))
    }

    fn problem(error: GpuError) -> Problem {
        Problem::System(format!("device: {error}"))
    }
}
