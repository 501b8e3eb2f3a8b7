"""Every mistake in composition gives one error with the places at both ends and a remedy.

¦ stands where the error is, ‡ at a place that is shown with it, each in front of the word that is marked.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, write
from tests.core.graph.files import ROOM, TOY

from followspot.errors import InputError, Mistake
from followspot.graph.compile import compile_graph

MAIN = """\
graph: building
room: room.yaml
stages:
  eyes: {uses: room.source, each: cameras}
  hall: {graph: middle.yaml, in: {frames: eyes}, with: {level: 0.75}}
  save: {uses: toy.save, in: {tracks: hall.tracks}}
"""
MIDDLE = """\
graph: middle
params: {level: inner.level}
inputs: {frames: inner.frames, hint: inner.hint}
outputs: {tracks: inner.tracks, forecast: inner.forecast}
stages:
  inner: {graph: tracker.yaml}
"""
FILES = {"main": MAIN, "middle": MIDDLE, "tracker": TRACKER, "room": ROOM}
Change = tuple[str, str, str]
"""A file, a part of its text, and what stands there instead."""


@dataclass(frozen=True)
class Wrong:
    """One mistake. over: the text of a file that extends main.yaml and is compiled instead."""

    changes: tuple[Change, ...]
    text: str
    remedy: str
    over: str = ""
    option: str = ""


def wrong(text: str, remedy: str, *changes: Change, over: str = "", option: str = "") -> Wrong:
    return Wrong(changes, text, remedy, over, option)


ANY = "{uses: toy.any, in: {blobs: hall/inner/pair}}"
LATE = "{uses: toy.detect, each: 'cameras[name=cam1]', in: {frame: ¦eyes}}"
ZONED = "{uses: toy.pair, each: zones, in: {blobs: ¦hall/inner/detect}}"
KEEP = "{uses: toy.save, in: {tracks: track}"
MORE = "{graph: middle.yaml, in: {frames: eyes}}"
ONLY = "{uses: toy.detect, in: {frame: {from: eyes, only: ¦'cameras[kind]'}}}"
KNOWING = ("main", "  save:", "  truth: {uses: toy.knowing, with: {path: truth.csv}}\n  save:")
MISTAKES = {
    # the interface of a sub-graph, from outside
    "unknown output": wrong(
        'sub-graph "hall" has no output "track"',
        'did you mean "tracks"?',
        ("main", "tracks: hall.tracks", "tracks: ¦hall.track"),
        ("middle", "graph: middle", "‡graph: middle"),
    ),
    "several outputs and none named": wrong(
        'sub-graph "hall" has several outputs',
        "name one: hall.tracks, hall.forecast",
        ("main", "tracks: hall.tracks", "tracks: ¦hall"),
        ("middle", "graph: middle", "‡graph: middle"),
    ),
    "no outputs": wrong(
        'sub-graph "hall" has no outputs',
        "add to its file: outputs:",
        ("main", "tracks: hall.tracks", "tracks: ¦hall"),
        ("middle", "graph: middle", "‡graph: middle"),
        ("middle", "outputs: {tracks: inner.tracks, forecast: inner.forecast}\n", ""),
    ),
    "unknown input": wrong(
        'graph "middle", used as "hall", has no input "frame"',
        'did you mean "frames"?',
        ("main", "{frames: eyes}", "{¦frame: eyes}"),
        ("middle", "graph: middle", "‡graph: middle"),
    ),
    "unknown input two levels down": wrong(
        'graph "tracker", used as "hall/inner", has no input "picture"',
        "inputs: frames, hint",
        ("middle", "{graph: tracker.yaml}", "{graph: tracker.yaml, in: {¦picture: eye}}"),
        ("main", "  hall:", "  ‡hall:"),
        ("tracker", "graph: tracker", "‡graph: tracker"),
    ),
    "input that an interface feeds into an unknown one": wrong(
        'graph "tracker", used as "hall/inner", has no input "picture"',
        "inputs: frames, hint",
        ("middle", "frames: inner.frames", "frames: inner.picture"),
        ("main", "{frames: eyes}", "{¦frames: eyes}"),
        ("tracker", "graph: tracker", "‡graph: tracker"),
    ),
    "input that nothing feeds": wrong(
        'input "frames" of sub-graph "hall" is fed by nothing',
        "name a stage",
        ("main", "frames: eyes", "frames: ¦[]"),
    ),
    "unknown parameter": wrong(
        'graph "middle", used as "hall", has no parameter "levle"',
        'did you mean "level"?',
        ("main", "level: 0.75", "¦levle: 0.75"),
        ("middle", "graph: middle", "‡graph: middle"),
    ),
    "wrong value two levels down": wrong(
        '"level" of stage "hall/inner/detect" (toy.detect) cannot be 7',
        "least brightness",
        ("main", "level: 0.75", "level: ¦7"),
        ("middle", "level: inner.level", "level: ‡inner.level"),
        ("tracker", "level: detect.level", "level: ‡detect.level"),
    ),
    "parameter that the stage lacks": wrong(
        'stage "hall/inner/detect" (toy.detect) has no parameter "levle"',
        'did you mean "level"?',
        ("main", "level: 0.75", "¦level: 0.75"),
        ("middle", "level: inner.level", "level: ‡inner.level"),
        ("tracker", "level: detect.level", "level: ‡detect.levle"),
    ),
    "two parameters for one value": wrong(
        'parameters "level" and "other" of sub-graph "hall" both set inner.level',
        "give one of them",
        ("main", "level: 0.75", "level: 0.75, ¦other: 0.5"),
        ("middle", "params: {level: inner.level", "params: {level: inner.level, other: ‡inner.level"),
    ),
    "two inputs for one port": wrong(
        'inputs "frames" and "again" of sub-graph "hall" both feed inner',
        "connect one of them",
        ("main", "frames: eyes", "frames: eyes, ¦again: eyes"),
        ("middle", "inputs: {", "inputs: {again: ‡inner.frames, "),
    ),
    "an input for a port of a replaced stage": wrong(
        'inputs "frames" and "hint" of sub-graph "hall/inner" both feed camera',
        "connect one of them",
        ("main", "frames: eyes", "frames: eyes, ¦hint: eyes"),
        ("tracker", "hint: extra.hint", "hint: ‡camera.hint"),
    ),
    "a value for a replaced stage": wrong(
        'parameter "level" of sub-graph "hall/inner" sets "camera.frames"',
        "this stage is replaced by an input",
        ("main", "level: 0.75", "¦level: 7"),
        ("middle", "level: inner.level", "level: ‡inner.level"),
        ("tracker", "level: detect.level", "level: ‡camera.frames"),
    ),
    "an input of another type two levels down": wrong(
        '"truth" gives Truth, but input "frame" of stage "hall/inner/detect" takes Frame',
        "name a stage that gives Frame",
        KNOWING,
        ("main", "frames: eyes", "frames: ¦truth"),
        ("tracker", "frame: camera", "frame: ‡camera"),
    ),
    "an output of another type": wrong(
        '"hall/inner/track.forecast" gives Forecast, but input "tracks" of stage "save" takes Tracks',
        "outputs of hall/inner/track",
        ("main", "tracks: hall.tracks", "tracks: ¦hall.forecast"),
        ("middle", "forecast: inner.forecast", "forecast: ‡inner.forecast"),
        ("tracker", "forecast: track.forecast, blobs", "forecast: ‡track.forecast, blobs"),
    ),
    "a cycle through a sub-graph": wrong(
        "the stages hall/inner/extra -> hall/inner/track -> hall/inner/extra wait for each other",
        "delay one edge",
        ("main", "frames: eyes", "frames: eyes, hint: ¦hall.tracks"),
        ("middle", "tracks: inner.tracks", "tracks: ‡inner.tracks"),
        ("tracker", "tracks: track.tracks", "tracks: ‡track.tracks"),
    ),
    "an input that passes through itself": wrong(
        "this input is fed from itself: hall/camera -> hall.frames -> hall/camera",
        "feed it from a stage",
        ("main", "middle.yaml, in: {frames: eyes}, with", "tracker.yaml, in: {frames: ¦hall.frames}, with"),
        ("tracker", "blobs: detect}", "frames: ‡camera}"),
    ),
    "an inner stage that is not there": wrong(
        'there is no stage "hall/inner/trakc"',
        'did you mean "hall/inner/track"?',
        ("main", "tracks: hall.tracks", "tracks: ¦hall/inner/trakc.tracks"),
    ),
    "a required input that is not connected": wrong(
        'stage "hall/inner/detect" (toy.detect) needs the input "frame"',
        "add in: {frame: STAGE}",
        ("main", "in: {frames: eyes}, ", ""),
        ("tracker", "frames: camera", "frames: detect.frame"),
        ("tracker", "in: {frame: camera, forecast", "in: {forecast"),
        ("tracker", "  detect:", "  ¦detect:"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "two sub-graphs that write one file": wrong(
        'stages "hall/inner/keep" and "save" write the same file tracks.csv',
        "give each its own path",
        ("main", "in: {tracks: hall.tracks}}", "in: {tracks: hall.tracks}, with: {path: ¦tracks.csv}}"),
        ("tracker", "  pair:", "  keep: {uses: toy.save, in: {tracks: track}}\n  pair:"),
    ),
    # the interface, from inside
    "output that names a missing stage": wrong(
        'outputs: tracks names the stage "trakc", which the graph lacks',
        'did you mean "track"?',
        ("tracker", "tracks: track.tracks", "tracks: ¦trakc.tracks"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "output that names a missing port": wrong(
        'stage "hall/inner/track" has no output "trakcs"',
        'did you mean "tracks"?',
        ("main", "tracks: hall.tracks", "tracks: ¦hall.tracks"),
        ("middle", "tracks: inner.tracks", "tracks: ‡inner.tracks"),
        ("tracker", "tracks: track.tracks", "tracks: ‡track.trakcs"),
    ),
    "output that stands for several": wrong(
        "outputs: tracks stands for STAGE or STAGE.PORT, not a list",
        "outputs: {tracks: STAGE.PORT}",
        ("middle", "tracks: inner.tracks", "tracks: ¦[inner.tracks, inner.tracks]"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "parameter without the name of one": wrong(
        'params: level stands for STAGE.PARAMETER, or a list of them, not "inner"',
        "params: {level: STAGE.PARAMETER}",
        ("middle", "level: inner.level", "level: ¦inner"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "input that stands for nothing": wrong(
        "inputs: frames stands for STAGE, STAGE.PORT, or a list of them, not an empty list",
        "inputs: {frames: STAGE.PORT}",
        ("middle", "frames: inner.frames", "frames: ¦[]"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "parameters of an interface that are no mapping": wrong(
        "params is a mapping of names to values, not a list",
        "params: {NAME: VALUE}",
        ("tracker", "params: {level: detect.level, model: [track.model]}", "params: ¦[detect.level]"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "outputs of an interface that are no mapping": wrong(
        'outputs is a mapping of names to values, not "track"',
        "outputs: {NAME: VALUE}",
        ("tracker", "{tracks: track.tracks, forecast: track.forecast, blobs: detect}", "¦track"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a parameter of an interface that nobody sets": wrong(
        'stage "hall/inner/detect" has no parameter "levle"',
        'did you mean "level"?',
        ("main", ", with: {level: 0.75}", ""),
        ("tracker", "level: detect.level", "level: ¦detect.levle"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "an input of an interface that nobody feeds": wrong(
        'stage "hall/inner/extra" has no input "hitn"',
        'did you mean "hint"?',
        ("tracker", "hint: extra.hint", "hint: ¦extra.hitn"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "an output of an interface that nobody reads": wrong(
        'stage "hall/cam0/inner/track" has no output "forcast"',
        'did you mean "forecast"?',
        ("main", "{graph: middle.yaml", "{each: cameras, graph: middle.yaml"),
        ("main", "tracks: hall.tracks", "tracks: hall/cam0/inner/track.tracks"),
        ("tracker", "forecast: track.forecast, blobs", "forecast: ¦track.forcast, blobs"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "an output of an interface that is a sink": wrong(
        'stage "hall/inner/keep" (toy.save) is a sink and has no outputs',
        "remove it from the interface",
        ("tracker", "blobs: detect}", "blobs: ¦keep}"),
        ("tracker", "  pair:", "  keep: {uses: toy.save, in: {tracks: track}, with: {path: k.csv}}\n  pair:"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a parameter of an interface that a sub-graph lacks": wrong(
        'sub-graph "hall/inner" has no parameter "levle"',
        'did you mean "level"?',
        ("main", ", with: {level: 0.75}", ""),
        ("middle", "level: inner.level", "level: ¦inner.levle"),
        ("tracker", "graph: tracker", "‡graph: tracker"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "an input of an interface that is one of a source": wrong(
        'stage "hall/inner/camera" (toy.camera) is a source and has no inputs',
        "remove it",
        ("main", "{frames: eyes}", "{¦frames: eyes}"),
        ("middle", "frames: inner.frames", "frames: ‡inner.frames"),
        ("tracker", "frames: camera", "frames: ‡camera.frame"),
    ),
    "odd name in an interface": wrong(
        '"le.vel" cannot be a name among the params',
        "use 1 to 100 letters, digits, _ and -",
        ("middle", "{level: inner.level}", "{¦le.vel: inner.level}"),
        ("main", "  hall:", "  ‡hall:"),
        ("main", ", with: {level: 0.75}", ""),
    ),
    "an interface of the graph itself that names a missing port": wrong(
        'stage "save" has no input "trakcs"',
        'did you mean "tracks"?',
        ("main", "room: room.yaml", "room: room.yaml\ninputs: {more: ¦save.trakcs}"),
    ),
    "an interface of the graph itself that names a missing parameter": wrong(
        'stage "save" has no parameter "paht"',
        'did you mean "path"?',
        ("main", "room: room.yaml", "room: room.yaml\nparams: {file: ¦save.paht}"),
    ),
    "an interface of the graph itself that names what a sub-graph lacks": wrong(
        'sub-graph "hall" has no output "trakcs"',
        'did you mean "tracks"?',
        ("main", "room: room.yaml", "room: room.yaml\noutputs: {tracks: ¦hall.trakcs}"),
        ("middle", "graph: middle", "‡graph: middle"),
    ),
    # files that use each other
    "recursion": wrong(
        "files use each other: middle.yaml -> tracker.yaml -> middle.yaml",
        "remove one use",
        ("tracker", "{uses: toy.any, in: {blobs: pair}}", "{graph: ¦middle.yaml}"),
        ("tracker", ", hint: extra.hint", ""),
        ("middle", ", hint: inner.hint", ""),
        ("tracker", "in: {blobs: extra}", "in: {blobs: pair}"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a graph that uses itself": wrong(
        "files use each other: main.yaml -> main.yaml",
        "remove one use",
        ("main", "graph: middle.yaml", "graph: ¦main.yaml"),
    ),
    "an overlay of itself": wrong(
        "files use each other: over.yaml -> over.yaml",
        "remove one use",
        over="extends: ¦over.yaml\n",
    ),
    "a base that uses its overlay": wrong(
        "files use each other: over.yaml -> main.yaml -> over.yaml",
        "remove one use",
        ("main", "graph: middle.yaml", "graph: ¦over.yaml"),
        over="extends: ‡main.yaml\n",
    ),
    "a file that is not there": wrong(
        "trackr.yaml: No such file or directory",
        "paths are relative to this file",
        ("middle", "tracker.yaml", "¦trackr.yaml"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "no file": wrong(
        "graph names a graph file, not 7", "graph: FILE.yaml", ("main", "graph: middle.yaml", "graph: ¦7")
    ),
    # keys and names
    "a stage that is a plugin and a graph": wrong(
        'sub-graph "hall" has no key "uses"',
        "keys: cameras, each, graph, in, optional, with",
        ("main", "{graph: middle.yaml", "{graph: middle.yaml, ¦uses: toy.any"),
    ),
    "a stage and a stage of a sub-graph of one name": wrong(
        'stage "hall/inner/pair" is declared twice',
        "rename one",
        ("main", "  save:", "  ¦hall/inner/pair: {uses: toy.any}\n  save:"),
        ("tracker", "  pair:", "  ‡pair:"),
    ),
    "an instance and a stage of a sub-graph of one name": wrong(
        '"hall/inner/detect/cam0" names an instance of stage "hall/inner/detect" and another stage',
        "rename one",
        ("main", "  save:", f"  ¦hall/inner/detect/cam0: {ANY}\n  save:"),
        ("tracker", "  detect:", "  ‡detect:"),
    ),
    "a name that is too long": wrong(
        "cannot be the name of a stage",
        "use 1 to 100 letters, digits",
        ("main", "  save:", f"  ¦{'/'.join(['part'] * 50)}: {ANY}\n  save:"),
    ),
    # cameras and fan-out
    "no selector": wrong(
        '"kind=color"',
        "cameras[kind=color]",
        ("main", "{graph: middle.yaml", '{cameras: ¦"kind=color", graph: middle.yaml'),
    ),
    "a selector of something else": wrong(
        'cameras cannot be "targets"',
        "cameras[zone=hall]",
        ("main", "{graph: middle.yaml", "{cameras: ¦targets, graph: middle.yaml"),
    ),
    "cameras that the room lacks": wrong(
        'sub-graph "hall" serves cameras[name=cam7], and the room "stage" has none',
        "name is one of: cam0, cam1; or write optional: true",
        ("main", "in: {frames: eyes}, ", ""),
        ("main", "{graph: middle.yaml", "{cameras: ¦'cameras[name=cam7]', graph: middle.yaml"),
    ),
    "cameras that are none of those around": wrong(
        'sub-graph "hall/inner" serves cameras[name=cam1, kind=color], and the room "stage" has none',
        "each condition fits something, and nothing fits all of them; or write optional: true",
        ("main", "{graph: middle.yaml", "{cameras: 'cameras[kind=color]', graph: middle.yaml"),
        ("middle", "{graph: tracker.yaml}", "{graph: tracker.yaml, cameras: ¦'cameras[name=cam1]'}"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a member of a fan-out without cameras": wrong(
        'sub-graph "hall/hall" serves cameras[kind=infrared, zone=hall], and the room "stage" has none',
        "each condition fits something, and nothing fits all of them; or write optional: true",
        ("main", "{graph: mid", "{each: zones, cameras: ¦'cameras[kind=infrared]', graph: mid"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: hall}\n"),
    ),
    "cameras with an unknown tag": wrong(
        'cameras of the room "stage" have no property and no tag "zon"',
        "properties and tags: host, kind, model, name",
        ("main", "{graph: middle.yaml", "{cameras: ¦'cameras[zon=hall]', graph: middle.yaml"),
    ),
    "cameras without a room": wrong(
        'sub-graph "hall" serves cameras[name=cam7], but the graph names no room',
        "add room: FILE.yaml",
        ("main", "room: room.yaml\n", ""),
        ("main", "{graph: middle.yaml", "{cameras: ¦'cameras[name=cam7]', graph: middle.yaml"),
    ),
    "a selector with several wrong conditions": wrong(
        '"kind" is no condition',
        "write PROPERTY=VALUE",
        ("main", "{graph: middle.yaml", "{cameras: ¦'cameras[kind, name]', graph: middle.yaml"),
    ),
    "a wrong selector in a file that fans out": wrong(
        '"kind" is no condition',
        "write PROPERTY=VALUE",
        ("main", "{graph: middle.yaml", "{each: cameras, graph: middle.yaml"),
        ("main", "tracks: hall.tracks", "tracks: hall/cam0/inner/track.tracks"),
        ("tracker", "toy.detect, each: cameras", "toy.detect, each: ¦'cameras[kind]'"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a wrong only": wrong(
        '"kind" is no condition',
        "write PROPERTY=VALUE",
        ("main", "  save:", f"  look: {ONLY}\n  save:"),
    ),
    "a wrong tag of the room that a fan-out needs": wrong(
        "tag zone cannot be a mapping",
        "a word: letters, digits, _ and -",
        ("main", "{graph: middle.yaml", "{each: zones, graph: middle.yaml"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: ¦{a: b}}\n"),
    ),
    "a wrong tag of the room and a part of a member": wrong(
        "tag zone cannot be a mapping",
        "a word: letters, digits, _ and -",
        ("main", "{graph: middle.yaml", "{each: zones, graph: middle.yaml"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: ¦{a: b}}\n"),
        option="hall/attic/inner/detect.level=0.5",
    ),
    "two uses of a file that writes": wrong(
        'stages "more/inner/keep" and "hall/inner/keep" write the same file k.csv',
        "give each its own path",
        ("tracker", "  pair:", f"  keep: {KEEP}, with: {{path: ¦k.csv}}}}\n  pair:"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", f"  ‡more: {MORE}\n  ‡hall:"),
    ),
    "a value of a tag that no camera carries": wrong(
        'sub-graph "hall" serves cameras[zone=hal], and the room "stage" has none',
        "zone is one of: hall; or write optional: true",
        ("main", "{graph: middle.yaml", "{cameras: ¦'cameras[zone=hal]', graph: middle.yaml"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: hall}\n"),
    ),
    "sinks of many cameras with one file": wrong(
        'stages "more/cam0" and "more/cam1" and 1 more write the same file tracks.csv',
        "give each its own path",
        ("main", "  save:", "  ¦more: {uses: toy.save, each: cameras, in: {tracks: hall.tracks}}\n  save:"),
    ),
    "one wrong file that is used twice": wrong(
        'outputs: tracks names the stage "trakc", which the graph lacks',
        'did you mean "track"?',
        ("tracker", "tracks: track.tracks", "tracks: ¦trakc.tracks"),
        ("middle", "  inner:", "  ‡other: {graph: tracker.yaml}\n  inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a fan-out over a tag that the room lacks": wrong(
        'the room "stage" has no zones',
        "cameras",
        ("main", "{graph: middle.yaml", "{each: ¦zones, graph: middle.yaml"),
    ),
    "a fan-out over nothing": wrong(
        'sub-graph "hall" fans out over cameras[name=cam7], and the room "stage" has none',
        "name is one of: cam0, cam1; or write optional: true",
        ("main", "{graph: middle.yaml", "{each: ¦'cameras[name=cam7]', graph: middle.yaml"),
    ),
    "instances that are not there": wrong(
        'no instance of stage "eyes" serves cameras[name=cam7]',
        "change the selector",
        ("main", "frames: eyes", "frames: {from: ¦eyes, only: 'cameras[name=cam7]'}"),
        ("tracker", "frame: camera", "frame: ‡camera"),
    ),
    # the room: members, tags and tunes
    "an unknown tag": wrong(
        'cameras of the room "stage" have no property and no tag "zon"',
        'did you mean "zone"?',
        ("main", "each: cameras}", "each: ¦'cameras[zon=hall]'}"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: hall}\n"),
    ),
    "an empty fan-out": wrong(
        'stage "eyes" needs a sensor that the room "stage" lacks',
        "sensors matches none of: no sensors; or write optional: true",
        ("main", "each: cameras}", "each: ¦sensors}"),
    ),
    "an empty fan-out over a tag": wrong(
        'stage "eyes" needs a zone that the room "stage" lacks',
        "zones[name=attic] matches none of: hall",
        ("main", "each: cameras}", "each: ¦'zones[name=attic]'}"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: hall}\n"),
    ),
    "a condition without a value": wrong(
        '"kind" is no condition',
        "write PROPERTY=VALUE",
        ("main", "each: cameras}", "each: ¦'cameras[kind]'}"),
    ),
    "members that do not meet": wrong(
        'stage "late" serves camera cam1, stage "eyes" does not',
        "give both the same each",
        ("main", "each: cameras}", "each: 'cameras[name=cam0]'}"),
        ("main", "hall: {graph: middle.yaml", "hall: {cameras: 'cameras[name=cam0]', graph: middle.yaml"),
        ("main", "  save:", f"  late: {LATE}\n  save:"),
    ),
    "a zone that no camera of the sender carries": wrong(
        'stage "late" serves zone attic, stage "hall/inner/detect" does not',
        "give both the same each",
        ("main", "  save:", f"  late: {ZONED}\n  save:"),
        ("room", "truth:", "sensors: {imu: {kind: imu, tags: {zone: attic}}}\ntruth:"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: hall}\n"),
    ),
    "a zone that the room lacks": wrong(
        'stage "late" needs a zone that the room "stage" lacks',
        "zones[name=attic] matches none of: hall",
        ("main", "  save:", f"  late: {LATE.replace('¦', '')[:-1]}, serves: ¦'zones[name=attic]'}}\n  save:"),
        ("room", "kind: color\n", "kind: color\n    tags: {zone: hall}\n"),
    ),
    "a stage that serves another set": wrong(
        "toy.imu serves one sensor, but stage \"hand\" fans out over cameras",
        "write each: sensors",
        ("main", "  save:", "  hand: {uses: toy.imu, each: ¦cameras}\n  save:"),
    ),
    "an optional stage whose reader needs it": wrong(
        'input "blobs" of stage "needs" needs what is left out',
        'the room has no cameras[kind=thermal]; write optional: true for "needs", too',
        ("main", "  save:", "  needs: {uses: toy.any, in: {¦blobs: maybe}}\n  save:"),
        ("main", "  save:", "  maybe: {uses: toy.detect, each: ‡'cameras[kind=thermal]', optional: true,"
         " in: {frame: eyes}}\n  save:"),
    ),
    "a sensor that is mounted on nothing": wrong(
        'sensor imu is mounted on target "gren", which the room lacks',
        'did you mean "green"?',
        ("room", "truth:", "sensors: {imu: {kind: imu, mount: {target: ¦gren}}}\ntruth:"),
    ),
    "a sensor with the name of a camera": wrong(
        '"cam0" names a sensor and a camera',
        "rename one",
        ("room", "truth:", "sensors: {¦cam0: {kind: imu}}\ntruth:"),
    ),
    "a sensor without a source": wrong(
        'sensor "imu" has no source, and stage "hand" needs it',
        "add source: {uses: STAGE",
        ("main", "  save:", "  hand: {uses: room.source, each: sensors}\n  save:"),
        ("room", "truth:", "sensors: {¦imu: {kind: imu}}\ntruth:"),
    ),
    "a source for what has none": wrong(
        'stage "hand" uses room.source but serves no camera and no sensor',
        "add each: cameras, or each: sensors",
        ("main", "  save:", "  ¦hand: {uses: room.source, each: targets}\n  save:"),
    ),
    "a tag that selectors use for something else": wrong(
        '"kind" cannot be a tag',
        "write another word",
        ("room", "kind: color\n", "kind: color\n    tags: {¦kind: hall}\n"),
    ),
    "two tunes of one parameter": wrong(
        'tune one parameter of "hall/inner/detect/cam0"',
        "remove one, or write hall/inner/detect/cam0.level",
        ("room", "truth:", "tune: {‡hall/inner/detect.level: 0.5, ¦toy.detect/cam0.level: 0.25}\ntruth:"),
    ),
    "a tune of an unknown parameter": wrong(
        'toy.detect has no parameter "levle"',
        'did you mean "level"?',
        ("room", "truth:", "tune: {¦toy.detect.levle: 0.5}\ntruth:"),
        ("tracker", "detect: {uses: toy.detect", "detect: {uses: ‡toy.detect"),
    ),
    "a tune out of range": wrong(
        '"level" of stage "hall/inner/detect" (toy.detect) cannot be 7',
        "least brightness",
        ("room", "truth:", "tune: {toy.detect.level: ¦7}\ntruth:"),
    ),
    "a tune that names no parameter": wrong(
        '"level" names no parameter',
        "PLUGIN.STAGE.PARAMETER",
        ("room", "truth:", "tune: {¦level: 0.5}\ntruth:"),
    ),
    # overlays
    "an overlay that removes what is read": wrong(
        'stage "hall" is removed, but read by: save',
        "feed them from another stage, or remove them too",
        ("main", "tracks: hall.tracks", "tracks: ‡hall.tracks"),
        over="extends: main.yaml\nstages: {¦hall: null}\n",
    ),
    "an overlay that removes what an interface names": wrong(
        'stage "track" is removed, but read by: detect, params: model, outputs: tracks, outputs: forecast',
        "feed them from another stage",
        ("tracker", "{from: track.forecast, delay: 1}", "‡{from: track.forecast, delay: 1}"),
        over="extends: tracker.yaml\nstages: {¦track: null}\n",
    ),
    "an overlay that removes nothing": wrong(
        'there is no stage "hal" to remove',
        'did you mean "hall"?',
        over="extends: main.yaml\nstages: {¦hal: null}\n",
    ),
    "an overlay whose stage lacks an input": wrong(
        'stage "save" has no input "blobs"',
        "inputs: tracks",
        over="extends: main.yaml\nstages: {save: {in: {¦blobs: hall.tracks}}}\n",
    ),
    "an overlay of another type below": wrong(
        '"hall/inner/track.tracks" gives Tracks, but input "blobs" of stage "save" takes Blobs',
        "outputs of hall/inner/track",
        ("main", "toy.save, in: {tracks: hall.tracks}", "toy.pair, in: {blobs: ¦hall.tracks}"),
        ("middle", "tracks: inner.tracks", "tracks: ‡inner.tracks"),
        ("tracker", "tracks: track.tracks", "tracks: ‡track.tracks"),
        over="extends: ‡main.yaml\n",
    ),
    "a parameter that was lost with the old stage": wrong(
        'stage "track" (toy.track_again) needs the parameter "model"',
        "add with: {model: ...}",
        over="extends: tracker.yaml\nstages: {track: {uses: ¦toy.track_again}}\n",
    ),
    # options
    "an option for a stage that is not there": wrong(
        'the graph has no stage "hall/inner/detekt"',
        'did you mean "hall/inner/detect"?',
        option="¦hall/inner/detekt.level=1",
    ),
    "an option for an unknown parameter of an interface": wrong(
        'graph "middle", used as "hall", has no parameter "levle"',
        'did you mean "level"?',
        ("middle", "graph: middle", "‡graph: middle"),
        option="hall.¦levle=1",
    ),
    "an option for one member that is the same for all": wrong(
        '"hall/cam0" is one member of a sub-graph; cameras is the same for all',
        "write hall.cameras=...",
        ("main", "{graph: middle.yaml", "{each: cameras, graph: middle.yaml"),
        option="¦hall/cam0.cameras=targets",
    ),
    "an option for a replaced stage": wrong(
        'stage "hall/inner/camera" is replaced by an input',
        "set the stage that feeds this input",
        ("main", "frames: eyes", "frames: ‡eyes"),
        option="¦hall/inner/camera.frames=3",
    ),
}  # fmt: skip


def marked(text: str, mark: str, file: str) -> list[tuple[str, int, int]]:
    """File, line and column of each mark."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        plain = line.replace("¦" if mark == "‡" else "‡", "")
        found += [(file, number, plain.index(mark) + 1)] if mark in plain else []
    return found


def compiled(folder: Path, case: Wrong) -> tuple[Mistake, ...]:
    files = {**FILES, **({"over": case.over} if case.over else {})}
    for name, old, new in case.changes:
        assert old in files[name], f"{name} has no {old!r}"
        files[name] = files[name].replace(old, new, 1)
    write(folder, **{name: text.replace("¦", "").replace("‡", "") for name, text in files.items()})
    options = [case.option.replace("¦", "")] if case.option else []
    with pytest.raises(InputError) as caught:
        compile_graph(
            folder / f"{'over' if case.over else 'main'}.yaml", overrides=options, plugin_files=[TOY]
        )
    return caught.value.mistakes


@pytest.mark.parametrize("case", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_in_composition_is_one_error_with_both_places(tmp_path: Path, case: Wrong) -> None:
    found = compiled(tmp_path, case)
    assert len(found) == 1, "\n".join(map(str, found))
    (mistake,) = found
    assert case.text in mistake.text
    assert case.remedy in mistake.remedy
    texts = {**FILES, "over": case.over}
    for name, old, new in case.changes:
        texts[name] = texts[name].replace(old, new, 1)
    marks = {
        mark: [
            *(place for name, text in texts.items() for place in marked(text, mark, f"{name}.yaml")),
            *marked(case.option, mark, "--set"),
        ]
        for mark in "¦‡"
    }
    place = mistake.place
    assert place is not None
    assert [(Path(place.file).name, place.line, place.column)] == marks["¦"]
    seen = {(Path(p.file).name, p.line, p.column) for p in place.outer_places}
    assert seen >= set(marks["‡"]), str(mistake)
    shown = mistake.render()
    assert all(f"see {tmp_path / file}:{line}:{column}" in shown for file, line, column in marks["‡"])


def test_forty_mistakes_are_held() -> None:
    assert len(MISTAKES) >= 40


def test_files_that_unfold_without_end_are_refused_at_once(tmp_path: Path) -> None:
    """Each of 18 files uses the next one twice: a quarter of a million stages, if nothing stopped it."""
    files = {
        f"f{n}": f"stages: {{a: {{graph: f{n + 1}.yaml}}, b: {{graph: f{n + 1}.yaml}}}}\n" for n in range(18)
    }
    write(tmp_path, **files, f18="stages: {x: {uses: toy.knowing}}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "f0.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert mistake.text == "more than 100 files, 1000 uses of files or 100000 values are used"


@pytest.mark.parametrize("key", ["extends: f{n}.yaml\n", "stages: {{a: {{graph: f{n}.yaml}}}}\n"])
def test_a_chain_of_files_has_a_limit(tmp_path: Path, key: str) -> None:
    write(tmp_path, **{f"f{n}": key.format(n=n + 1) for n in range(40)}, f40="stages: {}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "f0.yaml")
    (mistake,) = caught.value.mistakes
    assert mistake.text == "files use each other more than 20 levels deep"
    assert mistake.place is not None
    assert Path(mistake.place.file).name == "f19.yaml"


def test_many_files_with_many_values_have_a_limit(tmp_path: Path) -> None:
    value = "y" * 4000  # counts as 40 values
    large = "stages:\n" + "".join(f"  s{n}: {{with: {{x: {value}}}}}\n" for n in range(200))
    uses = "stages:\n" + "".join(f"  g{n}: {{graph: large.yaml}}\n" for n in range(90))
    write(tmp_path, main=uses, large=large)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml")
    (mistake,) = caught.value.mistakes
    assert "100000 values" in mistake.text


def test_an_input_of_two_stages_that_cannot_be_read_is_one_mistake(tmp_path: Path) -> None:
    both = TRACKER.replace("inputs: {", "inputs: {extra: [detect.forecast, pair.blobs], ")
    assert both != TRACKER
    text = "stages: {hall: {graph: tracker.yaml, in: {extra: [null]}}}\nroom: room.yaml\n"
    write(tmp_path, main=text, tracker=both, room=ROOM)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert mistake.text == "an input is fed from STAGE or STAGE.PORT, not nothing"


@pytest.mark.parametrize("content", ["\x01", "graph: a\n---\ngraph: b\n", "stages: [a]\n"])
def test_a_used_file_that_cannot_be_read_is_one_mistake_with_the_place_of_its_use(
    tmp_path: Path, content: str
) -> None:
    write(tmp_path, main="stages: {hall: {graph: used.yaml}}\n", used=content)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml")
    (mistake,) = caught.value.mistakes
    assert mistake.place is not None
    assert Path(mistake.place.file).name == "used.yaml"
    assert mistake.place.outer is not None
    assert Path(mistake.place.outer.file).name == "main.yaml"


@pytest.mark.parametrize("value", ["null", "[cam0, cam1]"])
def test_a_selector_that_cannot_be_read_is_named_by_its_key(tmp_path: Path, value: str) -> None:
    write(tmp_path, main=f"room: room.yaml\nstages: {{hall: {{graph: tracker.yaml, cameras: {value}}}}}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert mistake.text.startswith("cameras cannot be ")
    assert mistake.help == 'write for example "cameras[kind=color]"'
