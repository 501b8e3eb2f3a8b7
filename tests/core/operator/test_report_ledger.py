"""The ledger in a report: messages in flight at a death are lost, other unaccounted ones are an error."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from tests.integration.running import balanced

from followspot.control.host import HostStatus, WorkerStatus
from followspot.control.worker_report import WorkerReport
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedWorker
from followspot.operator.reporting import summary
from followspot.operator.reporting.report import RunReport, merge, summed_ledger
from followspot.operator.run_view import RunView
from followspot.worker.ledger import COLUMNS, DELIVERED, PRODUCED, SOURCE_LOSSES

TICKS = str(Path(__file__).parents[2] / "stages" / "ticks.py")


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    (tmp_path / "graph.yaml").write_text(
        "graph: g\nstages:\n  a: {uses: ticks.count}\n  save: {uses: ticks.write, in: {number: a}}\n"
    )
    return compile_graph(tmp_path / "graph.yaml", plugin_files=[TICKS])


def report(plan: Plan, produced: int, delivered: int, deaths: int = 0) -> RunReport:
    """The report of a run on two hosts: one counted produced messages, the other delivered ones."""
    rows = [[0] * COLUMNS, [0] * COLUMNS]
    rows[0][PRODUCED], rows[1][DELIVERED] = produced, delivered
    ended = [WorkerReport("main", 0)]
    return merge(plan, summed_ledger(rows, 1), ended, 1.0, stopped=False, restarts={"main": deaths})


def test_each_death_may_lose_the_messages_in_flight(plan: Plan) -> None:
    found = report(plan, 138, 100, deaths=2)
    assert found.ok
    assert found.edges[0][1].lost == 38


def test_further_missing_messages_are_an_error(plan: Plan) -> None:
    found = report(plan, 139, 100, deaths=2)
    assert found.unbalanced == ("a.out -> save.number: 1 messages are unaccounted for (a bug)",)
    assert not found.ok
    assert report(plan, 101, 100).unbalanced


def test_surplus_messages_are_an_error(plan: Plan) -> None:
    found = report(plan, 100, 103, deaths=2)
    assert found.unbalanced == (
        "a.out -> save.number: 3 messages were accounted for beyond those that were sent (a bug)",
    )
    count = found.edges[0][1]
    assert (count.produced, count.sent, count.in_flight) == (103, 103, 0), "no column is negative"


def test_what_a_stranger_may_have_sent_is_not_called_a_bug(plan: Plan) -> None:
    over_zenoh = replace(plan, edges=tuple(replace(edge, kind="zenoh") for edge in plan.edges))
    (line,) = report(over_zenoh, 100, 103).unbalanced
    assert line.endswith(
        "beyond those that were sent; "
        "if a warning says that it refused something, a stranger sent on it, else it is a bug"
    )
    assert not report(over_zenoh, 100, 103).ok


def test_a_ledger_that_does_not_fit_the_plan_is_left_out_and_named(plan: Plan) -> None:
    whole, other = [0] * COLUMNS, [0] * (2 * COLUMNS)
    whole[PRODUCED] = 3
    hosts = {
        "": HostStatus((), tuple(whole), age_s=0.0),
        "left": HostStatus((), tuple(other), age_s=0.1),
        "right": HostStatus((), ()),  # has not answered yet, which its status says
    }
    found = RunView(plan, hosts, begun=True).status()
    assert found.counts == tuple(whole)
    (line,) = found.news
    assert line.startswith(f"the ledger of host left is left out of the sum: it has {2 * COLUMNS} counts")


@pytest.mark.parametrize(
    ("age_s", "why"), [(0.1, "nothing is known of how it ended"), (9.0, "host left does not answer")]
)
def test_a_worker_without_a_report_was_not_there_and_its_host_tells_why(
    plan: Plan, age_s: float, why: str
) -> None:
    there = replace(plan, workers=(PlannedWorker("main", "left"),))
    host = HostStatus((WorkerStatus("main", "running"),), (0,) * COLUMNS, age_s=age_s)
    found = RunView(there, {"left": host}, begun=True).report(1.0, {}, stopped=True)
    assert found.errors == (f"worker main was not there at the end: {why}",)


def test_frames_lost_at_the_source_stand_beside_the_messages(plan: Plan) -> None:
    row = [0] * COLUMNS
    row[PRODUCED] = row[DELIVERED] = 5
    row[SOURCE_LOSSES["packet_loss"]], row[SOURCE_LOSSES["gap"]] = 3, 2
    found = merge(plan, summed_ledger([row, row], 1), [WorkerReport("main", 5)], 1.0, stopped=False)
    assert found.ok
    data = summary.data(found, {})
    assert balanced(data), "the equation is about messages"
    (edge,) = data["edges"]
    assert (edge["produced"], edge["packet_loss"], edge["device_overrun"], edge["gap"]) == (10, 6, 0, 4)
    shown = summary.text(found, "").split("frames lost at the source\n")[1].splitlines()[:2]
    assert shown[0].split() == ["source", "packet", "loss", "device", "overrun", "gap"]
    assert shown[1].split() == ["a", "6", "0", "4"]
    assert "lost at the source" not in summary.text(report(plan, 5, 5), "")
