"""Mistakes in the syntax and the keys of files, and in what stages fan out over."""

from __future__ import annotations

from tests.core.graph.broken_case import Broken

_PAIR = "pair: {uses: toy.pair, in: {blobs: detect}}"

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
