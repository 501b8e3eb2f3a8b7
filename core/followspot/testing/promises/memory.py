"""The promise that a stage does not use more and more memory."""

from __future__ import annotations

import gc
import logging
import mmap
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

from followspot.testing.trial import Trial, noise

GROWTH = 8 << 20
"""Bytes that a stage may grow by while it handles a third of many messages."""
CACHED = 64
"""Objects that numpy and Python may keep for reuse meanwhile; the number differs between machines."""


def keeps_its_memory(trial: Trial) -> Iterator[str]:
    """A show lasts hours: a stage may not keep objects or memory for each message.

    Memory that a stage needs once, such as a cache, does not count. So the growth is measured over the second
    and over the last third of the messages, and the smaller of the two is taken.
    """
    if not trial.computes or trial.messages < 3:
        return
    third = trial.messages // 3
    frames = [trial.inputs("plausible", n, noise(n)) for n in range(8)]
    frozen = gc.get_freeze_count()  # objects that the caller has frozen: they stay so
    gc.freeze()  # collections then examine new objects only
    disabled = logging.root.manager.disable
    logging.disable()  # pytest keeps log records in memory
    try:
        with trial.at_work() as stage:
            sizes = []
            for _ in range(3):
                for n in range(third):
                    trial.called(stage, frames[n % len(frames)])
                gc.collect()
                sizes.append((sys.getallocatedblocks(), _resident()))
    except Exception:
        return  # the promises about `process` report it
    finally:
        logging.disable(disabled)
        if not frozen:
            gc.unfreeze()
    objects, size = (min(later - sooner for sooner, later in pairwise(of)) for of in zip(*sizes, strict=True))
    if objects > CACHED + third // 2:
        yield f"it keeps {objects / third:.1f} objects a message"
    if size > GROWTH:
        yield f"it grows by {size / third:.0f} bytes a message"


def _resident() -> int:
    """Memory of this process, bytes; 0 if the system does not report it."""
    statistics = Path("/proc/self/statm")
    return int(statistics.read_text().split()[1]) * mmap.PAGESIZE if statistics.exists() else 0
