"""Stages of a sub-graph that is given some of the cameras know these alone; sources know the whole room."""

from __future__ import annotations

from pathlib import Path

from tests.core.graph.composed import planned
from tests.core.graph.subgraph_files import DETECTORS, TAGGED, ZONE

from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data

AREA = """\
  area:   {graph: zone.yaml, in: {blobs: detect}, LIMIT}
  all:    {uses: toy.pair, in: {blobs: detect}}
"""
EYES = """\
graph: zone
outputs: {blobs: gather}
stages:
  eyes:   {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: eyes}}
  gather: {uses: toy.pair, in: {blobs: detect}}
"""


def plan_of(folder: Path, limit: str) -> Plan:
    return planned(folder, (DETECTORS + AREA).replace("LIMIT", limit), room=TAGGED, zone=ZONE)


def known(plan: Plan) -> dict[str, list[str]]:
    """The cameras that each stage knows."""
    return {stage.name: list(plan.room_of(stage).cameras) for stage in plan.stages}


def test_a_sub_graph_knows_its_cameras_alone(tmp_path: Path) -> None:
    found = known(plan_of(tmp_path, 'cameras: "cameras[kind=infrared]"'))
    inside = {name for name in found if name.startswith("area/")}
    assert inside == {"area/own", "area/gather", "area/other"}
    assert all(found[name] == (["cam1"] if name in inside else ["cam0", "cam1"]) for name in found)


def test_a_sub_graph_for_each_zone_knows_the_cameras_of_its_zone(tmp_path: Path) -> None:
    found = known(plan_of(tmp_path, "each: zones"))
    assert (found["area/hall/gather"], found["area/stage/gather"]) == (["cam0"], ["cam1"])


def test_stages_of_one_part_share_its_room_and_what_they_derive_from_it(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, "each: zones")
    rooms = {stage.name: plan.room_of(stage) for stage in plan.stages}
    assert rooms["area/hall/gather"] is rooms["area/hall/own"]
    assert rooms["area/hall/gather"] is not rooms["area/stage/gather"]
    assert rooms["all"] is plan.room


def test_sources_inside_know_the_whole_room(tmp_path: Path) -> None:
    main = (DETECTORS + AREA).replace("in: {blobs: detect}, LIMIT", 'cameras: "cameras[zone=hall]"')
    found = known(planned(tmp_path, main, room=TAGGED, zone=EYES))
    assert found["area/eyes/cam0"] == ["cam0", "cam1"]
    assert found["area/detect/cam0"] == found["area/gather"] == ["cam0"]


def test_a_plan_keeps_the_known_cameras_on_its_way_and_needs_none(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, 'cameras: "cameras[zone=hall]"')
    data = plan_to_data(plan)
    assert known(plan_from_data(data)) == known(plan)
    for stage in data["stages"]:
        del stage["sees"]  # as plans of recordings were before
    assert set(map(tuple, known(plan_from_data(data)).values())) == {("cam0", "cam1")}
