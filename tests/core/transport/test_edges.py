"""Both kinds of edge between real processes: the same promises on the ring and on Zenoh."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.core.transport.edge_end import KEY, frame, intact, receive, send_all
from tests.integration.running import unused_memory

from followspot.message_checks.sealing import seal
from followspot.messages import Header, Message, identical, stamped
from followspot.tracking import Blobs, Frame
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.ring.reader import RingReader
from followspot.transport.ring.writer import RingWriter
from followspot.transport.token import END, Token, Watermark
from followspot.transport.zenoh.edge import ZenohReader, ZenohWriter, locators, open_session

EDGE_END = Path(__file__).with_name("edge_end.py")
DEPTH = 4
VGA = (480, 640, 3)
FULL_HD = (1080, 1920, 3)
TIMEOUT = 60.0
"""Seconds after which a test gives up; none waits that long when it passes."""


class Edge:
    """One end of an edge here, the other ends in processes of their own."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.session: Any = open_session() if kind == "zenoh" else None
        self.processes: list[subprocess.Popen[str]] = []
        self.ends: list[PortWriter | PortReader] = []

    def start(self, **order: Any) -> socket.socket | None:
        """Start the other end; the near socket of a ring."""
        order = {"kind": "Frame", "depth": DEPTH, "name": f"stage/{len(self.processes)}.in"} | order
        near = far = None
        if self.session is None:
            near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
            order["fd"] = far.fileno()
        else:
            order["connect"] = locators(self.session)
        command = [sys.executable, str(EDGE_END), json.dumps(order)]
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            pass_fds=[far.fileno()] if far else [],
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        )
        self.processes.append(process)
        if far:
            far.close()
        return near

    def writer(self, *orders: dict[str, Any]) -> PortWriter:
        """A writer here, with a reader for each order, all of them ready."""
        sockets = [self.start(role="reader", **({"delay": 0, "keep": 0} | order)) for order in orders]
        writer: PortWriter
        if self.session is None:
            writer = RingWriter([s for s in sockets if s], DEPTH)
        else:
            names = {f"stage/{index}.in": "" for index in range(len(orders))}
            writer = ZenohWriter(self.session, KEY, names, DEPTH)
        self._ready(writer)
        return writer

    def reader(self, **order: Any) -> PortReader:
        """A reader here, with a writer in another process."""
        near = self.start(role="writer", **({"shape": VGA, "count": 10, "end": True} | order))
        reader: PortReader
        if near is not None:
            reader = RingReader(near, Frame)
        else:
            assert self.session is not None
            reader = ZenohReader(self.session, KEY, "stage/0.in", Frame, DEPTH)
        self._ready(reader)
        return reader

    def _ready(self, end: PortWriter | PortReader) -> None:
        self.ends.append(end)
        until(end.matched)
        for process in self.processes:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"

    def found(self, index: int = 0) -> dict[str, Any]:
        """What the reader of that process found."""
        output, _ = self.processes[index].communicate(timeout=TIMEOUT)
        assert self.processes[index].returncode == 0
        return json.loads(output)  # type: ignore[no-any-return]

    def kill(self, index: int = 0) -> None:
        """Kill -9."""
        self.processes[index].send_signal(signal.SIGKILL)
        self.processes[index].wait(TIMEOUT)

    def close(self) -> None:
        for end in self.ends:
            end.close()
        if self.session is not None:
            self.session.close()
        for process in self.processes:
            process.kill()
            process.communicate()


@pytest.fixture(params=["ring", "zenoh"])
def edge(request: pytest.FixtureRequest) -> Iterator[Edge]:
    made = Edge(request.param)
    yield made
    made.close()


@pytest.fixture
def ring() -> Iterator[Edge]:
    made = Edge("ring")
    yield made
    made.close()


def until(condition: Callable[[], bool]) -> None:
    """Wait for what another process will do."""
    limit = time.monotonic() + TIMEOUT
    while not condition():
        assert time.monotonic() < limit, "it never happened"
        time.sleep(0.005)


def read_until_over(reader: PortReader) -> list[Token]:
    tokens: list[Token] = []
    while Watermark(END) not in tokens and not reader.lost:
        tokens += (arrived := receive(reader))
        reader.consumed(sum(isinstance(token, Message) for token in arrived))
    return tokens + reader.poll()


def blobs(number: int) -> Blobs:
    return stamped(seal(Blobs.empty()), Header("color/cam0", number, number))


def test_thousands_of_small_messages_arrive_in_order_at_two_readers(edge: Edge) -> None:
    many = {"ring": 4_000, "zenoh": 1_000}[edge.kind]  # of the depth of any queue of Zenoh, several times
    writer = edge.writer({"kind": "Blobs"}, {"kind": "Blobs"})
    send_all(writer, (blobs(number) for number in range(many)))
    send_all(writer, [Watermark(END)])
    for index in range(2):
        found = edge.found(index)
        assert found["seqs"] == list(range(many))
        assert found["others"] == [str(Watermark(END))]
        assert not found["lost"]


def test_frames_of_six_megabytes_arrive_intact(edge: Edge) -> None:
    writer = edge.writer({})
    send_all(writer, (frame(number, FULL_HD, writer if number % 2 else None) for number in range(16)))
    send_all(writer, [Watermark(END)])
    found = edge.found()
    assert found["seqs"] == list(range(16))
    assert found["damaged"] == 0


def test_a_slow_reader_loses_nothing_and_its_memory_stays_bounded(edge: Edge) -> None:
    """300 frames of 0.9 MB would take 276 MB; the depth of the edge is 4."""
    writer = edge.writer({"delay": 0.002})
    send_all(writer, (frame(number, VGA) for number in range(300)))
    send_all(writer, [Watermark(END)])
    found = edge.found()
    assert found["seqs"] == list(range(300))
    assert found["damaged"] == 0
    assert found["peak_mb"] < 160


def test_a_reader_keeps_old_frames_and_they_never_change(edge: Edge) -> None:
    writer = edge.writer({"keep": 2}, {"keep": 5})
    send_all(writer, (frame(number, (120, 160, 3), writer) for number in range(200)))
    send_all(writer, [Watermark(END)])
    for index in range(2):
        found = edge.found(index)
        assert found["seqs"] == list(range(200))
        assert found["damaged"] == 0


def test_the_end_arrives_after_any_number_of_watermarks(edge: Edge) -> None:
    writer = edge.writer({})
    send_all(writer, (Watermark(time) for time in range(20_000)))
    send_all(writer, [frame(20_000, (2, 2, 1)), Watermark(END)])
    found = edge.found()
    assert found["seqs"] == [20_000]
    assert found["others"] == [str(Watermark(END))]


def test_a_killed_reader_is_named_and_holds_nothing_up(edge: Edge) -> None:
    writer = edge.writer({"delay": 0.001}, {"delay": 1000.0})
    send_all(writer, (frame(number, VGA) for number in range(DEPTH)))
    assert writer.credit() == 0
    edge.kill(1)
    send_all(writer, (frame(number, VGA) for number in range(DEPTH, 40)))
    send_all(writer, [Watermark(END)])
    assert writer.lost == {1}
    found = edge.found(0)
    assert found["seqs"] == list(range(40))
    assert found["damaged"] == 0


def test_all_readers_killed_leaves_a_writer_that_goes_on_alone(edge: Edge) -> None:
    writer = edge.writer({"delay": 1000.0})
    send_all(writer, (frame(number, VGA) for number in range(DEPTH)))
    edge.kill()
    send_all(writer, (frame(number, VGA) for number in range(DEPTH, 40)))
    send_all(writer, [Watermark(END)])
    assert writer.lost == {0}


def test_a_killed_writer_is_lost_and_what_it_had_sent_is_there(edge: Edge) -> None:
    reader = edge.reader(count=3, end=False)
    tokens: list[Token] = []
    while len(tokens) < 3:
        tokens += receive(reader)
    lost_before = reader.lost
    edge.kill()
    until(lambda: reader.poll() == [] and reader.lost)
    assert not lost_before
    assert [token.header.seq for token in tokens if isinstance(token, Message)] == [0, 1, 2]
    assert all(intact(token) for token in tokens if isinstance(token, Message))


def test_a_writer_killed_in_full_flight_leaves_whole_messages_only(edge: Edge) -> None:
    reader = edge.reader(count=100_000, end=False)
    tokens = receive(reader)
    reader.consumed(len(tokens))
    edge.kill()
    tokens += read_until_over(reader)
    assert reader.lost
    frames = [token for token in tokens if isinstance(token, Frame)]
    assert [message.header.seq for message in frames] == list(range(len(frames)))
    assert all(identical(message, frame(message.header.seq, VGA)) for message in frames[-DEPTH:])


def test_kills_leave_no_file_behind(ring: Edge) -> None:
    before = unused_memory()
    writer = ring.writer({"delay": 1000.0})
    send_all(writer, [frame(0, FULL_HD)])
    ring.kill()
    until(lambda: unused_memory() <= before)  # other processes of this machine come and go, too


def test_a_loan_reaches_the_other_process_without_a_copy(ring: Edge) -> None:
    """The slot is one piece of memory: what is written behind the seal shows in the other process."""
    writer = ring.writer({"keep": 1})
    loan = writer.loan(VGA, "u1")
    assert loan is not None
    behind = loan.view()
    loan[:] = 0
    send_all(writer, [stamped(seal(Frame("cam0", loan)), Header("camera/cam0", 0, 0)), frame(1, VGA)])
    until(lambda: writer.credit() == DEPTH)  # both were found intact
    behind[:] = 9
    send_all(writer, [Watermark(END)])
    assert ring.found()["damaged"] == 1
