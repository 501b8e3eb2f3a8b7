"""Each mistake about cameras, members, tags and tunes gives one error with its places and a remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.wrong_compositions import Wrong, check, wrong

LATE = "{uses: toy.detect, each: 'cameras[name=cam1]', in: {frame: ¦eyes}}"
ZONED = "{uses: toy.pair, each: zones, in: {blobs: ¦hall/inner/detect}}"
KEEP = "{uses: toy.save, in: {tracks: track}"
MORE = "{graph: middle.yaml, in: {frames: eyes}}"
ONLY = "{uses: toy.detect, in: {frame: {from: eyes, only: ¦'cameras[kind]'}}}"
MISTAKES = {
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
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_about_what_a_room_has_is_one_error_with_all_places(tmp_path: Path, case: Wrong) -> None:
    check(tmp_path, case)
