"""The command ``fdem``."""

from __future__ import annotations

import sys

from . import _fdem


def main() -> int:
    """Runs the command line of the process, as the ``fdem`` that cargo installs, and returns its exit code."""
    return _fdem.main(["fdem", *sys.argv[1:]])
