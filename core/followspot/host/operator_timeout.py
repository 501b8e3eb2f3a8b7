"""What a host makes of an operator that falls silent: it goes on, says so, and gives up in the end.

A cable that is out, a router that is away, a desk that is suspended and one that died look alike from here.
"""

from __future__ import annotations

OPERATOR_TIMEOUT = 3600.0
"""Seconds without a word of its operator after which a host ends its part of a run, unless told otherwise."""
SILENT = 10.0
"""Seconds after which an operator counts as silent; it asks five times a second."""
_PAUSE = 2.0
"""Seconds between two looks that say that it was this process that slept."""


class Absence:
    """Of the operator of one run. Times are those of the monotonic clock, s."""

    def __init__(self, timeout: float | None, now: float) -> None:
        """timeout: seconds after which it is given up, None for a run that goes on alone."""
        self._timeout = timeout
        self._heard = self._looked = now
        self._silent_since: float | None = None
        self.discarded = False
        """Whether nobody is expected to come back; it stays so."""

    def heard(self, now: float) -> None:
        """An operator has asked for the run."""
        self._heard = now

    @property
    def silent(self) -> bool:
        """Whether nobody has asked for a while, at the last look."""
        return self._silent_since is not None

    def seconds(self, now: float) -> float:
        """How long nobody has asked."""
        return now - self._heard

    def look(self, now: float) -> str:
        """What is to be said of the operator since the last look, "" for nothing."""
        if now - self._looked > _PAUSE:  # nobody could be heard meanwhile
            self._heard = min(now, self._heard + now - self._looked)
        self._looked = now
        if self._timeout is None or self.discarded:
            return ""
        if now - self._heard > self._timeout:
            self.discarded = True
            return f"the operator was silent for {self._timeout:g} s: what runs here is ended"
        if now - self._heard <= SILENT:
            since, self._silent_since = self._silent_since, None
            return "" if since is None else f"the operator is back after {self._heard - since:.0f} s"
        if self._silent_since is not None:
            return ""
        self._silent_since = self._heard
        return f"the operator is silent: what runs here goes on for {self._timeout:g} s"
