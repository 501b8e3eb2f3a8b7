"""Stages fan out over cameras, sensors, targets and tags; optional ones may find nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import ROOM, TOY, write

from followspot.context import Context
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.room import Member
from followspot.stage import Stage

ZONES = (
    ROOM.replace("    kind: color\n", "    kind: color\n    tags: {zone: hall}\n")
    .replace("    kind: infrared\n", "    kind: infrared\n    tags: {zone: [hall, stage]}\n")
    .replace("    host: pc-left\n", "")
    + """\
sensors:
  imu0: {kind: imu, rate: 1000, mount: {target: green}, host: pc-right, source: {uses: toy.imu}}
  imu1: {kind: imu, tags: {zone: attic}, source: {uses: toy.imu, with: {scale: 2.0}}}
"""
)
GRAPH = """\
graph: members
room: room.yaml
stages:
  camera: {uses: room.source, each: cameras}
  imu: {uses: room.source, each: sensors}
"""


def planned(folder: Path, stages: str, room: str = ZONES, **options: object) -> Plan:
    graph = write(folder, graph=GRAPH + stages, room=room)
    return compile_graph(graph, plugin_files=[TOY], **options)  # type: ignore[arg-type]


def refused(folder: Path, stages: str, room: str = ZONES) -> list[str]:
    with pytest.raises(InputError) as caught:
        planned(folder, stages, room)
    return [f"{m.place and m.place.line}: {m.text}; {m.remedy}" for m in caught.value.mistakes]


def edges(plan: Plan, reader: str) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for edge in plan.edges:
        if edge.to_stage.startswith(reader):
            found.setdefault(edge.to_stage, []).append(edge.from_stage)
    return found


def test_a_sensor_has_a_source_a_member_and_a_host(tmp_path: Path) -> None:
    plan = planned(tmp_path, "", placement="camera")
    stages = {stage.name: stage for stage in plan.stages}
    assert stages["imu/imu1"].params["scale"] == 2.0
    assert stages["imu/imu0"].member == Member("sensors", "imu0")
    assert stages["imu/imu0"].camera is None
    assert plan.host_of_stage("imu/imu0") == "pc-right"
    assert plan_from_data(plan_to_data(plan)).stages == plan.stages


def test_a_placement_file_names_sensors(tmp_path: Path) -> None:
    file = tmp_path / "placed.yaml"
    file.write_text("workers: {left: {sensors: [imu0]}}\n", encoding="utf-8")
    plan = planned(tmp_path, "", placement=file)
    assert plan.worker_of("imu/imu0") == "left"
    assert plan.worker_of("imu/imu1") == "main"


def test_a_reader_of_a_tag_takes_from_the_members_that_carry_its_value(tmp_path: Path) -> None:
    plan = planned(
        tmp_path,
        "  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}\n"
        '  pair: {uses: toy.pair, each: "zones[kind=color|infrared]", in: {blobs: detect}}\n'
        "  track: {uses: toy.any, each: 'zones[name=hall|stage]', in: {blobs: pair}}\n"
        "  every: {uses: toy.pair, in: {blobs: pair}}\n"
        "  alone: {uses: toy.pair, each: targets, in: {blobs: detect}}\n",
    )
    assert edges(plan, "pair/") == {
        "pair/hall": ["detect/cam0", "detect/cam1"],
        "pair/stage": ["detect/cam1"],
    }
    assert edges(plan, "track/") == {"track/hall": ["pair/hall"], "track/stage": ["pair/stage"]}
    assert edges(plan, "every") == {"every": ["pair/hall", "pair/stage"]}
    assert edges(plan, "alone/") == {"alone/green": ["detect/cam0", "detect/cam1"]}


def test_a_reader_of_cameras_takes_from_the_zones_of_each(tmp_path: Path) -> None:
    room = ZONES.replace("zone: [hall, stage]", "zone: stage")
    plan = planned(
        tmp_path,
        "  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}\n"
        "  pair: {uses: toy.pair, each: 'zones[name=hall|stage]', in: {blobs: detect}}\n"
        "  own: {uses: toy.any, each: cameras, in: {blobs: pair}}\n",
        room,
    )
    assert edges(plan, "own/") == {"own/cam0": ["pair/hall"], "own/cam1": ["pair/stage"]}


OPTIONAL = """\
  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}
  depth: {uses: toy.detect, each: "cameras[kind=depth]", optional: true, in: {frame: camera}}
  pair: {uses: toy.pair, in: {blobs: [depth, detect]}}
"""


def test_readers_go_on_without_an_optional_stage_that_the_room_has_nothing_for(tmp_path: Path) -> None:
    plan = planned(tmp_path, OPTIONAL)
    assert edges(plan, "pair") == {"pair": ["detect/cam0", "detect/cam1"]}
    assert not [stage for stage in plan.stages if stage.group == "depth"]
    assert 'stage "depth" is left out: the room has no cameras[kind=depth]' in plan.notes


def test_an_optional_stage_is_left_out_with_all_that_feeds_it(tmp_path: Path) -> None:
    plan = planned(
        tmp_path,
        OPTIONAL + "  own: {uses: toy.pair, optional: true, in: {blobs: depth}}\n"
        "  draw: {uses: toy.any, optional: true, in: {blobs: own}}\n",
    )
    assert {stage.group for stage in plan.stages} == {"camera", "imu", "detect", "pair"}
    assert 'stage "draw" is left out: so is all that feeds it' in plan.notes


def test_a_forecast_alone_does_not_keep_an_optional_stage(tmp_path: Path) -> None:
    hint = "{blobs: depth, hint: {from: pair, delay: 1}}"
    plan = planned(tmp_path, OPTIONAL + f"  again: {{uses: toy.any, optional: true, in: {hint}}}\n")
    assert {stage.group for stage in plan.stages} == {"camera", "imu", "detect", "pair"}


def test_a_reader_that_needs_an_optional_stage_is_told(tmp_path: Path) -> None:
    (told,) = refused(tmp_path, OPTIONAL.replace("[depth, detect]", "depth"))
    assert told.startswith('8: input "blobs" of stage "pair" needs what is left out')
    assert "cameras[kind=depth]" in told


def test_an_optional_stage_may_ask_for_a_tag_that_the_room_does_not_know(tmp_path: Path) -> None:
    plan = planned(tmp_path, OPTIONAL.replace("kind=depth", "role=spare"))
    assert any("cameras[role=spare]" in note for note in plan.notes)


@pytest.mark.parametrize(
    ("stages", "text"),
    [
        ("  x: {uses: toy.camera, each: sensors}\n", "toy.camera serves one camera, but stage"),
        ("  x: {uses: toy.imu, each: cameras}\n", "toy.imu serves one sensor, but stage"),
        ("  x: {uses: toy.imu}\n", "toy.imu serves one sensor, and stage"),
        ("  x: {uses: room.source, each: zones}\n", "serves no camera and no sensor"),
        ("  x: {uses: room.source, each: targets}\n", "serves no camera and no sensor"),
        ("  x: {uses: toy.imu, each: 'sensors[kind=lidar]'}\n", "imu0 (imu), imu1 (imu)"),
        ("  x: {uses: toy.imu, each: 'zones[name=cellar]'}\n", "zones[name=cellar] matches none"),
        ("  x: {uses: toy.imu, each: zoness}\n", 'did you mean "zones"'),
        ("  x: {uses: toy.imu, each: sensors, optional: 3}\n", "optional cannot be 3"),
        (
            "  a: {uses: toy.detect, each: cameras, in: {frame: camera}}\n"
            "  x: {uses: toy.pair, each: zones, in: {blobs: a}}\n",
            'stage "x" serves zone attic, stage "a" does not',
        ),
    ],
)
def test_a_wrong_fan_out_is_one_mistake(tmp_path: Path, stages: str, text: str) -> None:
    told = refused(tmp_path, stages)
    assert len(told) == 1
    assert text in told[0]


def test_a_mistake_of_many_instances_is_told_once(tmp_path: Path) -> None:
    told = refused(
        tmp_path,
        "  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}\n"
        "  pair: {uses: toy.pair, each: 'zones[name=hall|stage]', in: {blobs: detect}}\n"
        "  own: {uses: toy.any, each: cameras, in: {blobs: pair}}\n",
        ZONES.replace("zone: hall}", "zone: [hall, stage]}"),
    )
    assert len(told) == 1
    assert 'input "blobs" of stage "own" takes one message, 2 come' in told[0]
    assert "give the stage each: zones, or declare" in told[0]


def test_a_stage_outside_its_set_says_what_to_write() -> None:
    stage = Stage(Context("imu", member=Member("zone", "hall")))
    with pytest.raises(LookupError, match='serves no sensor: give it one with "each: sensors"'):
        stage.sensor  # noqa: B018
    with pytest.raises(LookupError, match='serves no target: give it one with "each: targets"'):
        stage.target  # noqa: B018
    with pytest.raises(LookupError, match='target red, which the room "room" lacks'):
        Stage(Context("x", member=Member("targets", "red"))).target  # noqa: B018
