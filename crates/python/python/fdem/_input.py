"""Converts arguments to the arrays that the extension module takes: in C order, aligned, in the byte order of the machine."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, Literal, Optional, Union

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[Any]
"""An array of float32 or float64."""

Engine = Literal["auto", "rows", "multilevel", "cgrid", "nbs", "direct"]
"""The name of a search."""

AXES = "xyz"


def array_of(value: Any, name: str) -> npt.NDArray[Any]:
    """`value` as an array; exceptions name the argument."""
    if isinstance(value, np.ma.MaskedArray):
        if np.ma.is_masked(value):
            raise TypeError(f"{name} has masked entries: leave those elements out, or fill them")
        value = value.data
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name} must be an array, with rows of one length: {error}") from None


def floats(value: Any, name: str) -> Floats:
    """`value` as float32 or float64: other types become the smaller of the two that holds their values exactly."""
    array = array_of(value, name)
    if array.ndim == 0:
        # NumPy turns the result of a computation with an array without axes into a scalar, which cannot be changed.
        return floats(array.reshape(1), name).reshape(())
    dtype = array.dtype
    if dtype == np.float32 or dtype == np.float16:
        return np.require(array, np.float32, ["C", "A"])
    if dtype == np.float64:
        return np.require(array, np.float64, ["C", "A"])
    if dtype.kind == "O":
        try:
            return np.require(array, np.float64, ["C", "A"])
        except (TypeError, ValueError):
            raise TypeError(f"{name} must be real numbers; not all of them are") from None
    if dtype.kind not in "iuf":
        raise TypeError(f"{name} must be real numbers, not {dtype}")
    exact = array.astype(np.float64)
    if exact.size and (dtype.kind == "f" or dtype.itemsize == 8):
        back = exact.astype(np.longdouble) if dtype.kind == "f" else exact
        wrong = (back != array) & ~(np.isnan(exact) & (array != array))
        if dtype.kind in "iu":
            # As whole numbers: 2**63 - 1 and 2**63 are one float64.
            wrong = np.abs(exact) >= 2.0**53
            wrong[wrong] = [int(a) != int(b) for a, b in zip(exact[wrong], array[wrong])]
        if wrong.any():
            place = tuple(int(k) for k in np.argwhere(wrong)[0])
            raise ValueError(f"{name}: element {place[0] if place else ''} has {array[place]!r}, which float64 does not hold exactly")
    return np.require(exact, np.float64, ["C", "A"])


def points(value: Any, name: str) -> Floats:
    """`value` as points, ``[n, 2]`` or ``[n, 3]``."""
    array = floats(value, name)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        shape = "x".join(map(str, array.shape)) or "a number"
        raise ValueError(f"{name} must have the shape [n, 2] or [n, 3], not [{shape.replace('x', ', ')}]")
    return array


def alike(*arrays: Floats) -> list[Floats]:
    """The arrays in the larger of their types: float32 becomes float64, never the reverse."""
    dtype = np.result_type(*arrays)
    return [np.require(array, dtype, ["C", "A"]) for array in arrays]


def number(value: Any, name: str) -> float:
    """`value` as one real number."""
    if isinstance(value, (bool, np.bool_, str, bytes, complex, np.complexfloating)):
        raise TypeError(f"{name} must be a number, not {type(value).__name__}")
    try:
        return float(value)
    except TypeError:
        raise TypeError(f"{name} must be a number, not {type(value).__name__}") from None


def is_number(value: Any) -> bool:
    """Whether `value` is one number, and no array."""
    return np.ndim(value) == 0 and not isinstance(value, (str, bytes, dict))


def whole(value: Any, name: str, least: int) -> int:
    """`value` as a whole number of at least `least`."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be a whole number, not bool")
    try:
        result = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, not {type(value).__name__}") from None
    if result < least:
        raise ValueError(f"{name} must be at least {least}, not {result}")
    return result


def threads_of(threads: Optional[int]) -> int:
    """0 is one thread for each processor."""
    return 0 if threads is None else whole(threads, "threads", 1)


def numbers(value: Any, name: str, length: int) -> npt.NDArray[np.uint32]:
    """Whole numbers, one for each of `length` elements, as uint32 numbers that are equal for equal values."""
    array = array_of(value, name)
    if array.shape != (length,):
        raise ValueError(f"{name} must have one number for each of {length} elements, not the shape {array.shape}")
    if array.dtype.kind not in "iu" and length:
        raise TypeError(f"{name} must be whole numbers, not {array.dtype}")
    if array.dtype != np.uint32:
        array = np.unique(array, return_inverse=True)[1].reshape(length)
    return np.require(array, np.uint32, ["C", "A"])


def axes(value: Union[bool, Sequence[bool]], dimensions: int) -> list[bool]:
    """Whether each axis is periodic."""
    array = array_of(value, "periodic")
    if array.dtype.kind not in "biu" or not np.isin(array, (0, 1)).all():
        raise TypeError("periodic must be True or False, or one of them for each axis")
    if array.shape not in ((), (dimensions,)):
        raise ValueError(f"periodic must be one bool, or one for each of {dimensions} axes, not {array.size}")
    return [bool(axis) for axis in np.broadcast_to(array, dimensions)]
