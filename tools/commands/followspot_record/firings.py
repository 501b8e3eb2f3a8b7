"""Types and facts of recorded firings of stages, by which `verify` repeats a live run or a part of one."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from followspot import Message, Stage
from followspot.graph.plan import Plan
from followspot.plugins.registry import load_stage
from followspot.ports.firing import Firing, firings_of
from followspot.ports.signature import ports

MOMENT = "moment"
"""The fact in a recording that it begins in the middle of a run."""
WITHOUT_STATE = "without_state"
"""The fact that names the stages whose memory, if they have one, is not in the recording."""


def firing_types(plan: Plan, kept: Collection[str]) -> dict[str, type[Message]]:
    """The firings of the stages that send to these ports, STAGE.PORT; sources have none."""
    fed = {edge.to_stage for edge in plan.edges}
    senders = dict.fromkeys(port.rpartition(".")[0] for port in kept)
    return {firings_of(stage): Firing for stage in senders if stage in fed}


def facts_of_middle(plan: Plan) -> dict[str, str]:
    """The facts of a recording that begins in the middle of a run."""
    return {MOMENT: "true", **facts_of_firings(plan)}


def facts_of_firings(plan: Plan) -> dict[str, str]:
    """The facts of a recording that has the firings of stages."""
    return {WITHOUT_STATE: ", ".join(_without_state(plan))}


def _without_state(plan: Plan) -> Iterator[str]:
    """The stages that have inputs and outputs and no `state`, each once."""
    found = {stage.group: load_stage(stage.uses) for stage in plan.stages}
    for group, kind in found.items():
        if ports(kind).inputs and ports(kind).outputs and kind.state is Stage.state:
            yield group
