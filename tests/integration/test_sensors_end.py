"""A run of N frames has N frames of each camera, and readings of the sensors until the last of these."""

from __future__ import annotations

from pathlib import Path

import pytest

import followspot as fs

STAGES = Path(__file__).parents[1] / "stages/limited.py"
CAMERA = "{kind: color, size: [64, 48], matrix: [[50, 0, 32], [0, 50, 24], [0, 0, 1]], \
distortion: [0, 0, 0, 0, 0], rotation: [[1, 0, 0], [0, -1, 0], [0, 0, -1]], translation: [0, 0, 2]}"
ROOM = f"""\
room: props
cameras:
  left: {CAMERA}
  right: {CAMERA}
sensors:
  wrist: {{kind: imu, rate: 1000, mount: {{target: red}}}}
targets: {{red: {{radius: 0.1}}}}
"""
GRAPH = """\
graph: props
room: room.yaml
stages:
  eye: {uses: limited.CAMERA, each: cameras}
  imu: {uses: limited.SENSOR, each: sensors}
  pair: {uses: limited.pair, each: cameras, in: {frame: eye, newest: imu}}
  frames: {uses: limited.note, each: cameras, in: {read: pair}}
  readings: {uses: limited.note, in: {read: imu}}
"""
PLACEMENT = """\
placement: apart
workers:
  eyes: {stages: [eye, pair, frames]}
  wrist: {stages: [imu]}
  notes: {stages: [readings]}
"""


SENSORS = """\
graph: sensors
room: room.yaml
stages:
  imu: {uses: limited.imu, each: sensors}
  readings: {uses: limited.note, each: sensors, in: {read: imu}}
"""
EACH_APART = """\
placement: apart
workers:
  wrist: {sensors: [wrist]}
  ankle: {sensors: [ankle]}
"""


def notes(folder: Path, camera: str, sensor: str, placement: str | None) -> dict[str, list[str]]:
    """What each stage noted of a run of 10 frames of cameras and a sensor."""
    graph = GRAPH.replace("CAMERA", camera).replace("SENSOR", sensor)
    return run(folder, {"room.yaml": ROOM, "graph.yaml": graph, "apart.yaml": PLACEMENT}, placement)


def run(folder: Path, files: dict[str, str], placement: str | None) -> dict[str, list[str]]:
    """What each stage noted of a run of 10 frames."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    out = folder / f"out-{placement}"
    chosen = None if placement is None else str(folder / "apart.yaml")
    plugins = [STAGES]
    with fs.run(folder / "graph.yaml", placement=chosen, out=out, plugin_files=plugins, frames=10) as handle:
        report = handle.wait()
    assert report.ok
    assert report.frames == 10  # of a camera, not of a sensor
    return {path.stem: path.read_text().splitlines() for path in sorted(out.rglob("*.txt"))}


def test_a_sensor_ends_with_the_last_frame_of_the_cameras_in_every_placement(tmp_path: Path) -> None:
    together, apart = (notes(tmp_path, "timed", "imu", placement) for placement in (None, "apart"))
    assert together == apart
    last = 10**9 + 9 * 20_000_000
    assert {name: len(lines) for name, lines in together.items()} == {
        "left": 10,
        "right": 10,
        "readings": last // 1_000_000 + 1,
    }
    assert together["left"][-1] == f"{last} {last // 1_000_000}"
    assert together["readings"][-1] == f"{last} {last // 1_000_000}"


@pytest.mark.parametrize("placement", [None, "apart"])
def test_a_sensor_ends_after_cameras_that_do_not_know_their_times(
    placement: str | None, tmp_path: Path
) -> None:
    found = notes(tmp_path, "eye", "imu", placement)
    assert (len(found["left"]), len(found["right"])) == (10, 10)
    assert len(found["readings"]) >= 1180


@pytest.mark.parametrize("placement", [None, "apart"])
def test_a_live_sensor_ends_after_live_cameras(placement: str | None, tmp_path: Path) -> None:
    found = notes(tmp_path, "device", "device", placement)  # a run that never ends would fail
    assert max(len(found["left"]), len(found["right"])) <= 10


@pytest.mark.parametrize("placement", [None, "apart"])
def test_without_cameras_each_sensor_gives_as_many_readings(placement: str | None, tmp_path: Path) -> None:
    ankle = "sensors:\n  ankle: {kind: imu, rate: 1000, mount: {target: red}}"
    files = {"room.yaml": ROOM.replace("sensors:", ankle), "graph.yaml": SENSORS, "apart.yaml": EACH_APART}
    found = run(tmp_path, files, placement)
    readings = [f"{number * 1_000_000} {number}" for number in range(10)]
    assert found == {"ankle": readings, "wrist": readings}
