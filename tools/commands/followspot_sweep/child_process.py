"""`followspot` as long as its parent lives: `python -m followspot_sweep.child_process PARENT ARGUMENT...`.

A sweep that is killed leaves no runs behind, which would write to the folders of the sweep that goes on.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys

from followspot.cli.main import main

_SET_PARENT_DEATH_SIGNAL = 1
"""PR_SET_PDEATHSIG."""


def run_as_child(parent: int, arguments: list[str]) -> int:
    """Run the command; it ends as on SIGTERM when the thread that started this process does."""
    ctypes.CDLL(None, use_errno=True).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGTERM)
    if os.getppid() != parent:  # it was gone before
        return 1
    return main(arguments)


if __name__ == "__main__":
    sys.exit(run_as_child(int(sys.argv[1]), sys.argv[2:]))
