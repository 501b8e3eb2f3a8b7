"""An output port, its worker and its readers, with a model of what must come to each."""

from __future__ import annotations

import socket
from collections import deque
from dataclasses import dataclass, field

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine
from tests.promises.edge_messages import SMALL, Picture
from tests.promises.edge_model import ABSENT, END, Spoken

from followspot import Source, Stage
from followspot.transport.dropping_writer import DroppingWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.worker.inputs.input_queue import UNCHANGED, InputQueue
from followspot.worker.ledger import EdgeCount, Ledger
from followspot.worker.output_port import OutputPort
from followspot.worker.pace import Pace
from followspot.worker.scheduler import Scheduler

NEAR, LEFT, RIGHT, LOOSE = EDGES = range(4)
"""Edges: one within the worker, two over a ring that they share, one that drops, over a ring of its own."""
FAR = (LEFT, RIGHT, LOOSE)
ANY, ANY_FAR = st.sampled_from(EDGES), st.sampled_from(FAR)
SIZES = st.sampled_from([SMALL, 9_000])
LATENESS = 3
"""ns beyond its own time for which a message promises that nothing else comes."""
AHEAD = 2
"""Messages on their way to the reader of an edge that drops."""
ROUNDS = 2_000
PAIR = socket.AF_UNIX, socket.SOCK_SEQPACKET


class Count(Stage):
    """The stage of the port; the machine sends in its name."""

    def process(self) -> Source[Picture]:
        yield from ()


@dataclass
class Reader:
    """A stage that reads one edge, and what must come to it."""

    queue: InputQueue
    scheduler: Scheduler
    owed: deque[Spoken] = field(default_factory=deque)
    """Sent to it, and not in its queue yet; on an edge that drops, some of them come."""
    over: bool = False
    """Whether it was told the end, maybe by a sender before: only a message opens the stream again."""


class PortEnds(RuleBasedStateMachine):
    """One output port with a reader in its worker, and three in workers of their own."""

    output: OutputPort
    writers: dict[int, tuple[RingWriter | DroppingWriter, int]]

    def set_up(self, depth: int, live: bool) -> None:
        self.depth = depth
        self.live = live
        self.ledger = Ledger(len(EDGES))
        self.number = self.time = self.produced = 0
        self.accounted = [0] * len(EDGES)
        """Messages that readers took or threw away, by edge."""
        self.astray = [0] * len(EDGES)
        """Messages whose fate no end can know until the run ends."""
        self.announced = -END
        """How far the port last said to be, or that it is absent."""
        self.over = self.ended_once = False
        self.left_all = True
        """Whether nothing waited in the last sender when it died."""
        self.readers: dict[int, Reader] = {}
        self.unheard: deque[Spoken] = deque()
        """What was sent on the edge that drops without a reader: the next reader may get it."""
        self.sender: Scheduler | None = None

    @property
    def speaks(self) -> bool:
        return self.sender is not None and not self.over

    def count(self, edge: int) -> EdgeCount:
        return self.ledger.count(edge)

    def queued(self, edge: int) -> int:
        return len(self.readers[edge].queue.messages) if edge in self.readers else 0

    def queue(self, edge: int) -> InputQueue:
        row = self.ledger.row(edge)
        queue = InputQueue(str(edge), self.ledger.words, row, depth=self.depth, lateness=LATENESS)
        queue.after_loss = ABSENT if self.live else UNCHANGED
        return queue

    def reader(self, edge: int, sock: socket.socket) -> Reader:
        queue = self.queue(edge)
        queue.reader = RingReader(sock, Picture)
        return Reader(queue, Scheduler([], [queue], [], Pace()), self.unheard if edge == LOOSE else deque())

    def adopt(self, edge: int, sock: socket.socket) -> None:
        """The reader goes over to another sender, after all that the one before had sent."""
        reader = self.readers[edge]
        assert reader.queue.reader is not None
        before = len(reader.queue.messages), reader.queue.watermark
        reader.scheduler.ends.adopt_reader(reader.queue.reader, RingReader(sock, Picture))
        self.check_arrivals(edge, *before)
        assert edge == LOOSE or not (reader.owed and self.left_all), f"{reader.owed} were sent and not read"
        reader.owed.clear()

    def expect(self, spoken: Spoken) -> None:
        """All readers that are present are owed this message."""
        self.produced += 1
        for edge in FAR:
            if edge in self.readers:
                self.readers[edge].owed.append(spoken)
            elif edge == LOOSE:
                self.unheard.append(spoken)

    def check_arrivals(self, edge: int, queued: int, watermark: int) -> None:
        """What came is what was owed, in order, and not before the watermark."""
        reader = self.readers[edge]
        for message in list(reader.queue.messages)[queued:]:
            said = Spoken(message.header.seq, message.header.time)
            assert said in reader.owed, f"{said} came on edge {edge}, and was not sent, or came before"
            while (due := reader.owed.popleft()) != said:
                assert edge == LOOSE, f"{said} came on edge {edge} before {due}"
            again = watermark == ABSENT or (watermark == END and reader.over)
            assert again or said.time >= watermark, f"{said} came after the watermark {watermark}"
        assert (
            reader.queue.watermark >= watermark or watermark == ABSENT or len(reader.queue.messages) > queued
        )
        reader.over |= reader.queue.watermark == END and self.ended_once


def readable(scheduler: Scheduler) -> bool:
    """Whether something wakes this worker."""
    return any(event for _, event in scheduler.ends._poll.poll(0))
