"""Other processes of the user find a run by its control socket and ask it; it refuses invalid requests."""

from __future__ import annotations

import json
import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import pytest

from followspot.control.dispatch import Dispatcher, Request, Role
from followspot.control.unix_socket import MAX_REQUEST, serve_requests
from followspot.errors import FollowspotError
from followspot.operator.connect import runs_here

RUN = "feedc0de" * 4


class Double(Request):
    number: int
    roles: ClassVar[tuple[Role, ...]] = ("operator",)
    answer: ClassVar[Any] = int


class Halve(Double):
    """A request without a handler."""


class Wait(Request):
    roles: ClassVar[tuple[Role, ...]] = ("operator",)
    answer: ClassVar[Any] = str


def double(request: Double) -> int:
    if request.number < 0:
        raise FollowspotError("no negative numbers")
    return 2 * request.number


DOUBLING = Dispatcher("operator", {Double: double})


def socket_name() -> str:
    """Name of the run's socket, without the null byte that makes it abstract."""
    words = Path("/proc/net/unix").read_text().split()
    return next(word[1:] for word in words if word.endswith(RUN[:16]))


def this() -> list[str]:
    return [run.run for run in runs_here() if run.run == RUN]


def test_a_run_is_found_answers_and_leaves_no_socket() -> None:
    with serve_requests(RUN, "graph", DOUBLING):
        (run,) = [run for run in runs_here() if run.run == RUN]
        assert run.graph == "graph"
        assert run.ask(Double(number=21), 10.0) == 42
        for wanted in (str(os.getpid()), RUN[:8]):
            assert [found.run for found in runs_here(wanted)] == [RUN]
        with pytest.raises(FollowspotError, match="no negative numbers"):
            run.ask(Double(number=-1), 10.0)
        with pytest.raises(FollowspotError, match=r"no request 'halve'; known: double"):
            run.ask(Halve(number=1), 10.0)
    assert this() == []
    assert RUN[:16] not in Path("/proc/net/unix").read_text()
    with pytest.raises(FollowspotError, match="does not answer"):
        run.ask(Double(number=1), 10.0)


def test_pending_requests_are_answered_at_the_end_and_later_ones_are_not() -> None:
    asked, returned, answers = threading.Event(), threading.Event(), []

    def slow(_: Wait) -> str:
        asked.set()
        time.sleep(0.2)
        returned.set()
        return "done"

    with socket.socket(socket.AF_UNIX) as silent:
        with serve_requests(RUN, "graph", Dispatcher("operator", {Wait: slow})):
            (run,) = [run for run in runs_here() if run.run == RUN]
            silent.connect(f"\0{socket_name()}")
            asking = threading.Thread(target=lambda: answers.append(run.ask(Wait(), 60.0)))
            asking.start()
            assert asked.wait(60.0)
        assert returned.is_set()
        assert "refused" in json.loads(silent.makefile().readline())
    asking.join()
    assert answers == ["done"]


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"\n",
        b"[]\n",
        b"7\n",
        b'{"verb": []}\n',
        b'{"verb": "double", "numbers": 1}\n',
        b'{"verb": "double", "number": "one"}\n',
        b"\xff\n",
        b"[" * 100_000 + b"\n",
    ],
)
def test_invalid_requests_are_refused_and_valid_ones_still_answered(line: bytes) -> None:
    with serve_requests(RUN, "graph", DOUBLING):
        (run,) = [run for run in runs_here() if run.run == RUN]
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(f"\0{socket_name()}")
            client.sendall(line)
            client.shutdown(socket.SHUT_WR)
            assert "refused" in json.loads(client.makefile().readline())
        assert run.ask(Double(number=2), 10.0) == 4


def test_a_request_above_the_limit_is_refused() -> None:
    with serve_requests(RUN, "graph", Dispatcher("operator", {})):
        with socket.socket(socket.AF_UNIX) as client:
            client.connect(f"\0{socket_name()}")
            sent = 0
            with suppress(OSError):
                while sent < 16 * MAX_REQUEST:
                    sent += client.send(b"x" * 65536)
        assert sent < 4 * MAX_REQUEST
