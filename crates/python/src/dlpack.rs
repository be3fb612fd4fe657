//! Arrays in the form of `DLPack`: those of others, and those that others take.
//!
//! The layouts are those of `dlpack.h`, version 0.8, with the capsule `dltensor`.

#![allow(unsafe_code, reason = "the interface is structures in C, behind pointers")]

use std::ffi::{CStr, c_void};
use std::ptr::NonNull;

use pyo3::exceptions::{PyBufferError, PyTypeError};
use pyo3::ffi;
use pyo3::prelude::*;

/// `kDLCUDA`.
pub(crate) const CUDA: i32 = 2;

/// Name of a capsule with an array, and its name once somebody has taken the array.
const NAME: &CStr = c"dltensor";
const USED: &CStr = c"used_dltensor";

/// `DLDevice`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct DlDevice {
    kind: i32,
    number: i32,
}

/// `DLDataType`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct DlType {
    /// 0 for `kDLInt`, 1 for `kDLUInt`, 2 for `kDLFloat`.
    code: u8,
    bits: u8,
    lanes: u16,
}

/// `DLTensor`.
#[repr(C)]
#[derive(Debug)]
struct DlTensor {
    data: *mut c_void,
    device: DlDevice,
    axes: i32,
    of: DlType,
    shape: *mut i64,
    strides: *mut i64,
    offset: u64,
}

/// `DLManagedTensor`.
#[repr(C)]
#[derive(Debug)]
struct DlManaged {
    tensor: DlTensor,
    context: *mut c_void,
    deleter: Option<unsafe extern "C" fn(*mut DlManaged)>,
}

/// An array that somebody else has made, which is held until this is dropped.
#[pyclass(frozen, module = "fdem._fdem")]
#[derive(Debug)]
pub(crate) struct Tensor(NonNull<DlManaged>);

// SAFETY: the array is only read, and its deleter may be called by any thread that holds the interpreter's
// lock, as `Drop` does.
unsafe impl Send for Tensor {}
// SAFETY: the same.
unsafe impl Sync for Tensor {}

impl Tensor {
    fn tensor(&self) -> &DlTensor {
        // SAFETY: the capsule had an array, whose deleter has not been called.
        unsafe { &self.0.as_ref().tensor }
    }

    /// The numbers of an array of the structure, one for each axis.
    fn of_axes(&self, numbers: *const i64) -> Vec<i64> {
        let count = usize::try_from(self.tensor().axes).unwrap_or(0);
        if numbers.is_null() || count == 0 {
            return Vec::new();
        }
        // SAFETY: `shape`, and `strides` unless it is null, have a number for each axis.
        unsafe { std::slice::from_raw_parts(numbers, count) }.to_vec()
    }
}

impl Drop for Tensor {
    fn drop(&mut self) {
        Python::attach(|_| {
            // SAFETY: whoever takes the array out of a capsule calls its deleter once.
            unsafe {
                if let Some(deleter) = self.0.as_ref().deleter {
                    deleter(self.0.as_ptr());
                }
            }
        });
    }
}

#[pymethods]
impl Tensor {
    /// Takes the array out of a capsule `dltensor`.
    #[new]
    fn new(capsule: &Bound<'_, PyAny>) -> PyResult<Self> {
        let object = capsule.as_ptr();
        // SAFETY: the object is alive; the name ends with a zero.
        if unsafe { ffi::PyCapsule_IsValid(object, NAME.as_ptr()) } == 0 {
            return Err(PyTypeError::new_err(
                "__dlpack__ must return a capsule \"dltensor\" that nobody has used",
            ));
        }
        // SAFETY: it is a capsule with this name.
        let managed = unsafe { ffi::PyCapsule_GetPointer(object, NAME.as_ptr()) };
        let managed =
            NonNull::new(managed.cast()).ok_or_else(|| PyTypeError::new_err("the capsule is empty"))?;
        // SAFETY: the name is static. From here on the capsule no longer frees the array.
        if unsafe { ffi::PyCapsule_SetName(object, USED.as_ptr()) } != 0 {
            return Err(PyErr::fetch(capsule.py()));
        }
        Ok(Self(managed))
    }

    /// Address of the first number.
    #[getter]
    fn address(&self) -> u64 {
        (self.tensor().data as u64).wrapping_add(self.tensor().offset)
    }

    /// Kind and number of the device.
    #[getter]
    fn device(&self) -> [i32; 2] {
        [self.tensor().device.kind, self.tensor().device.number]
    }

    /// Type as in the interface of NumPy, such as "<f8"; of others "?".
    #[getter]
    fn typestr(&self) -> String {
        let DlType { code, bits, lanes } = self.tensor().of;
        let code = match code {
            0 => 'i',
            1 => 'u',
            2 => 'f',
            _ => return "?".to_owned(),
        };
        if lanes == 1 { format!("<{code}{}", bits / 8) } else { "?".to_owned() }
    }

    /// Numbers along each axis.
    #[getter]
    fn shape(&self) -> Vec<i64> {
        self.of_axes(self.tensor().shape)
    }

    /// Steps along each axis, in numbers; none of an array in C order.
    #[getter]
    fn strides(&self) -> Option<Vec<i64>> {
        (!self.tensor().strides.is_null()).then(|| self.of_axes(self.tensor().strides))
    }
}

/// An array `[rows, 2]` of whole numbers of 32 bits that somebody else takes, and the owner of its memory.
struct Given<K> {
    managed: DlManaged,
    shape: [i64; 2],
    _keeper: K,
}

/// A capsule with an array `[rows, 2]` of whole numbers of 32 bits at an address of the graphics processor
/// with a number. `keeper` is dropped when nobody uses the array any more.
pub(crate) fn capsule<K: Send + 'static>(
    py: Python<'_>,
    (address, rows): (u64, usize),
    number: usize,
    keeper: K,
) -> PyResult<Py<PyAny>> {
    let number = i32::try_from(number).map_err(|_| PyBufferError::new_err("no such device"))?;
    let given = Box::new(Given {
        managed: DlManaged {
            tensor: DlTensor {
                data: address as *mut c_void,
                device: DlDevice { kind: CUDA, number },
                axes: 2,
                of: DlType { code: 0, bits: 32, lanes: 1 },
                shape: std::ptr::null_mut(),
                strides: std::ptr::null_mut(),
                offset: 0,
            },
            context: std::ptr::null_mut(),
            deleter: Some(delete::<K>),
        },
        shape: [rows.cast_signed() as i64, 2],
        _keeper: keeper,
    });
    let given = Box::into_raw(given);
    // SAFETY: the box has just been made, and nobody else has it.
    let managed = unsafe {
        (*given).managed.tensor.shape = (&raw mut (*given).shape).cast();
        (*given).managed.context = given.cast();
        &raw mut (*given).managed
    };
    // SAFETY: the pointer is not null, the name is static, and the destructor takes such a capsule.
    let object = unsafe { ffi::PyCapsule_New(managed.cast(), NAME.as_ptr(), Some(free)) };
    // SAFETY: it is a new reference, or null with an exception.
    unsafe { Bound::from_owned_ptr_or_err(py, object) }.map(Bound::unbind).inspect_err(|_| {
        // SAFETY: there is no capsule that would free it.
        unsafe { delete::<K>(managed) }
    })
}

/// Frees an array that [`capsule`] has given.
unsafe extern "C" fn delete<K>(managed: *mut DlManaged) {
    // SAFETY: `capsule` has put the box of this type there, and each is deleted once.
    drop(unsafe { Box::from_raw((*managed).context.cast::<Given<K>>()) });
}

/// Frees the array of a capsule that nobody has taken.
unsafe extern "C" fn free(object: *mut ffi::PyObject) {
    // SAFETY: it is a capsule, whose name says whether its array has been taken; then it is not ours.
    unsafe {
        if ffi::PyCapsule_IsValid(object, NAME.as_ptr()) == 0 {
            return;
        }
        let managed: *mut DlManaged = ffi::PyCapsule_GetPointer(object, NAME.as_ptr()).cast();
        if let Some(deleter) = managed.as_ref().and_then(|managed| managed.deleter) {
            deleter(managed);
        }
    }
}

/// A capsule with numbers of the processor, for the tests: rows of two whole numbers of 32 bits, which it
/// says are those of graphics processor 0.
#[pyfunction]
pub(crate) fn dlpack_of_rows(py: Python<'_>, rows: Vec<[i32; 2]>) -> PyResult<Py<PyAny>> {
    capsule(py, (rows.as_ptr() as u64, rows.len()), 0, rows)
}
