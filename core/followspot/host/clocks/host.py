"""The clocks of a host in a run on several: compared with those of one of them, all the time."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from followspot.control.clock_status import ClockStatus
from followspot.control.observation import ClockReading, ReadClock
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.host.clocks.filter import ClockFilter, Exchange

if TYPE_CHECKING:
    from followspot.control.zenoh_rpc import RpcClient

_PERIOD = 1.0
"""Seconds between two questions."""
_FIRST = 8
"""Questions before a run begins."""
_TIMEOUT = 1.0
_NOTICEABLE = 20_000
"""ns by which a correction must change to be worth telling."""


def reference(plan: Plan) -> str:
    """The host by whose clock a run goes: the first that has an agent; "" where there is none."""
    return next((worker.host for worker in plan.workers if worker.host), "")


class HostClock:
    """Asks the reference how late it is, from a thread of its own.

    known: what the owner of this host knows its clock to be behind, ns.
    """

    def __init__(self, client: RpcClient | None = None, known: int = 0) -> None:
        """asker: speaks with agents; None where the run has no other host."""
        self.known = known
        self._client = client
        self._reference = ""
        self._filter = ClockFilter()
        self._over = threading.Event()
        self._told = (0, 0)
        self._thread: threading.Thread | None = None

    def follow(self, host: str) -> None:
        """Compare with this host: a few times now, then until `close`. Who follows one follows no other."""
        if self._client is None or self._reference:
            return
        self._reference = host
        for _ in range(_FIRST):
            if not self._compare(self._client):
                break  # it may be busy beginning a run that goes by our clock
        self._thread = threading.Thread(
            target=self._keep_comparing, args=(self._client,), name="clock", daemon=True
        )
        self._thread.start()

    def correction(self) -> tuple[int, int]:
        """What to add to capture times and to the monotonic clock of this host, ns."""
        offset = self._filter.offset()
        return (self.known, 0) if offset is None else (self.known + offset.captured, offset.steady)

    def news(self) -> tuple[int, int] | None:
        """The correction where it is another than what was told last."""
        now = self.correction()
        if max(abs(new - old) for new, old in zip(now, self._told, strict=True)) < _NOTICEABLE:
            return None
        self._told = now
        return now

    def status(self) -> ClockStatus:
        """As people want to know it."""
        offset = self._filter.offset() or Exchange(0, 0, 0)
        captured, round_trip = round(offset.captured / 1e6, 3), round(offset.round_trip / 1e6, 3)
        return ClockStatus(self._reference, captured, round_trip, self._filter.exchanges)

    def close(self) -> None:
        """Ask no more. A question that is under way is waited for: Zenoh must not outlive the interpreter."""
        self._over.set()
        if self._thread is not None:
            self._thread.join(2 * _TIMEOUT)

    def _keep_comparing(self, client: RpcClient) -> None:
        while not self._over.wait(_PERIOD):
            self._compare(client)

    def _compare(self, client: RpcClient) -> bool:
        """Ask once; whether there was an answer."""
        import zenoh  # only where there are other hosts

        wall, sent = time.time_ns() + self.known, time.monotonic_ns()
        try:
            read = client.ask(self._reference, ReadClock(), _TIMEOUT)
        except (FollowspotError, zenoh.ZError):
            return False
        round_trip = time.monotonic_ns() - sent
        half = round_trip // 2
        self._filter.add(Exchange(read.captured - (wall + half), read.steady - (sent + half), round_trip))
        return True


def read_clock(known: int) -> ClockReading:
    """What the clocks of this host read now, for others to compare with; known: as in `HostClock`."""
    return ClockReading(time.time_ns() + known, time.monotonic_ns())
