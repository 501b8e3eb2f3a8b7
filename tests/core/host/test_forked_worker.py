"""Workers that a fork server forks: their exit codes, and what befalls them when the server dies."""

from __future__ import annotations

import os
import signal
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from tests.core.plugins.packages import install
from tests.integration.running import alive, children, command_of, wait_until

import followspot as fs
from followspot.host.forked_worker import EXIT_CODE_UNKNOWN, ForkedWorker, ForkServerProcess
from followspot.host.worker_starts import WorkerStarts
from followspot.plugins.catalogue import GROUP

PATIENCE = 60.0
TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


@contextmanager
def forked(server: ForkServerProcess) -> Iterator[tuple[ForkedWorker, socket.socket]]:
    """A worker that waits for its plan, and the host's end of its control channel."""
    channel, end = socket.socketpair()
    with channel:
        with end:
            worker = server.start(end)
        yield worker, channel


def servers() -> list[int]:
    return [pid for pid in children(os.getpid()) if "fork_server" in command_of(pid)]


def test_the_exit_codes_of_workers_reach_the_host() -> None:
    with (
        closing(ForkServerProcess([])) as server,
        forked(server) as (first, channel),
        forked(server) as (second, _),
    ):
        assert first.poll() is None
        channel.close()
        assert first.wait(PATIENCE) == first.poll() == 1
        assert second.poll() is None, "each worker has its own channel"
        second.kill()
        assert second.wait(PATIENCE) == -signal.SIGKILL
        second.kill()  # it is gone, and another process may have its number
    assert not servers()


def test_a_worker_outlives_its_server_and_the_next_gets_a_new_one() -> None:
    with closing(ForkServerProcess([])) as server, forked(server) as (first, _):
        assert alive(first.pid)
        (pid,) = servers()
        os.kill(pid, signal.SIGKILL)
        assert wait_until(lambda: not alive(pid))
        assert first.poll() is None
        with forked(server) as (second, _):
            assert servers() != [pid]
            second.kill()
            assert second.wait(PATIENCE) == -signal.SIGKILL
        first.kill()
        assert first.wait(PATIENCE) == EXIT_CODE_UNKNOWN


def suspend(pid: int) -> None:
    os.kill(pid, signal.SIGSTOP)
    assert wait_until(lambda: Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "T")


def test_a_suspended_server_does_not_hide_the_death_of_a_worker_nor_keep_the_next_from_starting() -> None:
    with closing(ForkServerProcess([])) as server, forked(server) as (first, _), forked(server) as (other, _):
        assert alive(first.pid)
        assert alive(other.pid)
        (pid,) = servers()
        suspend(pid)
        os.kill(first.pid, signal.SIGKILL)
        assert wait_until(lambda: first.poll() is not None), "the host notices"
        assert first.poll() == EXIT_CODE_UNKNOWN
        assert other.poll() is None, "a worker outlives its server"
        with forked(server) as (second, _):
            assert alive(second.pid)
            assert servers() != [pid]
            suspend(servers()[0])
            other.kill()
            assert other.wait(PATIENCE) == EXIT_CODE_UNKNOWN
            second.kill()
            second.wait(PATIENCE)
        with forked(server) as (third, _):
            assert alive(third.pid)
            third.kill()
            assert third.wait(PATIENCE) == -signal.SIGKILL
            suspend(servers()[0])
    assert not servers(), "nor does it keep the host from ending"


@pytest.fixture
def starts_a_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a stage whose module starts a thread."""
    module = "import threading, time\nthreading.Thread(target=time.sleep, args=(600,), daemon=True).start()\n"
    entries = f"[{GROUP}]\nbusy.stage = busy:Stage\n"
    install(tmp_path, "busy", entries, modules={"busy.py": module})
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return "busy.stage"


def test_a_worker_imports_for_itself_if_imports_start_threads(starts_a_thread: str) -> None:
    with closing(ForkServerProcess([starts_a_thread])) as server, forked(server) as (worker, channel):
        assert wait_until(lambda: "followspot.worker.main" in command_of(worker.pid))
        channel.close()
        assert worker.wait(PATIENCE) == 1


def test_a_worker_that_its_server_could_not_fork_any_more_is_gone() -> None:
    with closing(ForkServerProcess([])) as server, forked(server) as (worker, _):
        assert wait_until(servers)
        os.kill(servers()[0], signal.SIGKILL)
        assert worker.wait(PATIENCE) == EXIT_CODE_UNKNOWN
        worker.kill()


def test_only_stages_of_this_distribution_are_imported_before_a_fork(starts_a_thread: str) -> None:
    channel, end = socket.socketpair()
    with closing(WorkerStarts(["left", "right"], (), [starts_a_thread, "sinks.csv"])) as starts:
        with channel, end:
            worker = starts.start("left", end)
        assert wait_until(servers)
        command = command_of(servers()[0])
        assert "sinks.csv" in command
        assert "busy.stage" not in command
        assert worker.wait(PATIENCE) == 1


def test_a_host_that_starts_one_worker_has_no_server() -> None:
    channel, end = socket.socketpair()
    with closing(WorkerStarts(["left", "right"], ["right"], [])) as starts:
        with channel, end:
            worker = starts.start("left", end)
        assert not servers()
        assert worker.wait(PATIENCE) == 1


FAMILY = """
import os
from pathlib import Path
import numpy as np
from followspot import Field, Message, Stage, StageParams

class Note(Stage):
    \"\"\"Writes down its process, the parent of that, and a random number.\"\"\"

    class Params(StageParams):
        path: str = Field("", description="file")

    def setup(self) -> None:
        Path(self.params.path).write_text(f"{os.getpid()} {os.getppid()} {np.random.random()}")

    def process(self, number: Message) -> None:
        return
"""


def test_workers_of_a_run_have_one_parent_and_draw_different_random_numbers(tmp_path: Path) -> None:
    (tmp_path / "family.py").write_text(FAMILY)
    (tmp_path / "graph.yaml").write_text(
        "graph: family\nstages:\n  a: {uses: ticks.count, with: {count: 3}}\n"
        + "".join(
            f"  {name}: {{uses: family.note, in: {{number: a}}, with: {{path: {tmp_path / name}}}}}\n"
            for name in ("b", "c")
        )
    )
    plugins = [TICKS, tmp_path / "family.py"]
    with fs.run(
        tmp_path / "graph.yaml", plugin_files=plugins, out=tmp_path / "out", placement="stage"
    ) as run:
        run.wait()
    (first, parent, number), (second, same, other) = ((tmp_path / x).read_text().split() for x in "bc")
    assert parent == same != str(os.getpid())
    assert first != second
    assert number != other
