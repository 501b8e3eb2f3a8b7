"""A run whose only worker is a thread of this process."""

from __future__ import annotations

from pathlib import Path

from followspot.graph.compile import compile_graph
from followspot.operator.launch import local_run
from followspot.worker.wiring import RunOptions

STUBBORN = """
from followspot import Message, Source, Stage, at

class Beat(Message):
    value: int

class Stubborn(Stage):
    '''Cannot be built.'''

    def __init__(self, *args, **params):
        raise ValueError("the model is missing")

    def process(self) -> Source[Beat]:
        yield at(0, Beat(1))
"""


def test_a_stage_that_cannot_be_built_is_named(tmp_path: Path) -> None:
    (tmp_path / "drum.py").write_text(STUBBORN)
    graph = tmp_path / "graph.yaml"
    graph.write_text("graph: g\nstages: {beat: {uses: drum.stubborn}}\n")
    plan = compile_graph(graph, plugin_files=[tmp_path / "drum.py"])
    report = local_run(plan, RunOptions(tmp_path)).execute()
    assert "stage beat failed: ValueError: the model is missing" in report.errors[0]


def test_a_run_that_is_stopped_before_it_begins_says_that_it_did_not(tmp_path: Path) -> None:
    plan = compile_graph(Path(__file__).parents[3] / "graphs" / "glowballs.yaml")
    run = local_run(plan, RunOptions(tmp_path, 3))
    run.stop()
    report = run.execute()
    assert report.stopped
    assert not report.begun
    assert report.silences == ()
