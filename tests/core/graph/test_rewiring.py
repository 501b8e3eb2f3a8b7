"""A file with other stages and edges in the place of a sub-graph: the plan that a new start would have."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, after, by_name, edges, names, planned, stage, travelled
from tests.core.graph.subgraph_files import EACH, SHARED, TWO, WING, WINGS, ZONED

from followspot.errors import FollowspotError, InputError
from followspot.graph.change.difference import only_worker
from followspot.graph.change.stages import change_of
from followspot.graph.plan import Plan, PlannedWorker
from followspot.graph.plan_data import plan_to_data
from followspot.host.worker_pool import WorkerPool

SMOOTHED = TRACKER.replace("outputs: {tracks: track.tracks", "outputs: {tracks: second.tracks") + (
    "  second: {uses: toy.track, in: {blobs: pair}, with: {model: constant}}\n"
)
PER_CAMERA = TRACKER.replace(
    "pair: {uses: toy.pair, in: {blobs: detect}}", "pair: {uses: toy.pair, in: {blobs: more}}"
)
PER_CAMERA += "  more: {uses: toy.detect, each: cameras, in: {frame: camera}}\n"
SHORT = """\
graph: tracker
params: {level: seen.level}
inputs: {frames: camera}
outputs: {tracks: whole.tracks, blobs: seen}
stages:
  camera: {uses: room.source, each: cameras}
  seen: {uses: toy.detect, each: cameras, in: {frame: camera}}
  both: {uses: toy.pair, in: {blobs: seen}}
  whole: {uses: toy.track, in: {blobs: both}, with: {model: constant}}
"""
BY_INTERFACE = EACH.replace("tracker/stage/track.tracks", "tracker/stage.tracks")
POLITE = TRACKER.replace("{model: constant}}", "{model: constant}, on_error: skip, tolerance: 0.2}")
OPEN = TRACKER.replace(", forecast: {from: track.forecast, delay: 1}", "")
OTHER_PORT = TRACKER.replace("blobs: detect}\nstages", "blobs: pair}\nstages")


@pytest.mark.parametrize(
    ("main", "file"),
    [
        *product([SHARED, BY_INTERFACE, TWO, WINGS], [SMOOTHED, PER_CAMERA, SHORT]),
        *product([SHARED], [POLITE, OPEN, OTHER_PORT]),
    ],
)
def test_the_plan_is_that_of_a_new_start_with_the_file(tmp_path: Path, main: str, file: str) -> None:
    wing = WING if file is not SHORT else WING.replace("tracks: inner.tracks, ", "")
    plan = travelled(planned(tmp_path, main, room=ZONED, wing=wing, other=file))
    uses = [use.name for use in plan.subgraphs if use.stage != "wing"]
    found = after(plan, *(f"{name}={tmp_path / 'other.yaml'}" for name in uses))
    fresh = travelled(planned(tmp_path, main, room=ZONED, wing=wing, tracker=file))
    assert {s.name: s for s in found.stages} == {s.name: s for s in fresh.stages}
    assert Counter(found.edges) == Counter(fresh.edges)
    assert by_name(found.subgraphs) == by_name(fresh.subgraphs)
    assert found.offered == fresh.offered
    order = {name: rank for rank, name in enumerate(names(found))}
    assert all(order[e.from_stage] < order[e.to_stage] for e in found.edges if not e.delay)


def test_an_edge_that_stays_keeps_its_number_and_one_that_goes_is_known(tmp_path: Path) -> None:
    plan = travelled(planned(tmp_path, SHARED, other=SMOOTHED))
    found = after(plan, f"hall={tmp_path / 'other.yaml'}")
    before = dict(plan.numbered())
    assert {number: edge for number, edge in found.numbered() if number in before} == {
        number: edge for number, edge in before.items() if edge in found.edges
    }
    assert [edge.name for _, edge in found.former] == ["hall/track.tracks -> save.tracks"]
    assert found.rows == len(plan.edges) + 2, "hall/pair -> hall/second, and hall/second -> save"
    back = after(found, f"hall={tmp_path / 'tracker.yaml'}")
    assert sorted(edges(back)) == sorted(edges(plan))
    assert len({number for number, _ in (*back.numbered(), *back.former)}) == back.rows == found.rows + 1


def test_what_set_gave_a_stage_that_stays_is_kept(tmp_path: Path) -> None:
    plan = travelled(planned(tmp_path, SHARED, "hall/detect.start=warm", other=SMOOTHED))
    plan = after(plan, "hall/detect/cam1.level=0.75")
    found = after(plan, f"hall={tmp_path / 'other.yaml'}", "hall/second.model=quick")
    assert stage(found, "hall/detect/cam1").params["level"] == 0.75
    assert stage(found, "hall/detect/cam0").params["start"] == "warm"
    assert stage(found, "hall/second").params["model"] == "quick"
    assert "while it ran: hall/second: came (toy.track)" in found.notes


def apart(plan: Plan, *names_: str) -> Plan:
    """The plan with these stages in a worker of their own."""
    stages = tuple(replace(s, worker="far") if s.name in names_ else s for s in plan.stages)
    where = {s.name: s.worker for s in stages}
    kinds = {
        edge: replace(edge, kind="ring") if where[edge.from_stage] != where[edge.to_stage] else edge
        for edge in plan.edges
    }
    workers = (*plan.workers, PlannedWorker("far"))
    return replace(plan, stages=stages, workers=workers, edges=tuple(kinds[e] for e in plan.edges))


def test_a_new_stage_comes_where_those_of_its_member_are(tmp_path: Path) -> None:
    plan = apart(planned(tmp_path, SHARED, other=PER_CAMERA), "eyes/cam0", "hall/detect/cam0")
    found = after(plan, f"hall={tmp_path / 'other.yaml'}")
    assert {s.name: s.worker for s in found.stages if "/more" in s.name} == {
        "hall/more/cam0": "far",
        "hall/more/cam1": "main",
    }
    kinds = {edge.name: edge.kind for edge in found.edges}
    assert kinds["hall/more/cam0.out -> hall/pair.blobs"] == "ring"
    assert kinds["eyes/cam0.out -> hall/more/cam0.frame"] == "reference"


@pytest.mark.parametrize(
    ("far", "worker"),
    [((), "main"), (("eyes/cam0",), None), (("save",), None), (("hall/pair", "hall/extra"), None)],
)
def test_the_worker_in_which_all_differs(tmp_path: Path, far: tuple[str, ...], worker: str | None) -> None:
    plan = apart(planned(tmp_path, SHARED, other=SMOOTHED), *far)
    assert only_worker(plan, after(plan, f"hall={tmp_path / 'other.yaml'}")) == worker


@pytest.mark.parametrize(
    ("file", "said"),
    [
        (TRACKER.replace("tracks: track.tracks", "tracks: pair"), "gives hall/pair.out (Blobs), and"),
        (SHORT.replace("tracks: whole.tracks, ", ""), 'has no output "tracks" in the file'),
        (SMOOTHED + "  log: {uses: toy.save, in: {tracks: track}}\n", 'which "save" is writing'),
        (SMOOTHED + "  odd: {uses: toy.camera, each: cameras}\n", "would begin its stream anew"),
    ],
)
def test_a_file_that_does_not_fit_the_running_graph_says_why(tmp_path: Path, file: str, said: str) -> None:
    plan = travelled(planned(tmp_path, SHARED, other=file))
    with pytest.raises(InputError) as caught:
        change_of(plan, [f"hall={tmp_path / 'other.yaml'}"])
    assert said in str(caught.value)


def test_another_sink_of_the_same_name_needs_another_file(tmp_path: Path) -> None:
    """Both would be open for a moment."""
    keep = "  keep: {uses: USES, in: {tracks: track}, with: {path: PATH}}\n"
    before = TRACKER + keep.replace("USES", "toy.save").replace("PATH", "k.csv")
    other = SMOOTHED + keep.replace("USES", "sinks.csv")
    files = {"same": other.replace("PATH", "k.csv"), "own": other.replace("PATH", "2-k.csv")}
    plan = travelled(planned(tmp_path, SHARED, tracker=before, **files))
    with pytest.raises(InputError) as caught:
        change_of(plan, [f"hall={tmp_path / 'same.yaml'}"])
    assert 'stage "hall/keep" would write k.csv, which "hall/keep" is writing' in str(caught.value)
    assert stage(after(plan, f"hall={tmp_path / 'own.yaml'}"), "hall/keep").uses == "sinks.csv"


def test_a_ledger_without_a_row_for_a_new_edge_refuses(tmp_path: Path) -> None:
    plan = travelled(planned(tmp_path, SHARED, other=SMOOTHED))
    found = after(plan, f"hall={tmp_path / 'other.yaml'}")
    pool = WorkerPool.__new__(WorkerPool)
    pool._rows = found.rows
    pool.check_rows(plan_to_data(found))
    pool._rows -= 1
    with pytest.raises(FollowspotError, match="has had 1024 new edges"):
        pool.check_rows(plan_to_data(found))
