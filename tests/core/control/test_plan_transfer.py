"""Transfer of a plan: without code and absolute paths; an agent refuses plans that ask for more."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from followspot.control.plan_transfer import packed, unpacked
from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedWorker
from followspot.graph.plan_data import plan_from_data
from followspot.room import Room, Sensor, StageUse
from followspot.security.grants import Grants
from followspot.testing import tiny_room


@pytest.fixture
def media(tmp_path: Path) -> Path:
    folder = tmp_path / "media"
    folder.mkdir()
    (folder / "clip.csv").write_text("0,0,0\n")
    (tmp_path / "secret.csv").write_text("0,0,0\n")
    (folder / "leads_out.csv").symlink_to(tmp_path / "secret.csv")
    return folder


@pytest.fixture
def plan(tmp_path: Path, media: Path) -> Plan:
    """A plan with a source that reads a file and a sink that writes one, on the host pc-left."""
    source = f"{{uses: cameras.truth_csv, with: {{path: {media / 'clip.csv'}}}}}"
    (tmp_path / "g.yaml").write_text(
        f"graph: g\nstages:\n  read: {source}\n  save: {{uses: sinks.jsonl, in: {{message: read}}}}\n"
    )
    compiled = compile_graph(tmp_path / "g.yaml")
    return replace(compiled, workers=(PlannedWorker("main", "pc-left"),))


def refused(data: dict[str, Any], media: Path | None, why: str) -> None:
    with pytest.raises(FollowspotError, match=why):
        unpacked(data, "pc-left", Grants(media), ())


def test_a_plan_travels_without_absolute_paths_and_arrives_equal(plan: Plan, media: Path) -> None:
    data = packed(plan, "pc-left", media)
    assert str(media.parent) not in json.dumps(data)
    there = plan_from_data(unpacked(data, "pc-left", Grants(media), ()))
    assert there.stages[0].params["path"] == str(media / "clip.csv")
    assert there.stages == plan.stages


def test_parameters_of_other_hosts_do_not_travel(plan: Plan, media: Path) -> None:
    assert "clip.csv" not in json.dumps(packed(plan, "pc-right", media))


def test_what_the_room_says_of_sources_and_parameters_does_not_travel(plan: Plan, media: Path) -> None:
    source = StageUse("cameras.stream", {"url": "rtsp://user:secret@device"})
    room = Room(
        cameras={"cam0": replace(tiny_room().cameras["cam0"], source=source)},
        sensors={"imu": Sensor("imu", "imu", source)},
        tune={"cameras.stream.url": "rtsp://user:secret@device"},
    )
    data = packed(replace(plan, room=room), "pc-left", media)
    assert "secret" not in json.dumps(data)
    assert plan_from_data(data).room.sensors["imu"].kind == "imu"


def test_a_file_outside_the_media_folder_is_an_error(plan: Plan, media: Path) -> None:
    with pytest.raises(FollowspotError, match="not below"):
        packed(plan, "pc-left", media / "elsewhere")


def test_an_agent_rejects_code(plan: Plan, media: Path) -> None:
    data = packed(plan, "pc-left", media)
    refused({**data, "plugin_files": ["/tmp/evil.py"]}, media, "code of its own")


def test_an_agent_rejects_a_stage_that_is_not_installed(plan: Plan, media: Path) -> None:
    data = packed(plan, "pc-left", media)
    data["stages"][1]["uses"] = "evil.stage"
    refused(data, media, "evil")


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.csv", "a/../../secret.csv", "", "a\0b"])
def test_an_agent_writes_below_the_folder_of_the_run_only(plan: Plan, media: Path, name: str) -> None:
    data = packed(plan, "pc-left", media)
    data["stages"][1]["params"]["path"] = name
    refused(data, media, "outside the run's folder")


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("/etc/passwd", "outside the agent's media folder"),
        ("../secret.csv", "outside the agent's media folder"),
        ("x/../../secret.csv", "outside the agent's media folder"),
        ("leads_out.csv", "outside the agent's media folder"),
        ("none.csv", "not in the agent's media folder"),
    ],
)
def test_an_agent_reads_below_its_media_folder_only(plan: Plan, media: Path, name: str, why: str) -> None:
    data = packed(plan, "pc-left", media)
    data["stages"][0]["params"]["path"] = name
    refused(data, media, why)


def test_an_agent_without_a_media_folder_reads_no_file(plan: Plan, media: Path) -> None:
    refused(packed(plan, "pc-left", media), None, "--media DIR")
