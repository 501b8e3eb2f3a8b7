"""Fuzz target: both ends of edges over Zenoh, which receive well-formed extreme tokens in real sessions.

After every few inputs a good message must pass; each input is delivered or counted as rejected.
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import zenoh

from followspot import people, tracking
from followspot.messages import InvalidMessage, Message, identical
from followspot.transport.codec import pack
from followspot.transport.token import MAX_COUNT, Invalid, Token, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, locators, open_session
from followspot.transport.zenoh.terms import CREDIT, NUMBER, START, has_subscriber, undeclare
from fuzzing.control_numbers import Numbers
from fuzzing.extreme import extreme_token
from fuzzing.target import Target
from fuzzing.wire import sample

KINDS: tuple[type[Message], ...] = (
    *(tracking.Frame, tracking.Blobs, tracking.Candidates, tracking.Forecast, tracking.Tracks),
    *(people.Boxes, people.Poses),
)
_DEPTH = 4
_OFTEN = 20
"""Inputs between two good messages."""
_LAST = 1 << 20
"""Numbers that are left to a writer before the largest."""
_LONGEST = 20.0
"""Seconds until what must happen did not."""


def _await(what: str, happened: Callable[[], bool]) -> None:
    limit = time.monotonic() + _LONGEST
    while not happened():
        if time.monotonic() > limit:
            raise AssertionError(f"{what} within {_LONGEST:.0f} s")
        time.sleep(0.0001)


class Hostile(NamedTuple):
    """The packet to put: a token by the writer's own host, or anything on a key of the edge by a stranger."""

    way: str
    kind: type[Message]
    token: bytes = b""
    numbers: Numbers | None = None


class _Reader(ZenohReader):
    """Counts the tokens that it has examined."""

    looked = 0

    def _take(self, sample: Any, tokens: list[Token]) -> None:
        super()._take(sample, tokens)
        self.looked += 1


class _Writer(ZenohWriter):
    """Counts the reports that it has examined, and keeps an exception of one of them."""

    looked = 0
    problem: BaseException | None = None

    def _on_report(self, sample: zenoh.Sample) -> None:
        try:
            super()._on_report(sample)
        except BaseException as error:
            self.problem = error
        self.looked += 1


class Pair:
    """A writer and a reader of one type of messages, and a stranger's publishers on all their keys."""

    def __init__(self, there: zenoh.Session, here: zenoh.Session, stranger: zenoh.Session, key: str) -> None:
        self._sessions = there, here, stranger
        self.key = key
        self.kind: type[Message] = Message

    def begin(self, kind: type[Message]) -> None:
        """Both ends are there, and so is the stranger."""
        there, here, stranger = self._sessions
        self.kind = kind
        self.writer = _Writer(there, self.key, {"reader": ""}, _DEPTH)
        self.reader = _Reader(here, self.key, "reader", kind, _DEPTH)
        _await("no reader", lambda: all([self.writer.matched(), self.reader.matched()]))
        keys = {
            "number": self.key,
            "start": self.reader._start_key,
            "credit": str(self.reader._report.key_expr),
        }
        block = zenoh.CongestionControl.BLOCK
        self.intruders = {
            way: stranger.declare_publisher(key, congestion_control=block) for way, key in keys.items()
        }
        for intruder in self.intruders.values():
            _await("no listener", partial(has_subscriber, intruder))

    def end(self) -> None:
        """Neither end is there any more."""
        undeclare(self.intruders.values())
        self.writer.close()
        self.reader.close()

    @property
    def refused(self) -> int:
        """The counts of both ends."""
        return self.writer.rejected + self.reader.rejected

    def agree(self) -> None:
        """Let the writer's state match what the reader believed, if the writer could have meant it.

        Both ends begin again if it was another writer, which never comes, or one that has counted as far as
        numbers go: what follows would be out of range.
        """
        if self.reader.position.writer != 0 or self.reader.position.tokens > MAX_COUNT - _LAST:
            self.end()
            self.begin(self.kind)
        elif (
            self.reader.position.tokens != self.writer._flow.tokens
            or self.reader.position.messages != self.writer._flow.messages
        ):
            self.writer._flow.tokens, self.writer._flow.messages = (
                self.reader.position.tokens,
                self.reader.position.messages,
            )
            self.reader.consumed(0)

    def put(self, hostile: Hostile) -> list[Token]:
        """The tokens that the reader gives out when it has seen it."""
        looked, reported = self.reader.looked, self.writer.looked
        numbers = b"" if hostile.numbers is None else hostile.numbers.packed(self.writer._flow.tokens)
        if hostile.way == "token":
            self.writer._flow.messages += hostile.token[4:6] != _SETTLED
            self.writer._put(hostile.token)
        elif hostile.way == "number":
            self.intruders["number"].put(hostile.token, attachment=numbers)
        else:
            self.intruders[hostile.way].put(numbers)
        if hostile.way == "credit":
            _await("no report came", lambda: self.writer.looked > reported)
            if self.writer.problem is not None:
                raise self.writer.problem
            self.reader.consumed(0)  # if the reader believed the stranger, the true report corrects that
            return []
        tokens: list[Token] = []

        def seen() -> bool:
            tokens.extend(self.reader.poll())
            return self.reader.looked > looked

        _await("nothing came", seen)
        self._taken(tokens)
        return tokens

    def passes(self, number: int) -> None:
        """A good message arrives as it was sent, once both ends have noticed if their link was cut."""
        _await("the ends do not find each other again", self._joined)
        _await("no credit", lambda: self.writer.credit() > 0)
        good = sample(self.kind, random.Random(number))
        self.writer.send(good)
        tokens: list[Token] = []

        def came() -> bool:
            tokens.extend(self.reader.poll())
            return bool(tokens)

        _await("no good message came", came)
        if not (isinstance(tokens[-1], Message) and identical(tokens[-1], good)):
            raise AssertionError(f"a good message came as {str(tokens)[:300]}")
        self._taken(tokens)

    def _joined(self) -> bool:
        """Whether the reader knows where the writer is, after each did what a woken worker does."""
        self.writer.drain()
        self._taken(self.reader.poll())
        return self.writer.matched() and self.reader.position.joined

    def _taken(self, tokens: list[Token]) -> None:
        self.reader.consumed(sum(not isinstance(token, Watermark) for token in tokens))


class ZenohEdge:
    """A session for the writers, one for the readers, and a stranger in a third."""

    def __init__(self) -> None:
        there = open_session()
        here = open_session(connect=locators(there))
        stranger = open_session(connect=[*locators(there), *locators(here)])
        self._count = 0
        self._pairs = {kind: Pair(there, here, stranger, f"fuzz/{kind.__name__}/out") for kind in KINDS}

    def make(self, rng: random.Random) -> Hostile:
        """A token of any kind, or control numbers near the true ones or far from them."""
        kind = rng.choice(KINDS)
        way = rng.choices(("token", "number", "start", "credit"), (6, 2, 1, 1))[0]
        token = extreme_token(kind, rng) if way in ("token", "number") else b""
        layout = {"number": NUMBER, "start": START, "credit": CREDIT}.get(way)
        return Hostile(way, kind, token, None if layout is None else Numbers.some(layout, rng))

    def take(self, hostile: Hostile) -> object:
        """Put it and see what becomes of it. Raises InvalidMessage if it is refused."""
        pair = self._pairs[hostile.kind]
        if pair.kind is not hostile.kind:
            pair.begin(hostile.kind)
        refused = pair.refused
        tokens = pair.put(hostile)
        self._count += 1
        counted = pair.refused > refused
        pair.agree()
        if self._count % _OFTEN == 0 or hostile.way != "token":
            pair.passes(self._count)
        broken = [token.reason for token in tokens if isinstance(token, Invalid)]
        if broken or counted:
            raise InvalidMessage(broken[-1] if broken else f"counted: {hostile.way}")
        return tokens


_SETTLED = pack(Watermark(0))[4:6]
"""The head of a watermark begins as a list of two with nothing first."""


def extreme_zenoh_target() -> Target:
    """A writer's own host, and strangers, on the keys of an edge."""
    edge = ZenohEdge()
    return Target(edge.make, edge.take, (InvalidMessage,))
