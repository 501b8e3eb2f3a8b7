"""Ends of Zenoh edges find each other before a run begins, whatever a new link swallows."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

from tests.core.worker.pair import PAIR, TICKS, with_another_edge
from tests.integration.running import wait_until

from followspot.graph.compile import compile_graph
from followspot.messages import Message
from followspot.plugins.registry import use_plugin_files
from followspot.transport.edge import PortReader
from followspot.transport.token import Token, Watermark
from followspot.transport.zenoh.edge import open_session
from followspot.worker.build import build_worker
from followspot.worker.ledger import Ledger
from followspot.worker.taps.published_ports import published
from followspot.worker.wiring import RunOptions, Wiring
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

CAUGHT = "  c: {uses: ticks.write, in: {number: b}}\n"


def test_a_reader_that_waits_for_the_start_says_again_that_it_is_there(tmp_path: Path) -> None:
    """What it said first may never have reached a writer that still looks for it."""
    (tmp_path / "g.yaml").write_text(PAIR)
    use_plugin_files([str(TICKS)])
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    heard: list[str] = []
    with open_session() as session:
        edge_factory = WorkerEdgeFactory(plan, {}, {}, session, "run")
        ends = edge_factory.reader(0, Message), edge_factory.writer([0], "zenoh")
        edge_factory.wait_matched()
        session.declare_subscriber("**/credit/**", lambda sample: heard.append(str(sample)))
        time.sleep(0.1)
        before = len(heard)
        edge_factory.zenoh.announce_again()
        deadline = time.monotonic() + 60.0
        while len(heard) == before and time.monotonic() < deadline:
            time.sleep(0.01)
        assert len(heard) > before
        for end in ends:
            end.close()


def test_an_edge_that_came_later_has_its_own_stream_from_the_start(tmp_path: Path) -> None:
    """While the former edge of the port is still there."""
    (tmp_path / "g.yaml").write_text(PAIR)
    use_plugin_files([str(TICKS)])
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    with open_session() as session:
        edge_factory = WorkerEdgeFactory(plan, {}, {}, session, "run")
        reader, writer = edge_factory.reader(0, Message), edge_factory.writer([0], "zenoh")
        edge_factory.wait_matched()
        writer.send(Watermark(5))
        more = edge_factory.for_plan(with_another_edge(plan))
        later, _ = more.reader(1, Message), more.writer([1], "zenoh")
        more.wait_matched(lambda: True)
        writer.send(Watermark(6))
        assert poll(reader) == [Watermark(5), Watermark(6)]
        assert later.poll() == []
        assert later.rejected == 0
        more.forget()
        assert not list(session.liveliness().get("**/alive/**/1/0")), "nothing is left of a failed attempt"
        again = edge_factory.for_plan(with_another_edge(plan))
        last, sender = again.reader(1, Message), again.writer([1], "zenoh")
        again.wait_matched(lambda: True)
        sender.send(Watermark(7))
        assert poll(last) == [Watermark(7)], "after an attempt that failed"
        last.report_at_once(True)
        assert wait_until(lambda: sender.all_taken)
        for end in (reader, writer, last, sender):
            end.close()


def test_the_end_of_an_attempt_ends_the_wait_for_other_ends(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(PAIR)
    use_plugin_files([str(TICKS)])
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    with open_session() as session:
        edge_factory = WorkerEdgeFactory(plan, {}, {}, session, "run")
        edge_factory.writer([0], "zenoh")
        asked = iter([True, True, False])
        edge_factory.wait_matched(lambda: next(asked))
        edge_factory.forget()


def test_a_port_is_published_if_no_edge_puts_its_messages_on_its_own_key(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(PAIR)
    use_plugin_files([str(TICKS)])
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="zenoh")
    with open_session() as session:
        edge_factory = WorkerEdgeFactory(plan, {}, {}, session, "run")
        scheduler = build_worker(Wiring(plan), "a", Ledger(2), RunOptions(tmp_path), edge_factory)
        assert published(edge_factory, scheduler) == []
        later = edge_factory.for_plan(with_another_edge(plan))
        (port,) = published(later, scheduler)
        assert published(later, scheduler, [port]) == [], "once"
        scheduler.close()


def poll(reader: PortReader) -> list[Token]:
    """What comes next to a reader."""
    found: list[Token] = []
    assert wait_until(lambda: found.extend(reader.poll()) or found)
    return found


def test_only_workers_at_an_edge_over_zenoh_need_a_session(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(PAIR.replace("b: {uses: ticks.write,", "b: {uses: ticks.add,") + CAUGHT)
    plan = compile_graph(tmp_path / "g.yaml", placement="stage", plugin_files=[TICKS], edges="ring")
    assert not plan.uses_zenoh()
    assert not plan.uses_zenoh("a")
    first, *others = plan.edges
    assert (first.from_stage, first.to_stage) == ("a", "b")
    mixed = replace(plan, edges=(replace(first, kind="zenoh"), *others))
    assert mixed.uses_zenoh()
    assert [mixed.uses_zenoh(worker) for worker in "abc"] == [True, True, False]
