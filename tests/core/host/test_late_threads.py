"""A worker process whose stage leaves a thread ends by itself: its host waits for others, or has ended."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from followspot.graph.compile import compile_graph
from followspot.host.worker_process import WorkerProcess
from followspot.operator.launch import run_plan
from followspot.worker.wiring import RunOptions

PLUGIN = '''
import threading
import followspot as fs

class Count(fs.Message):
    """A number."""
    number: int

class Once(fs.Stage):
    """One number."""
    def process(self) -> fs.Source[Count]:
        yield fs.at(0, Count(1))

class Device(fs.Stage):
    """Reads in a thread, which `close` forgets."""
    def setup(self) -> None:
        threading.Thread(target=self.read, name="my reader").start()

    def read(self) -> None:
        threading.Event().wait()

    def process(self, count: Count) -> None:
        """Nothing."""
'''

WITHOUT_HOST = """
import socket, sys, threading
from followspot.control.pipe import ChannelClosed
from followspot.worker import main

class Worker(main.WorkerMain):
    def live(self):
        threading.Thread(target=threading.Event().wait).start()
        self.has_late_threads = True
        raise ChannelClosed

main.WorkerMain = Worker
sys.exit(main.run_worker(socket.socketpair()[0].detach()))
"""


def test_it_ends_with_a_warning_and_is_not_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plugin, graph = tmp_path / "leaves.py", tmp_path / "g.yaml"
    plugin.write_text(PLUGIN)
    graph.write_text(
        "graph: g\nstages:\n  once: {uses: leaves.once}\n  device: {uses: leaves.device, in: {count: once}}\n"
    )
    codes: dict[str, int | None] = {}

    def end(worker: WorkerProcess) -> None:
        codes[worker.name] = worker.process.wait(timeout=60.0)
        before(worker)

    before = WorkerProcess.end
    monkeypatch.setattr(WorkerProcess, "end", end)
    plan = compile_graph(graph, placement="stage", plugin_files=[plugin])
    report = run_plan(plan, RunOptions(tmp_path / "out"))
    assert report.ok, report.errors
    (told,) = report.warnings
    assert 'device: its thread "my reader" goes on at ' in told
    assert set(codes.values()) == {0}
    assert len(codes) == 2


def test_it_ends_if_its_host_has_ended() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT_HOST], timeout=60, check=False)
    assert done.returncode == 1
