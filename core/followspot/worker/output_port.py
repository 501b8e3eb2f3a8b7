"""The sending end of all edges of one output port."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from threading import Lock
from typing import Any

from followspot.messages import Array, Header, InvalidMessage, Message, seal, stamped
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.edge import PortWriter
from followspot.transport.token import ABSENT, END, Watermark
from followspot.worker.input_queue import InputQueue
from followspot.worker.ledger import AWAY, LOST, OVERRUN, PRODUCED, REFUSED, SHED

_PLENTY = 1 << 30
_TAPPING = Lock()
"""Taps come from any thread and go in that of the worker."""


class OutputPort:
    """One output port: it checks and stamps each message once and hands it to every edge.

    queues: readers in the same worker; writers: one for each kind of edge to other workers;
    rows: ledger rows of the edges behind each writer; lateness: see `InputQueue`.
    """

    __slots__ = (
        "_all_rows",
        "_away",
        "_living",
        "_lost",
        "counts",
        "edges",
        "lateness",
        "patient",
        "queues",
        "refused",
        "rows",
        "taps",
        "told",
        "type",
        "watermark",
        "words",
        "writers",
    )

    def __init__(self, kind: type[Message], words: memoryview, *, lateness: int) -> None:
        self.type = kind
        self.words = words
        self.lateness = lateness
        self.queues: list[InputQueue] = []
        self.writers: list[PortWriter] = []
        self.rows: list[list[int]] = []
        self.edges: list[tuple[str, int]] = []
        """Names and ledger rows of the edges to other workers that may be full."""
        self._all_rows: list[int] = []
        """Of every edge."""
        self._living: list[tuple[PortWriter, list[int]]] = []
        """Writers with the rows of their living readers."""
        self._away: list[int] = []
        """Rows of the edges whose readers are away."""
        self._lost: list[frozenset[int]] = []
        """Readers of each writer that are away, as of the last look."""
        self.counts = True
        """Whether `send` counts what is produced; a source with a thread of its own does so there."""
        self.taps: tuple[Callable[[Message], None], ...] = ()
        """Called with every message; see `followspot.worker.tapping`."""
        self.watermark = -END
        self.told = -END
        """What readers know: the bound, or that nothing comes for now."""
        self.refused: Callable[[str], None] = _nothing
        self.patient = False
        """Whether to wait for a reader that is away and will be back: in replays, which lose nothing."""

    def connect(self, queues: Sequence[InputQueue]) -> None:
        """Add edges to readers in the same worker."""
        self.queues += queues
        self._all_rows += [queue.row for queue in queues]

    def attach(self, writer: PortWriter, names: Sequence[str], rows: list[int]) -> None:
        """Add the edges to other workers that one writer serves; names, rows: of its readers in turn."""
        if isinstance(writer, DroppingWriter):
            writer.dropped = partial(self._count, rows, SHED)
            writer.refused = partial(self._refused_later, rows)
        else:
            self.edges += zip(names, rows, strict=True)
        self.writers.append(writer)
        self.rows.append(rows)
        self._all_rows += rows
        self.look()

    def look(self) -> None:
        """Take note of which readers are away: what is produced until they are back counts as such.

        What was on its way to one that died is lost. One that is there again is told how far the stream is.
        """
        for writer, rows in zip(self.writers, self.rows, strict=True):
            for index, count in writer.perished():
                self.words[rows[index] + LOST] += count
        lost = [writer.lost for writer in self.writers]
        if lost == self._lost:
            return
        before, self._lost = self._lost, lost
        self._living, self._away = [], []
        for writer, rows, gone in zip(self.writers, self.rows, lost, strict=True):
            self._living.append((writer, [row for index, row in enumerate(rows) if index not in gone]))
            self._away += [row for index, row in enumerate(rows) if index in gone]
        for writer, then, now in zip(self.writers, before, lost, strict=False):
            if then - now:
                self.returned(writer)

    def returned(self, writer: PortWriter) -> None:
        """Another reader is there: tell it how far the stream is."""
        if writer in self.writers and -END < self.told < END:
            writer.send(Watermark(self.told))

    def has_room(self) -> bool:
        """Whether every edge takes another message."""
        for queue in self.queues:
            if len(queue.messages) >= queue.depth:
                return False
        if not self.writers:
            return True
        if self.patient and any(writer.lost for writer in self.writers):
            return False
        return all(writer.credit() > 0 for writer in self.writers)

    def send(self, message: Message, header: Header) -> None:
        """Stamp, check and deliver; one that breaks its contract is counted as invalid on every edge."""
        words = self.words
        if self.counts:
            for row in self._all_rows:
                words[row + PRODUCED] += 1
        try:
            if header.time < self.watermark:
                raise InvalidMessage(
                    f"time {header.time} ns lies before {self.watermark} ns, which was settled"
                )
            if not message.header.source:  # else it was sent before, and sealed then
                seal(message)
        except InvalidMessage as error:
            self._refuse(str(error), header)
            return
        if message.header is not header:
            message = stamped(message, header)
        self.watermark = self.told = header.time + 1 + self.lateness
        for tap in self.taps:
            tap(message)
        for queue in self.queues:
            queue.put(message)
        for row in self._away:
            words[row + AWAY] += 1
        for writer, rows in self._living:
            try:
                writer.send(message)
            except InvalidMessage as error:  # its head is too large to travel
                self._count(rows, REFUSED)
                self.refused(str(error))

    def advance(self, watermark: int) -> None:
        """Tell every reader that nothing earlier than `watermark`, ns, will come."""
        if watermark <= self.watermark:
            return
        self.watermark = self.told = watermark
        for queue in self.queues:
            queue.advance(watermark)
        for writer in self.writers:
            writer.send(Watermark(watermark))

    def absent(self) -> None:
        """Nothing comes for now, for nothing comes in; readers need not wait."""
        if self.watermark == END:
            return
        self.told = ABSENT
        for queue in self.queues:
            queue.advance(ABSENT)
        for writer in self.writers:
            writer.send(Watermark(ABSENT))

    def end(self) -> None:
        """Nothing more will come."""
        self.advance(END)

    def produced(self) -> None:
        """Count a message that a live source has made, in the thread in which it made it."""
        self._count(self._all_rows, PRODUCED)

    def invalid(self) -> None:
        """Count a message that was produced and breaks its contract."""
        self._count(self._present(), REFUSED)
        self._count(self._away, AWAY)

    def overrun(self) -> None:
        """Count a message that a live source has made and dropped before it left, in that thread."""
        self._count(self._all_rows, OVERRUN)

    def tap(self, by: Callable[[Message], None]) -> None:
        """Call it with every message from now on. Safe from any thread."""
        with _TAPPING:
            self.taps = (*self.taps, by)

    def untap(self, by: Callable[[Message], None]) -> None:
        """Call it no more. Safe from any thread."""
        with _TAPPING:
            self.taps = tuple(tap for tap in self.taps if tap is not by)

    def loan(self, shape: tuple[int, ...], dtype: str) -> Array | None:
        """An array in the memory of the first writer that has one to lend."""
        for writer in self.writers:
            array: Array | None = writer.loan(shape, dtype)
            if array is not None:
                return array
        return None

    def _refuse(self, reason: str, header: Header) -> None:
        self.invalid()
        self.refused(reason)
        self.advance(header.time + 1)

    def _refused_later(self, rows: list[int], reason: str) -> None:
        """A message that had to wait turned out to be too large to travel."""
        self._count(rows, REFUSED)
        self.refused(reason)

    def _count(self, rows: list[int], column: int) -> None:
        for row in rows:
            self.words[row + column] += 1

    def _present(self) -> list[int]:
        """Rows of every edge whose reader is there."""
        return [queue.row for queue in self.queues] + [row for _, rows in self._living for row in rows]


def _nothing(_: Any) -> None:
    """Nobody listens for refusals."""
