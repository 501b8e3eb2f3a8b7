"""Remedies for limits of the operating system (ulimit), which show as errors of files and processes."""

from __future__ import annotations

import errno

_FEWER = "fewer workers: --placement"
_DESCRIPTORS = "raise the limit of open files, for example ulimit -n 4096, or take " + _FEWER
_REMEDIES = {
    errno.EFBIG: "raise the limit of the size of a file: ulimit -f unlimited",
    errno.EMFILE: _DESCRIPTORS,
    errno.ENFILE: _DESCRIPTORS,
    errno.ETOOMANYREFS: _DESCRIPTORS,
    errno.EAGAIN: "raise the limit of processes, for example ulimit -u 4096, or take " + _FEWER,
    errno.ENOMEM: "free memory, or take " + _FEWER,
}


def limit_remedy(error: OSError, otherwise: str) -> str:
    """The remedy if a limit was met, else another one."""
    return _REMEDIES.get(error.errno or 0, otherwise)
