"""Real ends of a ring, with a model of what they owe each other."""

from __future__ import annotations

import contextlib
import os
import select
import socket
from collections.abc import Iterable
from functools import partial
from mmap import mmap
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis.stateful import RuleBasedStateMachine
from tests.promises.edge_messages import Picture, word
from tests.promises.edge_model import ABSENT, END, Advance, Owed, Port, Spoken

from followspot.messages import Array
from followspot.transport.ring.decoder import LARGEST
from followspot.transport.ring.notification import OVER
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter

SO_PEEK_OFF = 42
"""Of Linux, where Python has no name for it: each look at a socket goes on behind the one before."""
ROUNDS = 2_000
"""Most turns until all ends sleep; a few dozen are enough."""


class RingEnds(RuleBasedStateMachine):
    """A writer and its readers; every token that a reader gets is judged by the model."""

    def set_up(self, readers: int, depth: int) -> None:
        self.descriptors = open_descriptors()
        self.port = Port(depth, [None] * readers)
        self.readers: list[RingReader | None] = [None] * readers
        self.kept: list[list[Picture]] = [[] for _ in range(readers)]
        self.loans: list[Array] = []
        self.sent: list[Picture] = []
        self.number = self.time = 0
        self.over = self.asleep = self.silent = False
        self.dead: set[int] = set()
        """Readers that died, which the writer may not have noticed."""
        self.informed: set[int] = set()
        """Of these, readers whose process had been sent the end, and all before it."""
        self.writer: RingWriter | None = None
        self.together: list[set[int]] = []
        """For each reader, those that share its datagrams as the writer knows."""
        self.processes: list[set[int]] = []
        """For each reader, those that share its datagrams and die with it."""

    def turn_until_all_sleep(self) -> None:
        for _ in range(ROUNDS):
            assert self.writer is not None
            woken = [i for i, found in enumerate(self.readers) if found and self.readable(found.fileno())]
            called = any(map(self.readable, self.writer.filenos()))
            if not (woken or called):
                return
            for index in woken:
                if (reader := self.readers[index]) is not None:
                    self.take(index, reader)
            if called:
                self.writer.drain()
                self.notice()
        raise AssertionError("an end is woken again and again for nothing")

    def close(self) -> None:
        if self.writer is not None:
            self.writer.close()
        for found in self.readers:
            if found is not None:
                found.close()
        self.writer = None
        self.readers.clear()
        self.kept.clear()
        self.loans.clear()
        self.sent.clear()

    def lend(self, size: int) -> None:
        """What the stage writes there stays as it is."""
        assert self.writer is not None
        loan = self.writer.loan((size,), "u1")
        if loan is not None:
            loan[:] = 255
            self.loans.append(loan)

    @property
    def speaks(self) -> bool:
        return self.writer is not None and not self.over

    def say(self, spoken: Spoken | Advance) -> None:
        self.silent = spoken == Advance(ABSENT)
        self.asleep = False
        for owed in self.port.readers:
            if owed is not None:
                owed.say(spoken)

    def notice(self) -> None:
        """The writer has looked after its readers: the dead hold up nothing any more."""
        assert self.writer is not None
        assert self.writer.lost == self.dead - self.informed
        self.mourn(index for index, owed in enumerate(self.port.readers) if owed and index in self.dead)
        for index in self.dead:
            self.port.readers[index] = None
            self.part(index)
        self.asleep = False

    def mourn(self, dead: Iterable[int]) -> None:
        """The writer says how many messages were on their way to each that died, once."""
        assert self.writer is not None
        owed = {index: self.port.readers[index] for index in dead}
        waiting = {index: found.waiting for index, found in owed.items() if found is not None}
        assert dict(self.writer.newly_dead()) == waiting
        assert self.writer.newly_dead() == []

    def welcome(self, index: int, sock: socket.socket) -> None:
        self.readers[index] = found = RingReader(sock, Picture, self.reader)
        found.notify = partial(self.take, index, found)
        self.dead.discard(index)
        self.informed.discard(index)
        self.port.readers[index] = owed = Owed()
        if self.over:
            owed.say(Advance(END))
        assert self.writer is not None
        assert index not in self.writer.lost

    def has_the_end(self, index: int) -> bool:
        """Whether a living reader has taken the end, or it lies in the socket of this reader."""
        found, owed = self.reader(index), self.port.readers[index]
        return found is not None and owed is not None and (owed.ended or OVER in unread(found.fileno()))

    def reader(self, index: int) -> RingReader | None:
        return self.readers[index] if index < len(self.readers) else None

    def take(self, index: int, reader: RingReader) -> None:
        owed = self.port.readers[index]
        assert owed is not None
        for token in reader.poll():
            due = owed.receive(word(token))
            if isinstance(token, Picture):
                sampled = self.sampled(index, token)
                wants = isinstance(due, Spoken) and due.slot
                room = sum(map(lies_in_a_slot, sampled)) <= self.port.depth
                assert lies_in_a_slot(token) == (wants and room), "a reader has its share of slots"
                self.kept[index].append(token)

    def sampled(self, index: int, message: Picture) -> list[Picture]:
        """What this reader, and those that share its datagrams, held when the message was read."""
        held = [kept for mate in self.processes[index] for kept in self.kept[mate]]
        once = {id(kept): kept for kept in held}.values()
        return [kept for kept in once if self.reign <= kept.header.seq < message.header.seq]

    def part(self, index: int) -> None:
        """The writer knows that this reader shares no datagrams any more."""
        for mate in self.together[index] - {index}:
            self.together[mate] = self.together[mate] - {index}
        self.together[index] = {index}

    @staticmethod
    def readable(fileno: int) -> bool:
        ready = select.poll()
        ready.register(fileno, select.POLLIN)
        return bool(ready.poll(0))


def lies_in_a_slot(message: Picture) -> bool:
    """Whether its array is a view of the writer's memory."""
    array: Any = message.pixels
    while isinstance(array.base, np.ndarray):
        array = array.base
    return isinstance(array.base, mmap)


def unread(fileno: int) -> list[bytes]:
    """The datagrams in a socket, which stay there. OSError if the system cannot look behind the first."""
    found = []
    with socket.socket(fileno=os.dup(fileno)) as sock:
        sock.setsockopt(socket.SOL_SOCKET, SO_PEEK_OFF, 0)
        with contextlib.suppress(BlockingIOError):  # that was the last
            while datagram := sock.recv(LARGEST, socket.MSG_PEEK):
                found.append(datagram)
        sock.setsockopt(socket.SOL_SOCKET, SO_PEEK_OFF, -1)
    return found


def open_descriptors() -> set[tuple[int, int]]:
    """Number and inode of each; other threads may close theirs at any time."""
    found = set()
    for path in Path("/proc/self/fd").iterdir():
        with contextlib.suppress(OSError):  # it is closed already
            found.add((int(path.name), os.fstat(int(path.name)).st_ino))
    return found
