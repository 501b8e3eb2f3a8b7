"""Which ports the page looks at, and how their taps are told to."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from tests.tools.page.sensor_room import worn

from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedEdge
from followspot.inertial import Inertial, PosedTracks
from followspot.tracking import Tracks
from followspot_dashboard.picture import Picture
from followspot_page.display.scene import scene
from followspot_page.taps.replaced_tracks import followed
from followspot_page.taps.sensors import sensors
from followspot_page.taps.shown_ports import ShownPort, sent_kinds, shown_ports, tappings

GRAPHS = Path(__file__).parents[3] / "graphs"


def by_name(plan: Plan) -> dict[str, ShownPort]:
    return {port.name: port for port in shown_ports(plan)}


@pytest.mark.parametrize(
    ("graph", "last"),
    [("building", ["merge.out"]), ("show", ["balls/track.tracks"]), ("glowballs", ["track.tracks"])],
)
def test_of_tracks_made_of_tracks_the_last_are_shown(graph: str, last: list[str]) -> None:
    shown = by_name(compile_graph(GRAPHS / f"{graph}.yaml"))
    assert [name for name, port in shown.items() if issubclass(port.type, Tracks)] == last
    assert sum(name.endswith("track.forecast") for name in shown) == (2 if graph == "building" else 1)


def test_tracks_that_come_late_are_not_drawn_in_place_of_those_of_now() -> None:
    """With `lag_frames: 0` nothing would be drawn until the end."""
    assert followed(compile_graph(GRAPHS / "smooth.yaml")) == {"smooth.out"}


def test_tracks_that_are_fed_back_do_not_follow_themselves() -> None:
    plan = compile_graph(GRAPHS / "building.yaml")
    back = PlannedEdge("merge", "out", "hall/track", "positions", "reference", delay=1)
    assert followed(replace(plan, edges=(*plan.edges, back))) == {"hall/track.tracks", "stage/track.tracks"}


def test_trackers_beside_each_other_are_both_shown(tmp_path: Path) -> None:
    text = (
        (GRAPHS / "building.yaml").read_text(encoding="utf-8").replace("graph: glow", f"graph: {GRAPHS}/glow")
    )
    text = "".join(line for line in text.splitlines(True) if "merge" not in line)
    (tmp_path / "beside.yaml").write_text(text.replace("room: ", f"room: {GRAPHS}/"), encoding="utf-8")
    shown = by_name(compile_graph(tmp_path / "beside.yaml"))
    assert {"hall/track.tracks", "stage/track.tracks"} < set(shown)


def test_readings_of_sensors_are_shown_depth_as_pictures_and_posed_tracks_as_tracks(tmp_path: Path) -> None:
    plan = worn(tmp_path)
    shown = by_name(plan)
    assert {name: port.sensor for name, port in shown.items() if port.sensor} == {
        "imu/wrist.out": "wrist",
        "air/air.out": "air",
    }
    assert "track.tracks" not in shown  # the posed ones follow it
    assert shown["pose.out"].type is PosedTracks
    kinds = sent_kinds(shown.values())
    assert (kinds["camera/depth0.out"], kinds["imu/wrist.out"]) == (Picture, Inertial)
    taps = {tap.port: tap.params for tap in tappings(shown.values(), tmp_path, 10.0)}
    assert taps["camera/depth0.out"]["sets_times"]
    assert not taps["imu/wrist.out"]["sets_times"]  # a fast sensor would choose times no camera has reached
    assert taps["imu/wrist.out"]["message_rate"] > taps["air/air.out"]["message_rate"] > 0
    assert taps["imu/wrist.out"]["watched_only"]
    assert not taps["pose.out"]["watched_only"]
    cameras = {camera["name"]: camera["depths"] for camera in scene(plan.room)["cameras"]}
    assert cameras["depth0"]["farthest"] == taps["camera/depth0.out"]["farthest"] == 8.0


def test_sensors_of_the_room_are_told_whether_or_not_anything_serves_them(tmp_path: Path) -> None:
    plan = worn(tmp_path)
    told = sensors(plan.room, [port for port in shown_ports(plan) if port.sensor])
    wrist = {"kind": "imu", "rate": 100, "mount": "target red", "ports": ["imu/wrist.out"]}
    assert told[0] == {"name": "wrist", **wrist}
    assert [(sensor["name"], sensor["ports"]) for sensor in told[1:]] == [
        ("air", ["air/air.out"]),
        ("spare", []),
    ]
