"""Contacts of spheres and points whose arrays are on a graphics processor."""

from __future__ import annotations

from typing import Any, NamedTuple, Optional

import numpy as np
import numpy.typing as npt

from . import _fdem
from ._input import is_number, number

_KINDS = {2: "CUDA", 1: "the processor", 3: "pinned memory of the processor", 10: "ROCm", 13: "managed memory of CUDA", 14: "oneAPI"}
"""Kinds of devices as DLPack numbers them."""

_CUDA = 2


class Placed(NamedTuple):
    """An array that is on a graphics processor."""

    address: int
    """Where its numbers are; 0 if there are none."""
    shape: tuple[int, ...]
    dtype: str
    """"float32" or "float64"."""
    device: Optional[int]
    """The number of the device, if the array says it."""
    waits: bool
    """Whether work that writes to it may not be done."""
    owner: Any
    """The object that keeps its memory."""


def placed(value: Any, name: str) -> Placed:
    """An array by the interface of DLPack or of CUDA; exceptions name the argument."""
    if hasattr(value, "__dlpack_device__") and hasattr(value, "__dlpack__"):
        return _by_dlpack(value, name)
    if hasattr(value, "__cuda_array_interface__"):
        return _by_interface(value.__cuda_array_interface__, value, name)
    raise TypeError(f"{name} must be an array on a graphics processor, with __dlpack__ or __cuda_array_interface__, not {type(value).__name__}")


def _by_dlpack(value: Any, name: str) -> Placed:
    kind, device = value.__dlpack_device__()
    if int(kind) != _CUDA:
        where = _KINDS.get(int(kind), f"a device of kind {int(kind)}")
        raise TypeError(f"{name} must be on a graphics processor of NVIDIA, not on {where}: fdem.contacts takes arrays of the processor")
    # Stream 1 is the default one, in which the search runs: the producer lets it wait for the array.
    tensor = _fdem.Tensor(value.__dlpack__(stream=1))
    if list(tensor.device) != [_CUDA, int(device)]:
        raise TypeError(f"{name}: __dlpack__ and __dlpack_device__ name different devices")
    strides = None if tensor.strides is None else [step * _bytes_of(tensor.typestr) for step in tensor.strides]
    return _checked(name, tensor.address, tensor.shape, strides, tensor.typestr, int(device), False, tensor)


def _by_interface(interface: Any, value: Any, name: str) -> Placed:
    missing = [key for key in ("shape", "typestr", "data", "version") if key not in interface]
    if missing:
        raise TypeError(f"{name}: __cuda_array_interface__ lacks {', '.join(missing)}")
    if interface.get("mask") is not None:
        raise TypeError(f"{name} has a mask: leave the masked elements out")
    version, stream = interface["version"], interface.get("stream")
    if stream == 0:
        raise ValueError(f"{name}: stream 0 of __cuda_array_interface__ names no stream")
    # Before version 3 an array does not say which stream writes to it. Since then none is an array that is ready. The default stream, 1, is that of the search.
    waits = version < 3 or stream not in (None, 1)
    # The second number says whether the array is read-only, as the search takes it.
    address, _ = interface["data"]
    return _checked(name, address, interface["shape"], interface.get("strides"), interface["typestr"], None, waits, value)


def _bytes_of(typestr: str) -> int:
    return int(typestr[2:]) if typestr[2:].isdigit() else 0


def _checked(name: str, address: Optional[int], shape: Any, strides: Any, typestr: str, device: Optional[int], waits: bool, owner: Any) -> Placed:
    dtypes = {"<f4": "float32", "<f8": "float64"}
    if typestr not in dtypes:
        raise TypeError(f"{name} must be float32 or float64 in the byte order of the machine, not {typestr}: convert them on the device")
    shape = tuple(int(length) for length in shape)
    if min(shape, default=0) < 0:
        raise ValueError(f"{name} has the shape {shape}")
    count = int(np.prod(shape, dtype=object))
    if strides is not None and count > 0:
        step = _bytes_of(typestr)
        for length, stride in zip(reversed(shape), reversed(tuple(strides))):
            # The step along an axis of one number does not matter.
            if length > 1 and int(stride) != step:
                raise ValueError(f"{name} must be contiguous and in C order on the device: make a contiguous copy there")
            step *= length
    address = int(address or 0)
    if count > 0 and address == 0:
        raise ValueError(f"{name}: the array has {count} numbers, and its address is 0")
    if address % _bytes_of(typestr):
        raise ValueError(f"{name}: the address is not that of {dtypes[typestr]} numbers")
    return Placed(address if count else 0, shape, dtypes[typestr], device, waits, owner)


class DeviceContacts:
    """Couples that are on a graphics processor, made by :func:`contacts_on_device`.

    ``cupy.asarray(found)``, ``cupy.from_dlpack(found)`` and ``torch.from_dlpack(found)`` take them without a copy: an array ``[m, 2]`` of int32, the smaller element of each
    couple first. Its memory is freed once neither this object nor such an array uses it. The couples are ready for every stream.
    """

    def __init__(self) -> None:
        raise TypeError("couples on a device come from fdem.contacts_on_device")

    _couples: _fdem.DeviceCouples
    _elements: int

    @classmethod
    def _of(cls, couples: _fdem.DeviceCouples, elements: int) -> DeviceContacts:
        self = cls.__new__(cls)
        self._couples, self._elements = couples, elements
        return self

    def __len__(self) -> int:
        return len(self._couples)

    def __repr__(self) -> str:
        return f"<fdem.DeviceContacts: {len(self):,} couples of {self._elements:,} elements on gpu:{self.device}>"

    @property
    def n(self) -> int:
        """The number of elements, with contacts or without."""
        return self._elements

    @property
    def shape(self) -> tuple[int, int]:
        """``(m, 2)``."""
        return len(self), 2

    @property
    def device(self) -> int:
        """The number of the graphics processor."""
        return self._couples.device

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        return self._couples.__cuda_array_interface__

    def __dlpack_device__(self) -> tuple[int, int]:
        return self._couples.__dlpack_device__()

    def __dlpack__(self, **arguments: Any) -> Any:
        return self._couples.__dlpack__(**arguments)

    def numpy(self) -> npt.NDArray[np.int32]:
        """Copies the couples from the device: those of :func:`contacts` with the engine "rows", in their order."""
        return self._couples.numpy()


def contacts_on_device(positions: Any, radii: Any = None, cutoff: Optional[float] = None, *, tolerance: float = 0.0) -> DeviceContacts:
    """Finds all couples of spheres (discs in 2D) that touch, or of points that are at most `cutoff` apart, where their arrays are: on a graphics processor of NVIDIA.

    Arrays are read where they are, and the couples stay there. Only extremes, counts, and at most 4096 points are copied.

    Parameters
    ----------
    positions : array [n, 2] or [n, 3], float32 or float64
        Centres, contiguous and in C order, of any library whose arrays have ``__dlpack__`` or ``__cuda_array_interface__``: PyTorch, CuPy, JAX, Numba, Warp. Work that the
        library still does on them is waited for, in the stream that it names. They must not change until the function returns.
    radii : array [n] or number, optional
        The radius of each element, on the same device and of the same type, or a number for all.
    cutoff : number, optional
        The distance at which points touch. One of `radii` and `cutoff` must be given.
    tolerance : number, default 0
        The gap between surfaces that still counts as contact.

    Returns
    -------
    DeviceContacts
        The couples of ``contacts(..., engine="rows")``, in its order.

    Raises
    ------
    TypeError
        For arrays that are not on a graphics processor of NVIDIA, or not of float32 or float64, or of different types.
    ValueError
        For arrays of a wrong shape, that are not contiguous, or have a null pointer; for NaN, infinity and negative sizes: the message names the element.
    RuntimeError
        If the device cannot be had, has too little memory, or does not have the arrays.

    Examples
    --------
    With PyTorch::

        positions = torch.rand(1_000_000, 3, device="cuda")
        pairs = torch.from_dlpack(fdem.contacts_on_device(positions, radii=0.005))

    Arrays of the processor are refused:

    >>> import fdem
    >>> fdem.contacts_on_device([[0.0, 0.0], [1.0, 0.0]], radii=0.5)
    Traceback (most recent call last):
    TypeError: positions must be an array on a graphics processor, with __dlpack__ or __cuda_array_interface__, not list
    """
    centres = placed(positions, "positions")
    if len(centres.shape) != 2 or centres.shape[1] not in (2, 3):
        raise ValueError(f"positions must have the shape [n, 2] or [n, 3], not {list(centres.shape)}")
    if (radii is None) == (cutoff is None):
        raise TypeError("give radii, or the cutoff of points: one of the two")
    count = centres.shape[0]
    if count > np.iinfo(np.int32).max:
        raise ValueError(f"{count} elements are more than the numbers of couples on a device can name")
    each: Optional[Placed] = None
    radius = 0.0
    if cutoff is not None:
        radius = number(cutoff, "cutoff") / 2
    elif not hasattr(radii, "__cuda_array_interface__") and not hasattr(radii, "__dlpack__") and is_number(radii):
        radius = number(radii, "radii")
    else:
        each = placed(radii, "radii")
        if each.shape != (count,):
            raise ValueError(f"radii must be one number, or one for each of {count} elements, not of the shape {list(each.shape)}")
        if each.dtype != centres.dtype:
            raise TypeError(f"positions are {centres.dtype}, and radii {each.dtype}: convert one of them on the device")
        if None not in (each.device, centres.device) and each.device != centres.device:
            raise TypeError(f"positions are on gpu:{centres.device}, and radii on gpu:{each.device}")
    arrays = [centres] if each is None else [centres, each]
    device = next((array.device for array in arrays if array.device is not None), 0)
    address = None if each is None else each.address
    elements = {
        "device": device,
        "count": count,
        "dimensions": centres.shape[1],
        "is_double": centres.dtype == "float64",
        "points": centres.address,
        "radii": address,
        "radius": radius,
        "tolerance": number(tolerance, "tolerance"),
    }
    return DeviceContacts._of(_fdem.contacts_on_device(elements, any(array.waits for array in arrays)), count)
