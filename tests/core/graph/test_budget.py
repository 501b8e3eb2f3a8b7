"""Budgets of paths, as a placement file writes them."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import HERE, TOY, write

from followspot.errors import InputError
from followspot.graph.budget import Budget
from followspot.graph.compile import compile_graph
from followspot.graph.drawing.text import text
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data


def planned(folder: Path, said: str) -> Plan:
    graph = write(folder, room=HERE)
    (folder / "placement.yaml").write_text(said)
    return compile_graph(graph, placement=folder / "placement.yaml", plugin_files=[TOY])


@pytest.mark.parametrize(("said", "limit"), [("20 ms", 0.02), ("1.5s", 1.5), ("500us", 5e-4), ("60 s", 60.0)])
def test_a_plan_has_the_budgets_of_its_placement(tmp_path: Path, said: str, limit: float) -> None:
    plan = planned(tmp_path, f"by: camera\nbudget:\n  camera -> track: {said}\n")
    assert plan.budgets == (Budget("camera", "track", pytest.approx(limit)),)
    assert f"camera -> track: {1e3 * limit:g} ms" in text(plan)
    assert plan_from_data(plan_to_data(plan)).budgets == plan.budgets
    assert {worker.name for worker in plan.workers} == {"cam0", "cam1", "main"}


def test_a_placement_may_have_budgets_alone(tmp_path: Path) -> None:
    plan = planned(tmp_path, "budget: {camera->detect: 5 ms, camera -> save: 20 ms}\n")
    assert [budget.name for budget in plan.budgets] == ["camera -> detect", "camera -> save"]
    assert len(plan.workers) == 1


@pytest.mark.parametrize(
    ("path", "time", "told"),
    [
        ("camera -> trakc", "20 ms", '1:10: there is no stage "trakc"'),
        ("kamera -> track", "20 ms", '1:10: there is no stage "kamera"'),
        ("camera", "20 ms", '1:10: "camera" is no path'),
        ("detect -> track", "20 ms", '1:10: a budget begins at a source, and "detect" is none'),
        ("camera -> camera", "20 ms", "1:10: no path leads from camera to camera"),
        ("camera -> track", "20", "1:27: a budget is a time, not 20"),
        ("camera -> track", "20 h", '1:27: a budget is a time, not "20 h"'),
        ("camera -> track", "0 ms", "1:27: a budget cannot be 0 ms"),
        ("camera -> track", "61 s", "1:27: a budget cannot be 61 s"),
    ],
)
def test_a_mistake_has_its_place(tmp_path: Path, path: str, time: str, told: str) -> None:
    with pytest.raises(InputError) as error:
        planned(tmp_path, f"budget: {{{path}: {time}}}\n")
    assert f"placement.yaml:{told}" in str(error.value)
