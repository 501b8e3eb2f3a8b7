"""A worker process whose stage leaves a thread ends by itself: its host has others to attend to."""

from __future__ import annotations

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
