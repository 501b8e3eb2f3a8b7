"""The end of a worker's process: by itself after its report, else by a kill."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys

import pytest

from followspot.control.stage_status import StageStatus
from followspot.control.worker_report import WorkerReport
from followspot.host.forked_worker import EXIT_CODE_UNKNOWN
from followspot.host.worker_process import WorkerProcess

NO_SERVER = "the process that forks workers died or was suspended"


def worker(seconds: float) -> WorkerProcess:
    """A worker whose process exits after so many seconds."""

    def start(_name: str, _end: socket.socket) -> subprocess.Popen[bytes]:
        return subprocess.Popen([sys.executable, "-c", f"import time; time.sleep({seconds})"])

    return WorkerProcess("left", 0, start)


def test_a_new_worker_has_no_counts() -> None:
    left = worker(600.0)
    try:
        assert (left.phase, left.fired, left.time, left.expected) == ("starting", 0, -1, None)
        assert left.busy
    finally:
        left.end()


def test_a_worker_that_waited_for_the_others_in_silence_does_not_count_as_hanging_when_it_begins() -> None:
    left = worker(600.0)
    try:
        left.phase, left.heard = "ready", left.heard - 3600.0
        left.begin()
        assert left.phase == "running"
        assert left.status().age_s < 1800.0
    finally:
        left.end()


@pytest.mark.parametrize(("reported", "code"), [(True, 0), (False, -signal.SIGKILL)])
def test_a_worker_that_has_reported_exits_by_itself_and_any_other_is_killed(
    reported: bool, code: int
) -> None:
    left = worker(0.5 if reported else 600.0)
    left.report = WorkerReport("left", 0) if reported else None
    left.end()
    assert left.process.poll() == code
    assert not left.open


class Ended:
    """A process that has ended."""

    def __init__(self, pid: int, code: int) -> None:
        self.pid = pid
        self._code = code

    def poll(self) -> int:
        return self._code

    def wait(self, timeout: float | None = None) -> int:
        return self._code

    def kill(self) -> None:
        pass


@pytest.mark.parametrize(
    ("pid", "code", "reason"),
    [
        (7, -signal.SIGKILL, "worker left (process 7) died: killed by SIGKILL"),
        (7, 3, "worker left (process 7) died: exit code 3"),
        (7, EXIT_CODE_UNKNOWN, f"worker left (process 7) died: exit code unknown, as {NO_SERVER}"),
        (0, EXIT_CODE_UNKNOWN, f"worker left was not started: {NO_SERVER}"),
    ],
)
def test_why_a_worker_is_gone_is_said_as_far_as_it_is_known(pid: int, code: int, reason: str) -> None:
    left = WorkerProcess("left", 0, lambda _name, _end: Ended(pid, code))
    assert left.exit_reason() == reason
    left.end()


def test_a_worker_in_a_thread_does_not_keep_its_process_alive() -> None:
    program = (
        "import socket\n"
        "from followspot.host.worker_thread import WorkerThread\n"
        "ours, theirs = socket.socketpair()\n"
        "worker = WorkerThread('left', theirs)\n"
        "print(worker.poll())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout == "None\n"


def test_a_worker_that_is_killed_names_the_stage_that_was_at_work() -> None:
    left = WorkerProcess("left", 0, lambda _name, _end: Ended(7, -signal.SIGKILL))
    assert left.at_work() == ""
    left.stages = (StageStatus("a", "waiting"), StageStatus("b", "processing"))
    left.kill(f"it did not end{left.at_work()}")
    assert left.exit_reason().endswith("because it did not end, in which stage b was at work")
    left.end()
