"""One message from end to end within a process: by system calls alone, a bare ring, and the ring itself."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from math import prod
from typing import Any

import numpy as np

from benching.bare_ring import SMALL, BareReader, BareWriter, create
from benching.edge_writer import DEPTH
from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, stamped
from followspot.tracking import Frame
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter

HEAD = 96
"""Bytes of a datagram without its arrays, about those of the ring."""
Hop = Callable[[int], None]
"""Send and read the message of this number."""


def system_calls(shape: tuple[int, ...]) -> Hop:
    """A datagram of the size that a message has."""
    near, far = pair()
    data = bytes(HEAD + prod(shape) * (prod(shape) <= SMALL))
    buffer = [bytearray(HEAD + SMALL)]

    def hop(_number: int) -> None:
        far.send(data)
        near.recvmsg_into(buffer, socket.CMSG_LEN(4), socket.MSG_CMSG_CLOEXEC)

    return hop


def and_messages(shape: tuple[int, ...]) -> Hop:
    """The same, and what stages get in their hands at both ends."""
    datagram, pixels = system_calls(shape), np.zeros(shape, np.uint8)

    def hop(number: int) -> None:
        made(pixels, number)
        datagram(number)
        read = object.__new__(Frame)
        read.__dict__.update(camera="cam0", pixels=np.ndarray(shape, np.uint8, pixels), header=header(number))

    return hop


def bare_ring(shape: tuple[int, ...]) -> Hop:
    """The yardstick."""
    near, far = pair()
    memory = create(shape)
    writer, reader = BareWriter(far, memory, shape), BareReader(near, memory, shape)
    own = np.zeros(shape, np.uint8)

    def hop(_number: int) -> None:
        writer.credit()
        writer.send(own if own.nbytes <= SMALL else writer.loan(), time.monotonic_ns())
        reader.poll()
        reader.consumed()

    return hop


def ring(shape: tuple[int, ...]) -> Hop:
    """The edge as it is: what is large is written in place."""
    near, far = pair()
    writer, reader = RingWriter([far], DEPTH), RingReader(near, Frame)
    own = np.zeros(shape, np.uint8)

    def hop(number: int) -> None:
        writer.credit()
        loan = writer.loan(shape, "u1")
        writer.send(made(own if loan is None else loan, number))
        del loan
        count = sum(isinstance(token, Message) for token in reader.poll())
        if not count:
            raise RuntimeError("the message did not arrive")
        reader.consumed(count)

    return hop


CASES: dict[str, Callable[[tuple[int, ...]], Hop]] = {
    "system calls": system_calls,
    "and messages": and_messages,
    "bare ring": bare_ring,
    "ring": ring,
}


def pair() -> tuple[socket.socket, socket.socket]:
    """Both ends of a connection."""
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    near.setblocking(False)
    far.setblocking(False)
    return near, far


def header(number: int) -> Header:
    """The header of a message of a source."""
    return Header("camera/cam0", number, number, time.monotonic_ns())


def made(pixels: np.ndarray[Any, Any], number: int) -> Frame:
    """A message as the worker sends it."""
    return stamped(seal(Frame("cam0", pixels)), header(number))
