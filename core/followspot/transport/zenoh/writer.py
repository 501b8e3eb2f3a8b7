"""The writing end of an edge over Zenoh (docs/wire.md).

Zenoh loses nothing between living peers as long as nobody floods it, so credit bounds what is under way.
Its threads only note reports and ring a bell; all else happens in the worker's thread.
"""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple
from urllib.parse import quote

import zenoh
from zenoh.handlers import Callback

from followspot.graph.plan import EdgeCodec
from followspot.messages import Array, Message
from followspot.transport.codec import pack
from followspot.transport.keys import OPERATOR, reader_key
from followspot.transport.token import END, Watermark
from followspot.transport.wakeup_event import WakeupEvent
from followspot.transport.zenoh.codec import pack_as
from followspot.transport.zenoh.terms import (
    CREDIT,
    NUMBER,
    START,
    WINDOW,
    chunks,
    codec_key,
    is_incarnation,
    numbers,
    presence,
    publisher,
    reached,
    undeclare,
)

_REPEAT = 0.5
"""Seconds after which a reader that does not report is told again where to start."""


class _News(NamedTuple):
    """A liveliness token of a reader came or went; incarnation: its own, or of the writer that is done."""

    role: str
    reader: int
    incarnation: int
    there: bool


class ZenohWriter:
    """`PortWriter` for readers anywhere that a session reaches.

    A reader that comes, comes back, or comes as another incarnation joins at the next token: it is told
    which that is, and how many messages were meant for it before.
    """

    def __init__(
        self,
        session: zenoh.Session,
        key: str,
        readers: Mapping[str, str],
        depth: int,
        *,
        codec: EdgeCodec = "raw",
        incarnation: int = 0,
    ) -> None:
        """key: of the port, for example ``followspot/RUN/pc-left/color/cam0/out``; readers: the host of
        each, by its name, "" for the operator's own: nobody else may speak for it.

        incarnation: how many writers this port had before; a later one waits for nobody.
        """
        self._key = key = codec_key(key, codec)
        self._codec = codec
        self._incarnation = incarnation
        self._depth = depth
        self._names = [quote(name, safe="") for name in readers]
        self._hosts = [host or OPERATOR for host in readers.values()]
        self._index = {name: index for index, name in enumerate(self._names)}
        self._reports = [(0, 0)] * len(readers)
        self._given = [0] * len(readers)
        """Messages put for each reader's present incarnation."""
        self._news: deque[_News] = deque()
        self._present: dict[int, int] = {}
        """Incarnation of each reader that is there."""
        self._known: dict[int, int] = {}
        """Latest incarnation of each reader that was ever there."""
        self._left: dict[int, int] = {}
        """Messages that had been put when a reader went."""
        self._perished: list[tuple[int, int]] = []
        self._silent: set[int] = set()
        """Readers that have not reported since they were told where to start."""
        self._told_at = 0.0
        self._done: set[int] = set()
        """Readers that have taken the end of this writer."""
        self._gone: set[int] = set(range(len(readers))) if incarnation else set()
        self._tokens = 0
        self._messages = 0
        self._held: Watermark | None = None
        self._settled: Watermark | None = None
        """What was put last, where that was a watermark: whoever joins is told it again."""
        self._ending = False
        self._waiting = False
        self._refused = 0
        self._wakeup = WakeupEvent()
        self._session = session
        self._publisher = publisher(session, key)
        said = reader_key(key, "*")
        self._declared = [
            session.declare_subscriber(f"{said}/credit/*", Callback(self._on_report, indirect=False)),
            presence(session, f"{said}/*/*/*", self._on_presence),
            session.liveliness().declare_token(f"{key}/alive/writer/{incarnation}"),
        ]

    @property
    def lost(self) -> frozenset[int]:
        """Indices of the readers that `drain` found gone before the end."""
        return frozenset(self._gone)

    def perished(self) -> list[tuple[int, int]]:
        """Readers in whose place others came since the last call; see `PortWriter.perished`.

        One that went may just be cut off, and is told when it is back how many messages it has missed.
        """
        perished, self._perished = self._perished, []
        return perished

    @property
    def strangers(self) -> int:
        """How much came that was malformed, or not from the host of the reader of whom it spoke."""
        return self._refused

    def matched(self) -> bool:
        """Whether every reader is there, knows where to start, and would get what is sent."""
        self._notice()
        self._tell_again()
        present = len(self._present) == len(self._reports)
        return present and not self._silent and reached(self._publisher)

    def credit(self) -> int:
        """How many messages may be sent now."""
        reports = self._living()
        if not reports:
            return self._depth
        if self._full(reports):
            return 0
        return max(0, self._depth - self._messages + min(consumed for consumed, _ in reports))

    def send(self, token: Message | Watermark) -> None:
        """Put the token on the key; see `PortWriter.send`."""
        if isinstance(token, Watermark):
            self._held = token
            self._ending |= token.time == END
            self._send_held()
            return
        payload = pack_as(token, self._codec)
        if self.credit() <= 0:
            raise RuntimeError("a message was sent without credit")
        self._send_held()
        self._settled = None
        self._messages += 1
        for index in self._present:
            self._given[index] += 1
        self._put(payload)

    def loan(self, shape: Sequence[int], dtype: str) -> Array | None:
        """None: Zenoh copies in any case."""
        return None

    def flush(self) -> bool:
        """Send the watermark that had to wait. True when nothing waits; the end must have arrived.

        What became of the readers is left to `drain`, whose caller takes note of it.
        """
        self._waiting = True
        self._tell_again()
        self._send_held()
        arrived = len(self._done | self._gone) == len(self._reports)
        return self._held is None and (arrived or not self._ending)

    def filenos(self) -> list[int]:
        """The bell."""
        return [self._wakeup.fileno()]

    def want_credit(self) -> None:
        """Ring the bell at the next report."""
        self._waiting = True

    def drain(self) -> None:
        """Hush the bell, notice who came and who died, send what waited."""
        self._wakeup.clear()
        self._notice()
        self._send_held()

    def close(self) -> None:
        """Undeclare everything; the session stays open."""
        undeclare([*reversed(self._declared), self._publisher])
        for index in list(self._left):
            self._note_death(index)
        self._wakeup.close()

    def _notice(self) -> None:
        """Take over what Zenoh's threads saw."""
        while self._news:
            role, index, incarnation, there = self._news.popleft()
            if role == "done":
                self._done |= {index} if incarnation == self._incarnation else set()
            elif incarnation < self._known.get(index, 0):
                continue  # another one has taken its place
            elif there:
                self._welcome(index, incarnation)
            elif self._present.get(index) == incarnation:
                del self._present[index]
                self._left[index] = self._messages
                self._silent.discard(index)
                self._gone |= {index} - self._done

    def _welcome(self, index: int, incarnation: int) -> None:
        """A reader is there: from now on it counts, and what it missed before does not."""
        if self._known.get(index, incarnation) != incarnation:
            self._note_death(index)
        self._left.pop(index, None)
        if self._known.get(index) != incarnation:
            self._given[index] = 0
            self._done.discard(index)
        self._present[index] = self._known[index] = incarnation
        self._gone.discard(index)
        self._reports[index] = self._messages, self._tokens
        self._silent.add(index)
        self._tell_start(index)

    def _note_death(self, index: int) -> None:
        """What a reader has not reported of all that was put until it went."""
        left = self._left.pop(index, self._messages)
        self._perished.append((index, max(0, left - self._reports[index][0])))

    def _tell_again(self) -> None:
        """A new link may have swallowed the first words; who does not report is told them again."""
        if self._silent and time.monotonic() > self._told_at + _REPEAT:
            for index in self._silent:
                self._tell_start(index)

    def _tell_start(self, index: int) -> None:
        """Tell a reader which token comes next, and what was meant for it before."""
        self._told_at = time.monotonic()
        start = START.pack(self._incarnation, self._tokens, self._messages, self._given[index])
        with contextlib.suppress(zenoh.ZError):  # the session is closed
            self._session.put(
                f"{self._key}/start/{self._names[index]}/{self._present[index]}",
                start,
                congestion_control=zenoh.CongestionControl.BLOCK,
            )
        if self._settled is not None:
            self._put(pack(self._settled))

    def _living(self) -> list[tuple[int, int]]:
        """What those report who are there and have not taken the end."""
        over = self._gone | self._done
        return [report for index, report in enumerate(self._reports) if index not in over]

    def _full(self, reports: Sequence[tuple[int, int]]) -> bool:
        """Whether as many tokens are under way as may be."""
        return self._tokens - min(taken for _, taken in reports) >= WINDOW

    def _send_held(self) -> None:
        held = self._held
        reports = self._living()
        if held is not None and not (reports and self._full(reports)):
            self._held, self._settled = None, held
            self._put(pack(held))

    def _put(self, payload: bytes) -> None:
        number = NUMBER.pack(self._incarnation, self._tokens, self._messages)
        self._tokens += 1
        try:
            if reached(self._publisher):  # a put that nobody gets is still copied
                self._publisher.put(payload, attachment=number)
        except zenoh.ZError:  # the session is closed
            self._present.clear()
            self._gone = set(range(len(self._reports))) - self._done
            self._wakeup.set()

    def _on_report(self, sample: zenoh.Sample) -> None:
        host, _, name = chunks(sample, 3)
        index = self._reader(host, name)
        report = numbers(CREDIT, sample.payload)
        if index is None or report is None:
            self._refused += 1
            return
        writer, reader, consumed, taken = report
        if (writer, reader) != (self._incarnation, self._known.get(index)):
            return  # it is not the present one that speaks, or not to this one
        if consumed > min(taken, self._messages) or taken > self._tokens:
            self._refused += 1
            return
        self._reports[index] = consumed, taken
        self._silent.discard(index)
        if self._waiting:
            self._waiting = False
            self._wakeup.set()

    def _on_presence(self, sample: zenoh.Sample) -> None:
        host, role, name, incarnation = chunks(sample, 4)
        index = self._reader(host, name)
        there = sample.kind == zenoh.SampleKind.PUT
        if index is None or role not in ("alive", "done") or not is_incarnation(incarnation):
            self._refused += there
        elif there or role != "done":
            self._news.append(_News(role, index, int(incarnation), there))
            self._wakeup.set()

    def _reader(self, host: str, name: str) -> int | None:
        """Index of the reader of this name, None where it is not that host which may speak for it."""
        index = self._index.get(name)
        return index if index is not None and self._hosts[index] == host else None
