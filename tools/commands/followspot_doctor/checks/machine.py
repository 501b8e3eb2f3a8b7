"""The computer itself: cores, memory, open files, shared memory, disk and clock."""

from __future__ import annotations

import ctypes
import mmap
import os
import platform
import resource
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from followspot_doctor.finding import Finding, doubtful, fine, wrong

FEWEST_FILES = 256
"""A worker needs three for each edge to another worker, and some for its cameras."""
LITTLE_MEMORY = 2 << 30
LITTLE_DISK = 1 << 30
NOT_SYNCHRONISED = 5
"""Result of adjtimex while no time service steers the clock (TIME_ERROR)."""


def computer() -> Iterator[Finding]:
    """Cores and memory; a GPU is not used."""
    cores = len(os.sched_getaffinity(0))
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    python = platform.python_version()
    text = f"{platform.machine()}, {cores} cores, {memory / 2**30:.0f} GiB, Python {python}, no GPU used"
    if cores < 2:
        yield doubtful("computer", text, "workers share one core: give the machine two or more")
    elif memory < LITTLE_MEMORY:
        yield doubtful("computer", text, "frames of many cameras need more than 2 GiB")
    else:
        yield fine("computer", text)


def open_files() -> Iterator[Finding]:
    """The limit that a graph of many workers meets first."""
    limit, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    text = f"{limit} at a time"
    if limit < FEWEST_FILES:
        remedy = f"ulimit -n {min(4096, most)}; or raise nofile in /etc/security/limits.conf"
        yield wrong("open files", text, remedy)
    else:
        yield fine("open files", text)


def shared_memory() -> Iterator[Finding]:
    """Check shared memory, which the rings between workers use."""
    try:
        fd = os.memfd_create("followspot-doctor", os.MFD_CLOEXEC)
        try:
            os.ftruncate(fd, mmap.PAGESIZE)
            with mmap.mmap(fd, mmap.PAGESIZE) as memory:
                memory[0] = 1
        finally:
            os.close(fd)
    except (AttributeError, OSError) as error:
        yield doubtful("shared memory", f"not to be had: {error}", "frames go over Zenoh: --edges zenoh")
    else:
        yield fine("shared memory", "rings between workers work")


def output_folder(out: Path) -> Iterator[Finding]:
    """Check that results can be written, and how much space there is."""
    name = "output folder"
    place = next(folder for folder in (out, *out.absolute().parents) if folder.exists())
    try:
        with tempfile.NamedTemporaryFile(dir=place):
            pass
    except OSError as error:
        yield wrong(name, f"{out} cannot be written: {error.strerror}", "choose another with --out")
        return
    free = shutil.disk_usage(place).free
    text = f"{out}: {free / 2**30:.1f} GiB free"
    if free < LITTLE_DISK:
        yield doubtful(name, text, "free space, or choose another disk with --out; recordings need most")
    else:
        yield fine(name, text)


def clock() -> Iterator[Finding]:
    """Check that a time service steers the clock; cameras on several hosts need that."""
    state = ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.create_string_buffer(512))
    if state == NOT_SYNCHRONISED:
        remedy = "matters with cameras on several hosts: install chrony, or ptp4l"
        yield doubtful("clock", "no time service keeps it", remedy)
    else:
        yield fine(
            "clock",
            "kept by a time service" if state >= 0 else "kept by an unknown service",
        )
