"""Ends of Zenoh edges find each other before a run begins, whatever a new link swallows."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from followspot.graph.compile import compile_graph
from followspot.messages import Message
from followspot.plugins.registry import use_plugin_files
from followspot.transport.zenoh.edge import open_session
from followspot.worker.edge_links import EdgeLinks, uses_zenoh

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"
PAIR = """
graph: g
stages:
  a: {uses: ticks.count}
  b: {uses: ticks.write, in: {number: a}}
"""
CAUGHT = "  c: {uses: ticks.write, in: {number: b}}\n"


def test_a_reader_that_waits_for_the_start_says_again_that_it_is_there(tmp_path: Path) -> None:
    """What it said first may never have reached a writer that still looks for it."""
    (tmp_path / "g.yaml").write_text(PAIR)
    use_plugin_files([str(TICKS)])
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    heard: list[str] = []
    with open_session() as session:
        links = EdgeLinks(plan, {}, {}, session, "run")
        ends = links.reader(0, Message), links.writer([0], "zenoh")
        links.wait_matched()
        session.declare_subscriber("**/credit/**", lambda sample: heard.append(str(sample)))
        time.sleep(0.1)
        before = len(heard)
        links.remind()
        deadline = time.monotonic() + 20.0
        while len(heard) == before and time.monotonic() < deadline:
            time.sleep(0.01)
        assert len(heard) > before
        for end in ends:
            end.close()


def test_only_workers_at_an_edge_over_zenoh_need_a_session(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(PAIR.replace("b: {uses: ticks.write,", "b: {uses: ticks.add,") + CAUGHT)
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="ring")
    assert not uses_zenoh(plan)
    assert not uses_zenoh(plan, "a")
    first, *others = plan.edges
    assert (first.from_stage, first.to_stage) == ("a", "b")
    mixed = replace(plan, edges=(replace(first, kind="zenoh"), *others))
    assert uses_zenoh(mixed)
    assert [uses_zenoh(mixed, worker) for worker in "abc"] == [True, True, False]
