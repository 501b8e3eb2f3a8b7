"""Runs that operators left with an agent when they died: ended by the next operator of the same machine."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress

from followspot.deploy.absence import SILENT
from followspot.deploy.host import HostRefused, status_from_data
from followspot.deploy.listing import parts_of
from followspot.deploy.origin import Origin
from followspot.deploy.requests import Asker

_ENDING = 20.0
"""Seconds that workers may take to complete their outputs."""
_GLANCE = 0.1
"""Seconds between two looks at them."""


def end_left_behind(asker: Asker, host: str, here: Origin) -> Iterator[str]:
    """End what dead operators of this machine left with an agent; a line for each, and for who is silent.

    Raises HostLost, FollowspotError, ValueError.
    """
    try:
        parts = parts_of(asker, host)
    except HostRefused:  # who may not know may not begin a run either, and is told so then
        return
    for part in parts:
        if part.over or part.detached:
            continue
        name = f"run {part.run[:8]} of {part.graph}"
        if part.origin.dead(here):
            with suppress(HostRefused):  # somebody else was faster
                _end(asker, host, part.run)
            yield f"{name} was left there by a process of this machine that has died; it was ended"
        elif part.silent_s > SILENT:
            yield (
                f"{name} goes on there, whose operator has been silent for {part.silent_s:.0f} s; "
                f"followspot attach {part.run[:8]} --stop ends it"
            )


def _end(asker: Asker, host: str, run: str) -> None:
    """As its operator would: outputs are complete."""
    asker.ask(host, "stop", run=run)
    deadline = time.monotonic() + _ENDING
    while time.monotonic() < deadline:
        if status_from_data(asker.ask(host, "status", run=run)).all("over"):
            break
        time.sleep(_GLANCE)
    asker.ask(host, "close", run=run)
