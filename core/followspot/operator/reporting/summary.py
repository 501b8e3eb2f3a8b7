"""The summary of a run: accuracy, latency, ledger and warnings, as text or as JSON types."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from followspot.control.clock_status import ClockStatus
from followspot.control.path_latency import PathLatency
from followspot.graph.plan import Plan, PlannedEdge
from followspot.operator.reporting.report import RunReport
from followspot.operator.reporting.truth import scorable
from followspot.plugins.loaded_hooks import load_scorers
from followspot.tables.terminal import table
from followspot.worker.ledger import COUNTS, SOURCE_LOSSES, EdgeCount


def text(report: RunReport, accuracy: str) -> str:
    """The summary as text. accuracy: its table, empty if the truth is unknown."""
    rate = report.frames / report.seconds if report.seconds > 0 else 0.0
    workers = f"{len(report.plan.workers)} worker{'s' * (len(report.plan.workers) != 1)}"
    head = (
        f"{report.plan.graph} in {report.plan.room.name}: {report.frames} frames in {report.seconds:.2f} s, "
        f"{rate:.0f} per second, {workers}"
    )
    if report.stopped:
        head += ", stopped early" if report.frames else ", stopped before its first frame"
    parts = [head]
    if accuracy:
        parts.append(f"accuracy{_of_file(report.plan)} against ground truth\n{accuracy}")
    if any(worker.paths for worker in report.workers):
        parts.append("latency, source to sink\n" + _latency(report))
    if report.clocks:
        parts.append("clocks, offset added to the times of each host\n" + _clocks(report))
    parts.append("ledger\n" + _ledger(report))
    if lost := _lost_at_source(report):
        parts.append("frames lost at the source\n" + lost)
    if report.silences:
        lines = [line for silence in report.silences for line in (f"{silence}", f"    {silence.advice}")]
        parts.append("gave nothing\n" + _indented(lines))
    if report.plan.notes:
        parts.append("notes\n" + _indented(report.plan.notes))
    if report.warnings:
        parts.append("warnings\n" + _indented(report.warnings))
    if report.unbalanced:
        parts.append("the ledger does not add up\n" + _indented(report.unbalanced))
    if report.errors:
        parts.append("the run failed\n" + "\n".join(report.errors))
    return "\n\n".join(parts)


def data(report: RunReport, scores: Mapping[str, Any]) -> dict[str, Any]:
    """The summary in JSON types. scores: figures by scorer, empty if the truth is unknown."""
    return {
        "graph": report.plan.graph,
        "room": report.plan.room.name,
        "frames": report.frames,
        "seconds": round(report.seconds, 6),
        "stopped": report.stopped,
        "ok": report.ok,
        **{scorer.name: scores.get(scorer.name, {}) for scorer in load_scorers()},
        "scored": str(next(iter(scorable(report.plan)))) if scores else None,
        "paths": [_path_data(path) for worker in report.workers for path in worker.paths],
        "edges": [_edge_data(edge, count) for edge, count in report.edges],
        "clocks": [_clock_data(host, clock) for host, clock in report.clocks.items()],
        "workers": [worker.to_data() for worker in report.workers],
        "warnings": [*(f"{m.place}: {m.text}" for m in report.plan.warnings), *report.warnings],
        "silences": [{**asdict(silence), "text": str(silence)} for silence in report.silences],
        "notes": list(report.plan.notes),
        "errors": [*report.errors, *report.unbalanced],
    }


def _of_file(plan: Plan) -> str:
    """The file that is scored, if there are several that could be."""
    scored, *others = scorable(plan) or ("",)
    return f" of {scored} (not of {', '.join(map(str, others))})" if others else ""


def _indented(lines: Iterable[object]) -> str:
    return "\n".join(f"  {line}" for line in lines)


def _path_data(path: PathLatency) -> dict[str, Any]:
    return {
        "from": path.origin,
        "to": path.sink,
        "p50_ms": round(path.p50_ms, 4),
        "p95_ms": round(path.p95_ms, 4),
        "p99_ms": round(path.p99_ms, 4),
        "worst_ms": round(path.worst_ms, 4),
        "worst_id": path.worst_id,
        **({} if path.budget_ms is None else {"budget_ms": path.budget_ms, "late": path.late}),
    }


def _edge_data(edge: PlannedEdge, count: EdgeCount) -> dict[str, Any]:
    return {
        "from": f"{edge.from_stage}.{edge.from_port}",
        "to": f"{edge.to_stage}.{edge.to_port}",
        "kind": edge.kind,
        **{name: getattr(count, name) for name in (*COUNTS, *SOURCE_LOSSES)},
    }


def _clock_data(host: str, clock: ClockStatus) -> dict[str, Any]:
    return {
        "host": host,
        "reference": clock.reference,
        "offset_ms": clock.offset_ms,
        "round_trip_ms": clock.round_trip_ms,
        "exchanges": clock.exchanges,
    }


def _clocks(report: RunReport) -> str:
    rows = [
        (host or "this host", clock.reference, f"{clock.offset_ms:+.3f}", f"{clock.round_trip_ms:.3f}")
        for host, clock in report.clocks.items()
    ]
    return table(("host", "by the clock of", "offset ms", "round trip ms"), rows)


def _latency(report: RunReport) -> str:
    paths = [path for worker in report.workers for path in worker.paths]
    budgets = any(path.budget_ms is not None for path in paths)
    rows = [
        (
            f"{path.origin} -> {path.sink}",
            str(path.count),
            f"{path.p50_ms:.2f}",
            f"{path.p95_ms:.2f}",
            f"{path.worst_ms:.2f}",
            path.worst_id,
            *(_kept(path) if budgets else ()),
        )
        for path in paths
    ]
    head = ("path", "messages", "p50 ms", "p95 ms", "worst ms", "worst frame")
    return table((*head, *(("budget ms", "late") if budgets else ())), rows)


def _kept(path: PathLatency) -> tuple[str, str]:
    """Budget, and how many messages were late; "" for none."""
    return ("", "") if path.budget_ms is None else (f"{path.budget_ms:g}", str(path.late))


def _lost_at_source(report: RunReport) -> str:
    """A row for each source whose device lost frames; "" if none did. Every edge of a port says the same."""
    lost: dict[str, tuple[str, ...]] = {}
    for edge, count in report.edges:
        found = tuple(getattr(count, name) for name in SOURCE_LOSSES)
        if any(found):
            lost[edge.from_stage] = tuple(map(str, found))
    rows = [(name, *found) for name, found in lost.items()]
    return table(("source", *(name.replace("_", " ") for name in SOURCE_LOSSES)), rows) if rows else ""


def _ledger(report: RunReport) -> str:
    """A row for each group of edges that differ in the camera only, with their sums."""
    groups: dict[tuple[str, str], list[EdgeCount]] = {}
    group = {stage.name: stage.group for stage in report.plan.stages}
    for edge, count in report.edges:
        name = f"{group.get(edge.from_stage, edge.from_stage)}.{edge.from_port} -> "
        name += f"{group.get(edge.to_stage, edge.to_stage)}.{edge.to_port}"
        groups.setdefault((name, edge.kind), []).append(count)
    rows = [
        (name, kind, str(len(counts)), *(str(sum(getattr(c, column) for c in counts)) for column in COUNTS))
        for (name, kind), counts in groups.items()
    ]
    return table(("edges", "kind", "n", *(name.replace("_", " ") for name in COUNTS)), rows)
