"""The writing process of a case of `bench/runtime/edges.py`: paced messages, then as many without a pause."""

from __future__ import annotations

import json
import select
import socket
import time
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from math import prod
from typing import Any

import numpy as np
import zenoh

from benching.bare_ring import SMALL, BareWriter
from followspot.message_checks.sealing import seal
from followspot.messages import Array, Header, stamped
from followspot.tracking import Frame
from followspot.transport.edge import PortWriter
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Watermark
from followspot.transport.zenoh.edge import ZenohWriter
from followspot.transport.zenoh.network import LOOPBACK, Network
from followspot.transport.zenoh.session import config_of

BARE, SHARED, ICEORYX = "bare ring", "zenoh, shared memory", "iceoryx2"
KEY, READER, DEPTH = "bench/frame", "reader", 8
WARM_UP = 10
"""Messages at the start of a round that are not measured: first touch of memory, first wake-ups."""


def write(order: dict[str, Any]) -> float:
    """The writing process: paced messages, flooded ones, end; processor time of a paced message, s."""
    shape = tuple(order["shape"])
    if order["edge"] == BARE:
        bare = BareWriter(socket.socket(fileno=order["fd"]), order["memory"], shape)
        worked = paced(order, lambda number: send_bare(bare, shape))
        bare.end()
        return worked
    if order["edge"] == ICEORYX:
        return write_iceoryx(order, shape)
    session: Any = None
    if "connect" in order:
        session = zenoh_session(order["connect"], shared=order["edge"] == SHARED)
    writer: PortWriter
    if session:
        writer = ZenohWriter(session, KEY, {READER: ""}, DEPTH)
    else:
        writer = RingWriter([socket.socket(fileno=order["fd"])], DEPTH)
    in_place = order["edge"] == "ring in place"
    try:
        while not writer.matched():
            time.sleep(0.01)
        worked = paced(order, lambda number: send(writer, number, shape, in_place=in_place))
        writer.send(Watermark(END))
        while not writer.flush():
            sleep(writer.filenos())
            writer.drain()
    finally:
        writer.close()
        if session:
            session.close()
    return worked


def write_iceoryx(order: dict[str, Any], shape: tuple[int, ...]) -> float:
    """The same over iceoryx2."""
    from benching.iceoryx_edge import IceoryxWriter

    writer = IceoryxWriter(order["name"], shape)

    def send_one(_number: int) -> None:
        writer.loan()
        writer.send(time.monotonic_ns())

    worked = paced(order, send_one)
    writer.end()
    return worked


def zenoh_session(connect: Sequence[str] = (), *, shared: bool) -> zenoh.Session:
    """A session within this host; shared: whether Zenoh may put large messages into shared memory."""
    config = config_of(Network(LOOPBACK, tuple(connect)))
    config.insert_json5("transport/shared_memory/enabled", json.dumps(shared))
    return zenoh.open(config)


def paced(order: dict[str, Any], send_one: Callable[[int], None]) -> float:
    """Send them at the rate of the order, then as many without a pause; processor time of a paced one, s."""
    begun = 0.0
    for number in range(WARM_UP + order["messages"]):
        if number == WARM_UP:
            begun = time.process_time()
        time.sleep(1 / order["rate"])
        send_one(number)
    worked = time.process_time() - begun
    for number in range(order["messages"]):
        send_one(WARM_UP + order["messages"] + number)
    return worked / float(order["messages"])


def send(writer: PortWriter, number: int, shape: tuple[int, ...], *, in_place: bool) -> None:
    """Send one frame as soon as there is credit."""
    await_credit(writer)
    loan = writer.loan(shape, "u1") if in_place else None
    frame = seal(Frame("cam0", own(shape) if loan is None else loan))
    writer.send(stamped(frame, Header("camera/cam0", number, number, time.monotonic_ns())))


def send_bare(writer: BareWriter, shape: tuple[int, ...]) -> None:
    """Send one array as soon as there is credit."""
    await_credit(writer)
    writer.send(own(shape) if prod(shape) <= SMALL else writer.loan(), time.monotonic_ns())


def await_credit(writer: PortWriter | BareWriter) -> None:
    """Sleep until a message may be sent."""
    while not writer.credit():
        writer.want_credit()
        if not writer.credit():
            sleep(writer.filenos())
        writer.drain()


@cache
def own(shape: tuple[int, ...]) -> Array:
    """The array of a stage that computes in memory of its own."""
    return np.zeros(shape, np.uint8)


def sleep(filenos: Iterable[int]) -> None:
    """Until one of them is readable, or for the time limit that the edge's contract names."""
    ready = select.poll()
    for fileno in filenos:
        ready.register(fileno, select.POLLIN)
    ready.poll(100)
