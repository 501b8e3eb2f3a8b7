"""The graphs and placements that come with followspot are without mistakes."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.graph.compile import compile_graph

GRAPHS = Path(__file__).parents[3] / "graphs"


@pytest.mark.parametrize("placement", [None, "camera", "stage", GRAPHS / "placements" / "two.yaml"])
def test_the_tracker_of_glowing_balls_compiles_with_every_placement(placement: str | Path | None) -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml", placement=placement)
    color = [stage.camera for stage in plan.stages if stage.group == "color"]
    assert color == ["cam0", "cam2", "cam5"]
    assert {stage.group for stage in plan.stages} == {
        "camera",
        "color",
        "infrared",
        "verify",
        "triangulate",
        "fuse",
        "bridge",
        "track",
        "save",
    }
    assert sum(edge.delay for edge in plan.edges) == 10


def test_half_of_the_cameras_move_to_another_worker() -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml", placement=GRAPHS / "placements" / "two.yaml")
    left = {stage.camera for stage in plan.stages if stage.worker == "left"}
    assert left == {"cam0", "cam1", "cam2"}
    assert {edge.kind for edge in plan.edges} == {"reference", "ring"}


def test_another_fusion_is_one_word_on_the_command_line() -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml", overrides=["fuse.uses=balls.mean"])
    assert next(stage for stage in plan.stages if stage.name == "fuse").uses == "balls.mean"
