"""The other end of an edge, in a process of its own: `python edge_end.py '{"role": "reader", ...}'`."""

from __future__ import annotations

import json
import select
import socket
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, stamped
from followspot.tracking import Blobs, Frame
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Token, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, open_session

KEY = "test/port"


def frame(number: int, shape: tuple[int, ...], writer: PortWriter | None = None) -> Frame:
    """A frame that shows its number; computed in a loan where a writer is given."""
    loan = None if writer is None else writer.loan(shape, "u1")
    pixels = np.empty(shape, np.uint8) if loan is None else loan
    pixels[:] = number % 251
    return stamped(seal(Frame("cam0", pixels)), Header("camera/cam0", number, number))


def intact(message: Message) -> bool:
    """Whether the frame still shows its number."""
    return not isinstance(message, Frame) or bool((message.pixels == message.header.seq % 251).all())


def send_all(writer: PortWriter, tokens: Iterable[Message | Watermark]) -> None:
    """Send with credit, sleeping while there is none, until all is out of the process."""
    for token in tokens:
        while isinstance(token, Message) and not writer.credit():
            writer.want_credit()
            if not writer.credit():
                sleep(writer.filenos())
            writer.drain()
        writer.send(token)
    while not writer.flush():
        sleep(writer.filenos())
        writer.drain()


def sleep(filenos: Iterable[int]) -> None:
    """Until one of them is readable, or for the time limit that the edge's contract names."""
    ready = select.poll()
    for fileno in filenos:
        ready.register(fileno, select.POLLIN)
    ready.poll(100)


def receive(reader: PortReader) -> list[Token]:
    """What comes next; nothing if the writer is lost."""
    while not (tokens := reader.poll()) and not reader.lost:
        sleep([reader.fileno()])
    return tokens


def read_to_end(reader: PortReader, delay: float, keep: int) -> dict[str, Any]:
    """Read slowly, keep every `keep`th message; what was found."""
    seqs: list[int] = []
    others: list[str] = []
    kept: list[Message] = []
    damaged = 0
    while Watermark(END) not in (tokens := receive(reader)) and not reader.lost:
        damaged += take(reader, tokens, seqs, others, kept, delay, keep)
    damaged += take(reader, tokens, seqs, others, kept, delay, keep)
    return {
        "seqs": seqs,
        "others": others,
        "damaged": damaged + sum(not intact(message) for message in kept),
        "lost": reader.lost,
        "peak_mb": peak_mb(),
    }


def peak_mb() -> int:
    """Most memory that this process ever held, MB; the rusage figure would inherit that of its parent."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) // 1024


def take(
    reader: PortReader,
    tokens: list[Token],
    seqs: list[int],
    others: list[str],
    kept: list[Message],
    delay: float,
    keep: int,
) -> int:
    """Consume the messages among the tokens; how many were damaged."""
    damaged = 0
    for token in tokens:
        if not isinstance(token, Message):
            others += [str(token)] if not isinstance(token, Watermark) or token.time == END else []
            continue
        time.sleep(delay)
        seqs.append(token.header.seq)
        damaged += not intact(token)
        if keep and len(seqs) % keep == 0:
            kept.append(token)
        reader.consumed()
    tokens.clear()
    return damaged


def main(order: dict[str, Any]) -> None:
    """Play the part that the order says, and print what was found."""
    session: Any = open_session(connect=order["connect"]) if "connect" in order else None
    depth = order["depth"]
    end: PortReader | PortWriter
    kind = {"Frame": Frame, "Blobs": Blobs}[order["kind"]]
    if order["role"] == "reader":
        if session is None:
            end = RingReader(socket.socket(fileno=order["fd"]), kind)
        else:
            end = ZenohReader(session, KEY, order["name"], kind, depth)
        play: Callable[[Any, dict[str, Any]], None] = reading
    else:
        if session is None:
            end = RingWriter([socket.socket(fileno=order["fd"])], depth)
        else:
            end = ZenohWriter(session, KEY, {order["name"]: ""}, depth)
        play = writing
    try:
        while not end.matched():
            time.sleep(0.01)
        print("ready", flush=True)
        play(end, order)
    finally:
        end.close()
        if session is not None:
            session.close()


def reading(reader: Any, order: dict[str, Any]) -> None:
    """Read to the end."""
    print(json.dumps(read_to_end(reader, order["delay"], order["keep"])), flush=True)


def writing(writer: Any, order: dict[str, Any]) -> None:
    """Send frames; then end, or stay without a word."""
    send_all(writer, (frame(n, tuple(order["shape"]), writer) for n in range(order["count"])))
    if order["end"]:
        send_all(writer, [Watermark(END)])
    print("sent", flush=True)
    sys.stdin.readline()


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
