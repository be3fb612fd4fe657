//! Graphics processors of NVIDIA, by the driver's interface.

#![allow(unsafe_code, reason = "the driver is a library in C")]

use std::ffi::{CString, c_void};
use std::sync::{Arc, Mutex, PoisonError};

use cudarc::driver::result::{self, DriverError};
use cudarc::driver::sys;
use cudarc::nvrtc::{CompileError, CompileOptions, compile_ptx_with_opts};

use crate::device::Device;
use crate::error::GpuError;
use crate::kernels::{Kernel, THREADS, source};

/// A device that the driver has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Number of the device.
    pub number: usize,
    /// Name of the device, such as "NVIDIA H200".
    pub name: String,
    /// Memory of the device, bytes.
    pub memory: usize,
    /// Architecture as the compiler has it: 90 for compute capability 9.0.
    pub architecture: u32,
}

/// The devices that the driver has.
///
/// # Errors
/// [`GpuError::NoDriver`], [`GpuError::Driver`].
pub fn devices() -> Result<Vec<DeviceInfo>, GpuError> {
    (0..device_count()?).map(info).collect()
}

/// The device with a number. Each is opened once in a process: its kernels take seconds to compile.
///
/// # Errors
/// The errors of [`Cuda::new`].
pub fn opened(number: usize) -> Result<Arc<Cuda>, GpuError> {
    static DEVICES: Mutex<Vec<Arc<Cuda>>> = Mutex::new(Vec::new());
    let mut devices = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(device) = devices.iter().find(|device| device.info.number == number) {
        return Ok(Arc::clone(device));
    }
    let device = Arc::new(Cuda::new(number)?);
    devices.push(Arc::clone(&device));
    Ok(device)
}

/// A graphics processor.
#[derive(Debug)]
pub struct Cuda {
    info: DeviceInfo,
    device: sys::CUdevice,
    context: sys::CUcontext,
    module: sys::CUmodule,
    /// In the order of [`Kernel::ALL`].
    functions: Vec<sys::CUfunction>,
}

impl Cuda {
    /// Takes a device by its number, and compiles the kernels for it: some seconds.
    ///
    /// # Errors
    /// [`GpuError::NoDriver`], [`GpuError::NoDevice`], [`GpuError::NoCompiler`], [`GpuError::Compiler`],
    /// [`GpuError::OldDriver`], [`GpuError::Driver`].
    pub fn new(number: usize) -> Result<Self, GpuError> {
        let count = device_count()?;
        if number >= count {
            return Err(GpuError::NoDevice { number, count });
        }
        let info = info(number)?;
        let text = text_for_c(kernels_for(info.architecture, SHIPPED)?)?;
        let device = device(number)?;
        // SAFETY: the driver has given the device. `drop` releases the context.
        let context =
            unsafe { result::primary_ctx::retain(device) }.map_err(driver("cuDevicePrimaryCtxRetain"))?;
        let mut this = Self { info, device, context, module: std::ptr::null_mut(), functions: Vec::new() };
        this.enter()?;
        // SAFETY: the text ends with a zero.
        this.module = unsafe { result::module::load_data(text.as_ptr().cast()) }.map_err(|error| {
            if error.0 == sys::CUresult::CUDA_ERROR_UNSUPPORTED_PTX_VERSION {
                GpuError::OldDriver
            } else {
                driver("cuModuleLoadData")(error)
            }
        })?;
        for kernel in Kernel::ALL {
            let name = text_for_c(kernel.name())?;
            // SAFETY: the module is loaded.
            let function = unsafe { result::module::get_function(this.module, name) };
            this.functions.push(function.map_err(driver("cuModuleGetFunction"))?);
        }
        Ok(this)
    }

    /// Name and size of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Waits until all work on the device is done, that of other libraries of this process, too.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    pub fn synchronize(&self) -> Result<(), GpuError> {
        self.enter()?;
        result::ctx::synchronize().map_err(driver("cuCtxSynchronize"))
    }

    /// Refuses an address at which the device has no memory of this size.
    ///
    /// # Errors
    /// [`GpuError::Elsewhere`], [`GpuError::ShortMemory`]. `what`: the numbers that are there.
    pub fn check_address(&self, what: &'static str, address: u64, bytes: usize) -> Result<(), GpuError> {
        use sys::CUpointer_attribute_enum::{
            CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL as ORDINAL, CU_POINTER_ATTRIBUTE_MEMORY_TYPE as KIND,
            CU_POINTER_ATTRIBUTE_RANGE_SIZE as SIZE, CU_POINTER_ATTRIBUTE_RANGE_START_ADDR as START,
        };
        self.enter()?;
        let elsewhere = GpuError::Elsewhere { what, number: self.info.number };
        let attribute = |of| {
            let mut value = 0_u64;
            // SAFETY: each of these attributes has at most eight bytes. An address that the driver does not
            // know is an error.
            let done = unsafe { sys::cuPointerGetAttribute((&raw mut value).cast(), of, address) };
            if done == sys::CUresult::CUDA_SUCCESS { Some(value) } else { None }
        };
        let is_here = attribute(KIND) == Some(sys::CUmemorytype_enum::CU_MEMORYTYPE_DEVICE as u64)
            && attribute(ORDINAL) == Some(self.info.number as u64);
        let (true, Some(start), Some(size)) = (is_here, attribute(START), attribute(SIZE)) else {
            return Err(elsewhere);
        };
        let room = (start + size).saturating_sub(address) as usize;
        if room < bytes {
            return Err(GpuError::ShortMemory { what, bytes: room, needed: bytes });
        }
        Ok(())
    }

    /// Memory of the device that is free now, bytes.
    ///
    /// # Errors
    /// [`GpuError::Driver`].
    pub fn free_memory(&self) -> Result<usize, GpuError> {
        self.enter()?;
        Ok(result::mem_get_info().map_err(driver("cuMemGetInfo"))?.0)
    }

    /// Memory of the device that somebody else has taken, such as an array of another library, to be searched
    /// where it is. It is not freed when this is dropped.
    ///
    /// # Safety
    /// The memory at `address` has these bytes in the primary context of the device, is there until this is
    /// dropped, and nobody writes to it while a kernel reads it. All writes to it are done: kernels run in
    /// the default stream.
    pub unsafe fn borrow(&self, address: u64, bytes: usize) -> CudaMemory {
        CudaMemory { pointer: address, bytes, context: self.context, is_borrowed: true }
    }

    /// Makes the context of the device that of this thread.
    fn enter(&self) -> Result<(), GpuError> {
        // SAFETY: the context is retained until this is dropped.
        unsafe { result::ctx::set_current(self.context) }.map_err(driver("cuCtxSetCurrent"))
    }
}

// SAFETY: the driver's handles may be used by all threads, each of which enters the context before.
unsafe impl Send for Cuda {}
// SAFETY: the same.
unsafe impl Sync for Cuda {}

impl Drop for Cuda {
    fn drop(&mut self) {
        // SAFETY: `new` has retained the context.
        let _ = unsafe { result::primary_ctx::release(self.device) };
    }
}

/// Memory of a device.
#[derive(Debug)]
pub struct CudaMemory {
    pointer: sys::CUdeviceptr,
    bytes: usize,
    context: sys::CUcontext,
    /// Whether it is somebody else's, and not freed.
    is_borrowed: bool,
}

// SAFETY: all threads may use and release memory of a context, which they enter before.
unsafe impl Send for CudaMemory {}
// SAFETY: a shared reference gives its address and size only, which do not change.
unsafe impl Sync for CudaMemory {}

impl Drop for CudaMemory {
    fn drop(&mut self) {
        if self.is_borrowed {
            return;
        }
        // SAFETY: `allocate` has taken the memory, and kernels that use it are done before it is free. If the
        // context is gone, the driver says so.
        let _ =
            unsafe { result::ctx::set_current(self.context).and_then(|()| result::free_sync(self.pointer)) };
    }
}

impl Device for Cuda {
    type Memory = CudaMemory;

    fn allocate(&self, bytes: usize) -> Result<CudaMemory, GpuError> {
        self.enter()?;
        // SAFETY: every array is written before it is read, as on the host, where tests see to it.
        let pointer = unsafe { result::malloc_sync(bytes) }.map_err(|error| {
            if error.0 == sys::CUresult::CUDA_ERROR_OUT_OF_MEMORY {
                GpuError::OutOfMemory { bytes }
            } else {
                driver("cuMemAlloc")(error)
            }
        })?;
        Ok(CudaMemory { pointer, bytes, context: self.context, is_borrowed: false })
    }

    fn address(&self, memory: &CudaMemory) -> u64 {
        memory.pointer
    }

    fn bytes(&self, memory: &CudaMemory) -> usize {
        memory.bytes
    }

    fn write(&self, to: &mut CudaMemory, bytes: &[u8]) -> Result<(), GpuError> {
        assert!(bytes.len() <= to.bytes, "the memory is long enough");
        self.enter()?;
        // SAFETY: the memory has these bytes.
        unsafe { result::memcpy_htod_sync(to.pointer, bytes) }.map_err(driver("cuMemcpyHtoD"))
    }

    fn read(&self, from: &CudaMemory, offset: usize, bytes: &mut [u8]) -> Result<(), GpuError> {
        assert!(offset + bytes.len() <= from.bytes, "the memory has these bytes");
        self.enter()?;
        // SAFETY: the memory has these bytes. The copy waits for the kernels before, which run in its stream.
        unsafe { result::memcpy_dtoh_sync(bytes, from.pointer + offset as u64) }
            .map_err(driver("cuMemcpyDtoH"))
    }

    fn launch(&self, kernel: Kernel, blocks: u32, arguments: &[u64]) -> Result<(), GpuError> {
        if blocks == 0 {
            return Ok(());
        }
        self.enter()?;
        // The driver reads the structure, and does not change it.
        let mut parameters = [arguments.as_ptr().cast_mut().cast::<c_void>()];
        let function = self.functions[kernel as usize];
        let null = std::ptr::null_mut();
        // SAFETY: callers of this crate give each kernel its one argument, whose addresses are those of
        // arrays that they hold until the kernel is done.
        unsafe {
            result::launch_kernel(function, (blocks, 1, 1), (THREADS as u32, 1, 1), 0, null, &mut parameters)
        }
        .map_err(driver(kernel.name()))
    }
}

/// Compiled kernels that a release ships for machines without a compiler; empty in other builds. See
/// `build.rs`.
const SHIPPED: &str = include_str!(concat!(env!("OUT_DIR"), "/kernels.ptx"));

/// The oldest architecture with which kernels are compiled. The driver compiles them further for any later
/// one.
const OLDEST: u32 = 70;

/// The kernels in PTX: compiled, or else those that are shipped.
fn kernels_for(architecture: u32, shipped: &str) -> Result<String, GpuError> {
    match compile(architecture, false) {
        // Those of other kernels would read other arguments.
        Err(GpuError::NoCompiler) if shipped.starts_with(&shipped_title()) => Ok(shipped.to_owned()),
        done => done,
    }
}

/// The first line of kernels that are shipped, with a hash of their text (FNV-1a).
fn shipped_title() -> String {
    let hash = source().bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("// Kernels of fdem {} {hash:016x}\n", env!("CARGO_PKG_VERSION"))
}

/// Compiles the kernels into PTX for a release to ship: for all cards, the example `ptx` writes it.
///
/// # Errors
/// [`GpuError::NoCompiler`], [`GpuError::Compiler`].
pub fn compile_to_ship() -> Result<String, GpuError> {
    Ok(shipped_title() + &compile(OLDEST, false)?)
}

/// Whether this build has compiled kernels for machines without a compiler.
pub fn has_shipped_kernels() -> bool {
    SHIPPED.starts_with(&shipped_title())
}

/// Compiles the kernels into PTX for an architecture, 90 for compute capability 9.0. `contracted`: whether a
/// product and a sum may round once, as nothing but a test asks for.
///
/// # Errors
/// [`GpuError::NoCompiler`], [`GpuError::Compiler`].
pub fn compile(architecture: u32, contracted: bool) -> Result<String, GpuError> {
    // SAFETY: loading the library runs its initialisers only.
    if !unsafe { cudarc::nvrtc::sys::is_culib_present() } {
        return Err(GpuError::NoCompiler);
    }
    let options = CompileOptions {
        fmad: Some(contracted),
        prec_div: Some(true),
        prec_sqrt: Some(true),
        ftz: Some(false),
        options: vec![format!("--gpu-architecture=compute_{architecture}"), "--std=c++17".to_owned()],
        ..CompileOptions::default()
    };
    let text = compile_ptx_with_opts(source(), options).map_err(|error| {
        let message = match error {
            CompileError::CompileError { log, .. } => log.to_string_lossy().into_owned(),
            other => format!("{other:?}"),
        };
        GpuError::Compiler { message }
    })?;
    Ok(text.to_src())
}

fn device_count() -> Result<usize, GpuError> {
    // cudarc panics without the library.
    // SAFETY: loading the library runs its initialisers only.
    if !unsafe { sys::is_culib_present() } {
        return Err(GpuError::NoDriver);
    }
    match result::init() {
        Err(error) if error.0 == sys::CUresult::CUDA_ERROR_NO_DEVICE => return Ok(0),
        done => done.map_err(driver("cuInit"))?,
    }
    Ok(result::device::get_count().map_err(driver("cuDeviceGetCount"))? as usize)
}

/// A text that ends with a zero.
fn text_for_c(text: impl Into<Vec<u8>>) -> Result<CString, GpuError> {
    CString::new(text).map_err(|error| GpuError::Compiler { message: error.to_string() })
}

/// The driver's device with a number, which it has.
fn device(number: usize) -> Result<sys::CUdevice, GpuError> {
    let number = i32::try_from(number).unwrap_or(i32::MAX);
    result::device::get(number).map_err(driver("cuDeviceGet"))
}

fn info(number: usize) -> Result<DeviceInfo, GpuError> {
    use sys::CUdevice_attribute_enum::{
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR as MAJOR,
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR as MINOR,
    };
    let device = device(number)?;
    let name = result::device::get_name(device).map_err(driver("cuDeviceGetName"))?;
    // SAFETY: the driver has given the device.
    let (memory, [major, minor]) = unsafe {
        let memory = result::device::total_mem(device).map_err(driver("cuDeviceTotalMem"))?;
        let attribute =
            |of| result::device::get_attribute(device, of).map_err(driver("cuDeviceGetAttribute"));
        (memory, [attribute(MAJOR)?, attribute(MINOR)?])
    };
    Ok(DeviceInfo { number, name, memory, architecture: (10 * major + minor) as u32 })
}

/// The error of a call of the driver.
fn driver(call: &'static str) -> impl Fn(DriverError) -> GpuError {
    move |error| {
        let words = error.error_string().map(|words| words.to_string_lossy().into_owned());
        GpuError::Driver { call, message: words.unwrap_or_else(|_| format!("{:?}", error.0)) }
    }
}
