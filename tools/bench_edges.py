"""Latency and throughput of frames between two processes: the ring, with and without a copy, and Zenoh.

    python tools/bench_edges.py --rounds 5

Every round runs every case once, one after the other, so that a busy machine slows all of them alike;
the median over the rounds is printed, and how many times slower each edge is than the ring in place.
The clock of a message starts when its array is complete, and stops when the reader has it.
"""

from __future__ import annotations

import argparse
import json
import select
import socket
import subprocess
import sys
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import numpy as np

from followspot.messages import Array, Header, Message, seal, stamped
from followspot.tables import table
from followspot.tracking import Frame
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, locators, open_session
from scripting import options_of

SIZES = {"640x480": (480, 640, 3), "1920x1080": (1080, 1920, 3)}
EDGES = ("ring in place", "ring one copy", "zenoh")
KEY, READER, DEPTH = "bench/frame", "reader", 8
WARM_UP = 10
"""Messages at the start of a round that are not measured: first touch of memory, first wake-ups."""


@dataclass(frozen=True)
class Result:
    """One edge at one frame size; medians over the rounds."""

    edge: str
    size: str
    p50_ms: float
    p99_ms: float
    per_second: float


def main() -> None:
    """Run the benchmark, or the writing process of one round."""
    options = arguments()
    if options.writer:
        write(json.loads(options.writer))
        return
    rounds = [
        {(edge, size): measure(edge, size, options) for size in SIZES for edge in EDGES}
        for _ in range(options.rounds)
    ]
    results = [
        Result(edge, size, *(float(median(found[edge, size][i] for found in rounds)) for i in range(3)))
        for size in SIZES
        for edge in EDGES
    ]
    print(json.dumps(report(results), indent=2) if options.json else text(results))


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = options_of(__doc__)
    parser.add_argument("--rounds", type=int, default=3, help="interleaved rounds (default %(default)s)")
    parser.add_argument(
        "--messages", type=int, default=100, help="frames per round and phase (default %(default)s)"
    )
    parser.add_argument("--rate", type=float, default=60, help="frames per second while latency is measured")
    parser.add_argument("--writer", help=argparse.SUPPRESS)
    return parser.parse_args()


def measure(edge: str, size: str, options: argparse.Namespace) -> tuple[float, float, float]:
    """One round of one case, read in this process: latency p50 and p99, ms; flooded frames per second."""
    order = {"edge": edge, "shape": SIZES[size], "messages": options.messages, "rate": options.rate}
    session: Any = open_session() if edge == "zenoh" else None
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    order |= {"connect": locators(session)} if session else {"fd": far.fileno()}
    command = [sys.executable, __file__, "--writer", json.dumps(order)]
    with near, far, subprocess.Popen(command, pass_fds=[far.fileno()]):
        far.close()
        reader: PortReader
        reader = ZenohReader(session, KEY, READER, Frame, DEPTH) if session else RingReader(near, Frame)
        try:
            return figures(*arrivals(reader), options.messages)
        finally:
            reader.close()
            if session:
                session.close()


def arrivals(reader: PortReader) -> tuple[Array, Array]:
    """When each message was complete and when it arrived, (N,) ns each."""
    times: list[tuple[int, int]] = []
    ended = False
    while not ended and not reader.lost:
        sleep([reader.fileno()])
        for token in reader.poll():
            if isinstance(token, Message):
                times.append((token.header.entered, time.monotonic_ns()))
                reader.consumed()
            ended |= token == Watermark(END)
    sent, arrived = np.array(times).T
    return sent, arrived


def figures(sent: Array, arrived: Array, messages: int) -> tuple[float, float, float]:
    """Latency of the paced frames, ms (p50, p99), and rate of the flooded ones, 1/s."""
    paced = slice(WARM_UP, WARM_UP + messages)
    p50, p99 = np.percentile((arrived - sent)[paced], (50, 99)) / 1e6
    flooded = arrived[WARM_UP + messages :]
    return float(p50), float(p99), float((len(flooded) - 1) * 1e9 / (flooded[-1] - flooded[0]))


def write(order: dict[str, Any]) -> None:
    """The writing process: paced frames, flooded frames, end."""
    session: Any = open_session(connect=order["connect"]) if "connect" in order else None
    writer: PortWriter
    if session:
        writer = ZenohWriter(session, KEY, {READER: ""}, DEPTH)
    else:
        writer = RingWriter([socket.socket(fileno=order["fd"])], DEPTH)
    try:
        while not writer.matched():
            time.sleep(0.01)
        for number in range(WARM_UP + 2 * order["messages"]):
            if number < WARM_UP + order["messages"]:
                time.sleep(1 / order["rate"])
            send(writer, number, tuple(order["shape"]), in_place=order["edge"] == "ring in place")
        writer.send(Watermark(END))
        while not writer.flush():
            sleep(writer.filenos())
            writer.drain()
    finally:
        writer.close()
        if session:
            session.close()


def send(writer: PortWriter, number: int, shape: tuple[int, ...], *, in_place: bool) -> None:
    """Send one frame as soon as there is credit."""
    while not writer.credit():
        writer.want_credit()
        if not writer.credit():
            sleep(writer.filenos())
        writer.drain()
    loan = writer.loan(shape, "u1") if in_place else None
    own = PIXELS.setdefault(shape, np.zeros(shape, np.uint8))
    frame = seal(Frame("cam0", own if loan is None else loan))
    writer.send(stamped(frame, Header("camera/cam0", number, number, time.monotonic_ns())))


PIXELS: dict[tuple[int, ...], Array] = {}
"""The picture of a stage that computes in memory of its own."""


def sleep(filenos: Iterable[int]) -> None:
    """Until one of them is readable, or for the time limit that the edge's contract names."""
    ready = select.poll()
    for fileno in filenos:
        ready.register(fileno, select.POLLIN)
    ready.poll(100)


def report(results: list[Result]) -> dict[str, Any]:
    """The results with their ratios to the ring in place."""
    return {"results": [asdict(result) | {"times_slower": slower(result, results)} for result in results]}


def slower(result: Result, results: list[Result]) -> dict[str, float]:
    """Ratio to the ring written in place at the same size: latency, and throughput."""
    best = next(r for r in results if r.edge == EDGES[0] and r.size == result.size)
    return {"p50": result.p50_ms / best.p50_ms, "per_frame": best.per_second / result.per_second}


def text(results: list[Result]) -> str:
    """The results for people."""
    rows = [
        (
            *(
                f"{found.size} {found.edge}",
                f"{found.p50_ms:.3f}",
                f"{found.p99_ms:.3f}",
                f"{found.per_second:.0f}",
            ),
            *(f"{ratio:.1f}x" for ratio in slower(found, results).values()),
        )
        for found in results
    ]
    return table(("frame and edge", "p50 ms", "p99 ms", "frames/s", "slower p50", "flooded"), rows)


if __name__ == "__main__":
    main()
