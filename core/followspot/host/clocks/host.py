"""The clocks of a host: compared with those of the run's reference host throughout the run."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from followspot.control.clock_status import LIMIT_MS, ClockStatus
from followspot.control.observation import ClockReading, ReadClock
from followspot.control.worker_orders import Correction
from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.host.clocks.filter import ClockFilter, Exchange
from followspot.operating_system.wall_clock import lead, set_since

if TYPE_CHECKING:
    from followspot.control.zenoh_rpc import RpcClient

_PERIOD = 1.0
"""Seconds between two exchanges."""
_FIRST_EXCHANGES = 8
"""Exchanges before a run begins."""
_TIMEOUT = 1.0
_NOTICEABLE = 20_000
"""Smallest change of a correction that is reported, ns."""


def reference(plan: Plan) -> str:
    """The reference host of a run: the first that has an agent, "" if there is none."""
    return next((worker.host for worker in plan.workers if worker.host), "")


class HostClock:
    """Offsets from this host's clocks to the run's reference clock, measured in a thread.

    known: delay of this host's clock that its owner has configured, ns.
    """

    def __init__(self, client: RpcClient | None = None, known: int = 0) -> None:
        """client: reaches the agents; None if the run has no other host."""
        self.known = known
        self._client = client
        self._reference = self._run = ""
        self._filter = ClockFilter()
        self._closed = threading.Event()
        self._lead = lead()
        """The lead of the wall clock when the run was prepared: the run's times go on if the clock is set."""
        self._step_told = 0
        self._reported = (0, 0, self._lead)
        self._thread: threading.Thread | None = None

    def follow(self, host: str, run: str = "") -> None:
        """Compare with this host a few times now, then until `close`. Only the first call has an effect.

        run: whose times are compared, "" for the wall clock of that host.
        """
        if self._client is None or self._reference:
            return
        self._reference, self._run = host, run
        for _ in range(_FIRST_EXCHANGES):
            if not self._compare(self._client):
                break  # the host may be busy preparing a run
        self._thread = threading.Thread(
            target=self._keep_comparing, args=(self._client,), name="clock", daemon=True
        )
        self._thread.start()

    def correction(self) -> Correction:
        """Offsets to add to capture times and to the monotonic clock of this host, ns, and the lead that the
        wall clock has over it if the first of them is right.
        """
        offset = self._filter.offset() or Exchange(0, 0, 0)
        return self.known + offset.captured, offset.steady, self._lead

    def read(self) -> ClockReading:
        """Readings of this host's clocks now, for other hosts to compare with."""
        return ClockReading(time.time_ns() + self.known - set_since(self._lead), time.monotonic_ns())

    def step_news(self) -> int | None:
        """Step of the wall clock since the run was prepared, ns; None if it was reported already."""
        step = set_since(self._lead)
        if abs(step - self._step_told) < LIMIT_MS * 1e6:
            return None
        self._step_told = step
        return step

    def news(self) -> Correction | None:
        """The correction if it differs noticeably from the last reported one, else None."""
        now = self.correction()
        if max(abs(new - old) for new, old in zip(now, self._reported, strict=True)) < _NOTICEABLE:
            return None
        self._reported = now
        return now

    def status(self) -> ClockStatus:
        """The status of the clock, in ms."""
        offset = self._filter.offset() or Exchange(0, 0, 0)
        captured = offset.captured - set_since(self._lead) if self._filter.exchanges else 0
        captured_ms, round_trip = round(captured / 1e6, 3), round(offset.round_trip / 1e6, 3)
        return ClockStatus(self._reference, captured_ms, round_trip, self._filter.exchanges)

    def close(self) -> None:
        """Stop comparing; wait for a pending request, because Zenoh must not outlive the interpreter."""
        self._closed.set()
        if self._thread is not None:
            self._thread.join(2 * _TIMEOUT)

    def _keep_comparing(self, client: RpcClient) -> None:
        while not self._closed.wait(_PERIOD):
            self._compare(client)

    def _compare(self, client: RpcClient) -> bool:
        """Make one exchange; False if there was no answer."""
        import zenoh  # only runs with other hosts need it

        wall, sent = self.read().captured, time.monotonic_ns()
        try:
            read = client.ask(self._reference, ReadClock(run=self._run), _TIMEOUT)
        except (FollowspotError, zenoh.ZError):
            return False
        round_trip = time.monotonic_ns() - sent
        half = round_trip // 2
        self._filter.add(Exchange(read.captured - (wall + half), read.steady - (sent + half), round_trip))
        return True
