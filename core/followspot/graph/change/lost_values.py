"""Values that `--set` or a change gave, and that no stage has after a change."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from followspot.graph.plan import Plan, PlannedStage


def lost_values(old: Plan, new: Plan) -> dict[str, dict[str, Any]]:
    """The values by instance of the old plan and by parameter.

    A stage of the same name has taken a parameter over if it has one of that name; an interface has, if the
    value is now in the stages behind its parameter.
    """
    after = {stage.name: stage for stage in new.stages}
    found = {
        stage.name: {
            name: stage.params[name]
            for name in stage.kept
            if not (stage.name in after and name in after[stage.name].params)
            and not _is_passed_on(stage, name, old, new)
        }
        for stage in old.stages
    }
    return {stage: values for stage, values in found.items() if values}


def _is_passed_on(stage: PlannedStage, parameter: str, old: Plan, new: Plan) -> bool:
    """Whether a parameter of a sub-graph has brought the value of a stage to other stages."""
    leaf = f"{stage.group}.{parameter}"
    value = stage.params[parameter]
    return any(
        value in _values(new, use.name, name)
        for use in old.subgraphs
        for name, leaves in use.params.items()
        if leaf in leaves
    )


def _values(plan: Plan, subgraph: str, name: str) -> Iterator[Any]:
    """The values that the stages behind a parameter of a sub-graph keep."""
    for use in plan.subgraphs:
        for leaf in use.params.get(name, ()) if use.name == subgraph else ():
            group, _, parameter = leaf.rpartition(".")
            yield from (s.params[parameter] for s in plan.stages if s.group == group and parameter in s.kept)
