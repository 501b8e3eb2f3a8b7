"""Detects that the operator of a run has gone silent, and ends the run after a timeout.

A host cannot tell an unplugged cable, a router that is down, a suspended operator and a dead one apart.
"""

from __future__ import annotations

OPERATOR_TIMEOUT = 3600.0
"""Default of the seconds without a request of the operator after which a host ends its workers."""
SILENT = 10.0
"""Seconds after which an operator counts as silent; it polls five times a second."""
_PAUSE = 2.0
"""Seconds between two checks above which this process itself was suspended."""


class OperatorTimeout:
    """The timeout of the operator of one run. All times are monotonic, s."""

    def __init__(self, timeout: float | None, now: float) -> None:
        """timeout: seconds of silence after which the run ends, None for a detached run."""
        self._timeout = timeout
        self._heard = self._checked = now
        self._silent_since: float | None = None
        self.timed_out = False
        """True once the timeout has passed; the run is then ended."""

    def note_request(self, now: float) -> None:
        """Note a request of an operator."""
        self._heard = now

    @property
    def silent(self) -> bool:
        """True if the operator was silent at the last check."""
        return self._silent_since is not None

    def seconds(self, now: float) -> float:
        """Time since the last request, s."""
        return now - self._heard

    def check(self, now: float) -> str:
        """Update the state; return a line for the log if it has changed, else ""."""
        if now - self._checked > _PAUSE:  # this process could not hear requests
            self._heard = min(now, self._heard + now - self._checked)
        self._checked = now
        if self._timeout is None or self.timed_out:
            return ""
        if now - self._heard > self._timeout:
            self.timed_out = True
            return f"the operator was silent for {self._timeout:g} s: what runs here is ended"
        if now - self._heard <= SILENT:
            since, self._silent_since = self._silent_since, None
            return "" if since is None else f"the operator is back after {self._heard - since:.0f} s"
        if self._silent_since is not None:
            return ""
        self._silent_since = self._heard
        return f"the operator is silent: what runs here goes on for {self._timeout:g} s"
