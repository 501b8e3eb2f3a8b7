"""A tap sends messages over Zenoh only if its worker is on another host than the operator."""

from __future__ import annotations

import queue
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from tests.core.worker.solo import Solo

from followspot.control.tapping import Tapping
from followspot.graph.compile import compile_graph
from followspot.plugins.registry import load_stage
from followspot.transport.zenoh.edge import open_session
from followspot.worker.taps.worker_taps import WorkerTaps
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
GRAPH = """
graph: g
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.write, in: {number: a}}
"""
LOOK = """
import queue
from typing import ClassVar

from followspot import Message, Stage


class Look(Stage):
    tap = True
    posts: ClassVar[queue.Queue] = queue.Queue()

    def setup(self) -> None:
        self.posts.put(self.context.post)

    def process(self, message: Message) -> None: ...
"""


@pytest.fixture(scope="module")
def select(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plugins") / "look.py"
    path.write_text(LOOK)
    return path


@pytest.mark.parametrize(
    ("host", "joined", "posts"), [("", True, False), ("left", False, False), ("left", True, True)]
)
def test_a_tap_uses_zenoh_only_from_a_worker_on_another_host(
    tmp_path: Path, select: Path, host: str, joined: bool, posts: bool
) -> None:
    (tmp_path / "g.yaml").write_text(GRAPH)
    plan = compile_graph(tmp_path / "g.yaml", plugin_files=[TICKS, select])
    (worker,) = plan.workers
    plan = replace(plan, workers=(replace(worker, host=host),))
    found: queue.Queue[object] = sys.modules[load_stage("look.look").__module__].Look.posts
    warnings: list[str] = []
    with open_session() as session:
        edge_factory = WorkerEdgeFactory(plan, {}, {}, session if joined else None, "run")
        taps = WorkerTaps(worker.name, Solo(plan, tmp_path).scheduler, edge_factory, warnings.append)
        taps.place([Tapping("a.out", "look.look", {})])
        assert (found.get(timeout=60) is not None) is posts
        taps.close()
    assert warnings == []
