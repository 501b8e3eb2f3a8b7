"""Latency, processor time and rate of a hop between two processes: the ring, iceoryx2, Zenoh, a bare ring.

    python tools/bench/runtime/edges.py --rounds 5

Every round runs every case once, one after the other, so that a busy machine slows all of them alike;
the median over the rounds is printed, and the ratio to a bare ring (`tools/benching/bare_ring.py`), the least
that Python needs. The clock of a message starts when its array is complete, and stops when the reader has it.
Pictures are sent at 60 a second, arrays of 1 kB at 200, and then as fast as the reader takes them. Processor
time is that of both ends at these rates, from asking for credit to giving it back.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any, NamedTuple, Protocol

import numpy as np

from benching.bare_ring import Arrived, BareReader, create
from benching.edge_writer import (
    BARE,
    DEPTH,
    ICEORYX,
    KEY,
    READER,
    SHARED,
    WARM_UP,
    sleep,
    write,
    zenoh_session,
)
from followspot.messages import Array, Message
from followspot.tracking import Frame
from followspot.transport.edge import PortReader
from followspot.transport.ring.reader import RingReader
from followspot.transport.zenoh.edge import ZenohReader, locators
from scripting import shown, table_options

SIZES = {"1 kB": (18, 19, 3), "640x480": (480, 640, 3), "1920x1080": (1080, 1920, 3)}
RATES = {"1 kB": 200.0}
PICTURES = 60.0
"""Pictures per second while latency is measured."""
ZENOH = ("zenoh", SHARED)
EDGES = (BARE, "ring in place", "ring one copy", ICEORYX, *ZENOH)


class Reader(Protocol):
    """What reads an edge."""

    def poll(self) -> Sequence[Any]:
        """What has come."""

    def consumed(self) -> None:
        """Give credit for one message."""


class Round(NamedTuple):
    """One round of one case: latency of paced messages, their processor time at both ends, flooded rate."""

    p50_us: float
    p99_us: float
    cpu_us: float
    per_second: float


@dataclass(frozen=True)
class Result:
    """One edge at one size: medians over the rounds, and of the ratios to the bare ring of the same round."""

    edge: str
    size: str
    round: Round
    ratio: Round


def main() -> None:
    """Run the benchmark, or the writing process of one round."""
    options = parser().parse_args()
    if options.writer:
        print(json.dumps(write(json.loads(options.writer))))
        return
    edges = list(dict.fromkeys((BARE, *filter(installed, options.edges))))
    cases = [(edge, size) for size in options.sizes for edge in edges]
    rounds = [
        {(edge, size): measure(edge, size, options.messages) for edge, size in cases}
        for _ in range(options.rounds)
    ]
    results = summary(rounds)
    print(
        json.dumps([asdict(found) for found in results], indent=2) if options.json else text(options, results)
    )


def parser() -> argparse.ArgumentParser:
    """The command line."""
    options = table_options(__doc__)
    options.add_argument("--rounds", type=int, default=3, help="interleaved rounds (default %(default)s)")
    options.add_argument(
        "--messages", type=int, default=100, help="messages per round and phase (default %(default)s)"
    )
    options.add_argument("--sizes", nargs="+", choices=SIZES, default=list(SIZES), help="default: all")
    options.add_argument("--edges", nargs="+", choices=EDGES, default=list(EDGES), help="default: all")
    options.add_argument("--writer", help=argparse.SUPPRESS)
    return options


def installed(edge: str) -> bool:
    """Whether an edge is there; says so if not."""
    there = edge != ICEORYX or importlib.util.find_spec("iceoryx2") is not None
    if not there:
        print(f"{edge} is left out: pip install 'followspot[peers]'", file=sys.stderr)
    return there


def measure(edge: str, size: str, messages: int) -> Round:
    """One round of one case, read in this process."""
    shape = SIZES[size]
    order = {"edge": edge, "shape": shape, "messages": messages, "rate": RATES.get(size, PICTURES)}
    if edge == ICEORYX:
        return measure_iceoryx(order, shape)
    session: Any = zenoh_session(shared=edge == SHARED) if edge in ZENOH else None
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    memory = create(shape)
    order |= {"connect": locators(session)} if session else {"fd": far.fileno(), "memory": memory}
    command = [sys.executable, __file__, "--writer", json.dumps(order)]
    passed = [far.fileno(), memory]
    with near, far, subprocess.Popen(command, pass_fds=passed, stdout=subprocess.PIPE) as writer:
        far.close()
        try:
            if edge == BARE:
                bare = BareReader(near, memory, shape)
                return figures(arrivals(bare, lambda: sleep([near.fileno()])), messages, writer)
            reader: PortReader
            reader = ZenohReader(session, KEY, READER, Frame, DEPTH) if session else RingReader(near, Frame)
            try:
                return figures(arrivals(reader, lambda: sleep([reader.fileno()])), messages, writer)
            finally:
                reader.close()
        finally:
            os.close(memory)
            if session:
                session.close()


def measure_iceoryx(order: dict[str, Any], shape: tuple[int, ...]) -> Round:
    """The same over iceoryx2, whose processes find each other by a name."""
    from benching.iceoryx_edge import IceoryxReader

    order["name"] = f"followspot/bench/{os.getpid()}/{time.monotonic_ns()}"
    reader = IceoryxReader(order["name"], shape)
    command = [sys.executable, __file__, "--writer", json.dumps(order)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as writer:
        return figures(arrivals(reader, reader.wait), order["messages"], writer)


def arrivals(reader: Reader, wait: Callable[[], None]) -> Array:
    """Of each message when it was complete, when it arrived and the processor time by then, (N, 3) ns."""
    times: list[tuple[int, int, int]] = []
    ended = False
    while not ended:
        wait()
        tokens: Sequence[Any] = reader.poll()
        for token in tokens:
            if isinstance(token, Message):
                times.append((token.header.entered, time.monotonic_ns(), time.process_time_ns()))
                reader.consumed()
            elif isinstance(token, Arrived) and token.number >= 0:
                times.append((token.entered, time.monotonic_ns(), time.process_time_ns()))
                reader.consumed()
            else:
                ended = True
    return np.array(times)


def figures(times: Array, messages: int, writer: subprocess.Popen[bytes]) -> Round:
    """What the reader saw, and the writer's processor time, which it prints, s a message."""
    assert writer.stdout is not None
    written = json.loads(writer.stdout.read())
    sent, arrived, worked = times.T
    end = WARM_UP + messages
    p50, p99 = np.percentile((arrived - sent)[WARM_UP:end], (50, 99)) / 1e3
    read = (worked[end - 1] - worked[WARM_UP - 1]) / messages
    flooded = arrived[end:]
    rate = (len(flooded) - 1) * 1e9 / (flooded[-1] - flooded[0])
    return Round(float(p50), float(p99), float(read / 1e3 + written * 1e6), float(rate))


def summary(rounds: Sequence[dict[tuple[str, str], Round]]) -> list[Result]:
    """Medians over the rounds, and of the ratios to the bare ring within each."""
    results = []
    for edge, size in rounds[0]:
        found = [by_case[edge, size] for by_case in rounds]
        ratios = [
            [one / bare for one, bare in zip(by_case[edge, size], by_case[BARE, size], strict=True)]
            for by_case in rounds
        ]
        results.append(
            Result(edge, size, *(Round(*map(median, zip(*rows, strict=True))) for rows in (found, ratios)))
        )
    return results


def text(options: argparse.Namespace, results: Sequence[Result]) -> str:
    """The results for people."""
    rows = [
        (
            *(f"{found.size} {found.edge}", *(f"{value:.0f}" for value in found.round)),
            *(f"{ratio:.2f}" for ratio in found.ratio),
        )
        for found in results
    ]
    heads = ("size and edge", "p50 us", "p99 us", "CPU us", "flooded/s")
    return shown(options, (*heads, "x p50", "x p99", "x CPU", "x flooded"), rows)


if __name__ == "__main__":
    main()
