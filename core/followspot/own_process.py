"""The command line of a process of this program."""

from __future__ import annotations

import sys


def module_command(module: str, *arguments: str) -> list[str]:
    """Runs a module of this program.

    `-P` keeps the present folder off the path of imports: a `random.py` there, of an experiment or in a
    folder from elsewhere, must not take the place of the library's.
    """
    return [sys.executable, "-P", "-m", module, *arguments]
