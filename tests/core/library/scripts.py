"""What tests of scripts share: the tracker composed in Python, and a run that does not end by itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import followspot as fs
from followspot.tracking import Tracks

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"
ROOM = GRAPH.parent / "rooms" / "simulated.yaml"
TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
ENDLESS = """
graph: endless
stages:
  a: {uses: ticks.live, with: {count: 1000000, period: 0.01}}
  b: {uses: ticks.add, in: {number: a}}
"""


class Low(fs.Stage):
    """Keep the tracks below a height."""

    class Params(fs.StageParams):
        height: float = fs.Field(1.0, gt=0, description="highest position kept", unit="m")

    params: Params

    def process(self, tracks: Tracks) -> Tracks:
        return tracks.where(tracks.xyz[:, 2] < self.params.height)


def composed() -> fs.Graph:
    """graphs/glowballs.yaml without its bridge, and with `Low` at its end."""
    graph = fs.Graph("mine", room=ROOM)
    forecast = graph.port("track.forecast").delayed(1)
    camera = graph.add("camera", "room.source", each="cameras")
    color = graph.add(
        "color", "balls.color_blobs", each="cameras[kind=color]", frame=camera, forecast=forecast
    )
    infrared = graph.add(
        "infrared", "balls.ir_blobs", each="cameras[kind=infrared]", frame=camera, forecast=forecast
    )
    verify = graph.add("verify", "balls.verify_pairs", blobs=[color, infrared], forecast=forecast)
    found = graph.add("triangulate", "balls.triangulate", pairs=verify, forecast=forecast)
    fuse = graph.add("fuse", "balls.mean_shift", candidates=found, forecast=forecast, maximum_iterations=40)
    track = graph.add("track", "balls.kalman", positions=fuse)
    graph.add("low", Low, tracks=track.tracks, height=1.2)
    return graph


def endless(folder: Path, **options: Any) -> fs.OwnRun:
    """A run that goes on until it is stopped, with its files in this folder; options: as `run` takes them."""
    graph = folder / "endless.yaml"
    graph.write_text(ENDLESS)
    return fs.run(graph, plugin_files=[TICKS], out=folder / "out", **options)
