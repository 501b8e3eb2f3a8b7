"""Real ends of a Zenoh edge, with a model of what they owe each other."""

from __future__ import annotations

import itertools
import select
import time
from collections import deque
from collections.abc import Callable, Iterable

from hypothesis.stateful import RuleBasedStateMachine
from tests.promises.edge_messages import word
from tests.promises.edge_model import ABSENT, Advance, Missing, Owed, Spoken
from tests.promises.zenoh_hosts import READERS, Hosts

from followspot.transport.token import Token, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter

TIMEOUT = 60.0
"""Seconds for what must happen; nothing takes that long."""
LONGEST_SLEEP_MS = 100
"""Of a worker."""
NUMBERS = itertools.count()


class ZenohEnds(RuleBasedStateMachine):
    """A writer and two readers; every token that a reader gets is judged by the model."""

    shared_hosts: Hosts | None = None
    """Examples share the hosts, whose sessions take long to open."""

    def set_up(self, depth: int) -> None:
        self.depth = depth
        self.key = f"test/{next(NUMBERS)}/port"
        self.hosts = ZenohEnds.shared_hosts = ZenohEnds.shared_hosts or Hosts()
        self.readers: list[ZenohReader | None] = [None] * READERS
        self.eras: list[list[Owed]] = [[Owed()] for _ in range(READERS)]
        """For each reader, what is owed by one writer after the other, from the one that was heard last."""
        self.taken: list[deque[Owed]] = [deque() for _ in range(READERS)]
        """For each message that a reader took and did not consume, by whom it was owed."""
        self.readers_before = [0] * READERS
        self.writers_before = self.writer_host = 0
        self.writer: ZenohWriter | None = None
        self.replaced: list[ZenohWriter | ZenohReader] = []
        """Ends that other incarnations have replaced, and that do not know it."""
        self.announced: set[int] = set()
        self.number = self.time = 0
        self.over = self.silent = self.asleep = self.apart = False
        self.was_cut = False
        """Whether the first reader's cable was ever cut: the ends notice that at any later time."""

    def drain(self) -> None:
        assert self.writer is not None
        self.writer.drain()
        self.asleep = False

    def read(self, index: int) -> None:
        reader = self.readers[index]
        if reader is not None:
            for owed in self.eras[index]:  # what came while it did not read may have been too much
                owed.leaks |= reader.rejected > 0
            for token in reader.poll():
                self.take(index, token)

    def replaced_ends_act(self) -> None:
        for end in self.replaced:
            if isinstance(end, ZenohWriter):
                end.drain()
                end.flush()
            else:
                end.consumed(sum(not isinstance(token, Watermark) for token in end.poll()))

    def close(self) -> None:
        for end in (self.writer, *self.readers, *self.replaced):
            if end is not None:
                end.close()

    def leaks(self, index: int) -> bool:
        """Whether messages to this reader may be missing."""
        return index == 0 and self.was_cut

    @property
    def speaks(self) -> bool:
        return self.writer is not None and not self.over

    @property
    def owed(self) -> list[Owed]:
        """What the present writer owes each reader."""
        return [eras[-1] for eras in self.eras]

    @property
    def all_joined(self) -> bool:
        """Whether each reader knows the writer, and the writer none to be away."""
        found = [reader is not None and reader.matched() for reader in self.readers]
        return all(found) and not self.writer_lost

    @property
    def writer_lost(self) -> frozenset[int]:
        assert self.writer is not None
        return self.writer.lost

    def satisfied(self, index: int) -> bool:
        return self.owed[index].satisfied

    def matched(self) -> bool:
        """Whether all ends know of each other; asked of each, as a worker does at the start."""
        ends = (self.writer, *self.readers)
        found = [end is not None and end.matched() for end in ends]
        return all(found)

    def say(self, spoken: Spoken | Advance) -> None:
        """To the readers that the writer believes to be there."""
        self.silent = spoken == Advance(ABSENT)
        if isinstance(spoken, Advance):
            self.announced.add(spoken.watermark)
        for index, owed in enumerate(self.owed):
            if index not in self.writer_lost:
                owed.say(spoken)

    def take(self, index: int, token: Token) -> None:
        """Nothing of a writer is heard any more when one that came later was."""
        heard, eras = word(token), self.eras[index]
        while len(eras) > 1 and not eras[0].expects(heard):
            eras.pop(0)
        try:
            eras[0].receive(heard)
        except AssertionError as error:
            raise AssertionError(f"reader {index}, of {len(eras)} eras: {error}; {self.state()}") from None
        for later in eras[1:]:  # nothing tells of which writer a missing message was
            later.spare = later.spare + 1 if isinstance(heard, Missing) else 0
        if not isinstance(heard, Advance):
            self.taken[index].append(eras[0])

    def until(self, condition: Callable[[], bool]) -> None:
        """Let all ends act when woken, as workers do, until the condition holds."""
        limit = time.monotonic() + TIMEOUT
        while not condition():
            assert time.monotonic() < limit, f"it never happened within {TIMEOUT:.0f} s; {self.state()}"
            self.turn()

    def turn(self) -> None:
        """Sleep until an end is woken, or as long as a worker does at most."""
        assert self.writer is not None
        ends = {reader.fileno(): index for index, reader in enumerate(self.readers) if reader}
        woken = readable([*self.writer.filenos(), *ends], LONGEST_SLEEP_MS / 1000)
        for fd in woken:
            if fd in ends:
                self.read(ends[fd])
            else:
                self.drain()
        self.replaced_ends_act()
        if not woken:
            self.writer.flush()

    def state(self) -> str:
        """For a test that failed."""
        ends = [self.writer, *self.readers]
        shown = [
            {name: value for name, value in vars(end).items() if isinstance(value, (int, dict, set, list))}
            for end in ends
            if end is not None
        ]
        owed = [f"reader {index} is owed {owed}" for index, owed in enumerate(self.owed)]
        return "\n".join([*owed, *map(str, shown)])


def readable(filenos: Iterable[int], seconds: float) -> list[int]:
    ready = select.poll()
    for fileno in filenos:
        ready.register(fileno, select.POLLIN)
    return [fileno for fileno, _ in ready.poll(1000 * seconds)]
