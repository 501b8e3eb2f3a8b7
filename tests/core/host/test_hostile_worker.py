"""Invalid messages on a worker's control channel: the host kills the worker, says why, and goes on."""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from followspot.control.dispatch import by_verb
from followspot.control.pipe import MAX_LINE, Channel
from followspot.control.worker_messages import ChangeAnswer, Log, Ready, StageCheckpoint
from followspot.host.worker_process import WorkerProcess
from followspot.host.worker_starts import WorkerStarts


class Speaker:
    """A real worker process, and a socket that sends messages in its name."""

    def __init__(self) -> None:
        handlers = dict.fromkeys((StageCheckpoint, ChangeAnswer, Log), lambda _: None)
        self.worker = WorkerProcess("left", 0, WorkerStarts(["left"], (), []).start, handlers)
        kinds = self.worker.channel._kinds
        self.worker.channel.close()
        ours, self.socket = socket.socketpair()
        self.worker.channel = Channel(ours, kinds, takes_descriptors=False)

    def say(self, data: Any) -> tuple[str, int]:
        """Send one message; return the phase and the progress of the worker then."""
        self.socket.sendall(json.dumps(data).encode() + b"\n")
        self.worker.receive()
        return self.worker.phase, self.worker.fired


@pytest.fixture
def speaker() -> Iterator[Speaker]:
    made = Speaker()
    yield made
    made.worker.end()
    made.socket.close()


def test_valid_messages_of_a_worker_are_taken(speaker: Speaker) -> None:
    assert speaker.say({"verb": "ready", "expected": None, "last_times": {"left": 5}}) == ("ready", 0)
    assert speaker.say({"verb": "progress", "fired": 3, "time": -1}) == ("ready", 3)


@pytest.mark.parametrize(
    "message",
    [
        5,
        [],
        {},
        {"verb": 5},
        {"verb": []},
        {"verb": "unheard of"},
        {"verb": "progress"},
        {"verb": "progress", "fired": 2**63, "time": 0},
        {"verb": "progress", "fired": 0, "time": 2**63},
        {"verb": "progress", "fired": float("nan"), "time": 0},
        {"verb": "progress", "fired": -1, "time": 0},
        {"verb": "ready", "expected": 10**400, "last_times": {}},
        {"verb": "ready", "expected": "many", "last_times": {}},
        {"verb": "ready", "expected": 1},
        {"verb": "ready", "expected": 1, "last_times": {"left": 2**63}},
        {"verb": "ready", "expected": 1, "last_times": {}, "descriptors": 1},
        {"verb": "ready", "expected": 1, "last_times": {}, "descriptors": -1},
        {"verb": "ready", "expected": 1, "last_times": {}, "descriptors": float("inf")},
        {"verb": "ready", "expected": 1, "last_times": {}, "descriptors": []},
        {"verb": "stages", "stages": [{"stage": "a", "state": "asleep"}], "paths": []},
        {"verb": "stages", "stages": [{"stage": "a", "state": "over", "busy_ms": float("inf")}], "paths": []},
        {"verb": "stages", "stages": 5, "paths": []},
        {"verb": "log", "records": [{"time": 2**63, "level": "info", "text": "a"}]},
        {"verb": "log", "records": [{"time": 0, "level": "info", "text": "a" * 5000}]},
        {"verb": "change", "status": {"phase": "odd"}},
        {"verb": "state", "state": 5},
        {"verb": "done", "report": {"worker": "left", "frames": 2**63}},
        {"verb": "failed"},
        {"verb": "listening", "locators": 5},
    ],
    ids=lambda message: json.dumps(message)[:60],
)
def test_a_worker_that_sends_an_invalid_message_is_killed_with_the_reason(
    speaker: Speaker, message: Any
) -> None:
    assert speaker.say(message) == ("starting", 0)
    assert not speaker.worker.busy
    assert "killed by SIGKILL, because it sent an invalid message" in speaker.worker.exit_reason()


@pytest.mark.parametrize("line", [b"\xff\n", b"[" * 200_000 + b"\n", b"{]\n", b"9" * 5000 + b"\n"])
def test_lines_that_are_no_message_kill_the_worker(speaker: Speaker, line: bytes) -> None:
    for start in range(0, len(line), 1 << 15):
        speaker.socket.sendall(line[start : start + (1 << 15)])
        speaker.worker.receive()
    assert "it sent an invalid message" in speaker.worker.exit_reason()


def test_unexpected_descriptors_are_closed(speaker: Speaker) -> None:
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(100):
        socket.send_fds(speaker.socket, [b'{"verb": "built"}\n'], [speaker.socket.fileno()] * 8)
        heard = speaker.worker.heard
        speaker.worker.receive()
        assert speaker.worker.heard > heard
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_a_long_line_takes_linear_time_and_has_a_limit() -> None:
    """Each byte is searched for a newline only once."""
    ours, theirs = socket.socketpair()
    channel = Channel(ours, by_verb([Ready]))
    piece = b"a" * (1 << 15)
    with pytest.raises(ValueError, match="longer than"):  # noqa: PT012  # somewhere on the way
        for _ in range(2 * MAX_LINE // len(piece)):
            theirs.sendall(piece)
            assert channel.arrived() == []
            assert channel._newline_free == len(channel._pending)
    channel.close()
    theirs.close()
