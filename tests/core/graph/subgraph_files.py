"""Graph files that use others as stages, and rooms with zones, for several files of tests."""

from __future__ import annotations

from tests.core.graph.files import ROOM

TWO = """\
graph: building
room: room.yaml
stages:
  left:  {graph: tracker.yaml, cameras: "cameras[name=cam0]", with: {level: 0.25}}
  right: {graph: tracker.yaml, cameras: "cameras[kind=infrared]"}
  save:  {uses: toy.save, in: {tracks: left.tracks}, with: {path: left.csv}}
  other: {uses: toy.save, in: {tracks: right.tracks}, with: {path: right.csv}}
"""
SHARED = """\
graph: building
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  hall: {graph: tracker.yaml, in: {frames: eyes}}
  save: {uses: toy.save, in: {tracks: hall.tracks}}
"""
MIDDLE = """\
graph: middle
params: {level: inner.level}
inputs: {frames: inner.frames}
outputs: {tracks: inner.tracks}
stages:
  inner: {graph: tracker.yaml, cameras: "cameras[kind=color|infrared]"}
"""
NESTED = SHARED.replace("tracker.yaml", "middle.yaml, with: {level: 0.75}, cameras: 'cameras[name=cam1]'")
ZONED = ROOM.replace("    kind: color\n", "    kind: color\n    tags: {zone: hall}\n").replace(
    "    kind: infrared\n", "    kind: infrared\n    tags: {zone: [stage, hall]}\n"
)
EACH = """\
graph: building
room: room.yaml
stages:
  tracker: {graph: tracker.yaml, each: zones}
  pair:    {uses: toy.pair, in: {blobs: tracker.blobs}}
  only:    {uses: toy.save, in: {tracks: tracker/stage/track.tracks}}
"""
TAGGED = ROOM.replace("    kind: color\n", "    kind: color\n    tags: {zone: hall}\n").replace(
    "    kind: infrared\n", "    kind: infrared\n    tags: {zone: stage}\n"
)
ZONE = """\
graph: zone
inputs:  {blobs: gather.blobs}
outputs: {blobs: gather}
stages:
  own:    {uses: toy.any, in: {blobs: gather}}
  gather: {uses: toy.pair, in: {blobs: other}}
  other:  {uses: toy.pair, in: {blobs: gather}}
"""
DETECTORS = """\
graph: main
room: room.yaml
stages:
  eyes:   {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: eyes}}
"""
WINGS = """\
graph: nested
room: room.yaml
stages:
  wing: {graph: wing.yaml, each: zones, in: {pictures: eyes}, with: {level: 0.25}}
  eyes: {uses: room.source, each: cameras}
  pair: {uses: toy.pair, in: {blobs: wing.blobs}}
"""
WING = """\
graph: wing
params: {level: [inner.level]}
inputs: {pictures: inner.frames}
outputs: {blobs: inner.blobs}
stages:
  inner: {graph: tracker.yaml, cameras: "cameras[kind=color|infrared]"}
"""
