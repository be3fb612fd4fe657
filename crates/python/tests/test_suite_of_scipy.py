"""SciPy's own tests of its k-d trees, from the installed package, with ``fdem.KDTree`` in place of both of them."""

import pathlib

import pytest
from conftest import module_with

import fdem

scipy_spatial = pytest.importorskip("scipy.spatial")
SOURCE = pathlib.Path(scipy_spatial.__file__).parent / "tests" / "test_kdtree.py"
if not SOURCE.exists():
    pytest.skip("SciPy is installed without its tests", allow_module_level=True)


class cKDTree(fdem.KDTree):  # noqa: N801
    """The same under its other name: the suite makes a class of tests for each name."""

    def __init__(self, data, leafsize=16, *args, **options):
        super().__init__(data, leafsize, *args, **options)


OTHERWISE = {
    "test_query_pairs_eps": "couples that rounding puts beyond r by one digit are found with eps: here results are exact, and eps has no effect",
    "test_ckdtree_parallel": "all processors are counted by the system, and not by os.cpu_count, which the test makes fail",
    "Test_vectorization_cKDTree.test_single_query": "the number of one neighbour is an int in cKDTree and a numpy.intp in KDTree, as here",
}
"""Tests that do not hold here, by name, with the reason."""

replaced = {
    "scipy.spatial": {"KDTree": fdem.KDTree, "cKDTree": cKDTree},
    "scipy.spatial._ckdtree": {"cKDTreeNode": fdem.KDTree.node},
}
suite = module_with(SOURCE, "scipys_test_kdtree", replaced)
for name, value in vars(suite).items():
    if name.startswith(("test", "Test")) or name == "kdtree_type":
        globals()[name] = value
for name, reason in OTHERWISE.items():
    *of_class, test = name.split(".")
    holder = getattr(suite, of_class[0]) if of_class else suite
    skipped = pytest.mark.skip(reason=reason)(getattr(holder, test))
    if of_class:
        setattr(holder, test, skipped)
    else:
        globals()[test] = skipped


def test_the_suite_is_there():
    """A suite without tests would pass."""
    assert sum(name.startswith(("test", "Test")) for name in vars(suite)) > 80
    assert suite.KDTree is fdem.KDTree and suite.cKDTree is cKDTree
    assert scipy_spatial.KDTree is not fdem.KDTree, "other tests have SciPy's"
