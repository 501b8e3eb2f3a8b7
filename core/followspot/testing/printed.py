"""What code writes to standard output: by print, by the file descriptor, from C, or from a child process."""

from __future__ import annotations

import ctypes
import os
import tempfile
from collections.abc import Callable
from contextlib import redirect_stdout

_STDOUT = 1


def printed_by(act: Callable[[], object]) -> str:
    """The text that an act writes to standard output, which stays silent meanwhile."""
    with (
        tempfile.TemporaryFile() as file,
        open(file.fileno(), "w", closefd=False) as text,
    ):
        before = os.dup(_STDOUT)
        try:
            os.dup2(file.fileno(), _STDOUT)
            with redirect_stdout(text):
                act()
            text.flush()
            ctypes.CDLL(None).fflush(None)  # what C has buffered
        finally:
            os.dup2(before, _STDOUT)
            os.close(before)
        file.seek(0)
        return file.read().decode(errors="replace")
