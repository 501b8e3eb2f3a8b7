"""The status of the run of tools/soak.py: absent workers, used cameras, noticed faults."""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from followspot.control.unix_socket import socket_of
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan, PlannedEdge
from followspot.operator.run_handle import RunHandle
from followspot.operator.run_status import RunStatus
from followspot.worker.ledger import COUNTS, EdgeCount

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.promises.ledger_check import impossible

_PERIOD = 0.1
"""Seconds between two questions."""
_KEPT = 1200
"""Newest answers that are kept."""
_NETWORK = 0x40000000
"""CLONE_NEWNET of <sched.h>."""


class Observation(NamedTuple):
    """The run at one moment: s of the monotonic clock, news, workers that are away, blobs used by camera."""

    at: float
    news: Counter[str]
    away: frozenset[str]
    used: Mapping[str, int]


class Watch:
    """Asks a run for its status from a thread of its own, inside its network namespace."""

    def __init__(self, pid: int, space: str) -> None:
        """pid: of the run; space: name of the namespace."""
        self._pid = pid
        self._space = space
        self._observations: deque[Observation] = deque(maxlen=_KEPT)
        self.seen = 0
        """Number of statuses seen."""
        self.impossible: set[str] = set()
        """Impossible values of the ledger in a status."""
        self.news: set[str] = set()
        """All news of the run; a status has the newest only."""
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._keep_asking, name="watch", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Ask no more."""
        self._over.set()
        self._thread.join()

    def works(self, since: float, cameras: int) -> bool:
        """True if all workers work, and blobs of as many cameras were used after that time, s."""
        observations = [observation for observation in tuple(self._observations) if observation.at > since]
        if not observations or observations[-1].away:
            return False
        first, last = observations[0].used, observations[-1].used
        return sum(last[camera] > count for camera, count in first.items()) >= cameras

    def noticed(self, since: float) -> float | None:
        """Seconds until the run said that something was wrong; None if it never did."""
        observations = tuple(self._observations)
        before = [observation for observation in observations if observation.at <= since][-1]
        for observation in observations:
            new = [line for line in observation.news - before.news if not line.endswith("is back")]
            if observation.at > since and (new or observation.away - before.away):
                return observation.at - since
        return None

    def _keep_asking(self) -> None:
        _enter(self._space)
        plan: Plan | None = None
        while not self._over.wait(_PERIOD):
            with suppress(FollowspotError, OSError, StopIteration):  # it has not begun, or has ended
                run = RunHandle("", "", socket_of(self._socket(), "", self._pid), self._pid)
                plan = plan or run.plan()
                status = run.status()
                self._observations.append(_observation(status, plan))
                self.seen += 1
                self.impossible.update(
                    impossible(_columns(edge, count) for edge, count in status.edges(plan))
                )
                self.news.update(status.news)

    def _socket(self) -> str:
        """Raises StopIteration if the run has none yet."""
        begin = f"@followspot-{os.getuid()}-{self._pid}-"
        words = Path(f"/proc/{self._pid}/net/unix").read_text().split()
        return next(word[1:] for word in words if word.startswith(begin))


def _observation(status: RunStatus, plan: Plan) -> Observation:
    away = frozenset(worker.name for worker in status.workers if worker.phase not in ("running", "over"))
    edges = [(edge, count) for edge, count in status.edges(plan) if edge.to_stage == "verify"]
    used = {edge.from_stage: count.delivered for edge, count in edges if not edge.delay}
    return Observation(time.monotonic(), Counter(status.news), away, used)


def _columns(edge: PlannedEdge, count: EdgeCount) -> dict[str, Any]:
    """In the form of a run's summary."""
    ends = {"from": f"{edge.from_stage}.{edge.from_port}", "to": f"{edge.to_stage}.{edge.to_port}"}
    return {**ends, **{name: getattr(count, name) for name in COUNTS}}


def _enter(space: str) -> None:
    """Let the calling thread, and it alone, see the network of a namespace. Raises OSError."""
    with Path(f"/run/netns/{space}").open() as file:
        if ctypes.CDLL(None, use_errno=True).setns(file.fileno(), _NETWORK):
            raise OSError(ctypes.get_errno(), f"namespace {space} cannot be entered")
