"""Every way to get a graph, a room or a placement wrong, with the place and the words of the mistake.

A case replaces a piece of a good file; ¦ in the new piece marks where the mistake must be reported.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Broken:
    """In `file`, `old` became `new`; `text` and `remedy` are parts of what must be said."""

    file: str
    old: str
    new: str
    text: str
    remedy: str = ""


def _rates(feed: str, text: str, remedy: str = "") -> Broken:
    """A stage with inputs of all kinds, one of which is fed like this."""
    more = f"  rates: {{uses: toy.rates, in: {{blobs: pair, {feed}}}}}\n  save:"
    return Broken("graph", "  save:", more, text, remedy)


_PAIR = "pair: {uses: toy.pair, in: {blobs: detect}}"
_ANY = "{uses: toy.any, in: {blobs: pair}}\n  "
_CAM = """\
    kind: color
    size: [320, 240]
    matrix: [[250, 0, 160], [0, 250, 120], [0, 0, 1]]
    distortion: [0.1, 0, 0, 0, 0]
    rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    translation: [0, 0, 3]
"""
_SOURCE = "    source: {uses: toy.camera, with: {frames: 20}}\n"

SYNTAX = [
    Broken("graph", "seed: 7", "params: {x: y.z\nseed¦: 7", "not valid YAML", "flow mapping"),
    Broken("graph", "seed: 7", "¦\tseed: 7", "a tab stands here, and YAML indents by spaces"),
    Broken("graph", "seed: 7", "seed: 7\n¦seed: 8", 'the key "seed" stands here twice', "first in line 4"),
    Broken("graph", "pair: {uses", "pair: {uses: toy.any, ¦uses", 'the key "uses" stands here twice'),
    Broken("graph", "  save:", "  ¦track:", 'the key "track" stands here twice', "keep one"),
    Broken("graph", "seed: 7", "seed: ¦*seven", 'no anchor "&seven" stands before this alias'),
    Broken("graph", "seed: 7", "seed: ¦!!python/object:os.system 7", "tag tag:yaml.org,2002:python/object"),
    Broken("graph", "seed: 7", "? ¦[a, b]\n: 7", "a key must be text"),
    Broken("graph", "seed: 7", "seed: 7\n¦---\nmore: 1", "a second document begins here"),
    Broken("graph", "seed: 7", "seed: " + "[" * 49 + "¦[" + "]" * 50, "nested more than 50 deep"),
    Broken("room", "room: stage", "room: ¦\x07", "this character is not allowed in YAML"),
    Broken("room", "room: stage", "room: stage\n¦<<: 5", '"<<" merges mappings only'),
]

ENVELOPE = [
    Broken("graph", "seed: 7", "¦sead: 7", 'a graph has no key "sead"', 'did you mean "seed"?'),
    Broken("graph", "seed: 7", "seed: ¦-7", "seed cannot be -7", "a whole number from 0"),
    Broken("graph", "seed: 7", "params: ¦[least]", "params is a mapping of names to values, not a list"),
    Broken("graph", "each: cameras, in", "¦eech: cameras, each: cameras, in", 'has no key "eech"', '"each"'),
    Broken("graph", _PAIR, "¦pair: {in: {blobs: detect}}", 'stage "pair" lacks "uses"', "add uses: ..."),
    Broken("graph", _PAIR, "pair: ¦toy.pair", 'is a mapping of keys to values, not "toy.pair"', "keys: uses"),
    Broken(
        "graph",
        _PAIR,
        '¦"a//b": {uses: toy.any, in: {blobs: pair}}\n  ' + _PAIR,
        '"a//b" cannot be the name of a stage',
        "letters, digits",
    ),
    Broken(
        "graph",
        _PAIR,
        "¦a.b: {uses: toy.any, in: {blobs: pair}}\n  " + _PAIR,
        '"a.b" cannot be the name of a stage',
    ),
    Broken(
        "graph",
        "uses: toy.pair,",
        "uses: toy.pair, on_error: ¦ignore,",
        'cannot be "ignore"',
        "fail, restart",
    ),
    Broken(
        "graph",
        "uses: toy.pair,",
        "uses: toy.pair, tolerance: ¦-1,",
        "tolerance cannot be -1",
        "from 0 to 3600",
    ),
    Broken("graph", "uses: toy.pair,", "uses: toy.pair, deadline: ¦soon,", 'deadline cannot be "soon"'),
    Broken("graph", "uses: toy.pair,", "uses: ¦12,", "uses is text, not 12", "quote"),
    Broken("graph", "room: room.yaml", "room: ¦rooms.yaml", "rooms.yaml: No such file", "--room FILE"),
    Broken("graph", "room: room.yaml", "room: ¦[room.yaml]", "room names a room file, not a list"),
    Broken("graph", "seed: 7", "extends: ¦other.yaml", "other.yaml: No such file", "relative to this file"),
    Broken("graph", "seed: 7", "extends: ¦graph.yaml", "use each other: graph.yaml -> graph.yaml"),
    Broken("graph", "seed: 7", "extends: ¦7", "extends names a graph file, not 7"),
]

EXPANSION = [
    Broken(
        "graph", "each: cameras, in", 'each: ¦"cameras[kind=depth]", in', "lacks", "cam0 (color), cam1 (infr"
    ),
    Broken("graph", "each: cameras, in", 'each: ¦"cameras[kid=color]", in', 'no tag "kid"', '"kind"'),
    Broken("graph", "each: cameras, in", 'each: ¦"cameras[color]", in', "is no condition", "PROPERTY=VALUE"),
    Broken("graph", "each: cameras, in", "each: ¦rooms, in", "has no rooms: no camera", "cameras, sensors"),
    Broken("graph", "each: cameras, in", "each: ¦a b, in", 'each cannot be "a b"', "cameras[kind=color]"),
    Broken(
        "graph",
        "each: cameras}\n  detect: {uses: toy.detect, each: cameras, in: {frame: camera,",
        'each: "cameras[host=pc-left]"}\n  detect: {uses: toy.detect, each: cameras, in: {frame: ¦camera,',
        'stage "detect" serves camera cam0, stage "camera" does not',
        "give both the same each",
    ),
    Broken(
        "graph",
        "  camera: {uses: room.source, each: cameras}",
        "  ¦camera: {uses: room.source}",
        "serves no camera",
    ),
    Broken(
        "graph", "{blobs: detect}", "{blobs: ¦detekt}", 'there is no stage "detekt"', 'did you mean "detect"?'
    ),
    Broken("graph", "{blobs: detect}", "{blobs: ¦a.b.c}", 'STAGE or STAGE.PORT, not "a.b.c"', "for example"),
    Broken("graph", "{blobs: detect}", "{blobs: ¦7}", "STAGE or STAGE.PORT, not 7"),
    Broken("graph", "{blobs: detect}", "{blobs: ¦[]}", 'input "blobs" is fed by nothing', "name a stage"),
    Broken("graph", "delay: 1", "delay: ¦-1", "delay cannot be -1", "from 0 to 1000"),
    Broken("graph", "delay: 1", "delay: 1, depth: ¦0", "depth cannot be 0", "from 1 to 10000"),
    Broken(
        "graph",
        "delay: 1",
        "delay: 1, policy: ¦newest",
        'policy cannot be "newest"',
        "block, drop_oldest, latest",
    ),
    Broken(
        "graph",
        "delay: 1",
        "delay: 1, policy: ¦drop_oldst",
        "policy cannot be",
        'did you mean "drop_oldest"?',
    ),
    Broken("graph", "delay: 1", "delay: 1, policy: ¦latest", "cannot be latest", "the policy or the delay"),
    Broken(
        "graph",
        "{from: track.forecast, delay: 1}",
        "¦track.forecast",
        'samples "track.forecast" in the cycle track -> detect -> pair -> track',
        "delay it: {from: track.forecast, delay: 1}",
    ),
    Broken("graph", "delay: 1", "delay: 1, ¦dept: 4", 'an input has no key "dept"', '"depth"'),
    Broken(
        "graph",
        "forecast: {from: track.forecast, delay: 1}",
        "¦forecast: {delay: 1}",
        'an input lacks "from"',
    ),
]

PORTS = [
    Broken("graph", "uses: toy.pair,", "uses: ¦toy.peir,", 'no stage "toy.peir" is installed', '"toy.pair"'),
    Broken("graph", "{blobs: detect}", "{¦blob: detect, blobs: detect}", 'has no input "blob"', '"blobs"?'),
    Broken("graph", _PAIR, "¦pair: {uses: toy.pair}", 'needs the input "blobs"', "add in: {blobs: STAGE}"),
    Broken("graph", "{tracks: track}", "{tracks: ¦track.trax}", 'has no output "trax"', '"tracks"?'),
    Broken(
        "graph",
        "{tracks: track}",
        "{tracks: ¦pair}",
        '"pair" gives Blobs, but input "tracks" of stage "save"',
    ),
    Broken(
        "graph",
        "{tracks: track}",
        "{tracks: ¦track.forecast}",
        '"track.forecast" gives Forecast',
        "outputs of",
    ),
    Broken("graph", "{tracks: track}", "{tracks: ¦save}", 'stage "save" is a sink and has no outputs'),
    Broken(
        "graph",
        "  track: {uses: toy.track, in: {blobs: pair}",
        "  split: {uses: toy.split, in: {blobs: pair}}\n  track: {uses: toy.track, in: {blobs: ¦split}",
        'stage "split" has several outputs of type Blobs',
        "left (Blobs), right (Blobs)",
    ),
    Broken(
        "graph", "{blobs: pair}", "{¦blobs: detect}", "takes one message, 2 come", "detect/cam0, detect/cam1"
    ),
    _rates("window: {from: pair, delay: ¦1}", 'input "window" of stage "rates" is a Window', "Latest[Blobs]"),
    Broken("graph", _PAIR, _PAIR[:-1] + ", depth: ¦4}", "is no live source and has no depth of its own"),
    _rates("near: {from: pair, delay: ¦2}", "goes by capture time and has no delay", "Latest[Blobs]"),
    _rates("near: {from: pair, tolerance: ¦-1}", "tolerance cannot be -1", "a number from 0 to 3600"),
    _rates("latest: {from: pair, tolerance: ¦1}", "is a Latest and matches no times", "remove the tolerance"),
    _rates("latest: {from: pair, delay: 1, tolerance: ¦1}", "has a delay and matches no times"),
    _rates("window: ¦rates", "the stages rates -> rates wait for each other", "{from: rates, delay: 1}"),
    Broken(
        "graph", "{frame: camera,", "{frame: ¦track,", "has no output of type Frame", "tracks (Tracks), for"
    ),
    Broken("graph", "each: cameras}", "each: cameras, in: {¦frame: pair}}", "is a source and has no inputs"),
    Broken(
        "graph",
        _PAIR,
        "pair: {uses: toy.pair, in: {blobs: [detect, ¦echo]}}\n  echo: {uses: toy.any, in: {blobs: pair}}",
        "the stages pair -> echo -> pair wait for each other",
        "delay one edge: {from: echo, delay: 1}",
    ),
    Broken(
        "graph",
        _PAIR,
        "pair: {uses: toy.pair, in: {blobs: [detect, ¦pair]}}",
        "the stages pair -> pair wait for each other",
    ),
    Broken(
        "graph",
        "camera: {uses: room.source, each: cameras",
        "¦camera: {uses: toy.camera",
        "serves one camera",
        "add each: cameras",
    ),
    Broken(
        "graph",
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: tracks.csv}}",
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: ¦log.jsonl}}",
        'stage "save" writes log.jsonl, which is the log of the run',
        "give it another path",
    ),
    Broken(
        "graph",
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: tracks.csv}}",
        "  again: {uses: toy.save, in: {tracks: track}}\n"
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: ¦tracks.csv}}",
        'stages "again" and "save" write the same file tracks.csv',
    ),
]

PARAMETERS = [
    Broken(
        "graph", "model: constant", "¦modle: constant, model: constant", 'no parameter "modle"', '"model"?'
    ),
    Broken(
        "graph",
        "uses: toy.track, in: {blobs: pair}, with: {model: constant}",
        "uses: ¦toy.track, in: {blobs: pair}",
        'needs the parameter "model"',
        "name of the motion model",
    ),
    Broken(
        "graph",
        "model: constant",
        "model: ¦7",
        '"model" of stage "track" (toy.track) cannot be 7',
        "motion model",
    ),
    Broken(
        "graph",
        "uses: toy.detect,",
        "uses: toy.detect, with: {level: ¦0},",
        "must be greater than 0",
        "least bri",
    ),
    Broken("graph", "uses: toy.detect,", "uses: toy.detect, with: {level: ¦2},", "less than or equal to 1"),
    Broken(
        "graph",
        "uses: toy.detect,",
        "uses: toy.detect, with: {level: ¦high},",
        "cannot be 'high'",
        "brightness",
    ),
    Broken(
        "graph", "uses: toy.detect,", "uses: toy.detect, with: {start: ¦hot},", "must be 'cold' or 'warm'"
    ),
    Broken(
        "graph",
        "uses: toy.detect,",
        "uses: toy.detect, with: {weights: [1, ¦x]},",
        '"weights.1"',
        "per channel",
    ),
    Broken(
        "graph",
        "uses: toy.detect,",
        "uses: toy.detect, with: {mood: {¦gian: 2}},",
        '"mood.gian"',
        "remove it",
    ),
    Broken(
        "graph",
        "uses: toy.detect,",
        "uses: toy.detect, with: ¦7,",
        "with is a mapping of names to values, not 7",
    ),
    Broken(
        "graph", "path: tracks.csv", "path: ¦../tracks.csv", "is not below the output folder", "without .."
    ),
    Broken("graph", "path: tracks.csv", "path: ¦/etc/passwd", "is not below the output folder"),
    Broken(
        "room",
        "with: {frames: 20}",
        "with: {frames: ¦0}",
        '"frames" of stage "camera" (toy.camera) cannot be 0',
    ),
    Broken(
        "room", "with: {frames: 20}", "with: {¦fames: 20}", 'no parameter "fames"', 'did you mean "frames"?'
    ),
    Broken(
        "room",
        "with: {frames: 20}",
        "with: {path: ¦cam0.mkv}",
        "which does not exist",
        "relative to the file",
    ),
    Broken("room", "path: truth.csv", "path: ¦truht.csv", "which does not exist"),
]

ROOM = [
    Broken("room", "room: stage", "room: stage\n¦camera: {}", 'a room has no key "camera"', '"cameras"?'),
    Broken(
        "room",
        "    kind: color\n",
        "    knd: color\n    kind: color\n".replace("knd", "¦knd"),
        'has no key "knd"',
    ),
    Broken("room", "  cam0:\n    kind: color\n", "  ¦cam0:\n", 'camera cam0 lacks "kind"'),
    Broken("room", "[0, 0, 3]", "[0, 0, ¦{a: 1}]", "holds a mapping", ""),
    Broken("room", "kind: color", "kind: ¦a b", 'kind cannot be "a b"', "one word"),
    Broken(
        "room", "kind: color", "kind: color\n    model: ¦pinhol", 'model cannot be "pinhol"', '"pinhole"?'
    ),
    Broken(
        "room",
        "kind: color",
        "kind: depth\n    model: ¦cylinder",
        "a depth camera cannot be a cylinder",
        "pinhole, rational, or fisheye",
    ),
    Broken("room", "size: [320, 240]", "size: ¦[320]", "size has 2 numbers, not 1"),
    Broken("room", "size: [320, 240]", "size: ¦[320, 0]", "whole pixels", "each from 1 to 32768"),
    Broken("room", "[[250, 0, 160]", "[[¦fx, 0, 160]", 'matrix holds "fx" where a finite number belongs'),
    Broken("room", "[[250, 0, 160]", "¦[[-250, 0, 160]", "this is no camera matrix", "positive fx and fy"),
    Broken(
        "room", "[[250, 0, 160]", "¦[[250, 160]", "matrix has 3 x 3 numbers, not rows of different length"
    ),
    Broken("room", "[0.1, 0, 0, 0, 0]", "¦[0.1, 0]", "distortion has 5 or 4 numbers, not 2"),
    Broken("room", "[0.1, 0, 0, 0, 0]", "[0.1, ¦.nan, 0, 0, 0]", "distortion holds nan"),
    Broken("room", "[[1, 0, 0], [0, 1, 0]", "¦[[1, 0, 0], [0, 2, 0]", "rows are not orthogonal unit vectors"),
    Broken("room", "[[1, 0, 0], [0, 1, 0]", "¦[[-1, 0, 0], [0, 1, 0]", "but a reflection", "negate one row"),
    Broken(
        "room",
        "    host: pc-left",
        "    clock_offset: ¦15",
        "clock_offset cannot be 15",
        "write a number from -1 to 1",
    ),
    Broken("room", "translation: [0, 0, 3]", "translation: ¦3", "translation is a list of 3 numbers, not 3"),
    Broken(
        "room",
        "  cam0:\n" + _CAM + _SOURCE,
        "  ¦cam0:\n" + _CAM,
        'camera "cam0" has no source, and stage "camera" needs it',
        "add source:",
    ),
    Broken(
        "room",
        "{uses: toy.camera, with: {frames: 20}}",
        "{uses: ¦toy.camra}",
        'no stage "toy.camra"',
        "toy.camera",
    ),
    Broken("room", "floor: [0, 0, 1, 0]", "floor: ¦[0, 0, 2, 0]", "has length 2, not 1", "divide all four"),
    Broken("room", "floor: [0, 0, 1, 0]", '¦"my floor": [0, 0, 1, 0]', "cannot be a name", "letters, digits"),
    Broken(
        "room", "floor: [0, 0, 1, 0]", f"¦{'f' * 101}: [0, 0, 1, 0]", "cannot be a name", "1 to 100 letters"
    ),
    Broken("room", "radius: 0.0762", "radius: ¦0", "radius cannot be 0", "greater than 0"),
    Broken("room", "  green:\n    radius: 0.0762\n", "  ¦green:\n", 'target green lacks "radius"'),
    Broken(
        "room",
        "{cam0: [12, 140]}",
        "{¦cam9: [12, 140]}",
        'the room has no camera "cam9"',
        "cameras: cam0, cam1",
    ),
    Broken(
        "room",
        "{cam0: [12, 140]}",
        "{cam0: ¦[140, 12]}",
        "area for cam0 cannot be [140, 12]",
        "[smallest, lar",
    ),
    Broken("room", "{cam0: [1, 0, 0,", "{cam0: ¦[1, 0,", "hue_histogram for cam0 has 16 numbers, not 15"),
    Broken("room", "{cam0: [1, 0,", "{cam0: ¦[1, -1,", "has a bin below 0"),
    Broken("room", "{cam0: [1, 0,", "{cam0: ¦[0, 0,", "has no bin above 0"),
    Broken(
        "room",
        "uses: toy.knowing, with: {path: truth.csv}",
        "uses: ¦toy.camera",
        "is a source of Truth or PoseTruth, and toy.camera",
    ),
]

PLACEMENT = [
    Broken(
        "placement", "workers:", "¦wrokers: {}\nworkers:", 'a placement has no key "wrokers"', '"workers"?'
    ),
    Broken("placement", "placement: two", "¦by: stage", "either by or workers", "remove one"),
    Broken(
        "placement", "stages: [save]", "stages: [¦saev]", 'there is no stage "saev"', 'did you mean "save"?'
    ),
    Broken("placement", "cameras: [cam1]", "cameras: [¦cam7]", 'there is no camera "cam7"', "cam0, cam1"),
    Broken(
        "placement",
        "[detect/cam0]",
        "[detect/cam0, ¦save]",
        'stage "save" is placed twice',
        'worker "left" has it',
    ),
    Broken(
        "placement",
        "stages: [save]",
        "stages: ¦save",
        'stages is a list of names, not "save"',
        "stages: [NAME",
    ),
    Broken("placement", "stages: [save]", "¦stage: [save]", 'worker "left" has no key "stage"', '"stages"?'),
    Broken(
        "placement",
        "  right:",
        "  ¦empty: {host: pc}\n  right:",
        'worker "empty" runs nothing',
        "or remove it",
    ),
    Broken("placement", "  right:", '  ¦"a b":', '"a b" cannot be the name of a worker'),
    Broken("placement", "host: pc-left", "host: ¦7", "host is text, not 7", "quote"),
]

ALL = [*SYNTAX, *ENVELOPE, *EXPANSION, *PORTS, *PARAMETERS, *ROOM, *PLACEMENT]
