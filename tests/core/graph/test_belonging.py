"""Stages of a sub-graph that fans out belong to its members, whether they fan out themselves or not."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import edges, planned, write
from tests.core.graph.files import TOY
from tests.core.graph.subgraph_files import DETECTORS, TAGGED, ZONE

from followspot.cli.main import main as command
from followspot.errors import InputError
from followspot.graph.compile import compile_graph

SHARED = TAGGED.replace("{zone: hall}", "{zone: [hall, stage]}")


def readers(folder: Path, stages: str, room: str = TAGGED) -> list[str]:
    """The edges of these stages, beside cameras and detectors."""
    plan = planned(folder, DETECTORS + stages, room=room, zone=ZONE)
    return [
        edge
        for edge in edges(plan)
        if "frame" not in edge and not edge.endswith(("own.blobs", "other.blobs"))
    ]


def test_an_input_takes_from_the_senders_of_its_member_alone(tmp_path: Path) -> None:
    assert readers(tmp_path, "  area: {graph: zone.yaml, each: zones, in: {blobs: detect}}\n") == [
        "detect/cam0.out -> area/hall/gather.blobs",
        "detect/cam1.out -> area/stage/gather.blobs",
    ]


def test_a_reader_for_each_member_takes_what_the_sub_graph_of_its_member_gives(tmp_path: Path) -> None:
    text = """\
  area: {graph: zone.yaml, each: zones, in: {blobs: detect}}
  show: {uses: toy.any, each: zones, in: {blobs: area.blobs}}
  each: {uses: toy.any, each: cameras, in: {blobs: area.blobs}}
  all:  {uses: toy.pair, in: {blobs: area.blobs}}
"""
    assert readers(tmp_path, text)[2:] == [
        "area/hall/gather.out -> show/hall.blobs",
        "area/stage/gather.out -> show/stage.blobs",
        "area/hall/gather.out -> each/cam0.blobs",
        "area/stage/gather.out -> each/cam1.blobs",
        "area/hall/gather.out -> all.blobs",
        "area/stage/gather.out -> all.blobs",
    ]


def test_sub_graphs_of_one_set_are_connected_member_by_member(tmp_path: Path) -> None:
    text = """\
  first: {graph: zone.yaml, each: cameras, in: {blobs: detect}}
  then:  {graph: zone.yaml, each: "cameras[kind=infrared]", in: {blobs: first.blobs}}
"""
    assert readers(tmp_path, text)[2:] == ["first/cam1/gather.out -> then/cam1/gather.blobs"]


def test_a_camera_of_two_zones_gives_each_what_its_own_sub_graph_has_found(tmp_path: Path) -> None:
    seen = """\
graph: seen
inputs:  {frames: camera}
outputs: {blobs: detect}
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}
"""
    text = """\
graph: main
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  area: {graph: seen.yaml, each: zones, in: {frames: eyes}}
  show: {uses: toy.pair, each: zones, in: {blobs: area.blobs}}
"""
    found = edges(planned(tmp_path, text, room=SHARED, seen=seen))
    assert [edge for edge in found if "show" in edge] == [
        "area/hall/detect/cam0.out -> show/hall.blobs",
        "area/stage/detect/cam0.out -> show/stage.blobs",
        "area/stage/detect/cam1.out -> show/stage.blobs",
    ]


def test_an_input_of_a_port_gets_the_cameras_that_the_sub_graph_sees(tmp_path: Path) -> None:
    text = '  area: {graph: zone.yaml, cameras: "cameras[zone=stage]", in: {blobs: detect}}\n'
    assert readers(tmp_path, text) == ["detect/cam1.out -> area/gather.blobs"]
    outer = "graph: outer\ninputs: {blobs: area.blobs}\nstages:\n" + text.replace("in: {blobs: detect}", "")
    text = '  more: {graph: outer.yaml, cameras: "cameras[kind=infrared]", in: {blobs: detect}}\n'
    plan = planned(tmp_path, DETECTORS + text, room=SHARED, zone=ZONE, outer=outer)
    assert [e for e in edges(plan) if e.endswith("gather.blobs")] == [
        "detect/cam1.out -> more/area/gather.blobs"
    ]


def test_sensors_without_the_tag_feed_every_member(tmp_path: Path) -> None:
    room = TAGGED + "sensors: {imu0: {kind: imu, source: {uses: toy.imu}}}\n"
    text = """\
  imu:  {uses: room.source, each: sensors}
  area: {graph: hint.yaml, each: zones, in: {hint: imu, blobs: detect}}
"""
    hint = ZONE.replace("{blobs: gather.blobs}", "{blobs: gather.blobs, hint: own.hint}")
    found = edges(planned(tmp_path, DETECTORS + text, room=room, hint=hint))
    assert [edge for edge in found if edge.startswith("imu")] == [
        "imu/imu0.out -> area/hall/own.hint",
        "imu/imu0.out -> area/stage/own.hint",
    ]


def test_a_member_that_the_sender_does_not_serve_is_told(tmp_path: Path) -> None:
    text = """\
  few:  {uses: toy.pair, each: "zones[name=hall]", in: {blobs: detect}}
  area: {graph: zone.yaml, each: zones, in: {blobs: few}}
"""
    with pytest.raises(InputError) as caught:
        readers(tmp_path, text)
    (mistake,) = caught.value.mistakes
    assert mistake.text == 'stage "area/stage/gather" serves zone stage, stage "few" does not'


def test_the_flat_file_says_what_stages_belong_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = """\
  area: {graph: zone.yaml, each: zones, in: {blobs: detect}}
  few:  {graph: zone.yaml, cameras: "cameras[kind=color]", in: {blobs: detect}}
  show: {uses: toy.any, each: zones, in: {blobs: area.blobs}}
"""
    write(tmp_path, main=DETECTORS + text, room=TAGGED, zone=ZONE)
    plan = compile_graph(tmp_path / "main.yaml", plugin_files=[TOY])
    assert command(["graph", str(tmp_path / "main.yaml"), "--plugin", TOY, "--flat"]) == 0
    (tmp_path / "flat.yaml").write_text(capsys.readouterr().out)
    flat = compile_graph(tmp_path / "flat.yaml", plugin_files=[TOY])
    assert (flat.stages, flat.edges) == (plan.stages, plan.edges)
