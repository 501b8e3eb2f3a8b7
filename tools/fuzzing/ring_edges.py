"""Fuzz target: both ends of a ring, which receive well-formed extreme datagrams and words.

After each input a good message must pass, unless the input was one that the other end could have meant; each
input is delivered or counted as rejected.
"""

from __future__ import annotations

import random
import socket
from collections.abc import Callable
from contextlib import suppress

from followspot import tracking
from followspot.messages import InvalidMessage, Message, identical
from followspot.transport.ring.control import ARENAS, CONSUMED
from followspot.transport.ring.memory import Memory
from followspot.transport.ring.notification import ARENA, HELLO, INLINE, NOTIFICATION, SLOT, WATERMARK
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import Invalid
from fuzzing.extreme import extreme_integer, extreme_token
from fuzzing.target import Target
from fuzzing.wire import sample

_DEPTH = 4


class RingEdge:
    """A writer and a reader; on the writer's socket, and in the reader's shared words, anything may be."""

    def __init__(self) -> None:
        self._count = 0
        self._begin()

    def make(self, rng: random.Random) -> Callable[[], None]:
        """A datagram, with a descriptor now and then, or words of the reader."""
        way = rng.random()
        if way < 0.2:
            return self._words(rng)
        kind = rng.choice((HELLO, ARENA, INLINE, SLOT, WATERMARK, 0, 6, 255))
        ahead, far = rng.choice((0, 0, 1)), extreme_integer(rng, -(1 << 63), (1 << 63) - 1)
        near = rng.random() < 0.5
        slot = rng.choice((0, 1, 65535))
        rest = extreme_token(tracking.Blobs, rng)[: rng.choice((0, 64, 4096, 60_000))]
        size = rng.choice((0, 64, len(rest), extreme_integer(rng, 0, (1 << 32) - 1)))
        number = rng.choice((0, 1, ARENAS, 255))
        brings = rng.random() < 0.3

        def send() -> None:
            value = self.writer._sequence + ahead if near else far
            datagram = NOTIFICATION.pack(kind, number, slot, size, value) + rest
            if brings:
                socket.send_fds(self._sending, [datagram], [self._memory.fd])
            else:
                self._sending.send(datagram)

        return send

    def take(self, act: Callable[[], None]) -> object:
        """Do it and see what becomes of it. Raises InvalidMessage if it is refused."""
        refused = self.reader.rejected + self.writer.rejected
        sequence = self.reader._decoder.sequence
        act()
        tokens = [token for _ in range(4) for token in self.reader.poll()]
        self.writer.credit()
        self.writer.drain()
        self._count += 1
        refused = self.reader.rejected + self.writer.rejected - refused
        self._passes(self.reader._decoder.sequence != sequence or bool(self.writer.lost))
        broken = [token.reason for token in tokens if isinstance(token, Invalid)]
        if broken or refused:
            raise InvalidMessage(broken[-1] if broken else "counted")
        return tokens

    def _words(self, rng: random.Random) -> Callable[[], None]:
        """The words that a reader stores: messages consumed, released slots, whether it waits."""
        consumed = rng.choice((0, None, extreme_integer(rng, 0, (1 << 64) - 1)))
        stamp = extreme_integer(rng, 0, (1 << 64) - 1)
        arena, wakes = rng.randrange(ARENAS), rng.choice((1, 4000))

        def store() -> None:
            control = self.reader._memory.control
            assert control is not None
            control.words[CONSUMED] = self.writer._sequence if consumed is None else consumed
            control.release_all(arena, [stamp] * self.writer._slots)
            with suppress(OSError):
                self.reader._socket.send(b"\1" * wakes)

        return store

    def _begin(self) -> None:
        self._sending, receiving = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._memory = Memory.create("fuzz", 1 << 16)
        self.writer = RingWriter([self._sending], _DEPTH)
        self.reader = RingReader(receiving, tracking.Blobs)
        self._passes(misled=False)

    def _passes(self, misled: bool) -> None:
        """A good message arrives; misled: by a number or words that the other end could have meant."""
        stuck = self.writer._pool is not None and not self.writer.credit()
        if misled or stuck:
            self.writer.close()
            self.reader.close()
            self._begin()
            return
        control = self.reader._memory.control
        if control is not None:
            self.reader._consumed = self.writer._sequence
            self.reader.consumed(0)
        good = sample(tracking.Blobs, random.Random(self._count), 600 if self._count % 7 == 0 else 6)
        self.writer.send(good)
        tokens = [token for _ in range(4) for token in self.reader.poll()]
        if not (tokens and isinstance(tokens[-1], Message) and identical(tokens[-1], good)):
            raise AssertionError(f"a good message came as {str(tokens)[:300]}")
        self.reader.consumed(len(tokens))


def extreme_ring_target() -> Target:
    """A foreign writer or reader on the same host, which sends impossible control words."""
    ring = RingEdge()
    return Target(ring.make, ring.take, (InvalidMessage,))
