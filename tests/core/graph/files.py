"""A graph, a room and a placement without mistakes, for the tests to break."""

from __future__ import annotations

from pathlib import Path

TOY = str(Path(__file__).with_name("toy.py"))

GRAPH = """\
graph: play
room: room.yaml
outputs: {tracks: track.tracks}
seed: 7
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera, forecast: {from: track.forecast, delay: 1}}}
  pair: {uses: toy.pair, in: {blobs: detect}}
  track: {uses: toy.track, in: {blobs: pair}, with: {model: constant}}
  save: {uses: toy.save, in: {tracks: track}, with: {path: tracks.csv}}
"""

ROOM = """\
room: stage
cameras:
  cam0:
    kind: color
    size: [320, 240]
    matrix: [[250, 0, 160], [0, 250, 120], [0, 0, 1]]
    distortion: [0.1, 0, 0, 0, 0]
    rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    translation: [0, 0, 3]
    source: {uses: toy.camera, with: {frames: 20}}
  cam1:
    kind: infrared
    size: [640, 480]
    matrix: [[500, 0, 320], [0, 500, 240], [0, 0, 1]]
    rotation: [[0, 1, 0], [1, 0, 0], [0, 0, -1]]
    translation: [0, 0, 4]
    source: {uses: toy.camera, with: {frames: 30}}
    host: pc-left
planes: {floor: [0, 0, 1, 0]}
targets:
  green:
    radius: 0.0762
    hue_histogram: {cam0: [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]}
    area: {cam0: [12, 140]}
    gray: {cam1: [90, 255]}
truth: {uses: toy.knowing, with: {path: truth.csv}}
"""

HERE = ROOM.replace("    host: pc-left\n", "")
PLACEMENT = """\
placement: two
workers:
  left: {host: pc-left, cameras: [cam1], stages: [save]}
  right: {stages: [detect/cam0]}
"""


def write(folder: Path, **changed: str) -> Path:
    """Write the files, some with other text; returns the graph file."""
    texts = {"graph": GRAPH, "room": ROOM, "placement": PLACEMENT, **changed}
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    (folder / "truth.csv").write_text("", encoding="utf-8")
    return folder / "graph.yaml"
