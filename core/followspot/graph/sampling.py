"""Sampled inputs (`Latest`) in cycles without a delay: the message that such an input gets depends on timing.

Its sender waits for its reader's result, so the reader cannot wait until the newest message is known.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from followspot.errors import Mistake, Place
from followspot.graph.cycles import components, cycle_through, cyclic, successors
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports

_MOST_NAMED = 20
"""Cycles that are searched for and named; the time to find one grows with the graph."""


@dataclass(frozen=True)
class FlowEdge:
    """An edge between stages or their instances; origin: STAGE or STAGE.PORT as the file names it."""

    start: str
    origin: str
    end: str
    port: str
    delay: int
    sampled: bool
    policy: str = "block"
    place: Place | None = None


def sampled_cycles(edges: Iterable[FlowEdge]) -> list[Mistake]:
    """One mistake for each sampled input in a cycle without a delay, at the place of its edge."""
    undelayed = [edge for edge in edges if not edge.delay]
    ends = [(edge.start, edge.end) for edge in undelayed]
    circular = cyclic(ends)
    found = list(dict.fromkeys(x for x in undelayed if x.sampled and (x.start, x.end) in circular))
    graph = successors(dict.fromkeys(name for pair in ends for name in pair), ends)
    component = components(graph)
    mistakes = [
        _mistake(edge, cycle_through(graph, edge.start, edge.end, component)) for edge in found[:_MOST_NAMED]
    ]
    if len(found) > _MOST_NAMED:
        text = f"{len(found) - _MOST_NAMED} more inputs are sampled in cycles without a delay"
        mistakes.append(Mistake(found[_MOST_NAMED].place, text, "delay them too"))
    return mistakes


def plan_sampled_cycles(plan: Plan) -> list[Mistake]:
    """The mistakes of sampled inputs among the instances of a plan; they have no place."""
    group = {stage.name: stage.group for stage in plan.stages}
    known = {stage.name: ports(load_stage(stage.uses)) for stage in plan.stages}
    edges = [
        FlowEdge(
            edge.from_stage,
            f"{group[edge.from_stage]}.{edge.from_port}",
            edge.to_stage,
            edge.to_port,
            edge.delay,
            (port := known[edge.to_stage].input(edge.to_port)) is not None and port.kind == "latest",
            edge.policy,
        )
        for edge in plan.edges
    ]
    return sampled_cycles(edges)


def _mistake(edge: FlowEdge, cycle: Sequence[str]) -> Mistake:
    text = (
        f'the result depends on timing: input "{edge.port}" of stage "{edge.end}" samples "{edge.origin}" '
        f"in the cycle {' -> '.join(cycle)}, which has no delay"
    )
    without = "" if edge.policy == "block" else f" without policy: {edge.policy}"
    return Mistake(edge.place, text, f"delay it: {{from: {edge.origin}, delay: 1}}{without}")
