"""Both ends of a Zenoh edge in one session, and a session of a stranger."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack

import numpy as np
import zenoh

from followspot.message_checks.sealing import seal
from followspot.messages import Header, stamped
from followspot.tracking import Frame
from followspot.transport.keys import reader_key
from followspot.transport.token import Token
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, locators, open_session

KEY = "test/camera/cam0/out"
NAME = "color/cam0.frame"
SAID = reader_key(KEY, "")
QUOTED = "color%2Fcam0.frame"
DEPTH = 4


class Pair:
    """Both ends in one session, and a stranger's session beside it."""

    def __init__(self) -> None:
        self._sessions = ExitStack()
        self.session = self._sessions.enter_context(open_session())
        self.stranger = self._sessions.enter_context(open_session(connect=locators(self.session)))
        self.writer = ZenohWriter(self.session, KEY, {NAME: ""}, DEPTH)
        self.reader = ZenohReader(self.session, KEY, NAME, Frame, DEPTH)
        until(lambda: all([self.writer.matched(), self.reader.matched()]))

    def intruder(self, key: str) -> zenoh.Publisher:
        """A stranger's publisher whose samples will arrive."""
        publisher = self.stranger.declare_publisher(key, congestion_control=zenoh.CongestionControl.BLOCK)
        until(lambda: bool(publisher.matching_status.matching))  # type: ignore[attr-defined]
        return publisher

    def finished(self) -> bool:
        """Whether the reader has all, up to the end."""
        self.writer.drain()
        return self.writer.flush()

    def close(self) -> None:
        self.writer.close()
        self.reader.close()
        self._sessions.close()


def until(condition: Callable[[], bool]) -> None:
    limit = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < limit, "it never happened"
        time.sleep(0.005)


def arrived(reader: ZenohReader, count: int) -> list[Token]:
    tokens: list[Token] = []

    def enough() -> bool:
        tokens.extend(reader.poll())
        return len(tokens) >= count

    until(enough)
    return tokens


def frame(number: int) -> Frame:
    pixels = np.full((30, 40, 3), number, np.uint8)
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number))
