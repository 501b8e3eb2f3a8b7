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
        "associate",
        "fuse",
        "bridge",
        "track",
        "save",
    }
    assert sum(edge.delay for edge in plan.edges) == 11


def test_half_of_the_cameras_move_to_another_worker() -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml", placement=GRAPHS / "placements" / "two.yaml")
    left = {stage.camera for stage in plan.stages if stage.worker == "left"}
    assert left == {"cam0", "cam1", "cam2"}
    assert {edge.kind for edge in plan.edges} == {"reference", "ring"}


def test_another_fusion_is_one_word_on_the_command_line() -> None:
    plan = compile_graph(GRAPHS / "glowballs.yaml", overrides=["fuse.uses=balls.mean"])
    assert next(stage for stage in plan.stages if stage.name == "fuse").uses == "balls.mean"


def test_balls_that_are_covered_are_weighed_over_all_views() -> None:
    plan = compile_graph(GRAPHS / "covered.yaml")
    assert {s.name: s.uses for s in plan.stages}["fuse"] == "balls.bundle"
    assert [e.name for e in plan.edges if e.name.startswith("associate")] == [
        "associate.candidates -> fuse.candidates",
        "associate.existence -> bridge.existence",
    ]


def test_balls_and_people_share_the_cameras_of_a_show() -> None:
    plan = compile_graph(GRAPHS / "show.yaml")
    assert [stage.name for stage in plan.stages if "camera" in stage.name] == [
        "camera/left",
        "camera/right",
        "camera/front",
    ]
    readers = {edge.to_stage for edge in plan.edges if edge.from_stage == "camera/left"}
    assert readers == {
        "balls/color/left",
        "people/sampler/left",
        "people/gradients/left",
        "people/pose/left",
    }
    assert plan.warnings == ()


def test_a_show_leaves_infrared_cameras_to_the_balls() -> None:
    plan = compile_graph(GRAPHS / "show.yaml", room=GRAPHS / "rooms" / "simulated.yaml")
    assert {s.camera for s in plan.stages if s.group == "people/pose"} == {"cam0", "cam2", "cam5"}
    assert {s.camera for s in plan.stages if s.group == "balls/infrared"} == {"cam1", "cam3", "cam4"}


def test_the_room_tells_where_balls_without_colours_are_at_the_start() -> None:
    own = compile_graph(GRAPHS / "depth.yaml")
    assert set(next(s for s in own.stages if s.name == "track").params["marks"]) == set(own.room.targets)
    other = compile_graph(GRAPHS / "depth.yaml", room=GRAPHS / "rooms" / "simulated_mixed.yaml")
    assert next(s for s in other.stages if s.name == "track").params["marks"] == {}
