"""Flow control of an edge over Zenoh: the readers that a writer knows, and the credit that they give.

Zenoh's threads call `take_report`, `take_presence` and `take_end`, which only take notes. The worker's thread
does the rest.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple
from urllib.parse import quote

import zenoh

from followspot.transport.keys import OPERATOR
from followspot.transport.zenoh.terms import CREDIT, WINDOW, chunks, is_incarnation, numbers


@dataclass(eq=False)
class ReaderRecord:
    """The state of one reader at its writer.

    name: percent-encoded; host: of the reader, reports from others do not count.
    """

    name: str
    host: str
    lost: bool
    """Whether it is away before the end; it holds up nothing then."""
    incarnation: int = -1
    """Latest incarnation that was ever there; -1 before the first."""
    present: bool = False
    arrivals: int = 0
    """How often it came."""
    silent: bool = False
    """Whether it has not reported since it was told where to start."""
    dismissed: bool = False
    """Whether its edge has left the graph."""
    done_incarnation: int = -1
    """Latest incarnation that has taken the end of this writer's stream; -1 before the first."""
    given: int = 0
    """Messages put since its present incarnation came."""
    consumed: int = 0
    """Messages consumed, as it reported."""
    taken: int = 0
    """Tokens taken, as it reported."""
    messages_before_it_left: int | None = None
    """Messages that had been put when it left; None while it is present."""

    @property
    def done(self) -> bool:
        """Whether it gets nothing more: its present incarnation has taken the end of this writer's stream."""
        return self.dismissed or 0 <= self.done_incarnation == self.incarnation


class _Change(NamedTuple):
    """One change of an incarnation of a reader, as its liveliness tokens say.

    missing: it came, it does not report, and it has no token.
    """

    reader: ReaderRecord
    incarnation: int
    kind: Literal["came", "left", "done", "missing"]
    arrivals: int = 0
    """Of a missing reader: how often it had come when it was asked for."""


class FlowControl:
    """The readers of one port, and how much may be sent to them."""

    def __init__(
        self, readers: Mapping[str, str], depth: int, incarnation: int, wake: Callable[[], None]
    ) -> None:
        """readers: the host of each, by its name; depth: messages in flight; incarnation: the writer's.

        wake: called in a thread of Zenoh when there are changes to take over.
        """
        self.readers = tuple(
            ReaderRecord(quote(name, safe=""), host or OPERATOR, lost=incarnation > 0)
            for name, host in readers.items()
        )
        self.tokens = 0
        """Tokens put so far."""
        self.messages = 0
        """Messages put so far."""
        self.refused = 0
        """Reports and liveliness tokens that were malformed, or not from the reader's host."""
        self._depth = depth
        self._incarnation = incarnation
        self._wake = wake
        self._by_name = {reader.name: reader for reader in self.readers}
        self._changes: deque[_Change] = deque()
        self._deaths: list[tuple[int, int]] = []

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that are away before the end."""
        return frozenset(index for index, reader in enumerate(self.readers) if reader.lost)

    @property
    def ended(self) -> bool:
        """Whether every reader that is not lost has taken the end."""
        return all(reader.done or reader.lost for reader in self.readers)

    @property
    def all_taken(self) -> bool:
        """Whether every reader that is not lost has reported to have taken all tokens."""
        return all(reader.taken == self.tokens for reader in self._living())

    def dismiss(self, index: int) -> None:
        """Forget a reader: whether it comes or goes means nothing any more."""
        reader = self.readers[index]
        reader.dismissed, reader.silent, reader.lost = True, False, False
        reader.messages_before_it_left = None

    def deaths(self) -> list[tuple[int, int]]:
        """See `PortWriter.newly_dead`."""
        deaths, self._deaths = self._deaths, []
        return deaths

    def credit(self) -> int:
        """How many messages may be sent now; the depth if no reader is left."""
        readers = self._living()
        if not readers:
            return self._depth
        if self.window_is_full():
            return 0
        return max(0, self._depth - self.messages + min([reader.consumed for reader in readers]))

    def window_is_full(self) -> bool:
        """Whether as many tokens are on their way to the slowest reader as may be."""
        return any(self.tokens - reader.taken >= WINDOW for reader in self._living())

    def count_message(self) -> None:
        """The next token is a message, for every reader that is present."""
        self.messages += 1
        for reader in self.readers:
            reader.given += reader.present

    def lose_all(self) -> None:
        """The session is closed: no reader can be reached."""
        for reader in self.readers:
            reader.present = False
            reader.lost = not reader.done

    def changes(self) -> Iterator[ReaderRecord]:
        """Take over what Zenoh's threads noted; yields each reader that joins: tell it where it starts."""
        while self._changes:
            reader, incarnation, kind, arrivals = self._changes.popleft()
            if reader.dismissed:
                continue
            if kind == "done":
                reader.done_incarnation = max(reader.done_incarnation, incarnation)
            elif incarnation < reader.incarnation:
                continue  # another incarnation has taken its place
            elif kind == "came":
                self._join(reader, incarnation)
                yield reader
            elif kind == "missing" and not (reader.silent and reader.arrivals == arrivals):
                continue  # it has come again or reported since it was asked for
            elif reader.present and reader.incarnation == incarnation:
                reader.present = reader.silent = False
                reader.messages_before_it_left = self.messages
                reader.lost = not reader.done

    def close(self) -> None:
        """Readers that were cut off and did not come back count as dead."""
        for reader in self.readers:
            if reader.messages_before_it_left is not None:
                self._note_death(reader)

    def take_report(self, sample: zenoh.Sample) -> bool:
        """Note the report of a reader; returns whether there may be more credit now."""
        host, _, name = chunks(sample, 3)
        reader = self._reader(host, name)
        report = numbers(CREDIT, sample.payload)
        if reader is None or report is None:
            self.refused += 1
            return False
        writer, incarnation, consumed, taken = report
        if (writer, incarnation) != (self._incarnation, reader.incarnation):
            return False  # it is not the present one that speaks, or not to this one
        if consumed > min(taken, self.messages) or taken > self.tokens:
            self.refused += 1
            return False
        reader.consumed = max(reader.consumed, consumed)  # credit that was given is never taken back:
        reader.taken = max(reader.taken, taken)  # a stage that has asked for it may be about to send
        reader.silent = False
        return True

    def take_presence(self, sample: zenoh.Sample) -> None:
        """Note that a reader came or left."""
        host, role, name, incarnation = chunks(sample, 4)
        there = sample.kind == zenoh.SampleKind.PUT
        reader = self._reader(host, name)
        if reader is None or role != "alive" or not is_incarnation(incarnation):
            self.refused += there
        else:
            self._changes.append(_Change(reader, int(incarnation), "came" if there else "left"))
            self._wake()

    def take_end(self, sample: zenoh.Sample) -> None:
        """Note that a reader has taken the end of this stream."""
        host, _, name, incarnation, writer = chunks(sample, 5)
        there = sample.kind == zenoh.SampleKind.PUT
        reader = self._reader(host, name)
        if reader is None or not (is_incarnation(incarnation) and is_incarnation(writer)):
            self.refused += there
        elif there and int(writer) == self._incarnation:
            self._changes.append(_Change(reader, int(incarnation), "done"))
            self._wake()

    def take_absence(self, reader: ReaderRecord, incarnation: int, arrivals: int) -> None:
        """Note that a silent reader has no liveliness token. arrivals: of it, when it was asked for."""
        self._changes.append(_Change(reader, incarnation, "missing", arrivals))
        self._wake()

    def _join(self, reader: ReaderRecord, incarnation: int) -> None:
        """Count a reader that has joined from now on; messages before are none that it missed."""
        if reader.incarnation not in (-1, incarnation):
            self._note_death(reader)
        if reader.incarnation != incarnation:
            reader.given = 0
        reader.messages_before_it_left = None
        reader.consumed, reader.taken = self.messages, self.tokens
        reader.present, reader.incarnation = True, incarnation
        reader.arrivals += 1
        reader.lost, reader.silent = False, True

    def _note_death(self, reader: ReaderRecord) -> None:
        """Count the messages that were put until the reader left and that it has not reported."""
        left, reader.messages_before_it_left = reader.messages_before_it_left, None
        sent = self.messages if left is None else left
        self._deaths.append((self.readers.index(reader), max(0, sent - reader.consumed)))

    def _living(self) -> list[ReaderRecord]:
        """Readers that are not lost and have not taken the end."""
        return [reader for reader in self.readers if not (reader.lost or reader.done)]

    def _reader(self, host: str, name: str) -> ReaderRecord | None:
        """The reader of this name; None if there is none on this host."""
        reader = self._by_name.get(name)
        return reader if reader is not None and reader.host == host else None
