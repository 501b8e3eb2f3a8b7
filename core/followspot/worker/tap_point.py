"""A place whose messages can be tapped while a graph runs: an output port, or the journal of a stage."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock

from followspot.messages import Message

_TAPPING = Lock()
"""Guards the taps of all places: any thread adds taps, the worker's thread removes them."""


class TapPoint:
    """Calls `taps` with every message; see `followspot.worker.taps.port_taps`."""

    __slots__ = ("taps",)

    def __init__(self) -> None:
        self.taps: tuple[Callable[[Message], None], ...] = ()

    def tap(self, by: Callable[[Message], None]) -> None:
        """Call `by` with every message from now on. Safe from any thread."""
        with _TAPPING:
            self.taps = (*self.taps, by)

    def untap(self, by: Callable[[Message], None]) -> None:
        """Call `by` no more. Safe from any thread."""
        with _TAPPING:
            self.taps = tuple(tap for tap in self.taps if tap is not by)
