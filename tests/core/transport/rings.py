"""A ring with both ends in one process, and frames to send through it."""

from __future__ import annotations

import socket

import numpy as np

from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, Message, stamped
from followspot.tracking import Frame
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import Token

DEPTH = 4
SHAPE = (60, 80, 3)


class Ring:
    """A writer and its readers."""

    def __init__(self, readers: int = 1, kind: type[Message] = Frame, depth: int = DEPTH) -> None:
        pairs = [socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for _ in range(readers)]
        self.writer = RingWriter([ours for ours, _ in pairs], depth)
        self.readers = [RingReader(theirs, kind) for _, theirs in pairs]

    def loan(self, shape: tuple[int, ...], dtype: str) -> Array:
        """A loan that must not fail."""
        array = self.writer.loan(shape, dtype)
        assert array is not None
        return array

    def use_all_slots(self) -> tuple[list[Array], list[Token]]:
        """Loans, and messages that the first reader keeps; two further messages are in flight."""
        loans = [self.loan(SHAPE, "u1") for _ in range(DEPTH + 1)]
        kept = []
        for number in range(DEPTH + 1):
            self.writer.send(frame(number))
            kept += self.readers[0].poll()
            self.readers[0].consumed()
        self.writer.send(frame(5))
        self.writer.send(frame(6))
        return loans, kept

    def __enter__(self) -> Ring:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self.writer.close()
        for reader in self.readers:
            reader.close()


def frame(number: int, pixels: Array | None = None) -> Frame:
    if pixels is None:
        pixels = np.full(SHAPE, number % 251, np.uint8)
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number))


def messages(tokens: list[Token]) -> list[Message]:
    assert all(isinstance(token, Message) for token in tokens), tokens
    return [token for token in tokens if isinstance(token, Message)]
