"""Small graphs made of several files, for the tests."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.core.graph.files import GRAPH, ROOM, TOY

from followspot.graph.change.stages import change_of
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedStage
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.graph.subgraph_use import SubgraphUse
from followspot.operator.change_outcome import with_change

TRACKER = """\
graph: tracker
room: room.yaml
seed: 5
params: {level: detect.level, model: [track.model]}
inputs: {frames: camera, hint: extra.hint}
outputs: {tracks: track.tracks, forecast: track.forecast, blobs: detect}
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera, forecast: {from: track.forecast, delay: 1}}}
  pair: {uses: toy.pair, in: {blobs: detect}}
  extra: {uses: toy.any, in: {blobs: pair}}
  track: {uses: toy.track, in: {blobs: extra}, with: {model: constant}}
"""


def write(folder: Path, **files: str) -> None:
    """Write these files; a room, `graph.yaml` and `tracker.yaml` stand beside them."""
    for name, text in {"room": ROOM, "graph": GRAPH, "tracker": TRACKER, **files}.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    (folder / "truth.csv").write_text("", encoding="utf-8")


def planned(folder: Path, main: str, *overrides: str, **files: str) -> Plan:
    """The plan of the text `main`, which stands beside the files."""
    write(folder, main=main, **files)
    return compile_graph(folder / "main.yaml", overrides=overrides, plugin_files=[TOY])


def stage(plan: Plan, name: str) -> PlannedStage:
    """The instance of this name."""
    return next(stage for stage in plan.stages if stage.name == name)


def names(plan: Plan) -> list[str]:
    """The instances in their order."""
    return [stage.name for stage in plan.stages]


def edges(plan: Plan) -> list[str]:
    """The edges, with their delays."""
    return [edge.name + (f" delay {edge.delay}" if edge.delay else "") for edge in plan.edges]


def changed_stages(plan: Plan, words: Sequence[str], folder: Path = Path()) -> tuple[PlannedStage, ...]:
    """The stages that change, in their new form."""
    return change_of(plan, words, folder).stages


def travelled(plan: Plan) -> Plan:
    """The plan as an agent has it."""
    return plan_from_data(json.loads(json.dumps(plan_to_data(plan))))


def after(plan: Plan, *words: str) -> Plan:
    """The plan after a change, as an agent has it."""
    return travelled(with_change(plan, change_of(plan, words)))


def by_name(uses: Iterable[SubgraphUse]) -> dict[str, SubgraphUse]:
    """Uses of sub-graphs by their full names."""
    return {use.name: use for use in uses}
