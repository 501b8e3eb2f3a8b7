"""Keeps standard output for the one JSON object of a command."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout

_STDOUT, _STDERR = 1, 2


@contextmanager
def printed_to_stderr(wanted: bool) -> Iterator[None]:
    """What stages print meanwhile, or processes that begin meanwhile, goes to standard error, if `wanted`."""
    if not wanted:
        yield
        return
    sys.stdout.flush()
    before = os.dup(_STDOUT)
    os.dup2(_STDERR, _STDOUT)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        ctypes.CDLL(None).fflush(None)  # what C has buffered
        os.dup2(before, _STDOUT)
        os.close(before)
