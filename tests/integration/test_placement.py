"""Placement never changes the result: workers and kinds of edge, on a graph with joins, gaps and feedback."""

from __future__ import annotations

from itertools import accumulate
from pathlib import Path

import pytest
from tests.integration.running import STAGES, Finished, balanced, run, write_graph

GRAPH = """
left:   {uses: ticks.count, with: {count: 60, size: 9000}}
right:  {uses: ticks.count, with: {count: 55, shift: 2000000, skip: 7}}
more:   {uses: ticks.add, in: {number: left}, with: {term: 3}}
odd:    {uses: ticks.odd, in: {number: right}}
sort:   {uses: ticks.sort, in: {number: more}}
sum:    {uses: ticks.sum, in: {numbers: [more, odd, sort.even]}}
loop:   {uses: ticks.accumulate, in: {number: sum, before: {from: loop, delay: 2}}}
both:   {uses: ticks.both, in: {left: more, right: odd}}
save:   {uses: ticks.write, in: {number: loop}}
pairs:  {uses: ticks.write, in: {number: both}, with: {path: pairs.csv}}
"""
TWO = """
placement: two
workers:
  one: {stages: [left, more, loop]}
  two: {stages: [right, sum, save]}
"""
WAYS = [
    ("--placement", "stage"),
    ("--placement", "two.yaml"),
    ("--edges", "ring"),
    ("--edges", "zenoh"),
    pytest.param(("--placement", "stage", "--edges", "zenoh"), marks=pytest.mark.thorough),
]


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """The graph in one process."""
    return run(write_graph(tmp_path_factory.mktemp("once"), GRAPH))


@pytest.mark.parametrize("options", WAYS, ids=" ".join)
def test_every_placement_and_kind_of_edge_gives_the_same_bytes(
    once: Finished, tmp_path: Path, options: tuple[str, ...]
) -> None:
    graph = write_graph(tmp_path, GRAPH)
    (tmp_path / "two.yaml").write_text(TWO)
    options = tuple(str(tmp_path / o) if o.endswith(".yaml") else o for o in options)
    other = run(graph, *options)
    assert once.code == other.code == 0, once.errors + other.errors
    assert len(once.lines()) == 60
    for name in ("ticks.csv", "pairs.csv"):
        assert (other.out / name).read_bytes() == (once.out / name).read_bytes()
    assert balanced(once.summary)
    assert balanced(other.summary)
    counts = [{k: e[k] for k in e if k != "kind"} for e in once.summary["edges"]]
    assert [{k: e[k] for k in e if k != "kind"} for e in other.summary["edges"]] == counts


def test_forced_edges_have_the_forced_kind(tmp_path: Path) -> None:
    graph = write_graph(tmp_path, GRAPH)
    for kind in ("reference", "ring", "zenoh"):
        finished = run(graph, "--edges", kind, "--frames", "3", out=kind)
        assert {edge["kind"] for edge in finished.summary["edges"]} == {kind}, finished.errors


def test_latest_in_a_loop_of_a_live_run_is_the_newest_message(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.live, with: {count: 5}}
loop: {uses: ticks.accumulate, in: {number: a, before: loop}}
save: {uses: ticks.write, in: {number: loop}}
""",
    )
    finished = run(graph)
    numbers = [int(line.split(",")[0]) for line in finished.lines()]
    assert numbers, finished.errors
    assert finished.values() == list(accumulate(numbers))


def test_feedback_of_two_firings_ago(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
a:    {uses: ticks.count, with: {count: 6}}
loop: {uses: ticks.accumulate, in: {number: a, before: {from: loop, delay: 2}}}
save: {uses: ticks.write, in: {number: loop}}
""",
    )
    assert run(graph).values() == [0, 1, 2, 4, 6, 9]


def test_a_message_that_names_what_is_not_there_is_refused_in_every_placement(tmp_path: Path) -> None:
    graph = write_graph(
        tmp_path,
        """
see:  {uses: unfit.see}
save: {uses: sinks.csv, in: {seen: see}, with: {path: seen.csv}}
""",
    )
    plugin = ("--plugin", str(STAGES.with_name("unfit.py")))
    for kind in ("reference", "ring"):
        finished = run(graph, "--edges", kind, *plugin, out=kind)
        assert [line.split(",")[2] for line in finished.lines("seen.csv")] == ["name", "ball", "lamp", "lamp"]
        assert finished.edge("see", "save")["invalid"] == 1
        assert "see: name holds -1 to -1, where 0 to 1 can be" in finished.errors
