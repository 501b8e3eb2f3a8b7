"""Each mistake in what an interface says gives one error with the places at both ends and a remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.wrong_compositions import Wrong, check, wrong

MISTAKES = {
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
    "a parameter of an interface without a value": wrong(
        'stage "hall/inner/detect" has no parameter "levle"',
        'did you mean "level"?',
        ("main", ", with: {level: 0.75}", ""),
        ("tracker", "level: detect.level", "level: ¦detect.levle"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "an input of an interface that no stage feeds": wrong(
        'stage "hall/inner/extra" has no input "hitn"',
        'did you mean "hint"?',
        ("tracker", "hint: extra.hint", "hint: ¦extra.hitn"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "an output of an interface that no stage reads": wrong(
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
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_within_an_interface_is_one_error_with_both_places(tmp_path: Path, case: Wrong) -> None:
    check(tmp_path, case)
