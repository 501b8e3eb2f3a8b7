"""Each mistake in the use of a sub-graph gives one error with the places at both ends and a remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.wrong_compositions import Wrong, check, wrong

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
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_in_the_use_of_a_sub_graph_is_one_error(tmp_path: Path, case: Wrong) -> None:
    check(tmp_path, case)
