"""Mistakes in how stages are connected, and in their parameters."""

from __future__ import annotations

from tests.core.graph.broken_case import Broken


def _rates(feed: str, text: str, remedy: str = "") -> Broken:
    """A stage with inputs of all kinds, one of which is fed like this."""
    more = f"  rates: {{uses: toy.rates, in: {{blobs: pair, {feed}}}}}\n  save:"
    return Broken("graph", "  save:", more, text, remedy)


_PAIR = "pair: {uses: toy.pair, in: {blobs: detect}}"

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
    Broken(
        "graph",
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: tracks.csv}}",
        "  again: {uses: toy.save, in: {tracks: track}, with: {path: ¦d/e/a.csv}}\n"
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: d}}",
        'stage "again" writes d/e/a.csv, but d is the file of stage "save" and no folder',
        "give it a path in another folder",
    ),
    Broken(
        "graph",
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: tracks.csv}}",
        "  save: {uses: toy.save, in: {tracks: track}, with: {path: ¦log.jsonl/a.csv}}",
        'stage "save" writes log.jsonl/a.csv, but log.jsonl is the log of the run and no folder',
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
