"""The end of a run: when all hosts have ended, or early, with the reason."""

from __future__ import annotations

import time
from collections.abc import Sequence

from followspot.control.host import Host
from followspot.control.lifecycle import StopRun
from followspot.operator.silent_hosts import SilentHosts

_STOP_TIMEOUT = 20.0
"""Seconds that hosts have to end their workers after a stop."""
_DELIVERY_TIMEOUT = 5.0
"""Seconds after a stop in which the operator waits for a silent host, to deliver the stop to it."""


class RunEnd:
    """Decides when a run has ended, and ends it early.

    hosts: of the run, a list that grows when a host joins; silent: which of them do not answer; restart:
    whether hosts restart workers that die. A run without restarts ends if a host is lost.
    """

    def __init__(self, hosts: Sequence[Host], silent: SilentHosts, *, restart: bool) -> None:
        self.cut_short = ""
        """Why a run without restarts ended early: a host was lost, even if it came back."""
        self._hosts = hosts
        self._silent = silent
        self._restart = restart
        self._deadline: float | None = None
        """When hosts must have ended after a stop, s, monotonic; None before a stop."""

    def stop(self) -> None:
        """Ask every host to stop, once: workers finish the messages in flight."""
        if self._deadline is None:
            self._deadline = time.monotonic() + _STOP_TIMEOUT
            for host in self._hosts:
                host.ask(StopRun())

    @property
    def stopping(self) -> bool:
        """True after `stop`."""
        return self._deadline is not None

    def timed_out(self) -> bool:
        """True if hosts have not ended in time after a stop."""
        return self._deadline is not None and time.monotonic() > self._deadline

    def over(self) -> bool:
        """True if all workers of each host have ended, or if the operator no longer waits for the host."""
        return all(self._is_over(host) for host in self._hosts)

    def failed(self) -> bool:
        """True if a worker failed, or a host was lost in a run without restarts: either ends the run."""
        workers = (worker for host in self._hosts for worker in host.status().workers)
        lost = any(map(self._is_lost, self._hosts))
        return lost or any(w.phase == "over" and w.report and w.report.error for w in workers)

    def note_loss(self, host: Host) -> None:
        """Keep the reason if this host is lost and the run must therefore end early."""
        if self._deadline is None and self._is_lost(host):
            why = self._silent.reasons[host.name]
            self.cut_short = f"{why}: the run, which has no --restart, ended early"

    def _is_lost(self, host: Host) -> bool:
        """Whether a host does not answer, has workers at work, and the run cannot go on without it."""
        return host in self._silent and not (self._restart or host.status().all("over"))

    def _is_over(self, host: Host) -> bool:
        status = host.status()
        if host not in self._silent:
            return status.all("over")
        end = self._deadline
        undelivered = end is not None and time.monotonic() > end - _STOP_TIMEOUT + _DELIVERY_TIMEOUT
        ended = status.age_s is not None and status.all("over")
        return ended or undelivered or not self._restart
