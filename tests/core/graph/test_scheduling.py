"""Cores, priority and real time of workers, as a placement file writes them."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import HERE, TOY, write

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.drawing.text import text
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.graph.scheduling import Scheduling


def planned(folder: Path, said: str) -> Plan:
    graph = write(folder, room=HERE)
    (folder / "placement.yaml").write_text(f"workers:\n  fast: {{stages: [track], {said}}}\n")
    return compile_graph(graph, placement=folder / "placement.yaml", plugin_files=[TOY])


@pytest.mark.parametrize(
    ("said", "expected", "shown"),
    [
        ("cores: [1, 0]", Scheduling((1, 0)), "worker fast, cores 1 0"),
        ("nice: -5", Scheduling(nice=-5), "worker fast, nice -5"),
        ("cores: [3], realtime: 20", Scheduling((3,), 0, 20), "worker fast, cores 3, real-time 20"),
        ("nice: 0", Scheduling(), "worker fast\n"),
    ],
)
def test_a_worker_has_what_its_placement_says(
    tmp_path: Path, said: str, expected: Scheduling, shown: str
) -> None:
    plan = planned(tmp_path, said)
    assert plan.scheduling_of("fast") == expected
    assert plan.scheduling_of("main") == Scheduling()
    assert shown in text(plan)
    assert plan_from_data(plan_to_data(plan)).workers == plan.workers


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("cores: 1", "2:34: cores is a list of numbers, not 1"),
        ("cores: []", "2:34: cores is a list of numbers, not an empty list"),
        ("cores: [0, x]", '2:38: a core cannot be "x"'),
        ("cores: [0, -1]", "2:38: a core cannot be -1"),
        ("cores: [true]", "2:35: a core cannot be true"),
        ("cores: [2, 2]", "2:38: core 2 is named twice"),
        ("nice: 20", "2:33: nice cannot be 20"),
        ("realtime: 0", "2:37: realtime cannot be 0"),
        ("nice: 5, realtime: 5", '2:27: worker "fast" has nice and realtime'),
        ("priority: 5", '2:27: worker "fast" has no key "priority"'),
    ],
)
def test_a_mistake_has_its_place(tmp_path: Path, said: str, told: str) -> None:
    with pytest.raises(InputError) as error:
        planned(tmp_path, said)
    assert f"placement.yaml:{told}" in str(error.value)
