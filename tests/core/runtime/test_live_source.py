"""A live source at its end: what its thread gave last is sent, however the two threads take turns."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest

from followspot import Message
from followspot.deploy.local import LocalRun
from followspot.graph.compile import compile_graph
from followspot.plugins.registry import load_stage
from followspot.runtime.cell import StageError
from followspot.runtime.source import LiveCell
from followspot.runtime.wiring import RunOptions

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a: {uses: ticks.live}
  save: {uses: ticks.write, in: {number: a}}
"""


class Turn:
    """A lock: when the worker lets go of it, the source's thread goes on to its end before it does."""

    def __init__(self, cell: LiveCell) -> None:
        self.cell = cell
        self.lock = threading.Lock()
        self.go_on = threading.Event()

    def __enter__(self) -> None:
        self.lock.acquire()

    def __exit__(self, *_: object) -> None:
        self.lock.release()
        thread = self.cell._thread
        assert thread is not None
        if threading.current_thread() is not thread:
            self.go_on.set()
            thread.join()


@pytest.mark.parametrize("fails", [False, True])
def test_the_last_message_is_sent_before_the_end_is_seen(tmp_path: Path, fails: bool) -> None:
    (tmp_path / "g.yaml").write_text(GRAPH)
    run = LocalRun(compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS]), RunOptions(tmp_path))
    (cell,) = run.worker.live
    turn = Turn(cell)
    tick = sys.modules[load_stage("ticks.live").__module__].tick

    def process() -> Iterator[Message]:
        assert turn.go_on.wait(20)
        yield tick(7)
        if fails:
            raise RuntimeError("the camera fell down")

    cell.stage.process = process
    run.worker.setup()
    cell.start()
    cell._lock = turn  # type: ignore[assignment]
    assert not cell.pull()
    assert cell.pull()
    assert not cell.done
    with pytest.raises(StageError, match="fell down") if fails else nullcontext():
        cell.pull()
    assert cell.done != fails
    run.worker.close()
