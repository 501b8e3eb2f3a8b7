"""Messages that joins did not use, because their partners never came or came too late."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from followspot.graph.plan import Plan, PlannedEdge, PlannedStage
from followspot.operator.reporting.scored import class_of
from followspot.ports.signature import ports
from followspot.worker.ledger import EdgeCount

FEWEST, SHARE = 5, 0.02
"""Messages of an edge, and share of all that were sent, from which a user is told: at the ends of streams
some always lack a partner."""


def unused_messages(plan: Plan, edges: Sequence[tuple[PlannedEdge, EdgeCount]]) -> tuple[str, ...]:
    """A line for each group of edges of which joins did not use many messages. Those that a live run drops by
    its policy are not among them.
    """
    stages = {stage.name: stage for stage in plan.stages}
    group = {name: stage.group for name, stage in stages.items()}
    counts: dict[tuple[str, bool], list[EdgeCount]] = defaultdict(list)
    for edge, count in edges:
        ends = group.get(edge.from_stage, edge.from_stage), group.get(edge.to_stage, edge.to_stage)
        name = f"{ends[0]}.{edge.from_port} -> {ends[1]}.{edge.to_port}"
        counts[name, _is_window(stages.get(edge.to_stage), edge.to_port)].append(count)
    return tuple(line for (name, window), found in counts.items() for line in _lines(name, window, found))


def _is_window(reader: PlannedStage | None, port: str) -> bool:
    """Whether an input takes all that came since the last firing; such a one needs no partner."""
    kind = class_of(reader) if reader is not None else None
    found = ports(kind).input(port) if kind is not None else None
    return found is not None and found.kind == "window"


def _lines(name: str, window: bool, counts: Sequence[EdgeCount]) -> list[str]:
    sent = sum(count.sent for count in counts)
    unmatched, late = (sum(getattr(count, kind) for count in counts) for kind in ("unmatched", "late"))
    lines = []
    if _many(unmatched, sent):
        remedy = "raise tolerance, or give each sender a reader of its own"
        no_partner = f"found no partner and were not used: {remedy}"
        why = "came after the last firing of their reader and were not used" if window else no_partner
        lines.append(f"{name}: {unmatched} of {sent} messages {why}")
    if _many(late, sent):
        remedy = "raise deadline, or check the clocks of the senders"
        lines.append(f"{name}: {late} of {sent} messages came too late for their join: {remedy}")
    return lines


def _many(count: int, sent: int) -> bool:
    return count >= FEWEST and count > SHARE * sent
