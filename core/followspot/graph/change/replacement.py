"""Checks whether one plugin stage can replace another in a running graph: ports, kind, cameras."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator

from followspot.graph.plan import Plan, PlannedStage
from followspot.messages import Message
from followspot.plugins.registry import load_stage
from followspot.ports.signature import ports
from followspot.ports.specs import InputSpec, Ports, accepts
from followspot.room import SETS
from followspot.stage import Stage

Misfit = tuple[str, str]
"""A reason why the stage does not fit, and the remedy."""


def mismatches(old: PlannedStage, present: type[Stage], stage: type[Stage], plan: Plan) -> list[Misfit]:
    """Every reason why `stage` cannot replace `present` as the instance `old` of a plan; empty if it can.

    Edges do not change, so connected ports must keep their names, types and kinds.
    """
    before, after = ports(present), ports(stage)
    if before.source and not present.live:
        return [(f'source "{old.name}" would begin its stream anew', "only live sources can be changed")]
    if before.source != after.source or present.live != stage.live:
        text = f'{stage.__name__} cannot take the place of stage "{old.name}"'
        return [(text, "a live source takes the place of a live source, another stage that of another")]
    if before.gives != after.gives:
        text = f'{stage.__name__} gives messages in another way than stage "{old.name}"'
        return [(text, "Outputs, Deferred and Lagged take the place of their like")]
    found = [*_inputs(old, before, after, plan), *_outputs(old, before, after, plan)]
    served = stage.serves()
    if served and (old.member is None or old.member.set != served):
        found.append((f'{stage.__name__} serves one {SETS[served]}, and stage "{old.name}" serves none', ""))
    return found


def _inputs(old: PlannedStage, before: Ports, after: Ports, plan: Plan) -> Iterator[Misfit]:
    """Reasons why the inputs do not fit."""
    fed = _fed(old, plan)
    one_each = len(before.inputs) == len(after.inputs) == 1
    for name, types in fed.items():
        port, new = before.input(name), after.input(name)
        if port is None or new is None or not (one_each or new.name == port.name):
            have = ", ".join(p.name for p in after.inputs)
            yield f'the replacement of "{old.name}" has no input "{name}"', f"its inputs: {have}"
        elif not (_like(port, new, len(types)) and all(accepts(new.type, each) for each in types)):
            given = " and ".join(sorted({each.__name__ for each in types}))
            yield (
                f'input "{name}" of "{old.name}" is {port.kind} {given}, '
                f"that of its replacement {new.kind} {new.type.__name__}",
                "",
            )
    met = {port.name for name in fed if (port := after.input(name)) is not None}
    for new in after.inputs:
        if new.required and new.name not in met:
            yield (
                f'the replacement of "{old.name}" needs the input "{new.name}"',
                "nothing feeds it here",
            )


def _fed(old: PlannedStage, plan: Plan) -> dict[str, list[type[Message]]]:
    """Types of the messages that edges bring to each input, by its name in the graph."""
    uses = {stage.name: stage.uses for stage in plan.stages}
    fed: dict[str, list[type[Message]]] = defaultdict(list)
    for edge in plan.edges:
        if edge.to_stage == old.name:
            sent = ports(load_stage(uses[edge.from_stage])).output(edge.from_port)
            fed[edge.to_port] += [] if sent is None else [sent.type]
    return fed


def _like(port: InputSpec, new: InputSpec, edges: int) -> bool:
    """True if the inputs take messages alike; with one edge, `Joined` takes the same as a plain input."""
    return port.kind == new.kind or (edges == 1 and {port.kind, new.kind} == {"plain", "joined"})


def _outputs(old: PlannedStage, before: Ports, after: Ports, plan: Plan) -> Iterator[Misfit]:
    """Reasons why the outputs that others read do not fit."""
    read = {edge.from_port for edge in plan.edges if edge.from_stage == old.name}
    for port in before.outputs:
        new = after.output(port.name)
        if port.name in read and (new is None or new.type is not port.type):
            gives = ", ".join(f"{p.name} ({p.type.__name__})" for p in after.outputs) or "nothing"
            yield (
                f'"{old.name}.{port.name}" gives {port.type.__name__} to others, its replacement does not',
                f"it gives {gives}",
            )
