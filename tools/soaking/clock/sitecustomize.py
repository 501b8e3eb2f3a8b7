"""The wall clock of a host in tools/soak.py: imported by Python at its start; a file says how wrong it is.

The kernel has one wall clock for all namespaces, so processes of a host are made to read it with an error.
"""

from __future__ import annotations

import mmap
import os
import struct
import time
from collections.abc import Callable
from pathlib import Path


def wrong(clock: Callable[[], int], file: Path) -> Callable[[], int]:
    """The clock, ns, plus what the 8 bytes of the file say at that moment, ns."""
    with file.open("rb") as opened:
        words = mmap.mmap(opened.fileno(), 8, access=mmap.ACCESS_READ)
    error = struct.Struct("<q")
    return lambda: clock() + int(error.unpack(words)[0])


if "SOAK_CLOCK" in os.environ:
    time.time_ns = wrong(time.time_ns, Path(os.environ["SOAK_CLOCK"]))
