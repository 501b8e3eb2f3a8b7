"""Which messages belong to a marked moment: of each port, up to some seconds after the mark."""

from __future__ import annotations

from collections.abc import Iterator

from followspot.frame_times import to_ns
from followspot_record.flight.kept_messages import KeptMessage, KeptMessages

_GRACE = 2.0
"""Seconds that a port has, beyond those after the mark, to send what belongs to the moment."""


class MomentSpan:
    """Grows with every mark; each message is given once."""

    def __init__(self) -> None:
        self._ends: dict[str, int] = {}
        """Capture time up to which messages of a port belong to the moment, ns."""
        self._given: dict[str, int] = {}
        """Number of arrival of the last message of a port that was given."""
        self._after = 0
        self._deadline = 0.0

    def extend(self, kept: KeptMessages, after: float, now: float) -> Iterator[KeptMessage]:
        """Add a mark: the messages that are held and were not given yet. after, now: s.

        An earlier mark with more seconds after it keeps them.
        """
        self._after = max(self._after, to_ns(after))
        self._deadline = max(self._deadline, now + after + _GRACE)
        for message in kept.after(dict(self._given)):
            self._given[message.port] = message.number
            yield message
        for port in kept.ports:
            end = kept.newest(port) + to_ns(after)
            self._ends[port] = max(end, self._ends.get(port, end))

    def takes(self, message: KeptMessage) -> bool:
        """Whether a message that has just come belongs to the moment; it then counts as given."""
        end = self._ends.setdefault(message.port, message.time + self._after)
        if message.time > end:
            return False
        self._given[message.port] = message.number
        return True

    def over(self, kept: KeptMessages, now: float) -> bool:
        """Whether nothing more belongs to the moment. now: s."""
        passed = all(kept.newest(port) > end for port, end in self._ends.items())
        return now >= self._deadline or (passed and bool(self._ends))
