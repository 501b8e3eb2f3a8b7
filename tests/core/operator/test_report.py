"""Errors of a run whose workers all ended cleanly."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

from followspot.control.worker_report import WorkerReport
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.operator.reporting.report import merge
from followspot.transport.token import Invalid
from followspot.worker.inputs.input_queue import InputQueue
from followspot.worker.ledger import AWAY, DELIVERED, INVALID, PRODUCED, UNMATCHED, Ledger
from followspot.worker.reporting.report import missing

TICKS = Path(__file__).parents[2] / "stages" / "ticks.py"


def planned(folder: Path, source: str) -> Plan:
    path = folder / "g.yaml"
    path.write_text(
        f"graph: g\nstages:\n  a: {{uses: ticks.{source}}}\n  b: {{uses: ticks.write, in: {{number: a}}}}\n"
    )
    return compile_graph(path, placement="stage", plugin_files=[TICKS])


def errors(plan: Plan, away: int, restarts: dict[str, int] | None = None, error: str = "") -> tuple[str, ...]:
    """The errors of a run in which `away` of ten messages were sent while their reader was absent."""
    ledger = Ledger(1)
    for column, count in ((PRODUCED, 10), (AWAY, away), (DELIVERED, 10 - away)):
        ledger.words[column] = count
    report = merge(
        plan, ledger, [WorkerReport("a", 10), WorkerReport("b", 10, error=error)], 1.0, stopped=False,
        restarts=restarts,
    )  # fmt: skip
    assert not report.unbalanced
    assert report.ok is not bool(report.errors)
    return report.errors


def test_a_replay_with_unread_messages_fails_and_names_the_edge(
    tmp_path: Path,
) -> None:
    plan = planned(tmp_path, "count")
    (line,) = errors(plan, 3)
    assert line.startswith("a.out -> b.number: 3 messages came when their reader was away")
    assert errors(plan, 0) == ()


def test_live_runs_and_runs_with_restarts_only_count_unread_messages(tmp_path: Path) -> None:
    assert errors(planned(tmp_path, "live"), 3) == ()
    assert errors(planned(tmp_path, "count"), 3, {"a": 0, "b": 1}) == ()


def test_the_error_of_a_worker_has_precedence(tmp_path: Path) -> None:
    assert errors(planned(tmp_path, "count"), 3, error="worker b died") == ("worker b died",)


def test_what_a_failed_run_left_in_its_queues_is_not_laid_to_its_joins(tmp_path: Path) -> None:
    ledger = Ledger(1)
    for column, count in ((PRODUCED, 100), (DELIVERED, 40), (UNMATCHED, 60)):
        ledger.words[column] = count
    plan = planned(tmp_path, "count")

    def warnings(error: str) -> tuple[str, ...]:
        workers = [WorkerReport("a", 100), WorkerReport("b", 100, error=error)]
        return merge(plan, ledger, workers, 1.0, stopped=False).warnings

    assert warnings("messages were lost on their way") == ()
    (line,) = warnings("")
    assert "60 of 100 messages found no partner" in line


def test_lost_and_damaged_messages_are_distinguished() -> None:
    ledger = Ledger(2)
    queues = [
        InputQueue(name, ledger.words, ledger.row(n), depth=4, lateness=0)
        for n, name in enumerate(("a -> b", "a -> c"))
    ]
    for queue in queues:
        queue.reader = SimpleNamespace(consumed=lambda count=1: None)  # type: ignore[assignment]
        queue.accept(Invalid("it is of another type"))
    worker = SimpleNamespace(ends=SimpleNamespace(readers=queues))
    assert missing(worker) == ""  # type: ignore[arg-type]
    for _ in range(2):
        queues[1].accept(Invalid("gap", missing=True))
    assert missing(worker).startswith("a -> c: 2 messages were lost on their way")  # type: ignore[arg-type]
    assert [ledger.words[ledger.row(n) + INVALID] for n in range(2)] == [1, 3]
