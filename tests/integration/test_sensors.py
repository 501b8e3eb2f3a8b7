"""A graph over sensors, tags and targets gives the same in one process and in one for each device."""

from __future__ import annotations

from pathlib import Path

import followspot as fs

PLUGIN = '''
import numpy as np
from followspot import Array, Joined, Message, Source, Stage, at, column


class Reading(Message):
    sensor: str
    acceleration: Array = column("N", 3, unit="m/s^2")


class Imu(Stage):
    """Readings that count."""

    per_sensor = True

    def process(self) -> Source[Reading]:
        for number in range(50):
            time = round(number * 1e9 / self.sensor.rate)
            value = 1.0 * number + len(self.sensor.mount.name)
            yield at(time, Reading(self.sensor.name, np.full((1, 3), value)))


class Mean(Stage):
    """The mean of the sensors."""

    def process(self, readings: Joined[Reading]) -> Reading:
        name = "+".join(reading.sensor for reading in readings)
        return Reading(name, np.mean([reading.acceleration for reading in readings], axis=0))


class Note(Stage):
    """A file for each target."""

    per_target = True

    def setup(self) -> None:
        self.lines = []

    def process(self, reading: Reading) -> None:
        self.lines.append(f"{reading.sensor} {reading.acceleration[0, 0]}")

    def close(self) -> None:
        (self.context.out / f"{self.target.name}.txt").write_text("\\n".join(self.lines))
'''
ROOM = """\
room: props
sensors:
  left: {kind: imu, rate: 100, mount: {target: red}, tags: {body: arms}, source: {uses: props.imu}}
  right: {kind: imu, rate: 100, mount: {target: green}, tags: {body: arms}, source: {uses: props.imu}}
  foot: {kind: imu, rate: 100, mount: {target: red}, tags: {body: legs}, source: {uses: props.imu}}
targets: {red: {radius: 0.1}, green: {radius: 0.1}}
"""
GRAPH = """\
graph: props
room: room.yaml
stages:
  imu: {uses: room.source, each: sensors}
  body: {uses: props.mean, each: bodies, in: {readings: imu}}
  all: {uses: props.mean, in: {readings: body}}
  note: {uses: props.note, each: targets, in: {reading: all}}
"""


def test_sensors_bodies_and_targets(tmp_path: Path) -> None:
    for name, text in (("props.py", PLUGIN), ("room.yaml", ROOM), ("graph.yaml", GRAPH)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    found = {}
    for placement in (None, "camera"):
        out = tmp_path / str(placement)
        plugins = [tmp_path / "props.py"]
        with fs.run(tmp_path / "graph.yaml", placement=placement, out=out, plugin_files=plugins) as run:
            run.wait()
        found[placement] = [(out / f"{name}.txt").read_text().splitlines() for name in ("red", "green")]
    assert found[None] == found["camera"]
    red, green = found[None]
    assert red == green
    assert len(red) == 50
    assert red[0] == "left+right+foot 3.5"  # of the arms 3 and 5, and the leg 3
