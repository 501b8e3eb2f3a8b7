"""An output port: the sending end of all its edges, their watermark, and their backpressure."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from threading import Lock

from followspot.context import SourceLoss
from followspot.messages import Array, Header, InvalidMessage, Message, seal, stamped
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.edge import PortWriter
from followspot.transport.token import ABSENT, END, UNKNOWN, Watermark
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import (
    AWAY,
    FILLED,
    LOST,
    OVERRUN,
    PRODUCED,
    REFUSED,
    SHED,
    SOURCE_LOSSES,
)

_NONE = -1
"""Stands for the row of an edge that has left the graph: its reader keeps its index in the writer."""
_TAPPING = Lock()
"""Guards the taps of all ports: any thread adds taps, the worker's thread removes them."""


class OutputPort:
    """One output port: checks and stamps each message once, and sends it along every edge.

    queues: readers in the same worker; writers: one for each kind of edge to other workers;
    rows: ledger rows of the edges behind each writer; lateness: see `InputQueue`.
    """

    __slots__ = (
        "_away",
        "_living",
        "_lost",
        "all_rows",
        "announced",
        "counts",
        "edges",
        "filled",
        "lateness",
        "queues",
        "refused",
        "rows",
        "taps",
        "type",
        "waits_for_readers",
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
        """Names and ledger rows of the edges to other workers that exert backpressure."""
        self.all_rows: list[int] = []
        """Ledger rows of all edges."""
        self._living: list[tuple[PortWriter, list[int]]] = []
        """Writers with the rows of their living readers."""
        self._away: list[int] = []
        """Ledger rows of the edges whose readers are away."""
        self._lost: list[frozenset[int]] = []
        """Readers of each writer that were away at the last update."""
        self.counts = True
        """Whether `send` counts messages as produced; a live source counts them in its thread."""
        self.taps: tuple[Callable[[Message], None], ...] = ()
        """Called with every message; see `followspot.worker.taps.port_taps`."""
        self.filled = False
        """Whether a message that was sent had rows."""
        self.watermark = -END
        self.announced = -END
        """What readers were told last: the watermark, or `ABSENT`."""
        self.refused: Callable[[str], None] = lambda reason: None
        self.waits_for_readers = False
        """Whether to wait for a reader that is away and comes back: in replays, which lose nothing."""

    def connect(self, queues: Sequence[InputQueue]) -> None:
        """Add edges to readers in the same worker."""
        self.queues += queues
        rows = [queue.row for queue in queues]
        self.all_rows += rows
        self._fill(rows)

    def reconnect(self, queues: Sequence[InputQueue], waiting: int = 0) -> None:
        """Replace the readers in the same worker.

        waiting: messages that count as produced and are yet to be sent, then to the new readers.
        """
        before = self.all_rows
        far = [row for rows in self.rows for row in rows if row != _NONE]
        self.queues = list(queues)
        self.all_rows = [queue.row for queue in queues] + far
        self.recount(before, waiting)
        self._fill(self.all_rows)

    def recount(self, before: Collection[int], waiting: int) -> None:
        """Move the counts of produced messages that are yet to be sent to the edges that are there now.

        before: ledger rows of the edges before; waiting: how many messages.
        """
        for row in self.all_rows:
            self.words[row + PRODUCED] += 0 if row in before else waiting
        for row in before:
            self.words[row + PRODUCED] -= 0 if row in self.all_rows else waiting

    def attach(self, writer: PortWriter, names: Sequence[str], rows: list[int]) -> None:
        """Add the edges to other workers that one writer serves; names, rows: of its readers in turn."""
        if isinstance(writer, DroppingWriter):
            writer.dropped = partial(self._count, rows, SHED)
            writer.refused = partial(self._refused_later, rows)
        else:
            self.edges += zip(names, rows, strict=True)
        self.writers.append(writer)
        self.rows.append(rows)
        self.all_rows = [*self.all_rows, *rows]
        self._fill(rows)
        self.update_readers()

    def detach(self, rows: Collection[int]) -> list[tuple[PortWriter, list[int]]]:
        """Let edges to other workers go; returns the writers concerned, with the indices of those readers.

        rows: ledger rows of the edges. A writer without other readers is removed.
        """
        concerned = []
        for writer, own in tuple(zip(self.writers, self.rows, strict=True)):
            gone = [index for index, row in enumerate(own) if row in rows]
            if gone:
                concerned.append((writer, gone))
            if gone and all(row in rows or row == _NONE for row in own):
                self.writers.remove(writer)
                self.rows.remove(own)
            for index in gone:
                own[index] = _NONE
        self.edges = [(name, row) for name, row in self.edges if row not in rows]
        self.all_rows = [row for row in self.all_rows if row not in rows]
        self._note_away([writer.lost for writer in self.writers])
        return concerned

    def update_readers(self) -> None:
        """Take note of which readers are away: messages count as away until those are back.

        Messages that were on their way to a dead reader count as lost. A reader that is back is told the
        watermark.
        """
        for writer, rows in zip(self.writers, self.rows, strict=True):
            for index, count in writer.perished():
                self.words[rows[index] + LOST] += count
        lost = [writer.lost for writer in self.writers]
        if lost == self._lost:
            return
        before = self._lost
        self._note_away(lost)
        for writer, then, now in zip(self.writers, before, lost, strict=False):
            if then - now:
                self.returned(writer)

    def _note_away(self, lost: list[frozenset[int]]) -> None:
        """Take note of the readers of each writer that are away."""
        self._lost = lost
        self._living, self._away = [], []
        for writer, rows, gone in zip(self.writers, self.rows, lost, strict=True):
            here = (row for index, row in enumerate(rows) if index not in gone)
            self._living.append((writer, [row for row in here if row != _NONE]))
            self._away += [row for index, row in enumerate(rows) if index in gone]

    def returned(self, writer: PortWriter) -> None:
        """Tell a reader that is back the watermark."""
        if writer in self.writers and -END < self.announced < END:
            writer.send(Watermark(self.announced))

    def has_room(self) -> bool:
        """Whether every edge has credit for another message."""
        for queue in self.queues:
            if len(queue.messages) >= queue.depth:
                return False
        if not self.writers:
            return True
        if self.waits_for_readers and any(writer.lost for writer in self.writers):
            return False
        return all(writer.credit() > 0 for writer in self.writers)

    def send(self, message: Message, header: Header, following: int = UNKNOWN) -> None:
        """Stamp, check and send a message; it counts as invalid on every edge if it breaks its contract.

        following: the watermark after it, ns, if more is known than what the message itself announces.
        """
        words = self.words
        if self.counts:
            for row in self.all_rows:
                words[row + PRODUCED] += 1
        try:
            if header.time < self.watermark:
                raise InvalidMessage(f"time {header.time} ns lies before the watermark {self.watermark} ns")
            if not message.header.source:  # else it was sealed when it was sent before
                seal(message)
        except InvalidMessage as error:
            self.invalid()
            self.refused(str(error))
            self.advance(max(header.time + 1, following))
            return
        if message.header is not header:
            message = stamped(message, header)
        if not self.filled and not message.is_empty:
            self.filled = True
            self._fill(self.all_rows)
        own = header.time + 1 + self.lateness
        following = following if following > own else UNKNOWN
        self.watermark = self.announced = max(own, following)
        for tap in self.taps:
            tap(message)
        for queue in self.queues:
            queue.put(message)
            if following != UNKNOWN:
                queue.advance(following)
        for row in self._away:
            words[row + AWAY] += 1
        for writer, rows in self._living:
            try:
                writer.send(message, following)
            except InvalidMessage as error:  # its head is too large to travel
                self._count(rows, REFUSED)
                self.refused(str(error))
                if following != UNKNOWN:
                    writer.send(Watermark(following))

    def advance(self, watermark: int) -> None:
        """Advance the watermark, ns, and tell every reader."""
        if watermark <= self.watermark:
            return
        self.watermark = self.announced = watermark
        for queue in self.queues:
            queue.advance(watermark)
        for writer in self.writers:
            writer.send(Watermark(watermark))

    def absent(self) -> None:
        """Announce that nothing comes for now, so that joins downstream do not wait."""
        if self.watermark == END:
            return
        self.announced = ABSENT
        for queue in self.queues:
            queue.advance(ABSENT)
        for writer in self.writers:
            writer.send(Watermark(ABSENT))

    def end(self) -> None:
        """End the stream."""
        self.advance(END)

    def produced(self) -> None:
        """Count a message that a live source has made; called in the source's thread."""
        self._count(self.all_rows, PRODUCED)

    def invalid(self) -> None:
        """Count a message that breaks its contract, and that counts as produced already."""
        self._count(self._present(), REFUSED)
        self._count(self._away, AWAY)

    def overrun(self) -> None:
        """Count a message that a live source has made and dropped; called in the source's thread."""
        self._count(self.all_rows, OVERRUN)

    def lost_at_source(self, kind: SourceLoss, number: int) -> None:
        """Count frames that a device made and its source never had; called in the source's thread."""
        for row in self.all_rows:
            self.words[row + SOURCE_LOSSES[kind]] += number

    def tap(self, by: Callable[[Message], None]) -> None:
        """Call `by` with every message from now on. Safe from any thread."""
        with _TAPPING:
            self.taps = (*self.taps, by)

    def untap(self, by: Callable[[Message], None]) -> None:
        """Call `by` no more. Safe from any thread."""
        with _TAPPING:
            self.taps = tuple(tap for tap in self.taps if tap is not by)

    def loan(self, shape: tuple[int, ...], dtype: str) -> Array | None:
        """An array in the shared memory of the first writer that has a free slot; None if there is none."""
        for writer in self.writers:
            array: Array | None = writer.loan(shape, dtype)
            if array is not None:
                return array
        return None

    def _refused_later(self, rows: list[int], reason: str) -> None:
        """Count a message that was queued and turned out too large to send."""
        self._count(rows, REFUSED)
        self.refused(reason)

    def _fill(self, rows: list[int]) -> None:
        """Note on these edges that a message had rows, if one had."""
        for row in rows:
            self.words[row + FILLED] |= self.filled

    def _count(self, rows: list[int], column: int) -> None:
        for row in rows:
            self.words[row + column] += 1

    def _present(self) -> list[int]:
        """Ledger rows of every edge whose reader is present."""
        return [queue.row for queue in self.queues] + [row for _, rows in self._living for row in rows]
