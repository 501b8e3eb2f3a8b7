"""Checkpoints that outlive an agent: which of them its successor gives to the stages."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.host.checkpoint_file import CheckpointFile

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


def planned(folder: Path, uses: str) -> Plan:
    graph = folder / "g.yaml"
    lines = "a: {uses: ticks.live}", f"b: {{uses: {uses}, in: {{number: a}}}}"
    graph.write_text("graph: g\nstages:\n" + "".join(f"  {line}\n" for line in lines))
    return compile_graph(graph, plugin_files=[TICKS])


def test_a_stage_of_the_same_class_gets_the_newest_checkpoint(tmp_path: Path) -> None:
    path, plan = tmp_path / ".checkpoints", planned(tmp_path, "ticks.tally")
    assert CheckpointFile(path).left(plan) == {}
    file = CheckpointFile(path)
    file.keep({}, plan, 1000.0)
    assert not path.exists()
    for now in (1000.0, 1000.5, 1002.0):
        file.keep({"b": {"count": now}, "gone": 1}, plan, now)
    assert CheckpointFile(path).left(plan) == {"b": {"count": 1002.0}}
    assert CheckpointFile(path).left(planned(tmp_path, "ticks.add")) == {}


@pytest.mark.parametrize("text", ["", '{"b": ["ticks.tal', "[]", '{"b": 3}', '{"b": [1]}'])
def test_a_file_that_is_not_whole_or_of_another_version_is_passed_over(tmp_path: Path, text: str) -> None:
    (tmp_path / ".checkpoints").write_text(text)
    assert CheckpointFile(tmp_path / ".checkpoints").left(planned(tmp_path, "ticks.tally")) == {}


def test_a_full_disk_does_not_end_the_run(tmp_path: Path) -> None:
    CheckpointFile(tmp_path / "gone" / ".checkpoints").keep({"b": 1}, planned(tmp_path, "ticks.tally"), 1.0)
