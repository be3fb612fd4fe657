"""Arguments that are taken as they are, that are converted, and that are refused; and the messages."""

import gc
import os
import pathlib
import re
import sys
import tracemalloc

import numpy as np
import pytest
from conftest import couples, gas

import fdem
from fdem._files import write_whole

POSITIONS = gas(2000, 8, 3)[0]
EXPECTED = couples(fdem.contacts(POSITIONS, cutoff=1.0))


def strided(array):
    wide = np.full((2 * len(array), array.shape[1] + 2), np.nan)
    wide[::2, 1:-1] = array
    return wide[::2, 1:-1]


def unaligned(array):
    raw = np.zeros(array.nbytes + 1, np.uint8)
    view = raw[1:].view(np.float64).reshape(array.shape)
    view[:] = array
    assert not view.flags.aligned
    return view


@pytest.mark.parametrize(
    "convert",
    [
        np.asfortranarray,
        strided,
        unaligned,
        lambda array: array[::-1][::-1],
        lambda array: array.astype(">f8"),
        lambda array: array.tolist(),
        lambda array: array.astype(object),
        lambda array: np.ma.masked_array(array),
        lambda array: array.astype(np.longdouble),
    ],
)
def test_other_layouts_give_the_same(convert):
    found = fdem.contacts(convert(POSITIONS), cutoff=1.0)
    assert couples(found) == EXPECTED
    assert found.distance.dtype == np.float64


def test_arrays_in_c_order_are_not_copied():
    for dtype in (np.float32, np.float64):
        array = POSITIONS.astype(dtype)
        array.flags.writeable = False
        assert fdem.contacts(array, cutoff=1.0)._positions is array
    radii = np.full(len(POSITIONS), 0.5)
    assert fdem.contacts(POSITIONS, radii)._others is radii


def test_whole_numbers_and_halves():
    grid = np.stack(np.meshgrid(*[np.arange(5)] * 3), -1).reshape(-1, 3)
    for dtype in (np.int8, np.uint16, np.int64, np.float16, np.float32):
        found = fdem.contacts(grid.astype(dtype), cutoff=1)
        assert len(found) == 3 * 4 * 25
        assert found.distance.dtype == (np.float32 if np.dtype(dtype).kind == "f" else np.float64)


def test_single_and_double_become_double():
    single = POSITIONS.astype(np.float32)
    found = fdem.contacts(single, radii=np.full(len(single), 0.5))
    assert found.distance.dtype == np.float64
    assert couples(found) == couples(fdem.contacts(single.astype(np.float64), radii=0.5))
    # 0.1 is rounded to the type of the positions, in which the two are exactly that far apart.
    assert len(fdem.contacts(np.array([[0, 0], [0.1, 0]], np.float32), cutoff=0.1)) == 1


def test_what_float64_does_not_hold_is_refused():
    with pytest.raises(ValueError, match="positions: element 1 has .*9007199254740993"):
        fdem.contacts(np.array([[0, 0], [0, 2**53 + 1]]), cutoff=1.0)
    assert len(fdem.contacts(np.array([[0, 0], [0, 2**60]]), cutoff=1.0)) == 0
    third = np.array([[1, 3]], np.longdouble) / 3
    if third[0, 0] != float(third[0, 0]):
        with pytest.raises(ValueError, match="float64 does not hold"):
            fdem.contacts(third, cutoff=1.0)


def test_groups_of_any_whole_numbers():
    positions = [[0, 0], [1, 0], [2, 0]]
    for dtype in (np.int8, np.uint8, np.int64, np.uint32):
        assert len(fdem.contacts(positions, cutoff=1, groups=np.array([5, 5, 7], dtype))) == 1
    far = np.array([-(2**62), -(2**62), 2**62])
    assert couples(fdem.contacts(positions, cutoff=1, groups=far)) == {(1, 2)}


NAN = float("nan")
TWO = [[0.0, 0.0], [1.0, 0.0]]


@pytest.mark.parametrize(
    ("error", "words", "call"),
    [
        (ValueError, "element 1: coordinate y is NaN", lambda: fdem.contacts([[0, 0], [1, NAN]], cutoff=1)),
        (ValueError, "element 0: coordinate x is inf", lambda: fdem.contacts([[np.inf, 0]], cutoff=1)),
        (ValueError, "element 1: coordinate x is 1e300", lambda: fdem.contacts([[0, 0], [1e300, 0]], cutoff=1)),
        (ValueError, "element 1: radius.*-1", lambda: fdem.contacts(TWO, radii=[1, -1])),
        (ValueError, "radius", lambda: fdem.contacts(TWO, radii=-2.0)),
        (ValueError, "radii must be one number, or one for each of 2", lambda: fdem.contacts(TWO, radii=[1, 1, 1])),
        (ValueError, "cut-off", lambda: fdem.contacts(TWO, cutoff=NAN)),
        (ValueError, "tolerance", lambda: fdem.contacts(TWO, cutoff=1, tolerance=-1)),
        (TypeError, "radii, or the cutoff", lambda: fdem.contacts(TWO)),
        (TypeError, "radii, or the cutoff", lambda: fdem.contacts(TWO, 1.0, 1.0)),
        (TypeError, "cutoff is one number", lambda: fdem.contacts(TWO, cutoff=[1, 1])),
        (TypeError, "cutoff is one number", lambda: fdem.contacts(TWO, cutoff="1")),
        (TypeError, "positions must be real numbers, not complex", lambda: fdem.contacts(np.zeros((2, 2), complex), cutoff=1)),
        (TypeError, "positions must be real numbers, not bool", lambda: fdem.contacts(np.zeros((2, 2), bool), cutoff=1)),
        (TypeError, "positions must be real numbers", lambda: fdem.contacts([["a", "b"]], cutoff=1)),
        (TypeError, "masked", lambda: fdem.contacts(np.ma.masked_equal(TWO, 1.0), cutoff=1)),
        (ValueError, r"positions must have the shape \[n, 2\] or \[n, 3\], not \[4\]", lambda: fdem.contacts(np.zeros(4), cutoff=1)),
        (ValueError, r"not \[2, 4\]", lambda: fdem.contacts(np.zeros((2, 4)), cutoff=1)),
        (ValueError, "rows of one length", lambda: fdem.contacts([[0, 0], [1]], cutoff=1)),
        (ValueError, "no engine 'fast'", lambda: fdem.contacts(TWO, cutoff=1, engine="fast")),
        (ValueError, "threads must be at least 1", lambda: fdem.contacts(TWO, cutoff=1, threads=0)),
        (TypeError, "threads must be a whole number", lambda: fdem.contacts(TWO, cutoff=1, threads=1.5)),
        (ValueError, "cannot start 5000 threads", lambda: fdem.contacts(TWO, cutoff=1, threads=5000)),
        (ValueError, "one number for each of 2", lambda: fdem.contacts(TWO, cutoff=1, groups=[1])),
        (TypeError, "groups must be whole", lambda: fdem.contacts(TWO, cutoff=1, groups=[1.5, 2])),
        (ValueError, "periodic needs a box", lambda: fdem.contacts(TWO, cutoff=1, periodic=True)),
        (ValueError, "does not repeat plays no part", lambda: fdem.contacts(TWO, cutoff=1, box=[4, 4])),
        (ValueError, "one for each of 2 axes", lambda: fdem.contacts(TWO, cutoff=1, box=[4, 4], periodic=[True] * 3)),
        (TypeError, "periodic must be True or False", lambda: fdem.contacts(TWO, cutoff=1, box=[4, 4], periodic="xy")),
        (ValueError, "along x 0.0 is not below -4.0", lambda: fdem.contacts(TWO, cutoff=1, box=[-4, 4], periodic=True)),
        (ValueError, "2 lengths, 2 pairs", lambda: fdem.contacts(TWO, cutoff=1, box=[4, 4, 4], periodic=True)),
        (ValueError, "box", lambda: fdem.contacts(TWO, cutoff=1, box=fdem.Box([[0, 1], [0, 2]]), periodic=True)),
        (ValueError, "lower has the shape", lambda: fdem.boxes(np.zeros((2, 2)), np.zeros((2, 3)))),
        (ValueError, "element 1", lambda: fdem.boxes(np.zeros((2, 2)), [[1, 1], [1, -1]])),
        (TypeError, "r, the largest distance, or k", lambda: fdem.query(TWO)),
        (ValueError, "3", lambda: fdem.query(TWO, 1.0, at=np.zeros((1, 3)))),
        (ValueError, "buffer", lambda: fdem.Detector(1.0, buffer=-1.0)),
        (RuntimeError, "before the first update", lambda: fdem.Detector(1.0).contacts),
        (TypeError, "come from", fdem.Contacts),
    ],
)
def test_what_is_wrong_is_named(error, words, call):
    with pytest.raises(error) as raised:
        call()
    assert re.search(words, str(raised.value)), raised.value


def test_positions_that_change_are_noticed():
    positions = POSITIONS.copy()
    found = fdem.contacts(positions, cutoff=1.0)
    positions += 0.01
    for ask in (lambda: found.distance, lambda: found.overlap, lambda: found.vector, found.verify):
        with pytest.raises(RuntimeError, match="changed in place"):
            ask()
    assert len(found.coordination) == len(positions), "what needs no positions is there"
    positions = POSITIONS.copy()
    found = fdem.contacts(positions, cutoff=1.0)
    before = found.distance
    positions += 0.01
    assert found.distance is before


def test_results_are_given_out_without_a_copy_and_let_go():
    positions = gas(200_000, 12, 3)[0]
    fdem.contacts(positions, cutoff=1.0, threads=1)
    found = fdem.contacts(positions, cutoff=1.0, threads=1)
    assert found.i.base is not None and np.shares_memory(found.i, found.pairs)
    assert found.pairs.flags.writeable and found.pairs.flags.c_contiguous
    pairs = found.pairs
    del found
    gc.collect()
    assert pairs.max() < 200_000, "the array outlives the contacts"
    tracemalloc.start()
    fdem.contacts(positions, cutoff=1.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1 << 20, "nothing is copied by NumPy"


@pytest.mark.parametrize("cutoff", [np.nan, -1.0, [0.5, np.nan], [0.5, -1.0], {(1, 1): -1.0}, {(1, 1): np.inf}])
def test_cutoffs_of_neighbour_lists_that_cannot_be(cutoff):
    with pytest.raises(ValueError, match="cutoff"):
        fdem.neighbor_list("ij", positions=[[0.0, 0, 0], [1, 0, 0]], numbers=[1, 1], cutoff=cutoff)


@pytest.mark.parametrize("boxsize", [-1, np.nan, [1, np.inf, 1], [1, 1]])
def test_boxes_of_trees_that_cannot_be(boxsize):
    with pytest.raises(ValueError, match="boxsize"):
        fdem.KDTree(np.zeros((3, 3)), boxsize=boxsize)


@pytest.mark.parametrize("box", [1, 1.0, True])
def test_a_box_is_no_number(box):
    with pytest.raises(TypeError, match="not one number"):
        fdem.contacts(np.zeros((3, 3)), radii=1, box=box, periodic=True)


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_files_are_written_whole(tmp_path):
    """The old file stays until the new one is complete; links and devices stay what they are."""
    file, link = tmp_path / "file", tmp_path / "link"
    write_whole(file, b"old")
    with pytest.raises(TypeError):
        write_whole(file, None)
    assert file.read_bytes() == b"old"
    link.symlink_to("file")
    write_whole(link, b"new")
    assert link.is_symlink() and file.read_bytes() == b"new"
    write_whole(pathlib.Path(os.devnull), b"new")
    assert not pathlib.Path(os.devnull).is_file()
    with pytest.raises(FileNotFoundError, match="no such folder"):
        write_whole(tmp_path / "absent" / "file", b"")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["file", "link"]
