"""A ball that is hidden for a second is followed by its sensor, on this host or on another, late or not."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from tests.integration.hosts import Hosts, namespaces_are_permitted
from tests.integration.running import balanced

import followspot as fs
from followspot import room_file
from followspot.context import Context
from followspot.plugins.registry import load_stage
from followspot_accuracy import TargetScore, TruthTable, read_tracks_csv, score, truth_of

ROOT = Path(__file__).parents[2]
STAGES = ROOT / "tests/stages/seeing.py"
ROOM = ROOT / "graphs/rooms/simulated_imu.yaml"
GRAPH = """\
graph: hidden
room: room.yaml
stages:
  seen:        {uses: seeing.seen, with: {frames: FRAMES, seed: SEED, begin: 5.0, period: 2.0}}
  imu:         {uses: room.source, each: sensors}
  orientation: {uses: imu.orientation, each: sensors, in: {readings: imu}}
  track:       {uses: balls.inertial, in: {positions: seen, readings: imu, orientations: orientation}}
  save:        {uses: sinks.csv, in: {tracks: track.tracks}, with: {path: tracks.csv}}
"""
BEGIN, GAP, SETTLED = 5.0, 60, 30
"""First time of hiding, s; frames of a gap, and before the first that count."""
PLACEMENT = """\
placement: wrist
workers:
  wrist: {host: pc-wrist, sensors: [imu_red]}
"""


def made(folder: Path, frames: int, seed: int = 7, balls: Sequence[str] = ("red",)) -> Path:
    """A graph and its room; these balls carry sensors. All are hidden for 1 s, seen for 1 s, and so on."""
    room = yaml.safe_load(ROOM.read_text())
    for part in (*room["cameras"].values(), *room["sensors"].values(), {"source": room["truth"]}):
        part["source"]["with"] |= {"frames": frames, "seed": seed}
    room["sensors"] = {f"imu_{ball}": room["sensors"][f"imu_{ball}"] for ball in balls}
    (folder / "room.yaml").write_text(yaml.safe_dump(room, sort_keys=False))
    path = folder / "graph.yaml"
    told = GRAPH.replace("FRAMES", str(frames)).replace("SEED", str(seed))
    path.write_text(told)
    return path


def truth(folder: Path) -> TruthTable:
    room = room_file.load(folder / "room.yaml")
    assert room.truth is not None
    source = load_stage(room.truth.uses)(Context(room=room), **room.truth.params)
    source.setup()
    return truth_of(source.process())


def scores(folder: Path, out: Path) -> dict[str, TargetScore]:
    """Scores of a run; frames count in which a ball is trackable, also while its positions are taken away."""
    return score(read_tracks_csv(out / "tracks.csv"), counted(truth(folder), BEGIN))


def counted(true: TruthTable, begin: float) -> TruthTable:
    """The truth with those frames only in which a ball was hidden for no more than 1 s, and before that seen
    for half a second. begin: first time of hiding, s.
    """
    hiding = (true.time >= begin) & ((true.time - begin) % 2.0 < 1.0)
    trackable = np.zeros_like(true.trackable)
    for ball, seen in enumerate((true.trackable & ~hiding[:, None]).T):
        gone, steady = 0, 0
        for frame, here in enumerate(seen):
            gone = 0 if here else gone + 1
            steady = 0 if gone > GAP else steady + 1
            trackable[frame, ball] = true.trackable[frame, ball] and steady > SETTLED
    return replace(true, trackable=trackable)


def run(graph: Path, out: Path, **options: Any) -> bytes:
    with fs.run(graph, out=out, plugin_files=[STAGES], **options) as handle:
        assert handle.wait().ok
    return (out / "tracks.csv").read_bytes()


def test_a_ball_hidden_for_a_second_is_covered_by_its_sensor(tmp_path: Path) -> None:
    run(made(tmp_path, 480), tmp_path / "out")
    found = scores(tmp_path, tmp_path / "out")
    assert found["red"].coverage == 1.0
    assert found["red"].orientation_deg < 3.0
    assert found["green"].coverage < 0.95  # hidden as long, and without a sensor


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [7, 11, 12])
def test_all_balls_are_covered_in_other_performances(seed: int, tmp_path: Path) -> None:
    run(made(tmp_path, 1020, seed, balls=("green", "red", "blue")), tmp_path / "out")
    assert [one.coverage for one in scores(tmp_path, tmp_path / "out").values()] == [1.0, 1.0, 1.0]


@pytest.fixture
def hosts(tmp_path: Path) -> Iterator[Hosts]:
    with Hosts(tmp_path, ["desk", "pc-wrist"]) as made:
        yield made


@pytest.mark.thorough
@pytest.mark.skipif(not namespaces_are_permitted(), reason="this user may not make network namespaces")
def test_the_sensor_may_be_on_another_host_behind_a_slow_link(hosts: Hosts, tmp_path: Path) -> None:
    graph = made(tmp_path, 480)
    alone = run(graph, tmp_path / "alone")
    (tmp_path / "placement.yaml").write_text(PLACEMENT)
    hosts.agent("pc-wrist", "--plugin", STAGES)
    hosts.throttle("pc-wrist", "2mbit")
    words = (
        "run",
        graph,
        "--plugin",
        STAGES,
        "--placement",
        tmp_path / "placement.yaml",
        "--out",
        tmp_path / "two",
    )
    process = hosts.start(
        "desk", *words, "--json", "--quiet", "--connect", hosts.endpoint("pc-wrist"), "--insecure"
    )
    stdout, stderr = process.communicate(timeout=120)
    assert process.returncode == 0, stderr + stdout
    summary = json.loads(stdout)
    assert balanced(summary)
    assert "zenoh" in {edge["kind"] for edge in summary["edges"]}
    assert (tmp_path / "two/tracks.csv").read_bytes() == alone
    assert scores(tmp_path, tmp_path / "two")["red"].coverage == 1.0


@pytest.mark.thorough
def test_readings_that_come_late_are_used(tmp_path: Path) -> None:
    """Over a link that delays them by 30 to 120 ms, so that each position comes before its readings."""
    graph = made(tmp_path, 480)
    told = yaml.safe_load(graph.read_text())
    told["stages"]["link"] = {"uses": "seeing.belated", "each": "sensors", "in": {"readings": "imu"}}
    told["stages"]["orientation"]["in"] = {"readings": "link"}
    told["stages"]["track"]["in"]["readings"] = "link"
    graph.write_text(yaml.safe_dump(told, sort_keys=False))
    run(graph, tmp_path / "out")
    found = scores(tmp_path, tmp_path / "out")
    assert found["red"].coverage == 1.0
    assert found["green"].coverage < 0.95
