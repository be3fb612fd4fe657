"""ASE's own tests of its neighbour lists, from the installed package, with the functions of fdem in place of its own."""

import pathlib

import pytest
from conftest import module_with

import fdem

ase_neighborlist = pytest.importorskip("ase.neighborlist")
FOLDER = pathlib.Path(ase_neighborlist.__file__).parent / "test" / "neighbor"
FILES = sorted(FOLDER.glob("test_*.py"))
if not FILES:
    pytest.skip("ASE is installed without its tests", allow_module_level=True)

replaced = {
    "ase.neighborlist": {
        "neighbor_list": fdem.neighbor_list,
        "primitive_neighbor_list": fdem.primitive_neighbor_list,
        "NewPrimitiveNeighborList": fdem.NewPrimitiveNeighborList,
    }
}
suites = [module_with(file, f"ases_{file.stem}", replaced) for file in FILES]
for suite in suites:
    for name, value in vars(suite).items():
        if name.startswith("test"):
            assert name not in globals(), f"two tests of ASE are named {name}"
            globals()[name] = value


def test_the_suites_are_there():
    """Suites without tests would pass."""
    assert sum(name.startswith("test") for suite in suites for name in vars(suite)) > 5
    assert any(vars(suite).get("neighbor_list") is fdem.neighbor_list for suite in suites)
    assert ase_neighborlist.neighbor_list is not fdem.neighbor_list, "other tests have ASE's"
