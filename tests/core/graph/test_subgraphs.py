"""A graph file as a stage of another: parameters, inputs, outputs, cameras, several levels."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, edges, names, planned, stage
from tests.core.graph.subgraph_files import EACH, MIDDLE, NESTED, SHARED, TWO, ZONED


def test_a_file_that_is_used_twice_is_two_sets_of_stages(tmp_path: Path) -> None:
    plan = planned(tmp_path, TWO)
    assert [name for name in names(plan) if name.startswith("left")] == [
        "left/camera/cam0",
        "left/detect/cam0",
        "left/pair",
        "left/extra",
        "left/track",
    ]
    assert {s.camera for s in plan.stages if s.name.startswith("right")} == {"cam1", None}
    assert stage(plan, "left/detect/cam0").params["level"] == 0.25
    assert stage(plan, "right/detect/cam1").params["level"] == 0.5
    assert stage(plan, "left/detect/cam0").group == "left/detect"
    assert "left/track.tracks -> save.tracks" in edges(plan)
    assert "left/track.forecast -> left/detect/cam0.forecast delay 1" in edges(plan)
    assert (plan.graph, plan.seed) == ("building", 0)


def test_an_input_takes_the_place_of_a_stage(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    assert "hall/camera/cam0" not in names(plan)
    assert "eyes/cam0.out -> hall/detect/cam0.frame" in edges(plan)
    assert "eyes/cam1.out -> hall/detect/cam1.frame" in edges(plan)


def test_one_input_feeds_several_ports_camera_by_camera(tmp_path: Path) -> None:
    twice = TRACKER.replace("frames: camera", "frames: [camera, second.frame]").replace(
        "  pair:", "  second: {uses: toy.detect, each: cameras}\n  pair:"
    )
    plan = planned(tmp_path, SHARED, tracker=twice)
    assert [edge for edge in edges(plan) if edge.startswith("eyes/cam1")] == [
        "eyes/cam1.out -> hall/detect/cam1.frame",
        "eyes/cam1.out -> hall/second/cam1.frame",
    ]


def test_an_input_of_a_port_replaces_what_the_file_feeds_it(tmp_path: Path) -> None:
    hinted = TRACKER.replace("in: {blobs: pair}}", "in: {blobs: pair, hint: pair}}")
    main = SHARED.replace("{frames: eyes}", "{frames: eyes, hint: {from: hall.tracks, delay: 2, depth: 5}}")
    plan = planned(tmp_path, main, tracker=hinted)
    found = [edge for edge in plan.edges if edge.to_port == "hint"]
    assert [(e.from_stage, e.from_port, e.delay, e.depth) for e in found] == [("hall/track", "tracks", 2, 5)]


def test_options_of_both_ends_hold_and_delays_add_up(tmp_path: Path) -> None:
    held = TRACKER.replace("frame: camera", "frame: {from: camera, depth: 3, policy: drop_oldest}")
    plan = planned(tmp_path, SHARED.replace("frames: eyes", "frames: {from: eyes, depth: 2}"), tracker=held)
    (edge, _) = (edge for edge in plan.edges if edge.to_port == "frame")
    assert (edge.depth, edge.policy) == (2, "drop_oldest")
    late = TRACKER.replace("frame: camera", "frame: {from: camera, delay: 3}")
    plan = planned(tmp_path, SHARED.replace("frames: eyes", "frames: {from: eyes, delay: 2}"), tracker=late)
    assert [edge.delay for edge in plan.edges if edge.to_port == "frame"] == [5, 5]


def test_an_only_output_needs_no_name_and_may_be_a_stage_with_cameras(tmp_path: Path) -> None:
    one = TRACKER.replace(
        "{tracks: track.tracks, forecast: track.forecast, blobs: detect}", "{blobs: detect}"
    )
    main = SHARED.replace(
        "save: {uses: toy.save, in: {tracks: hall.tracks}}", "all: {uses: toy.pair, in: {blobs: hall}}"
    )
    plan = planned(tmp_path, main, tracker=one)
    assert [edge for edge in edges(plan) if edge.endswith("all.blobs")] == [
        "hall/detect/cam0.out -> all.blobs",
        "hall/detect/cam1.out -> all.blobs",
    ]


def test_levels_pass_on_parameters_inputs_outputs_and_cameras(tmp_path: Path) -> None:
    plan = planned(tmp_path, NESTED, middle=MIDDLE)
    assert names(plan) == [
        "eyes/cam0",
        "eyes/cam1",
        "hall/inner/detect/cam1",
        "hall/inner/pair",
        "hall/inner/extra",
        "hall/inner/track",
        "save",
    ]
    assert stage(plan, "hall/inner/detect/cam1").params["level"] == 0.75
    assert "eyes/cam1.out -> hall/inner/detect/cam1.frame" in edges(plan)
    assert "hall/inner/track.tracks -> save.tracks" in edges(plan)


def test_an_output_may_pass_an_input_through(tmp_path: Path) -> None:
    through = TRACKER.replace(", blobs: detect}", ", frames: camera}")
    main = SHARED + "  look: {uses: toy.detect, each: cameras, in: {frame: hall.frames}}\n"
    plan = planned(tmp_path, main, tracker=through)
    assert "eyes/cam0.out -> look/cam0.frame" in edges(plan)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("hall.level=0.125", 0.125),
        ("hall.with.level=0.125", 0.125),
        ("hall/inner.level=0.125", 0.125),
        ("hall/inner/detect.level=0.125", 0.125),
    ],
)
def test_an_option_reaches_every_level_and_wins(tmp_path: Path, option: str, value: float) -> None:
    plan = planned(tmp_path, NESTED, option, middle=MIDDLE)
    assert stage(plan, "hall/inner/detect/cam1").params["level"] == value


def test_the_innermost_option_wins_whatever_the_order(tmp_path: Path) -> None:
    options = ("hall/inner/detect.level=0.125", "hall.level=1")
    for given in (options, options[::-1]):
        plan = planned(tmp_path, NESTED, *given, middle=MIDDLE)
        assert stage(plan, "hall/inner/detect/cam1").params["level"] == 0.125


def test_an_option_may_name_another_file_and_other_cameras(tmp_path: Path) -> None:
    other = TRACKER.replace("toy.track,", "toy.track_again,")
    plan = planned(
        tmp_path,
        SHARED,
        f"hall.graph={tmp_path / 'other.yaml'}",
        "hall.cameras='cameras[name=cam0]'",
        other=other,
    )
    assert stage(plan, "hall/track").uses == "toy.track_again"
    assert "hall/detect/cam1" not in names(plan)


def test_an_overlay_changes_sub_graphs_and_stages_become_some(tmp_path: Path) -> None:
    top = "extends: two.yaml\nstages: {left: {with: {model: fast}}, right: null, other: null}\n"
    plan = planned(tmp_path, top, two=TWO)
    assert stage(plan, "left/track").params == {"model": "fast"}
    assert stage(plan, "left/detect/cam0").params["level"] == 0.25
    top = "extends: two.yaml\nstages: {save: null, other: {graph: tracker.yaml, in: {tracks: null}}}\n"
    assert "other/track" in names(planned(tmp_path, top, two=TWO))


def test_flat_names_in_a_file_mean_the_same_stages(tmp_path: Path) -> None:
    flat = """\
graph: flat
room: room.yaml
stages:
  hall/camera: {uses: room.source, each: cameras}
  hall/detect: {uses: toy.detect, each: cameras, in: {frame: hall/camera}}
  hall/pair: {uses: toy.pair, in: {blobs: hall/detect.out}}
"""
    plan = planned(tmp_path, flat, "hall/detect.level=0.125")
    assert names(plan)[-2:] == ["hall/detect/cam1", "hall/pair"]
    assert stage(plan, "hall/detect/cam1").params["level"] == 0.125


def test_an_inner_stage_can_be_read_by_its_full_name(tmp_path: Path) -> None:
    main = SHARED.replace("hall.tracks", "hall/track.tracks")
    assert "hall/track.tracks -> save.tracks" in edges(planned(tmp_path, main))


def test_a_stage_without_cameras_gets_those_of_its_sub_graph_only(tmp_path: Path) -> None:
    gathered = TRACKER.replace("frame: camera", "frame: {from: camera, depth: 3}").replace(
        "  pair:", "  all: {uses: toy.mosaic, in: {frames: camera}}\n  pair:"
    )
    main = SHARED.replace("in: {frames: eyes}", "cameras: 'cameras[name=cam1]', in: {frames: eyes}")
    found = edges(planned(tmp_path, main, tracker=gathered))
    assert [edge for edge in found if edge.startswith("eyes")] == [
        "eyes/cam1.out -> hall/detect/cam1.frame",
        "eyes/cam1.out -> hall/all.frames",
    ]


def test_a_sub_graph_fans_out_over_the_values_of_a_tag(tmp_path: Path) -> None:
    options = ("tracker.level=0.25", "tracker/hall/detect.level=0.75", "tracker/stage.model=slow")
    plan = planned(tmp_path, EACH, *options, room=ZONED)
    assert [s.name for s in plan.stages if "detect" in s.name] == [
        "tracker/hall/detect/cam0",
        "tracker/hall/detect/cam1",
        "tracker/stage/detect/cam1",
    ]
    assert stage(plan, "tracker/stage/detect/cam1").params["level"] == 0.25
    assert stage(plan, "tracker/hall/detect/cam1").params["level"] == 0.75
    models = [stage(plan, f"tracker/{zone}/track").params["model"] for zone in ("hall", "stage")]
    assert models == ["constant", "slow"]
    found = edges(plan)
    assert "tracker/hall/track.forecast -> tracker/hall/detect/cam1.forecast delay 1" in found
    assert "tracker/stage/track.tracks -> only.tracks" in found
    assert len([edge for edge in found if edge.endswith(" pair.blobs")]) == 3


def test_zones_that_overlap_share_what_an_input_gives_them(tmp_path: Path) -> None:
    main = EACH.replace("each: zones}", "each: zones, in: {frames: eyes}}")
    main += "  eyes: {uses: room.source, each: cameras}\n"
    found = edges(planned(tmp_path, main, room=ZONED))
    assert [edge for edge in found if edge.startswith("eyes/cam1")] == [
        "eyes/cam1.out -> tracker/hall/detect/cam1.frame",
        "eyes/cam1.out -> tracker/stage/detect/cam1.frame",
    ]


def test_the_ports_of_a_replaced_stage_are_those_of_the_stage_in_its_place(tmp_path: Path) -> None:
    halves = TRACKER.replace("hint: extra.hint", "halves: split").replace(
        "  extra: {uses: toy.any, in: {blobs: pair}}",
        "  split: {uses: toy.split, in: {blobs: pair}}\n"
        "  extra: {uses: toy.any, in: {blobs: split.right, hint: split.left}}",
    )
    main = SHARED.replace("frames: eyes", "frames: eyes, halves: other")
    main += "  other: {uses: toy.split, in: {blobs: {from: hall/pair}}}\n"
    found = [edge for edge in edges(planned(tmp_path, main, tracker=halves)) if edge.startswith("other")]
    assert found == ["other.right -> hall/extra.blobs", "other.left -> hall/extra.hint"]


EYE = """\
graph: eye
inputs: {frames: camera}
outputs: {blobs: detect}
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}
"""


@pytest.mark.parametrize("cameras", ["cameras", "cameras[name=cam1]"])
def test_sub_graphs_of_each_camera_are_connected_camera_by_camera(tmp_path: Path, cameras: str) -> None:
    (tmp_path / "eye.yaml").write_text(EYE)
    text = f"""\
graph: building
room: room.yaml
stages:
  first: {{uses: room.source, each: cameras}}
  eye: {{graph: eye.yaml, each: cameras, in: {{frames: first}}}}
  show: {{uses: toy.any, each: "{cameras}", in: {{blobs: eye}}}}
"""
    shown = [edge for edge in edges(planned(tmp_path, text)) if " -> show/" in edge]
    wanted = {name: f"eye/{name}/detect/{name}.out -> show/{name}.blobs" for name in ("cam0", "cam1")}
    assert shown == [wanted[name] for name in wanted if name in cameras or cameras == "cameras"]
