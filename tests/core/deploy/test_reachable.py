"""Runs are found and asked by other processes of their user; what they cannot read is refused."""

from __future__ import annotations

import json
import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from followspot.deploy.reachable import MAX_REQUEST, reachable, runs_here
from followspot.errors import FollowspotError

RUN = "feedc0de" * 4


def double(number: int) -> int:
    if number < 0:
        raise FollowspotError("no negative numbers")
    return 2 * number


def this() -> list[str]:
    return [run.run for run in runs_here() if run.run == RUN]


def test_a_run_is_found_answers_and_is_gone_without_a_trace() -> None:
    with reachable(RUN, "graph", {"double": double}):
        (run,) = [run for run in runs_here() if run.run == RUN]
        assert run.graph == "graph"
        assert run.ask("double", number=21) == 42
        assert runs_here(str(os.getpid())) == runs_here(RUN[:8]) == [run]
        with pytest.raises(FollowspotError, match="no negative numbers"):
            run.ask("double", number=-1)
        with pytest.raises(FollowspotError, match="halve"):
            run.ask("halve", number=1)
        with pytest.raises(FollowspotError, match="unexpected keyword"):
            run.ask("double", numbers=1)
    assert this() == []
    assert RUN[:16] not in Path("/proc/net/unix").read_text()
    with pytest.raises(FollowspotError, match="does not answer"):
        run.ask("double", number=1)


def test_what_was_asked_is_answered_before_the_end_and_who_has_not_asked_is_refused() -> None:
    asked, returned, answers = threading.Event(), threading.Event(), []

    def slow() -> str:
        asked.set()
        time.sleep(0.2)
        returned.set()
        return "done"

    with socket.socket(socket.AF_UNIX) as silent:
        with reachable(RUN, "graph", {"slow": slow}):
            (run,) = [run for run in runs_here() if run.run == RUN]
            silent.connect(f"\0{run.socket}")
            asking = threading.Thread(target=lambda: answers.append(run.ask("slow")))
            asking.start()
            assert asked.wait(10.0)
        assert returned.is_set()
        assert "refused" in json.loads(silent.makefile().readline())
    asking.join()
    assert answers == ["done"]


@pytest.mark.parametrize(
    "line", [b"", b"\n", b"[]\n", b"7\n", b'{"verb": []}\n', b"\xff\n", b"[" * 100_000 + b"\n"]
)
def test_what_is_no_request_is_refused_and_others_are_still_answered(line: bytes) -> None:
    with reachable(RUN, "graph", {"double": double}):
        (run,) = [run for run in runs_here() if run.run == RUN]
        with socket.socket(socket.AF_UNIX) as asker:
            asker.connect(f"\0{run.socket}")
            asker.sendall(line)
            asker.shutdown(socket.SHUT_WR)
            assert "refused" in json.loads(asker.makefile().readline())
        assert run.ask("double", number=2) == 4


def test_a_request_without_end_is_cut_off() -> None:
    with reachable(RUN, "graph", {}):
        (run,) = [run for run in runs_here() if run.run == RUN]
        with socket.socket(socket.AF_UNIX) as asker:
            asker.connect(f"\0{run.socket}")
            sent = 0
            with suppress(OSError):
                while sent < 16 * MAX_REQUEST:
                    sent += asker.send(b"x" * 65536)
        assert sent < 4 * MAX_REQUEST
