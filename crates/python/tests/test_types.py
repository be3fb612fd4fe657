"""What type checkers say of the examples of the documentation."""

import doctest
import importlib
import json
import pathlib
import re
import subprocess
import sys

import pytest
from test_docs import MODULES, ROOT, pages

import fdem

CONFIGURATION = """
[mypy]
strict = true
untyped_calls_exclude = ase
[mypy-ase.*,freud.*,matscipy.*,networkx.*,pandas.*,pyvista.*,scipy.*,vesin.*]
ignore_missing_imports = true
"""


@pytest.fixture(scope="module")
def examples(tmp_path_factory):
    """A folder with a program for each page, and one for each docstring with examples."""
    folder = tmp_path_factory.mktemp("examples")
    for page in pages():
        blocks = []
        for block in re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
            parsed = doctest.DocTestParser().get_examples(block)
            blocks.append("".join(example.source for example in parsed) if parsed else block)
        if blocks:
            name = re.sub(r"\W+", "_", str(page.relative_to(ROOT).with_suffix("")))
            (folder / f"page_{name}.py").write_text("\n".join(blocks), encoding="utf-8")
    for module in MODULES:
        for found in doctest.DocTestFinder().find(importlib.import_module(module)):
            if found.examples:
                source = "".join(example.source for example in found.examples)
                name = re.sub(r"\W+", "_", found.name)
                (folder / f"docstring_{name}.py").write_text(source, encoding="utf-8")
    assert len(list(folder.glob("page_*.py"))) >= 4 and len(list(folder.glob("docstring_*.py"))) >= 20
    (folder / "mypy.ini").write_text(CONFIGURATION)
    return folder


def test_mypy_passes_on_every_example(examples):
    files = sorted(map(str, examples.glob("*.py")))
    command = [sys.executable, "-m", "mypy", "--config-file", "mypy.ini", "--cache-dir", ".cache", *files]
    run = subprocess.run(command, capture_output=True, text=True, cwd=examples)
    assert run.returncode == 0, run.stdout + run.stderr


def pyright(folder, *files):
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "--outputjson", *files]
    run = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    said = json.loads(run.stdout)
    return said["summary"], [entry for entry in said["generalDiagnostics"] if entry["severity"] == "error"]


def test_pyright_passes_on_every_example(examples):
    files = sorted(map(str, examples.glob("*.py")))
    summary, errors = pyright(examples, *files)
    assert summary["filesAnalyzed"] == len(files)
    assert not errors, errors


def test_what_type_checkers_know(tmp_path):
    """The types of results, and that wrong engines and formats are found before a program runs."""
    right = tmp_path / "right.py"
    right.write_text(
        "import fdem\n"
        "packing: fdem.Packing = fdem.read('a.csv', kind='packing')\n"
        "mesh: fdem.Mesh = fdem.read('a.msh', kind='mesh')\n"
        "last: fdem.Packing = fdem.read('run.xyz', -1)\n"
        "either = fdem.read('a')\n"
        "n: int = len(either.positions if isinstance(either, fdem.Packing) else either.nodes)\n"
        "found: fdem.Contacts = fdem.contacts(packing.positions, packing.radii, engine='rows')\n"
    )
    wrong = tmp_path / "wrong.py"
    lines = [
        "fdem.contacts([[0.0, 0.0]], 1.0, engine='row')",
        "fdem.Detector(1.0, engine='fast')",
        "fdem.read('a', kind='packing').nodes",
        "fdem.read('a', kind='mesh').positions",
        "fdem.read('a', 3).nodes",
        "fdem.read('a', kind='net')",
        "fdem.read('a', format='csv')",
        "fdem.read('a', kind='mesh', columns='x,y')",
        "fdem.labels([[1]], neighbourhood='all')",
    ]
    wrong.write_text("import fdem\n" + "\n".join(lines) + "\n")
    summary, errors = pyright(tmp_path, str(right), str(wrong))
    assert summary["filesAnalyzed"] == 2
    assert {pathlib.Path(entry["file"]).name for entry in errors} == {"wrong.py"}, errors
    assert {entry["range"]["start"]["line"] for entry in errors} == set(range(1, 1 + len(lines))), errors
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    assert subprocess.run([*command, str(right)], capture_output=True, cwd=tmp_path).returncode == 0
    run = subprocess.run([*command, str(wrong)], capture_output=True, text=True, cwd=tmp_path)
    assert {int(line) for line in re.findall(r"wrong\.py:(\d+): error", run.stdout)} == set(range(2, 2 + len(lines))), run.stdout


def test_the_kind_of_a_file_is_checked():
    with pytest.raises(ValueError, match=r"squares.msh: this is a mesh, not a packing"):
        fdem.read(ROOT / "examples/squares.msh", kind="packing")
    with pytest.raises(ValueError, match=r"packing.csv: this is a packing, not a mesh"):
        fdem.read(ROOT / "examples/packing.csv", kind="mesh")
    with pytest.raises(ValueError, match="no kind 'net'"):
        fdem.read(ROOT / "examples/packing.csv", kind="net")
