"""Keeps standard output for the result of a command."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout

_STDOUT, _STDERR = 1, 2
_IMPORTING = threading.RLock()
"""Threads that import at once would take each other's standard error for standard output."""


@contextmanager
def printed_to_stderr(wanted: bool) -> Iterator[None]:
    """What stages print meanwhile, or processes that begin meanwhile, goes to standard error, if `wanted`."""
    if not wanted:
        yield
        return
    if sys.stdout is not None:
        sys.stdout.flush()
    before = _to_stderr()
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        ctypes.CDLL(None).fflush(None)  # what C has buffered
        if before is not None:
            os.dup2(before, _STDOUT)
            os.close(before)


def _to_stderr() -> int | None:
    """Let the descriptor of standard output be that of standard error; returns a copy of the former one.

    None if the process lacks one of them, as a service may.
    """
    before = None
    try:
        before = os.dup(_STDOUT)
        os.dup2(_STDERR, _STDOUT)
    except OSError:
        if before is not None:
            os.close(before)
        return None
    return before


@contextmanager
def importing() -> Iterator[None]:
    """What the module of a stranger prints when it is imported goes to standard error, too."""
    with _IMPORTING, printed_to_stderr(True):
        yield
