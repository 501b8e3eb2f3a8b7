"""A placement changes workers and the kinds of edges, and nothing else."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest
from tests.core.graph.files import HERE, ROOM, TOY, write

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedWorker


def planned(folder: Path, placement: str | None, room: str = HERE, **options: Any) -> Plan:
    graph = write(folder, room=room)
    file = placement if placement in (None, "camera", "stage") else folder / "placement.yaml"
    if isinstance(file, Path):
        file.write_text(placement or "")
    return compile_graph(graph, placement=file, plugin_files=[TOY], **options)


def workers(plan: Plan) -> dict[str, list[str]]:
    return {w.name: [s.name for s in plan.stages if s.worker == w.name] for w in plan.workers}


def kinds(plan: Plan) -> dict[str, int]:
    found = [edge.kind for edge in plan.edges]
    return {kind: found.count(kind) for kind in sorted(set(found))}


def test_without_a_placement_one_worker_runs_everything(tmp_path: Path) -> None:
    plan = planned(tmp_path, None)
    assert plan.workers == (PlannedWorker("main"),)
    assert kinds(plan) == {"reference": 8}
    assert plan.notes == ()


def test_cameras_on_other_hosts_that_run_here_are_noted(tmp_path: Path) -> None:
    assert "cam1" in planned(tmp_path, None, room=ROOM).notes[0]


def test_a_worker_per_camera_holds_all_that_serves_it_on_its_host(tmp_path: Path) -> None:
    plan = planned(tmp_path, "camera", room=ROOM)
    assert workers(plan) == {
        "cam0": ["camera/cam0", "detect/cam0"],
        "cam1": ["camera/cam1", "detect/cam1"],
        "main": ["pair", "track", "save"],
    }
    assert plan.workers[1] == PlannedWorker("cam1", "pc-left")
    assert kinds(plan) == {"reference": 4, "ring": 2, "zenoh": 2}


def test_a_worker_per_stage_holds_its_instances(tmp_path: Path) -> None:
    plan = planned(tmp_path, "stage")
    assert list(workers(plan)) == ["camera", "detect", "pair", "track", "save"]
    assert kinds(plan) == {"ring": 8}


def test_a_file_may_place_by_camera_or_stage(tmp_path: Path) -> None:
    assert workers(planned(tmp_path, "by: stage")) == workers(planned(tmp_path, "stage"))


def test_an_instance_counts_before_its_stage_and_that_before_its_camera(tmp_path: Path) -> None:
    text = "workers: {a: {cameras: [cam0]}, b: {stages: [detect]}, c: {stages: [detect/cam1, pair]}}"
    assert workers(planned(tmp_path, text)) == {
        "a": ["camera/cam0"],
        "main": ["camera/cam1", "track", "save"],
        "b": ["detect/cam0"],
        "c": ["detect/cam1", "pair"],
    }


@pytest.mark.parametrize("placement", ["camera", "stage", "workers: {a: {stages: [track]}}"])
def test_a_placement_changes_nothing_but_workers_and_kinds(tmp_path: Path, placement: str) -> None:
    alone, placed = planned(tmp_path, None), planned(tmp_path, placement)
    same_stages = tuple(dataclasses.replace(stage, worker="main") for stage in placed.stages)
    same_edges = tuple(dataclasses.replace(edge, kind="reference") for edge in placed.edges)
    assert (same_stages, same_edges, placed.seed) == (alone.stages, alone.edges, alone.seed)


@pytest.mark.parametrize(
    ("placement", "edges", "expected", "noted"),
    [
        (None, "ring", {"ring": 8}, ""),
        (None, "zenoh", {"zenoh": 8}, ""),
        (None, "reference", {"reference": 8}, ""),
        ("camera", "ring", {"ring": 8}, ""),
        ("camera", "reference", {"reference": 4, "ring": 4}, "4 edges are ring and not reference"),
    ],
)
def test_a_kind_is_forced_where_it_can_be_and_noted_where_not(
    tmp_path: Path, placement: str | None, edges: str, expected: dict[str, int], noted: str
) -> None:
    plan = planned(tmp_path, placement, edges=edges)
    assert kinds(plan) == expected
    assert "".join(plan.notes).startswith(noted)
    assert bool(plan.notes) == bool(noted)


def test_a_ring_between_hosts_becomes_zenoh_and_is_noted(tmp_path: Path) -> None:
    plan = planned(tmp_path, "camera", room=ROOM, edges="ring")
    assert kinds(plan) == {"ring": 6, "zenoh": 2}
    assert plan.notes == ("2 edges are zenoh and not ring: they join two hosts",)


def test_a_placement_that_is_no_file_is_a_mistake(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--placement:1:1: cannot read two\.yaml"):
        compile_graph(write(tmp_path, room=HERE), placement="two.yaml", plugin_files=[TOY])


@pytest.mark.parametrize("text", ["", "placement: nothing\n", "workers: {}\n"])
def test_a_placement_that_places_nothing_is_a_mistake(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError, match="placement"):
        planned(tmp_path, text)
