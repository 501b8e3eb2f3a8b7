"""The edges of an output port: their readers and ledger rows, and which readers are away."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial

from followspot.messages import Array
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.edge import PortWriter
from followspot.transport.token import END, Watermark
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import FILLED, LOST, PRODUCED, REFUSED, SHED
from followspot.worker.tap_point import TapPoint

_NONE = -1
"""Stands for the row of an edge that has left the graph: its reader keeps its index in the writer."""


class PortEdges(TapPoint):
    """Edges and taps of one output port, which come and go while the graph runs.

    queues: readers in the same worker; writers: one for each kind of edge to other workers;
    rows: ledger rows of the edges behind each writer; words: of the ledger.
    """

    __slots__ = (
        "_away",
        "_living",
        "_lost",
        "all_rows",
        "announced",
        "edges",
        "filled",
        "queues",
        "refused",
        "rows",
        "waits_for_readers",
        "words",
        "writers",
    )

    def __init__(self, words: memoryview) -> None:
        super().__init__()
        self.words = words
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
        self.filled = False
        """Whether a message that was sent had rows."""
        self.announced = -END
        """The last announcement to readers: a watermark, or `ABSENT`."""
        self.refused: Callable[[str], None] = lambda reason: None
        """Called with the reason when a message was refused."""
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

        Messages that were on their way to a dead reader count as lost. A reader that is back gets the
        watermark.
        """
        for writer, rows in zip(self.writers, self.rows, strict=True):
            for index, count in writer.newly_dead():
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
        """Send the watermark to the readers of a writer: one of them is back."""
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
