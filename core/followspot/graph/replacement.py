"""Checks whether one plugin stage can replace another in a running graph: ports, kind, cameras."""

from __future__ import annotations

from collections.abc import Iterator

from followspot.graph.plan import Plan, PlannedStage
from followspot.ports import Ports, accepts, ports
from followspot.stage import Stage

Misfit = tuple[str, str]
"""What does not fit, and the remedy."""


def misfits(old: PlannedStage, present: type[Stage], stage: type[Stage], plan: Plan) -> list[Misfit]:
    """Every reason why `stage` cannot replace `present` as the instance `old` of a plan; empty if it can.

    Edges do not change, so connected ports must keep their names, types and kinds.
    """
    before, after = ports(present), ports(stage)
    if before.source and not present.live:
        return [(f'source "{old.name}" would begin its stream anew', "only live sources can be changed")]
    if before.source != after.source or present.live != stage.live:
        text = f'{stage.__name__} cannot take the place of stage "{old.name}"'
        return [(text, "a live source takes the place of a live source, another stage that of another")]
    found = [*_inputs(old, before, after, plan), *_outputs(old, before, after, plan)]
    if stage.per_camera and old.camera is None:
        found.append((f'{stage.__name__} serves one camera, and stage "{old.name}" has no each', ""))
    return found


def _inputs(old: PlannedStage, before: Ports, after: Ports, plan: Plan) -> Iterator[Misfit]:
    fed = {edge.to_port for edge in plan.edges if edge.to_stage == old.name}
    for port in before.inputs:
        new = after.input(port.name)
        if port.name not in fed:
            continue
        if new is None:
            have = ", ".join(p.name for p in after.inputs)
            yield f'the replacement of "{old.name}" has no input "{port.name}"', f"its inputs: {have}"
        elif new.kind != port.kind or not accepts(new.type, port.type):
            yield (
                f'input "{port.name}" of "{old.name}" is {port.kind} {port.type.__name__}, '
                f"that of its replacement {new.kind} {new.type.__name__}",
                "",
            )
    for new in after.inputs:
        if new.required and new.name not in fed:
            yield (
                f'the replacement of "{old.name}" needs the input "{new.name}"',
                "nothing feeds it here",
            )


def _outputs(old: PlannedStage, before: Ports, after: Ports, plan: Plan) -> Iterator[Misfit]:
    read = {edge.from_port for edge in plan.edges if edge.from_stage == old.name}
    for port in before.outputs:
        new = after.output(port.name)
        if port.name in read and (new is None or new.type is not port.type):
            gives = ", ".join(f"{p.name} ({p.type.__name__})" for p in after.outputs) or "nothing"
            yield (
                f'"{old.name}.{port.name}" gives {port.type.__name__} to others, its replacement does not',
                f"it gives {gives}",
            )
