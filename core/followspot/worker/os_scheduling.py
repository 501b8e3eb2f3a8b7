"""Asks the operating system for the cores and the priority of a worker's thread, and of those it starts."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

from followspot.graph.scheduling import Scheduling

_RIGHTS = "run it with CAP_SYS_NICE, or have limits {limit} in /etc/security/limits.conf"


def apply_scheduling(wanted: Scheduling) -> Iterator[str]:
    """Schedule the calling thread, and threads that it starts, as wanted; a line for what the host refuses.

    Real time is for the calling thread alone: threads that it starts, such as those of libraries, are
    ordinary ones. Iterate to the end.
    """
    if wanted.cores:
        yield from _cores(wanted.cores)
    if wanted.nice:
        yield from _asked(
            lambda: os.setpriority(os.PRIO_PROCESS, 0, wanted.nice),
            f"nice {wanted.nice} is not allowed here",
            _RIGHTS.format(limit="nice"),
        )
    if wanted.realtime:
        policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        yield from _asked(
            lambda: os.sched_setscheduler(0, policy, os.sched_param(wanted.realtime)),
            f"real-time priority {wanted.realtime} is not allowed here, so the worker is an ordinary one",
            _RIGHTS.format(limit="rtprio"),
        )


def _cores(wanted: tuple[int, ...]) -> Iterator[str]:
    """Keep to those of the cores that the host gives this process."""
    allowed = os.sched_getaffinity(0)
    missing = [core for core in wanted if core not in allowed]
    if missing:
        have = " ".join(map(str, sorted(allowed)))
        kept = "; it keeps to the others" if len(missing) < len(wanted) else ""
        yield f"there is no core {' '.join(map(str, missing))} for it here{kept}\n    cores here: {have}"
    if found := set(wanted) & allowed:
        yield from _asked(
            lambda: os.sched_setaffinity(0, found), "its cores cannot be chosen here", "remove cores"
        )


def _asked(ask: Callable[[], object], text: str, remedy: str) -> Iterator[str]:
    try:
        ask()
    except OSError as error:
        yield f"{text} ({error.strerror})\n    {remedy}"
