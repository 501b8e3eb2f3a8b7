"""A model of what an edge promises, without sockets, memory or sessions: it judges real edges.

The model knows what `followspot.transport.edge` says, and nothing of any implementation. Each reader that is
present is owed every word of the port, in order. Of watermarks that follow each other, only the last must
come. Messages that are on their way when a link is cut come as missing, in their place. All others arrive.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from typing import NamedTuple

END = 2**63 - 1
"""The watermark of a stream that has ended."""
ABSENT = END - 1
"""The watermark of a stream whose source is away."""


class Spoken(NamedTuple):
    """A message that a port sent; time: of its capture, ns; slot: whether it lies in shared memory."""

    number: int
    time: int
    slot: bool = False


class Advance(NamedTuple):
    """Nothing earlier than this will come, ns."""

    watermark: int


class Missing(NamedTuple):
    """What a reader was given in the place of a message."""

    reason: str


Word = Spoken | Advance | Missing


@dataclass
class Owed:
    """What one reader is owed by the writer that it knows."""

    due: deque[Spoken | Advance] = field(default_factory=deque)
    """Said and not yet received."""
    given: int = 0
    """Messages that were sent to this reader."""
    got: int = 0
    """Messages that it received, or `Missing`s in their place."""
    consumed: int = 0
    """Of these, how many it gave credit for."""
    ended: bool = False
    """Whether it received the end."""
    leaks: bool = False
    """Whether the link was cut since: messages may be missing, and watermarks gone."""
    joins: bool = False
    """Whether nothing came yet, and the writer may not have known of this reader at first."""
    vague: bool = False
    """Whether absence or end that come first may have been taken for those of a writer before."""
    spare: int = 0
    """Messages that came as missing, and count for the writer before, but may have been this one's."""
    announced: set[int] = field(default_factory=set)
    """All times that the writer announced: any reader may be told so, also again, once it is true."""
    watermark: int = -END
    """The latest watermark that it received, unless absence was said."""
    _heard: Advance | None = None
    """The last word that it received, if that was a watermark."""

    def say(self, word: Spoken | Advance) -> None:
        """The writer sends something, and this reader is there."""
        self.given += isinstance(word, Spoken)
        self.due.append(word)

    def receive(self, word: Word) -> Spoken | None:
        """The reader got something; the message that was due. AssertionError if it is not what comes next."""
        self._join(word)
        if isinstance(word, Advance):
            self._advance(word)
            return None
        self._skip_watermarks()
        if isinstance(word, Spoken):
            self._skip_spare(lambda due: not self._is(due, word))
            self.spare = 0
        assert self.due, f"{word} came, and nothing is due"
        due = self.due.popleft()
        assert isinstance(due, Spoken), f"{word} came before {due}"
        self.got += 1
        self.vague = False
        self._heard = None
        if isinstance(word, Missing):
            assert self.leaks, f"{due} came as {word}, and no link was cut"
            return due
        assert self._is(due, word), f"{word} came in the place of {due}"
        assert word.time >= self.watermark, f"{word} came after {self.watermark} was announced"
        return due

    def consume(self, count: int = 1) -> None:
        """The reader gives credit for messages that it has got."""
        self.consumed += count
        assert self.consumed <= self.got

    def __str__(self) -> str:
        """For a test that failed."""
        first, last = list(self.due)[:3], list(self.due)[-3:]
        return (
            f"{len(self.due)} words due, {first} to {last}, after {self._heard}, {self.got} of {self.given}"
        )

    @property
    def waiting(self) -> int:
        """Messages for which this reader has given no credit."""
        return self.given - self.consumed

    @property
    def in_slots(self) -> set[int]:
        """Numbers of the messages in shared memory that the reader has not looked at."""
        return {word.number for word in self.due if isinstance(word, Spoken) and word.slot}

    def expects(self, word: Word) -> bool:
        """Whether this writer said that, and it did not come yet or may be said again."""
        if isinstance(word, Missing):
            return self.leaks and any(isinstance(due, Spoken) for due in self.due)
        if isinstance(word, Advance) and word.watermark in self.announced:
            return True
        return self._is_due(word)

    @property
    def satisfied(self) -> bool:
        """Whether nothing is due any more that must come."""
        if self.joins and Advance(END) not in self.due:
            return True
        self._skip_watermarks()
        return sum(isinstance(due, Spoken) for due in self.due) <= self.spare

    def rest(self) -> None:
        """Nothing is on its way: what did not come was missing. A cut may still be noticed later."""
        if not self.joins:
            self.due.clear()
            self.spare = 0
            self.given = self.got = self.consumed = 0

    def _join(self, word: Word) -> None:
        """The first word tells where this reader joined; absence or the end tell nothing."""
        if self.joins and self._is_due(word) and not (isinstance(word, Advance) and word.watermark >= ABSENT):
            while not self._is(self.due[0], word):
                self.given -= isinstance(self.due.popleft(), Spoken)
            self.joins = False

    def _is_due(self, word: Word) -> bool:
        return any(self._is(due, word) for due in self.due)

    @staticmethod
    def _is(due: Spoken | Advance, word: Word) -> bool:
        return word == (due._replace(slot=False) if isinstance(due, Spoken) else due)

    def _advance(self, word: Advance) -> None:
        if word.watermark == END and self.ended:
            return
        if word.watermark != ABSENT:
            self._skip_spare(lambda due: due.time < word.watermark)
            self.spare = 0
        row = self._next_watermarks()
        if self.joins:
            if word.watermark == END:  # what was said before was not for this reader
                self.due.clear()
        elif word in row:
            for _ in range(row.index(word) + 1):
                self.due.popleft()
        else:
            assert word.watermark in self.announced, f"{word} came, and was never said"
            due = self._next_spoken()
            assert due is None or due.time >= word.watermark or word.watermark == ABSENT, (
                f"{word} came before {due}"
            )
        self._heard = word
        self.ended = word.watermark == END
        if word.watermark < ABSENT:
            self.watermark = word.watermark

    def _skip_spare(self, passed: Callable[[Spoken], bool]) -> None:
        """Messages that this writer passed over came as missing before, and count for another writer."""
        while self.spare and (due := self._next_spoken()) is not None and passed(due):
            while self.due.popleft() != due:
                pass
            self.spare -= 1
            self.given -= 1

    def _next_spoken(self) -> Spoken | None:
        return next((word for word in self.due if isinstance(word, Spoken)), None)

    def _next_watermarks(self) -> list[Advance]:
        """Those before the next message."""
        return [
            word
            for word in takewhile(lambda word: isinstance(word, Advance), self.due)
            if isinstance(word, Advance)
        ]

    def _skip_watermarks(self) -> None:
        """Only the last watermark in a row must come; none, if the link was cut."""
        row = self._next_watermarks()
        gone = self.leaks and row[-1:] != [Advance(END)]
        told_before = self.vague and all(word.watermark >= ABSENT for word in row)
        if row and (row[-1] == self._heard or gone or told_before):
            for _ in row:
                self.due.popleft()


@dataclass
class Port:
    """A writer and those whom it knows to be there; None for one that is away."""

    depth: int
    readers: list[Owed | None]

    @property
    def credit(self) -> int:
        """Messages that may be sent as far as the readers' queues are concerned."""
        present = [owed.waiting for owed in self.readers if owed is not None]
        return max(0, self.depth - max(present, default=0))

    def credit_of_memory(self, lent: int, kept: Sequence[int]) -> int:
        """Messages that the slots leave room for, at least.

        lent: arrays that the writer's process holds; kept: messages that each reader holds.
        Each may hold one more than the edge is deep without being in the way of the others.
        """
        share = self.depth + 1
        slots = share * (len(self.readers) + 1) + 2
        present = [number for number, owed in enumerate(self.readers) if owed is not None]
        unread = set().union(*(self._unread(number) for number in present))
        sampled = min(lent, share) + sum(min(kept[number], share) for number in present)
        return min(self.credit, slots - sampled - len(unread)) if present else self.depth

    def _unread(self, number: int) -> set[int]:
        owed = self.readers[number]
        return owed.in_slots if owed is not None else set()
