"""The command ``fdem``."""

from __future__ import annotations

import signal
import sys

from . import _fdem


def main() -> int:
    """Runs the command line of the process, as the ``fdem`` that cargo installs, and returns its exit code."""
    # The command handles Ctrl-C by itself. Python would raise KeyboardInterrupt after it, with a traceback.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _fdem.main(["fdem", *sys.argv[1:]])
