"""Taps follow a run whose stages come and go."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from followspot.control.tapping import Tapping
from followspot.graph.compile import compile_graph
from followspot.library.run_taps import RunTaps
from followspot.operator.run_requests import RunMetadata

GRAPH = Path(__file__).parents[3] / "graphs" / "glowballs.yaml"


class Run:
    """A run that notes what is asked of it."""

    def __init__(self, out: Path) -> None:
        self.whole = self.now = compile_graph(GRAPH)
        self.out = out
        self.tapped: list[str] = []
        self.untapped: list[str] = []

    def plan(self) -> Any:
        return self.now

    def metadata(self) -> RunMetadata:
        return RunMetadata(self.out)

    def tap(self, taps: list[Tapping]) -> None:
        self.tapped += [tap.port for tap in taps]

    def untap(self, taps: list[Tapping]) -> None:
        self.untapped += [tap.port for tap in taps]


def test_a_stage_that_leaves_is_let_go_and_tapped_again_when_it_is_back(tmp_path: Path) -> None:
    run = Run(tmp_path)
    taps = RunTaps(cast(Any, run), ["fuse.positions", "track.tracks"], "recording.tap", lambda records: None)
    assert run.tapped == ["fuse.positions", "track.tracks"]
    run.now = replace(run.whole, stages=tuple(one for one in run.whole.stages if one.name != "fuse"))
    taps.follow()
    taps.follow()
    assert run.tapped == ["fuse.positions", "track.tracks"]
    run.now = run.whole
    taps.follow()
    assert run.tapped == ["fuse.positions", "track.tracks", "fuse.positions"]
    taps.close()
    assert run.untapped == ["fuse.positions", "track.tracks"]
