"""The documentation: docstrings, stubs, and the blocks of README and book."""

import doctest
import importlib
import inspect
import os
import pathlib
import pkgutil
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

import fdem

MODULES = ["fdem"] + [f"fdem.{module.name}" for module in pkgutil.iter_modules(fdem.__path__) if module.name not in ("_fdem", "__main__")]


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings(name):
    module = importlib.import_module(name)
    assert module.__doc__, name
    failed, _ = doctest.testmod(module)
    assert failed == 0


@pytest.mark.parametrize("name", [name for name in fdem.__all__ if not name.startswith("__")])
def test_all_that_is_public_is_documented(name):
    thing = getattr(fdem, name)
    assert inspect.getdoc(thing), name
    if inspect.isfunction(thing):
        text = inspect.getdoc(thing)
        for section in ("Parameters", "Returns", "Raises", "Examples"):
            assert f"{section}\n---" in text, f"{name}: {section}"
        for parameter in inspect.signature(thing).parameters:
            assert re.search(rf"\b{parameter}\b", text), f"{name}: {parameter}"
    else:
        for member, value in vars(thing).items():
            if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                assert inspect.getdoc(value), f"{name}.{member}"


def test_types_are_checked_and_stubs_are_those_of_the_module(tmp_path):
    package = pathlib.Path(fdem.__file__).parent
    assert (package / "py.typed").exists()
    # mypy checks installed packages less strictly.
    shutil.copytree(package, tmp_path / "fdem", ignore=shutil.ignore_patterns("__pycache__"))
    environment = dict(os.environ, MYPYPATH=str(tmp_path))
    for command in (["mypy", "--strict", "--cache-dir", os.devnull, "-p", "fdem"], ["mypy.stubtest", "fdem._fdem", "--ignore-disjoint-bases"]):
        run = subprocess.run([sys.executable, "-m", *command], capture_output=True, text=True, env=environment, cwd=tmp_path)
        assert run.returncode == 0, run.stdout + run.stderr


def pages():
    return [ROOT / "README.md", ROOT / "crates/python/README.md", *sorted((ROOT / "book").glob("src/**/*.md"))]


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
def test_python_blocks_run(page, tmp_path, monkeypatch, capsys):
    """The blocks of a page run one after the other, as a reader would type them, in the folder of the repository's examples."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names = {"__name__": page.stem}
    for block in re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S):
        if ">>>" in block:
            parsed = doctest.DocTestParser().get_doctest(block, names, str(page), str(page), 0)
            runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
            runner.run(parsed, clear_globs=False)
            assert runner.failures == 0
            names.update(parsed.globs)
        else:
            exec(compile(block, str(page), "exec"), names)  # noqa: S102
            # The comment after a `print` is its output.
            expected = re.findall(r"^print\(.*\) *# (.*)$", block, re.M)
            printed = capsys.readouterr().out.splitlines()
            assert not expected or len(expected) == len(printed)
            for want, got in zip(expected, printed):
                assert doctest.OutputChecker().check_output(want + "\n", got + "\n", doctest.ELLIPSIS), (want, got)
