//! The errors of this crate.

use fdem_contact::Error;

/// The reason why a device computes nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// The driver of the graphics processor cannot be loaded.
    #[error("there is no driver of NVIDIA: the library libcuda cannot be loaded")]
    NoDriver,
    /// The compiler of kernels cannot be loaded.
    #[error(
        "there is no compiler of kernels: the library libnvrtc cannot be loaded (Python has it in the package nvidia-cuda-nvrtc-cu12)"
    )]
    NoCompiler,
    /// The driver is older than the compiler of kernels.
    #[error("the driver is older than libnvrtc: install a newer driver, or an older libnvrtc 12")]
    OldDriver,
    /// There is no device with this number.
    #[error("there is no device {number}: the driver has {count}")]
    NoDevice {
        /// The number asked for.
        number: usize,
        /// Number of devices that the driver has.
        count: usize,
    },
    /// The device has too little memory.
    #[error("the device cannot give {bytes} bytes of memory")]
    OutOfMemory {
        /// The bytes asked for.
        bytes: usize,
    },
    /// The kernels cannot be compiled.
    #[error("the kernels cannot be compiled: {message}")]
    Compiler {
        /// The compiler's words.
        message: String,
    },
    /// The driver reports an error.
    #[error("the driver reports an error ({call}): {message}")]
    Driver {
        /// Name of the call.
        call: &'static str,
        /// Words of the driver.
        message: String,
    },
    /// Memory of the device that was given is too short for the elements.
    #[error("the memory for {what} has {bytes} bytes, and {needed} are needed")]
    ShortMemory {
        /// Points or radii.
        what: &'static str,
        /// The bytes that it has.
        bytes: usize,
        /// The bytes that the elements have.
        needed: usize,
    },
    /// An address at which the device has no memory.
    #[error("the {what} are not in the memory of device {number}")]
    Elsewhere {
        /// Points or radii.
        what: &'static str,
        /// The number of the device.
        number: usize,
    },
    /// The device does not search this.
    #[error("a device does not search {what}")]
    Unsupported {
        /// Elements or dimensions.
        what: &'static str,
    },
}

impl From<GpuError> for Error {
    fn from(error: GpuError) -> Self {
        Self::Device { message: error.to_string() }
    }
}
