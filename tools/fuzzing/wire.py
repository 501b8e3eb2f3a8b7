"""Targets: messages of every type as they come over Zenoh and over a ring."""

from __future__ import annotations

import random
import socket
from typing import Any

import msgpack
import numpy as np

from followspot import people, tracking
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, InvalidMessage, Message, stamped
from followspot.transport.codec import codec_of, pack
from followspot.transport.ring.heads import HeadPacker
from followspot.transport.ring.notification import (
    INLINE,
    MESSAGE,
    NOTIFICATION,
    SLOT,
    WATERMARK,
)
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import UNKNOWN, Invalid, Watermark
from followspot.transport.wire import ALIGN, PREFIX, VERSION, unpack_head
from followspot.transport.zenoh.codec import pack_as, unpack_as
from fuzzing.mutation import broken_bytes
from fuzzing.target import Target
from fuzzing.trees import broken_tree

KINDS: tuple[type[Message], ...] = tuple(
    kind
    for module in (tracking, people)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Message) and kind is not Message
)
_SAMPLES = 40


def sample(kind: type[Message], rng: random.Random, most: int = 6) -> Message:
    """A valid message of this type with random values; most: rows."""
    numbers = np.random.default_rng(rng.randrange(1 << 30))
    sizes: dict[str, int] = {}

    def array(shape: tuple[int | str, ...], dtype: np.dtype[Any]) -> Array:
        whole = [
            size if isinstance(size, int) else sizes.setdefault(size, rng.randrange(most)) for size in shape
        ]
        if dtype.kind == "f":
            return numbers.normal(size=whole).astype(dtype)
        return numbers.integers(0, 2 if dtype.kind == "b" else 100, whole).astype(dtype)

    values: dict[str, Any] = {column.name: array(column.shape, column.dtype) for column in kind.columns}
    scalars: dict[Any, Any] = {str: "cam0", int: 3, float: 0.5, bool: True}
    values |= {name: scalars.get(of, ("a", "b")) for name, of in kind.scalars}
    message = seal(kind(**values))
    return stamped(
        message, Header(f"camera/cam{rng.randrange(6)}", rng.randrange(1000), rng.randrange(1 << 60), 7)
    )


def zenoh_target() -> Target:
    """Packets for a subscriber: raw, lossless and JPEG, messages and watermarks, and noise."""
    rng = random.Random(0)
    valid = [
        (kind, pack_as(sample(kind, rng), codec))
        for kind in KINDS
        for codec in ("raw", "lossless", "jpeg")
        for _ in range(3)
    ]
    valid += [(kind, pack(Watermark(5))) for kind in KINDS]
    data = [packed for _, packed in valid]

    def make(rng: random.Random) -> tuple[type[Message], bytes]:
        kind, packed = rng.choice(valid)
        way = rng.random()
        if way < 0.05:
            return kind, rng.randbytes(rng.choice((0, 1, 3, 64, 500)))
        if way < 0.5:
            return kind, _other_head(packed, rng)
        return rng.choice(KINDS) if way < 0.52 else kind, broken_bytes(packed, rng, data)

    return Target(make, lambda made: unpack_as(made[1], made[0]), (InvalidMessage,))


def _other_head(packed: bytes, rng: random.Random) -> bytes:
    """A message with a well-formed and wrong msgpack head."""
    fields, start = unpack_head(packed)
    head: bytes = msgpack.packb(broken_tree(fields, rng), unicode_errors="surrogatepass")[: (1 << 16) - 1]
    size = PREFIX.size + len(head)
    return PREFIX.pack(VERSION, len(head)) + head + bytes(-size % ALIGN) + packed[start:]


class Ring:
    """A reader with a fuzzed socket and the memory of a real writer."""

    def __init__(self) -> None:
        self._sending, receiving = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        rng = random.Random(1)
        self._blobs = [sample(tracking.Blobs, rng) for _ in range(_SAMPLES)]
        self._writer = RingWriter([self._sending], 4)
        self._reader = RingReader(receiving, tracking.Blobs)
        self._writer.send(sample(tracking.Blobs, rng, 1000))
        self._reader.poll()
        self._valid = [self._datagram(kind, message) for message in self._blobs for kind in (INLINE, SLOT)]
        self._valid.append(NOTIFICATION.pack(WATERMARK, 0, 0, 0, 5))

    def _datagram(self, kind: int, message: Message) -> bytes:
        codec = codec_of(type(message))
        arrays = codec.arrays(message)
        body = pack(message)[len(codec.head(message, arrays)) :]
        heads = HeadPacker(type(message))
        head, _ = heads.pack(message, arrays)
        rest = body if kind == INLINE else heads.places.pack(*range(0, ALIGN * len(arrays), ALIGN))
        return MESSAGE.pack(kind, 0, 1, len(body), 1, *message.header[1:], UNKNOWN) + head + rest

    def make(self, rng: random.Random) -> bytes:
        """A broken datagram, of no more bytes than fit."""
        datagram = bytearray(broken_bytes(rng.choice(self._valid), rng, self._valid)[:60_000])
        if len(datagram) >= NOTIFICATION.size and rng.random() < 0.5:
            numbers = [rng.choice((0, 1, 2, 3, 4, 5, 6, 255)) for _ in range(2)]
            NOTIFICATION.pack_into(datagram, 0, *numbers, rng.randrange(9), rng.choice((0, 64, 1 << 20)), 2)
        return bytes(datagram) or b"\0"

    def take(self, datagram: bytes) -> object:
        """Give it to the reader. Raises InvalidMessage if it says so."""
        self._reader._decoder.sequence = 1  # what the datagrams say: each input meets the same reader
        self._sending.send(datagram)
        tokens = self._reader.poll()
        broken = next((token.reason for token in tokens if isinstance(token, Invalid)), None)
        if broken is not None:
            raise InvalidMessage(broken)
        if not tokens:
            raise InvalidMessage("no datagram of a ring")
        return tokens


def ring_target() -> Target:
    """Packets of a process that has got hold of the socket of a reader on the same host."""
    ring = Ring()
    return Target(ring.make, ring.take, (InvalidMessage,))
