"""Arrays that are on a graphics processor. Without one, arrays that only say so are read and refused."""

import ctypes
import gc
import importlib.util
import os

import numpy as np
import pytest

import fdem
from fdem import _fdem
from fdem._on_device import placed
from test_device import has_device

POINTS = np.array([[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]])


class Fake:
    """An array of the processor that says that it is on a graphics processor."""

    def __init__(self, array, **changes):
        self.array = array
        interface = {
            "shape": array.shape,
            "typestr": array.dtype.str,
            "data": (array.ctypes.data, False),
            "strides": None if array.flags.c_contiguous else array.strides,
            "version": 3,
            "stream": None,
        }
        self.__cuda_array_interface__ = {key: value for key, value in {**interface, **changes}.items() if value != "leave out"}


class Shared:
    """An array by DLPack, whose device is another than it is if one is given."""

    def __init__(self, array, device=None):
        self.array, self.device, self.streams = array, device, []

    def __dlpack_device__(self):
        return self.device or self.array.__dlpack_device__()

    def __dlpack__(self, stream=None):
        self.streams.append(stream)
        return self.array.__dlpack__()


def test_arrays_are_read_as_they_describe_themselves():
    for dtype in ("float32", "float64"):
        array = POINTS.astype(dtype)
        found = placed(Fake(array), "positions")
        assert found[:5] == (array.ctypes.data, (3, 2), dtype, None, False)
        # An array of one column has any step along it.
        assert placed(Fake(array[:, :1][:1]), "positions").shape == (1, 1)
        # The search only reads.
        assert placed(Fake(array, data=(array.ctypes.data, True)), "positions").address == array.ctypes.data
    none = placed(Fake(POINTS[:0], data=(0, False)), "positions")
    assert (none.address, none.shape) == (0, (0, 2))


def test_streams_are_waited_for_unless_the_array_is_ready():
    def waits(**changes):
        return placed(Fake(POINTS, **changes), "positions").waits

    assert not waits(stream=None)
    assert not waits(stream=1)
    assert waits(stream=2) and waits(stream=12345)
    # Arrays of version 2 do not say it.
    assert waits(version=2, stream="leave out")
    with pytest.raises(ValueError, match="positions: stream 0"):
        waits(stream=0)


@pytest.mark.parametrize(
    "array, changes, error, part",
    [
        (POINTS.astype(np.int64), {}, TypeError, "positions must be float32 or float64 in the byte order of the machine, not <i8"),
        (POINTS.astype(">f8"), {}, TypeError, "not >f8"),
        (POINTS[:, ::-1], {}, ValueError, "positions must be contiguous and in C order"),
        (np.asfortranarray(POINTS), {}, ValueError, "contiguous and in C order"),
        (POINTS, {"strides": (8, 16)}, ValueError, "contiguous and in C order"),
        (POINTS, {"data": (0, False)}, ValueError, "positions: the array has 6 numbers, and its address is 0"),
        (POINTS, {"data": (None, False)}, ValueError, "its address is 0"),
        (POINTS, {"data": (12, False)}, ValueError, "the address is not that of float64 numbers"),
        (POINTS, {"shape": (3, -2)}, ValueError, "positions has the shape"),
        (POINTS, {"typestr": "leave out"}, TypeError, "positions: __cuda_array_interface__ lacks typestr"),
        (POINTS, {"mask": Fake(POINTS)}, TypeError, "positions has a mask"),
        (np.zeros(3), {}, ValueError, r"positions must have the shape \[n, 2\] or \[n, 3\], not \[3\]"),
        (np.zeros((3, 4)), {}, ValueError, r"not \[3, 4\]"),
    ],
)
def test_arrays_that_cannot_be_searched_are_refused(array, changes, error, part):
    with pytest.raises(error, match=part):
        fdem.contacts_on_device(Fake(array, **changes), radii=1.0)


def test_arguments_that_do_not_fit_are_refused():
    points = Fake(POINTS)
    radii = np.full(3, 0.5)
    with pytest.raises(TypeError, match="give radii, or the cutoff of points: one of the two"):
        fdem.contacts_on_device(points)
    with pytest.raises(TypeError, match="give radii, or the cutoff of points: one of the two"):
        fdem.contacts_on_device(points, radii=1.0, cutoff=1.0)
    with pytest.raises(ValueError, match=r"one for each of 3 elements, not of the shape \[2\]"):
        fdem.contacts_on_device(points, radii=Fake(radii[:2]))
    with pytest.raises(TypeError, match="positions are float64, and radii float32"):
        fdem.contacts_on_device(points, radii=Fake(radii.astype(np.float32)))
    with pytest.raises(TypeError, match="radii must be an array on a graphics processor, .* not list"):
        fdem.contacts_on_device(points, radii=[0.5, 0.5, 0.5])
    with pytest.raises(TypeError, match="positions must be an array on a graphics processor, .* not list"):
        fdem.contacts_on_device([[0.0, 0.0]], radii=1.0)
    with pytest.raises(TypeError, match="come from fdem.contacts_on_device"):
        fdem.DeviceContacts()


def test_arrays_of_the_processor_are_refused():
    with pytest.raises(TypeError, match="positions must be on a graphics processor of NVIDIA, not on the processor: fdem.contacts takes"):
        fdem.contacts_on_device(POINTS, radii=1.0)
    with pytest.raises(TypeError, match="not on ROCm"):
        fdem.contacts_on_device(Shared(POINTS, (10, 0)), radii=1.0)
    with pytest.raises(TypeError, match="not on a device of kind 99"):
        fdem.contacts_on_device(Shared(POINTS, (99, 0)), radii=1.0)
    # An array that says two things.
    liar = Shared(POINTS, (2, 0))
    with pytest.raises(TypeError, match="name different devices"):
        fdem.contacts_on_device(liar, radii=1.0)
    assert liar.streams == [1]


def test_memory_of_the_processor_is_refused_with_a_driver_and_without():
    words = "the points are not in the memory of device 0" if has_device() else "(driver|compiler|there is no device|without graphics processors)"
    with pytest.raises(RuntimeError, match=f"^device: .*{words}"):
        fdem.contacts_on_device(Fake(POINTS), radii=1.0)


def test_arrays_of_numpy_are_read_by_dlpack():
    for array in (POINTS, POINTS.astype(np.float32), np.arange(24.0).reshape(2, 3, 4)[:, 1:, ::2], np.zeros(0), np.arange(5, dtype=np.uint16)):
        tensor = _fdem.Tensor(array.__dlpack__())
        assert tensor.address == array.ctypes.data or array.size == 0
        assert (tuple(tensor.shape), tensor.typestr, list(tensor.device)) == (array.shape, array.dtype.str, [1, 0])
        if tensor.strides is not None and array.size:
            assert [step * array.itemsize for step in tensor.strides] == list(array.strides)
    assert _fdem.Tensor(np.zeros(2, complex).__dlpack__()).typestr == "?"


def test_a_capsule_is_taken_once_and_kept():
    array = np.arange(1000.0)
    capsule = array.__dlpack__()
    address = array.ctypes.data
    tensor = _fdem.Tensor(capsule)
    with pytest.raises(TypeError, match="that nobody has used"):
        _fdem.Tensor(capsule)
    with pytest.raises(TypeError, match='must return a capsule "dltensor"'):
        _fdem.Tensor(array)
    del array, capsule
    gc.collect()
    # The memory is still there.
    assert np.ctypeslib.as_array((ctypes.c_double * 1000).from_address(address)).sum() == 499500.0
    assert tensor.address == address


def test_couples_are_handed_over_and_freed():
    rows = [[0, 1], [7, 9], [1000000, 2000000]]
    # Taken by somebody, and by nobody.
    tensor = _fdem.Tensor(_fdem.dlpack_of_rows(rows))
    assert (list(tensor.shape), tensor.typestr, list(tensor.device), tensor.strides) == ([3, 2], "<i4", [2, 0], None)
    assert np.ctypeslib.as_array((ctypes.c_int32 * 6).from_address(tensor.address)).reshape(3, 2).tolist() == rows
    for _ in range(1000):
        _fdem.dlpack_of_rows(rows)
        _fdem.Tensor(_fdem.dlpack_of_rows(rows))
    assert list(_fdem.Tensor(_fdem.dlpack_of_rows([])).shape) == [0, 2]


def library(name):
    """A library with arrays on a graphics processor. Skipped without a device; `just gpu` has one and needs the libraries."""
    if not has_device():
        pytest.skip("there is no graphics processor")
    if importlib.util.find_spec(name) is None and not os.environ.get("FDEM_NEEDS_GPU"):
        pytest.skip(f"there is a graphics processor, and {name} is not installed")
    return importlib.import_module(name)


@pytest.mark.parametrize("dtype", ["float32", "float64"])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_tensors_of_pytorch_are_searched_where_they_are(dtype, dimensions):
    torch = library("torch")
    points = np.random.default_rng(1).random((5000, dimensions)).astype(dtype)
    radii = np.random.default_rng(2).uniform(0.01, 0.02, 5000).astype(dtype)
    expected = fdem.contacts(points, radii, engine="rows").pairs
    stream = torch.cuda.Stream()
    with torch.cuda.stream(stream):
        # The search has to wait for this stream.
        busy = torch.rand(4000, 4000, device="cuda")
        for _ in range(20):
            busy = busy @ busy / 4000
        placed_points, placed_radii = (torch.from_numpy(array).cuda(non_blocking=True) for array in (points, radii))
        found = fdem.contacts_on_device(placed_points, placed_radii)
    assert len(found) == len(expected) > 100
    assert np.array_equal(found.numpy(), expected)
    tensor = torch.from_dlpack(found)
    assert tensor.data_ptr() == found.__cuda_array_interface__["data"][0]
    del found
    gc.collect()
    assert np.array_equal(tensor.cpu().numpy(), expected)
    with pytest.raises(ValueError, match="contiguous"):
        fdem.contacts_on_device(placed_points.flip(1)[:, ::2].T.contiguous().T, radii=1.0)


def test_arrays_of_cupy_are_searched_where_they_are():
    cupy = library("cupy")
    points = np.random.default_rng(1).random((5000, 3))
    expected = fdem.contacts(points, cutoff=0.05, engine="rows").pairs
    found = fdem.contacts_on_device(cupy.asarray(points), cutoff=0.05)
    for array in (cupy.asarray(found), cupy.from_dlpack(found)):
        assert np.array_equal(array.get(), expected)
    with pytest.raises(ValueError, match="element 7: coordinate"):
        wrong = cupy.asarray(points)
        wrong[7, 1] = cupy.nan
        fdem.contacts_on_device(wrong, cutoff=0.05)
    assert len(fdem.contacts_on_device(cupy.zeros((0, 3)), cutoff=1.0)) == 0
