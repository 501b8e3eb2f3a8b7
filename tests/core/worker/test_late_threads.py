"""Threads of stages that hold up the end of a process are named."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import followspot as fs
from followspot.context import Context
from followspot.worker.reporting import late_threads as module
from followspot.worker.reporting.late_threads import late_threads


class Count(fs.Message):
    """A number."""

    number: int


class Once(fs.Stage):
    """One number."""

    def process(self) -> fs.Source[Count]:
        yield fs.at(0, Count(1))


class Device(fs.Stage):
    """Reads in a thread, which `close` forgets."""

    class Params(fs.StageParams):
        daemon: bool = fs.Field(False, description="whether the process ends without waiting for it")

    params: Params
    over = threading.Event()

    def setup(self) -> None:
        threading.Thread(target=self.read, name="my reader", daemon=self.params.daemon).start()

    def read(self) -> None:
        self.over.wait()

    def process(self, count: Count) -> None:
        """Nothing."""


@pytest.fixture(autouse=True)
def over() -> Iterator[threading.Event]:
    Device.over.clear()
    yield Device.over
    Device.over.set()


def run(out: Path, *, daemon: bool) -> fs.Report:
    graph = fs.Graph("g")
    graph.add("device", Device, count=graph.add("once", Once), daemon=daemon)
    with fs.run(graph, out=out) as run:
        return run.wait()


def test_the_report_names_the_stage_the_thread_and_its_place(tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match='"my reader"'):
        (said,) = run(tmp_path, daemon=False).warnings
    assert said.startswith('device: its thread "my reader" goes on at ')
    assert f"{__file__}:" in said
    assert said.endswith("after close(): end it in close(), or start it with daemon=True")


def test_threads_that_hold_nothing_up_are_not_named(tmp_path: Path, over: threading.Event) -> None:
    assert not run(tmp_path, daemon=True).warnings
    over.set()
    assert not run(tmp_path, daemon=False).warnings


def test_what_no_stage_has_started_is_named_in_a_process_of_its_own_alone(over: threading.Event) -> None:
    before = threading.enumerate()
    threading.Thread(target=over.wait, name="of a library").start()
    stages = [("once", Once(Context("once")))]
    assert list(late_threads(before, stages, own_process=False)) == []
    ((stage, text),) = late_threads(before, stages, own_process=True)
    assert stage == ""
    assert text.startswith('its thread "of a library" goes on after close()')


def test_a_thread_of_a_pool_is_named_while_it_works_and_not_waited_for_without_work(
    over: threading.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The end of the process ends one without work."""
    before = threading.enumerate()
    monkeypatch.setattr(module, "_PATIENCE", 0.0)
    with ThreadPoolExecutor(1, "my pool") as pool:
        work = pool.submit(over.wait)
        found = list(late_threads(before, [], own_process=True))
        over.set()
        work.result()
        monkeypatch.setattr(module, "_PATIENCE", math.inf)
        without_work = list(late_threads(before, [], own_process=True))
    ((_, text),) = found
    assert text.startswith('its thread "my pool_0" goes on after close()')
    assert without_work == []


SCRIPT = """
import threading
from pathlib import Path
import followspot as fs

class Note(fs.Message):
    value: int

class Once(fs.Stage):
    def process(self) -> fs.Source[Note]:
        yield fs.at(0, Note(1))

class Device(fs.Stage):
    def setup(self) -> None:
        threading.Thread(target=self.read, name="of the stage", daemon=False).start()

    def read(self) -> None:
        over.wait()

    def process(self, note: Note) -> None:
        begun.set()
        going.wait()

def own() -> None:
    going.set()
    over.wait()

begun, going, over = threading.Event(), threading.Event(), threading.Event()
graph = fs.Graph("g")
graph.add("device", Device, note=graph.add("once", Once))
with fs.run(graph, out=Path("out")) as run:
    begun.wait()
    threading.Thread(target=own, name="of the script").start()
    print(*run.wait().warnings)
over.set()
"""


def test_threads_that_a_script_starts_during_its_run_are_its_own(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    words = [sys.executable, "script.py"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith('device: its thread "of the stage" goes on at ')
    assert "of the script" not in done.stdout
